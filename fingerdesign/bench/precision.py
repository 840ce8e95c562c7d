"""Speed against accuracy: error of forces and gage strains against wall time, mesh by mesh."""

from __future__ import annotations

import csv
import os
import platform
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fingerdesign.contact.objects import Plane
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.design.io import load_design, with_values
from fingerdesign.design.layout import crest_height
from fingerdesign.design.schema import Design
from fingerdesign.design.starter import shipped_path

Array = NDArray[np.float64]
Tell = Callable[[str], None]

# A finger with three of the reference finger's plates, so that a much finer mesh can be afforded.
VALUES = {
    "body.depth_mm": 6.0,
    "plates.placement": [[-1.5, 7.0, 45.0], [0.0, 7.0, 45.0], [1.5, 7.0, 45.0]],
    "plates.span_mm": 6.0,
}
ROWS = ((0.05, 0.0), (0.1, 0.0), (0.1, 0.03), (0.1, 0.06), (0.1, 0.09))
SECTIONS = (0.4, 0.2, 0.1, 0.05, 0.025)  # mm, contact facets; plates and the rest in proportion
EXTRUDED = (0.8, 0.6, 0.45, 0.35, 0.25)
TETRAHEDRA = (0.8, 0.6, 0.45, 0.35)
FINEST = {"plane strain": 0.0125, "3-D": 0.17}


@dataclass(frozen=True)
class Point:
    """One mesh: seconds from mesh to last increment, and errors against the finest mesh."""

    method: str
    size_mm: float
    dofs: int
    seconds: float
    normal_force_error: float
    tangential_force_error: float
    stick_ratio_error: float
    gage_error: float


def measure_precision(tell: Tell = lambda message: None) -> list[Point]:
    """All points; the reference of plane strain is a finer section, that of 3-D a finer extrusion.

    Force errors are relative, stick ratios absolute, gage strains relative to the largest reading
    of the increment; each is the worst over the increments.
    """
    points = []
    families = (
        ("plane strain", "plane strain", SECTIONS),
        ("3-D", "3-D extruded", EXTRUDED),
        ("3-D", "3-D pytetwild", TETRAHEDRA),
    )
    finest: dict[str, Array] = {}
    for kind, method, sizes in families:
        if kind not in finest:
            tell(f"{kind}: the finest mesh")
            finest[kind] = _solve("3-D extruded" if kind == "3-D" else kind, FINEST[kind])[0]
        for size in sizes:
            tell(f"{method}, {size:g} mm")
            found, dofs, seconds = _solve(method, size)
            points.append(Point(method, size, dofs, seconds, *_errors(found, finest[kind])))
    return points


def write_precision(points: list[Point], folder: Path) -> list[Path]:
    """precision.csv and precision.png."""
    folder.mkdir(parents=True, exist_ok=True)
    table = folder / "precision.csv"
    with table.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(asdict(points[0])), lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(point) for point in points)
    chart = folder / "precision.png"
    _draw(points, chart)
    return [table, chart]


def _solve(method: str, size: float) -> tuple[Array, int, float]:
    """Rows (k, 3 + gages) of F_n, F_t, stick ratio and membrane readings; dofs; seconds."""
    from fingerdesign.design.contact_zone import candidate_zone
    from fingerdesign.design.scene import SceneObject
    from fingerdesign.fem.model import build_model
    from fingerdesign.mesh.extrude import extrude
    from fingerdesign.mesh.section import mesh_section
    from fingerdesign.mesh.tetwild import tetrahedralise
    from fingerdesign.pipeline import one_thread

    design = _sized(method, size)
    zone = candidate_zone(design, SceneObject(), ROWS[-1][0]).half_width
    start = time.perf_counter()
    if method == "plane strain":
        mesh = mesh_section(design, zone)
    elif method == "3-D extruded":
        mesh = extrude(design, zone)
    else:
        mesh = tetrahedralise(design, zone, use_cache=False)
    model = build_model(design, mesh, zone).reduced
    problem = contact_problem(model, Plane(crest_height(design.body)), 0.5)
    with one_thread():
        steps = list(follow(problem, [Motion(*row) for row in ROWS]))
    seconds = time.perf_counter() - start
    rows = [
        [
            s.measures.normal_force,
            s.measures.tangential_force,
            s.measures.stick_ratio or 0.0,
            *s.measures.gages.mean(axis=1),
        ]
        for s in steps
    ]
    return np.array(rows), mesh.points.size, seconds


def _sized(method: str, size: float) -> Design:
    design = with_values(load_design(shipped_path("maeno2000")), VALUES)
    if method == "plane strain":
        values = {
            "mesh.section.contact_size_mm": size,
            "mesh.section.plate_size_mm": size,
            "mesh.section.plate_end_size_mm": 0.4 * size,
            "mesh.section.far_size_mm": 10 * size,
        }
    else:
        values = {
            "mesh.contact_size_mm": size,
            "mesh.plate_size_mm": size,
            "mesh.far_size_mm": 3.5 * size,
            "mesh.layers": max(2, round(2.2 / size)),
        }
    return with_values(design, values)


def _errors(found: Array, finest: Array) -> tuple[float, float, float, float]:
    sheared = np.array([row[1] > 0 for row in ROWS])
    normal = np.abs(found[:, 0] / finest[:, 0] - 1.0).max()
    tangential = np.abs(found[sheared, 1] / finest[sheared, 1] - 1.0).max()
    stick = np.abs(found[:, 2] - finest[:, 2]).max()
    largest = np.abs(finest[:, 3:]).max(axis=1, keepdims=True)
    gage = (np.abs(found[:, 3:] - finest[:, 3:]) / largest).max()
    return float(normal), float(tangential), float(stick), float(gage)


def _draw(points: list[Point], path: Path) -> None:
    from matplotlib.figure import Figure

    names = {
        "normal_force_error": "normal force, relative",
        "tangential_force_error": "tangential force, relative",
        "stick_ratio_error": "stick ratio, absolute",
        "gage_error": "gage strain, of the largest",
    }
    marks = {"plane strain": "o-", "3-D extruded": "s--", "3-D pytetwild": "^:"}
    figure = Figure(figsize=(8, 6), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True)
    for ax, (key, title) in zip(axes.flat, names.items(), strict=True):
        for method, mark in marks.items():
            line = [point for point in points if point.method == method]
            ax.loglog(
                [p.seconds for p in line], [getattr(p, key) for p in line], mark, label=method
            )
        ax.set_title(title, fontsize=9)
        ax.grid(True, which="both", alpha=0.25)
        ax.tick_params(labelsize=8)
        ax.set_ylim(1e-4, 1e-1)
    for ax in axes[1]:
        ax.set_xlabel("seconds, mesh to last increment", fontsize=8)
    for ax in axes[:, 0]:
        ax.set_ylabel("worst error over 5 increments", fontsize=8)
    axes[0, 0].legend(fontsize=8)
    figure.suptitle(
        f"reference: the finest mesh of the kind; {os.cpu_count()} cores, {platform.machine()}, "
        "imports warm, caches cold",
        fontsize=8,
    )
    figure.savefig(path, dpi=130)
