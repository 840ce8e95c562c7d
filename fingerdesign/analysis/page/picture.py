"""Pictures of the finger: its inside, and deformed. Drawn off-screen, no display needed.

VTK is native code that can crash where its graphics drivers are odd, so it runs in a process of its
own with a time limit; its failure is a :class:`PictureError` and the report does without.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.analysis.page.words import FIGURES
from fingerdesign.arrays import Array
from fingerdesign.design.schema import Gages
from fingerdesign.errors import PictureError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.types import Mesh
from fingerdesign.records.arrays import OPEN, FieldHistory
from fingerdesign.report.page import said
from fingerdesign.runtime.isolate import ProcessError, beside

if TYPE_CHECKING:  # the drawing process starts without it
    from fingerdesign.analysis.analysis import Analysis

LIFT = 0.02  # mm: gages lie above their faces, or the two would flicker into each other
_BENT_PIECES = 6


def gage_quads(plates: tuple[PlateFrame, ...], gages: Gages) -> Array:
    """Corners of the gages, a hair above the plate faces that carry them: (q, 4, 3), mm.

    On a bent plate a gage is several quads, one beside the other.
    """
    sides = {"upper": (1.0,), "lower": (-1.0,)}.get(gages.face, (1.0, -1.0))
    quads = []
    for plate in plates:
        pieces = 1 if plate.bend_radius is None else _BENT_PIECES
        along = np.linspace(-0.5, 0.5, pieces + 1) * gages.length_mm
        low, high = (plate.middle + gages.z_mm + sign * 0.5 * gages.width_mm for sign in (-1, 1))
        for side in sides:
            line = plate.from_local(along, side * (0.5 * plate.thickness + LIFT))
            near, far = plate.to_space(line, low), plate.to_space(line, high)
            quads += [[near[k], near[k + 1], far[k + 1], far[k]] for k in range(pieces)]
    return np.array(quads, dtype=float).reshape(-1, 4, 3)


TIME_LIMIT_S = 60.0  # the pictures take 2 to 4 s; a software renderer on a busy machine far longer
UNMOVED_MM = 1e-6  # a displacement that is not worth a picture


@dataclass(frozen=True)
class Picture:
    """A PNG and what it shows, in words; scale_mm: the colour scale's top, None without colours."""

    png: bytes
    alternative: str
    scale_mm: float | None = None


@contextmanager
def pictures_of(
    analysis: Analysis, time_limit_s: float = TIME_LIMIT_S
) -> Iterator[Callable[[], dict[str, Picture]]]:
    """Draw in a process of its own while the block goes on; what is yielded waits for the pictures.

    Name ("inside", "deformed") -> picture. Raises PictureError: at once where there is nothing to
    draw, when waiting where the drawing failed.
    """
    arrays, words = drawing_of(analysis)

    def pictures() -> dict[str, Picture]:
        try:
            drawn: dict[str, bytes] = wait()
        except ProcessError as error:
            why = f"the drawing process failed: {error}"
            if error.kind == "timeout":
                why = f"drawing took longer than {time_limit_s:g} s"
            raise PictureError(why) from error
        found = {name: Picture(drawn[name], said) for name, said in words.items()}
        if "deformed" in found:
            top = float(np.linalg.norm(arrays["moved"], axis=1).max())
            found["deformed"] = replace(found["deformed"], scale_mm=top)
        return found

    with beside(draw, arrays, time_s=time_limit_s) as wait:
        yield pictures


