"""
A gripper inside MuJoCo
=======================

MuJoCo moves the rigid bodies. Both pads are our contact model: in each step it reads the poses and
returns forces, gages and the stick ratio. The gripper closes, lifts the box, and shakes it.
"""

import mujoco
import numpy as np
from matplotlib import pyplot

from fingerdesign.checks.load import load_design
from fingerdesign.layout.bodies import crest_height
from fingerdesign.robots.mujoco import Coupling, Mount
from fingerdesign.robots.pad import pad_of

SIDES = {"left": 1, "right": -1}
design = load_design("sensitive")
away = 0.02 + 1e-3 * crest_height(design.body) + 2e-4  # of a finger's base at the start, m
finger = """<body pos="{x} 0 0"><joint name="{side}" type="slide" axis="{sign} 0 0" damping="60"/>
<geom type="box" size=".004 .008 .012" mass=".15" contype="0" conaffinity="0"/>
<site name="{side}_pad" xyaxes="0 0 1 {sign} 0 0"/></body>"""
face = '<site name="{side}_face" pos="{x} 0 0" xyaxes="0 0 1 {sign} 0 0"/>'
drive = '<position joint="{side}" kp="4e4" ctrlrange="0 .01"/>'


def both(text, x=0.0):
    """Fill in a text for each side."""
    return "".join(text.format(side=side, sign=k, x=-k * x) for side, k in SIDES.items())


model = mujoco.MjModel.from_xml_string(f"""
<mujoco><option timestep="1e-3"/><worldbody><geom type="plane" size="1 1 .1"/>
<body pos="0 0 .02"><joint name="lift" type="slide" axis="0 0 1" damping="100"/>
<geom size=".01" pos="0 .04 0" mass=".5" contype="0" conaffinity="0"/>{both(finger, away)}</body>
<body name="box" pos="0 0 .02"><joint type="slide" axis="1 0 0"/>
<joint name="rise" type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>
<geom type="box" size=".02 .02 .02" mass=".3"/>{both(face, 0.02)}</body>
</worldbody><actuator>{both(drive)}<position joint="lift" kp="2e4"/></actuator></mujoco>""")

# The section alone, as the box moves in its plane; a free box needs pad_of(design, 0.5).
mounts = [Mount(pad_of(design, 0.5, "plane-strain"), f"{s}_pad", f"{s}_face") for s in SIDES]
coupling = Coupling(model, mounts)
data = mujoco.MjData(model)
rows, readings = [], []
while data.time < 0.7:
    t = data.time
    shake = 0.004 * np.sin(40.0 * max(t - 0.5, 0.0))
    data.ctrl[:] = *[5e-4 * min(1.0, t / 0.2)] * 2, 0.02 * np.clip(5 * t - 1.25, 0, 1) + shake
    touch = coupling.step(data)[0]
    assert not touch.outside
    stick = np.nan if touch.measures is None else touch.measures.stick_ratio
    rows.append((t, touch.normal_force, 1e3 * data.joint("rise").qpos[0], stick))
    readings.append(touch.readings)

time, normal, rise, stick = np.array(rows).T
figure, axes = pyplot.subplots(3, 1, figsize=(7.2, 6.0), sharex=True, layout="constrained")
axes[0].plot(time, np.column_stack([normal, rise]))
axes[0].legend(["normal force, N", "rise of the box, mm"])
axes[1].plot(time, stick)
axes[2].plot(time, readings, lw=0.8)
for each, words in zip(axes[1:], ("stick ratio", "gages over time in s"), strict=True):
    each.set_ylabel(words)
pyplot.show()
