"""The stability map's judge: the laws of contact in global axes, and a second answer.

Nothing here uses the production solver or its certificate. Frames, gaps and slips are made from the
reduced model and the object alone; a node is right when it is open, sticks or slides as defined:

    open   f = 0,  gap >= 0
    stick  gap = 0,  no slip,  f_n >= 0,  |f_t| <= b(f_n)
    slip   gap = 0,  f_n >= 0,  f_t = -b(f_n) (slip / |slip|)

with the bound b(f_n) = mu f_n, or that of another law of friction.

Its violation is the least, over the three, of the worst term, with forces relative to the largest
nodal force and lengths to what that force moves its own node by.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from fingerdesign.arrays import Array
from fingerdesign.contact.friction import Friction, friction_at
from fingerdesign.contact.problem import Motion
from fingerdesign.contact.solver.gauss_seidel import gauss_seidel
from fingerdesign.reduced import ReducedModel
from fingerdesign.shapes.friction import FrictionLaw
from fingerdesign.shapes.objects import Indenter

SHARP = 1e-8  # violation of an answer that is exact but for rounding
LOOSE = 1e-3  # methods that claim no more are judged by total forces
_SAME = 1e-4  # nodal forces, relative to the largest: one answer, not two
_SECONDS = 2.0  # for one search
_NOTHING = 1e-10  # of the force that would press the body flat: no force at all


@dataclass(frozen=True)
class Past:
    """The start of an increment: global forces (m, dim) N, and the motion they belong to."""

    force: Array
    motion: Motion


@dataclass(frozen=True)
class Judge:
    """A body, an object and a friction law, read from the model alone."""

    model: ReducedModel
    indenter: Indenter
    law: FrictionLaw

    @cached_property
    def friction(self) -> Friction:
        """The law at the nodes."""
        return friction_at(self.law, self.model.areas)

    @cached_property
    def normals(self) -> Array:
        return self.indenter.normal(self.model.points)

    @cached_property
    def first_gap(self) -> Array:
        surface = self.model.surface
        weighted = surface.weight * self.indenter.distance(surface.points)[surface.point]
        return np.asarray(np.bincount(surface.node, weighted, self.model.nodes), dtype=float)

    @cached_property
    def _unit(self) -> float:
        """A typical displacement of a node per own force, mm/N."""
        return float(np.median(np.diag(self.model.compliance)))

    def untouched(self) -> Past:
        return Past(np.zeros(self.model.points.shape), Motion(0.0, 0.0))

    def relative(self, force: Array, motion: Motion) -> Array:
        """Displacement (m, dim) mm of the finger's nodes seen from the object."""
        points = self.model.points
        moved = np.zeros(points.shape)
        moved[:, 0], moved[:, 1] = motion.shear, -motion.approach
        if points.shape[1] == 3:
            turn = motion.twist_deg * np.pi / 180.0
            moved[:, 0] += turn * points[:, 2]
            moved[:, 2] = motion.shear_z - turn * points[:, 0]
        moved[self.model.locked] = 0.0
        own = self.model.compliance @ force.ravel()
        return np.asarray(own.reshape(points.shape) - moved)

    def violation(self, force: Array, past: Past, motion: Motion) -> float:
        """Worst violation of the laws over the nodes; infinite where a force is not finite."""
        if not np.isfinite(force).all():
            return float("inf")
        now = self.relative(force, motion)
        gap = self.first_gap + np.sum(self.normals * now, axis=1)
        change = now - self.relative(past.force, past.motion)
        slip = change - np.sum(change * self.normals, axis=1)[:, None] * self.normals
        press = np.sum(force * self.normals, axis=1)
        drag = force - press[:, None] * self.normals
        stretch = max(float(np.abs(gap).max()), float(np.abs(slip).max()))
        newton = max(float(np.abs(force).max()), _NOTHING * stretch / self._unit, 1e-300)
        length = newton * self._unit
        moved = np.sqrt(np.sum(slip**2, axis=1))
        direction = slip / np.maximum(moved, 1e-300)[:, None]
        sizes = np.sqrt(np.sum(drag**2, axis=1))
        bound = self.law.bound(press, self.model.areas)
        touching = np.maximum(-press / newton, np.abs(gap) / length)
        opens = np.max([np.abs(press) / newton, sizes / newton, -gap / length], axis=0)
        sticks = np.max([touching, moved / length, (sizes - bound) / newton], axis=0)
        opposed = np.sqrt(np.sum((drag + bound[:, None] * direction) ** 2, axis=1))
        slides = np.maximum(touching, opposed / newton)
        each = np.min([opens, sticks, slides], axis=0)
        support = self.model.reaction_readout @ force.ravel() + force.sum(axis=0)
        free = ~self.model.locked.any(axis=0)
        balance = float(np.abs(support[free]).max()) / max(float(np.abs(press).sum()), newton)
        return max(float(each.max()), balance if balance > 1e-6 else 0.0, 0.0)

    def same(self, one: Array, other: Array, motion: Motion) -> bool:
        """Do the nodal forces agree to 1e-4 of the largest, or are both nothing?"""
        scale = max(float(np.abs(one).max()), float(np.abs(other).max()))
        stretch = max(float(np.abs(self.first_gap).max()), abs(motion.approach))
        if scale <= _NOTHING * stretch / self._unit:
            return True
        return bool(np.abs(one - other).max() <= _SAME * scale)

    def carries(self, force: Array, normal: float, tangential: float | None) -> bool:
        """Are the whole finger's forces those prescribed (N), to 1e-6 of the normal one?"""
        total = self.model.symmetry_factor * force.sum(axis=0)
        missing = [total[1] + normal, 0.0 if tangential is None else total[0] - tangential]
        return bool(np.abs(missing).max() <= 1e-6 * normal)

    def at_rim(self, force: Array) -> bool:
        """Does the contact reach a node where the candidates end although the surface goes on?"""
        press = np.sum(force * self.normals, axis=1)
        return bool((press[self.model.rim] > 1e-9 * np.abs(force).max()).any())

    def second_answer(self, past: Past, motion: Motion) -> Array | None:
        """Global forces (m, dim) of another method that obey the laws sharply; None: none found."""
        compliance, offset, frames = self._local(past, motion)
        for method in (_swept, fixed_bound):
            local = method(compliance, offset, self.friction)
            if local is not None:
                force = np.asarray(np.einsum("mab,ma->mb", frames, local))
                if self.violation(force, past, motion) <= SHARP:
                    return force
        return None

    def nearest_answer(self, force: Array, past: Past, motion: Motion) -> Array | None:
        """The end of Gauss-Seidel sweeps from ``force``, if that obeys the laws sharply."""
        compliance, offset, frames = self._local(past, motion)
        start = np.einsum("mab,mb->ma", frames, force)
        found = gauss_seidel(compliance, offset, self.friction, start, 20_000, 1e-11, _SECONDS)
        near = np.asarray(np.einsum("mab,ma->mb", frames, found.multiplier))
        return near if self.violation(near, past, motion) <= SHARP else None

    def _local(self, past: Past, motion: Motion) -> tuple[Array, Array, Array]:
        """Compliance, offset (m, dim) and frames (m, dim, dim) in the judge's own axes."""
        frames = _frames(self.normals)
        turn = block_diag(*frames)
        now = self.relative(np.zeros(self.model.points.shape), motion)
        before = self.relative(past.force, past.motion)
        offset = np.einsum("mab,mb->ma", frames, now - before)
        offset[:, 0] = self.first_gap + np.sum(self.normals * now, axis=1)
        return turn @ self.model.compliance @ turn.T, offset, frames


