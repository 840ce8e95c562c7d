"""``fingerdesign identify``: the user's own rubber, friction and gages, from one recorded trace.

    found = identified(design, read_trace("press.csv"), "press.csv")
    write_identification(found, "press.csv", folder)     # identify_page.py: record, design, page

A trace of a press, a shear and a hold is compared, point by point, with what the finger's model
answers along its moves:

    F(t) = s R[mu, touch; g_i, T_i](t),        gage_j(t) = k_j e_j(t) + o_j + d_j t + c_j (T - T_0)

R: forces of the finger as it is condensed, friction and the rubber's memory in it; e_j: its
readings at the forces found. A modulus s times as large scales forces alone at the same moves, as
far as plates are stiff beside the rubber: so the finger is condensed anew with the modulus found
until that moves no more. What enters linearly (k, o, d, c) is projected out of the least squares
(G. Golub and V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413); standard deviations are those of all
unknowns together, from the noise that the trace itself shows, and wider by what the model leaves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.sensing.identify.trace_path import Points, TracePath, played

if TYPE_CHECKING:
    from fingerdesign.contact.problem import ContactProblem
    from fingerdesign.control.trace import Trace
    from fingerdesign.design.schema import Design

MOST_TERMS = 2  # of the Prony series
_STEPS = {"modulus": 1e-4, "friction": 1e-3, "touch": 1e-5, "share": 1e-4, "time": 1e-3}
_SAME = 2e-4  # of the modulus: the finger is condensed anew for more
_NEARLY = 10.0  # times that: every row is worth playing
_ROUNDS = 8
_LEAST_NOISE = 1e-6  # of a channel's greatest value
_TOUCH = 0.15  # of the deepest approach: how far the touch may be off
# Standard deviations before any measurement: of logarithms, of the deepest approach, of shares, of
# gains; of offsets, drifts and what a kelvin does, microstrain.
_BEFORE = {"modulus": 1.0, "friction": 1.0, "touch": 0.1, "share": 0.3, "time": 3.0}
_BEFORE |= {"gain": 0.5, "beside": 1e4}
_KEPT = 40  # answers; a derivative and its steps ask for the same ones
_TERM = 2.0  # times the logarithm of the number of data, by which a term must lessen the squares
_TIMES, _SMALL = 9, 1e-3  # times that are tried for a further term, with so small a share
_CORRECTED = 2  # times that answers are corrected for rows left out
_EVALUATIONS, _ROUGHLY = 100, 30
_TOLD = 0.5  # of the squares: with the modulus far off, a term that leaves more mends that alone
_MODULUS = 8.0  # how many times off it may be, either way

Terms = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Unknown:
    """What is looked for by iteration. kind: modulus and friction and time by their logarithms,
    touch in mm, share of the Prony series."""

    name: str
    kind: str
    start: float
    low: float
    high: float

    @property
    def by_logarithm(self) -> bool:
        return self.kind in ("modulus", "friction", "time")


class TraceModel:
    """A finger's model along a trace: residuals, in noise's standard deviations, and derivatives.

    x (n,): the unknowns, logarithms where they are looked for so.
    """

    def __init__(self, problem: ContactProblem, face: str, path: TracePath, noise: Array) -> None:
        """noise (2 + g,): standard deviations of one sample, N and microstrain."""
        self._problem, self._face, self.path = problem, face, path
        self.noise = noise
        self._noise = noise[None, :] / np.sqrt(path.samples[:, None])
        self._known: dict[tuple[float, ...], Array] = {}
        self._thinned = np.zeros(0)  # by so much every row's answers differ from the points'
        self.data = np.column_stack([path.forces, path.readings])

    def answers(self, x: Array) -> Array:
        """Of the model, (k, 2 + g), before gains and offsets."""
        key = tuple(float(value) for value in x[1:])
        if key not in self._known:
            if len(self._known) > _KEPT:
                self._known.clear()
            self._known[key] = self._played(x, self.path)
        found = self._known[key]
        return np.asarray(np.exp(x[0]) * (found + self._thinned if self._thinned.size else found))

    def _played(self, x: Array, path: TracePath) -> Array:
        friction, touch, *memory = (float(value) for value in x[1:])
        terms = [
            (share, float(np.exp(time))) for share, time in zip(*[iter(memory)] * 2, strict=True)
        ]
        problem = self._problem.with_friction(float(np.exp(friction)))
        return played(problem, self._face, path, terms, touch)

    def correct(self, x: Array, trace: Trace) -> None:
        """From now on answers hold what every row, played at x, differs by from the points."""
        own = Points.of(trace).mean(self._played(x, TracePath.every(trace)))
        self._thinned = own - self._played(x, self.path)

    def along(self, path: TracePath) -> TraceModel:
        """The same finger along another path."""
        return TraceModel(self._problem, self._face, path, self.noise)

    @cached_property
    def beside(self) -> Array:
        """What a gage reads beside the finger's strain, (k, b): a constant, time, temperature."""
        time = self.path.time - self.path.time[0]
        columns = [np.ones_like(time), time]
        if self.path.temperature is not None and np.ptp(self.path.temperature) > 0.0:
            columns.append(self.path.temperature - self.path.temperature[0])
        return np.column_stack(columns)

    def linear(self, answers: Array) -> Array:
        """Gain, offset, drift(, per kelvin) of each gage (g, 1 + b) that fit best."""
        found = []
        for j in range(2, answers.shape[1]):
            own = np.column_stack([answers[:, j], self.beside]) / self._noise[:, j : j + 1]
            found.append(np.linalg.lstsq(own, self.data[:, j] / self._noise[:, j], rcond=None)[0])
        return np.array(found).reshape(-1, 1 + self.beside.shape[1])

    def fitted(self, x: Array) -> Array:
        """What the model says of each channel, (k, 2 + g), gains and offsets in it."""
        answers = self.answers(x)
        return self._with_linear(answers, self.linear(answers))

    def _with_linear(self, answers: Array, linear: Array) -> Array:
        shown = answers.copy()
        shown[:, 2:] = answers[:, 2:] * linear[:, 0] + self.beside @ linear[:, 1:].T
        return shown

    def residuals(self, x: Array) -> Array:
        """(k (2 + g),), channel by channel."""
        return np.asarray(((self.fitted(x) - self.data) / self._noise).T.reshape(-1))

    def jacobian(self, x: Array, steps: Array) -> Array:
        """Of the residuals with gains and offsets following, (k (2 + g), n)."""
        base = self.residuals(x)
        return np.column_stack(
            [(self.residuals(x + step) - base) / step.sum() for step in np.diag(steps)]
        )

    def information(self, x: Array, steps: Array, linear: Array) -> Array:
        """J^T J of all unknowns, those of the gages after the others: gage by gage."""
        base = self.answers(x)
        shown = self._with_linear(base, linear)
        moved = [self._with_linear(self.answers(x + step), linear) for step in np.diag(steps)]
        slopes = [(each - shown) / step for each, step in zip(moved, steps, strict=True)]
        count, width = len(x), linear.shape[1]
        whole = np.zeros((*shown.shape, count + linear.size))
        for j, slope in enumerate(slopes):
            whole[:, :, j] = slope / self._noise
        for gage in range(len(linear)):
            own = np.column_stack([base[:, 2 + gage], self.beside])
            at = count + gage * width
            whole[:, 2 + gage, at : at + width] = own / self._noise[:, 2 + gage : 3 + gage]
        flat = whole.reshape(-1, whole.shape[2])
        return np.asarray(flat.T @ flat)


