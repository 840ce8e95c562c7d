"""Pictures of a mold, drawn off-screen, in a process of its own: the mold opened, each part moved
along its draw, and what each step of the casting notes puts in its place or takes away.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from fingerdesign.arrays import Array
from fingerdesign.errors import PictureError
from fingerdesign.mold.part import BASE, BASE_FRAME, CORE, OUTER, RUBBER, MoldMeshes, PartMesh
from fingerdesign.mold.products.notes import PLATES, Up, View
from fingerdesign.runtime.isolate import ProcessError, Wait, concurrently

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
}


@dataclass(frozen=True)
class Shown:
    """One thing in the picture: its triangles, how far it is moved, its look."""

    name: str
    mesh: PartMesh
    colour: str
    move: tuple[float, float, float] = (0.0, 0.0, 0.0)
    opacity: float = 1.0

    @property
    def points(self) -> Array:
        """Its vertices where it is drawn."""
        return np.asarray(self.mesh.vertices + np.array(self.move))


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


def exploded_parts(meshes: MoldMeshes) -> tuple[Shown, ...]:
    """All that is drawn. The finger (rubber, plates, a core that is inside) stays in its place."""
    size = np.array(meshes.high) - np.array(meshes.low)
    return (
        *(
            Shown(part.name, part, COLOURS[part.name.split("_")[0]], _moved(part, size))
            for part in meshes.parts
        ),
        *(Shown(plate.name, plate, COLOURS["plate"]) for plate in meshes.plates),
        Shown("rubber", meshes.rubber, COLOURS["rubber"], opacity=0.3),
    )


def step_parts(meshes: MoldMeshes, views: Sequence[View]) -> list[tuple[Shown, ...]]:
    """Choose what is drawn of each view: what is there already is pale; what the step puts in its
    place, or takes away, is in its colour, on its way."""
    size = np.array(meshes.high) - np.array(meshes.low)
    alike = {PLATES: meshes.plates}
    alike |= {part.name: (part,) for part in (*meshes.parts, meshes.rubber)}
    there: list[str] = []
    found = []
    for view in views:
        names = [name for name in view.names if name in alike]
        there = [name for name in there if name not in names]
        found.append(
            tuple(
                _in_view(mesh, name, view, size)
                for name in (*there, *names)
                for mesh in alike[name]
            )
        )
        if not view.taken:
            there += names
    return found


def _in_view(mesh: PartMesh, name: str, view: View, size: Array) -> Shown:
    """A thing as a view has it; name: its own, or PLATES."""
    colour = COLOURS[mesh.name.split("_")[0]]
    if name not in view.names:
        opacity = 0.35 if name == RUBBER else 1.0
        return Shown(mesh.name, mesh, _pale(colour), opacity=opacity)
    away = _moved(mesh, size)
    if name == PLATES:  # from above, along their slots
        x, y, z = (0.9 * size * camera_axes((0.0, 0.0, 1.0), view.up)[1]).tolist()
        away = x, y, z
    return Shown(mesh.name, mesh, colour, away)


def _pale(colour: str) -> str:
    """A colour half way to white.

    >>> _pale("#000000")
    '#8c8c8c'
    """
    parts = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return "#" + "".join(f"{round(0.45 * part + 0.55 * 255):02x}" for part in parts)


def pictures_job(
    meshes: MoldMeshes, views: Sequence[View], time_limit_s: float = TIME_LIMIT_S
) -> AbstractContextManager[Wait]:
    """The drawing process; enter it to start, and give it to :func:`pictures_of`."""
    steps = [
        (things, view.up) for things, view in zip(step_parts(meshes, views), views, strict=True)
    ]
    return concurrently(draw_pictures, exploded_parts(meshes), steps, time_s=time_limit_s)


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


# The drawing, in a process of its own.

SIZE, STEP_SIZE = (1200, 940), (560, 420)
VIEW_ANGLE, FILLED = 25.0, 0.94  # degrees, vertical; the part of the frame that may be used


def png_of(plotter: Any) -> bytes:
    """Write what a plotter shows as PNG on nothing."""
    png = io.BytesIO()
    plotter.screenshot(png, transparent_background=True)
    return png.getvalue()


def plotter_of(size: tuple[int, int]) -> Any:
    """An off-screen plotter in which what is translucent is drawn in its order."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    plotter.enable_anti_aliasing("ssaa")
    plotter.enable_depth_peeling(6)
    return plotter


def camera_axes(toward: Sequence[float], up: Up = "+y") -> Array:
    """Unit vectors (3, 3) to the right and up in a picture, and to the camera, which is where
    ``toward`` points when y is up; turned as a whole until ``up`` is."""
    out = np.array(toward) / np.linalg.norm(toward)
    right = np.cross([0.0, 1.0, 0.0], out)
    right /= np.linalg.norm(right)
    axes = np.array([right, np.cross(out, right), out])
    turns = {"+y": ("x", 0), "-y": ("z", 180), "+z": ("x", 90), "-z": ("x", -90)}
    turns |= {"+x": ("z", -90), "-x": ("z", 90)}
    axis, angle = turns[up]
    return np.asarray(Rotation.from_euler(axis, angle, degrees=True).apply(axes))


