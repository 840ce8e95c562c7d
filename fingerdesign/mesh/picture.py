"""A picture of a mesh: its outside with edges and, of a whole finger, its inside too (pyvista).

Plates are bronze, a core purple, and a legend says so. VTK is native code that can crash where
graphics drivers are odd: it draws in a process of its own.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.errors import MeshError
from fingerdesign.mesh.types import Mesh
from fingerdesign.runtime.files import whole_file
from fingerdesign.runtime.isolate import Function, ProcessError, call

TIME_LIMIT_S = 120.0  # drawing takes 1 to 2 s; a software renderer on a busy machine far longer
SIZE = (1600, 1120)
SILICONE, BRONZE, CORE, EDGES = "#cfd8e3", "#b87333", "#a487b5", "#33475b"


def placed(mesh: Mesh) -> Array:
    """Nodes (n, 3) as they are drawn: of a half model its mirror image z <= 0, the cut in front."""
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.dimension] = mesh.points
    if mesh.symmetric:
        points[:, 2] *= -1.0
    return points


def view(plotter: Any) -> None:
    """Look from the front, a little from above and the left."""
    plotter.view_vector((-0.3, 0.4, 1.0), viewup=(0.0, 1.0, 0.0))


def cut_open(grid: Any) -> Any:
    """The part z <= 0 of an unstructured grid, cut flat; all of it where none lies in front."""
    return grid.clip("z", origin=(0.0, 0.0, 0.0)) if grid.bounds[5] > 1e-9 else grid


def cropped(image: NDArray[Any]) -> tuple[NDArray[Any], tuple[int, int]]:
    """Pixels without the white around them, and the column and row of their first corner."""
    rows, columns = np.nonzero((image < 250).any(axis=2))
    if not len(rows):
        return image, (0, 0)
    top, left = int(rows.min()), int(columns.min())
    return image[top : rows.max() + 1, left : columns.max() + 1], (left, top)


def draw_mesh(
    mesh: Mesh, path: Path | str, time_limit_s: float = TIME_LIMIT_S, name: str = ""
) -> Path:
    """Write a PNG of a mesh: a section seen along -z, a half model with its mid-plane in front, a
    whole one beside itself cut open at z = 0. ``name``: the design's, for the title.

    MeshError where nothing can be rendered (no off-screen graphics on this machine).
    """
    path = Path(path)
    cores = [number for number, region in mesh.region_names.items() if region == "core"]
    part = np.where(np.isin(mesh.regions, cores), 2, np.minimum(mesh.regions, 1))
    whole = mesh.dimension == 3 and not mesh.symmetric
    data = {
        "points": placed(mesh),
        "cells": mesh.corners,
        "part": part,
        "whole": whole,
        "title": picture_title(mesh, name),
    }
    return drawn(paint_mesh, path, time_limit_s, data)


def drawn(paint: Function, path: Path, time_limit_s: float, *given: Any) -> Path:
    """``paint(*given, path)`` in a process of its own, whole or not at all; MeshError says why."""
    try:
        with whole_file(path.absolute()) as aside:
            call(paint, *given, aside, time_s=time_limit_s)
    except ProcessError as error:
        raise MeshError(f"the picture {path} could not be drawn: {error}") from error
    return path


def picture_title(mesh: Mesh, name: str = "") -> str:
    """What is drawn: of which design, how much of it, of how many elements."""
    shown = "the section z = 0"
    if mesh.dimension == 3:
        shown = "the half z >= 0" if mesh.symmetric else "the whole finger, and cut open at z = 0"
    about = f"{shown}; {len(mesh.cells)} elements ({mesh.mesher})"
    return f"{name}: {about}" if name else about


def paint_mesh(data: dict[str, Any], target: Path) -> None:
    """Draw a PNG; runs in its process. VTK's errors pass: the caller gets the last line of them."""
    import pyvista

    whole = bool(data["whole"])
    plotter = pyvista.Plotter(
        off_screen=True,
        window_size=[SIZE[0] * (1 + whole), SIZE[1]],
        shape=(1, 1 + whole),
        border=False,
    )
    for column in range(1 + whole):
        plotter.subplot(0, column)
        _draw(plotter, data, cut=column == 1)
    plotter.subplot(0, 0)
    plotter.add_text(data["title"], position="upper_left", font_size=14, color="black")
    parts = zip(("elastomer", "plates", "core"), (SILICONE, BRONZE, CORE), strict=True)
    shown = [list(part) for k, part in enumerate(parts) if (data["part"] == k).any()]
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


def _draw(plotter: Any, data: dict[str, NDArray[Any]], cut: bool) -> None:
    """The mesh; ``cut``: of the rubber z <= 0, with plates and core standing out of it."""
    import pyvista

    points, cells, part = data["points"], data["cells"], data["part"]
    plotter.set_background("white")
    kind = pyvista.CellType.TRIANGLE if cells.shape[1] == 3 else pyvista.CellType.TETRA
    for number, colour in enumerate((SILICONE, BRONZE, CORE)):
        rows = part == number
        if rows.any():
            grid = pyvista.UnstructuredGrid({kind: cells[rows]}, points)
            shown = cut_open(grid) if cut and number == 0 else grid
            plotter.add_mesh(shown, color=colour, show_edges=True, edge_color=EDGES, ambient=0.3)
    if cells.shape[1] == 3:
        plotter.view_xy()
    else:
        view(plotter)
    plotter.camera.zoom(1.15)