def _swept(compliance: Array, offset: Array, friction: Friction) -> Array | None:
    """Gauss-Seidel from nothing to 1e-11; the production solver's last resort starts elsewhere."""
    start = np.zeros_like(offset)
    found = gauss_seidel(compliance, offset, friction, start, 2000, 1e-11, _SECONDS)
    return found.multiplier if found.converged else None


def same_total(one: Array, other: Array, share: float) -> bool:
    """Do the total forces (m, dim) agree to ``share`` of the greater one?"""
    first, second = one.sum(axis=0), other.sum(axis=0)
    scale = max(float(np.linalg.norm(first)), float(np.linalg.norm(second)))
    return bool(np.linalg.norm(first - second) <= share * scale)


def _frames(normals: Array) -> Array:
    """Rows: the normal and its tangents, (m, dim, dim), by Householder's reflection of axis 0."""
    unit = np.eye(normals.shape[1])
    mirror = normals - unit[0]
    size = np.sum(mirror**2, axis=1)[:, None, None]
    along = size > 1e-24
    reflected = unit - 2.0 * mirror[:, :, None] * mirror[:, None, :] / np.where(along, size, 1.0)
    return np.where(along, reflected, unit)


def fixed_bound(compliance: Array, offset: Array, friction: Friction) -> Array | None:
    """Forces (m, dim): p from a bound b(p) of the round before until it no longer changes.

    Each round minimises 1/2 f C f + w f over p >= 0, |t| <= bound: Haslinger's fixed point. None
    where the rounds do not settle (they need not for a large friction coefficient) within 4000
    gradient steps in all.
    """
    (m, dim), budget = offset.shape, 4000
    scale = np.sqrt(np.repeat(np.diag(compliance).reshape(m, dim).max(axis=1), dim))
    matrix = compliance / np.outer(scale, scale)
    load = offset.reshape(-1) / scale
    step = 1.0 / float(np.linalg.eigvalsh(matrix)[-1])
    weight = scale[::dim]  # one scale a node keeps its disc round
    force = np.zeros(m * dim)
    bound = np.zeros(m)
    while budget > 0:
        force, spent = _descend(matrix, load, step, bound, force, dim)
        budget -= spent
        before, bound = bound, weight * friction.bound(force[::dim] / weight)
        change = float(np.abs(bound - before).max())
        if change <= 1e-10 * max(float(np.abs(force).max()), 1e-300):
            force, _ = _descend(matrix, load, step, bound, force, dim)
            return np.asarray(force.reshape(m, dim) / weight[:, None])
    return None


def _descend(
    matrix: Array, load: Array, step: float, bound: Array, start: Array, dim: int
) -> tuple[Array, int]:
    """Projected gradient with momentum, restarted where it overshoots (O'Donoghue, Candes 2015).

    Returns the forces and the steps taken.
    """
    force, ahead, momentum = start, start, 1.0
    for count in range(1, 2001):
        new = _admissible(ahead - step * (matrix @ ahead + load), bound, dim)
        moved = new - force
        size = float(np.abs(new).max())
        if max(np.abs(moved).max(), np.abs(new - ahead).max()) <= 1e-12 * size:
            return new, count
        if (ahead - new) @ moved > 0.0:
            momentum, ahead, force = 1.0, new, new
            continue
        following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
        ahead = new + (momentum - 1.0) / following * moved
        force, momentum = new, following
    return force, count


def _admissible(force: Array, bound: Array, dim: int) -> Array:
    shaped = force.reshape(-1, dim).copy()
    shaped[:, 0] = np.maximum(shaped[:, 0], 0.0)
    size = np.sqrt(np.sum(shaped[:, 1:] ** 2, axis=1))
    over = size > bound
    shaped[over, 1:] *= (bound[over] / size[over])[:, None]
    return np.asarray(shaped.reshape(-1))
