"""Pads inside MuJoCo: frames and momentum, the stable step by trial, energy of a held object."""

import numpy as np
import pytest

from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.robots.mujoco import Coupling, Mount
from fingerdesign.robots.pad import Pad
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import bump, followed

mujoco = pytest.importorskip("mujoco", reason="pip install 'fingerdesign[mujoco]' brings it")

FACES = '<site name="box_{0}" pos="{1} 0 0" xyaxes="0 0 1 {2} 0 0"/>'
WORLD = """
<mujoco><option timestep="{step}" gravity="0 0 {gravity}" integrator="{integrator}"/>
<worldbody>
<body pos="-{gap} 0 0"><site name="left" xyaxes="0 0 1 1 0 0"/></body>
<body pos="{gap} 0 0"><site name="right" xyaxes="0 0 1 -1 0 0"/></body>
<body name="box">{joint}
<geom type="box" size=".005 .005 .005" mass="{mass}" contype="0" conaffinity="0"/>{faces}</body>
</worldbody></mujoco>"""
FREE = "<freejoint/>"
BESIDE = '<joint type="slide" axis="1 0 0"/>'


def held(pads, crest_mm, closed_mm, mass, step, gravity=-9.81, joint=FREE, integrator="Euler"):
    """A box between two pads, each pressed by ``closed_mm``: its model and its coupling."""
    faces = FACES.format("left", -0.005, 1) + FACES.format("right", 0.005, -1)
    gap = 1e-3 * (5.0 + crest_mm - closed_mm)
    text = WORLD.format(**locals())
    model = mujoco.MjModel.from_xml_string(text)
    sides = zip(pads, ("left", "right"), strict=True)
    return model, Coupling(model, [Mount(pad, each, f"box_{each}") for pad, each in sides])


def bumps(friction, nodes=7):
    """Two small pads whose crest is at y = 0."""
    problem = contact_problem(bump(nodes), Plane(0.0), friction)
    return [Pad(problem, "both", 0.0) for _ in range(2)]


def test_the_wrench_is_the_engines_on_any_pose_in_the_world():
    """A moved object in front of a pad that is turned and shifted: 1e-6 of the engine's."""
    turned = '<site name="pad" pos=".3 -.2 .1" quat=".8 .1 -.3 .5"/>'
    moved = '<body name="met" mocap="true"><site name="met"/></body>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody><body>{turned}</body>{moved}</worldbody></mujoco>"
    )
    data, problem = mujoco.MjData(model), contact_problem(bump(7), Plane(0.0), 0.4)
    coupling = Coupling(model, [Mount(Pad(problem, "both", 0.0), "pad", "met")])
    mujoco.mj_forward(model, data)
    base, axes = data.site("pad").xpos.copy(), data.site("pad").xmat.reshape(3, 3).copy()
    path = [Motion(0.008, 2e-4 * k, -1e-4 * k, 0.02 * k) for k in range(12)]
    for motion, exact in zip(path, followed(problem, path), strict=True):
        place = np.array([motion.shear, -motion.approach, motion.shear_z])
        data.mocap_pos[0] = base + 1e-3 * axes @ place
        half, own, both = np.deg2rad(motion.twist_deg) / 2, np.zeros(4), np.zeros(4)
        mujoco.mju_mat2Quat(own, axes.ravel())
        turn = np.array([np.cos(half), 0.0, np.sin(half), 0.0])
        mujoco.mju_mulQuat(both, own, turn)
        data.mocap_quat[0] = both
        (touch,) = coupling.step(data)
        assert touch.wrench[:3] == pytest.approx(-exact.force.sum(axis=0), abs=1e-6)


def test_momentum_is_nobodys_but_the_objects():
    """A free pad and a free object fly together without gravity: nothing acts from outside."""
    bodies = """
<body pos="-.02 0 0"><freejoint/><geom size=".005" pos="-.01 .004 0" mass=".02"/>
<site name="pad" pos=".003 0 .001" xyaxes="0 0 1 1 0 0"/></body>
<body pos=".02 .003 0"><freejoint/><geom type="box" size=".004 .006 .005" mass=".05"/>
<site name="face" pos="-.037008 -.003 .001" xyaxes="0 0 1 1 0 0"/></body>"""
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><option timestep="2e-5" gravity="0 0 0"><flag contact="disable"/></option>'
        f"<worldbody>{bodies}</worldbody></mujoco>"
    )
    problem, data = contact_problem(bump(7), Plane(0.0), 0.4), mujoco.MjData(model)
    coupling = Coupling(model, [Mount(Pad(problem, "both", 0.0), "pad", "face")])
    pressed = [coupling.step(data)[0].normal_force for _ in range(300)]
    assert max(pressed) > 0.01
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    speeds = np.linalg.norm(data.cvel[1:, 3:], axis=1)
    momentum = 0.05 * speeds.min()
    # Of first order in the step: both bodies turn while the wrench is that of the step's begin.
    assert np.abs(data.subtree_linvel[0]).max() * 0.07 < 1e-3 * momentum
    assert np.abs(data.subtree_angmom[0]).max() < 1e-3 * momentum * 0.02


