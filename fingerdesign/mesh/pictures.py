"""A picture of a mesh: its outside with edges and, of a whole finger, its inside too (pyvista).

Plates are bronze, a core purple, and a legend names them. VTK is native code that can crash where
graphics drivers are odd: it draws in a process of its own.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.errors import MeshError
from fingerdesign.mesh.measures import cell_angles
from fingerdesign.mesh.quality import QualityReport
from fingerdesign.mesh.requested import TargetSizes, size_zones
from fingerdesign.mesh.types import Mesh
from fingerdesign.runtime.files import whole_file
from fingerdesign.runtime.isolate import Function, ProcessError, call

TIME_LIMIT_S = 120.0  # drawing takes 1 to 2 s; a software renderer on a busy machine far longer
SIZE = (1600, 1120)
SILICONE, BRONZE, CORE, EDGES = "#cfd8e3", "#b87333", "#a487b5", "#33475b"
_NAMES = {"contact": "at the contact", "rest": "elsewhere in the rubber"}
_COLOURS = {"contact": "#0b6fb0", "plates": "#d2560a", "core": "#b0569a", "rest": "#0a8f6b"}
_STYLES = {"contact": "-", "plates": "--", "core": "-.", "rest": ":"}
VIEW = (1500, 1100)  # pixels of the view in space
MARKED = 10  # worst elements in the picture
_SATURATED = 40.0  # degrees: what is better looks the same


def placed(mesh: Mesh) -> Array:
    """Nodes (n, 3) as they are drawn: of a half model its mirror image z <= 0, the cut in front."""
    return mesh.in_space * ([1.0, 1.0, -1.0] if mesh.symmetric else 1.0)


def view(plotter: Any) -> None:
    """Look from the front, a little from above and the left."""
    plotter.view_vector((-0.3, 0.4, 1.0), viewup=(0.0, 1.0, 0.0))


def grid_of(points: Array, cells: IntArray) -> Any:
    """Cells, by their corners, as pyvista has them."""
    import pyvista

    types = pyvista.CellType
    kind = {3: types.TRIANGLE, 4: types.TETRA, 6: types.WEDGE}[cells.shape[1]]
    return pyvista.UnstructuredGrid({kind: cells}, points)


def cut_open(grid: Any) -> Any:
    """The part z <= 0 of an unstructured grid, cut flat; all of it where none lies in front."""
    return grid.clip("z", origin=(0.0, 0.0, 0.0)) if grid.bounds[5] > 1e-9 else grid


def cropped(image: NDArray[Any]) -> NDArray[Any]:
    """Pixels without the white around them."""
    rows, columns = np.nonzero((image < 250).any(axis=2))
    return image[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]


def draw_mesh(mesh: Mesh, path: Path, name: str) -> Path:
    """Write a PNG of a mesh: a section seen along -z, a half model with its mid-plane in front, a
    whole one next to itself cut open at z = 0. ``name``: the design's, for the title.

    MeshError where nothing can be rendered (no off-screen graphics on this machine).
    """
    return drawn(paint_mesh, path, mesh, name)


def drawn(paint: Function, path: Path, *arguments: Any) -> Path:
    """Run ``paint(*arguments, path)`` in a process of its own; MeshError where that fails."""
    try:
        with whole_file(path.absolute()) as aside:
            call(paint, *arguments, aside, time_s=TIME_LIMIT_S)
    except ProcessError as error:
        raise MeshError(f"the picture {path} could not be drawn: {error}") from error
    return path


def picture_title(mesh: Mesh, name: str) -> str:
    """Title of a picture: the design, the part of it that is shown, the number of elements."""
    shown = "the section z = 0"
    if mesh.dimension == 3:
        shown = "the half z >= 0" if mesh.symmetric else "the whole finger, and cut open at z = 0"
    return f"{name}: {shown}; {len(mesh.cells)} elements ({mesh.mesher})"


def paint_mesh(mesh: Mesh, name: str, target: Path) -> None:
    """Draw a PNG; runs in its process. VTK's errors pass: the caller gets the last line of them."""
    import pyvista

    part = np.where(mesh.parts["core"], 2, np.minimum(mesh.regions, 1))
    whole = mesh.dimension == 3 and not mesh.symmetric
    plotter = pyvista.Plotter(
        off_screen=True,
        window_size=[SIZE[0] * (1 + whole), SIZE[1]],
        shape=(1, 1 + whole),
        border=False,
    )
    for column in range(1 + whole):
        plotter.subplot(0, column)
        _draw(plotter, mesh, part, cut=column == 1)
    plotter.subplot(0, 0)
    plotter.add_text(picture_title(mesh, name), position="upper_left", font_size=14, color="black")
    parts = zip(("elastomer", "plates", "core"), (SILICONE, BRONZE, CORE), strict=True)
    shown = [list(each) for k, each in enumerate(parts) if (part == k).any()]
    # VTK writes each word in the colour of its part: only a dark ground shows them all.
    plotter.add_legend(
        shown,
        face="rectangle",
        loc="lower left",
        size=(0.13, 0.04 * len(shown)),
        bcolor="#1d2833",
        background_opacity=1.0,
    )
    plotter.screenshot(str(target))


