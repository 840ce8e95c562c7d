"""Draws a mold's exploded picture: ``python -m fingerdesign.report.mold_picture_worker FOLDER``.

In FOLDER it finds scene.npz (points_k, triangles_k) and scene.json (name, colour, opacity and move
of each k), and leaves exploded.png and places.json: name -> where its middle is in the picture,
shares from the left and the top.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.process import die_with_parent

SIZE = (1200, 940)
VIEW_ANGLE, FILLED = 22.0, 0.95  # degrees, vertical; the part of the frame that may be used
TOWARD = (-0.72, 0.52, 1.0)  # the camera: in front, to the left, above
EDGE, TRAIL = "#2f3a44", "#8a8f96"


def main(arguments: Sequence[str]) -> int:
    """Draw what the folder holds. pyvista's errors pass: the caller reads the last line of them."""
    die_with_parent()
    folder = Path(arguments[0])
    looks = json.loads((folder / "scene.json").read_text("utf-8"))
    with np.load(folder / "scene.npz") as file:
        things = [(file[f"points_{k}"], file[f"triangles_{k}"]) for k in range(len(looks))]
    view = View.of(np.vstack([points for points, _ in things]))
    plotter = _drawn(looks, things, view)
    plotter.screenshot(str(folder / "exploded.png"), transparent_background=True)
    places = {
        look["name"]: view.place(0.5 * (points.min(axis=0) + points.max(axis=0)))
        for look, (points, _) in zip(looks, things, strict=True)
    }
    (folder / "places.json").write_text(json.dumps(places), "utf-8")
    return 0


class View:
    """The camera: where it stands, and where a point is in its picture."""

    def __init__(self, centre: Any, distance: float) -> None:
        self.toward = np.array(TOWARD) / np.linalg.norm(TOWARD)
        self.right = np.cross([0.0, 1.0, 0.0], self.toward)
        self.right /= np.linalg.norm(self.right)
        self.up = np.cross(self.toward, self.right)
        self.centre, self.position = centre, centre + distance * self.toward

    @staticmethod
    def of(points: Any) -> View:
        """As near as keeps every point inside the frame."""
        flat = View(np.zeros(3), 0.0)
        up, right = points @ flat.up, points @ flat.right
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        centre = (
            0.5 * (up.min() + up.max()) * flat.up
            + 0.5 * (right.min() + right.max()) * flat.right
            + (middle @ flat.toward) * flat.toward
        )
        slope = FILLED * np.tan(np.radians(0.5 * VIEW_ANGLE))
        offset = points - centre
        tall = np.abs(offset @ flat.up) / slope
        wide = np.abs(offset @ flat.right) / (slope * SIZE[0] / SIZE[1])
        return View(centre, float((offset @ flat.toward + np.maximum(tall, wide)).max()))

    def place(self, point: Any) -> tuple[float, float]:
        """Shares from the left and from the top of the picture."""
        offset = point - self.position
        depth = float(-offset @ self.toward) * np.tan(np.radians(0.5 * VIEW_ANGLE))
        across = float(offset @ self.right) / (depth * SIZE[0] / SIZE[1])
        return round(0.5 + 0.5 * across, 4), round(0.5 - 0.5 * float(offset @ self.up) / depth, 4)


def _drawn(looks: list[dict[str, Any]], things: list[tuple[Any, Any]], view: View) -> Any:
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=SIZE)
    plotter.enable_anti_aliasing("ssaa")
    plotter.enable_depth_peeling(6)
    for look, (points, triangles) in zip(looks, things, strict=True):
        faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
        solid = pyvista.PolyData(points, faces=faces)
        plotter.add_mesh(
            *(solid,),
            color=look["colour"],
            opacity=look["opacity"],
            smooth_shading=False,
            ambient=0.22,
        )
        edges = solid.extract_feature_edges(feature_angle=25, manifold_edges=False)
        if edges.n_cells:
            plotter.add_mesh(edges, color=EDGE, line_width=1.2)
        move = np.array(look["move"])
        if np.linalg.norm(move) > 0.0:  # from its place to where it is drawn
            middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
            plotter.add_mesh(pyvista.Line(middle - move, middle), color=TRAIL, line_width=1.5)
    camera = plotter.camera
    camera.focal_point, camera.up = view.centre, (0.0, 1.0, 0.0)
    camera.position, camera.view_angle = view.position, VIEW_ANGLE
    plotter.reset_camera_clipping_range()
    plotter.add_axes(color=TRAIL, line_width=3, viewport=(0.0, 0.0, 0.12, 0.16))
    return plotter


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
