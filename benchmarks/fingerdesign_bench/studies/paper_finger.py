"""Which finger did the paper use? A stated, repeatable search for what it does not say.

Maeno, Hiromitsu and Kawai 2000 give the plates' number, thickness and angle and both moduli, no
other dimension. Sobol points over those dimensions (paper_space.py) are analysed in plane strain,
and the finger is chosen on which the paper's claim holds best: that the gage area follows the stick
area, whatever the friction (its section 3.1).

Score of a candidate: the worst rank correlation of the compensated gage area with the true stick
area, over FRICTIONS, over thresholds 10 % below and above half of the design's own largest
full-stick response, and over two scenes: the fundamental one, and one whose approach grows to the
end (up to complete slip), as it does in a grip. Every row is cut into PIECES. A finger that only
works at one threshold, friction or path thus scores low. Scores equal to 0.05 are ties: the larger
signal wins, then the contact that spans more plates at a small force.

The depth is left at 10 mm: in plane strain it multiplies forces and divides responses, no more.

What holds in plane strain need not in 3-D. There the in-plane strains of rubber do not add up to
zero, so that the finger's bending strains plates at 45 degrees too, with one sign left of the
middle and the other right of it: the response is lopsided, and on a coarse extruded mesh of the
shipped finger the eight steps correlate by 0.86 for friction from 0.5 on, by 0.3 and less below.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.analysis.slip_study import (
    gage_areas,
    rank_correlation,
    slip_studies,
)
from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.checks.starter import shipped_text
from fingerdesign.contact.measures import COMPLETE_SLIP
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.design.gages import AREA_SHARE
from fingerdesign.errors import DesignError, FingerDesignError, SolverError
from fingerdesign.layout.frames import crest_height
from fingerdesign.layout.zone import contact_half_width, summarise
from fingerdesign.shapes.objects import Plane
from fingerdesign_bench.paper.case import GROWING_SHARE

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.records.arrays import SlipStudy


# The dimensions that the paper does not give, sampled: candidates for its finger.

# name -> (least, most, step), mm but for the gage's share of its plate. The skin is the rubber over
# the plate's upper corner at the crest, the approach that of the fundamental scene.
SPACE = {
    "arc_radius": (30.0, 60.0, 2.0),
    "width": (18.0, 24.0, 2.0),
    "base_height": (4.0, 12.0, 1.0),
    "plate_length": (0.6, 1.6, 0.1),
    "skin": (0.3, 0.9, 0.05),
    "pitch": (0.6, 1.1, 0.05),
    "gage_share": (0.3, 0.8, 0.05),
    "approach": (0.08, 0.2, 0.02),
}

# What the mold asks for.
LEAST_COVER_MM = 0.3  # over the plates' upper corners: a skin that survives the mold's opening
LEAST_GAP_MM = 0.25  # between plates: silicone must flow in without bubbles

_COARSE = {
    "mesh.section.contact_size_mm": 0.1,
    "mesh.section.plate_size_mm": 0.2,
    "mesh.section.plate_end_size_mm": 0.05,
    "mesh.section.far_size_mm": 2.0,
    "mesh.section.gradation": 0.5,
}


@dataclass(frozen=True)
class Candidate:
    """One point of SPACE: the design's dotted keys and the approach of its fundamental scene, mm.

    ``refused`` says why it was not analysed to the end; empty where nothing speaks against it.
    """

    number: int
    values: dict[str, float]
    approach: float
    refused: str = ""


def candidates(count: int, seed: int) -> list[Candidate]:
    """``count`` Sobol points of SPACE, rounded to its steps; those that cannot be cast refused."""
    from scipy.stats import qmc

    power = int(np.ceil(np.log2(max(count, 1))))
    points = qmc.Sobol(len(SPACE), seed=seed).random_base2(power)[:count]
    found = []
    for number, point in enumerate(points):
        place = {
            name: least + step * round(share * (most - least) / step)
            for share, (name, (least, most, step)) in zip(point, SPACE.items(), strict=True)
        }
        found.append(_checked(_candidate(number, place)))
    return found


def design_of(candidate: Candidate, coarse: bool) -> Design:
    """The shipped paper finger with the candidate's dimensions. Raises DesignError."""
    design = parse_design(shipped_text("maeno2000"), "maeno2000")
    values: dict[str, object] = {**candidate.values}
    return with_values(design, {**values, **_COARSE} if coarse else values)


