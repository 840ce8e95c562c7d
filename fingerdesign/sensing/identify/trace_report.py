"""The record of ``fingerdesign identify DESIGN TRACE``: values with their intervals, the next
motion that would narrow them, and the design with them."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.checks.load import with_values
from fingerdesign.design.schema import Design
from fingerdesign.records.base import Count, Size, closed
from fingerdesign.records.folder import RecordFolder
from fingerdesign.sensing.identify.trace_fit import Identified, TraceFit, time_doubts
from fingerdesign.sensing.identify.trace_path import TracePath
from fingerdesign.version import versions

RECORD_FILE, DESIGN_FILE, PAGE_FILE = "identification.json", "identified.toml", "identify.html"
IDENTIFICATION = RecordFolder("identification", RECORD_FILE, (RECORD_FILE, DESIGN_FILE, PAGE_FILE))
_TWO_SIDED = 1.96  # Half a 95 % interval, in standard deviations.
# A value is determined if half its interval is no wider: a fraction of the value; mm; a fraction of
# all forces (share); microstrain; a logarithm (time).
TARGET = {"modulus": 0.03, "friction": 0.05, "touch": 0.005, "share": 0.02, "time": 0.4}
TARGET |= {"exponent": 0.1}
TARGET |= {"gain": 0.03, "offset": 5.0, "drift": 0.5, "per_kelvin": 1.0}
_ROWS = 30  # Rows of a motion that is tried.
_LONGER = 3.0  # A further rest lasts so many times the longest one.
_DRIFTS = ("offset", "drift", "per_kelvin")
_UNITS = {"offset": "microstrain", "drift": "microstrain/s", "per_kelvin": "microstrain/K"}
_UNITS |= {"modulus": "MPa", "touch": "mm", "time": "s"}
Motion = Literal["press", "shear", "hold"]


@closed
@dataclass(frozen=True)
class ValueData:
    """A value with its standard deviation and 95 % interval; determined: the interval is narrow
    enough to use; gage_K of the trace's gages from 1. Deviations of modulus, friction and times are
    those of their logarithms times the value."""

    name: str
    kind: str
    unit: str
    value: float
    deviation: Size
    low: float
    high: float
    determined: bool

    def shown(self) -> tuple[str, str]:
        """The value and its interval, to the digits that the interval leaves."""
        half = 0.5 * (self.high - self.low)
        digits = int(np.clip(1 - np.floor(np.log10(max(half, 1e-9))), 0, 8))
        return f"{self.value:.{digits}f}", f"{self.low:.{digits}f} to {self.high:.{digits}f}"


@closed
@dataclass(frozen=True)
class NextMotion:
    """The motion that would most narrow the worst value: its words, the value, and the width of its
    interval over the target, now and then."""

    motion: Motion
    words: str
    of: str
    now: Size
    then: Size


@closed
@dataclass(frozen=True)
class IdentificationData:
    """The content of identification.json. modulus_given_MPa: the design's; noise of one sample of
    each channel; misfit: residuals over what the noise explains, in squares."""

    design: str
    digest: str
    trace: str
    fidelity: Literal["plane-strain", "3d"]
    rows: Count
    points: Count
    seconds: Size
    modulus_given_MPa: Size
    values: tuple[ValueData, ...]
    force_noise_N: tuple[float, ...]
    gage_noise_microstrain: tuple[float, ...]
    misfit: Size
    warnings: tuple[str, ...]
    next_motion: NextMotion | None
    versions: dict[str, str]


def identification(found: Identified, trace: str) -> IdentificationData:
    """The record of an identification from the trace of that name."""
    fit, design = found.fit, found.design
    values = tuple(_values(fit, design.material_of("body").youngs_modulus_MPa))
    noise = fit.model.noise
    return IdentificationData(
        design=found.given.design.name,
        digest=found.given.digest(),
        trace=trace,
        fidelity="3d" if found.fidelity == "3d" else "plane-strain",
        rows=len(found.trace),
        points=len(fit.model.path.time),
        seconds=float(found.trace.time[-1] - found.trace.time[0]),
        modulus_given_MPa=found.given.material_of("body").youngs_modulus_MPa,
        values=values,
        force_noise_N=tuple(noise[:2].tolist()),
        gage_noise_microstrain=tuple(noise[2:].tolist()),
        misfit=fit.misfit,
        warnings=(*_fit_warnings(fit), *_trace_warnings(found, values), *_law_warnings(found)),
        next_motion=next_motion(found, values),
        versions=versions(),
    )


def _values(fit: TraceFit, modulus: float) -> Iterator[ValueData]:
    count = len(fit.x)
    names = {"modulus": "youngs_modulus", "friction": "friction_coefficient"}
    for each, x, deviation in zip(fit.unknowns, fit.x, fit.deviations[:count], strict=True):
        scale = modulus if each.kind == "modulus" else 1.0
        scaled = scale if each.by_logarithm else None
        yield _value(names.get(each.name, each.name), each.kind, float(x), float(deviation), scaled)
    if fit.terms:
        yield _relaxed(fit, modulus)
    width = fit.linear.shape[1]
    own = fit.deviations[count:].reshape(-1, width)
    for gage, (row, deviations) in enumerate(zip(fit.linear, own, strict=True), 1):
        for kind, value, deviation in zip(("gain", *_DRIFTS), row, deviations, strict=False):
            yield _value(f"gage_{gage}.{kind}", kind, float(value), float(deviation))


def _value(
    name: str, kind: str, x: float, deviation: float, scale: float | None = None
) -> ValueData:
    """The value x or, with a scale, scale exp(x); the deviation is that of x."""
    half, unit = _TWO_SIDED * deviation, _UNITS.get(kind, "")
    value, low, high = x, x - half, x + half
    if scale is not None:
        value, low, high = (float(scale * np.exp(each)) for each in (value, low, high))
        deviation *= value
    return ValueData(name, kind, unit, value, deviation, low, high, half <= TARGET[kind])


def _relaxed(fit: TraceFit, modulus: float) -> ValueData:
    """The modulus of fully relaxed rubber: E (1 - sum g_i)."""
    shares = [k for k, each in enumerate(fit.unknowns) if each.kind == "share"]
    left = 1.0 - float(fit.x[shares].sum())
    slope = np.zeros(len(fit.deviations))
    slope[0], slope[shares] = 1.0, -1.0 / left
    deviation = float(np.sqrt(slope @ fit.covariance() @ slope))
    value = modulus * float(np.exp(fit.x[0])) * left
    return _value("relaxed_modulus", "modulus", 0.0, deviation, value)


def _fit_warnings(fit: TraceFit) -> Iterator[str]:
    if fit.misfit > 4.0:
        yield (
            f"the model leaves {fit.misfit**0.5:.1f} times what noise explains: intervals are "
            "widened by as much, and values may be off by more; is it this finger, and did it "
            "touch where the trace begins?"
        )
    for each, x in zip(fit.unknowns, fit.x, strict=True):
        near = 0.01 * (each.high - each.low)
        if each.kind not in ("share", "exponent") and (x - each.low < near or each.high - x < near):
            yield f"{each.name} is at the end of its range: do not use it"


def _trace_warnings(found: Identified, values: tuple[ValueData, ...]) -> Iterator[str]:
    yield from time_doubts(found.trace)
    for value in values:
        if value.kind == "gain" and value.high < 0.5:
            yield f"{value.name} is {value.value:.2g}: is that gage dead, or another input?"
    if found.fit.terms and found.given.grip.plant != "lift":
        yield f'{DESIGN_FILE} has no grip.rubber_memory: identify with plant = "lift" under [grip]'
    if found.trace.temperature is None:
        yield "no temperature was recorded: its effect on gages is taken for drift, even in time"
    rest = found.fit.model.path.rest
    for value in values:
        if value.kind == "time" and value.value > rest:
            yield (
                f"{value.name} = {value.value:.3g} s is longer than the longest rest, "
                f"{rest:.3g} s: the trace has no information about later relaxation"
            )


def _law_warnings(found: Identified) -> Iterator[str]:
    """Say which law of friction the trace supports, where it is not Coulomb's for certain."""
    value, half = found.exponent[0], _TWO_SIDED * found.exponent[1]
    exponent = f"{value:.3f} +- {half:.2g}"
    if found.fit.unknowns[-1].kind == "exponent":
        pressure = found.fit.model.pressure
        strength = float(np.exp(found.fit.x[1])) * pressure
        constant = f", nearly a constant strength of {strength:.3g} MPa" if value > 0.9 else ""
        yield (
            f"friction falls with the pressure p: mu (p / {pressure:.3g} MPa)^-n, n = {exponent}"
            f"{constant}; scenes take it as object.friction_law"
        )
    elif half > TARGET["exponent"]:
        yield (
            "the trace does not decide whether friction depends on the pressure (exponent "
            f"{exponent}): shear until all slips, at two depths"
        )


