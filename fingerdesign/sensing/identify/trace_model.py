"""A finger's model along a recorded trace: channels, residuals and their derivatives.

    F(t) = s R[mu, touch; g_i, T_i](t),        gage_j(t) = k_j e_j(t) + o_j + d_j t + c_j (T - T_0)

R: forces of the finger as it is condensed, with friction and the rubber's memory; e_j: its readings
at these forces. A modulus s times as large scales forces alone at the same moves, as far as plates
are stiff compared with the rubber. The linear unknowns (k, o, d, c) are projected out of the least
squares (G. Golub and V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413).
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache, partial

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.increment import solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.control.trace import Trace
from fingerdesign.sensing.identify.trace_path import Points, TracePath, played
from fingerdesign.shapes.friction import FrictionLaw

_LEAST_NOISE = 1e-6  # The least noise of a channel, over its greatest value.
_CACHED = 40  # So many answers are cached; a derivative and its steps need the same ones.

Terms = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Unknown:
    """An unknown of the iteration. kind: modulus, friction and time by their logarithms, touch in
    mm, share of the Prony series, exponent of friction (the last one, where it is unknown)."""

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

    x (n,): the unknowns, some as logarithms.
    """

    def __init__(self, problem: ContactProblem, face: str, path: TracePath, noise: Array) -> None:
        """noise (2 + g,): standard deviations of one sample, N and microstrain."""
        self._problem, self._face, self.path = problem, face, path
        self.noise = noise
        self._noise = noise[None, :] / np.sqrt(path.samples[:, None])
        self._solved = lru_cache(_CACHED)(partial(self._played, path))
        self._thinned = np.zeros(())  # The answers of all rows less those of the points.
        self.data = np.column_stack([path.forces, path.readings])

    def answers(self, x: Array) -> Array:
        """The model's channels, (k, 2 + g), before gains and offsets."""
        return np.asarray(np.exp(x[0]) * (self._solved(*x[1:].tolist()) + self._thinned))

    def _played(self, path: TracePath, friction: float, touch: float, *memory: float) -> Array:
        exponent = memory[-1] if len(memory) % 2 else 0.0
        pairs = zip(memory[::2], memory[1::2], strict=False)  # without the exponent
        terms = [(share, float(np.exp(time))) for share, time in pairs]
        law = FrictionLaw(float(np.exp(friction)), exponent=exponent, reference=self.pressure)
        problem = self._problem.with_friction(law)
        return played(problem, self._face, path, terms, touch)

    @cached_property
    def pressure(self) -> float:
        """Mean pressure, MPa, of a press to the mean depth of the path: p0 of the friction law. Any
        number would do: near the trace's own pressures, mu and the exponent are least related."""
        depth, problem = float(self.path.approach.mean()), self._problem
        start = ContactState.untouched(problem)
        force = solve_increment(problem, start, Motion(depth, 0.0)).multiplier[:, 0]
        return float(force.sum() / problem.model.areas[force > 0.0].sum()) if force.any() else 1.0

    def correct(self, x: Array, trace: Trace) -> None:
        """Add to all later answers the difference of every row, played at x, from the points."""
        every = self._played(TracePath.every(trace), *x[1:].tolist())
        self._thinned = Points(trace).mean(every) - self._solved(*x[1:].tolist())

    def along(self, path: TracePath) -> "TraceModel":
        """The same finger along another path."""
        return TraceModel(self._problem, self._face, path, self.noise)

    @cached_property
    def drifts(self) -> Array:
        """Readings that are not strain of the finger, (k, b): a constant, time, temperature."""
        time = self.path.time - self.path.time[0]
        columns = [np.ones_like(time), time]
        if self.path.temperature is not None and np.ptp(self.path.temperature) > 0.0:
            columns.append(self.path.temperature - self.path.temperature[0])
        return np.column_stack(columns)

    def linear(self, answers: Array) -> Array:
        """Gain, offset, drift(, per kelvin) of each gage (g, 1 + b) by least squares."""
        found = []
        for j in range(2, answers.shape[1]):
            own = np.column_stack([answers[:, j], self.drifts]) / self._noise[:, j : j + 1]
            found.append(np.linalg.lstsq(own, self.data[:, j] / self._noise[:, j], rcond=None)[0])
        return np.array(found).reshape(-1, 1 + self.drifts.shape[1])

    def fitted(self, x: Array) -> Array:
        """The model's channels, (k, 2 + g), with gains and offsets."""
        answers = self.answers(x)
        return self._with_linear(answers, self.linear(answers))

    def _with_linear(self, answers: Array, linear: Array) -> Array:
        shown = answers.copy()
        shown[:, 2:] = answers[:, 2:] * linear[:, 0] + self.drifts @ linear[:, 1:].T
        return shown

    def residuals(self, x: Array) -> Array:
        """(k (2 + g),), channel by channel."""
        return np.asarray(((self.fitted(x) - self.data) / self._noise).T.reshape(-1))

    def jacobian(self, x: Array, steps: Array) -> Array:
        """The Jacobian of the residuals, gains and offsets following, (k (2 + g), n)."""
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
            own = np.column_stack([base[:, 2 + gage], self.drifts])
            at = count + gage * width
            whole[:, 2 + gage, at : at + width] = own / self._noise[:, 2 + gage : 3 + gage]
        flat = whole.reshape(-1, whole.shape[2])
        return np.asarray(flat.T @ flat)


def noise_of(trace: Trace) -> Array:
    """Standard deviation of one sample of each channel, (2 + g,), by second differences.

    They are 0 for values that are even over three rows; white noise of deviation s leaves 6 s^2.
    """
    data = np.column_stack([trace.normal_force, trace.tangential_force, trace.readings])
    bends = data[2:] - 2.0 * data[1:-1] + data[:-2]
    # The median leaves out the starts and stops of the stage, which are no noise.
    found = np.median(np.abs(bends), axis=0) / (0.6745 * np.sqrt(6.0))
    return np.asarray(np.maximum(found, _LEAST_NOISE * np.abs(data).max(axis=0) + 1e-12))
