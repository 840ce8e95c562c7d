"""Finer meshes for contacts of few nodes, which show little of pressure and nothing of slip.

The mesh is made for the contact that is forecast, and no finer than a third of what the design
says (mesh/sizing.py). Where the object is small, or barely touches, the contact is smaller than
that; how small, the first answer shows.
"""

from dataclasses import replace

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.fidelity.choice import Choice
from fingerdesign.analysis.path import closed_nodes, deepest, touch_point
from fingerdesign.arrays import Array, BoolArray
from fingerdesign.checks.load import with_values
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.design.scene import Scene
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.make import mesher_of

LEAST_NODES = 8  # In contact, at most over the rows: fewer show neither pressure nor slip.
_TARGET_NODES = 20  # More than needed, since the forecast of their number is rough.
_FINEST = 1.0 / 16.0  # Of the edge before: one attempt refines no further.
_MARGIN = 2.0  # Edges of the mesh before, around the contact that it showed.
_ATTEMPTS = 4  # One node shows little of how small the contact is.
_MOST_NODES = 800.0  # Candidates: so many take seconds in plane strain.


def finer(
    chosen: Choice, scene: Scene, problem: ContactProblem, steps: list[Step], attempt: int = 1
) -> tuple[Case, Zone] | None:
    """The case and the zone to solve again, its contact meshed finer; None where it holds enough
    nodes, or where nothing was pressed.

    chosen: as it was solved, for the ``attempt``-th time. Raises SolverError, which says what to
    do, where no mesh that is fine enough can be had.
    """
    closed = closed_nodes(steps)
    most = int(closed.sum(axis=1).max())
    if most >= LEAST_NODES or deepest(steps) <= 0.0:
        return None
    case, flat = chosen.case, chosen.case.fidelity == "plane-strain"
    few = f"the contact holds {most} nodes at most, and {LEAST_NODES} are needed: "
    _refuse_unmade(chosen, few)
    near = closed.any(axis=0)
    if not near.any():
        near = _touched(case, scene, problem.model.points)
    edge = float(np.median(_edges(problem)[near]))
    layered = flat or mesher_of(case.design).sections  # as many nodes along z, whatever the size
    share = max(most, 1) / _TARGET_NODES
    size = edge * max(share if layered else share**0.5, _FINEST)
    reach = np.abs(problem.model.points[near]).max(axis=0) + _MARGIN * edge
    zone = chosen.zone if case.runs_grips else _within(chosen.zone, reach)
    key = f"mesh.{'section.' if flat else ''}contact_size_mm"
    remedy = "press harder, take a larger object"
    if attempt >= _ATTEMPTS or _candidates(problem, zone, size, layered) > _MOST_NODES:
        raise SolverError(
            f"{few}its facets of {edge:.3g} mm are too long, and those of {size:.3g} mm would be "
            f"too many; {remedy}, or make {key} smaller all the same"
        )
    try:
        return replace(case, design=with_values(case.design, {key: size})), zone
    except DesignError:  # below the key's bound
        raise SolverError(f"{few}facets of {size:.3g} mm are too short; {remedy}") from None


def _refuse_unmade(chosen: Choice, few: str) -> None:
    """Raise SolverError where the mesh is the ladder's or a file's: neither is made finer here."""
    if chosen.summary is not None:
        raise SolverError(f"{few}name a fidelity, 3d or plane-strain, which meshes it finer")
    if chosen.case.design.mesh.mesher == "file" and chosen.case.fidelity != "plane-strain":
        raise SolverError(f"{few}press harder, or make the file's mesh finer there")


def _touched(case: Case, scene: Scene, points: Array) -> BoolArray:
    """The node (m,) nearest to where the object first touches."""
    x, z = touch_point(scene.object, case.design.body)
    along_z = points[:, 2] - z if points.shape[1] == 3 else 0.0
    away = np.hypot(points[:, 0] - x, along_z)
    return np.asarray(away == away.min())


def _within(zone: Zone, reach: Array) -> Zone:
    """The part of a zone that lies within ``reach`` (dim,), mm."""
    deep = None if zone.half_depth is None else min(zone.half_depth, float(reach[-1]))
    return replace(zone, half_width=min(zone.half_width, float(reach[0])), half_depth=deep)


def _candidates(problem: ContactProblem, zone: Zone, size: float, layered: bool) -> float:
    """About how many nodes a zone would hold with edges of ``size`` mm."""
    across, points = 2.0 * zone.half_width / size, problem.model.points
    if points.shape[1] == 2:
        return across
    if layered:
        return across * len(np.unique(np.round(points[:, 2], 6)))
    return across * float(np.ptp(points[:, 2])) / size


def _edges(problem: ContactProblem) -> Array:
    """Length (m,) of the facets about each node, mm."""
    model = problem.model
    flat = model.dimension == 2
    return np.asarray(model.areas / model.depth if flat else np.sqrt(model.areas))
