"""A mold's report.html: verdict, picture, casting notes to tick, tables; offline and printable.

The picture shows each part moved along its draw; it is drawn off-screen, in a process of its own.
"""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.errors import PictureError
from fingerdesign.mold.part import CORE, OUTER, MoldMeshes, PartMesh, axis_name
from fingerdesign.report.page import rendered
from fingerdesign.report.table import number_text
from fingerdesign.runtime.isolate import ProcessError, Wait, beside

if TYPE_CHECKING:
    from fingerdesign.mold.record import CheckData, HoleData, MoldData

TEMPLATE = Path(__file__).parent / "templates" / "mold.html.j2"


def mold_html(record: MoldData, picture: Exploded | None, missing: str = "") -> str:
    """The page, from what mold_report.json holds; ``missing`` says why there is no picture."""
    return rendered(
        TEMPLATE,
        data=record,
        picture=picture,
        missing=missing,
        kinds=kinds_of(record["checks"]),
        labels=labels(record["base"]["holes"]),
        axis_name=axis_name,
        measure=measure,
        number=number_text,
    )


def labels(holes: list[HoleData]) -> list[str]:
    """A label a hole: its kind's letter, and a number where there are more of them.

    >>> labels([{"kind": "gate"}, {"kind": "vent"}, {"kind": "vent"}])
    ['G', 'V1', 'V2']
    """
    kinds = [hole["kind"] for hole in holes]
    numbers = [kinds[: k + 1].count(kind) for k, kind in enumerate(kinds)]
    return [
        f"{kind[0].upper()}{number if kinds.count(kind) > 1 else ''}"
        for kind, number in zip(kinds, numbers, strict=True)
    ]


def kinds_of(checks: list[CheckData]) -> list[dict[str, Any]]:
    """What was checked: of each kind how often, how many failed, and the one nearest its bound."""
    found = []
    for name in dict.fromkeys(check["name"] for check in checks):
        alike = [check for check in checks if check["name"] == name]
        failed = [check for check in alike if not check["ok"]]
        nearest = min(failed or alike, key=_room)
        found.append({"checked": len(alike), "failed": len(failed), "nearest": nearest})
    return found


def _room(check: CheckData) -> float:
    """How far a measure is from its bound, relative to the larger; 0: at it, or not reported."""
    measured, bound = check["measured"], check["bound"]
    if measured is None or bound is None:
        return 0.0
    most = max(abs(measured), abs(bound))
    return float(abs(measured - bound) / most) if most > 0.0 else 0.0


def measure(value: float | None) -> str:
    """A measured value in four digits; a dash where there is none.

    >>> measure(0.123456), measure(None), measure(0.0), measure(15.0)
    ('0.1235', '–', '0', '15')
    """
    if value is None or not math.isfinite(value):
        return "–"
    return "0" if abs(value) < 1e-12 else f"{value:.4g}"


TIME_LIMIT_S = 60.0  # it takes 2 to 4 s; a software renderer on a busy machine far longer
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
class Exploded:
    """The picture, its badges, and what it shows, in words."""

    png: bytes
    badges: tuple[Badge, ...]
    alternative: str


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


def exploded_job(
    meshes: MoldMeshes, time_limit_s: float = TIME_LIMIT_S
) -> AbstractContextManager[Wait]:
    """The drawing process; enter it to start, and give it to :func:`exploded_of`."""
    return beside(draw_exploded, exploded_parts(meshes), time_s=time_limit_s)


def exploded_of(wait: Wait, meshes: MoldMeshes) -> Exploded:
    """What was drawn; PictureError says why nothing was."""
    try:
        png, places = wait()
    except ProcessError as error:
        raise PictureError(str(error)) from error
    badges = tuple(
        Badge(number, name, *places[name])
        for name, number in numbered(meshes).items()
        if name in places
    )
    words = ", ".join(f"{badge.number} {badge.name.replace('_', ' ')}" for badge in badges)
    return Exploded(
        png,
        badges,
        f"The mold opened: each part is moved along its draw. {words}. The finger with its plates "
        "and their legs stands in the middle, base down (it is cast with the base up).",
    )


def _moved(part: PartMesh, size: Array) -> tuple[float, float, float]:
    """How far a part is moved: sheets less than what is behind them."""
    if part.draw is None:  # a core that is inside stays
        inside = part.name == CORE and part.vertices[:, 1].min() > 1e-6
        far = 0.0 if inside else 0.45 if part.name == CORE else 0.95
        return (0.0, -far * size[1], 0.0)
    shares = (0.25, 0.75, 0.3) if part.made == "sheet" else (0.5, 0.75, 0.85)
    shares = (0.0, 0.75, 1.3) if part.name.endswith(OUTER) else shares
    x, y, z = (np.array(shares) * size * part.draw).tolist()
    return (x, y, z)


# The drawing, in a process of its own.

SIZE = (1200, 940)
VIEW_ANGLE, FILLED = 25.0, 0.94  # degrees, vertical; the part of the frame that may be used


def png_of(plotter: Any) -> bytes:
    """What a plotter shows, as PNG on nothing."""
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


def camera_axes(toward: Sequence[float]) -> Array:
    """Unit vectors (3, 3) to the right and up in a picture, and ``toward`` the camera, y up."""
    out = np.array(toward) / np.linalg.norm(toward)
    right = np.cross([0.0, 1.0, 0.0], out)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(out, right), out])


def camera_at(points: Array, axes: Array, size: tuple[int, int]) -> Array:
    """Where a camera of :func:`camera_axes` stands, as near as keeps every point in its frame.

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
    camera.position, camera.view_angle, camera.up = position, VIEW_ANGLE, (0.0, 1.0, 0.0)
    camera.focal_point = position - axes[2]
    plotter.reset_camera_clipping_range()


AXES = camera_axes((-0.72, 0.52, 1.0))  # the camera is in front, to the left, above
EDGE, TRAIL = "#2f3a44", "#8a8f96"


def draw_exploded(things: tuple[Shown, ...]) -> tuple[bytes, dict[str, tuple[float, float]]]:
    """The picture as PNG, and by name a place in it where a thing is seen, shares from the left and
    the top; what nothing is seen of has none. pyvista's errors pass."""
    camera = camera_at(np.vstack([thing.points for thing in things]), AXES, SIZE)
    plotter = _drawn(things, camera)
    png = png_of(plotter)
    plotter.close()
    return png, _seen(things, camera)


def _drawn(things: tuple[Shown, ...], camera: Array) -> Any:
    import pyvista

    plotter = plotter_of(SIZE)
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
    aim(plotter, camera, AXES)
    plotter.add_axes(color=TRAIL, line_width=3, viewport=(0.0, 0.0, 0.12, 0.16))
    return plotter


def _seen(things: tuple[Shown, ...], camera: Array) -> dict[str, tuple[float, float]]:
    """Where each thing is seen best: the middle of the largest disc of it that nothing covers."""
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
