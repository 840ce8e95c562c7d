"""Fit of a finger's hidden values to its bench: regularised least squares.

    fit = fit_latents(Measured(design, phases, curves, Noise(0.5, 0.005)))
    fit.latents, fit.values, fit.deviations

With x the latents, each 0 in the design and known before the fit to a standard deviation d (a
careful workshop's tolerances, sensing/perturb), minimise

    sum_i ((m_i(x) - y_i) / s_i)^2 + sum_k (x_k / d_k)^2

y: readings pressed and tilted at a few normal forces, responses to F_t where all sticks and all
along the slides, F_n by approach, dF_t/dx; m: the same of the condensed model in the phases' own
moves. s: the sensors' noise and, in squares, the difference of two meshes of one finger (``MESH``).

Steps are Gauss-Newton's. The Jacobian is derived at the design, and after the first and the second
step (sensitivities.py): readings curve with the plates' places, more than with all else. In 3-D it
is that of a rough mesh: off by 8 %, for a third of the time; only the last one's slope by the lean
is of the fit's own mesh. Gains and touch need no other finger: after each step they are fitted
alone. Plates move within the design's mesh: meshed again, a finger's readings change with the last
digits of its plates' places by as much as its angles are worth.

Columns of gains, touch and the rubber's modulus (all moduli multiply the forces) need curves alone.
That of the lean is a difference: it moves the contact from node to node, and its derivative, with
the nodes' statuses frozen, is off by a quarter to a third. The covariance is the inverse of
J^T J / c + I in units of d, with c = max(1, the misfit over its degrees of freedom): a model that
does not fit gives less. A lean of the bench moves the contact by plates: it is found first, and
sensitivities are those there. Cross-talk and the force cells' gains are not fitted: they change the
values (docs/how_to/identify.md).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.optimize import lsq_linear

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.control.bench_curves import BenchCurves, Phase, Points, Slide, pressed
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.fem.factor import orders_held
from fingerdesign.fem.memory import memory_kept
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.identify.bench import MOST_LEAN_DEG, BenchModel, protocol
from fingerdesign.sensing.identify.latents import MOST_POISSON, Latent, latents_of, with_latents
from fingerdesign.sensing.identify.sensitivities import differences

# Deviations between the model and a fine one of `sensitive`, doubled: along a gage's curve they
# differ alike, so its points carry less information than as many independent ones. In 3-D they are
# 0.6 microstrain.
# Readings, microstrain; responses, microstrain/N; forces, a fraction.
MESH = {"plane-strain": (1.8, 0.6, 0.004), "3d": (1.0, 0.5, 0.005)}
# Errors beyond the covariance, of fifteen drawn fingers, in 3-D of four: the row as a whole and the
# lean can hardly be separated (8 micrometres at the crest are a hundredth of a degree), and in 3-D
# the rest of the mesh's errors is alike along a gage's curve.
BEYOND = {
    "plane-strain": {"x": 0.015, "lean": 0.02},
    "3d": {"x": 0.015, "y": 0.008, "angle": 0.1, "lean": 0.02},
}
_FORCES = 12  # Points of a press that are compared.
# Moves of a press where the lean is looked for and first derivatives are taken, and of the last.
_MOVES = (12, 24)
_LEANS = np.linspace(-2.5, 2.5, 11)  # Leans to try, degrees; then half-way to the next.
_LEAN_GAIN = 0.7  # A lean is accepted if its squares are under this fraction of a level bench's.
_REACH = 4.0  # The largest change in standard deviations.
# Steps at most after each set of derivatives. All end where squares would fall by less than this
# fraction: in 3-D a step takes 6 to 9 s. By 0.15 a finger's heights were off by a fourth more.
_STEPS, _ENOUGH, _HALVINGS = (1, 1, 8), 0.1, 4
# Of a slide, points with these shares of its last F_t are compared, and the last: those between
# repeat them, with the same errors of the mesh.
_SHARES = (0.4, 0.8)
_EXACT = ("gain", "touch", "modulus")  # Latents whose slopes need curves alone.
# Those that need no other finger; so many steps settle them, the second for the touch.
_FREE, _SETTLING = ("gain", "touch"), 2
_EQUATIONS = 400_000  # Of the rough and the coarse mesh together, at most.
_ANOTHER = 10.0  # Times noise and mesh: so much is left where the finger or a unit is another.
_SMALL = 0.25  # The mesh changes a small shear's readings by this fraction of a press's.


@dataclass(frozen=True)
class Noise:
    """Standard deviations of one sample: a gage's, microstrain; a force's, N."""

    gage: float
    force: float


@dataclass(frozen=True)
class Measured:
    """The finger of a design, measured on its bench. curves: bench_curves of the phases; fidelity:
    of the model that they are compared with."""

    design: Design
    phases: tuple[Phase, ...]
    curves: BenchCurves
    noise: Noise
    fidelity: str = "plane-strain"

    @property
    def mean_noise(self) -> Noise:
        """The noise of a point of the press, which is the mean of many samples."""
        (press,) = (each for each in self.phases if each.kind == "press")
        mean = float(np.median(press.points.samples)) ** 0.5
        return Noise(self.noise.gage / mean, self.noise.force / mean)


@dataclass(frozen=True)
class LatentFit:
    """values, deviations (k,): of each latent after the fit, in its unit. before, after: RMS of
    readings less the model's, microstrain; gages_after (g,): the same of each gage. misfit: what
    the fit leaves, over its degrees of freedom; 1 where noise and mesh explain it. dead: gages
    (from 1) without response. curves: the fitted model's, through the fitted gains."""

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


