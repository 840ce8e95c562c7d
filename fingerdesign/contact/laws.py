"""Signorini and friction as residuals, and the certificate of an increment (numpy only).

lambda_n >= 0,  gap >= 0,  lambda_n gap = 0
|lambda_t| <= b(lambda_n),   slip increment d = -alpha lambda_t, alpha >= 0,
                             d = 0 where |lambda_t| < b(lambda_n)

b is the node's friction bound (friction.py), mu lambda_n of Coulomb's law.
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.contact.friction import Friction

OPEN, STICK, SLIP = 0, 1, 2


def lengths(vectors: Array) -> Array:
    """Euclidean lengths (m,) of the rows of (m, k); in the plane (k = 1) without a square root.

    >>> lengths(np.array([[3.0, 4.0]])).tolist(), lengths(np.array([[-2.0]])).tolist()
    ([5.0], [2.0])
    """
    if vectors.shape[1] == 1:
        return np.abs(vectors[:, 0])
    if vectors.shape[1] == 2:
        return np.asarray(np.hypot(vectors[:, 0], vectors[:, 1]))
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def project(multiplier: Array, friction: Friction) -> Array:
    """Nearest admissible forces by parts: normal onto [0, inf), tangential onto its disc."""
    projected = multiplier.copy()
    projected[:, 0] = np.maximum(projected[:, 0], 0.0)
    size = lengths(projected[:, 1:])
    bound = friction.bound(projected[:, 0])
    over = size > bound
    projected[over, 1:] *= (bound[over] / size[over])[:, None]
    return projected


def natural_residual(
    multiplier: Array, motion: Array, self_compliance: Array, friction: Friction
) -> Array:
    """lambda - project(lambda - motion / C_ii) (m, dim) in N: zero exactly at a solution.

    ``motion`` (m, dim): gap and slip increment. The friction bound is that of the projected normal
    force, so the residual vanishes only where both laws hold together.
    """
    step = multiplier - motion / self_compliance[:, None]
    return multiplier - project(step, friction)


@dataclass(frozen=True)
class Certificate:
    """Worst violations of one increment, relative to its force and motion scales.

    complementarity: largest of tension, penetration and |lambda_n gap|
    coulomb: force outside the friction disc
    dissipation: power put *in* by friction, or slip not opposed to its force
    balance: base reaction against contact force
    """

    complementarity: float
    coulomb: float
    dissipation: float
    balance: float

    @property
    def laws(self) -> float:
        """Worst violation of Signorini's law and of friction's."""
        total = self.complementarity + self.coulomb + self.dissipation
        if total != total:
            return total  # not a number, which a maximum would hide
        return max(self.complementarity, self.coulomb, self.dissipation)

    def __str__(self) -> str:
        return (
            f"complementarity {self.complementarity:.1e}, Coulomb {self.coulomb:.1e}, "
            f"dissipation {self.dissipation:.1e}, balance {self.balance:.1e}"
        )


def certify(
    multiplier: Array,
    motion: Array,
    typical_compliance: float,
    friction: Friction,
    base_reaction: Array,
    contact_force: Array,
) -> Certificate:
    """Check the laws as they are written, apart from the residual that the solver drove down.

    typical_compliance: of a node to its own normal force, mm/N; it makes a length of a force.
    """
    if not (np.isfinite(multiplier).all() and np.isfinite(motion).all()):
        return Certificate(*4 * [float("inf")])
    normal, gap = multiplier[:, 0], motion[:, 0]
    tangential, slip = multiplier[:, 1:], motion[:, 1:]
    lowest = float(gap.min(initial=0.0))
    if not multiplier.any():
        # Nothing is touched: only penetration can be wrong.
        overlap = -lowest / max(float(np.abs(gap).max(initial=0.0)), 1e-300)
        return Certificate(overlap, 0.0, 0.0, 0.0)
    pulled = max(0.0, -float(normal.min()))
    force = max(pulled, float(normal.max()))
    length = force * typical_compliance
    # Tension and penetration too: the lesser of the two is then below 0.
    complementarity = float(np.abs(np.minimum(normal / force, gap / length)).max())
    bound = friction.bound(normal if pulled == 0.0 else np.maximum(normal, 0.0))
    coulomb = max(0.0, float((lengths(tangential) - bound).max())) / force
    # Maximum dissipation: bound |d| + lambda_t . d = 0 in contact; open nodes carry nothing.
    travelled = lengths(slip)
    loss = bound * travelled + np.einsum("ij,ij->i", tangential, slip)
    # Per node: a long slip (light contact, large shear) carries the rounding of its own length.
    dissipation = float((np.abs(loss) / np.maximum(travelled, length)).max()) / force
    balance = float(np.abs(base_reaction + contact_force).max() / max(normal.sum(), 1e-300))
    return Certificate(complementarity, coulomb, dissipation, balance)


def coded(slides: BoolArray, closed: BoolArray) -> IntArray:
    """Statuses of nodes that slide if they are closed.

    >>> coded(np.array([True, False, True]), np.array([True, True, False])).tolist()
    [2, 1, 0]
    """
    return np.asarray((slides + np.int64(STICK)) * closed)


def status_of(
    multiplier: Array, motion: Array, self_compliance: Array, friction: Friction
) -> IntArray:
    """OPEN, STICK or SLIP per node (m,) from the trial forces of the laws."""
    trial = multiplier - motion / self_compliance[:, None]
    bound = friction.bound(trial[:, 0], 1.0 + 1e-9)
    return coded(lengths(trial[:, 1:]) > bound, trial[:, 0] > 0.0)
