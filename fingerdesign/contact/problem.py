"""One object against one finger: gaps, local frames, motions (numpy only; objects.py).

Local components at node i: 0 along the object's outward normal n_i (toward the finger), 1 and 2 in
its tangent plane. With the object moved by U(x), small motions give

    gap_i  = gap0_i + n_i . (u_i - U_i)          >= 0
    slip_i = t_i . (u_i - U_i)                   friction acts on its increment

gap0 is the phi_i-weighted mean of the exact distance between CAD surface and object.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.friction import ByPressure, Coulomb, friction_at
from fingerdesign.errors import SolverError
from fingerdesign.reduced import ReducedModel
from fingerdesign.shapes.friction import FrictionLaw
from fingerdesign.shapes.objects import Indenter

FREE = slice(2, 4)  # The amplitudes, shear_z and twist, that an object free to turn finds itself.
_ROWS = 16  # That are turned at a time: they stay in the processor's cache.


@dataclass(frozen=True)
class Motion:
    """Rigid motion of the object from first contact, and the fraction of the body's own loads.

    approach (closing > 0), shear toward +x, shear_z toward +z: mm; twist_deg: turn about +y
    through x = z = 0, degrees, small; load: 0 to 1 (bodies with loads of their own only).
    """

    approach: float
    shear: float
    shear_z: float = 0.0
    twist_deg: float = 0.0
    load: float = 0.0

    @property
    def amplitudes(self) -> Array:
        """(5,): the fields in their order."""
        return np.array([self.approach, self.shear, self.shear_z, self.twist_deg, self.load])

    def toward(self, target: Motion, share: float) -> Motion:
        """The motion ``share`` of the way to ``target``."""
        way = self.amplitudes + share * (target.amplitudes - self.amplitudes)
        return Motion(*(float(value) for value in way))

    def __str__(self) -> str:
        text = f"approach {self.approach:g}, shear {self.shear:g} mm"
        text += f", shear_z {self.shear_z:g} mm" if self.shear_z else ""
        text += f", twist {self.twist_deg:g} degrees" if self.twist_deg else ""
        return text + (f", load {self.load:g}" if self.load else "")


@dataclass(frozen=True)
class ContactProblem:
    """A reduced model facing an object, in local components.

    compliance (m dim, m dim) mm/N; gap0 (m,) mm; frames (m, dim, dim): rows n, t1(, t2);
    modes (5, m, dim): gap and slip of a rigid finger per unit of each of Motion's amplitudes;
    friction_share (m,): see :meth:`patchy`; self_compliance (m,): normal self-compliance of each
    node, the solver's length per force. softness: of the springs along z, mm/N, and about y,
    degrees^2/(N mm), that hold an object free to turn (turning.py); None: its motion is all given.
    """

    model: ReducedModel
    compliance: Array
    gap0: Array
    frames: Array
    modes: Array
    law: FrictionLaw
    friction_share: Array | None = None
    softness: Array | None = None

    @property
    def shape(self) -> tuple[int, int]:
        return self.model.points.shape[0], self.model.dimension

    @cached_property
    def friction(self) -> Coulomb | ByPressure:
        """The law at the nodes, with their shares."""
        return friction_at(self.law, self.model.areas, self.friction_share)

    def mean_friction(self, normal: Array) -> float:
        """Friction force at normal forces (m,) N over their sum; 0 without contact."""
        if self.law.is_coulomb and self.friction_share is None:
            return self.law.coefficient
        pressed = np.maximum(normal, 0.0)
        return float(self.friction.bound(pressed).sum() / max(pressed.sum(), 1e-300))

    def slip_ratio(self, normal: Array) -> float | None:
        """F_t / F_n at which the whole contact would slip toward +x under normal forces (m,) N.

        Both forces are along the stage's axes, as a rig measures them. On a level plane it is the
        friction coefficient; on one that leans by t degrees it is tan(atan(mu) + t); under another
        law than Coulomb's it changes with F_n (gross_slip.py). None without contact, and for an
        object that turns (turning.py).
        """
        if self.softness is not None:
            return None
        pressing, pulling = self.carried_sliding(normal)
        return pulling / pressing if pressing > 0.0 else None

    def carried_sliding(self, normal: Array) -> tuple[float, float]:
        """F_n and F_t (N) along the stage's axes as all of a contact of normal forces (m,) N slides
        toward +x."""
        pressed = np.maximum(normal, 0.0)
        limit = np.zeros(self.shape)
        limit[:, 0] = pressed
        limit[:, 1] = np.copysign(self.friction.bound(pressed), self.frames[:, 1, 0])
        pressing, pulling = self.resultant(self.to_global(limit)).tolist()
        return pressing, pulling

    def resultant(self, force: Array) -> Array:
        """(F_n, F_t), N, of the whole finger: what presses and what pulls toward +x, of nodal
        forces (m, dim) N in x, y(, z)."""
        total = self.model.total_force(force)
        return np.array([-total[1], total[0]])

    @property
    def is_level(self) -> bool:
        """True where a shear toward +x leaves every gap as it is: on a plane that does not lean."""
        return not self.modes[1, :, 0].any()

    @property
    def friction_coefficient(self) -> float:
        """Coulomb's coefficient. Raises SolverError under another law, which has none."""
        if not self.law.is_coulomb:
            raise SolverError(f"this holds for Coulomb's law alone, not for friction {self.law}")
        return self.law.coefficient

    @cached_property
    def self_compliance(self) -> Array:
        return np.diag(self.compliance).reshape(self.shape)[:, 0].copy()

    @cached_property
    def typical_compliance(self) -> float:
        """The median of ``self_compliance``, mm/N."""
        return float(np.median(self.self_compliance))

    @cached_property
    def own_compliance(self) -> Array:
        """Self-compliance of a node less that of its most compliant neighbour (m,), mm/N."""
        own = self.self_compliance
        dim = self.shape[1]
        normal, pairs = self.compliance[::dim, ::dim], self.model.facets
        nearest = np.full(len(own), -np.inf)
        for here, there in combinations(pairs.T, 2):
            np.maximum.at(nearest, here, normal[here, there])
            np.maximum.at(nearest, there, normal[here, there])
        return np.asarray(own - np.maximum(nearest, 0.0))

    def offset(self, motion: Motion, slip_reference: Array) -> Array:
        """Gap and slip increment (m, dim) that the motion gives a rigid finger."""
        local = (motion.amplitudes @ self.modes.reshape(5, -1)).reshape(self.shape)
        local[:, 0] += self.gap0
        local[:, 1:] -= slip_reference
        return local

    def found_motion(self, motion: Motion, multiplier: Array) -> Motion:
        """A motion with what an object free to turn adds to it under the forces (m, dim) N."""
        if self.softness is None:
            return motion
        added = self.softness * np.einsum("kma,ma->k", self.modes[FREE], multiplier)
        z, twist = added.tolist()
        return replace(motion, shear_z=motion.shear_z + z, twist_deg=motion.twist_deg + twist)

    def to_global(self, multiplier: Array) -> Array:
        """Nodal forces on the finger (m, dim) N in x, y(, z)."""
        return np.asarray(np.einsum("mab,ma->mb", self.frames, multiplier))

    def with_friction(self, friction: float | FrictionLaw) -> ContactProblem:
        """The same finger and object with another friction coefficient, or law: nothing is
        recomputed."""
        return replace(self, law=_law(friction))

    def restricted(self, nodes: IntArray) -> ContactProblem:
        """The same on some nodes (k,), rising: its answers hold while no other is reached."""
        dim = self.shape[1]
        dofs = (nodes[:, None] * dim + np.arange(dim)).reshape(-1)
        return replace(
            self,
            model=self.model.restricted(nodes),
            compliance=np.ascontiguousarray(self.compliance[dofs][:, dofs]),
            gap0=self.gap0[nodes],
            frames=self.frames[nodes],
            modes=self.modes[:, nodes],
            friction_share=None if self.friction_share is None else self.friction_share[nodes],
        )

    def patchy(self, share: Array) -> ContactProblem:
        """The same with ``share`` (m,) > 0 times the friction bound at each node, or times
        the share that it has already."""
        if not (np.isfinite(share) & (share > 0.0)).all():
            raise ValueError("shares of the friction bound must be finite and > 0")
        own = 1.0 if self.friction_share is None else self.friction_share
        return replace(self, friction_share=np.asarray(share * own, dtype=np.float64))