def next_motion(found: Identified, values: tuple[ValueData, ...]) -> NextMotion | None:
    """The motion, of pressing on, shearing on and holding, that would narrow most the value whose
    interval is widest compared with its target; None where all are determined, but for gages'
    offsets, drifts and kelvins, which belong to the trace. By the model's derivatives."""
    fit = found.fit
    first = [v for v in values if v.name != "relaxed_modulus"]
    ratios = np.array([0.0 if v.kind in _DRIFTS else _half(v) / TARGET[v.kind] for v in first])
    worst = int(np.argmax(ratios))
    if ratios[worst] <= 1.0:
        return None
    name, now, deviation = first[worst].name, float(ratios[worst]), float(fit.deviations[worst])

    def then(path: TracePath) -> float:
        return float(now * np.sqrt(fit.covariance(path)[worst, worst])) / deviation

    tried = [NextMotion(how, words, name, now, then(path)) for how, words, path in _motions(found)]
    return min(tried, key=lambda each: each.then)


def _half(value: ValueData) -> float:
    """Half an interval's width, in the unit of TARGET."""
    if value.kind in ("modulus", "friction", "time"):
        return 0.5 * float(np.log(value.high / value.low))
    return 0.5 * (value.high - value.low)


def _motions(found: Identified) -> Iterator[tuple[Motion, str, TracePath]]:
    path, grip = found.fit.model.path, found.given.grip
    step = float(np.median(np.diff(found.trace.time)))
    deep, shear = float(path.approach[-1]), float(path.shear[-1])
    if deep < 0.95 * grip.max_approach_mm:
        down = np.linspace(deep, grip.max_approach_mm, _ROWS)
        words = f"press on to {grip.max_approach_mm:g} mm"
        yield "press", words, _longer(path, down, shear, 2 * step)
    friction = float(np.exp(found.fit.x[1]))
    way = max(3.0 * friction * deep, 0.1 * float(path.approach.max()))
    across = np.linspace(shear, shear + way, _ROWS)
    words = f"shear on by {way:.2g} mm toward +x, or until F_t rises no more"
    yield "shear", words, _longer(path, deep, across, 2 * step)
    rest = max(_LONGER * path.rest, 20.0)
    still = np.diff(np.geomspace(step, rest, _ROWS + 1))
    yield "hold", f"hold still for {rest:.0f} s more", _longer(path, deep, shear, still)


