"""Faults of a scene against a design: motions that the body can take, readout points inside it."""

import numpy as np

from fingerdesign.checks.body import body_faults
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.layout.bodies import crest_height, surface_height

# Neither small nor finite strain describes a finger whose object has moved by half of its height:
# rubber folds there.
MOST_MOTION = 0.5
MOST_TWIST_DEG = 10.0  # Turns are taken as small; cos 10 degrees is 0.985.
_LESS = "move the object less: no model here follows a finger so far"
_TURN_LESS = "turn the object less: rotations are taken as small"


def scene_faults(scene: Scene, design: Design) -> list[Fault]:
    """Find every fault of a scene against a design; none when it can be run.

    A body that cannot exist has its own fault: nothing is judged against it.
    """
    if body_faults(design.body):
        return []
    return _motion_faults(scene, design) + _point_faults(scene, design)


def _motion_faults(scene: Scene, design: Design) -> list[Fault]:
    if scene.path.control == "force":
        return _friction_faults(scene)
    limit = MOST_MOTION * crest_height(design.body)
    height = f"within {limit:.4g} mm, half of the finger's height"
    motions = ("an approach", "a shear", "a shear_z")
    bounds = [(limit, f"{motion} {height}", _LESS) for motion in motions]
    bounds.append((MOST_TWIST_DEG, f"a twist within {MOST_TWIST_DEG:g} degrees", _TURN_LESS))
    faults: list[Fault] = []
    rows = np.array([[*row, 0.0, 0.0][:4] for row in scene.path.rows])
    for column, (most, bound, remedy) in enumerate(bounds):
        worst = int(np.argmax(np.abs(rows[:, column])))
        value = float(rows[worst, column])
        if abs(value) > most:
            faults.append(Fault(f"path.increments_mm[{worst}][{column}]", value, bound, remedy))
    return faults


def _friction_faults(scene: Scene) -> list[Fault]:
    """Find forces that no friction carries on a plane: the worst row. Planes that slope along z are
    left out: their force may have a part there that is not prescribed. So are laws other than
    Coulomb's: the contact's area decides what they carry."""
    across, down, along = scene.object.made().normal(np.zeros((1, 3)))[0]
    if not (scene.object.flat and scene.object.law.is_coulomb) or abs(along) > 1e-12:
        return []
    slope, angle = np.arctan2(across, -down), np.arctan(scene.object.friction_coefficient)
    low, high = (float(np.tan(slope + sign * angle)) for sign in (-1.0, 1.0))
    rows = np.array([row[:2] for row in scene.path.rows])
    over = np.maximum(rows[:, 1] - high * rows[:, 0], low * rows[:, 0] - rows[:, 1])
    worst = int(np.argmax(over))
    normal, tangential = (float(force) for force in rows[worst])
    if over[worst] <= 1e-6 * normal:
        return []
    bound = f"{low * normal:.4g} to {high * normal:.4g} N, what friction carries under {normal:g} N"
    remedy = "pull less, press harder, or prescribe the motion"
    return [Fault(f"{scene.path.key}[{worst}][1]", tangential, bound, remedy)]


def _point_faults(scene: Scene, design: Design) -> list[Fault]:
    points = np.array(scene.readout.points_mm).reshape(-1, 3)
    body = design.body
    across, along = 0.5 * body.width_mm, 0.5 * body.depth_mm
    x, y, z = points.T
    over = np.maximum(np.abs(x) - across, np.abs(z) - along)
    x, z = np.clip(x, -across, across), np.clip(z, -along, along)
    if body.kind.turned:
        radius = np.hypot(points[:, 0], points[:, 2])
        over = radius - across
        x, z = points[:, 0::2].T * np.minimum(1.0, across / np.maximum(radius, 1e-12))
    top = surface_height(body, x, z)
    topless = np.isnan(top)  # where a STEP body has no top
    top = np.where(topless, 0.0, top)
    over = np.maximum(np.maximum(over, np.where(topless, 1e-3, 0.0)), np.maximum(-y, y - top))
    outside = np.flatnonzero(over > 1e-9)
    if not len(outside):
        return []
    worst = int(np.argmax(over))
    others = [str(index) for index in outside if index != worst]
    also = f"; so are {', '.join(others[:8])}{' ...' if len(others) > 8 else ''}" if others else ""
    sides = f"|x| <= {across:g}, |z| <= {along:g}"
    if body.kind.turned:
        sides = f"x^2 + z^2 <= {across:g}^2"
    bound = f"inside the body: {sides}, 0 <= y <= {top[worst]:.4f} there"
    remedy = f"move it inside: it is {over[worst]:.4g} mm outside{also}"
    return [Fault(f"readout.points_mm[{worst}]", points[worst].tolist(), bound, remedy)]