@dataclass(frozen=True)
class TraceFit:
    """What a trace says. x (n,) of the unknowns; linear (g, 1 + b); steps (n,) of derivatives;
    information of all unknowns, as :meth:`TraceModel.information` has it; misfit: squares left over
    those of the noise; bic: Schwarz's criterion."""

    unknowns: tuple[Unknown, ...]
    x: Array
    linear: Array
    steps: Array
    information: Array
    misfit: float
    model: TraceModel
    bic: float

    @property
    def again(self) -> list[Unknown]:
        """The unknowns, to start from what was found."""
        pairs = zip(self.unknowns, self.x, strict=True)
        return [replace(each, start=float(value)) for each, value in pairs]

    @property
    def terms(self) -> Terms:
        """Shares and times (s) of the Prony series."""
        own = self.x[3:]
        return tuple((float(own[k]), float(np.exp(own[k + 1]))) for k in range(0, len(own), 2))

    def covariance(self, more: TracePath | None = None) -> Array:
        """Of all unknowns, (n + g (1 + b),) squared: with another path instead, what it would be.

        What no datum speaks of keeps what is thought beforehand (:data:`_BEFORE`).
        """
        information = self.information
        if more is not None:
            other = self.model.along(more)
            information = other.information(self.x, self.steps, self.linear)
        deepest = float(self.model.path.approach.max())
        width = self.linear.shape[1]
        before = [_BEFORE[each.kind] for each in self.unknowns]
        before = [
            each * (deepest if u.kind == "touch" else 1.0)
            for each, u in zip(before, self.unknowns, strict=True)
        ]
        before += [_BEFORE["gain"], *[_BEFORE["beside"]] * (width - 1)] * len(self.linear)
        told = information / max(self.misfit, 1.0) + np.diag(np.array(before) ** -2.0)
        scale = np.sqrt(np.diag(told))
        return np.asarray(np.linalg.inv(told / np.outer(scale, scale)) / np.outer(scale, scale))

    @cached_property
    def deviations(self) -> Array:
        """Standard deviations of all, (n + g (1 + b),)."""
        return np.asarray(np.sqrt(np.diag(self.covariance())))


