"""``fingerdesign identify DESIGN BENCH``: a finger's own curves and hidden values."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.control.bench_curves import Kind, Phase, bench_curves
from fingerdesign.control.bench_table import TABLE, read_bench, table_text
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.signals import Calibration
from fingerdesign.design.io import dump_design
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.rows import plate_frames
from fingerdesign.records.base import Count, Size, closed, json_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.identify.bench import SimulatedBench
from fingerdesign.sensing.identify.bench_fit import LatentFit, Measured, Noise, fit_latents
from fingerdesign.sensing.identify.joined_curves import joined_calibration
from fingerdesign.sensing.identify.latents import AXES, TOLERANCE
from fingerdesign.sensing.model import gripped_case
from fingerdesign.version import versions

RECORD_FILE, ESTIMATOR_FILE, FITTED_FILE = "calibration.json", "estimator.json", "fitted.toml"
DRAWN_FILE = "drawn.toml"
CALIBRATION = RecordFolder("calibration", RECORD_FILE, (RECORD_FILE, ESTIMATOR_FILE, FITTED_FILE))
MEASURED = RecordFolder("measured finger", TABLE, ("*.csv", DRAWN_FILE))
_DETERMINED = 0.5  # A value is determined if the fit leaves less than this of its deviation.
_SURELY = 2.0  # A plate is off its tolerance if it is beyond it by so many deviations.
_BEYOND_MM = 0.02  # An early touch may lengthen the stage's travel by this much.
_SHORT = 0.95  # A press should reach this fraction of the stage's travel.
_FRICTION_OFF = 0.05  # The slide may differ from the stated friction by this fraction.
_MISFIT = 4.0  # A misfit of twice the deviations of noise and mesh, in squares.
_ODD_GAGE = 5.0  # A gage's residual is odd above so many times the median one.
_AXIS_WORDS = {"x": "mm off along x", "y": "mm off along y", "angle": "degrees off in angle"}


@closed
@dataclass(frozen=True)
class PhaseData:
    """A row of the bench's table; points: the number of rests in its trace."""

    trace: str
    phase: Kind
    friction_coefficient: Size
    tilt_deg: float
    samples: Size
    points: Count


@closed
@dataclass(frozen=True)
class CurvesData:
    """The finger by F_n: under it alone (c), and sheared a little where all sticks (k); measured
    and, as far as these are noisy or end, of the fitted model."""

    normal_force_N: tuple[float, ...]
    approach_mm: tuple[float, ...]
    pressed_microstrain: tuple[tuple[float, ...], ...]
    sheared_force_N: tuple[float, ...]
    sticking_microstrain_per_N: tuple[tuple[float, ...], ...]
    stiffness_N_per_mm: tuple[float, ...]


@closed
@dataclass(frozen=True)
class LatentData:
    """A hidden value, as its difference from the design's: plate_K of the design's plates from 0,
    gage_K of the trace's from 1. determined: the fit has halved its standard deviation at least."""

    name: str
    unit: str
    deviation_before: Size
    value: float
    deviation: Size
    determined: bool


@closed
@dataclass(frozen=True)
class FitData:
    """RMS of readings less the model's, by design and by the fitted finger; misfit: residuals over
    what noise and mesh explain, in squares."""

    before_microstrain: Size
    after_microstrain: Size
    gages_after_microstrain: tuple[float, ...]
    misfit: Size


@closed
@dataclass(frozen=True)
class CalibrationData:
    """The content of calibration.json; trained_on: key of the estimator's design, null without one;
    slid_ratio: F_t / F_n at the end of the slide; force_cross_talk: F_t that is measured per newton
    of F_n, 0 where it was not slid to both sides."""

    design: str
    digest: str
    fidelity: Literal["plane-strain", "3d"]
    trained_on: str | None
    noise_microstrain: Size
    force_noise_N: Size
    phases: tuple[PhaseData, ...]
    curves: CurvesData
    delay_samples: Count
    slid_ratio: float | None
    force_cross_talk: float
    dead_gages: tuple[int, ...]
    latents: tuple[LatentData, ...]
    fit: FitData
    warnings: tuple[str, ...]
    versions: dict[str, str]


@dataclass(frozen=True)
class CalibratedFinger:
    """The result of a bench. estimator: with this finger's curves, None where none was given."""

    data: CalibrationData
    fit: LatentFit
    estimator: GripEstimator | None


def calibrated_finger(
    design: Design,
    source: Path,
    estimator: GripEstimator | None = None,
    fidelity: str = "plane-strain",
    report: Report = lambda message: None,
) -> CalibratedFinger:
    """Read a bench's traces, derive the finger's curves, fit its hidden values.

    Raises DesignError, before any work, with every fault of the table or of the traces, and where
    the design cannot be gripped with; SolverError where its model has no answer.
    """
    gripped_case(design, fidelity)
    plates = gage_array(design)
    phases = read_bench(source, len(plates))
    _refuse_beyond(design, phases, source)
    frames = plate_frames(design)
    curves = bench_curves(phases, np.array([frames[plate].x for plate in plates]))
    hardware = design.rig.hardware
    gage = hardware.gage_noise_microstrain if estimator is None else estimator.noise
    noise = Noise(gage, hardware.force_noise_N)
    measured = Measured(design, phases, curves, noise, fidelity)
    fit = fit_latents(measured, report)
    report("joining the curves")
    known, trained_on = joined_calibration(measured, fit), None
    if estimator is not None:
        trained_on, estimator = estimator.design, estimator.on_rig(known)
    return CalibratedFinger(_data(measured, known, fit, trained_on), fit, estimator)


