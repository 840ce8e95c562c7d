"""An object that slides through the fingers: with what speed, how far, until when (numpy only).

Friction cannot carry the object, so the whole of both contacts slides. Over a control step the hand
moves evenly, and closes evenly, so that friction, 2 mu_k F_n, changes evenly; relative to the
fingers the object, of mass m, moves down by

    m a = W - friction,      a(t) = a_0 + (a_1 - a_0) t / T,
    v(t) = v_0 + a_0 t + (a_1 - a_0) t^2 / 2T,

integrated exactly. Where v comes back to zero it sticks: it is caught. W: the weight and what tugs.
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Inertia:
    """rate: moves a second; drop: mm that a slide goes before the object counts as dropped."""

    rate: float
    drop: float


def frequency(stiffness: float, mass_g: float) -> float:
    """Hz at which an object swings on fingers of so many N/mm along the shear.

    >>> round(frequency(40.0, 300.0), 1)
    58.1
    """
    return math.sqrt(1e6 * max(stiffness, 0.0) / mass_g) / (2.0 * math.pi)


@dataclass(frozen=True)
class Slid:
    """Over an interval: the way (mm), the speed at its end (mm/s), and when in it the object was
    caught (s), None: it still slides. waited: s before it began to."""

    way: float
    speed: float
    caught: float | None = None
    waited: float = 0.0


def slide(speed: float, first: float, last: float, seconds: float) -> Slid:
    """From ``speed`` (mm/s, down) under an acceleration from ``first`` to ``last`` (mm/s^2).

    An object at rest waits where it is held at first and not at last; an upward speed is none.

    >>> slide(10.0, -1000.0, -1000.0, 0.02)  # v^2 / 2a, after v / a
    Slid(way=0.05, speed=0.0, caught=0.01, waited=0.0)
    """
    change = (last - first) / seconds
    if speed <= 0.0:
        speed = 0.0
        if first <= 0.0 and last <= 0.0:
            return Slid(0.0, 0.0, 0.0)
        if first < 0.0:
            left = seconds + first / change
            return Slid(change * left**3 / 6.0, 0.5 * change * left**2, None, seconds - left)
    stop = _stop(speed, first, change)
    until = min(stop, seconds)
    way = until * (speed + until * (0.5 * first + until * change / 6.0))
    if stop <= seconds:
        return Slid(way, 0.0, stop)
    return Slid(way, speed + until * (first + 0.5 * until * change))


def _stop(speed: float, first: float, change: float) -> float:
    """The first zero of speed + first t + change t^2 / 2 after t = 0, s; infinity: never."""
    square = first * first - 2.0 * change * speed
    if square < 0.0:
        return math.inf
    if first < 0.0:  # the same root as below, without its cancellation
        return 2.0 * speed / (math.sqrt(square) - first)
    return (-first - math.sqrt(square)) / change if change < 0.0 else math.inf
