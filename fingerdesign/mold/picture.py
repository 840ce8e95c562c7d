"""Pictures of a mold: the mold opened, each part moved along its draw, and what each step of the
casting notes puts in its place or takes away. They are drawn by render.py in another process.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.errors import PictureError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.part import (
    BASE,
    BASE_FRAME,
    CORE,
    MOUNT,
    OUTER,
    RUBBER,
    MoldMeshes,
    PartMesh,
)
from fingerdesign.mold.plan.plan import Bolt, MoldPlan
from fingerdesign.mold.products.notes import PLATES, View
from fingerdesign.mold.render import Shown, camera_axes, draw_pictures
from fingerdesign.runtime.isolate import ProcessError, Wait, concurrently

PATCH_MM = 0.06  # thickness of a gage in a picture
_QUADS = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
BOX = np.array([(a, *two) for a, b, c, d in _QUADS for two in ((b, c), (c, d))])  # its triangles
TIME_LIMIT_S = 90.0  # it takes 4 to 8 s; a software renderer on a busy machine far longer
COLOURS = {  # by the first word of a part's name
    "contact": "#5b8fc7",
    "end": "#7fae8c",
    "frame": "#7fae8c",
    "side": "#a9b6a0",
    "comb": "#c9a227",
    "base": "#8b8f99",
    "core": "#5f8f4e",
    "rubber": "#8fb4cf",
    "plate": "#b5652a",
    "gage": "#1f7a4d",
    "lead": "#b3261e",
    "mount": "#6f6a8c",
    "bolts": "#4b5563",
}


@dataclass(frozen=True)
class Badge:
    """A part's number, and where its middle is in the picture: shares from the left and top."""

    number: int
    name: str
    left: float
    top: float


@dataclass(frozen=True)
class Picture:
    """A picture, its badges, and what it shows, in words."""

    png: bytes
    badges: tuple[Badge, ...]
    alternative: str


@dataclass(frozen=True)
class Pictures:
    """The mold opened; of steps their pictures, by the section's title and the step's number."""

    opened: Picture
    steps: dict[tuple[str, int], Picture]


def numbered(meshes: MoldMeshes) -> dict[str, int]:
    """Part name -> its number in picture and table, in the order of opening, the finger last."""
    return {part.name: number for number, part in enumerate(meshes.parts, start=1)}


def exploded_parts(meshes: MoldMeshes, more: Sequence[PartMesh] = ()) -> tuple[Shown, ...]:
    """All that is drawn. The finger (rubber, plates, a core that is inside) stays in its place."""
    size = np.array(meshes.high) - np.array(meshes.low)
    return (
        *(
            Shown(part.name, part, COLOURS[part.name.split("_")[0]], _moved(part, size))
            for part in meshes.parts
        ),
        *(
            Shown(e.name, e, COLOURS[e.name.split("_")[0]])
            for e in (*meshes.plates, *more)
            if e.draw is None
        ),
        Shown("rubber", meshes.rubber, COLOURS["rubber"], opacity=0.3),
    )


def bonded(plan: MoldPlan) -> tuple[PartMesh, ...]:
    """Gages on their plates' faces, and their leads to the plates' front ends, or out on the front
    legs, as thin plates: drawn larger than they are thick."""
    gages, found = plan.design.gages, []
    leg = plan.design.mold.leads == "leg"
    for frame in plan.frames:
        tips = [each.tip for each in plan.legs_by_plate.get(frame.index, ()) if each.side[0] == "+"]
        end = max(tips) if leg and tips else frame.high
        edge = frame.middle + gages.z_mm + 0.5 * gages.width_mm
        low = edge - gages.width_mm
        for side in gages.sides:
            wide = 0.25 * min(gages.length_mm, frame.length)
            found.append(_patch(frame, f"gage_{frame.index}", side, 2.0 * wide, (low, edge)))
            found.append(_patch(frame, f"lead_{frame.index}", side, 0.5 * wide, (edge, end)))
    return (*found, *map(_bolt, plan.bolts))


def _bolt(bolt: Bolt) -> PartMesh:
    """A bolt as a bar along its axis."""
    along = {"y": 1, "z": 2}[bolt.axis]
    half = np.full(3, 0.45 * bolt.diameter)
    half[along] = 0.0
    square = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    ends = []
    for place in (bolt.low - bolt.diameter, bolt.high + bolt.diameter):
        signs = np.insert(np.array(square, dtype=float), along, 0.0, axis=1)
        ends.append(bolt.at(place) + signs * half)
    draw = (0.0, 1.0, 0.0) if bolt.axis == "y" else (0.0, 0.0, 1.0)
    return PartMesh(f"bolts_{bolt.axis}", np.vstack(ends), BOX, draw, 9, "metal", 0.0, 0.0, 0.0)


def _patch(
    frame: PlateFrame, name: str, side: float, half: float, ends: tuple[float, float]
) -> PartMesh:
    """A thin box on a plate's face, +-``half`` about its middle, between two places across."""
    near, far = 0.5 * frame.thickness, 0.5 * frame.thickness + PATCH_MM
    section = np.array([[-half, near], [half, near], [half, far], [-half, far]])
    points = [frame.from_local(s, side * v) for s, v in section]
    corners = np.vstack([frame.to_space(np.atleast_2d(p), w) for w in ends for p in points])
    return PartMesh(name, corners, BOX, None, 9, "metal", 0.0, 0.0, 0.0)


