"""What one object does to one finger: gaps, local frames, motions (numpy only).

Local components at node i: 0 along the object's outward normal n_i (toward the finger), 1 and 2 in
its tangent plane. With the object moved by U(x), small motions give

    gap_i  = gap0_i + n_i . (u_i - U_i)          >= 0
    slip_i = t_i . (u_i - U_i)                   friction acts on its increment

gap0 is the phi_i-weighted mean of the exact distance between CAD surface and object.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fingerdesign.reduced import ReducedModel

Array = NDArray[np.float64]


class Indenter(Protocol):
    """A rigid object: signed distance and outward normal where points of the finger face it."""

    def distance(self, points: Array) -> Array:
        """Distance (q,) mm of points (q, dim) from the object, > 0 outside."""
        ...

    def normal(self, points: Array) -> Array:
        """Outward unit normals (q, dim) of the object at the facing points."""
        ...


@dataclass(frozen=True)
class Plane:
    """A rigid plane y = height, the object above it."""

    height: float

    def distance(self, points: Array) -> Array:
        return np.asarray(self.height - points[:, 1])

    def normal(self, points: Array) -> Array:
        normals = np.zeros_like(points)
        normals[:, 1] = -1.0
        return normals


@dataclass(frozen=True)
class Motion:
    """Rigid motion of the object from touch: approach (closing > 0), shear toward +x, mm."""

    approach: float
    shear: float

    def displacement(self, points: Array) -> Array:
        """Displacement (n, dim) of the object's material at ``points``."""
        moved = np.zeros_like(points)
        moved[:, 0] = self.shear
        moved[:, 1] = -self.approach
        return moved


@dataclass(frozen=True)
class ContactProblem:
    """A reduced model facing an object, in local components.

    compliance (m dim, m dim) mm/N; gap0 (m,) mm; frames (m, dim, dim): rows n, t1(, t2);
    self_compliance (m,): normal self-compliance of each node, the solver's length per force.
    """

    model: ReducedModel
    compliance: Array
    gap0: Array
    frames: Array
    friction_coefficient: float

    @property
    def shape(self) -> tuple[int, int]:
        return self.model.points.shape[0], self.model.dimension

    @property
    def self_compliance(self) -> Array:
        return np.asarray(np.diag(self.compliance).reshape(self.shape)[:, 0])

    def offset(self, motion: Motion, slip_reference: Array) -> Array:
        """Gap and slip increment (m, dim) that the motion gives a rigid finger."""
        moved = motion.displacement(self.model.points)
        local: Array = -np.einsum("mab,mb->ma", self.frames, moved)
        local[:, 0] += self.gap0
        local[:, 1:] -= slip_reference
        return local

    def to_global(self, multiplier: Array) -> Array:
        """Nodal forces on the finger (m, dim) N in x, y(, z)."""
        return np.asarray(np.einsum("mab,ma->mb", self.frames, multiplier))

    def with_friction(self, friction_coefficient: float) -> ContactProblem:
        """The same finger and object with another friction coefficient: nothing is recomputed."""
        return ContactProblem(
            self.model, self.compliance, self.gap0, self.frames, friction_coefficient
        )


def contact_problem(
    model: ReducedModel, indenter: Indenter, friction_coefficient: float
) -> ContactProblem:
    """Turn the compliance into local components and integrate the exact gap."""
    if not (np.isfinite(friction_coefficient) and friction_coefficient >= 0.0):
        raise ValueError(f"friction coefficient {friction_coefficient} must be finite and >= 0")
    frames = local_frames(indenter.normal(model.points))
    gap0 = model.surface.mean(indenter.distance(model.surface.points), model.nodes)
    m, dim = model.points.shape
    blocks = model.compliance.reshape(m, dim, m, dim)
    turned = np.einsum("iab,ibjd->iajd", frames, blocks, optimize=True)
    turned = np.einsum("iajd,jcd->iajc", turned, frames, optimize=True)
    compliance = np.ascontiguousarray(turned.reshape(m * dim, m * dim))
    return ContactProblem(model, compliance, gap0, frames, float(friction_coefficient))


def local_frames(normals: Array) -> Array:
    """Rows n, t1(, t2) per node (m, dim, dim); t1 is +x turned into the tangent plane."""
    m, dim = normals.shape
    along_x = np.zeros_like(normals)
    along_x[:, 0] = 1.0
    first = along_x - np.sum(along_x * normals, axis=1, keepdims=True) * normals
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    frames = np.zeros((m, dim, dim))
    frames[:, 0], frames[:, 1] = normals, first
    if dim == 3:
        # The sign makes t2 point to +z, as t1 does to +x.
        frames[:, 2] = np.cross(first, normals) * np.where(normals[:, 1:2] < 0, -1.0, 1.0)
    return frames