def drawing_of(analysis: Analysis) -> tuple[dict[str, Any], dict[str, str]]:
    """All that the worker draws, as arrays, and by name what each picture shows, in words.

    A section (plane strain) is drawn as the finger that it stands for: extruded over the body's
    depth. A half model is mirrored in z = 0.
    """
    mesh = analysis.mesh
    if mesh is None:
        raise PictureError("there is no mesh to draw")
    solid, core = mesh.parts["plates"], mesh.parts["core"]
    arrays: dict[str, Any] = {
        "points": mesh.points,
        "cells": mesh.corners,
        "plates": solid,
        "core": core,
        "depth": analysis.depth_mm if mesh.dimension == 2 else 0.0,
        "half": mesh.symmetric,
        "rings": [],
    }
    count = len(set(mesh.regions[solid].tolist()))
    if not solid.any():  # sheets, or left out: drawn as they are cast
        count = len(analysis.plates)
        arrays["rings"] = [
            tuple(plate.to_space(plate.outline(), end) for end in (plate.low, plate.high))
            for plate in analysis.plates
        ]
    if analysis.gages is not None and analysis.plates:
        arrays["gages"] = gage_quads(analysis.plates, analysis.gages)
    arrays |= (touched := _contact_zone(analysis))
    seen = {"plates": count, "core": core.any(), "gages": "gages" in arrays}
    words = {"inside": said(FIGURES, "inside", **seen, touched=bool(touched))[0]}
    if analysis.fields is not None and len(analysis.fields.increments):
        moved, shown = _moved(mesh, analysis.fields)
        if moved is None:
            words["inside"] += f" {shown}"
        else:
            arrays["moved"], words["deformed"] = moved, shown
    return arrays, words


def _moved(mesh: Mesh, fields: FieldHistory) -> tuple[Array | None, str]:
    """Displacement (n, 3) of the corner nodes in the last field, 0 of the others, None if it is
    next to nothing; and words for it."""
    last = fields.displacement[-1]
    if len(last) != len(mesh.points):
        raise PictureError("the displacement field does not belong to the mesh")
    corners = np.unique(mesh.corners)
    moved = np.zeros((len(last), 3))
    moved[corners, : last.shape[1]] = last[corners]
    most = float(np.linalg.norm(moved, axis=1).max())
    number = fields.increments[-1] + 1
    if most < UNMOVED_MM:
        return None, f"There is no picture of it deformed: in increment {number} nothing moves it."
    return moved, said(FIGURES, "deformed", number=number, most=most)[0]


def _contact_zone(analysis: Analysis) -> dict[str, Any]:
    """The candidate surface and which of its points ever touched; empty if none did."""
    contact = analysis.contact
    if contact is None or not (contact.status != OPEN).any():
        return {}
    touched = (contact.status != OPEN).any(axis=0)
    points, triangles = contact.points, contact.facets
    if contact.dimension == 2:
        half, n = 0.5 * analysis.depth_mm, len(points)
        points = np.concatenate([np.column_stack([points, np.full(n, z)]) for z in (-half, half)])
        a, b = triangles.T
        triangles = np.concatenate([np.stack([a, b, b + n], 1), np.stack([a, b + n, a + n], 1)])
        touched = np.tile(touched, 2)
    elif contact.symmetric:
        triangles = np.concatenate([triangles, triangles + len(points)])
        points = np.concatenate([points, points * np.array([1.0, 1.0, -1.0])])
        touched = np.tile(touched, 2)
    return {"zone_points": points, "zone_triangles": triangles, "zone_touched": touched}


# The drawing, in a process of its own.

SIZE = (940, 640)
VIEW_ANGLE, FILLED = 25.0, 0.94  # degrees, vertical; the part of the frame that may be used
BODY, PLATE, GAGE, ZONE = "#8fb4cf", "#c07f36", "#0d3b66", "#d2560a"
CORE = "#5f8f4e"


def draw(scene: dict[str, Any]) -> dict[str, bytes]:
    """Name -> PNG of what ``drawing_of`` holds. pyvista's errors pass."""
    found = {"inside": png_of(_inside(scene))}
    if "moved" in scene:
        found["deformed"] = png_of(_deformed(scene))
    return found


def png_of(plotter: Any) -> bytes:
    """What a plotter shows, as PNG on nothing."""
    png = io.BytesIO()
    plotter.screenshot(png, transparent_background=True)
    return png.getvalue()