@dataclass(frozen=True)
class _Points:
    """Points at which curves are compared: forces (n,) N of the press, of each tilted press, of the
    small shears; approach (n,) mm of the press; slid: shears of each slide, mm."""

    press: Array
    tilted: tuple[Array, ...]
    sheared: Array
    approach: Array
    slid: tuple[Array, ...]

    @property
    def readings(self) -> int:
        """The number of readings, microstrain, among strain's rows; the others are responses."""
        return len(self.press) + sum(map(len, self.tilted))

    def of(
        self, curves: BenchCurves, touch: float = 0.0, stiffer: float = 1.0
    ) -> tuple[Array, Array]:
        """Strain (r, g) and scalar (q,), F_n then dF_t/dx, of curves of the same phases. stiffer:
        all moduli times this, which multiplies forces and leaves readings."""
        own = curves.calibration
        rows = [own.normal.at(force / stiffer) for force in self.press]
        for forces, (_, leant) in zip(self.tilted, curves.tilted, strict=True):
            rows += [leant.at(force / stiffer) for force in forces]
        rows += [own.sticking.at(force / stiffer) / stiffer for force in self.sheared]
        for shears in self.slid:
            side = [each for each in curves.slides if each.shear[-1] * shears[-1] > 0.0]
            rows += [*(side[0].at(shears) / stiffer)]
        forces = np.interp(self.approach + touch, own.approach, own.normal.normal_force)
        stiffness = np.interp(self.sheared / stiffer, own.sticking.normal_force, own.stiffness)
        return np.array(rows), stiffer * np.concatenate([forces, stiffness])