def noise_of(trace: Trace) -> Array:
    """Standard deviation of one sample of each channel, (2 + g,), by second differences.

    What is even over three rows leaves nothing in them; white noise of deviation s leaves 6 s^2.
    """
    forces = np.column_stack([trace.normal_force, trace.tangential_force])
    data = np.column_stack([forces, trace.readings])
    bends = data[2:] - 2.0 * data[1:-1] + data[:-2]
    # By the median, for where the stage starts or stops is no noise.
    found = np.median(np.abs(bends), axis=0) / (0.6745 * np.sqrt(6.0))
    return np.asarray(np.maximum(found, _LEAST_NOISE * np.abs(data).max(axis=0) + 1e-12))


def fit_trace(
    problem: ContactProblem,
    face: str,
    trace: Trace,
    terms: int | None = None,
    start: TraceFit | None = None,
    rough: bool = False,
    report: Callable[[str], None] = lambda message: None,
) -> TraceFit:
    """The fit with the fewest Prony terms that the trace asks for (Schwarz's criterion), or so
    many of them.

    start: a fit at nearly this modulus, whose terms are kept unless fewer or more now do. rough:
    the modulus may be far off: no row but the points', as near as a few evaluations come, and at
    most one term, which must tell more than that modulus's own misfit: that bends one, and share,
    time and modulus then trade along a valley. Raises SolverError where none converges.
    """
    path = TracePath.of(trace)
    model = TraceModel(problem, face, path, noise_of(trace))
    if start is not None and not rough:
        best = _fit(model, start.again)
        if terms is not None:
            return _corrected(best, trace, report)
        if not _is_near(best):
            return _fewer(best)
        best = _fewer(_corrected(best, trace, report))
        more = None if len(best.terms) == MOST_TERMS else _with_term(best, False, False, report)
        return best if more is None or more.bic >= best.bic else more
    report("fitting without relaxation")
    best = _fit(model, _unknowns(model), rough)
    for _ in range(1 if terms is None else terms):
        found = _with_term(best, terms is not None, rough, report)
        if found is None:
            break
        if rough:
            return found if found.misfit < _TOLD * best.misfit else best
        if terms is None and found.bic >= best.bic:
            break
        best = found
    return best if rough else _corrected(best, trace, report)


def _is_near(fit: TraceFit) -> bool:
    """Whether the modulus is nearly the model's: another one, and rows left out, ask for terms of
    relaxation of their own."""
    return bool(abs(fit.x[0]) <= _NEARLY * _SAME)


