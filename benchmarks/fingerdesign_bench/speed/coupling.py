"""Two pads inside MuJoCo: a step's time, the wrench against the engine, energy, the least mass.

A box between two fingers. For the time they close, lift it and shake it, as the gallery's gripper
does; for the rest their bases are fixed: the box swings from rest under gravity for ten seconds, or
is pushed at a fixed step to find by trial the mass from which it stays.
"""

import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.checks.load import load_design
from fingerdesign.contact.increment import Workspace, solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.layout.bodies import crest_height
from fingerdesign.robots.mujoco import Coupling, Mount
from fingerdesign.robots.pad import Pad
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing.model import grip_problem
from fingerdesign_bench.check import Check, Table

STEP_MS, WRENCH_N, DRIFT, MASS = 2.0, 1e-6, 0.01, 0.2  # targets; a step: 500 a second
FULL = {"fidelity": "3d", "whole": True, "seconds": 10.0, "runs": 3}
QUICK = {"fidelity": "plane-strain", "whole": False, "seconds": 1.0, "runs": 1}
_STEP_s, _LIFT_s, _CLOSED_mm, _MASS_kg = 2e-3, 0.7, 0.2, 0.3
_SWING_STEP_s, _TRIAL_STEP_s, _TRIALS, _PUSHES = 5e-4, 1e-3, 5, 150
_SIDES = {"left": 1, "right": -1}
_FINGER = """<body pos="{x} 0 0">{joint}
<geom type="box" size=".004 .008 .012" mass=".15" contype="0" conaffinity="0"/>
<site name="{side}_pad" xyaxes="0 0 1 {sign} 0 0"/></body>"""
_FACE = '<site name="{side}_face" pos="{x} 0 0" xyaxes="0 0 1 {sign} 0 0"/>'
_WORLD = """<mujoco><option timestep="{step}" gravity="0 0 {gravity}"/><worldbody>{floor}
<body pos="0 0 .02">{lift}{fingers}</body><body pos="0 0 .02">{free}
<geom type="box" size=".02 .02 .02" mass="{mass}"/>{faces}</body></worldbody>{motors}</mujoco>"""
_SLIDE = '<joint name="{side}" type="slide" axis="{sign} 0 0" damping="60"/>'
_LIFT = """<joint name="lift" type="slide" axis="0 0 1" damping="100"/>
<geom size=".01" pos="0 -.3 0" mass=".5" contype="0" conaffinity="0"/>"""
_MOTORS = """<actuator><position joint="left" kp="4e4"/><position joint="right" kp="4e4"/>
<position joint="lift" kp="2e4"/></actuator>"""
_IN_PLANE = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>'
_ACROSS = '<joint type="slide" axis="1 0 0"/>'


@dataclass(frozen=True)
class Coupled:
    """Results. step_ms, parts: of a step of the lift; wrench_N: largest error; drift: of all
    energy; mass: the least stable one by trial over the formula's."""

    contact_nodes: int
    step_ms: float
    parts: float
    wrench_N: float
    drift: float
    mass: float

    def checks(self) -> list[Check]:
        """Compare with the targets."""
        name = f"MuJoCo, two pads of {self.contact_nodes} nodes"
        return [
            Check(f"{name}: a step of the lift, warm", STEP_MS, self.step_ms, "ms"),
            Check(f"{name}: wrench off the engine's", WRENCH_N, self.wrench_N, "N or N mm"),
            Check(f"{name}: energy drift of a held box", DRIFT, self.drift),
            Check(f"{name}: least mass by trial off k h^2 / 4", MASS, abs(self.mass - 1.0)),
        ]

    def table(self) -> Table:
        """One row."""
        cells = [f"{1e3 / self.step_ms:.0f}", f"{self.parts:.2f}", f"{self.wrench_N:.1e}"]
        cells += [f"{100 * self.drift:.2g} %", f"{self.mass:.2f}"]
        headings = ["steps a second", "parts a step", "wrench error", "energy drift", "least mass"]
        return f"Two pads of {self.contact_nodes} nodes in MuJoCo", headings, [cells]


def coupled(case: dict[str, Any]) -> dict[str, Any]:
    """Measure one model. case: fidelity; whole: both halves; seconds of the swing; runs."""
    design = load_design("sensitive")
    problem = grip_problem(design, case["fidelity"], whole=case["whole"])
    crest = crest_height(design.body)
    planar = problem.shape[1] == 2 or problem.model.symmetry_factor == 2
    with one_thread():
        times = [_lift(problem, crest, planar) for _ in range(case["runs"])]
        found = Coupled(
            contact_nodes=problem.model.nodes,
            step_ms=1e3 * min(seconds for seconds, _ in times),
            parts=times[0][1],
            wrench_N=_wrench_error(problem, crest),
            drift=_drift(problem, crest, case["seconds"]),
            mass=_least_mass(problem, crest),
        )
    return asdict(found)


