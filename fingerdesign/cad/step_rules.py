"""The rules of ``[body.step]``: base and contact surface of a STEP body, and what it must be.

Numpy only; runs in a process of its own. Faults are DesignErrors that name what the rules met.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.faults import at_most
from fingerdesign.errors import DesignError, Fault
from fingerdesign.shapes.faces import CadFace, nearest, top_height

BASE_DEG = 0.01  # a base is flat and clamped: 0.01 degrees of 20 mm are 3 micrometres
SIZES_MM = (1.0, 500.0)  # of an extent along x or z: those of every body
FACING_DEG = 60.0  # a base within it of contact_direction looks where the object comes from
MIRROR_MM = 1e-5  # between the solid and its mirror image
_NAMED = 8  # faces named in a fault


def refused(key: str, value: object, bound: str, remedy: str) -> DesignError:
    """The error of one fault of a file or rule."""
    return DesignError([Fault(f"body.step.{key}", value, bound, remedy)])


def on_base(faces: Sequence[CadFace], low: Array, rules: Mapping[str, Any]) -> Array:
    """Offset (3,) of the solid from y = 0: its base's height, or its lowest point's where the
    base does not face down."""
    direction = _unit(rules["base_direction"])
    if direction[1] > -np.cos(np.radians(BASE_DEG)):
        return np.array([0.0, low[1], 0.0])
    base = _base(faces, rules)
    height = -_offset(faces[base[0]])
    if low[1] < height - 1e-4:
        raise refused(
            "base_direction",
            list(rules["base_direction"]),
            "the direction of the lowest, flat face",
            f"the solid reaches {height - low[1]:.4g} mm below its lowest flat face; the base "
            "must be the flat end of the body",
        )
    return np.array([0.0, height, 0.0])


def picks(
    faces: Sequence[CadFace], middles: Array, normals: Array, rules: Mapping[str, Any]
) -> tuple[list[int], list[int]]:
    """Numbers of the base's and of the contact surface's faces; middles, normals (faces, 3)."""
    base = _base(faces, rules)
    facing = _unit(rules["contact_direction"])
    angle = np.degrees(np.arccos(np.clip(normals @ facing, -1.0, 1.0)))
    close = angle <= rules["contact_angle_deg"] + 1e-9
    if (close[base] & (angle[base] <= FACING_DEG)).any():
        raise refused(
            "base_direction",
            list(rules["base_direction"]),
            "the outward normal of a face that looks away from contact_direction = "
            f"{list(rules['contact_direction'])}: base and contact pick the same face",
            "leave it out where the base looks down, as the body lies after body.step.up, or name "
            "the flat face that is fixed",
        )
    above = middles[:, 1] > rules["contact_above_mm"]
    contact = [k for k in np.flatnonzero(close & above).tolist() if k not in base]
    if contact:
        return base, contact
    free = [k for k in range(len(faces)) if k not in base]
    fit = np.intersect1d(np.flatnonzero(close), free)
    if len(fit):
        highest = at_most(float(middles[fit, 1].max()))
        raise refused(
            "contact_above_mm",
            rules["contact_above_mm"],
            "below the middle of a face that looks along contact_direction",
            f"lower it to less than {highest}: the highest such middle is at y = {highest}",
        )
    reported = _reported([faces[k] for k in free], normals[free], middles[free])
    raise refused(
        "contact_direction",
        list(rules["contact_direction"]),
        f"within contact_angle_deg = {rules['contact_angle_deg']:g} of a face's outward normal",
        "turn the body with body.step.up, or widen the angle; the faces look, at their middles, "
        f"along {reported}",
    )


def _base(faces: Sequence[CadFace], rules: Mapping[str, Any]) -> list[int]:
    """The farthest flat faces that look along base_direction."""
    direction = _unit(rules["base_direction"])
    flat = [k for k, face in enumerate(faces) if face.flat]
    near = np.cos(np.radians(BASE_DEG))
    along = [k for k in flat if float(_outward(faces[k]) @ direction) >= near]
    if not along:
        outward = np.array([_outward(faces[k]) for k in flat]).reshape(-1, 3)
        reported = _reported([faces[k] for k in flat], outward, None)
        raise refused(
            "base_direction",
            list(rules["base_direction"]),
            "the outward normal of a flat face, the base",
            f"turn the body with body.step.up; its flat faces look along {reported or 'nowhere'}",
        )
    farthest = max(_offset(faces[k]) for k in along)
    return [k for k in along if _offset(faces[k]) > farthest - 1e-4]


def named(
    faces: Sequence[CadFace], base: Sequence[int], contact: Sequence[int], low: Array, high: Array
) -> list[str]:
    """ "base", "contact", "end" (flat, at the extremes of z) or "side" for each face."""
    names = []
    for number, face in enumerate(faces):
        if number in base:
            names.append("base")
        elif number in contact:
            names.append("contact")
        elif face.flat and abs(_outward(face)[2]) > 1.0 - 1e-9:
            limit = high[2] if _outward(face)[2] > 0.0 else -low[2]
            names.append("end" if _offset(face) > limit - 1e-5 else "side")
        else:
            names.append("side")
    return names


def check_body(faces: Sequence[CadFace], low: Array, high: Array, name: str) -> None:
    """DesignError unless the solid has a finger's size and a crest over x = z = 0."""
    for axis in (0, 2):
        size = float(high[axis] - low[axis])
        if not SIZES_MM[0] <= size <= SIZES_MM[1]:
            bound = f"a body of {SIZES_MM[0]:g} to {SIZES_MM[1]:g} mm along x and z"
            remedy = f"it has {size:.4g} mm along {'xyz'[axis]}; check its unit and body.step.up"
            raise refused("file", name, bound, remedy)
    crest = top_height([face for face in faces if face.name == "contact"], *np.zeros((2, 1)))[0]
    if not crest > 0.0:
        raise refused(
            "file",
            name,
            "a body whose contact surface lies over x = z = 0",
            "there the object first touches: move the body (or set body.step.centre), or pick "
            "other faces by body.step.contact_direction, contact_angle_deg, contact_above_mm",
        )