@dataclass(frozen=True)
class ContactState:
    """The frozen past: slip so far (m, dim - 1) mm, and the last forces as a first guess."""

    slip: Array
    multiplier: Array
    motion: Motion
    travelled: Array  # (m,) accumulated slip while in contact, mm
    sliding: Array  # (m,) length of the last slip of nodes that are on their friction limit, mm

    @staticmethod
    def untouched(problem: ContactProblem) -> ContactState:
        m, dim = problem.shape
        return ContactState(
            np.zeros((m, dim - 1)), np.zeros((m, dim)), Motion(0.0, 0.0), np.zeros(m), np.zeros(m)
        )

    def widened(self, own: IntArray, joins: IntArray, slip: Array) -> ContactState:
        """The state on more nodes: its own at the places ``own``, open ones at ``joins`` with their
        ``slip``."""
        m = len(own) + len(joins)
        rows = [self.slip, self.multiplier, self.travelled, self.sliding]
        found = [np.zeros((m, *row.shape[1:])) for row in rows]
        for wide, row in zip(found, rows, strict=True):
            wide[own] = row
        found[0][joins] = slip
        return ContactState(found[0], found[1], self.motion, found[2], found[3])


def contact_problem(
    model: ReducedModel,
    indenter: Indenter,
    friction: float | FrictionLaw,
    object_compliance: Array | None = None,
    like: ContactProblem | None = None,
) -> ContactProblem:
    """Turn the compliance into local components and integrate the exact gap.

    object_compliance (m dim, m dim) mm/N, global: that of an elastic object at the finger's
    nodes. Both bodies yield to the same forces, so compliances add. like: a problem of the same
    compliance, whose turned one is taken over where the object's normals are the same.
    """
    law = _law(friction)
    frames = local_frames(indenter.normal(model.points))
    gap0 = model.surface.mean(indenter.distance(model.surface.points), model.nodes)
    modes = np.einsum("mab,kmb->kma", frames, rigid_modes(model))
    if like is not None and np.array_equal(frames, like.frames):
        return replace(like, model=model, gap0=gap0, modes=modes)
    both = model.compliance if object_compliance is None else model.compliance + object_compliance
    compliance = _turned(both, frames)
    if not (np.isfinite(compliance).all() and np.isfinite(gap0).all()):
        raise ValueError("compliance or gap hold values that are not finite numbers")
    return ContactProblem(model, compliance, gap0, frames, modes, law)


