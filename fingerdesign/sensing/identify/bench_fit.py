"""What a finger's bench tells of its hidden values: where its plates lie, its moduli, its gains.

    fit = fit_latents(design, phases, Noise(0.5, 0.005))
    fit.values, fit.deviations          # beside fit.latents: what each is, and what it was before

Regularised least squares. With x the latents, each 0 in the design and known before the fit to a
standard deviation d (a careful workshop's tolerances, sensing/perturb/finger.py), minimise

    sum_i ((m_i(x) - y_i) / s_i)^2 + sum_k (x_k / d_k)^2

y: readings pressed and tilted at a few normal forces, responses to F_t where all sticks and where
all slips, F_n by approach, dF_t/dx; m: the same of the condensed model in the phases' own moves. s:
the sensors' noise and, in squares, what meshes of one finger differ by (``MESH``).

Sensitivities are central differences on the design, condensed anew on either side in worker
processes and kept in the user's cache: they serve every finger of the design. Plates move in one
mesh (mesh/moved.py): the difference of two would look like information. Readings are all but
linear in them (of what 0.1 mm changes a few per cent are not), so they are not made anew at the
answer; gains are exact. The covariance is the inverse of J^T J / c + I in units of d,
with c = max(1, what the fit leaves over its degrees of freedom): a model that does not fit tells
less. A bench that leans moves the contact by plates: its lean is looked for first, and
sensitivities are those there. Cross-talk and the force cells' gains are not fitted: they end up in
the values (docs/how_to/identify.md).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.checks.load import with_values
from fingerdesign.control.bench_curves import BenchCurves, Phase, pressed
from fingerdesign.control.calibration import Calibration
from fingerdesign.control.signals import NormalCalibration
from fingerdesign.design.digest import content_digest
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.runtime.cache import GARBLED, Cache, packed, unpacked
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.identify.bench import MOST_LEAN_DEG, model_curves, protocol
from fingerdesign.sensing.model import MESHED
from fingerdesign.sensing.perturb.finger import training_faults
from fingerdesign.version import __version__

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

_EVEN = 3.0**-0.5  # standard deviation of what lies evenly between -1 and 1
# Before the fit: standard deviations of sensing/perturb's draws; of a touch seen by eye.
PRIOR = {
    "x": 0.1 * _EVEN,
    "y": 0.1 * _EVEN,
    "angle": 1.0 * _EVEN,
    "modulus": 0.15 * _EVEN,
    "poisson": 0.015 * _EVEN,
    "plate_modulus": 0.2 * _EVEN,
    "lean": 2.0 * _EVEN,
    "touch": 0.01,
    "gain": 0.03,
}
UNITS = {"x": "mm", "y": "mm", "angle": "degrees", "poisson": "", "lean": "degrees", "touch": "mm"}
SHARE = "share"  # unit of the others: of the design's own
AXES = ("x", "y", "angle")
TOLERANCE = {"x": 0.1, "y": 0.1, "angle": 1.0}  # of a plate's place, mm and degrees
# Twice what two meshes of `sensitive` differ by (standard deviations): along a gage's curve they
# differ alike, so that its points say less than as many would that were wrong each for itself.
# Readings, microstrain; responses, microstrain/N; forces, a share.
MESH = {"plane-strain": (1.8, 0.6, 0.004), "3d": (6.0, 2.0, 0.01)}
# What fifteen drawn fingers show beyond the covariance: the row as a whole and the bench's lean are
# hard to tell apart (8 micrometres at the crest are a hundredth of a degree): the mesh decides.
ROW = {"x": 0.015, "lean": 0.02}
_STEPS = {"lean": 0.5}  # standard deviations to either side
_STEP = 0.25  # of the others
_FORCES = 12  # points of a press that are compared
_LEANS = np.linspace(-2.5, 2.5, 21)  # degrees
_LEANS_ANYHOW = 0.7  # of what a level bench leaves, what one that leans has to leave
_MOST_POISSON = 0.4999
_REACH, _ROUNDS = 4.0, 8  # standard deviations; evaluations of the model
_FORMAT = 1
_KINDS = {kind.__name__: kind for kind in (BenchCurves, Calibration, NormalCalibration)}


@dataclass(frozen=True)
class Latent:
    """A hidden value, as what it is off the design's. kind: a key of PRIOR; number: of the plate,
    or of the gage in the readings' order; deviation: before the fit."""

    kind: str
    number: int | None = None

    @property
    def name(self) -> str:
        """What records and tables call it."""
        if self.kind == "gain":
            return f"gage_{self.number}.gain"
        return self.kind if self.number is None else f"plate_{self.number}.{self.kind}"

    @property
    def unit(self) -> str:
        return UNITS.get(self.kind, SHARE)

    @property
    def deviation(self) -> float:
        return PRIOR[self.kind]

    @property
    def step(self) -> float:
        """To either side, of its sensitivity."""
        return _STEPS.get(self.kind, _STEP) * self.deviation


