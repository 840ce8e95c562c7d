"""Draws the pictures in a process of its own: ``python -m ...page.picture_worker FILE.npz``.

Reads the arrays that picture.py wrote; writes inside.png and deformed.png
into the working directory.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

SIZE = (940, 640)
VIEW_ANGLE, FILLED = 25.0, 0.94  # degrees, vertical; the part of the frame that may be used
BODY, PLATE, GAGE, ZONE = "#8fb4cf", "#c07f36", "#0d3b66", "#d2560a"
CORE = "#5f8f4e"


def main(path: str) -> None:
    """Draw what the file holds. pyvista's errors pass: the caller reads the last line of them."""
    with np.load(path) as file:
        scene = {name: file[name] for name in file.files}
    _inside(scene).screenshot("inside.png", transparent_background=True)
    if "moved" in scene:
        _deformed(scene).screenshot("deformed.png", transparent_background=True)


def _inside(scene: dict[str, Any]) -> Any:
    import pyvista

    plotter = _plotter()
    body = _surface(scene["body_points"], scene["body_triangles"])
    plotter.add_mesh(body, color=BODY, opacity=0.28, smooth_shading=False)
    _add_outline(plotter, body)
    if "zone_points" in scene:
        # Just above the body, or the two would flicker into each other.
        zone = _surface(scene["zone_points"] + [0.0, 0.02, 0.0], scene["zone_triangles"])
        zone["touched"] = scene["zone_touched"].astype(float)
        zone = zone.clip_scalar("touched", value=0.5, invert=False)
        if zone.n_cells:
            plotter.add_mesh(zone, color=ZONE, opacity=0.45, show_scalar_bar=False)
    if "core_points" in scene:
        core = _surface(scene["core_points"], scene["core_triangles"])
        plotter.add_mesh(core, color=CORE, opacity=0.55, smooth_shading=False, ambient=0.2)
        _add_outline(plotter, core, "#3d5135")
    if "plate_points" in scene:
        plates = _surface(scene["plate_points"], scene["plate_triangles"])
        plotter.add_mesh(plates, color=PLATE, smooth_shading=False, ambient=0.25)
        _add_outline(plotter, plates, "#5f3d14")
    for quad in scene.get("gages", ()):
        gage = pyvista.PolyData(quad, faces=[4, 0, 1, 2, 3])
        plotter.add_mesh(gage, color=GAGE, ambient=0.5)
    return _look(plotter, scene["body_points"])


def _deformed(scene: dict[str, Any]) -> Any:
    plotter = _plotter()
    body = _surface(scene["body_points"] + scene["moved"], scene["body_triangles"])
    body["moved by (mm)"] = np.linalg.norm(scene["moved"], axis=1)
    plotter.add_mesh(
        body,
        scalars="moved by (mm)",
        cmap="cividis",
        smooth_shading=False,
        ambient=0.45,
        diffuse=0.55,
        show_scalar_bar=False,  # the page draws it, in the page's own ink
    )
    _add_outline(plotter, _surface(scene["body_points"], scene["body_triangles"]))
    return _look(plotter, scene["body_points"])


def _plotter() -> Any:
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=SIZE)
    plotter.enable_anti_aliasing("ssaa")
    plotter.enable_depth_peeling(6)
    return plotter


def _look(plotter: Any, points: Any) -> Any:
    """Camera in front, to the left and above (it sees the plates' upper faces), y up.

    Just so far away that the corners of the bounding box stay inside the frame.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    centre = 0.5 * (low + high)
    toward = np.array([-0.55, 0.5, 1.0]) / np.linalg.norm([0.55, 0.5, 1.0])
    right = np.cross([0.0, 1.0, 0.0], toward)
    right /= np.linalg.norm(right)
    corners = np.array(np.meshgrid(*zip(low - centre, high - centre, strict=True))).reshape(3, -1).T
    nearness, across, up = corners @ toward, corners @ right, corners @ np.cross(toward, right)
    slope = FILLED * np.tan(np.radians(0.5 * VIEW_ANGLE))
    wide = slope * SIZE[0] / SIZE[1]
    distance = (nearness + np.maximum(np.abs(up) / slope, np.abs(across) / wide)).max()
    camera = plotter.camera
    camera.focal_point, camera.up = centre, (0.0, 1.0, 0.0)
    camera.position = centre + distance * toward
    camera.view_angle = VIEW_ANGLE
    plotter.reset_camera_clipping_range()
    plotter.add_axes(color="#6c6f73", line_width=3, viewport=(0.0, 0.0, 0.14, 0.2))
    return plotter


def _add_outline(plotter: Any, solid: Any, colour: str = "#5b7386") -> None:
    """The solid's sharp edges; points are merged first, or a mirrored half's seam would show."""
    edges = solid.clean().extract_feature_edges(feature_angle=25, manifold_edges=False)
    if edges.n_cells:
        plotter.add_mesh(edges, color=colour, line_width=1.6)


def _surface(points: Any, triangles: Any) -> Any:
    import pyvista

    faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    return pyvista.PolyData(points, faces=faces)


if __name__ == "__main__":
    main(sys.argv[1])
