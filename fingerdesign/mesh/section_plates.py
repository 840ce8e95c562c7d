"""Plates in the section's outline: boxes, bent boxes, or the mid-lines of sheets."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.layout import PlateFrame, plate_frames
from fingerdesign.mesh.outline import BODY, Outline
from fingerdesign.mesh.sheets import boundary_facets, line_beyond, room_around

if TYPE_CHECKING:
    from fingerdesign.design.meshing import SectionMesh
    from fingerdesign.design.schema import Body, Design


_SAGITTA = 0.1  # of the thickness: what a chord of a bent face may leave, before its middle is bent


def section_frames(design: Design) -> tuple[PlateFrame, ...]:
    """The plates that the section z = 0 cuts across their span; none where they are left out."""
    if design.plates.model == "none":
        return ()
    return tuple(f for f in plate_frames(design) if f.along == "x" and f.low <= 0.0 <= f.high)


def add_plates(
    outline: Outline, frames: tuple[PlateFrame, ...], gage_length: float, sizes: SectionMesh
) -> None:
    """Add solid plates as domains, fine at their square ends."""
    for frame in frames:
        _add_plate(outline, frame, gage_length, sizes)


def add_sheets(
    outline: Outline,
    frames: tuple[PlateFrame, ...],
    gage_length: float,
    sizes: SectionMesh,
    body: Body,
) -> None:
    """Add plates as their mid-lines inside the body.

    Beyond each end goes a short line within which the square ends will open.
    """
    for frame in frames:
        beyond = line_beyond(frame, room_around(frame, frames, body), sizes.plate_end_size_mm)
        along = _stations(frame, gage_length)
        along = [along[0] - beyond, *along, along[-1] + beyond]
        last = len(along) - 1
        line = []
        for k, (x, y) in enumerate(frame.from_local(np.array(along), 0.0)):
            line.append(outline.point(x, y, beyond if k in (1, last - 1) else None))
        for k, (a, b) in enumerate(pairwise(line)):
            size = beyond if k in (0, last - 1) else sizes.plate_size_mm
            outline.curve([a, b], BODY, BODY, size)


def bend_faces(
    points: Array, cells: IntArray, regions: IntArray, frames: tuple[PlateFrame, ...]
) -> Array:
    """Points (n, dim) of a quadratic mesh with the mid-nodes of bent plates' faces on the bend."""
    moved = points.copy()
    for frame in frames:
        if frame.bend_radius is None:
            continue
        face = _lateral_nodes(points, cells[regions == frame.index + 1])
        s, v = frame.local(points[face]).T
        on = np.abs(s) < 0.5 * frame.length - 1e-6  # the square ends stay as they are
        face, s = face[on], s[on]
        level = 0.5 * frame.thickness * np.sign(v[on])
        moved[face, :2] = frame.from_local(s, level)
    return moved


def _lateral_nodes(points: Array, cells: IntArray) -> IntArray:
    """Nodes on the surface of some cells, but of its parts of constant z: where a plate ends."""
    dimension = points.shape[1]
    facets = boundary_facets(cells, dimension)
    if dimension == 3:
        z = points[facets[:, :3], 2]
        facets = facets[np.ptp(z, axis=1) > 1e-9]
    return np.unique(facets)


def _add_plate(outline: Outline, frame: PlateFrame, gage_length: float, sizes: SectionMesh) -> None:
    domain = BODY + 1 + frame.index
    along = np.array(_stations(frame, gage_length))
    last = len(along) - 1
    rows = []
    for side in (-0.5, 0.5):
        where = frame.from_local(along, side * frame.thickness)
        size = sizes.plate_end_size_mm
        rows.append(
            [
                outline.point(x, y, size if k in (0, last) else None)
                for k, (x, y) in enumerate(where)
            ]
        )
    lower, upper = rows
    for k in range(last):
        _add_face(outline, frame, (lower[k], lower[k + 1]), domain, sizes)
        _add_face(outline, frame, (upper[k + 1], upper[k]), domain, sizes)
    outline.curve([lower[-1], upper[-1]], domain, BODY, sizes.plate_end_size_mm)
    outline.curve([upper[0], lower[0]], domain, BODY, sizes.plate_end_size_mm)
    outline.domains.append((domain, sizes.plate_size_mm))


def _add_face(
    outline: Outline, frame: PlateFrame, ends: tuple[int, int], domain: int, sizes: SectionMesh
) -> None:
    size = sizes.plate_size_mm
    if frame.bend_radius is None:
        outline.curve(list(ends), domain, BODY, size)
        return
    centre = frame.centre - frame.bend_radius * frame.normal
    most = float(np.sqrt(8.0 * _SAGITTA * frame.thickness * frame.bend_radius))
    outline.arc(ends, centre, domain, BODY, min(size, most))


def _stations(frame: PlateFrame, gage_length: float) -> list[float]:
    """Vertices along a plate: its ends, and the gage's, so that its strain is a difference of
    nodal displacements."""
    along = [-0.5 * frame.length, 0.5 * frame.length]
    if gage_length < 0.98 * frame.length:
        along[1:1] = [-0.5 * gage_length, 0.5 * gage_length]
    return along
