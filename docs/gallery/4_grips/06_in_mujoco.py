"""
A gripper inside MuJoCo
=======================

MuJoCo moves the rigid bodies. Both pads are our contact model in 3-D: in each step it reads poses
and returns forces and gages. ``MUJOCO_GL=egl python 06_in_mujoco.py lift.gif`` writes the film.

.. image:: ../../images/lift.gif
"""

import sys

import mujoco
import numpy as np
from matplotlib import animation, pyplot

from fingerdesign.checks.load import load_design
from fingerdesign.design.scene import SceneObject
from fingerdesign.layout.bodies import crest_height
from fingerdesign.robots.mujoco import Coupling, Mount
from fingerdesign.robots.pad import pad_of

BOX = '<geom type="box" size=".02 .02 .02" mass=".3" rgba=".8 .6 .3 1"/>'
BOTTLE = """<geom type="cylinder" size=".02 .02" mass=".25" rgba=".3 .6 .4 1"/>
<geom type="cylinder" size=".007 .014" pos="0 0 .034" mass=".05" rgba=".3 .6 .4 1"/>"""
OBJECTS = {BOX: None, BOTTLE: SceneObject(shape="cylinder", radius_mm=20.0, axis="x")}
FINGER = """<body pos="{x} 0 0"><joint name="{side}" type="slide" axis="{sign} 0 0" damping="60"/>
<geom type="box" size=".004 .008 .012" mass=".15" contype="0" conaffinity="0"/>
<site name="{side}_pad" xyaxes="0 0 1 {sign} 0 0"/></body>"""
FACE = '<site name="{side}_face" pos="{x} 0 0" xyaxes="0 0 1 {sign} 0 0"/>'
WORLD = """<mujoco><visual><headlight ambient=".6 .6 .6"/></visual><worldbody><geom type="plane"
size="1 1 .1"/><camera name="front" pos="0 -.2 .062" xyaxes="1 0 0 0 .2 1"/>
<body pos="0 0 .02"><joint name="lift" type="slide" axis="0 0 1" damping="100"/>
<geom size=".01" pos="0 -.3 0" mass=".5" contype="0" conaffinity="0"/>{fingers}</body>
<body pos="0 0 .02"><joint type="slide" axis="1 0 0"/><joint name="rise" type="slide" axis="0 0 1"/>
<joint type="hinge" axis="0 1 0"/>{met}</body></worldbody><actuator>
<position joint="left" kp="4e4"/><position joint="right" kp="4e4"/>
<position joint="lift" kp="2e4"/></actuator></mujoco>"""
design, sides = load_design("sensitive"), {"left": 1, "right": -1}
away = 0.0202 + 1e-3 * crest_height(design.body)  # of a finger's base at the start, m
(figure, axes), film = pyplot.subplots(2, 3, figsize=(9.0, 4.4), layout="constrained"), ([], [])
for (view, forces, gages), (geoms, met), seen in zip(axes, OBJECTS.items(), film, strict=True):
    faces = "".join(FACE.format(side=s, sign=k, x=-0.02 * k) for s, k in sides.items())
    fingers = "".join(FINGER.format(side=s, sign=k, x=-away * k) for s, k in sides.items())
    model = mujoco.MjModel.from_xml_string(WORLD.format(fingers=fingers, met=geoms + faces))
    # Half a finger, as the object moves in its plane; a free object needs whole=True.
    pads = [Mount(pad_of(design, 0.5, "3d", False, met), f"{s}_pad", f"{s}_face") for s in sides]
    coupling, data, rows = Coupling(model, pads), mujoco.MjData(model), []
    while data.time < 0.7:
        t, shake = data.time, 0.004 * np.sin(40.0 * max(data.time - 0.5, 0.0))
        data.ctrl[:] = *[5e-4 * min(1.0, t / 0.2)] * 2, 0.02 * np.clip(5 * t - 1.25, 0, 1) + shake
        touch = coupling.step(data)[0]
        assert not touch.outside  # A rotation of more than 3 degrees would be named here.
        rows.append((t, touch.normal_force, 1e3 * data.joint("rise").qpos[0], *touch.readings))
        if sys.argv[1:] and len(rows) % 10 == 1:
            (renderer := mujoco.Renderer(model, 240, 240)).update_scene(data, "front")
            now = [forces.axvline(t, color="k"), gages.axvline(t, color="k")]
            seen.append([view.imshow(renderer.render()), *now])
    forces.plot([row[0] for row in rows], [row[1:3] for row in rows])
    forces.set_ylabel("force, N (blue); rise, mm")
    gages.plot([row[0] for row in rows], [row[3:] for row in rows])
    gages.set_ylabel("gages, microstrain")
if frames := [box + bottle for box, bottle in zip(*film, strict=True)]:
    animation.ArtistAnimation(figure, frames).save(sys.argv[1], "pillow", fps=10, dpi=60)
pyplot.show()