def step_parts(
    meshes: MoldMeshes, views: Sequence[View], more: Sequence[PartMesh] = ()
) -> list[tuple[Shown, ...]]:
    """Choose what is drawn of each view: what is there already is pale; what the step puts in its
    place, or takes away, is in its colour, on its way."""
    size = np.array(meshes.high) - np.array(meshes.low)
    bolts = {axis: [b for b in more if b.name == f"bolts_{axis}"] for axis in "yz"}
    more = [each for each in more if not each.name.startswith("bolts")]
    alike: dict[str, tuple[PartMesh, ...]] = {PLATES: (*meshes.plates, *more)}
    alike |= {f"bolts_{axis}": tuple(each) for axis, each in bolts.items()}
    alike |= {part.name: (part,) for part in (*meshes.parts, *meshes.coupon, meshes.rubber)}
    there: list[str] = []
    found = []
    for view in views:
        names = [name for name in view.names if name in alike]
        stays = [name for name in names if name in there]
        there = [name for name in there if name not in names]
        shown = tuple(
            _in_view(mesh, name, view, size) for name in (*there, *names) for mesh in alike[name]
        )
        # What is laid on the bench first has nowhere to go.
        found.append(shown if there else tuple(replace(e, way=(0.0, 0.0, 0.0)) for e in shown))
        if view.verb == "put":
            there += names
        elif view.verb == "move":
            there += stays
    return found


def _in_view(mesh: PartMesh, name: str, view: View, size: Array) -> Shown:
    """A thing as a view has it; name: its own, or PLATES."""
    colour = COLOURS[mesh.name.partition("_")[0]]
    if name not in view.names and mesh.name.startswith(("gage", "lead")):
        return Shown(mesh.name, mesh, colour)
    if name not in view.names:
        opacity = 0.35 if name == RUBBER else 1.0
        return Shown(mesh.name, mesh, _pale(colour), opacity=opacity)
    away = _moved(mesh, size)
    if view.way is not None:  # from where it comes
        x, y, z = (-0.2 * float(size.max()) * np.array([*view.way, 0.0])).tolist()
        if name == PLATES:  # they stay, and their legs are bent
            return Shown(mesh.name, mesh, colour, way=(-x, -y, -z))
        away = x, y, z
    elif name == PLATES:  # from above, along their slots
        x, y, z = (0.9 * size * camera_axes((0.0, 0.0, 1.0), view.up)[1]).tolist()
        away = x, y, z
    sign = 1.0 if view.verb == "take" else -1.0
    x, y, z = (sign * np.array(away)).tolist()
    return Shown(mesh.name, mesh, colour, away, way=(x, y, z))


def _pale(colour: str) -> str:
    """A colour half way to white.

    >>> _pale("#000000")
    '#8c8c8c'
    """
    parts = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return "#" + "".join(f"{round(0.45 * part + 0.55 * 255):02x}" for part in parts)


def pictures_job(
    meshes: MoldMeshes,
    views: Sequence[View],
    more: Sequence[PartMesh] = (),
    time_limit_s: float = TIME_LIMIT_S,
) -> AbstractContextManager[Wait]:
    """The drawing process; enter it to start, and give it to :func:`pictures_of`."""
    steps = [
        (things, view.up)
        for things, view in zip(step_parts(meshes, views, more), views, strict=True)
    ]
    return concurrently(draw_pictures, exploded_parts(meshes, more), steps, time_s=time_limit_s)


def pictures_of(wait: Wait, meshes: MoldMeshes, views: Sequence[View]) -> Pictures:
    """Wait for the pictures; PictureError where nothing was drawn."""
    try:
        png, places, steps = wait()
    except ProcessError as error:
        raise PictureError(str(error)) from error
    badges = tuple(
        Badge(number, name, *places[name])
        for name, number in numbered(meshes).items()
        if name in places
    )
    words = ", ".join(f"{badge.number} {badge.name.replace('_', ' ')}" for badge in badges)
    opened = Picture(
        png,
        badges,
        f"The mold opened: each part is moved along its draw. {words}. The finger with its plates "
        "and their legs is in the middle, base down (it is cast with the base up).",
    )
    drawn = {
        (view.section, view.step): Picture(step, (), view.words)
        for view, step in zip(views, steps, strict=True)
    }
    return Pictures(opened, drawn)


def _moved(part: PartMesh, size: Array) -> tuple[float, float, float]:
    """Distance by which a part is moved: sheets less than what is behind them."""
    if part.name == MOUNT:  # the base plate slides into it from its front
        return 0.0, 0.0, -1.1 * float(size[2])
    if part.draw is None and part.name not in (BASE, CORE):
        return 0.0, 0.0, 0.0
    if part.draw is None:  # a core that is inside stays
        inside = part.name == CORE and part.vertices[:, 1].min() > 1e-6
        far = 0.0 if inside else 0.45 if part.name == CORE else 0.95
        return (0.0, -far * size[1], 0.0)
    if part.name == BASE_FRAME:  # beyond the base plate
        return (0.0, -1.4 * size[1], 0.0)
    shares = (0.25, 0.75, 0.3) if part.made == "sheet" else (0.5, 0.75, 0.85)
    shares = (0.0, 0.75, 1.3) if part.name.endswith(OUTER) else shares
    x, y, z = (np.array(shares) * size * part.draw).tolist()
    return (x, y, z)
