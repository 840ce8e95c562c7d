"""A finger's pad against one face of a moving object: poses in, wrench and gages out (numpy only).

Pose: place p (mm) of a point of the object's face in the pad's axes, and the object's rotation
vector w (rad) in them. At first touch the point is at the crest, and the object's axes are the
pad's. Each node X of the pad meets the motion

    U(X) = p - a + w x (X - a),

linear in p and w, about an anchor a. The wrench that acts on the object at its point,

    F = - sum f,   M = - sum (X - a) x f,

is conjugate to it: what sticks stores all work that is put in. The anchor is the crest; along the
directions in which the face goes on (a plane's x, z and turn about y) it is where the object was
last free, and it follows the object where the whole contact slides: what sticks moves with it.

Motions are small: a rotation beyond MOST_DEG, or motions out of the plane of a model of half a
finger, are reported as ``outside``, and so is contact past the edge of a face that has one; where
the crest is past it the object is free. Contact that outruns the candidate zone is a ZoneExhausted.

Solved for are the nodes that the object is near to. Gaps of the others are bounded in each step;
where the bound fails they are computed, and below _NEAR_MM more nodes join: answers are those of
all nodes.
"""

from dataclasses import dataclass
from math import degrees, isfinite, radians

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.history import FrictionHistory
from fingerdesign.contact.increment import Increment, solve_increment
from fingerdesign.contact.laws import STICK
from fingerdesign.contact.measures import Measures, measure
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.contact.tangent import force_response
from fingerdesign.control.signals import FACES, reading_readout
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.layout.bodies import crest_height
from fingerdesign.sensing.model import against, grip_problem

MOST_DEG = 3.0  # What a rotation vector neglects at 5 mm from the anchor is then 7 micrometres.
_MOST_RAD = radians(MOST_DEG)
MOST_OUT_MM = 0.05  # Out of the plane of half a finger: a tenth of a usual approach.
PLANE = (True, True, True)
_LEAST, _NEAR_MM = 60, 0.01  # Nodes to begin with; at such a gap one of the others joins.


@dataclass(frozen=True)
class Touch:
    """Contact at one instant. wrench (6,): force N and moment N mm on the object at its point, in
    the pad's axes; readings (g,) microstrain; outside: motions that the model does not know;
    problem, increment: on the nodes near the object, None without contact."""

    wrench: Array
    readings: Array
    outside: tuple[str, ...] = ()
    problem: ContactProblem | None = None
    increment: Increment | None = None

    @property
    def normal_force(self) -> float:
        """Force that presses the pad, N."""
        return float(self.wrench[1])

    @property
    def measures(self) -> Measures | None:
        """Areas, stick ratio and slip distance; None without contact."""
        if self.problem is None or self.increment is None:
            return None
        return measure(self.problem, self.increment)

    @property
    def stored_mJ(self) -> float:
        """Elastic energy of the finger, N mm."""
        if self.problem is None or self.increment is None:
            return 0.0
        force = self.increment.multiplier.reshape(-1)
        work = 0.5 * float(force @ (self.problem.compliance @ force))
        return self.problem.model.symmetry_factor * work

    @property
    def dissipated_mJ(self) -> float:
        """Work that friction has taken in this step, N mm."""
        if self.problem is None or self.increment is None:
            return 0.0
        work = np.vdot(self.increment.multiplier[:, 1:], self.increment.slip_increment)
        return -self.problem.model.symmetry_factor * float(work)


