"""Where a face of a CAD solid ends, as pieces that numpy computes with; runs in the worker.

Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.GCPnts import GCPnts_AbscissaPoint
from OCP.GeomAbs import GeomAbs_Line
from OCP.gp import gp_Pnt, gp_Vec
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FORWARD, TopAbs_REVERSED
from OCP.TopoDS import TopoDS

from fingerdesign.arrays import Array
from fingerdesign.design.face_border import Border
from fingerdesign.design.quadrics import Shape
from fingerdesign.geometry.step_shape import parts

PIECES = 600  # of a face's border
LEAST_PIECES = 24  # of a curved edge: 1e-7 mm on a quarter circle of 0.5 mm


def triple(place: Any) -> Array:
    """The numbers of a kernel's point or direction."""
    return np.array([place.X(), place.Y(), place.Z()])


def border_of(face: Any, shape: Shape, sign: float) -> Border:
    """The face's edges in pieces, but for seams, where it goes on, and poles."""
    edges = []
    for part in parts(face, TopAbs_EDGE):
        edge = TopoDS.Edge_s(part)
        if edge.Orientation() not in (TopAbs_FORWARD, TopAbs_REVERSED):
            continue
        if BRep_Tool.Degenerated_s(edge) or BRep_Tool.IsClosed_s(edge, face):
            continue
        curve = BRepAdaptor_Curve(edge)
        edges.append((edge, curve, float(GCPnts_AbscissaPoint.Length_s(curve))))
    total = sum(length for *_, length in edges)
    columns: list[list[Array]] = [[] for _ in range(4)]
    for edge, curve, length in edges:
        straight = curve.GetType() == GeomAbs_Line
        number = max(int(np.ceil(PIECES * length / total)), 2 if straight else LEAST_PIECES)
        places, slopes = edge_samples(curve, number)
        if edge.Orientation() == TopAbs_REVERSED:
            places, slopes = places[::-1], -slopes[::-1]
        for column, values in zip(
            columns, (places[:-1], places[1:], slopes[:-1], slopes[1:]), strict=True
        ):
            column.append(values)
    if not edges:
        return Border(*(np.zeros((0, 3)) for _ in range(6)))
    start, end, leaving, arriving = (np.concatenate(column) for column in columns)
    # The face lies to the left of its edges, seen from outside.
    inward = [
        np.cross(sign * shape.normal(places), slopes)
        for places, slopes in ((start, leaving), (end, arriving))
    ]
    inward = [m / np.maximum(np.linalg.norm(m, axis=1), 1e-300)[:, None] for m in inward]
    return Border(start, end, leaving, arriving, *inward)


def edge_samples(curve: Any, number: int) -> tuple[Array, Array]:
    """Places and derivatives (by pieces) at the ends of ``number`` pieces, (number + 1, 3)."""
    first, last = curve.FirstParameter(), curve.LastParameter()
    step = (last - first) / number
    places, slopes = np.empty((number + 1, 3)), np.empty((number + 1, 3))
    for k in range(number + 1):
        place, slope = gp_Pnt(), gp_Vec()
        curve.D1(first + k * step, place, slope)
        places[k], slopes[k] = triple(place), step * triple(slope)
    return places, slopes