def _candidate(number: int, place: dict[str, float]) -> Candidate:
    """Rounded to what a drawing says."""
    length = place["plate_length"]
    # Half of a plate of 0.1 mm at 45 degrees, up to its upper corner.
    rise = 0.5 * (length + 0.1) / np.sqrt(2.0)
    values = {
        "body.arc_radius_mm": place["arc_radius"],
        "body.width_mm": place["width"],
        "body.base_height_mm": place["base_height"],
        "plates.length_mm": length,
        "plates.cover_mm": 0.05 * np.ceil((place["skin"] + rise) / 0.05),
        "plates.pitch_mm": place["pitch"],
        "gages.length_mm": max(0.3, 0.1 * round(place["gage_share"] * length / 0.1)),
    }
    rounded = {key: round(float(value), 6) for key, value in values.items()}
    return Candidate(number, rounded, round(place["approach"], 6))


def _checked(candidate: Candidate) -> Candidate:
    try:
        summary = summarise(design_of(candidate, coarse=True))
    except DesignError as error:
        return replace(candidate, refused="; ".join(fault.key for fault in error.faults))
    assert summary.least_surface_mm is not None
    assert summary.least_gap_mm is not None
    if summary.least_surface_mm < LEAST_COVER_MM:
        return replace(candidate, refused="cover too thin")
    if summary.least_gap_mm < LEAST_GAP_MM:
        return replace(candidate, refused="plates too close")
    return candidate


Rows = list[tuple[float, float]]

FRICTIONS = (0.2, 0.35, 0.5, 0.7, 1.0)
SCENE_FRICTION = 0.5
PIECES = 5
THRESHOLDS = (0.9, 1.0, 1.1)  # times AREA_SHARE