class Pad:
    """The history of one finger's contact with one face; nothing of a simulator."""

    def __init__(
        self,
        problem: ContactProblem,
        face: str,
        crest_mm: float,
        goes_on: tuple[bool, bool, bool] = PLANE,
        kinetic_share: float = 1.0,
        half_face_mm: tuple[float, float] | None = None,
    ) -> None:
        """problem: posed at first touch. face: of the gages. crest_mm: height of the touch.

        goes_on: whether the face goes on along x, along z and about y, as a plane does.
        half_face_mm: from the object's point to the face's edges along x and z; None: no edge.
        A finger with loads of its own, and values without meaning, raise ValueError.
        """
        if problem.model.load_displacement is not None:
            raise ValueError("a finger with loads of its own cannot meet a moving object")
        if face not in FACES:
            raise ValueError(f"face = {face!r}: must be one of {', '.join(FACES)}")
        if not isfinite(crest_mm):
            raise ValueError(f"crest_mm = {crest_mm}: must be a finite number")
        if half_face_mm is not None and not all(each > 0.0 for each in half_face_mm):
            raise ValueError(f"half_face_mm = {half_face_mm}: must be over 0; None: no edge")
        self._edge = half_face_mm
        self._face, self._crest, self._share = face, crest_mm, kinetic_share
        self._goes_on = np.array(goes_on)
        model, dim = problem.model, problem.model.dimension
        self.planar = dim == 2 or model.symmetry_factor == 2
        self._out = [2, 3, 4] if self.planar else []  # of a pose: what a half knows nothing of
        points = np.zeros((model.nodes, 3))
        points[:, :dim] = model.points
        # Motions (6, m, dim) of the nodes with the axes, and about the origin, of an object.
        axes = np.broadcast_to(np.eye(3)[:, None], (3, *points.shape))
        rigid = np.concatenate([axes, np.cross(np.eye(3)[:, None], points)])[..., :dim]
        rigid[self._out] = 0.0
        self._all, self._all_rigid, self._points = problem, rigid, points
        self._all_local = np.einsum("mab,kmb->kma", problem.frames, rigid)
        self._width = float(np.ptp(points[:, 2])) or model.depth
        self._reach = 3.0 * float(np.abs(points).max()) + abs(crest_mm)
        self._about, self._blank = np.eye(6), np.zeros(len(model.gage_x))
        self.reset()

    def reset(self) -> None:
        """Forget all contact: the object is as before its first touch."""
        self._anchor, self._turn = np.array([0.0, self._crest, 0.0]), 0.0
        self._carried = np.zeros(2)  # x and z of the anchor's own way, mm
        self._rotation = np.zeros(3)
        self.touch = Touch(np.zeros(6), self._blank)
        # Friction that falls in motion has a history at each node: all take part.
        every = self._all.model.nodes
        count = every if self._share != 1.0 else min(every, max(_LEAST, every // 4))
        self._take(np.sort(np.argsort(self._all.gap0, kind="stable")[:count]))

    def _take(self, nodes: IntArray) -> None:
        """Solve on these nodes (k,), rising, from now on."""
        left = np.ones(self._all.shape[0], dtype=bool)
        left[nodes] = False
        self._nodes, self._far, dim = nodes, np.flatnonzero(left), self._all.shape[1]
        part = self._all.restricted(nodes) if len(self._far) else self._all
        self._history = FrictionHistory(part, self._share)
        self._frames = part.frames
        rows = reading_readout(part.model.gage_readout, self._face)
        self._sums = np.vstack([self._all_rigid[:, nodes].reshape(6, -1), rows])
        self._local = np.ascontiguousarray(self._all_local[:, nodes])
        dofs = (nodes[:, None] * dim + np.arange(dim)).reshape(-1)
        self._far_rows = self._all.compliance[dim * self._far][:, dofs]
        self._far_normal = self._all_local[:, self._far, 0]
        self._most = np.abs(self._far_rows).max(axis=0, initial=0.0)  # mm/N, of each force
        self._slack, self._checked = 0.0, ([0.0] * 3, [0.0] * 3, np.zeros(part.shape))

    def meet(self, place: Array, rotation: Array) -> Touch:
        """Go on to a pose: ``place`` (3,) mm, ``rotation`` (3,) rad.

        Raises SolverError without an accepted answer, ValueError for what is no pose; the pad is
        then as it was.
        """
        place, rotation = _three(place, "place", "mm"), _three(rotation, "rotation", "rad")
        if self._edge is not None and (np.abs(place[::2]) >= self._edge).any():
            return self._leave(place, rotation)  # the crest is past the edge
        if self.touch.increment is None:
            self._rest(place, rotation)
        before, nodes = self._history.state, self._nodes
        try:
            increment = self._solved(place, rotation)
        except SolverError:
            if len(nodes) < len(self._nodes):  # The last touch is of the nodes before.
                self._take(nodes)
            self._history.state = before
            raise
        if increment is None or not (increment.multiplier[:, 0] > 0.0).any():
            return self._leave(place, rotation)
        history = self._history
        sums = self._sums @ increment.force.reshape(-1)
        outside, wrench = self._outside(place, rotation), self._wrench(sums[:6])
        if self._edge is not None:
            closed = self._points[self._nodes[increment.multiplier[:, 0] > 0.0]]
            if (np.abs(closed - place)[:, ::2] > self._edge).any():
                outside += ("contact past the edge of the face",)
        solved = history.problem
        history.accept(increment)
        self.touch = Touch(wrench, sums[6:], outside, solved, increment)
        self._rotation = rotation
        if not (increment.status == STICK).any():
            self._follow(increment, rotation)
        return self.touch

    def _solved(self, place: Array, rotation: Array) -> Increment | None:
        """The increment to a pose on all nodes that matter; None for an object that stays free."""
        motion = self._motion(place, rotation)
        while True:
            history = self._history
            history.displace(self._tilt(rotation))
            if self.touch.increment is None and self._is_free(motion):
                if not self._widen(motion, place, rotation, np.zeros_like(self._checked[2])):
                    return None
                continue
            increment = solve_increment(history.problem, history.state, motion, history.workspace)
            if not self._widen(motion, place, rotation, increment.multiplier):
                return increment

    def _widen(self, motion: Motion, place: Array, rotation: Array, force: Array) -> bool:
        """Take in nodes that were left out, where forces (k, dim) would let the object reach one.

        A bound by the way since the last look spares most looks: no gap falls by more than the
        object moves, and each change of force times its largest compliance there.
        """
        if not len(self._far):
            return False
        (u, v, w), (a, b, c), pressed = self._checked
        (x, y, z), (p, q, r) = place.tolist(), rotation.tolist()
        way = abs(x - u) + abs(y - v) + abs(z - w)
        way += self._reach * (abs(p - a) + abs(q - b) + abs(r - c))
        if way < self._slack:
            way += float(self._most @ np.abs(force - pressed).reshape(-1))
        if way < self._slack:
            return False
        gap = self._all.gap0[self._far] + motion.amplitudes[:4] @ self._all.modes[:4, self._far, 0]
        gap -= self._tilted(rotation) @ self._far_normal
        gap += self._far_rows @ force.reshape(-1)
        if gap.min() > _NEAR_MM:
            self._slack = float(gap.min())
            self._checked = place.tolist(), rotation.tolist(), force
            return False
        before, nodes = self._history.state, self._nodes
        count = max(len(nodes) // 2, int((gap < 2.0 * _NEAR_MM).sum()))
        more = self._far[np.argsort(gap, kind="stable")[:count]]
        slip = self._slip_of(more, before)
        self._take(np.sort(np.concatenate([nodes, more])))
        self._history.state = before.widened(
            np.searchsorted(self._nodes, nodes), np.searchsorted(self._nodes, more), slip
        )
        return True

    def _slip_of(self, nodes: IntArray, state: ContactState) -> Array:
        """Place (k, dim - 1) mm in their tangent planes of open nodes that were left out."""
        dim = self._all.shape[1]
        dofs = (nodes[:, None] * dim + np.arange(dim)).reshape(-1)
        near = (self._nodes[:, None] * dim + np.arange(dim)).reshape(-1)
        yielded = self._all.compliance[dofs][:, near] @ state.multiplier.reshape(-1)
        tilt = self._tilted(self._rotation) @ self._all_local[:, nodes].reshape(6, -1)
        moved = state.motion.amplitudes[:4] @ self._all.modes[:4, nodes].reshape(4, -1)
        return np.asarray((moved - tilt + yielded).reshape(-1, dim)[:, 1:])

    def _leave(self, place: Array, rotation: Array) -> Touch:
        """The object is free: its friction history is over, and the next one begins here."""
        self._rest(place, rotation)
        motion, history = self._motion(place, rotation), self._history
        history.displace(self._tilt(rotation))
        still = np.zeros(history.problem.shape)
        slip = history.problem.offset(motion, still[:, 1:])[:, 1:]
        history.state = ContactState(slip, still, motion, still[:, 0], still[:, 0])
        self.touch = Touch(np.zeros(6), self._blank, self._outside(place, rotation))
        return self.touch

    def stiffness(self) -> Array:
        """- d wrench / d (place, rotation) (6, 6) as if all that touches stuck; N, mm, rad."""
        found = np.zeros((6, 6))
        increment, problem = self.touch.increment, self.touch.problem
        if increment is None or problem is None:
            return found
        modes = -np.einsum("jk,kma->jma", self._about_anchor().T, self._local)
        changes = force_response(problem, increment, modes, self._history.workspace, True)
        for column, change in enumerate(changes):
            force = problem.to_global(change).reshape(-1)
            found[:, column] = -self._wrench(self._sums[:6] @ force)
        return 0.5 * (found + found.T)

    def _about_anchor(self) -> Array:
        """A motion about the origin (6,) of one about the anchor: w x (X - a) = w x X + a x w."""
        x, y, z = self._anchor.tolist()
        found = self._about
        found[0, 4], found[0, 5], found[1, 3] = -z, y, z
        found[1, 5], found[2, 3], found[2, 4] = -x, -y, x
        return found

    def _rest(self, place: Array, rotation: Array) -> None:
        """The object is free: where the face goes on, contact begins where it now is."""
        x, z, turn = self._goes_on
        self._anchor = np.array([place[0] * x, self._crest, place[2] * z])
        self._turn, self._carried = float(rotation[1]) * bool(turn), np.zeros(2)
        self._slack = 0.0

    def _motion(self, place: Array, rotation: Array) -> Motion:
        way, anchor = place - self._anchor, self._anchor
        if self.planar:
            return Motion(-float(way[1]), float(way[0] + self._carried[0]), load=1.0)
        turn = float(rotation[1]) - self._turn
        shear = way[0] + self._carried[0] - turn * anchor[2]
        shear_z = way[2] + self._carried[1] + turn * anchor[0]
        return Motion(-float(way[1]), float(shear), float(shear_z), float(np.rad2deg(turn)), 1.0)

    def _tilt(self, rotation: Array) -> Array:
        """Motion (m, dim) mm, local, of the finger relative to an object tilted about x and z."""
        turned = -self._tilted(rotation) @ self._local.reshape(6, -1)
        return np.asarray(turned.reshape(self._frames.shape[:2]))

    def _tilted(self, rotation: Array) -> Array:
        """Motion about the origin (6,) of an object that is tilted about x and z at the anchor."""
        x, y, z = self._anchor.tolist()
        a, _, c = rotation.tolist()
        return np.array([y * c, z * a - x * c, -y * a, a, 0.0, c])

    def _is_free(self, motion: Motion) -> bool:
        offset = self._history.problem.offset(motion, self._history.state.slip)
        return bool(offset[:, 0].min() >= 0.0)

    def _wrench(self, sums: Array) -> Array:
        """Force and moment (6,) on the object at its point; sums (6,): of the modelled part's
        forces and their moments about the origin."""
        total = self._about_anchor().T @ sums
        total[self._out] = 0.0
        return np.asarray(-self._history.problem.model.symmetry_factor * total)

    def _follow(self, increment: Increment, rotation: Array) -> None:
        """All slides: the anchor goes with the object, by the mean slip, where the face goes on."""
        pressed = increment.multiplier[:, 0]
        slip = np.einsum("mab,ma->mb", self._frames[:, 1:], increment.slip_increment)
        mean = -(pressed @ slip) / pressed.sum()
        way = np.array([mean[0], 0.0 if self.planar else mean[2]]) * self._goes_on[:2]
        self._anchor = self._anchor + np.array([way[0], 0.0, way[1]])
        turn = 0.0 if self.planar else float(rotation[1]) - self._turn
        self._carried = self._carried + way + turn * np.array([way[1], -way[0]])
        self._slack = 0.0

    def _outside(self, place: Array, rotation: Array) -> tuple[str, ...]:
        x, y, z = rotation.tolist()
        most, found = max(abs(x), abs(y - self._turn), abs(z)), []
        if most > _MOST_RAD:
            found.append(f"turned by {degrees(most):.2g} degrees: at most {MOST_DEG:g}")
        if self.planar:
            turned = self._width * max(abs(x), abs(y - self._turn))
            out = max(abs(place[2] - self._anchor[2]), turned)
            if out > MOST_OUT_MM:
                words = f"{out:.2g} mm out of the plane of half a finger: condense the whole one"
                found.append(words)
        return tuple(found)


def pad_of(
    design: Design,
    friction_coefficient: float,
    fidelity: str = "3d",
    whole: bool = True,
    met: SceneObject | None = None,
    half_face_mm: tuple[float, float] | None = None,
) -> Pad:
    """Condense a design's finger for a moving object; several seconds, less from the cache.

    whole: both halves, for an object that is free in space; half a finger is a third of the work.
    met: the object's shape, at touch; None: a plane. half_face_mm: see :class:`Pad`; without it the
    pad presses a plane also where the object has long been dropped.
    Raises DesignError where the design cannot be gripped with, and for a face that is tilted or
    turned at touch.
    """
    met = SceneObject() if met is None else met
    if met.tilt_deg or met.turn_deg:
        given = (met.tilt_deg, met.turn_deg)
        fault = Fault("object.tilt_deg, turn_deg", given, "0", "tilt the body in the simulator")
        raise DesignError([fault])
    problem = grip_problem(design, fidelity, whole=whole)
    problem = against(problem, met, design).with_friction(friction_coefficient)
    flat = met.shape == "plane"
    round_bar = met.axis if met.shape == "cylinder" else ""
    goes_on = (flat or round_bar == "x", flat or round_bar == "z", flat or met.shape == "sphere")
    crest, share = crest_height(design.body), design.grip.kinetic_share
    return Pad(problem, design.gages.face, crest, goes_on, share, half_face_mm)


def _three(values: Array, name: str, unit: str) -> Array:
    found = np.array(values, dtype=float)  # a copy: callers fill theirs again
    if found.shape != (3,) or not isfinite(sum(found.tolist())):
        raise ValueError(f"{name} = {found.tolist()}: must be three finite numbers, {unit}")
    return found