@dataclass(frozen=True)
class Noise:
    """Standard deviations of one sample: a gage's, microstrain; a force's, N."""

    gage: float
    force: float


@dataclass(frozen=True)
class LatentFit:
    """values, deviations (k,): of each latent after the fit, in its unit. before, after: RMS of
    readings less the model's, microstrain; gages_after (g,): the same of each gage. misfit: what
    the fit leaves, over its degrees of freedom; 1 where noise and mesh explain it. dead: gages
    (from 1) that answer to nothing. curves: the fitted model's, through the fitted gains."""

    latents: tuple[Latent, ...]
    values: Array
    deviations: Array
    before: float
    after: float
    gages_after: Array
    misfit: float
    dead: tuple[int, ...]
    design: Design
    curves: BenchCurves

    def of(self, kind: str) -> tuple[Array, Array]:
        """Values and deviations of all latents of a kind."""
        rows = [k for k, each in enumerate(self.latents) if each.kind == kind]
        return self.values[rows], self.deviations[rows]


def latents_of(design: Design, gages: int, tilted: bool) -> tuple[Latent, ...]:
    """What can be off in a design: plates where they lie in one level row, moduli where rubber and
    plates are of two materials; the bench's lean where a press was tilted."""
    possible = training_faults(design)
    plates = range(len(plate_frames(design))) if "plates" in possible else ()
    found = [Latent(axis, plate) for plate in plates for axis in AXES]
    found += [Latent(kind) for kind in ("modulus", "plate_modulus") if "modulus" in possible]
    found += [Latent("poisson"), *([Latent("lean")] if tilted else []), Latent("touch")]
    return (*found, *(Latent("gain", number) for number in range(1, gages + 1)))


def with_latents(design: Design, latents: Sequence[Latent], values: Array) -> Design:
    """The design with such plates and materials. DesignError where it cannot be."""
    keys: dict[str, object] = {}
    frames = plate_frames(design)
    places = np.array([[*each.centre, each.angle_deg] for each in frames]).reshape(-1, 3)
    moved = False
    for latent, value in zip(latents, values, strict=True):
        if latent.kind in AXES and latent.number is not None:
            places[latent.number, AXES.index(latent.kind)] += value
            moved = moved or bool(value)
        elif latent.kind in ("modulus", "plate_modulus"):
            table = "body" if latent.kind == "modulus" else "plates"
            name = getattr(design, table).material
            own = design.material_of(table).youngs_modulus_MPa  # type: ignore[arg-type]
            keys[f"materials.{name}.youngs_modulus_MPa"] = own * (1.0 + float(value))
        elif latent.kind == "poisson":
            own = design.material_of("body").poissons_ratio + float(value)
            keys[f"materials.{design.body.material}.poissons_ratio"] = min(own, _MOST_POISSON)
    if moved:
        rows: list[list[float]] = places.tolist()
        if any(frame.middle for frame in frames):
            rows = [[*row, frame.middle] for row, frame in zip(rows, frames, strict=True)]
            keys |= {"plates.stagger_mm": 0.0, "plates.span_offset_mm": 0.0}
        keys |= {"plates.placement": rows, "plates.offset_mm": 0.0}
    return with_values(design, keys)