def _inside(scene: dict[str, Any]) -> Any:
    import pyvista

    plotter = plotter_of(SIZE)
    body = surface(scene)
    plotter.add_mesh(body, color=BODY, opacity=0.28, smooth_shading=False)
    _add_outline(plotter, body)
    if "zone_points" in scene:
        # Just above the body, or the two would flicker into each other.
        triangles = scene["zone_triangles"]
        faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
        zone = pyvista.PolyData(scene["zone_points"] + [0.0, 0.02, 0.0], faces)
        zone["touched"] = scene["zone_touched"].astype(float)
        zone = zone.clip_scalar("touched", value=0.5, invert=False)
        if zone.n_cells:
            plotter.add_mesh(zone, color=ZONE, opacity=0.45, show_scalar_bar=False)
    if scene["core"].any():
        core = surface(scene, scene["core"])
        plotter.add_mesh(core, color=CORE, opacity=0.55, smooth_shading=False, ambient=0.2)
        _add_outline(plotter, core, "#3d5135")
    for plates in [surface(scene, scene["plates"])] if scene["plates"].any() else cast(scene):
        plotter.add_mesh(plates, color=PLATE, smooth_shading=False, ambient=0.25)
        _add_outline(plotter, plates, "#5f3d14")
    for quad in scene.get("gages", ()):
        gage = pyvista.PolyData(quad, faces=[4, 0, 1, 2, 3])
        plotter.add_mesh(gage, color=GAGE, ambient=0.5)
    return _look(plotter, body.points)


def _deformed(scene: dict[str, Any]) -> Any:
    plotter = plotter_of(SIZE)
    rest, body = surface(scene), surface(scene)
    body.points += body["moved"]
    body["moved by (mm)"] = np.linalg.norm(body["moved"], axis=1)
    plotter.add_mesh(
        body,
        scalars="moved by (mm)",
        cmap="cividis",
        smooth_shading=False,
        ambient=0.45,
        diffuse=0.55,
        show_scalar_bar=False,  # the page draws it, in the page's own ink
    )
    _add_outline(plotter, rest)
    return _look(plotter, rest.points)


def surface(scene: dict[str, Any], chosen: Any = slice(None)) -> Any:
    """The surface of the whole finger's chosen cells, flat triangles between corner nodes."""
    import pyvista

    points, cells = scene["points"], scene["cells"][chosen]
    flat = points.shape[1] == 2
    kind = pyvista.CellType.TRIANGLE if flat else pyvista.CellType.TETRA
    places = np.column_stack([points, np.full(len(points), -0.5 * scene["depth"])][: 1 + flat])
    places[np.abs(places) < 1e-9] = 0.0  # nodes a rounding off the cut would keep its facets
    halves = []
    for side in (1.0, -1.0) if scene["half"] else (1.0,):
        own = cells if side > 0.0 else np.roll(cells, 1, axis=1)  # or inside out: a seam shows
        grid = pyvista.UnstructuredGrid({kind: own}, places * [1.0, 1.0, side])
        if "moved" in scene:
            grid["moved"] = scene["moved"] * [1.0, 1.0, side]
        halves.append(grid)
    # Where the halves meet their facets are inner ones: the cut is no surface of the finger.
    found = pyvista.merge(halves).extract_surface() if scene["half"] else grid.extract_surface()
    found.clear_cell_data()
    return found.extrude((0.0, 0.0, scene["depth"]), capping=True).triangulate() if flat else found


def cast(scene: dict[str, Any]) -> list[Any]:
    """The plates as they are cast, from their outlines alone; holes are left out."""
    import pyvista

    return [
        pyvista.PolyData(near, [len(near), *range(len(near))])
        .triangulate()
        .extrude(far[0] - near[0], capping=True)
        .triangulate()
        for near, far in scene["rings"]
    ]


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


def _look(plotter: Any, points: Array) -> Any:
    """Camera in front, to the left and above (it sees the plates' upper faces)."""
    axes = camera_axes((-0.55, 0.5, 1.0))
    aim(plotter, camera_at(points, axes, SIZE), axes)
    plotter.add_axes(color="#6c6f73", line_width=3, viewport=(0.0, 0.0, 0.14, 0.2))
    return plotter


def _add_outline(plotter: Any, solid: Any, colour: str = "#5b7386") -> None:
    """The solid's sharp edges; points are merged first, or a mirrored half's seam would show."""
    edges = solid.clean().extract_feature_edges(feature_angle=25, manifold_edges=False)
    if edges.n_cells:
        plotter.add_mesh(edges, color=colour, line_width=1.6)