def _longer(
    path: TracePath, approach: Array | float, shear: Array | float, steps: Array | float
) -> TracePath:
    """A path with points after it; as many samples each as its moves have, or its rate gives."""
    steps, usual = np.full(_ROWS, steps), float(np.min(path.steps / path.samples))
    after: dict[str, Array] = {
        "time": path.time[-1] + np.cumsum(steps),
        "approach": np.full(_ROWS, approach),
        "shear": np.full(_ROWS, shear),
        "forces": np.zeros((_ROWS, 2)),
        "readings": np.zeros((_ROWS, path.readings.shape[1])),
        "samples": np.maximum(steps / usual, 1.0),
    }
    if path.temperature is not None:
        after["temperature"] = np.full(_ROWS, path.temperature[-1])
    longer = {key: np.concatenate([getattr(path, key), more]) for key, more in after.items()}
    return replace(path, **longer)


def identified_design(found: Identified, data: IdentificationData) -> Design:
    """The design with modulus, relaxation and friction as found, the modulus with its source."""
    modulus = next(each for each in data.values if each.name == "youngs_modulus")
    material = found.given.body.material
    source = (
        f"identified from {data.trace[:80]}: {modulus.value:.4g} MPa, "
        f"95 % {modulus.low:.4g} to {modulus.high:.4g}"
    )
    friction = next(each for each in data.values if each.name == "friction_coefficient")
    values: dict[str, object] = {
        f"materials.{material}.youngs_modulus_MPa": float(f"{modulus.value:.6g}"),
        f"materials.{material}.source": source,
    }
    if found.fit.terms and found.given.grip.plant == "lift":
        values["grip.relaxation_per_minute"] = 0.0
        values["grip.rubber_memory"] = [
            [float(f"{share:.4g}"), float(f"{time:.4g}")] for share, time in found.fit.terms
        ]
    if friction.determined:
        values["grip.bench_friction_coefficient"] = float(f"{friction.value:.4g}")
    return with_values(found.given, values)