def camera_at(points: Array, axes: Array, size: tuple[int, int]) -> Array:
    """Place of a camera of :func:`camera_axes`, as near as keeps every point in its frame.

    At distance d a point (x, y, z) in the camera's axes is in a frame of slope s about a where
    |x - a| <= s (d - z): with h = max(s z + x), l = max(s z - x), a = (h - l) / 2 and
    s d >= (h + l) / 2; the same for y.
    """
    place = points @ axes.T
    slopes = FILLED * np.tan(np.radians(0.5 * VIEW_ANGLE)) * np.array([size[0] / size[1], 1.0])
    depth = slopes * place[:, 2:]
    high, low = (depth + place[:, :2]).max(axis=0), (depth - place[:, :2]).max(axis=0)
    distance = (0.5 * (high + low) / slopes).max()
    return np.asarray(np.append(0.5 * (high - low), distance) @ axes)


def aim(plotter: Any, position: Array, axes: Array) -> None:
    """Set a plotter's camera to a position and :func:`camera_axes`."""
    camera = plotter.camera
    camera.position, camera.view_angle, camera.up = position, VIEW_ANGLE, axes[1]
    camera.focal_point = position - axes[2]
    plotter.reset_camera_clipping_range()


AXES = camera_axes((-0.72, 0.52, 1.0))  # the camera is in front, to the left, above
EDGE, TRAIL = "#2f3a44", "#8a8f96"


STEEP_VIEW = (-0.72, 0.95, 1.0)  # of steps: into what is open above


def draw_pictures(
    opened: tuple[Shown, ...], steps: Sequence[tuple[tuple[Shown, ...], Up]]
) -> tuple[bytes, dict[str, tuple[float, float]], list[bytes]]:
    """The mold opened as PNG; by name a place in it where a thing is seen, shares from the left and
    the top (what nothing is seen of has none); a PNG a step. pyvista's errors pass."""
    camera = camera_at(np.vstack([thing.points for thing in opened]), AXES, SIZE)
    png, places = _drawn(opened, camera, AXES, SIZE), _seen(opened, camera)
    pngs = []
    for things, up in steps:
        axes = camera_axes(STEEP_VIEW, up)
        place = camera_at(np.vstack([thing.points for thing in things]), axes, STEP_SIZE)
        pngs.append(_drawn(things, place, axes, STEP_SIZE))
    return png, places, pngs


def _drawn(things: Sequence[Shown], camera: Array, axes: Array, size: tuple[int, int]) -> bytes:
    import pyvista

    plotter = plotter_of(size)
    for thing in things:
        solid = pyvista.PolyData.from_regular_faces(thing.points, thing.mesh.triangles)
        look = {"color": thing.colour, "opacity": thing.opacity}
        plotter.add_mesh(solid, **look, smooth_shading=False, ambient=0.22)
        edges = solid.extract_feature_edges(feature_angle=25, manifold_edges=False)
        if edges.n_cells:
            plotter.add_mesh(edges, color=EDGE, line_width=1.2)
        move = np.array(thing.move)
        if np.linalg.norm(move) > 0.0:  # from its place to where it is drawn
            middle = 0.5 * (thing.points.min(axis=0) + thing.points.max(axis=0))
            plotter.add_mesh(pyvista.Line(middle - move, middle), color=TRAIL, line_width=1.5)
    aim(plotter, camera, axes)
    plotter.add_axes(color=TRAIL, line_width=3, viewport=(0.0, 0.0, 0.12, 0.16))
    png = png_of(plotter)
    plotter.close()
    return png


def _seen(things: tuple[Shown, ...], camera: Array) -> dict[str, tuple[float, float]]:
    """Find the place of each thing that is seen best: the middle of its largest uncovered disc."""
    import pyvista
    from scipy.ndimage import distance_transform_edt

    width, height = SIZE[0] // 2, SIZE[1] // 2
    plotter = pyvista.Plotter(off_screen=True, window_size=(width, height))
    plotter.disable_anti_aliasing()
    plotter.set_background("white")
    for k, thing in enumerate(things):
        if thing.opacity == 1.0:  # what is translucent covers nothing
            colour = tuple((k + 1) >> shift & 255 for shift in (16, 8, 0))
            solid = pyvista.PolyData.from_regular_faces(thing.points, thing.mesh.triangles)
            plotter.add_mesh(solid, color=colour, lighting=False)
    aim(plotter, camera, AXES)
    image = plotter.screenshot(return_img=True).astype(np.int64)
    plotter.close()
    number = (image[..., 0] << 16) + (image[..., 1] << 8) + image[..., 2] - 1
    places = {}
    for k, thing in enumerate(things):
        inside = distance_transform_edt(np.pad(number == k, 1))[1:-1, 1:-1]
        if inside.max() >= 2.0:
            row, column = np.unravel_index(inside.argmax(), inside.shape)
            places[thing.name] = (
                round((float(column) + 0.5) / width, 4),
                round((float(row) + 0.5) / height, 4),
            )
    return places