def _refuse_beyond(design: Design, phases: Sequence[Phase], source: Path) -> None:
    """DesignError where the bench pressed farther than the design's stage goes."""
    most = design.grip.max_approach_mm
    faults = [
        Fault(
            f"{each.name}, column dy_mm",
            f"{each.points.approach.max():g} mm in all",
            f"at most grip.max_approach_mm = {most:g}",
            "cut the trace there, or raise it and train again",
        )
        for each in phases
        if each.points.approach.max() > most + _BEYOND_MM
    ]
    if faults:
        raise DesignError(faults, str(source))


def _data(
    measured: Measured, own: Calibration, fit: LatentFit, trained_on: str | None
) -> CalibrationData:
    design, noise = measured.design, measured.noise
    return CalibrationData(
        design=design.design.name,
        digest=design.digest(),
        fidelity="3d" if measured.fidelity == "3d" else "plane-strain",
        trained_on=trained_on,
        noise_microstrain=noise.gage,
        force_noise_N=noise.force,
        phases=tuple(
            PhaseData(
                *(p.name, p.kind, p.friction_coefficient, p.tilt_deg, p.samples),
                len(p.points.approach),
            )
            for p in measured.phases
        ),
        curves=CurvesData(
            normal_force_N=tuple(own.normal.normal_force.tolist()),
            approach_mm=tuple(own.approach.tolist()),
            pressed_microstrain=tuple(map(tuple, own.normal.readings.tolist())),
            sheared_force_N=tuple(own.sticking.normal_force.tolist()),
            sticking_microstrain_per_N=tuple(map(tuple, own.sticking.readings.tolist())),
            stiffness_N_per_mm=tuple(own.stiffness.tolist()),
        ),
        delay_samples=own.delay,
        slid_ratio=measured.curves.slid,
        force_cross_talk=own.cross_talk,
        dead_gages=fit.dead,
        latents=tuple(
            LatentData(
                *(each.name, each.unit, each.deviation, float(value), float(deviation)),
                bool(deviation < _DETERMINED * each.deviation),
            )
            for each, value, deviation in zip(fit.latents, fit.values, fit.deviations, strict=True)
        ),
        fit=FitData(fit.before, fit.after, tuple(fit.gages_after.tolist()), fit.misfit),
        warnings=(*_plate_warnings(fit), *_gage_warnings(fit), *_bench_warnings(measured)),
        versions=versions(),
    )


def _plate_warnings(fit: LatentFit) -> Iterator[str]:
    for latent, value, deviation in zip(fit.latents, fit.values, fit.deviations, strict=True):
        most = TOLERANCE.get(latent.kind, np.inf)
        if latent.kind in AXES and abs(value) - _SURELY * deviation > most:
            words = f"{value:+.3g} ± {deviation:.2g} {_AXIS_WORDS[latent.kind]}"
            yield f"plate {latent.number} lies {words}: more than the tolerance of {most:g}"


def _gage_warnings(fit: LatentFit) -> Iterator[str]:
    for gage in fit.dead:
        yield f"gage_{gage} has no response: it is left out of the fit and of grips"
    alive = [k for k in range(len(fit.gages_after)) if k + 1 not in fit.dead]
    usual = float(np.median(fit.gages_after[alive])) if alive else 0.0
    for k in alive:
        if fit.gages_after[k] > _ODD_GAGE * max(usual, 1.0):
            left = f"{fit.gages_after[k]:.3g} microstrain off, others {usual:.2g}"
            yield f"gage_{k + 1} does not fit the finger ({left}): is it wired as its number says?"
    if fit.misfit > _MISFIT:
        yield (
            f"the model leaves {fit.after:.3g} microstrain, {fit.misfit**0.5:.1f} times what noise "
            "and mesh explain: deviations are widened by as much, and values may be off by more"
        )


def _bench_warnings(measured: Measured) -> Iterator[str]:
    phases, slid = measured.phases, measured.curves.slid
    reached = max(float(p.points.approach.max()) for p in phases if p.kind == "press")
    most = measured.design.grip.max_approach_mm
    if reached < _SHORT * most:
        yield f"pressed to {reached:g} of {most:g} mm: beyond it curves are the fitted model's"
    stated = {p.friction_coefficient for p in phases if p.kind == "slide"}
    for friction in stated:
        if slid is not None and abs(slid / friction - 1.0) > _FRICTION_OFF:
            words = f"slides at F_t / F_n = {slid:.3g}, its stated friction is"
            yield f"the bench {words} {friction:g}: check both force cells, and the surface"
    if not any(p.kind == "quick" for p in phases):
        yield "no quick press was recorded: the delay is taken for 0"


def write_calibration(found: CalibratedFinger, folder: Path) -> None:
    """The record, the fitted design and, where there is one, the estimator into a folder."""
    (folder / RECORD_FILE).write_text(json_text(found.data, indent=1), encoding="utf-8")
    (folder / FITTED_FILE).write_text(dump_design(found.fit.design), encoding="utf-8")
    if found.estimator is not None:
        (folder / ESTIMATOR_FILE).write_text(found.estimator.to_json(), encoding="utf-8")


def write_measured(bench: SimulatedBench, folder: Path) -> None:
    """The table and the traces of a simulated bench, and the finger that was drawn."""
    (folder / TABLE).write_text(table_text(bench.phases), encoding="utf-8")
    for phase in bench.phases:
        assert phase.trace is not None
        (folder / phase.name).write_text(phase.trace.to_csv(), encoding="utf-8")
    (folder / DRAWN_FILE).write_text(dump_design(bench.design), encoding="utf-8")