# The scene by shares of the largest approach and of the shear that just ends in complete slip: both
# grow to step three, then the approach is held; step eight is past complete slip, step seven short
# of it in 3-D too, where the shipped finger slips completely at 0.84 of the plane-strain shear.
APPROACH_SHARE = (0.4, 0.75, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
SHEAR_SHARE = (0.05, 0.12, 0.20, 0.32, 0.46, 0.61, 0.77, 1.12)

# What a finger must offer beside its score.
GRIP_FORCE_N = 5.0  # the paper's grips end near it (its Fig. 10)
LEAST_PITCHES = 4.0  # that the contact spans at GRIP_FORCE_N, or few gages see the stick region
MOST_FORCE_N = 15.0  # of the fundamental case: three times that of the grips


@dataclass(frozen=True)
class Analysed:
    """A candidate's fundamental case. Correlations are by FRICTIONS, compensated unless raw.

    rows          the scene: cumulative (approach, shear), mm
    score         the worst correlation (see the module); -1 where one is undefined
    fine, fine_raw, steps, steps_raw  at the threshold itself: rows cut finer, and the eight steps
    growing       the same, rows cut finer, where the approach grows to the end
    threshold, signal  microstrain/N; signal is the largest full-stick response
    normal_force  N, the largest; pitches: contact width at GRIP_FORCE_N over the plates' pitch
    slips_at_the_end  complete slip at the eighth step and not before, at every friction
    """

    candidate: Candidate
    rows: Rows
    score: float
    fine: tuple[float, ...]
    fine_raw: tuple[float, ...]
    steps: tuple[float, ...]
    steps_raw: tuple[float, ...]
    growing: tuple[float, ...]
    threshold: float
    signal: float
    normal_force: float
    pitches: float
    slips_at_the_end: bool
    studies: tuple[SlipStudy, ...] = field(default=(), repr=False)

    @property
    def order(self) -> tuple[float, float, float]:
        """Greater is better: score to 0.05 (meshes agree to half of that), signal, pitches."""
        return (round(20.0 * self.score) / 20.0, round(self.signal, 2), self.pitches)


def analyse_candidate(candidate: Candidate, coarse: bool = True) -> Candidate | Analysed:
    """The candidate's fundamental case, or the candidate with the reason why there is none."""
    if candidate.refused:
        return candidate
    try:
        return _find(candidate, coarse)
    except FingerDesignError as error:
        return replace(candidate, refused=f"{type(error).__name__}: {error}")


def scene_rows(approach: float, slip_shear: float, growing: bool = False) -> Rows:
    """Rows (approach, shear), to 1 um: the fundamental scene, or the one that is never held."""
    approaches = GROWING_SHARE if growing else APPROACH_SHARE
    return [
        (round(a * approach, 3), round(s * slip_shear, 3))
        for a, s in zip(approaches, SHEAR_SHARE, strict=True)
    ]


def complete_slip_shear(problem: ContactProblem, approach: float) -> float:
    """Least shear (mm, to 3 % of the approach) with complete slip at a held ``approach``.

    Raises SolverError where four times the approach is not enough.
    """
    press = [Motion(approach * k / 4, 0.0) for k in range(1, 5)]
    shears = [Motion(approach, approach * k / 30) for k in range(1, 121)]
    for step in follow(problem, press + shears):
        if step.increment.motion.shear > 0.0 and _slips(step.measures.stick_ratio):
            return float(step.increment.motion.shear)
    raise SolverError(f"no complete slip within a shear of {4 * approach:g} mm")


def best(findings: list[Analysed], count: int) -> list[Analysed]:
    """The ``count`` best findings whose scene ends as it should, best first."""
    sound = [finding for finding in findings if finding.slips_at_the_end]
    return sorted(sound, key=lambda finding: finding.order, reverse=True)[:count]


def build_problem(design: Design, approach: float) -> ContactProblem:
    """The design in plane strain, facing a plane with the scene's friction."""
    from fingerdesign.fem.model import build_model
    from fingerdesign.mesh.section.section import mesh_section

    # Shear drags the contact along; the forecast of its width is good to 15 %.
    zone = min(2.0 * contact_half_width(design, approach) + 1.0, 0.5 * design.body.width_mm)
    model = build_model(design, mesh_section(design, zone), zone)
    return contact_problem(model.reduced, Plane(crest_height(design.body)), SCENE_FRICTION)


def _find(candidate: Candidate, coarse: bool) -> Candidate | Analysed:
    approach = candidate.approach
    design = design_of(candidate, coarse)
    problem = build_problem(design, approach)
    face = design.gages.face
    force, width = _pressed(problem, approach)
    pitches = width / design.plates.pitch_mm
    if force > MOST_FORCE_N:
        return replace(candidate, refused="pressed too hard")
    if pitches < LEAST_PITCHES:
        return replace(candidate, refused="contact spans too few plates")
    slip_shear = complete_slip_shear(problem, approach)
    rows = scene_rows(approach, slip_shear)
    growing = scene_rows(approach, slip_shear, growing=True)
    steps = slip_studies(problem, rows, face, FRICTIONS)
    fine = slip_studies(problem, rows, face, FRICTIONS, PIECES)
    moving = [
        _before_slip(study) for study in slip_studies(problem, growing, face, FRICTIONS, PIECES)
    ]
    threshold = fine[0].threshold
    worst = [
        correlation_at(study, factor * threshold)
        for study in (*fine, *moving)
        for factor in THRESHOLDS
    ]
    return Analysed(
        candidate=candidate,
        rows=rows,
        score=min(map(_number, worst)),
        fine=tuple(_number(study.rank_correlation) for study in fine),
        fine_raw=tuple(_number(study.rank_correlation_raw) for study in fine),
        steps=tuple(_number(study.rank_correlation) for study in steps),
        steps_raw=tuple(_number(study.rank_correlation_raw) for study in steps),
        growing=tuple(_number(correlation_at(study, threshold)) for study in moving),
        threshold=threshold,
        signal=threshold / AREA_SHARE,
        normal_force=force,
        pitches=pitches,
        slips_at_the_end=all(
            _slips(study.stick_ratio[-1]) and not any(map(_slips, study.stick_ratio[:-1]))
            for study in steps
        ),
        studies=steps,
    )


def _before_slip(study: SlipStudy) -> SlipStudy:
    """The increments before complete slip: past it there is no stick area to follow."""
    end = next((k for k, ratio in enumerate(study.stick_ratio) if _slips(ratio)), None)
    kept = (
        "stick_ratio",
        "stick_length_mm",
        "gage_area_raw_mm",
        "gage_area_mm",
        "response_raw",
        "response",
        "tangential_force",
        "normal_force",
    )
    return replace(study, **{name: getattr(study, name)[:end] for name in kept})


def _pressed(problem: ContactProblem, approach: float) -> tuple[float, float]:
    """Normal force (N) of a pure ``approach``, and the contact width (mm) under GRIP_FORCE_N."""
    forces, widths = [0.0], [0.0]
    reached = 0.0
    for step in follow(problem, (Motion(approach * k / 10.0, 0.0) for k in range(1, 31))):
        forces.append(step.measures.normal_force)
        widths.append(step.measures.contact_width)
        if len(forces) == 11:
            reached = forces[-1]
        if len(forces) >= 11 and forces[-1] >= GRIP_FORCE_N:
            break
    return reached, float(np.interp(GRIP_FORCE_N, forces, widths))


def _slips(stick_ratio: float | None) -> bool:
    return stick_ratio is not None and stick_ratio < COMPLETE_SLIP[2]


def _number(correlation: float | None) -> float:
    """An area that never changes says nothing: as bad as one that does the opposite."""
    return -1.0 if correlation is None else correlation


def correlation_at(study: SlipStudy, threshold: float) -> float | None:
    """The compensated rank correlation that another threshold gives, with the stick length."""
    change = np.diff(study.tangential_force, prepend=0.0)
    floor = study.force_floor_N
    area = gage_areas(study.gage_x_mm, study.response, threshold, change, floor)
    used = np.logical_or.accumulate(np.abs(change) >= floor) & np.isfinite(study.stick_ratio)
    return rank_correlation(area[used], study.stick_length_mm[used])