def grows(step, mass, integrator="Euler"):
    """Whether a push at a box that is held in the middle grows, at a fixed step."""
    model, coupling = held(bumps(50.0), 0.0, 0.008, mass, step, 0.0, BESIDE, integrator)
    data = mujoco.MjData(model)
    coupling.step(data)
    stable = coupling.stable_step(data)
    coupling.cuts = False  # one part, whatever its stability
    data.qvel[0] = 1e-7 / step
    for _ in range(150):
        coupling.step(data)
        if not abs(data.qpos[0]) < 3e-6:
            return True, stable
    return False, stable


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast"])
def test_the_stable_step_is_that_of_the_formula(integrator):
    """By trial, between 0.8 and 1.2 of 2 sqrt(m / k)."""
    _, stable = grows(1e-6, 0.05, integrator)
    low, high = 0.5 * stable, 2.0 * stable
    assert not grows(low, 0.05, integrator)[0]
    assert grows(high, 0.05, integrator)[0]
    for _ in range(5):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if grows(middle, 0.05, integrator)[0] else (middle, high)
    assert 0.8 * stable < low < high < 1.2 * stable


def test_the_least_mass_is_that_of_the_formula():
    """k h^2 / 4 within 20 %: at a step of 1 ms, by trial."""
    _, stable = grows(1e-6, 0.05)
    least = 0.05 * (1e-3 / stable) ** 2
    assert grows(1e-3, 0.8 * least)[0]
    assert not grows(1e-3, 1.2 * least)[0]


@pytest.mark.slow
def test_a_held_object_keeps_its_energy_for_five_seconds():
    """It swings on the pads from rest under gravity; of all energy under 1 % is lost or won."""
    step = 5e-4
    model, coupling = held(bumps(2.0, 5), 0.0, 0.008, 0.008, step)
    data, found, swing = mujoco.MjData(model), [], []
    for _ in range(10_000):
        coupling.step(data)
        stored = sum(touch.stored_mJ for touch in coupling.touches)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        found.append(stored + coupling.dissipated_mJ + 1e3 * float(data.energy.sum()))
        swing.append(data.qpos[2])
    mean = np.reshape(found, (10, -1)).mean(axis=1)  # a swing's ripple is the step's, not a drift
    assert np.ptp(mean) < 0.01 * mean.mean()
    assert np.ptp(swing[-1000:]) > 1e-6  # it still swings


def test_a_long_step_is_cut_and_no_pad_is_forgotten():
    model, coupling = held(bumps(1.0), 0.0, 0.008, 0.05, 0.02)
    data = mujoco.MjData(model)
    coupling.step(data)
    assert coupling.parts > 3
    assert data.time == pytest.approx(0.02)
    assert model.opt.timestep == 0.02
    assert not data.qfrc_applied.any()


def test_what_cannot_be_coupled_is_refused():
    with pytest.raises(ValueError, match="RK4"):
        held(bumps(1.0), 0.0, 0.008, 0.05, 1e-3, integrator="RK4")
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    with pytest.raises(KeyError, match="nowhere"):
        Coupling(model, [Mount(bumps(1.0)[0], "nowhere", "neither")])
    with pytest.raises(ValueError, match="on another body"):
        Coupling(model, [Mount(bumps(1.0)[0], "left", "left")])
    one = bumps(1.0)[0]
    with pytest.raises(ValueError, match="mounted twice"):
        held([one, one], 0.0, 0.008, 0.05, 1e-3)
    for share in (0.0, -1.0, 2.0, np.nan):
        with pytest.raises(ValueError, match="share = "):
            Coupling(model, [], share)


def test_forces_do_not_count_twice():
    """Geoms of pad and object that collide are refused, unless their bodies are excluded."""
    geom = '<geom size=".01"/>'
    pad = f'<body name="pad"><site name="pad"/>{geom}</body>'
    met = f'<body name="met"><freejoint/><site name="met"/>{geom}</body>'
    excluded = '<contact><exclude body1="pad" body2="met"/></contact>'
    for more in ("", excluded):
        text = f"<mujoco><worldbody>{pad}{met}</worldbody>{more}</mujoco>"
        given = mujoco.MjModel.from_xml_string(text), [Mount(bumps(1.0)[0], "pad", "met")]
        if more:
            Coupling(*given)
            continue
        with pytest.raises(ValueError, match='<exclude body1="pad" body2="met"/>'):
            Coupling(*given)


def test_a_step_that_is_none_and_strange_data_are_refused():
    model, coupling = held(bumps(1.0), 0.0, 0.008, 0.05, 1e-3)
    data = mujoco.MjData(model)
    for step in (0.0, -1e-3, np.nan, np.inf):
        model.opt.timestep = step
        with pytest.raises(ValueError, match="timestep = "):
            coupling.step(data)
    model.opt.timestep = 1e-3
    with pytest.raises(ValueError, match="of the coupling's model"):
        coupling.step(mujoco.MjData(mujoco.MjModel.from_xml_string("<mujoco/>")))


def test_an_episode_after_reset_is_the_same_again():
    """Data that was reset is refused until the pads are reset as well: friction has a history."""
    model, coupling = held(bumps(0.3), 0.0, 0.008, 0.05, 1e-3)
    data = mujoco.MjData(model)

    def episode():
        return [coupling.step(data)[0].wrench.tolist() for _ in range(20)]

    first = episode()
    mujoco.mj_resetData(model, data)
    with pytest.raises(ValueError, match=r"call reset\(\)"):
        coupling.step(data)
    coupling.reset()
    assert episode() == first
