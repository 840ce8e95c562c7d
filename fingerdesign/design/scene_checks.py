"""Whether a scene suits a design: motions that the body can take, readout points inside it."""

from __future__ import annotations

import numpy as np

from fingerdesign.design.layout import crest_height, surface_height
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault

# Small strain is long past where the object has moved by half of the finger's height.
MOST_MOTION = 0.5


def scene_faults(scene: Scene, design: Design) -> list[Fault]:
    """Every fault of a sound scene against a sound design; empty when it can be run."""
    faults: list[Fault] = []
    limit = MOST_MOTION * crest_height(design.body)
    rows = np.array(scene.path.increments_mm)
    for column, name in enumerate(("approach", "shear")):
        worst = int(np.argmax(np.abs(rows[:, column])))
        value = float(rows[worst, column])
        if abs(value) > limit:
            faults.append(
                Fault(
                    f"path.increments_mm[{worst}][{column}]",
                    value,
                    f"an {name} within {limit:.4g} mm, half of the finger's height"
                    if name == "approach"
                    else f"a {name} within {limit:.4g} mm, half of the finger's height",
                    "move the object less: strains are taken as small",
                )
            )
    return faults + _point_faults(scene, design)


def _point_faults(scene: Scene, design: Design) -> list[Fault]:
    body = design.body
    faults = []
    for index, (x, y, z) in enumerate(scene.readout.points_mm):
        across, along = 0.5 * body.width_mm, 0.5 * body.depth_mm
        key = f"readout.points_mm[{index}]"
        if abs(x) > across or abs(z) > along:
            bound = f"inside the body: |x| <= {across:g}, |z| <= {along:g}"
            faults.append(Fault(key, [x, y, z], bound, "move it inside"))
            continue
        top = float(surface_height(body, x, z))
        if not 0.0 <= y <= top:
            bound = f"inside the body: 0 <= y <= {top:.4f} there"
            faults.append(Fault(key, [x, y, z], bound, "move it inside"))
    return faults
