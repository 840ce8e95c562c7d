"""Pictures of a mold: the mold opened, each part moved along its draw, and what each step of the
casting notes puts in its place or takes away. They are drawn by render.py in another process.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.errors import PictureError
from fingerdesign.mold.aids import GAGES, Aids
from fingerdesign.mold.part import (
    BASE,
    BASE_FRAME,
    CORE,
    MOUNT,
    OUTER,
    RUBBER,
    MoldMeshes,
    PartMesh,
    Point,
    colour_of,
    point,
)
from fingerdesign.mold.products.notes import PLATES, View
from fingerdesign.mold.render import STILL, Shown, camera_axes, draw_pictures
from fingerdesign.runtime.isolate import ProcessError, Wait, concurrently

TIME_LIMIT_S = 90.0  # it takes 4 to 8 s; a software renderer on a busy machine far longer
NONE: Aids = MappingProxyType({})
MAKING = "Make the parts"  # each for itself
ON_BENCH = ("Mix and pour", "Cure and open", "Finish and measure")  # what is there stays there


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


def exploded_parts(meshes: MoldMeshes, aids: Aids = NONE) -> tuple[Shown, ...]:
    """All that is drawn. The finger (rubber, plates, a core that is inside) stays in its place."""
    size = np.array(meshes.high) - np.array(meshes.low)
    return (
        *(
            Shown(part.name, part, colour_of(part.name), _moved(part, size))
            for part in meshes.parts
        ),
        *(Shown(e.name, e, colour_of(e.name)) for e in (*meshes.plates, *aids.get(GAGES, ()))),
        Shown("rubber", meshes.rubber, colour_of("rubber"), opacity=0.3),
    )


def step_parts(
    meshes: MoldMeshes, views: Sequence[View], aids: Aids = NONE
) -> list[tuple[Shown, ...]]:
    """Choose what is drawn of each view: what is there already is pale; what the step puts in its
    place, or takes away, is in its colour, on its way."""
    size = np.array(meshes.high) - np.array(meshes.low)
    plates = {PLATES: (*meshes.plates, *aids.get(GAGES, ()))}  # with what is on them
    parts = {part.name: (part,) for part in (*meshes.parts, *meshes.coupon, meshes.rubber)}
    alike = {**plates, **aids, **parts}  # by the names of views
    return [_of_view(view, there, alike, size) for view, there in _already_there(views, set(alike))]


def _already_there(views: Sequence[View], known: set[str]) -> Iterator[tuple[View, list[str]]]:
    """Each view with the names of what is there before its step, without what the step moves."""
    there: list[str] = []
    section = ""
    for view in views:
        if view.section == MAKING or view.section not in (section, *ON_BENCH):
            there = []
        section = view.section
        there = [name for name in there if name != "spacers" or view.up == "+z"]
        stays = [name for name in view.names if name in there]
        there = [name for name in there if name not in view.names]
        yield view, list(there)
        if view.verb == "put":
            there += [name for name in view.names if name in known]
        elif view.verb == "move":
            there += stays


def _of_view(
    view: View, there: Sequence[str], alike: Mapping[str, tuple[PartMesh, ...]], size: Array
) -> tuple[Shown, ...]:
    """Draw what is there and what the step moves. What is laid on the bench first has nowhere to
    go but down."""
    names = [*there, *(name for name in view.names if name in alike)]
    shown = [_in_view(mesh, name, view, size) for name in names for mesh in alike[name]]
    above = camera_axes((0.0, 0.0, 1.0), view.up)[1]
    return tuple(e if there or above @ e.way < 0.0 else replace(e, way=STILL) for e in shown)


def _in_view(mesh: PartMesh, name: str, view: View, size: Array) -> Shown:
    """A thing as a view has it; name: its own, or PLATES."""
    colour = colour_of(mesh.name)
    if name not in view.names and mesh.name.startswith(("gage", "lead")):
        return Shown(mesh.name, mesh, colour)
    if name not in view.names:
        opacity = 0.35 if name == RUBBER else 1.0
        return Shown(mesh.name, mesh, _pale(colour), opacity=opacity)
    away = _moved(mesh, size)
    if view.way is not None:  # from where it comes
        away = point(-0.2 * float(size.max()) * np.array([*view.way, 0.0]))
        if name in (PLATES, MOUNT):  # they stay: legs are bent, the hand is below
            return Shown(mesh.name, mesh, colour, way=point(-np.array(away)))
    elif name == PLATES or (name.startswith("side_wall") and view.up == "+z"):  # from above
        away = point(0.9 * size * camera_axes((0.0, 0.0, 1.0), view.up)[1])
    elif name == f"bolts_{view.up[1]}" and view.up[0] == "-":
        away = point(-np.array(away))  # a bolt comes from above
    sign = 1.0 if view.verb == "take" else -1.0
    return Shown(mesh.name, mesh, colour, away, way=point(sign * np.array(away)))


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
    aids: Aids = NONE,
    time_limit_s: float = TIME_LIMIT_S,
) -> AbstractContextManager[Wait]:
    """The drawing process; enter it to start, and give it to :func:`pictures_of`."""
    steps = [
        (things, view.up)
        for things, view in zip(step_parts(meshes, views, aids), views, strict=True)
    ]
    return concurrently(draw_pictures, exploded_parts(meshes, aids), steps, time_s=time_limit_s)


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


def _moved(part: PartMesh, size: Array) -> Point:
    """Distance by which a part is moved: sheets less than what is behind them."""
    inside = part.name == CORE and part.vertices[:, 1].min() > 1e-6  # such a core stays
    fixed = {
        MOUNT: (0.0, 0.0, -1.1),  # the base plate slides into it from its front
        BASE: (0.0, -0.95, 0.0),
        BASE_FRAME: (0.0, -1.4, 0.0),  # beyond the base plate
        CORE: (0.0, 0.0 if inside else -0.45, 0.0),
    }
    if part.name in fixed or part.draw is None:
        return point(size * fixed.get(part.name, STILL))
    shares = (0.25, 0.75, 0.3) if part.made == "sheet" else (0.5, 0.75, 0.85)
    shares = (0.0, 0.75, 1.3) if part.name.endswith(OUTER) else shares
    return point(np.array(shares) * size * part.draw)
