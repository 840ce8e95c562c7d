"""Drawing of a mold's pictures, off-screen, in a process of its own."""

import io
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from fingerdesign.arrays import Array, IntArray
from fingerdesign.mold.part import PartMesh, Point, point
from fingerdesign.mold.products.notes import Up

SIZE, STEP_SIZE = (1200, 940), (560, 420)
VIEW_ANGLE, FILLED = 25.0, 0.94  # degrees, vertical; the part of the frame that may be used
EDGE, TRAIL, ARROW = "#2f3a44", "#8a8f96", "#c2410c"
STEEP_VIEW = (-0.72, 0.95, 1.0)  # of steps: into what is open above
FRONT_VIEW = (-0.72, 0.52, 1.0)  # the camera is in front, to the left, above
STILL: Point = (0.0, 0.0, 0.0)
Shapes = dict[int, tuple[Any, Array, IntArray]]  # by the mesh's identity


@dataclass(frozen=True)
class Shown:
    """One thing in the picture: its triangles, how far it is moved, its look."""

    name: str
    mesh: PartMesh
    colour: str
    move: Point = STILL
    opacity: float = 1.0
    way: Point = STILL  # along which it goes: an arrow

    @property
    def points(self) -> Array:
        """Its vertices where it is drawn."""
        return np.asarray(self.mesh.vertices + np.array(self.move))


def camera_axes(toward: Sequence[float], up: Up = "+y") -> Array:
    """Unit vectors (3, 3) to the right and up in a picture, and to the camera, which is where
    ``toward`` points when y is up; turned as a whole until ``up`` is."""
    out = np.array(toward) / np.linalg.norm(toward)
    right = np.cross([0.0, 1.0, 0.0], out)
    right /= np.linalg.norm(right)
    axes = np.array([right, np.cross(out, right), out])
    turns = {"+y": ("x", 0), "-y": ("z", 180), "+z": ("x", 90), "-z": ("x", -90)}
    turns |= {"+x": ("z", -90), "-x": ("z", 90), "+Y": ("y", 180)}
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


def draw_pictures(
    opened: tuple[Shown, ...], steps: Sequence[tuple[tuple[Shown, ...], Up]]
) -> tuple[bytes, dict[str, tuple[float, float]], list[bytes]]:
    """The mold opened as PNG; by name a place in it where a thing is seen, shares from the left and
    the top (what nothing is seen of has none); a PNG a step. pyvista's errors pass."""
    shapes: Shapes = {}
    front = camera_axes(FRONT_VIEW)
    camera = camera_at(np.vstack([thing.points for thing in opened]), front, SIZE)
    png, places = _drawn(opened, camera, front, SIZE, shapes), _seen(opened, camera)
    pngs = []
    for things, up in steps:
        axes = camera_axes(STEEP_VIEW, up)
        points = [thing.points for thing in things]
        points += [np.vstack([start, start + way]) for start, way in arrows_of(things, axes)]
        place = camera_at(np.vstack(points), axes, STEP_SIZE)
        pngs.append(_drawn(things, place, axes, STEP_SIZE, shapes))
    return png, places, pngs


def _shape_of(mesh: PartMesh, shapes: Shapes) -> tuple[Any, Array, IntArray]:
    """A mesh for the plotter, and its edges: points (n, 3) and pairs (e, 2). They are found once
    for all pictures, and drawn as one thing a picture: both were a third of the work."""
    import pyvista

    if id(mesh) not in shapes:
        solid = pyvista.PolyData.from_regular_faces(mesh.vertices, mesh.triangles)
        edges = solid.extract_feature_edges(feature_angle=25, manifold_edges=False)
        pairs = edges.lines.reshape(-1, 3)[:, 1:]
        shapes[id(mesh)] = solid, np.asarray(edges.points, dtype=float), pairs
    return shapes[id(mesh)]


def _drawn(
    things: Sequence[Shown], camera: Array, axes: Array, size: tuple[int, int], shapes: Shapes
) -> bytes:
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    plotter.enable_anti_aliasing("ssaa")
    plotter.enable_depth_peeling(6)  # what is translucent is drawn in its order
    ends, pairs, count = [np.zeros((0, 3))], [np.zeros((0, 2), dtype=int)], 0
    for thing in things:
        solid, points, own = _shape_of(thing.mesh, shapes)
        move, look = np.array(thing.move), {"color": thing.colour, "opacity": thing.opacity}
        actor = plotter.add_mesh(solid, **look, smooth_shading=False, ambient=0.22)
        actor.position = thing.move
        ends.append(points + move)
        pairs.append(own + count)
        count += len(points)
        if np.linalg.norm(move) > 0.0:  # from its place to where it is drawn
            middle = 0.5 * (thing.points.min(axis=0) + thing.points.max(axis=0))
            plotter.add_mesh(pyvista.Line(middle - move, middle), color=TRAIL, line_width=1.5)
    if count:
        lines = np.insert(np.vstack(pairs), 0, 2, axis=1)
        plotter.add_mesh(pyvista.PolyData(np.vstack(ends), lines=lines), color=EDGE, line_width=1.2)
    for start, way in arrows_of(things, axes):
        sizes = {"tip_length": 0.3, "tip_radius": 0.09, "shaft_radius": 0.03}
        shape = pyvista.Arrow(start, way, scale=float(np.linalg.norm(way)), **sizes)
        plotter.add_mesh(shape, color=ARROW, lighting=False)
    aim(plotter, camera, axes)
    plotter.add_axes(color=TRAIL, line_width=3, viewport=(0.0, 0.0, 0.12, 0.16))
    png = io.BytesIO()
    plotter.screenshot(png, transparent_background=True)
    plotter.close()
    return png.getvalue()


def arrows_of(things: Sequence[Shown], axes: Array) -> list[tuple[Array, Array]]:
    """Start and way (3,) of an arrow next to what is moved, to the right of it as it is seen: one a
    direction, none where nothing goes anywhere."""
    moved, found = defaultdict[Point, list[Shown]](list), []
    for each in things:
        if (size := float(np.linalg.norm(each.way))) > 0.0:
            moved[point(np.round(np.array(each.way) / size, 6))].append(each)
    for alike in moved.values():
        points = np.vstack([each.points for each in alike])
        middle, way = 0.5 * (points.min(axis=0) + points.max(axis=0)), np.array(alike[0].way)
        aside = float((points @ axes[0]).max() - middle @ axes[0])
        found.append((middle + 1.05 * aside * axes[0] - 0.5 * way, way))
    return found


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
    aim(plotter, camera, camera_axes(FRONT_VIEW))
    image = plotter.screenshot(return_img=True).astype(np.int64)
    plotter.close()
    number = (image[..., 0] << 16) + (image[..., 1] << 8) + image[..., 2] - 1
    places = {}
    for k, thing in enumerate(things):
        rows, columns = np.nonzero(number == k)
        if not len(rows):
            continue
        top, left = rows.min(), columns.min()
        own = number[top : rows.max() + 1, left : columns.max() + 1] == k
        inside = distance_transform_edt(np.pad(own, 1))[1:-1, 1:-1]
        if inside.max() >= 2.0:
            row, column = np.unravel_index(inside.argmax(), inside.shape)
            places[thing.name] = (
                round((float(left + column) + 0.5) / width, 4),
                round((float(top + row) + 0.5) / height, 4),
            )
    return places
