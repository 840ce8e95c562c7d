"""Draws a mold's exploded picture: ``python -m fingerdesign.mold.page.picture_worker FOLDER``.

In FOLDER it finds scene.npz (points_k, triangles_k) and scene.json (name, colour, opacity and move
of each k), and leaves exploded.png and places.json: name -> a place in the picture where it is
seen, shares from the left and the top; what nothing is seen of has none.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.runtime.process import die_with_parent

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
    plotter.close()
    (folder / "places.json").write_text(json.dumps(_seen(looks, things, view)), "utf-8")
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
        """As near as keeps every point inside the frame, what is seen in its middle."""
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        view = View(middle, 1.0)
        view = View(middle, view.distance(points))
        for _ in range(6):  # near things look larger, so that the middle of all moves a little
            left, top = view.places(points).T
            half = np.linalg.norm(view.position - view.centre) * np.tan(
                np.radians(0.5 * VIEW_ANGLE)
            )
            aside = (left.min() + left.max() - 1.0) * half * SIZE[0] / SIZE[1]
            above = (1.0 - top.min() - top.max()) * half
            centre = view.centre + aside * view.right + above * view.up
            view = View(centre, View(centre, 1.0).distance(points))
        return view

    def distance(self, points: Any) -> float:
        """How far from its centre the camera must be, for all points to be in the picture."""
        slope = FILLED * np.tan(np.radians(0.5 * VIEW_ANGLE))
        offset = points - self.centre
        tall = np.abs(offset @ self.up) / slope
        wide = np.abs(offset @ self.right) / (slope * SIZE[0] / SIZE[1])
        return float((offset @ self.toward + np.maximum(tall, wide)).max())

    def places(self, points: Any) -> Any:
        """Shares (n, 2) from the left and from the top of the picture."""
        offset = points - self.position
        depth = -(offset @ self.toward) * np.tan(np.radians(0.5 * VIEW_ANGLE))
        across = (offset @ self.right) / (depth * SIZE[0] / SIZE[1])
        return np.column_stack([0.5 + 0.5 * across, 0.5 - 0.5 * (offset @ self.up) / depth])


def _drawn(looks: list[dict[str, Any]], things: list[tuple[Any, Any]], view: View) -> Any:
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=SIZE)
    plotter.enable_anti_aliasing("ssaa")
    plotter.enable_depth_peeling(6)
    for look, (points, triangles) in zip(looks, things, strict=True):
        solid = _surface(points, triangles)
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
    _aimed(plotter, view)
    plotter.add_axes(color=TRAIL, line_width=3, viewport=(0.0, 0.0, 0.12, 0.16))
    return plotter


def _seen(
    looks: list[dict[str, Any]], things: list[tuple[Any, Any]], view: View
) -> dict[str, tuple[float, float]]:
    """Where each thing is seen best: the middle of the largest disc of it that nothing covers."""
    import pyvista
    from scipy.ndimage import distance_transform_edt

    width, height = SIZE[0] // 2, SIZE[1] // 2
    plotter = pyvista.Plotter(off_screen=True, window_size=(width, height))
    plotter.disable_anti_aliasing()
    plotter.set_background("white")
    for k, (look, thing) in enumerate(zip(looks, things, strict=True)):
        if look["opacity"] == 1.0:  # what is translucent covers nothing
            colour = tuple((k + 1) >> shift & 255 for shift in (16, 8, 0))
            plotter.add_mesh(_surface(*thing), color=colour, lighting=False)
    _aimed(plotter, view)
    image = plotter.screenshot(return_img=True).astype(np.int64)
    plotter.close()
    number = (image[..., 0] << 16) + (image[..., 1] << 8) + image[..., 2] - 1
    places = {}
    for k, look in enumerate(looks):
        inside = distance_transform_edt(np.pad(number == k, 1))[1:-1, 1:-1]
        if inside.max() >= 2.0:
            row, column = np.unravel_index(inside.argmax(), inside.shape)
            places[look["name"]] = (
                round((float(column) + 0.5) / width, 4),
                round((float(row) + 0.5) / height, 4),
            )
    return places


def _aimed(plotter: Any, view: View) -> None:
    camera = plotter.camera
    camera.focal_point, camera.up = view.centre, (0.0, 1.0, 0.0)
    camera.position, camera.view_angle = view.position, VIEW_ANGLE
    plotter.reset_camera_clipping_range()


def _surface(points: Any, triangles: Any) -> Any:
    import pyvista

    faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    return pyvista.PolyData(points, faces=faces)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
