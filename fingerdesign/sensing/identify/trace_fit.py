"""Rubber, friction and gages from one recorded trace: least squares and its covariance.

A trace of a press, a shear and a hold is compared, point by point, with the finger's model along
its moves (trace_model.py). The finger is condensed again with the modulus found until that changes
no more. Standard deviations are those of all unknowns together, from the noise of the trace itself,
and widened by the misfit.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from fingerdesign.arrays import Array
from fingerdesign.checks.load import with_values
from fingerdesign.control.trace import Trace
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.runtime.progress import Report
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing.identify.trace_model import Terms, TraceModel, Unknown, noise_of
from fingerdesign.sensing.identify.trace_path import TracePath
from fingerdesign.sensing.model import grip_problem

MOST_TERMS = 2  # The most terms of the Prony series.
_STEPS = {"modulus": 1e-4, "friction": 1e-3, "touch": 1e-5, "share": 1e-4, "time": 1e-3}
_STEPS |= {"exponent": 1e-2}
_SLIPS = 0.05  # Deviation of the friction's logarithm over which the trace hardly slips.
_MOST_EXPONENT = 0.98  # At 1 the bound is a constant strength.
_SAME = 2e-4  # A larger change of the modulus condenses the finger again.
_NEARLY = 10.0  # Below so many times that change, every row is played.
_ROUNDS = 8
_TOUCH = 0.15  # The touch may be off by this fraction of the deepest approach.
# Standard deviations before any measurement: of logarithms, of the touch over the deepest approach,
# of shares and gains; of offsets, drifts and temperature, microstrain.
_BEFORE = {"modulus": 1.0, "friction": 1.0, "touch": 0.1, "share": 0.3, "time": 3.0}
_BEFORE |= {"gain": 0.5, "drift": 1e4, "exponent": 1.0}
# A term must lower the squares by so many times the logarithm of the number of data.
_TERM = 2.0
_TIMES, _SMALL = 9, 1e-3  # Times to try for a further term, with this share.
_CORRECTED = 2  # Answers are corrected so often for rows that are left out.
_EVALUATIONS, _ROUGHLY = 100, 30
# With the modulus far off, a term must bring the squares below this fraction.
_FAR_GAIN = 0.5
_EXCHANGED = 0.1  # A force that rises with so little closing a shear rises with the other column.
_LASTS_S = (1.0, 1e4)  # A trace takes a minute; 1000 times less or more is another unit of time.
_MODULUS = 8.0  # The modulus may be off by this factor, either way.


@dataclass(frozen=True)
class TraceFit:
    """The fit of a trace. x (n,) of the unknowns; linear (g, 1 + b); steps (n,) of derivatives;
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
    def restart(self) -> list[Unknown]:
        """The unknowns, with the found values as start."""
        pairs = zip(self.unknowns, self.x, strict=True)
        return [replace(each, start=float(value)) for each, value in pairs]

    @property
    def terms(self) -> Terms:
        """Shares and times (s) of the Prony series."""
        own = self.x[3:]
        return tuple((float(own[k]), float(np.exp(own[k + 1]))) for k in range(0, len(own) - 1, 2))

    def covariance(self, more: TracePath | None = None) -> Array:
        """Covariance of all unknowns, (n + g (1 + b),) squared; that along another path, if given.

        An unknown without data has its deviation before the measurement (:data:`_BEFORE`).
        """
        information = self.information
        if more is not None:
            other = self.model.along(more)
            information = other.information(self.x, self.steps, self.linear)
        units = {"touch": float(self.model.path.approach.max())}
        before = [_BEFORE[each.kind] * units.get(each.kind, 1.0) for each in self.unknowns]
        drifts = [_BEFORE["drift"]] * (self.linear.shape[1] - 1)
        before += [_BEFORE["gain"], *drifts] * len(self.linear)
        total = information / max(self.misfit, 1.0) + np.diag(np.array(before) ** -2.0)
        scale = np.sqrt(np.diag(total))
        return np.asarray(np.linalg.inv(total / np.outer(scale, scale)) / np.outer(scale, scale))

    @cached_property
    def deviations(self) -> Array:
        """Standard deviations of all, (n + g (1 + b),)."""
        return np.asarray(np.sqrt(np.diag(self.covariance())))