# Sensitivities: the curves of fingers to either side of the design, and of the design itself.


def sensitivities(
    design: Design,
    plan: Sequence[Phase],
    latents: Sequence[Latent],
    fidelity: str,
    workers: int,
    report: Report,
    lean_deg: float = 0.0,
) -> list[tuple[BenchCurves, BenchCurves, float]]:
    """Curves of each latent below and above the design's value, and how far apart the two lie.

    A side on which there is no sound finger is the design's own. lean_deg: of the bench, about
    which the lean's own lies.
    """
    kept = Cache("sensitivities", most=40)
    name = f"{_key(design, plan, latents, fidelity, lean_deg)}.npz"
    sides = [(latent, side * latent.step) for latent in latents for side in (-1.0, 1.0)]
    found: list[BenchCurves | None] = []
    if stored := kept.arrays(name):
        try:
            found = list(unpacked(stored[1], stored[0], _KINDS))
        except GARBLED:
            found = []
    if len(found) != 1 + len(sides):
        jobs = [(None, 0.0), *sides]
        with Pool(
            min(workers, len(jobs)), shared=(design, tuple(plan), fidelity, lean_deg)
        ) as pool:
            found = []
            for each in pool.in_order(_curves_beside, jobs):
                found.append(each)
                report(f"sensitivities: {len(found)} of {len(jobs)}")
        if found[0] is None:
            raise SolverError("the design's own model has no answer in the moves of its bench")
        arrays: dict[str, Array] = {}
        about = packed(tuple(found), arrays)
        kept.put_arrays(name, arrays, about)
    middle, steps = found[0], [step for _, step in sides]
    assert middle is not None
    pairs = []
    for k in range(len(latents)):
        low, high = found[1 + 2 * k], found[2 + 2 * k]
        apart = steps[2 * k + 1] * (high is not None) - steps[2 * k] * (low is not None)
        pairs.append((low or middle, high or middle, apart or 1.0))
    return pairs


def _curves_beside(
    design: Design,
    plan: tuple[Phase, ...],
    fidelity: str,
    lean_deg: float,
    latent: Latent | None,
    off: float,
) -> BenchCurves | None:
    """Those of one finger beside the design; None where it is not sound."""
    try:
        if latent is None:
            return model_curves(design, plan, fidelity, lean_deg, design)
        if latent.kind == "lean":
            return model_curves(design, plan, fidelity, lean_deg + off, design)
        beside = with_latents(design, [latent], np.array([off]))
        return model_curves(beside, plan, fidelity, lean_deg, design)
    except (DesignError, SolverError):
        return None


def _key(
    design: Design,
    plan: Sequence[Phase],
    latents: Sequence[Latent],
    fidelity: str,
    lean_deg: float,
) -> str:
    moves = [
        (
            p.kind,
            p.friction_coefficient,
            p.tilt_deg,
            p.points.approach.tolist(),
            p.points.shear.tolist(),
        )
        for p in plan
    ]
    tables = [design.body, design.plates, design.gages, design.mesh, *design.materials.values()]
    content = [
        *(_FORMAT, __version__, fidelity, MESHED, MOST_LEAN_DEG, moves),
        [content_digest(each) for each in tables],
        sorted(design.materials),
        [(each.name, each.step) for each in latents],
        *([lean_deg] if lean_deg else []),
    ]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


# The fit.