def check_mirror(faces: Sequence[CadFace], name: str) -> None:
    """DesignError unless points of the solid's edges and faces lie on it when mirrored in z = 0.

    Of every face's inside too: the image of a hole's edges lies on the faces that it leaves.
    """
    borders = [face.border.start[::7] for face in faces]
    places = np.vstack(borders + [face.samples[len(face.border.start) :: 7] for face in faces])
    misfit = nearest(faces, places * np.array([1.0, 1.0, -1.0]))[3]
    worst = float(misfit.max(initial=0.0))
    if worst > MIRROR_MM:
        raise refused(
            "mirrors_in_z",
            "true",
            "false for a body that is not its own mirror image in z = 0",
            f"{name}: the mirror image of an edge or face lies {worst:.2g} mm from the solid's; "
            "remove the key",
        )


def _unit(direction: Sequence[float]) -> Array:
    vector = np.array(direction, dtype=float)
    return np.asarray(vector / np.linalg.norm(vector))


def _outward(face: CadFace) -> Array:
    return np.asarray(face.normal(np.zeros((1, 3)))[0])


def _offset(face: CadFace) -> float:
    """outward . point of a flat face, mm."""
    return -float(face.distance(np.zeros((1, 3)))[0])


def _reported(faces: Sequence[CadFace], normals: Array, middles: Array | None) -> str:
    """Directions, largest faces first, as "[0, 1, 0] at y = 12.7"."""
    order = np.argsort([-face.area for face in faces])[:_NAMED]
    words = []
    for k in order:
        text = "[" + ", ".join(f"{value + 0.0:.3g}" for value in np.round(normals[k], 3)) + "]"
        words.append(text if middles is None else f"{text} at y = {middles[k, 1]:.4g}")
    return ", ".join(dict.fromkeys(words))