def _draw(plotter: Any, mesh: Mesh, part: IntArray, cut: bool) -> None:
    """The mesh; ``cut``: of the rubber z <= 0, with plates and core standing out of it."""
    plotter.set_background("white")
    for number, colour in enumerate((SILICONE, BRONZE, CORE)):
        rows = part == number
        if rows.any():
            grid = grid_of(placed(mesh), mesh.corners[rows])
            shown = cut_open(grid) if cut and number == 0 else grid
            plotter.add_mesh(shown, color=colour, show_edges=True, edge_color=EDGES, ambient=0.3)
    if mesh.dimension == 2:
        plotter.view_xy()
    else:
        view(plotter)
    plotter.camera.zoom(1.15)


def draw_angles(axes: Any, report: QualityReport, least: Array) -> None:
    """All angles as bars, the least of each element as steps, the least of all as a line."""
    edges, counts = (np.array(report.dihedral_histogram[key]) for key in ("edges_deg", "counts"))
    width = np.diff(edges)
    share = 100.0 * counts / max(counts.sum(), 1.0)
    axes.bar(edges[:-1], share, width, align="edge", color="#cfd8e3", edgecolor="#33475b", lw=0.5)
    own = np.histogram(least, edges)[0]
    axes.stairs(100.0 * own / len(least), edges, color="#0b6fb0", lw=1.6)
    axes.axvline(float(least.min()), color="#e0102a", lw=1.2)
    axes.set_xlim(0.0, 180.0)
    axes.set_xticks(np.arange(0, 181, 30))
    axes.set_xlabel("degrees")
    axes.set_ylabel("per cent")
    axes.set_title(
        f"{_angle(report)}s: all (grey), the least of each element (blue)\n"
        f"least of all {least.min():.1f} deg (red), {report.inverted_elements} inverted",
        loc="left",
        fontsize=9.5,
    )


def draw_ratios(axes: Any, ratios: dict[str, NDArray[Any]]) -> None:
    """Mean edges over the target sizes, zone by zone."""
    edges = np.geomspace(0.25, 4.0, 49)
    for zone, values in ratios.items():
        counts = np.histogram(np.clip(values, edges[0], edges[-1]), edges)[0]
        axes.stairs(
            100.0 * counts / len(values),
            edges,
            color=_COLOURS[zone],
            linestyle=_STYLES[zone],
            lw=1.5,
            label=f"{_NAMES.get(zone, 'in the ' + zone)} (mean {values.mean():.2f})",
        )
    axes.axvline(1.0, color="#6c6f73", lw=0.8)
    axes.set_xscale("log")
    axes.set_xticks([0.25, 0.5, 1.0, 2.0, 4.0], ["1/4", "1/2", "1", "2", "4"])
    axes.minorticks_off()
    axes.set_xlabel("mean edge over the target size there")
    axes.set_ylabel("per cent of the zone's elements")
    axes.set_ylim(0.0, 1.4 * axes.get_ylim()[1])
    axes.legend(fontsize=8.5, frameon=False, loc="upper left")
    axes.set_title("sizes against their targets", loc="left", fontsize=9.5)


def draw_quality(
    mesh: Mesh, design: Design, report: QualityReport, path: Path, requested: TargetSizes
) -> Path:
    """Write the PNG: the mesh cut open at z = 0, those of its worst elements marked that lie near
    the cut, the histogram of all angles and those of the sizes over their targets, zone by zone.

    MeshError where nothing can be rendered.
    """
    ratios = requested.ratios(mesh.points, mesh.corners)
    zones = size_zones(mesh, requested)
    by_zone = {zone: ratios[rows] for zone, rows in zones.items() if rows.any()}
    return drawn(paint_quality, path, mesh, report, by_zone, design.design.name)


def _angle(report: QualityReport) -> str:
    return "dihedral angle" if report.dimension == 3 else "angle"