@dataclass(frozen=True)
class _Where:
    """Where curves are compared: forces (n,) N of the press, of each tilted press, of the small
    shears; approach (n,) mm of the press; whether there was a slide."""

    press: Array
    tilted: tuple[Array, ...]
    sheared: Array
    approach: Array
    slid: bool

    @property
    def readings(self) -> int:
        """How many of strain's rows are readings, microstrain; the others are responses."""
        return len(self.press) + sum(map(len, self.tilted))

    def of(self, curves: BenchCurves, touch: float = 0.0) -> tuple[Array, Array]:
        """Strain (r, g) and scalar (q,), F_n then dF_t/dx, of curves of the same phases."""
        own = curves.calibration
        rows = [own.normal.at(force) for force in self.press]
        for forces, (_, leant) in zip(self.tilted, curves.tilted, strict=True):
            rows += [leant.at(force) for force in forces]
        rows += [own.sticking.at(force) for force in self.sheared]
        if self.slid and curves.sliding is not None:
            rows.append(curves.sliding)
        forces = np.interp(self.approach + touch, own.approach, own.normal.normal_force)
        stiffness = np.interp(self.sheared, own.sticking.normal_force, own.stiffness)
        return np.array(rows), np.concatenate([forces, stiffness])


@dataclass(frozen=True)
class _Data:
    """What was measured there, and its standard deviations."""

    where: _Where
    strain: Array
    strain_deviation: Array
    scalar: Array
    scalar_deviation: Array


