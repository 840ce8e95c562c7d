"""The finger inside MuJoCo: a rigid scene there, the contact of finger pads here.

    pads = Coupling(model, [Mount(pad, "left_pad", "box_left"), Mount(...)])
    touches = pads.step(data)     # one step of the model's; a Touch for each mount

A mount names two sites: one with a finger's axes at its base (``NAME_pad`` of an exported finger),
one on the object's face with the axes that the pad's have at touch. In each step the poses are
read, each pad's wrench found, and applied to both bodies at the object's site, opposite and equal:
momentum is MuJoCo's to conserve. Geoms of pad and object may not collide.

Explicit coupling: the wrench is of the step's begin, velocities go first (the integrators Euler,
implicit and implicitfast). With M the mass matrix in the joints and K = J' k J the stiffness of all
pads there, k as all sticks, that is stable up to

    h = 2 / sqrt(largest eigenvalue of M^-1 K)            one mass, one spring: 2 sqrt(m / k),

so a step's least mass is k h^2 / 4. A step longer than SHARE of h is cut into equal parts.
Needs the extra ``mujoco`` (``pip install fingerdesign[mujoco]``).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh

from fingerdesign.arrays import Array
from fingerdesign.robots.pad import Pad, Touch
from fingerdesign.runtime.extras import needs

try:
    import mujoco
except ImportError:  # Reported where a coupling is made: the module can be imported without.
    mujoco = None

# A swing then takes six steps, and its frequency is 5 % off (at 0.4 eight, and 3 %). In the
# gallery's lift forces are off by 0.4 % of the largest, RMS (0.2 %), against a share of 0.1.
SHARE = 0.5
_AGAIN = 1.15  # The stable step is found again where a pad presses by so much more.
_MM = 1e3


@dataclass(frozen=True)
class Mount:
    """One pad in a scene: sites of the finger's base and of the face that it meets."""

    pad: Pad
    pad_site: str
    object_site: str