class _Data:
    """The measured values at some points, and their standard deviations: infinite of dead gages."""

    def __init__(self, measured: Measured, alive: BoolArray) -> None:
        phases, curves, noise = measured.phases, measured.curves, measured.mean_noise
        own = curves.calibration
        some = _some(len(own.approach), _FORCES)
        leant = [pressed(p.points)[0].normal_force for p in phases if p.kind == "tilt"]
        self.where = _Points(
            own.normal.normal_force[some],
            tuple(forces[_some(len(forces), _FORCES // 2)] for forces in leant),
            own.sticking.normal_force,
            own.approach[some],
            tuple(each.shear[_compared(each)] for each in curves.slides),
        )
        self.strain, self.scalar = self.where.of(curves)
        pulls, shears = small_pulls(phases, len(self.where.sheared))
        readings, responses, forces = MESH[measured.fidelity]
        rows = [np.full(self.where.readings, np.hypot(noise.gage, readings))]
        sheared = np.hypot(2.0**0.5 * noise.gage, _SMALL * readings)
        rows.append(np.hypot(sheared / pulls, responses))
        slid = np.hypot(2.0**0.5 * noise.gage, readings)
        for way, each in zip(self.where.slid, curves.slides, strict=True):
            rows.append(np.full(len(way), slid / abs(each.tangential_force[-1])))
        self.strain_deviation = np.concatenate(rows)[:, None] * np.where(alive, 1.0, np.inf)
        jitter = np.concatenate([np.full(len(some), noise.force), 2.0**0.5 * noise.force / shears])
        self.scalar_deviation = np.hypot(jitter, forces * self.scalar)


def _some(points: int, count: int) -> IntArray:
    """``count`` of a curve's points, or all, evenly up to its last, without its first."""
    return np.unique(np.linspace(1, points - 1, count + 1).astype(np.int64)[1:])


def _compared(slide: Slide) -> IntArray:
    """Points of a slide: the first ones with these shares of F_t, and the last."""
    shares = slide.tangential_force / slide.tangential_force[-1]
    return np.unique([*(int(np.argmax(shares >= share)) for share in _SHARES), len(shares) - 1])


def _planned(phase: Phase, friction: float, moves: int) -> Phase:
    """A phase at the bench's friction; a press with no more moves than derivatives need."""
    points = phase.points
    if phase.kind == "press" and len(points.approach) > moves:
        some = _some(len(points.approach), moves)
        points = Points(**{key: each[some] for key, each in vars(points).items()})
    return replace(phase, points=points, friction_coefficient=friction)


def small_pulls(phases: Sequence[Phase], count: int) -> tuple[Array, Array]:
    """F_t, N, and shear, mm, of the ``count`` deepest small shears (k,), by depth."""
    sheared = [phase.points for phase in phases if phase.kind == "shear"]
    last = [(at.normal_force[-1], at.tangential_force[-1], at.shear[-1]) for at in sheared]
    table = np.array(sorted(last)[-count:])
    return table[:, 1], table[:, 2]


def dead_gages(curves: BenchCurves, noise: float) -> tuple[int, ...]:
    """Gages (from 1) whose readings under the press are noise, or a hundredth of the others'."""
    most = np.abs(curves.calibration.normal.readings).max(axis=0)
    dead = most < max(5.0 * noise, 0.01 * np.median(most))
    return tuple((1 + np.flatnonzero(dead)).tolist())


class _Problem:
    """Residuals over deviations, and their derivatives by the latents over theirs."""

    def __init__(self, model: BenchModel, data: _Data, latents: Sequence[Latent]) -> None:
        """columns (data, latents): the Jacobian's, 0 of what is exact."""
        self.model, self.data, self.latents = model, data, latents
        self.columns = np.zeros((data.strain.size + len(data.scalar), len(latents)))
        self.scale = np.array([each.deviation for each in latents])
        self._kinds = np.array([each.kind for each in latents])
        self._free = np.isin(self._kinds, _FREE)
        self._leant = dict[bytes, Callable[[float], BenchCurves]]()
        self.least, self.most = _bounds(model.design, latents)

    def finger(self, x: Array) -> Design:
        """The finger at x. Raises DesignError where it is not sound."""
        return with_latents(self.model.design, self.latents, x * self.scale)

    def curves(self, x: Array, leaning: float = 0.0) -> BenchCurves:
        """The model's at x, in deviations, and at a further lean, degrees. Raises DesignError where
        x is no sound finger."""
        key = x[~self._free & (self._kinds != "lean")].tobytes()
        if key not in self._leant:
            last = list(self._leant.items())[-1:]  # Of a finger in 3-D 120 MB are held.
            played = cache(self.model.curves_by_lean(self.finger(x)))
            self._leant = {**dict(last), key: played}
        return self._leant[key](self.value(x, "lean") + leaning)

    def values(self, x: Array, kind: str) -> Array:
        """The latents of a kind, in their unit."""
        return np.asarray((x * self.scale)[self._kinds == kind])

    def value(self, x: Array, kind: str) -> float:
        """The latent of a kind of which there is one, or 0."""
        return float(self.values(x, kind).sum())

    def played(
        self, x: Array, lean: float = 0.0, touch: float = 0.0, stiffer: float = 0.0
    ) -> tuple[Array, Array]:
        """The model's strain, through gains of 1, and scalar at x, and at a further lean and touch,
        all moduli larger by the fraction ``stiffer``."""
        touch += self.value(x, "touch")
        return self.data.where.of(self.curves(x, lean), touch, 1.0 + stiffer)

    def off(self, x: Array) -> tuple[Array, Array]:
        """The model's strain and scalar less the measured ones."""
        strain, scalar = self.played(x)
        return strain * (1.0 + self.values(x, "gain")) - self.data.strain, scalar - self.data.scalar

    def residual(self, x: Array) -> Array:
        try:
            strain, scalar = self.off(x)
        except (DesignError, SolverError):  # Plates overlap: large residuals shorten the step.
            strain, scalar = 1e3 * self.data.strain, self.data.scalar
        own = strain / self.data.strain_deviation
        return np.concatenate([own.ravel(), scalar / self.data.scalar_deviation, x])

    def settled(self, x: Array) -> Array:
        """x with those gains and that touch that fit best to its finger's curves, or x where the
        finger is not sound."""
        own = self._free
        try:
            self.curves(x)
        except (DesignError, SolverError):
            return x
        for _ in range(_SETTLING):
            jacobian = self.jacobian(x)[:, own]
            room = (self.least - x)[own], (self.most - x)[own]
            x = x.copy()
            x[own] += lsq_linear(jacobian, -self.residual(x), room).x
        return x

    def derive(self, x: Array, planned: BenchModel, roughly: bool, report: Report) -> None:
        """Take the columns again, at x, in the moves of ``planned``. roughly: that of the lean in
        the rough mesh, too."""
        exact = _EXACT if roughly else (*_EXACT, "lean")
        shaped = [k for k, each in enumerate(self.latents) if each.kind not in exact]
        own = [self.latents[k] for k in shaped]
        found = differences(planned, self.finger(x), own, self.value(x, "lean"), report)
        self.columns = np.zeros_like(self.columns)
        for k, each in zip(shaped, found, strict=True):
            low, high = (self._weighed(*self.data.where.of(c)) for c in (each.low, each.high))
            self.columns[:, k] = (high - low) * self.scale[k] / each.apart
        if "lean" in self._kinds and not roughly:
            own, slope = self._kinds == "lean", self._slope(x, "lean", self.model.lean_step)
            self.columns[:, own] = slope[:, None] * self.scale[own]

    def jacobian(self, x: Array) -> Array:
        gains = 1.0 + self.values(x, "gain") * np.ones_like(self.data.strain)
        through = np.concatenate([gains.ravel(), np.ones(len(self.data.scalar))])
        own = through[:, None] * (self.columns + self._exact_columns(x))
        strain, still = self.played(x)[0], np.zeros_like(self.data.scalar)
        for gage, k in enumerate(np.flatnonzero(self._kinds == "gain")):
            rise = np.zeros_like(strain)
            rise[:, gage] = self.scale[k] * strain[:, gage]
            own[:, k] = self._weighed(rise, still)
        return np.concatenate([own, np.eye(len(self.scale))])

    def _exact_columns(self, x: Array) -> Array:
        """Columns at x of touch and modulus, which take no condensation; those of the others 0."""
        own, values = np.zeros_like(self.columns), x * self.scale
        for k, each in enumerate(self.latents):
            if each.kind == "touch":
                own[:, k] = self._slope(x, "touch", each.step)
            elif each.kind == "modulus":
                plates = int(np.flatnonzero(self._kinds == "plate_modulus")[0])
                alone = (1.0 + values[plates]) * self.columns[:, plates] / self.scale[plates]
                own[:, k] = (self._slope(x, "stiffer", each.step) - alone) / (1.0 + values[k])
        return np.asarray(own * self.scale)

    def _slope(self, x: Array, what: str, step: float) -> Array:
        """Half the difference of what is played at a step below and above x, by the step."""
        below, above = (self._weighed(*self.played(x, **{what: off})) for off in (-step, step))
        return np.asarray((above - below) / (2.0 * step))

    def _weighed(self, strain: Array, scalar: Array) -> Array:
        own = (strain / self.data.strain_deviation).ravel(), scalar / self.data.scalar_deviation
        return np.concatenate(own)


def _about_lean(curves: Callable[[float], BenchCurves], data: _Data, report: Report) -> float:
    """Find the lean, degrees, at which the design's own model fits best: among ``_LEANS``, then
    next to the best of them. Sensitivities depend on the place of the contact, which a degree moves
    by plates. curves: the design's by a lean."""

    @cache
    def left(lean: float) -> float:
        report("looking for the bench's lean")
        try:
            strain = data.where.of(curves(lean))[0] - data.strain
            return float(np.sum((strain / data.strain_deviation) ** 2))
        except SolverError:
            return np.inf

    half_way = 0.5 * float(_LEANS[1] - _LEANS[0])
    best = min(_LEANS.tolist(), key=left)
    best = min((best, best - half_way, best + half_way), key=left)
    return best if left(best) < _LEAN_GAIN * left(0.0) else 0.0


def fit_latents(measured: Measured, report: Report = lambda message: None) -> LatentFit:
    """Fit the finger that was measured.

    Raises SolverError where the design's own model has no answer in the phases' moves, where the
    fit does not converge, and where no finger near the design has these curves.
    """
    design, phases = measured.design, measured.phases
    gages = measured.curves.calibration.normal.readings.shape[1]
    tilts = [each.tilt_deg for each in phases if each.kind == "tilt"]
    latents = latents_of(design, gages, bool(tilts))
    dead = dead_gages(measured.curves, measured.noise.gage)
    alive = ~np.isin(np.arange(1, gages + 1), dead)
    data = _Data(measured, alive)
    model = BenchModel(design, phases, measured.fidelity)
    (friction,) = {each.friction_coefficient for each in phases if each.kind == "press"}
    plan = protocol(design, tilts)
    at_first, in_the_end = (
        replace(model, phases=tuple(_planned(each, friction, moves) for each in plan))
        for moves in _MOVES
    )
    about = _about_lean(at_first.rough_curves_by_lean(), data, report) if tilts else 0.0
    problem = _Problem(model, data, latents)
    x = np.array([about / each.deviation * (each.kind == "lean") for each in latents])
    x, fall = problem.settled(x), np.inf
    with orders_held(_EQUATIONS), memory_kept():
        for number, steps in enumerate(_STEPS, 1):
            roughly = number < len(_STEPS)
            problem.derive(x, at_first if roughly else in_the_end, roughly, report)
            report("fitting")
            x, fall = _least_squares(problem, x, steps)
            if fall < _ENOUGH * float(np.sum(problem.residual(x) ** 2)):
                break
    left = problem.residual(x)
    # Squares under their number are noise: no step is needed there.
    if fall >= _ENOUGH * max(float(left @ left), len(left)):
        raise SolverError(
            f"the fit did not converge: a further step promises {100.0 * fall / (left @ left):.0f} "
            "% less misfit, but none brings it. Is each gage wired as its number says, and is the "
            "design near to the finger?"
        )
    fit = _fitted(problem, x, dead, alive, model.curves())
    _refuse_another(fit, np.minimum(x - problem.least, problem.most - x) < 1e-6)
    return fit


def _refuse_another(fit: LatentFit, stopped: BoolArray) -> None:
    """Raise SolverError where a modulus goes no further, and much is left."""
    moduli = np.array(["modulus" in each.kind for each in fit.latents])
    if fit.misfit > _ANOTHER**2 and (moduli & stopped).any():
        raise SolverError(
            "no finger near the design explains the bench: a modulus ends at its limit, and "
            f"{fit.misfit**0.5:.0f} times what noise and mesh explain is left. Are forces in N? "
            "Is it this design's bench?"
        )


def _least_squares(problem: _Problem, x: Array, most: int) -> tuple[Array, float]:
    """Gauss-Newton steps from x within bounds, at most ``most``: x, and by how much squares would
    fall by a further step. Steps end where that is less than the share ``_ENOUGH``.

    A step is halved until squares fall: plates may overlap on the way.
    """
    left, fall = problem.residual(x), 0.0
    for number in range(most + 1):
        jacobian = problem.jacobian(x)
        step = lsq_linear(jacobian, -left, (problem.least - x, problem.most - x)).x
        fall = float(left @ left - np.sum((left + jacobian @ step) ** 2))
        if fall < _ENOUGH * float(left @ left) or number == most:
            break
        for _ in range(_HALVINGS):
            there = problem.settled(x + step)
            now = problem.residual(there)
            if now @ now < left @ left:
                break
            step *= 0.5
        else:
            break
        x, left = there, now
    return x, fall


def _bounds(design: Design, latents: Sequence[Latent]) -> tuple[Array, Array]:
    """The least and the largest latents, in deviations."""
    most = np.full(len(latents), _REACH)
    least = -most
    for k, each in enumerate(latents):
        if each.kind == "poisson":
            room = MOST_POISSON - design.material_of("body").poissons_ratio
            most[k] = max(room / each.deviation, 1e-3)
        if each.kind == "lean":
            most[k] = MOST_LEAN_DEG / each.deviation
            least[k] = -most[k]
    return least, most


def _fitted(
    problem: _Problem, x: Array, dead: tuple[int, ...], alive: BoolArray, level: BenchCurves
) -> LatentFit:
    """level: the design's curves on a level bench."""
    data = problem.data
    jacobian = problem.jacobian(x)[: -len(x)]
    left = problem.residual(x)
    count = int(np.isfinite(data.strain_deviation).sum()) + len(data.scalar)
    misfit = float(left @ left) / count  # The prior adds as many rows as there are latents.
    covariance = np.linalg.inv(jacobian.T @ jacobian / max(1.0, misfit) + np.eye(len(x)))

    def rms(strain: Array) -> Array:
        return np.asarray(np.sqrt(np.mean(strain[: data.where.readings] ** 2, axis=0)))

    before = rms(data.where.of(level)[0] - data.strain)
    after = rms(problem.off(x)[0])
    values = x * problem.scale
    own = BEYOND[problem.model.fidelity]
    beyond = np.array([own.get(each.kind, 0.0) for each in problem.latents])
    deviations = np.hypot(np.sqrt(np.diag(covariance)) * problem.scale, beyond)
    return LatentFit(
        latents=tuple(problem.latents),
        values=values,
        deviations=np.minimum(deviations, problem.scale),
        before=float(np.sqrt(np.mean(before[alive] ** 2))),
        after=float(np.sqrt(np.mean(after[alive] ** 2))),
        gages_after=after,
        misfit=misfit,
        dead=dead,
        design=with_latents(problem.model.design, problem.latents, values),
        curves=problem.curves(x),
    )