def _data(
    phases: Sequence[Phase],
    curves: BenchCurves,
    noise: Noise,
    alive: BoolArray,
    fidelity: str,
) -> _Data:
    """The measured values; deviations of gages that are dead are infinite."""
    own = curves.calibration
    (press,) = (each for each in phases if each.kind == "press")
    mean = float(np.median(press.points.samples)) ** 0.5
    reading, force = noise.gage / mean, noise.force / mean
    some = _some(len(own.approach), _FORCES)
    leant = [pressed(p.points)[0].normal_force for p in phases if p.kind == "tilt"]
    where = _Where(
        own.normal.normal_force[some],
        tuple(forces[_some(len(forces), _FORCES // 2)] for forces in leant),
        own.sticking.normal_force,
        own.approach[some],
        curves.sliding is not None,
    )
    strain, scalar = where.of(curves)
    pulls, shears = small_pulls(phases, len(where.sheared))
    slides = [p.points for p in phases if p.kind == "slide" and p.points.shear[-1] > 0.0]
    apart = 2.0**0.5 * reading / np.array([*pulls, *(at.tangential_force[-1] for at in slides[:1])])
    mesh = MESH[fidelity]
    rows = [np.full(where.readings, np.hypot(reading, mesh[0]))]
    rows.append(np.hypot(apart, mesh[1]))
    deviation = np.concatenate(rows)[:, None] * np.where(alive, 1.0, np.inf)
    jitter = np.concatenate([np.full(len(some), force), 2.0**0.5 * force / shears])
    return _Data(where, strain, deviation, scalar, np.hypot(jitter, mesh[2] * scalar))


def _some(points: int, count: int) -> IntArray:
    """``count`` of a curve's points, or all, evenly up to its last; its first is no point."""
    return np.unique(np.linspace(1, points - 1, count + 1).astype(np.int64)[1:])


def small_pulls(phases: Sequence[Phase], count: int) -> tuple[Array, Array]:
    """F_t, N, and shear, mm, of the ``count`` deepest small shears (k,), by depth."""
    last = [
        (float(p.points.normal_force[-1]), p.points.tangential_force[-1], p.points.shear[-1])
        for p in phases
        if p.kind == "shear"
    ]
    table = np.array(sorted(last)[-count:])
    return table[:, 1], table[:, 2]


def dead_gages(curves: BenchCurves, noise: float) -> tuple[int, ...]:
    """Gages (from 1) whose readings under the press are noise, or a hundredth of the others'."""
    most = np.abs(curves.calibration.normal.readings).max(axis=0)
    return tuple(
        int(k) + 1 for k in np.flatnonzero(most < max(5.0 * noise, 0.01 * np.median(most)))
    )


class _Problem:
    """Residuals over deviations, and their derivatives by the latents over theirs."""

    def __init__(
        self,
        design: Design,
        phases: Sequence[Phase],
        fidelity: str,
        data: _Data,
        latents: Sequence[Latent],
        columns: Array,
    ) -> None:
        self.design, self.phases, self.fidelity, self.data = design, phases, fidelity, data
        self.latents, self._columns = latents, columns
        self.scale = np.array([each.deviation for each in latents])
        self._kinds = np.array([each.kind for each in latents])
        self._known: dict[bytes, BenchCurves] = {}

    def curves(self, x: Array) -> BenchCurves:
        """The model's at x, in deviations; the design's own where x is no sound finger."""
        if x.tobytes() not in self._known:
            lean = float(self.values(x, "lean").sum())
            design = with_latents(self.design, self.latents, x * self.scale)
            self._known[x.tobytes()] = model_curves(
                design, self.phases, self.fidelity, lean, self.design
            )
        return self._known[x.tobytes()]

    def values(self, x: Array, kind: str) -> Array:
        """Of the latents of a kind, in their unit."""
        return np.asarray((x * self.scale)[self._kinds == kind])

    def off(self, x: Array) -> tuple[Array, Array]:
        """The model's strain and scalar less what was measured."""
        strain, scalar = self.data.where.of(self.curves(x), float(self.values(x, "touch").sum()))
        return strain * (1.0 + self.values(x, "gain")) - self.data.strain, scalar - self.data.scalar

    def residual(self, x: Array) -> Array:
        try:
            strain, scalar = self.off(x)
        except (DesignError, SolverError):  # plates that overlap: no finger, and a shorter step
            strain, scalar = 1e3 * self.data.strain, self.data.scalar
        own = strain / self.data.strain_deviation
        return np.concatenate([own.ravel(), scalar / self.data.scalar_deviation, x])

    def jacobian(self, x: Array) -> Array:
        strain, _ = self.data.where.of(self.curves(x))
        columns = self._columns.copy()
        for gage, k in enumerate(np.flatnonzero(self._kinds == "gain")):
            own = np.zeros_like(strain)
            own[:, gage] = strain[:, gage] / self.data.strain_deviation[:, gage] * self.scale[k]
            columns[: own.size, k] = own.ravel()
        return np.concatenate([columns, np.eye(len(x))])


def _columns(
    data: _Data, latents: Sequence[Latent], pairs: Sequence[tuple[BenchCurves, BenchCurves, float]]
) -> Array:
    """Of the Jacobian (data, latents), gains left 0."""
    rows = data.strain.size + len(data.scalar)
    found = np.zeros((rows, len(latents)))
    shaped = iter(pairs)
    for k, latent in enumerate(latents):
        if latent.kind == "gain":
            continue
        if latent.kind == "touch":
            low = high = pairs[0][0]
            apart = 2.0 * latent.step
            below, above = data.where.of(low, -0.5 * apart), data.where.of(high, 0.5 * apart)
        else:
            low, high, apart = next(shaped)
            below, above = data.where.of(low), data.where.of(high)
        strain = (above[0] - below[0]) / data.strain_deviation
        scalar = (above[1] - below[1]) / data.scalar_deviation
        found[:, k] = np.concatenate([strain.ravel(), scalar]) * latent.deviation / apart
    return found


def _about_lean(
    design: Design, phases: Sequence[Phase], data: _Data, fidelity: str, report: Report
) -> float:
    """The bench's lean, degrees, to the next of ``_LEANS``, at which the design's own model fits
    best: sensitivities depend on where the contact lies, which a degree moves by plates."""
    left: list[float] = []
    for lean in _LEANS:
        report("looking for the bench's lean")
        try:
            curves = model_curves(design, phases, fidelity, float(lean), design)
        except SolverError:
            left.append(np.inf)
            continue
        strain = (data.where.of(curves)[0] - data.strain) / data.strain_deviation
        left.append(float(np.sum(strain**2)))
    level = left[len(_LEANS) // 2]
    return float(_LEANS[int(np.argmin(left))]) if min(left) < _LEANS_ANYHOW * level else 0.0


def fit_latents(
    design: Design,
    phases: Sequence[Phase],
    curves: BenchCurves,
    noise: Noise,
    fidelity: str = "plane-strain",
    workers: int = 1,
    report: Report = lambda message: None,
) -> LatentFit:
    """The finger that the phases were measured on; curves: bench_curves of these phases.

    Raises SolverError where the design's own model has no answer in the phases' moves.
    """
    gages = curves.calibration.normal.readings.shape[1]
    tilts = [each.tilt_deg for each in phases if each.kind == "tilt"]
    latents = latents_of(design, gages, bool(tilts))
    dead = dead_gages(curves, noise.gage)
    alive = ~np.isin(np.arange(1, gages + 1), dead)
    data = _data(phases, curves, noise, alive, fidelity)
    (friction,) = {each.friction_coefficient for each in phases if each.kind == "press"}
    plan = [
        type(each)(each.name, each.kind, friction, each.tilt_deg, each.points)
        for each in protocol(design, tilts)
    ]
    shaped = [each for each in latents if each.kind not in ("gain", "touch")]
    about = _about_lean(design, phases, data, fidelity, report) if tilts else 0.0
    pairs = sensitivities(design, plan, shaped, fidelity, workers, report, about)
    problem = _Problem(design, phases, fidelity, data, latents, _columns(data, latents, pairs))
    most = np.full(len(latents), _REACH)
    least = -most.copy()
    for k, each in enumerate(latents):
        if each.kind == "poisson":
            room = _MOST_POISSON - design.material_of("body").poissons_ratio
            most[k] = max(room / each.deviation, 1e-3)
        if each.kind == "lean":
            most[k], least[k] = MOST_LEAN_DEG / each.deviation, -MOST_LEAN_DEG / each.deviation
    report("fitting")
    start = np.array([about / each.deviation * (each.kind == "lean") for each in latents])
    found = least_squares(
        problem.residual,
        start,
        problem.jacobian,
        (least, most),
        ftol=1e-3,
        xtol=1e-3,
        max_nfev=_ROUNDS,
    )
    return _fitted(problem, found.x, dead, alive)


def _fitted(problem: _Problem, x: Array, dead: tuple[int, ...], alive: BoolArray) -> LatentFit:
    data = problem.data
    jacobian = problem.jacobian(x)[: -len(x)]
    left = problem.residual(x)
    count = int(np.isfinite(data.strain_deviation).sum()) + len(data.scalar)
    misfit = float(left @ left) / count  # with the prior's rows, as many as there are latents
    covariance = np.linalg.inv(jacobian.T @ jacobian / max(1.0, misfit) + np.eye(len(x)))

    def rms(strain: Array) -> Array:
        return np.asarray(np.sqrt(np.mean(strain[: data.where.readings] ** 2, axis=0)))

    before, after = (rms(problem.off(at)[0]) for at in (np.zeros(len(x)), x))
    values = x * problem.scale
    row = np.array([ROW.get(each.kind, 0.0) for each in problem.latents])
    deviations = np.hypot(np.sqrt(np.diag(covariance)) * problem.scale, row)
    return LatentFit(
        latents=tuple(problem.latents),
        values=values,
        deviations=np.minimum(deviations, problem.scale),
        before=float(np.sqrt(np.mean(before[alive] ** 2))),
        after=float(np.sqrt(np.mean(after[alive] ** 2))),
        gages_after=after,
        misfit=misfit,
        dead=dead,
        design=with_latents(problem.design, problem.latents, values),
        curves=problem.curves(x),
    )