def _scene(
    problem: ContactProblem, crest: float, friction: float, closed: float, **text: Any
) -> Coupling:
    """A box between two fresh pads, pressed by ``closed`` mm; text: of _WORLD."""
    import mujoco

    usual = {"lift": "", "motors": "", "floor": "", "gravity": 0.0, "mass": _MASS_kg, "joint": ""}
    given: dict[str, Any] = usual | text
    away = 0.02 + 1e-3 * (crest - closed)
    fingers = faces = ""
    for side, sign in _SIDES.items():
        slide = given["joint"].format(side=side, sign=sign)
        fingers += _FINGER.format(side=side, sign=sign, x=-away * sign, joint=slide)
        faces += _FACE.format(side=side, sign=sign, x=-0.02 * sign)
    given |= {"fingers": fingers, "faces": faces}
    model = mujoco.MjModel.from_xml_string(_WORLD.format(**given))
    own = problem.with_friction(friction)
    mounts = [Mount(Pad(own, "both", crest), f"{side}_pad", f"{side}_face") for side in _SIDES]
    return Coupling(model, mounts)


def _lift(problem: ContactProblem, crest: float, planar: bool) -> tuple[float, float]:
    """Seconds and parts of a step."""
    import mujoco

    free = _IN_PLANE + '<joint type="hinge" axis="0 1 0"/>' if planar else "<freejoint/>"
    floor = '<geom type="plane" size="1 1 .1"/>'
    moved = {"joint": _SLIDE, "lift": _LIFT, "motors": _MOTORS, "floor": floor, "free": free}
    coupling = _scene(problem, crest, 0.5, -0.2, step=_STEP_s, gravity=-9.81, **moved)
    data, steps, parts, start = mujoco.MjData(coupling.model), 0, 0, time.perf_counter()
    while data.time < _LIFT_s:
        shake = 0.004 * np.sin(40.0 * max(data.time - 0.5, 0.0))
        rise = 0.02 * np.clip(5.0 * data.time - 1.25, 0.0, 1.0) + shake
        data.ctrl[:] = *[5e-4 * min(1.0, data.time / 0.2)] * 2, rise
        coupling.step(data)
        steps, parts = steps + 1, parts + coupling.parts
    return (time.perf_counter() - start) / steps, parts / steps


def _wrench_error(problem: ContactProblem, crest: float) -> float:
    """The largest error of a pad's force and moment along a press and a shear, N and N mm."""
    own = problem.with_friction(0.5)
    pad, worst = Pad(own, "both", crest), 0.0
    state, workspace = ContactState.untouched(own), Workspace()
    for k in range(1, 41):
        motion = Motion(0.01 * min(k, 20), 0.005 * max(0, k - 20))
        exact = solve_increment(own, state, motion, workspace)
        state = exact.state
        place = np.array([motion.shear, crest - motion.approach, 0.0])
        found = pad.meet(place, np.zeros(3)).wrench
        worst = max(worst, float(np.abs(found - _wrench(own, exact.force, crest)).max()))
    return worst


def _wrench(problem: ContactProblem, force: Array, crest: float) -> Array:
    """Force and moment (6,) about the crest on the object, of both halves."""
    model = problem.model
    points, forces = np.zeros((model.nodes, 3)), np.zeros((model.nodes, 3))
    points[:, : model.dimension], forces[:, : model.dimension] = model.points, force
    moment = np.cross(points - [0.0, crest, 0.0], forces).sum(axis=0)
    total = -model.symmetry_factor * np.concatenate([forces.sum(axis=0), moment])
    if model.dimension == 2 or model.symmetry_factor == 2:
        total[2:5] = 0.0
    return np.asarray(total)


def _drift(problem: ContactProblem, crest: float, seconds: float) -> float:
    """Range of all energy, averaged over twentieths of the time, over the swing's: its largest
    kinetic energy."""
    import mujoco

    swung = {"step": _SWING_STEP_s, "gravity": -9.81, "free": _IN_PLANE}
    coupling = _scene(problem, crest, 2.0, _CLOSED_mm, **swung)
    model, energy, swing = coupling.model, [], 0.0
    data = mujoco.MjData(model)
    for _ in range(round(seconds / _SWING_STEP_s)):
        coupling.step(data)
        stored = sum(touch.stored_mJ for touch in coupling.touches)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        swing = max(swing, 1e3 * float(data.energy[1]))
        energy.append(stored + coupling.dissipated_mJ + 1e3 * float(data.energy.sum()))
    mean = np.reshape(energy[: len(energy) // 20 * 20], (20, -1)).mean(axis=1)
    return float(np.ptp(mean) / swing)


def _least_mass(problem: ContactProblem, crest: float) -> float:
    """The mass from which a push does not grow, by trial, over k h^2 / 4."""
    _, stable = _grows(problem, crest, _MASS_kg)
    formula = _MASS_kg * (_TRIAL_STEP_s / stable) ** 2
    low, high = 0.5, 2.0
    for _ in range(_TRIALS):
        middle = 0.5 * (low + high)
        grows, _ = _grows(problem, crest, middle * formula)
        low, high = (middle, high) if grows else (low, middle)
    return 0.5 * (low + high)


def _grows(problem: ContactProblem, crest: float, mass: float) -> tuple[bool, float]:
    """True if a push at the box grows at a step that is not cut; the stable step, s."""
    import mujoco

    across = {"step": _TRIAL_STEP_s, "free": _ACROSS, "mass": mass}
    coupling = _scene(problem, crest, 2.0, _CLOSED_mm, **across)
    data = mujoco.MjData(coupling.model)
    coupling.step(data)
    stable = coupling.stable_step(data)
    coupling.cuts = False
    data.qvel[0] = 1e-7 / _TRIAL_STEP_s
    for _ in range(_PUSHES):
        coupling.step(data)
        if not abs(data.qpos[0]) < 3e-6:
            return True, stable
    return False, stable
