"""Designs, faults and parts of boxes that tests of molds share.

Their molds are closed, which have everything that a mold may have; tests/mold/test_open_mold.py has
the open ones.
"""

import lib3mf
import numpy as np
from fingerdesign_bench.any_finger.designs import random_design

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.schema import Design
from fingerdesign.design.step import resolved
from fingerdesign.errors import DesignError
from fingerdesign.layout.volume import enclosed_volume as volume
from fingerdesign.mold.part import PartMesh
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.plan.refusals import MoldRefused
from fingerdesign.mold.plan.remedies import remedied
from fingerdesign.mold.products.three_mf import _locale_kept

CLOSED = {"mold.pour": "closed"}
CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)
BOX = np.array(
    [
        *([0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4]),
        *([1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]),
    ]
)


def box(name, low, high, draw=None, order=9, made="process"):
    """A box between two corners as a part."""
    low, high = np.array(low, float), np.array(high, float)
    return meshed(name, CORNERS * (high - low) + low, BOX, draw, order, made)


def meshed(name, points, triangles, draw=None, order=9, made="process", volume=None):
    """Triangles as a part; the volume of a box by default."""
    volume = float(np.prod(np.ptp(points, axis=0))) if volume is None else volume
    return PartMesh(name, points, triangles, draw, order, made, volume, 0.0, volume)


def made(body=None, plates=None, mold=None):
    """A design of three tables."""
    tables = {"body": body or {}, "plates": plates or {}, "mold": mold or {}}
    tables["mold"] = {"pour": "closed", **tables["mold"]}
    return Design.model_validate({"design": {"name": "t"}, **tables})


def shipped(name, **values):
    """A shipped design with other values, ``__`` for the dots of their keys."""
    given = {key.replace("__", "."): value for key, value in values.items()}
    return with_values(load_design(name), {**CLOSED, **given})


def drawn(seed):
    """A random design."""
    return with_values(Design.model_validate(resolved(random_design(seed))[0]), CLOSED)


def mold_faults(design):
    """The faults that keep a design's mold from being planned."""
    try:
        plan_mold(design)
    except DesignError as error:
        return error.faults
    return ()


def mold_remedies(design):
    """The same faults, with their remedies."""
    try:
        plan_mold(design)
    except MoldRefused as refused:
        return remedied(design, refused).faults
    return ()


def keys(faults):
    """The keys of faults."""
    return [fault.key for fault in faults]


def read_3mf(path):
    """Of each part in a 3MF file of millimetres by name: vertices, triangles, volume in mm^3."""
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    with _locale_kept():
        reader.ReadFromFile(str(path))
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    items, held = model.GetBuildItems(), {}
    while items.MoveNext():
        mesh = items.GetCurrent().GetObjectResource()
        assert mesh.IsManifoldAndOriented()
        points = np.array([each.Coordinates[:] for each in mesh.GetVertices()])
        triangles = np.array([each.Indices[:] for each in mesh.GetTriangleIndices()], dtype=int)
        held[mesh.GetName()] = len(points), len(triangles), volume(points, triangles)
    return held
