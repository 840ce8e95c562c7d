"""Rubber with a memory: contact forces by a Prony series, step by step (numpy only).

All moduli of a finger being relaxed alike, by R of the time since, with Poisson's ratio constant,

    R(t) = 1 - sum_i g_i (1 - exp(-t / T_i)),        f(t) = integral R(t - s) df_e(s),

where f are the contact forces and f_e those that unrelaxed rubber would need for the same surface
displacement, u = C f_e (the correspondence principle; for contacts that grow, where f_e is the
elastic answer itself: Lee and Radok, J. Appl. Mech. 27 (1960) 438; Graham, Int. J. Eng. Sci. 3
(1965) 27). Over a control step h in which f_e moves evenly, with q_i = integral
exp(-(t - s) / T_i) df_e(s) and d_i = exp(-h / T_i), c_i = T_i (1 - d_i) / h, exactly

    q_i <- d_i q_i + c_i df_e,        f = (1 - sum g_i) f_e + sum g_i q_i = A df_e + f_left,
    A = 1 - sum g_i (1 - c_i),        f_left = (1 - sum g_i) f_e + sum g_i d_i q_i  (before).

So of one step the unknown f enters as of elastic rubber that was displaced before:

    u = C f / A + lag,        lag = C (f_e - f_left / A),

and contact, stick and slip are those of the true forces: Signorini's and Coulomb's laws do not mind
the factor A; other laws of friction, which have a pressure of their own, do. The contact need not
grow: where it shrinks, the dent left behind recovers in time. What is approximate is the step: the
laws hold at its end.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.problem import ContactProblem


@dataclass(frozen=True)
class Rubber:
    """shares g_i and times T_i (s) of the Prony series; step h of the moves, s. Raises ValueError
    where the shares are not over 0 and below 1 together, or a time is not."""

    shares: tuple[float, ...]
    times: tuple[float, ...]
    step: float

    def __post_init__(self) -> None:
        sound = len(self.shares) == len(self.times) and sum(self.shares) < 1.0
        if not (sound and all(value > 0.0 for value in (*self.shares, *self.times, self.step))):
            raise ValueError("shares and times must be over 0, and the shares' sum below 1")

    @cached_property
    def fading(self) -> Array:
        """d_i (k,)."""
        return np.exp(-self.step / np.array(self.times))

    @cached_property
    def taken(self) -> Array:
        """c_i (k,): of an even change over a step, what its parts hold at its end."""
        ratio = self.step / np.array(self.times)
        return np.asarray(-np.expm1(-ratio) / ratio)

    @cached_property
    def relaxation_factor(self) -> float:
        """A: force at a step's end over the elastic force of an even change in it."""
        return float(1.0 - np.array(self.shares) @ (1.0 - self.taken))

    def left(self, seconds: float) -> float:
        """R: what is left of a force so long after it came at once."""
        faded = -np.expm1(-seconds / np.array(self.times))
        return float(1.0 - np.array(self.shares) @ faded)


class RubberHistory:
    """The history of the rubber at one contact; multipliers (m, dim) N as a problem has them."""

    def __init__(self, rubber: Rubber, problem: ContactProblem) -> None:
        self.rubber = rubber
        self._problem = problem
        self._elastic = np.zeros(problem.shape)  # f_e
        self._parts = np.zeros((len(rubber.shares), *problem.shape))  # q_i
        self._left: tuple[Rubber, Array] | None = None  # ``rest`` of this step, and whose

    @property
    def rest(self) -> Array:
        """f_left / A (m, dim): the step's forces, over A, were nothing displaced in it."""
        rubber = self.rubber
        if self._left is None or self._left[0] is not rubber:
            shares = np.array(rubber.shares)
            faded = (shares * rubber.fading) @ self._parts.reshape(len(shares), -1)
            left = (1.0 - shares.sum()) * self._elastic + faded.reshape(self._elastic.shape)
            self._left = rubber, left / rubber.relaxation_factor
        return self._left[1]

    @property
    def rest_force(self) -> Array:
        """The same in x, y(, z)."""
        return self._problem.to_global(self.rest)

    @property
    def lag(self) -> Array:
        """Displacement of the surface (m, dim) in addition to C f / A, mm."""
        moved = self._problem.compliance @ (self._elastic - self.rest).reshape(-1)
        return np.asarray(moved.reshape(self._problem.shape))

    def record(self, multiplier: Array) -> None:
        """A step is over, its forces over A being ``multiplier``."""
        change = multiplier - self.rest
        rubber = self.rubber
        faded = rubber.fading[:, None, None] * self._parts
        self._parts = faded + rubber.taken[:, None, None] * change
        self._elastic = self._elastic + change
        self._left = None