def _turned(matrix: Array, frames: Array) -> Array:
    """A matrix (m dim, m dim) with its rows and its columns turned into the frames."""
    m, dim, _ = frames.shape
    found = (frames @ matrix.reshape(m, dim, -1)).reshape(matrix.shape)
    for start in range(0, len(found), _ROWS):
        some = found[start : start + _ROWS]
        some[:] = (frames @ some.T.reshape(m, dim, -1)).reshape(some.T.shape).T
    return found


def _law(friction: float | FrictionLaw) -> FrictionLaw:
    return friction if isinstance(friction, FrictionLaw) else FrictionLaw(float(friction))


def rigid_modes(model: ReducedModel) -> Array:
    """Motion of the finger relative to the object (5, m, dim) mm per unit of each amplitude."""
    points, dim = model.points, model.dimension
    modes = np.zeros((5, *points.shape))
    modes[0, :, 1] = 1.0
    modes[1, :, 0] = -1.0
    if dim == 3:
        modes[2, :, 2] = -1.0
        modes[3, :, 0] = -np.deg2rad(points[:, 2])
        modes[3, :, 2] = np.deg2rad(points[:, 0])
    if model.load_displacement is not None:
        modes[4] = model.load_displacement
    modes[:, model.locked] = 0.0
    return modes


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