def _with_term(
    fit: TraceFit, asked: bool, rough: bool, report: Callable[[str], None]
) -> TraceFit | None:
    """The fit with one term more; None where the trace shows none, unless it is ``asked`` for."""
    number = len(fit.terms) + 1
    term, gain = _next_term(fit)
    if not asked and gain < _TERM * np.log(fit.model.data.size):
        return None
    report(f"fitting {number} term{'' if number == 1 else 's'} of relaxation")
    return _fit(fit.model, [*fit.again, *term(number)], rough)


def _fewer(fit: TraceFit) -> TraceFit:
    """The fit with as many terms as it needs (Schwarz's criterion)."""
    while fit.terms:
        fewer = _fit(fit.model, fit.again[:-2])
        if fewer.bic >= fit.bic:
            break
        fit = fewer
    return fit


def _next_term(fit: TraceFit) -> tuple[Callable[[int], list[Unknown]], float]:
    """The term that a fit lacks most, and by how much its squares would fall (a score test)."""
    model, path = fit.model, fit.model.path
    least, most = 0.3 * float(path.steps.min()), 10.0 * float(path.time[-1] - path.time[0])
    left = model.residuals(fit.x)
    slopes, _ = np.linalg.qr(model.jacobian(fit.x, fit.steps))
    best = (0.0, 0.0, float(np.sqrt(least * most)))
    for time in np.geomspace(3.0 * least, 0.2 * most, _TIMES):
        more = np.append(fit.x, [_SMALL, np.log(time)])
        slope = (model.residuals(more) - left) / _SMALL
        slope -= slopes @ (slopes.T @ slope)
        along, square = float(slope @ left), float(slope @ slope)
        if along < 0.0 and along**2 / max(square, 1e-300) > best[0]:
            best = (along**2 / square, -along / square, float(time))
    gain, share, time = best

    def term(number: int) -> list[Unknown]:
        start = float(np.clip(share, 0.01, 0.3))
        ends = (float(np.log(least)), float(np.log(most)))
        return [
            Unknown(f"share_{number}", "share", start, 1e-5, 0.45),
            Unknown(f"time_{number}", "time", float(np.log(time)), *ends),
        ]

    return term, gain


def _corrected(
    fit: TraceFit, trace: Trace, report: Callable[[str], None] = lambda message: None
) -> TraceFit:
    """The fit to answers of every row, where the modulus is nearly the model's: what is left out of
    the points bends them by 1e-4."""
    if not _is_near(fit):
        return fit
    report("playing every row")
    for _ in range(_CORRECTED):
        fit.model.correct(fit.x, trace)
        fit = _fit(fit.model, fit.again)
    return fit


def _unknowns(model: TraceModel) -> list[Unknown]:
    """All but the relaxation."""
    normal, tangential = model.path.forces.T
    pressed = normal > 0.1 * normal.max()
    used = float(np.abs(tangential[pressed] / normal[pressed]).max())
    deepest = float(model.path.approach.max())
    friction = float(np.log(np.clip(1.1 * used, 0.05, 3.0)))
    return [
        Unknown("modulus", "modulus", 0.0, -np.log(_MODULUS), np.log(_MODULUS)),
        Unknown("friction", "friction", friction, float(np.log(0.02)), float(np.log(6.0))),
        Unknown("touch", "touch", 0.0, -_TOUCH * deepest, _TOUCH * deepest),
    ]


def _fit(model: TraceModel, unknowns: Sequence[Unknown], rough: bool = False) -> TraceFit:
    from scipy.optimize import least_squares

    steps = np.array([_STEPS[each.kind] for each in unknowns])
    low, high = (np.array([getattr(u, end) for u in unknowns]) for end in ("low", "high"))
    inside = 1e-6 * (high - low)
    start = np.clip([each.start for each in unknowns], low + inside, high - inside)
    found = least_squares(
        model.residuals,
        start,
        jac=lambda x: model.jacobian(x, np.where(x + steps > high, -steps, steps)),
        bounds=(low, high),
        x_scale=np.array([{"touch": 0.01, "share": 0.1}.get(u.kind, 0.3) for u in unknowns]),
        ftol=1e-6,
        xtol=1e-6,
        gtol=1e-7,
        max_nfev=_ROUGHLY if rough else _EVALUATIONS,
    )
    if found.status <= 0 and not rough:
        raise SolverError(
            f"the fit of the trace did not converge in {found.nfev} evaluations: give another "
            "modulus to start from in the design, or fewer --terms"
        )
    x = _quick_first(np.asarray(found.x))
    linear = model.linear(model.answers(x))
    steps = np.where(x + steps > high, -steps, steps)
    information = model.information(x, steps, linear)
    count = model.data.size - len(information)
    misfit = float(2.0 * found.cost / max(count, 1))
    bic = 2.0 * found.cost + len(information) * np.log(model.data.size)
    own = (information, misfit)
    return TraceFit(tuple(unknowns), x, linear, steps, *own, model, float(bic))