def near_cut(mesh: Mesh, cells: list[int]) -> IntArray:
    """Those of the cells no farther from z = 0 than they are long; all where the mesh is flat."""
    chosen = np.array(cells, dtype=np.int64)
    if mesh.dimension == 2:
        return chosen
    corners = mesh.points[mesh.corners[chosen]]
    long = np.linalg.norm(np.ptp(corners, axis=1), axis=1)
    return np.asarray(chosen[np.abs(corners[..., 2]).min(axis=1) <= long])


def _interest(mesh: Mesh) -> tuple[str, IntArray]:
    """Title and nodes of the close view: plates or their slots, or the core."""
    parts = mesh.parts
    slots = [rows for name, rows in mesh.facets.items() if name.startswith("plate_")]
    plates = [mesh.cells[parts["plates"]].reshape(-1)]
    nodes = np.unique(np.concatenate(plates + [rows.reshape(-1) for rows in slots]))
    if len(nodes):
        return "close to the plates", nodes
    core = parts["core"]
    return ("close to the core" if core.any() else "at the crest"), np.unique(mesh.cells[core])


def paint_quality(
    mesh: Mesh, report: QualityReport, ratios: dict[str, Array], name: str, target: Path
) -> None:
    """Draw what ``draw_quality`` describes; runs in its process."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=(14.0, 8.2), dpi=110, layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=[1.6, 1.0], height_ratios=[1.25, 1.0])
    least = cell_angles(mesh.points, mesh.corners).min(axis=1)
    worst = [row["element"] for row in report.worst[:MARKED]]
    near = near_cut(mesh, worst)
    whole = f"{name}: {report.elements} elements ({report.mesher}), {report.dofs} dofs"
    whole += ", cut flat at z = 0" if report.modelled == "whole" else ""
    for row, (title, close) in enumerate(((whole, None), _interest(mesh))):
        scene = figure.add_subplot(grid[row, 0])
        scene.imshow(cropped(_cut_open(mesh, least, near, close)))
        scene.set_axis_off()
        scene.set_title(title, loc="left", fontsize=11, fontweight="bold" if row == 0 else None)
    scale = plt.cm.ScalarMappable(plt.Normalize(0.0, _SATURATED), "viridis")
    rings = f"the {len(worst)} worst"
    if len(near) < len(worst):
        rings = f"of {rings} the {len(near)} near the cut" if len(near) else "none near the cut"
    label = f"least {_angle(report)} of an element, degrees; red rings: {rings}"
    figure.colorbar(scale, ax=scene, location="bottom", aspect=40, extend="max", label=label)
    draw_angles(figure.add_subplot(grid[0, 1]), report, least)
    draw_ratios(figure.add_subplot(grid[1, 1]), ratios)
    figure.savefig(target)


def _cut_open(mesh: Mesh, least: Array, worst: IntArray, close: IntArray | None) -> NDArray[Any]:
    """Pixels of a view of what lies behind z = 0, coloured by the least angles (c,), rings about
    the ``worst`` cells; close: the nodes to look at (none: all from near), None: from afar."""
    import pyvista

    points, cells = placed(mesh), mesh.corners
    size = [VIEW[0], VIEW[1] if close is None else VIEW[1] * 3 // 4]
    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    plotter.set_background("white")
    grid = grid_of(points, cells)
    grid.cell_data["least"] = least
    plotter.add_mesh(
        cut_open(grid),
        scalars="least",
        cmap="viridis",
        clim=(0.0, _SATURATED),
        show_edges=True,
        edge_color=EDGES,
        line_width=0.5,
        show_scalar_bar=False,
        ambient=0.45,
    )
    if mesh.regions.any():
        inner = cut_open(grid_of(points, cells[mesh.regions > 0]))
        lines = inner.extract_surface().extract_feature_edges(30.0)
        if lines.n_cells:
            plotter.add_mesh(lines, color="black", line_width=2.0)
    if len(worst):
        plotter.add_point_labels(
            points[cells[worst]].mean(axis=1),
            ["O"] * len(worst),
            text_color="#e0102a",
            font_size=26,
            shape=None,
            show_points=False,
            always_visible=True,
            justification_horizontal="center",
            justification_vertical="center",
        )
    if close is None and mesh.dimension == 3:
        view(plotter)
    elif close is None:
        plotter.view_xy()
    else:
        near = points[close] if len(close) else points
        (left, bottom, _), (right, *_) = near.min(axis=0), near.max(axis=0)
        plotter.enable_parallel_projection()
        plotter.view_xy(bounds=(left, right, bottom, points[:, 1].max(), 0.0, 0.0))
        plotter.camera.zoom(1.6)
    return np.asarray(plotter.screenshot(return_img=True))