def fit_trace(
    model: TraceModel, trace: Trace, terms: int | None, rough: bool, report: Report
) -> TraceFit:
    """Fit the trace with as many Prony terms as Schwarz's criterion selects, or with ``terms``.

    rough: the modulus may be far off: the points alone, a few evaluations, and at most one term,
    which must remove much of the misfit: a wrong modulus looks like a term of relaxation. Raises
    SolverError where none converges.
    """
    report("fitting without relaxation")
    best = _fit(model, _unknowns(model), rough)
    if rough:
        found = None if terms == 0 else _with_term(best, terms is not None, True, report)
        return best if found is None or found.misfit >= _FAR_GAIN * best.misfit else found
    for _ in range(1 if terms is None else terms):
        found = _with_term(best, terms is not None, False, report)
        if found is None or (terms is None and found.bic >= best.bic):
            break
        best = found
    return _corrected(best, trace, report)


def _refitted(
    model: TraceModel, start: TraceFit, trace: Trace, terms: int | None, report: Report
) -> TraceFit:
    """The fit on another model, begun at an earlier fit of nearly this modulus, whose terms stay
    unless fewer or more fit better."""
    best = _fit(model, start.restart)
    if terms is not None:
        return _corrected(best, trace, report)
    if not _is_near(best):
        return _fewer(best)
    best = _fewer(_corrected(best, trace, report))
    more = None if len(best.terms) == MOST_TERMS else _with_term(best, False, False, report)
    return best if more is None or more.bic >= best.bic else more


def _is_near(fit: TraceFit) -> bool:
    """True if the modulus is nearly the model's: another one, and rows that are left out, look like
    terms of relaxation."""
    return bool(abs(fit.x[0]) <= _NEARLY * _SAME)


def _with_term(fit: TraceFit, required: bool, rough: bool, report: Report) -> TraceFit | None:
    """The fit with one term more; None where the trace shows none, unless it is ``required``."""
    number = len(fit.terms) + 1
    term, gain = _next_term(fit, number)
    if not required and gain < _TERM * np.log(fit.model.data.size):
        return None
    report(f"fitting {number} term{'' if number == 1 else 's'} of relaxation")
    return _fit(fit.model, [*fit.restart, *term], rough)


def _fewer(fit: TraceFit) -> TraceFit:
    """The fit with as many terms as it needs (Schwarz's criterion)."""
    while fit.terms:
        fewer = _fit(fit.model, fit.restart[:-2])
        if fewer.bic >= fit.bic:
            break
        fit = fewer
    return fit


def _next_term(fit: TraceFit, number: int) -> tuple[list[Unknown], float]:
    """The best next term, and the fall of the squares that it promises (a score test)."""
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
    start, low, high = (float(np.log(each)) for each in (time, least, most))
    term = [
        Unknown(f"share_{number}", "share", float(np.clip(share, 0.01, 0.3)), 1e-5, 0.45),
        Unknown(f"time_{number}", "time", start, low, high),
    ]
    return term, gain


def _corrected(fit: TraceFit, trace: Trace, report: Report = lambda message: None) -> TraceFit:
    """The fit to answers of every row, where the modulus is nearly the model's: thinning changes
    answers by 1e-4."""
    if not _is_near(fit):
        return fit
    report("playing every row")
    for _ in range(_CORRECTED):
        fit.model.correct(fit.x, trace)
        fit = _fit(fit.model, fit.restart)
    return fit