def _quick_first(x: Array) -> Array:
    """The same with its terms in the order of their times: all have the same bounds."""
    terms = x[3:].reshape(-1, 2)
    return np.concatenate([x[:3], terms[np.argsort(terms[:, 1])].reshape(-1)])


@dataclass(frozen=True)
class Identified:
    """A finger with the values that a trace tells. design: with the modulus found; fit: of its own
    model, so the modulus over the design's is exp(x[0]), next to 1."""

    design: Design
    given: Design
    trace: Trace
    fit: TraceFit
    fidelity: str


def identified(
    design: Design,
    trace: Trace,
    source: str,
    fidelity: str = "plane-strain",
    terms: int | None = None,
    report: Callable[[str], None] = lambda message: None,
) -> Identified:
    """Fit modulus, relaxation, friction and gages of a finger to one trace.

    Raises DesignError for a trace that cannot tell a modulus, before any work; SolverError where
    the fit does not converge.
    """
    from fingerdesign.analysis.stages import one_thread
    from fingerdesign.checks.load import with_values
    from fingerdesign.sensing.model import grip_problem

    faults = list(trace_faults(design, trace))
    if faults:
        raise DesignError(faults, source)
    material, own = design.body.material, design
    fit: TraceFit | None = None
    for number in range(_ROUNDS):
        report("condensing the finger")
        problem = grip_problem(own, fidelity)
        with one_thread():
            start = fit if number > 1 else None
            fit = fit_trace(problem, own.gages.face, trace, terms, start, number == 0, report)
        if number > 1 and abs(fit.x[0]) < _SAME:  # the first two may lack a term
            break
        modulus = own.materials[material].youngs_modulus_MPa * float(np.exp(fit.x[0]))
        own = with_values(own, {f"materials.{material}.youngs_modulus_MPa": modulus})
    assert fit is not None
    return Identified(own, design, trace, fit, fidelity)


def trace_faults(design: Design, trace: Trace) -> Iterator[Fault]:
    """What keeps a trace from telling anything of the rubber."""
    deepest, most = float(np.cumsum(trace.dy).max()), design.grip.max_approach_mm
    if not deepest > 0.0:
        remedy = "closing is positive: record from the first touch on"
        yield Fault("trace, column dy_mm", f"{deepest:g} mm in all", "over 0", remedy)
    elif deepest > most * 1.05:
        remedy = "cut the trace there, or raise it; are these positions? a row has its own move"
        bound = f"at most grip.max_approach_mm = {most:g}"
        yield Fault("trace, column dy_mm", f"{deepest:g} mm in all", bound, remedy)
    if not trace.normal_force.max() > 20.0 * noise_of(trace)[0]:
        bound = "twenty times its noise somewhere"
        said = f"{trace.normal_force.max():.3g} N at the most"
        yield Fault("trace, column normal_force_N", said, bound, "press deeper")
    pulled, noise = trace.tangential_force, noise_of(trace)[1]
    if np.abs(pulled).max() > 20.0 * noise and np.cumsum(trace.dx) @ pulled < 0.0:
        key, bound = "trace, column tangential_force_N", "positive where dx_mm shears toward +x"
        yield Fault(key, "the other way", bound, "turn the sign of the force, or of dx_mm")
    if len(TracePath.of(trace).time) < 12:
        bound = "at least 12 points that move or rest"
        yield Fault("trace", f"{len(trace)} rows", bound, "record the way down, not its end alone")
