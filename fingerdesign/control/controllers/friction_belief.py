"""The friction as the regulator knows it: a coefficient, and its fall as the force rises.

Rubber's friction often falls as the force rises: mu(F_n) = mu(F_0) (F_n / F_0)^-n, with n = 1/3 for
contact at a constant shear strength and n = 0 for Coulomb's law. A coefficient learnt at a small
force is then too large for the lift. Therefore each coefficient belongs to the force that it was
seen at. The ends of the first and of the last probe give n, the slope of log mu over log F_n, which
is joined with a prior.
"""

from math import log, sqrt

# Standard deviations of the friction by which it leans to the safe side. In 3-D, of a hundred lifts
# with all faults at once, 1 lifts 95 (none crushed, margin 1.69), 0.5 lifts 93 (1.61), 2 lifts 91.
_CAUTION = 1.0
# The exponent before it is known. Data are from 0 to 0.35: the mean of such rubbers and of others.
_EXPONENT, _MOST_EXPONENT = 0.1, 0.35
# Weight of that prior: (0.1 / 0.12)^2, a probe's relative error over the exponent's deviation.
_PRIOR = 0.7


class FrictionBelief:
    """A fading average of the coefficient, at the mean of its forces.

    weight: the sum of the samples' weights, each 1 / (relative variance); exponent: n.
    """

    def __init__(self) -> None:
        self.weight = self._sum = self._forces = 0.0
        self.exponent = _EXPONENT
        self._first: tuple[float, float] | None = None  # F_n and mu of the first probe

    def learn(self, friction: float, force: float, weight: float, memory: float) -> None:
        """Take in one sample, made at the normal force; memory: the weight of what was before."""
        self.fade(memory)
        self.weight += weight
        self._sum += weight * friction
        self._forces += weight * force

    def fade(self, share: float) -> None:
        """Leave this share of the weight of all samples."""
        self.weight *= share
        self._sum *= share
        self._forces *= share

    def probe_ends(self) -> None:
        """Learn the exponent from the present coefficient and that of the first probe."""
        if (friction := self.mean) is None:
            return
        force = self._forces / self.weight
        self._first = self._first or (force, friction)
        rise, fall = log(force / self._first[0]), log(self._first[1] / friction)
        found = (_PRIOR * _EXPONENT + 0.5 * rise * fall) / (_PRIOR + 0.5 * rise * rise)
        self.exponent = min(max(found, 0.0), _MOST_EXPONENT)

    @property
    def mean(self) -> float | None:
        """The coefficient at the mean force of its samples; None before anything is known."""
        return self._sum / self.weight if self.weight > 0.0 else None

    def at(self, force: float) -> float | None:
        """The coefficient at a normal force, N, over 0; None before anything is known.

        (F / F_0)^-n to the second order in log(F / F_0), without the cost of a power: 1 % off where
        the force doubles at n = 0.35.
        """
        if (friction := self.mean) is None:
            return None
        mean = self._forces / self.weight
        both, off = mean + force, self.exponent * (mean - force)
        return friction * (both + off) / (both - off)

    def surely(self, force: float) -> float:
        """The coefficient less its standard deviations; ``weight`` is over 0."""
        friction = self.at(force)
        assert friction is not None
        return friction * max(1.0 - _CAUTION / sqrt(self.weight), 0.5)