def _unknowns(model: TraceModel) -> list[Unknown]:
    """All but the relaxation."""
    normal, tangential = model.path.forces.T
    pressed = normal > 0.1 * normal.max()
    utilisation = float(np.abs(tangential[pressed] / normal[pressed]).max())
    deepest = float(model.path.approach.max())
    friction = float(np.log(np.clip(1.1 * utilisation, 0.05, 3.0)))
    return [
        Unknown("modulus", "modulus", 0.0, -np.log(_MODULUS), np.log(_MODULUS)),
        Unknown("friction", "friction", friction, float(np.log(0.02)), float(np.log(6.0))),
        Unknown("touch", "touch", 0.0, -_TOUCH * deepest, _TOUCH * deepest),
    ]


def _fit(model: TraceModel, unknowns: Sequence[Unknown], rough: bool = False) -> TraceFit:
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
    x = np.asarray(found.x)
    terms = x[3 : 3 + (len(x) - 3) // 2 * 2].reshape(-1, 2)
    terms[:] = terms[np.argsort(terms[:, 1])]  # The quick one first: all have the same bounds.
    linear = model.linear(model.answers(x))
    steps = np.where(x + steps > high, -steps, steps)
    information = model.information(x, steps, linear)
    count = model.data.size - len(information)
    misfit = float(2.0 * found.cost / max(count, 1))
    bic = 2.0 * found.cost + len(information) * np.log(model.data.size)
    return TraceFit(tuple(unknowns), x, linear, steps, information, misfit, model, float(bic))


@dataclass(frozen=True)
class Identified:
    """A finger with the values from a trace. design: with the modulus found; fit: of its own
    model, so the modulus over the design's is exp(x[0]), next to 1. exponent: of friction by
    pressure, and its standard deviation; part of the fit where the trace supports it."""

    design: Design
    given: Design
    trace: Trace
    fit: TraceFit
    fidelity: str
    exponent: tuple[float, float]


def identified(
    design: Design,
    trace: Trace,
    source: str,
    fidelity: str = "plane-strain",
    terms: int | None = None,
    report: Report = lambda message: None,
) -> Identified:
    """Fit modulus, relaxation, friction and gages of a finger to one trace.

    Raises DesignError for a trace that cannot give a modulus, before any work; SolverError where
    the fit does not converge.
    """
    _refuse(design, trace, source, report)
    own = design
    fit: TraceFit | None = None
    for number in range(_ROUNDS):
        report("condensing the finger")
        model = _model_of(own, trace, fidelity)
        with one_thread():
            if fit is not None and number > 1:
                fit = _refitted(model, fit, trace, terms, report)
            else:
                fit = fit_trace(model, trace, terms, number == 0, report)
        if number == 1 and abs(fit.x[0]) > np.log(_MODULUS) - 1e-3:
            raise SolverError(
                f"the modulus would be over {_MODULUS**2:g} times as large or as small as the "
                "design's: are forces in N, and moves in mm? Is it this design's finger?"
            )
        if number > 1 and abs(fit.x[0]) < _SAME:  # The first two fits may lack a term.
            break
        own = _with_modulus(own, fit)
    assert fit is not None
    if fit.deviations[1] > _SLIPS:
        return Identified(own, design, trace, fit, fidelity, (0.0, _BEFORE["exponent"]))
    report("fitting the friction's dependence on pressure")
    with one_thread():
        law = with_exponent(fit)
    if law.bic < fit.bic:  # Coulomb's law was wrong, and with it the modulus.
        own, fit = _with_law(own, law, trace, fidelity)
        law = fit
    exponent = float(law.x[-1]), float(law.deviations[len(law.x) - 1])
    return Identified(own, design, trace, fit, fidelity, exponent)


def _refuse(design: Design, trace: Trace, source: str, report: Report) -> None:
    """Raise DesignError for a trace that cannot give a modulus; report what is doubtful in it."""
    faults = list(trace_faults(design, trace))
    if faults:
        raise DesignError(faults, source)
    for words in time_doubts(trace):
        report(f"warning: {words}")


def _model_of(design: Design, trace: Trace, fidelity: str) -> TraceModel:
    problem = grip_problem(design, fidelity)
    return TraceModel(problem, design.gages.face, TracePath.of(trace), noise_of(trace))


def _with_law(
    design: Design, fit: TraceFit, trace: Trace, fidelity: str
) -> tuple[Design, TraceFit]:
    """The finger condensed again, and the fit to it, until the modulus changes no more."""
    for _ in range(_ROUNDS):
        design = _with_modulus(design, fit)
        model = _model_of(design, trace, fidelity)
        with one_thread():
            fit = _corrected(_fit(model, fit.restart), trace)
        if abs(fit.x[0]) < _SAME:
            break
    return design, fit


def _with_modulus(design: Design, fit: TraceFit) -> Design:
    """The design with the modulus that a fit of its own model finds."""
    modulus = design.material_of("body").youngs_modulus_MPa * float(np.exp(fit.x[0]))
    return with_values(design, {f"materials.{design.body.material}.youngs_modulus_MPa": modulus})


def with_exponent(fit: TraceFit) -> TraceFit:
    """The fit with a friction coefficient mu (p / p0)^-n, n unknown, p0 = ``fit.model.pressure``.

    n = 0 is Coulomb's law, n near 1 a constant strength of the interface. While rubber relaxes, p
    is the pressure before it did: that moves mu, and n hardly.
    """
    exponent = Unknown("friction_exponent", "exponent", 0.1, 0.0, _MOST_EXPONENT)
    return _fit(fit.model, [*fit.restart, exponent])


def time_doubts(trace: Trace) -> Iterator[str]:
    """Ask whether times are in seconds, where a trace is shorter or longer than a hand takes."""
    lasts = float(trace.time[-1] - trace.time[0])
    if not _LASTS_S[0] <= lasts <= _LASTS_S[1]:
        yield f"the trace lasts {lasts:.3g} s: is time_s in seconds? times of relaxation follow it"


def trace_faults(design: Design, trace: Trace) -> Iterator[Fault]:
    """Faults of a trace that gives no information about the rubber."""
    deepest, most = float(np.cumsum(trace.dy).max()), design.grip.max_approach_mm
    normal = trace.normal_force
    rise = slice(1, int(np.argmax(normal >= 0.5 * normal.max())) + 1)
    closed, sheared = (float(np.abs(each[rise]).sum()) for each in (trace.dy, trace.dx))
    if closed < _EXCHANGED * sheared and normal[0] < 0.25 * normal.max():
        bound, remedy = "what presses", "are dx_mm and dy_mm exchanged? dy_mm closes"
        found = f"{closed:.3g} mm, and dx_mm {sheared:.3g} mm, while the normal force rises"
        yield Fault("trace, column dy_mm", found, bound, remedy)
    elif not deepest > 0.0:
        remedy = "closing is positive: record from the first touch on"
        yield Fault("trace, column dy_mm", f"{deepest:g} mm in all", "over 0", remedy)
    elif deepest > most * 1.05:
        remedy = "cut the trace there, or raise it; are these positions? a row has its own move"
        bound = f"at most grip.max_approach_mm = {most:g}"
        yield Fault("trace, column dy_mm", f"{deepest:g} mm in all", bound, remedy)
    if not trace.normal_force.max() > 20.0 * noise_of(trace)[0]:
        bound = "twenty times its noise somewhere"
        most_force = f"{trace.normal_force.max():.3g} N at the most"
        yield Fault("trace, column normal_force_N", most_force, bound, "press deeper")
    pulled, noise = trace.tangential_force, noise_of(trace)[1]
    if np.abs(pulled).max() > 20.0 * noise and np.cumsum(trace.dx) @ pulled < 0.0:
        key, bound = "trace, column tangential_force_N", "positive where dx_mm shears toward +x"
        yield Fault(key, "the other way", bound, "turn the sign of the force, or of dx_mm")
    if len(TracePath.of(trace).time) < 12:
        bound = "at least 12 points that move or rest"
        yield Fault("trace", f"{len(trace)} rows", bound, "record the way down, not its end alone")