class Coupling:
    """Pads in one MuJoCo model. ``touches``: of the last step, one for each mount; parts: of that
    step; dissipated_mJ: work that friction has taken in all of them; cuts: long steps are cut.

    Friction has a history: after ``mj_resetData`` call :meth:`reset`."""

    def __init__(self, model: Any, mounts: Sequence[Mount], share: float = SHARE) -> None:
        """share: of the stable step, see :data:`SHARE`.

        Raises ImportError without MuJoCo, KeyError for an unknown site, ValueError for the
        integrator RK4, which evaluates forces within a step, for another share, for a pad that two
        mounts have, and where MuJoCo's own contact of pad and object would act as well."""
        needs("mujoco", "mujoco")
        if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
            raise ValueError('integrator = "RK4": must be Euler, implicit or implicitfast')
        if not 0.0 < share <= 1.0:
            raise ValueError(f"share = {share}: must be over 0 and at most 1, of the stable step")
        if len({id(each.pad) for each in mounts}) < len(mounts):
            raise ValueError("a pad is mounted twice: make another by pad_of, each has a history")
        for each in mounts:
            if each.pad_site == each.object_site:
                raise ValueError(f"object_site = {each.object_site!r}: must be on another body")
        self.model, self._mounts, self._share = model, tuple(mounts), share
        self.cuts = True
        pairs = ((each.pad_site, each.object_site) for each in self._mounts)
        self._sites = [(model.site(pad).id, model.site(met).id) for pad, met in pairs]
        for pad, met in self._sites:
            _refuse_contact(model, model.site_bodyid[pad], model.site_bodyid[met])
        self._begin()

    def reset(self) -> None:
        """Forget all contact: for ``data`` that was reset."""
        for each in self._mounts:
            each.pad.reset()
        self._begin()

    def _begin(self) -> None:
        self.touches: tuple[Touch, ...] = tuple(each.pad.touch for each in self._mounts)
        self.parts, self.dissipated_mJ, self._time = 0, 0.0, -math.inf
        self._pressed, self._stable = [0.0] * len(self._mounts), math.inf

    def step(self, data: Any) -> tuple[Touch, ...]:
        """Advance ``data`` by the model's timestep; forces in qfrc_applied act as well.

        Raises SolverError where a pad has no accepted answer; data is then as it was in that part.
        ValueError for a timestep that is none, data of another model, and time that went back.
        """
        model = self.model
        whole, done = float(model.opt.timestep), 0.0
        if not 0.0 < whole < math.inf:
            raise ValueError(f"timestep = {whole}: must be a finite number over 0, s")
        if len(data.qpos) != model.nq or len(data.site_xpos) != model.nsite:
            raise ValueError("data: must be of the coupling's model, by mujoco.MjData(model)")
        if data.time < self._time - 1e-9:
            raise ValueError(
                f"data.time = {data.time:g}: must be at least {self._time:g} s, that of the last "
                "step; call reset() where data was reset"
            )
        own = data.qfrc_applied.copy()
        try:
            self.parts = 0
            while whole - done > 1e-9 * whole:
                mujoco.mj_step1(model, data)
                data.qfrc_applied[:] = own + self._forces(data)
                left = math.ceil((whole - done) / self._longest(data) * (1.0 - 1e-9))
                model.opt.timestep = (whole - done) / max(left, 1)
                mujoco.mj_step2(model, data)
                done += model.opt.timestep
                self.parts += 1
        finally:
            model.opt.timestep = whole
            data.qfrc_applied[:] = own
            self._time = float(data.time)
        return self.touches

    def stable_step(self, data: Any) -> float:
        """Longest stable step, s, about the present state; infinite without contact."""
        model = self.model
        mass, whole = np.zeros((model.nv, model.nv)), np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        for mount, (pad, met) in zip(self._mounts, self._sites, strict=True):
            axes = data.site_xmat[pad].reshape(3, 3)
            moved = self._relative(data, pad, met)
            local = np.vstack([_MM * axes.T @ moved[:3], axes.T @ moved[3:]])
            # mJ in mm and rad: 1e-3 N m.
            whole += 1e-3 * local.T @ mount.pad.stiffness() @ local
        largest = float(eigh(whole, mass, eigvals_only=True)[-1]) if model.nv else 0.0
        return 2.0 / math.sqrt(largest) if largest > 0.0 else math.inf

    def _longest(self, data: Any) -> float:
        """SHARE of the stable step, found again where a pad presses harder."""
        pressed = [touch.normal_force for touch in self.touches]
        if any(now > _AGAIN * then for now, then in zip(pressed, self._pressed, strict=True)):
            self._stable, self._pressed = self.stable_step(data), pressed
        elif not any(pressed):
            self._pressed, self._stable = pressed, math.inf
        return self._share * self._stable if self.cuts else math.inf

    def _forces(self, data: Any) -> Array:
        """Meet the poses; forces (nv,) of all wrenches in the joints."""
        model, total = self.model, np.zeros(self.model.nv)
        touches, quaternion, turned = [], np.zeros(4), np.zeros(3)
        for mount, (pad, met) in zip(self._mounts, self._sites, strict=True):
            axes = data.site_xmat[pad].reshape(3, 3)
            point = data.site_xpos[met]
            place = _MM * axes.T @ (point - data.site_xpos[pad])
            mujoco.mju_mat2Quat(quaternion, (axes.T @ data.site_xmat[met].reshape(3, 3)).ravel())
            mujoco.mju_quat2Vel(turned, quaternion, 1.0)
            touch = mount.pad.meet(place, turned)
            force, moment = axes @ touch.wrench[:3], axes @ touch.wrench[3:] / _MM
            for sign, site in ((1.0, met), (-1.0, pad)):
                body = model.site_bodyid[site]
                mujoco.mj_applyFT(model, data, sign * force, sign * moment, point, body, total)
            touches.append(touch)
        self.touches = tuple(touches)
        self.dissipated_mJ += sum(touch.dissipated_mJ for touch in touches)
        return total

    def _relative(self, data: Any, pad: int, met: int) -> Array:
        """Velocity (6, nv) of the object's point and its rotation relative to the pad's body."""
        found = np.zeros((6, self.model.nv))
        for sign, site in ((1.0, met), (-1.0, pad)):
            way, turn = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
            body = self.model.site_bodyid[site]
            mujoco.mj_jac(self.model, data, way, turn, data.site_xpos[met], body)
            found += sign * np.vstack([way, turn])
        return found


def _refuse_contact(model: Any, pad: int, met: int) -> None:
    """Raise ValueError where geoms of two bodies collide: forces would count twice."""
    signature = (min(pad, met) << 16) + max(pad, met)
    off = model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT
    if off or signature in model.exclude_signature:
        return
    first, second = (np.flatnonzero(model.geom_bodyid == body) for body in (pad, met))
    kinds, meets = model.geom_contype, model.geom_conaffinity
    both = (kinds[first, None] & meets[second]) | (meets[first, None] & kinds[second])
    if both.any():
        names = [model.body(body).name for body in (pad, met)]
        bodies = " ".join(f'body{k}="{name}"' for k, name in enumerate(names, 1))
        raise ValueError(
            f"geoms of the bodies {names} collide, as the pad does: "
            f"add <contact><exclude {bodies}/></contact>, or set contype and conaffinity to 0"
        )
