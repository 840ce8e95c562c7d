"""How smooth the pressure along the contact's middle is: against facets of 0.1 mm."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.path import follow_path, object_at_touch
from fingerdesign.analysis.stages import condense, make_mesh, one_thread, zone_of
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.checks.starter import shipped_path
from fingerdesign.contact.problem import contact_problem
from fingerdesign.contact.recovery import middle_weights
from fingerdesign.layout.zone import candidate_zone, greatest_approach
from fingerdesign_bench.check import Check

if TYPE_CHECKING:
    from fingerdesign.arrays import Array
    from fingerdesign.design.schema import Design
    from fingerdesign.reduced import ReducedModel

ASKED = 0.03  # of the peak
# Of the contact's half-width: beyond, the pressure falls more steeply than any facet can follow,
# and what two meshes differ by is where the last facet ends.
WITHIN = 0.8
FINE_MM, FINE_LAYERS = 0.1, 6
_PLACES = 401


def smoothness_checks() -> list[Check]:
    """Peak-to-peak ripple of the reference finger's pressure at z = 0, fully pressed and sheared.

    The ripple is what the pressure, as the page draws it, differs by from that of the swept finger
    with facets of FINE_MM, over WITHIN of the contact's half-width, over its peak. (Facets half as
    long as the design's do not judge: from FINE_MM they differ by 8 % of the peak themselves.)
    """
    demo = load_design(shipped_path("maeno2000"))
    swept = with_values(demo, {"mesh.mesher": "extrude"})
    facets = {"mesh.contact_size_mm": FINE_MM, "mesh.layers": FINE_LAYERS}
    fine, _ = middle_pressures(with_values(swept, facets), drawn=False)
    found = []
    for mesher, design in (("tetwild", demo), ("extrude", swept)):
        pressures, nodes = middle_pressures(design)
        label = f"pressure at z = 0, {mesher}, {nodes} candidate nodes: ripple over peak"
        worst = max(ripple(*pair) for pair in zip(pressures, fine, strict=True))
        found.append(Check(label, ASKED, worst))
    return found


def ripple(pressure: Array, fine: Array) -> float:
    """Peak-to-peak difference of two pressures (places,) over the middle of the contact, over the
    greatest of the second."""
    x = np.linspace(-1.0, 1.0, len(fine))
    inside = np.abs(x) <= WITHIN * np.abs(x[fine > 1e-6 * fine.max()]).max()
    return float(np.ptp((pressure - fine)[inside]) / fine.max())


def middle_pressures(design: Design, drawn: bool = True) -> tuple[list[Array], int]:
    """Pressures (places,) MPa at z = 0 after the rows of the fundamental path with the greatest
    approach, and the candidates' number; drawn: with as many as the grips ask for, and as the page
    draws it, else straight from the nodes."""
    case = Case(design, fields=False)
    scene = case.path_scene
    deepest = greatest_approach(design, scene)
    own = candidate_zone(design, scene.object, deepest)
    zone = zone_of(case, scene) if drawn else own
    model = condense(design, make_mesh(design, "3d", zone), zone, scene).reduced
    rigid = object_at_touch(scene.object, design.body)
    problem = contact_problem(model, rigid, scene.object.friction_coefficient)
    with one_thread():
        steps = follow_path(problem, scene, design)
    pressed = [k for k, row in enumerate(scene.path.rows) if row[0] == deepest]
    x = np.linspace(-own.half_width, own.half_width, _PLACES)
    line = recovered(model, x) if drawn else along_middle(model, x)
    return [-line @ (steps[k].increment.force[:, 1] / model.areas) for k in pressed], model.nodes


def recovered(model: ReducedModel, x: Array) -> Array:
    """Weights (places, nodes) of a half model's nodal tractions at places x (mm) of z = 0, as the
    page draws them."""
    middle = np.flatnonzero(np.abs(model.points[:, 2]) < 1e-6)
    line = middle[np.argsort(model.points[middle, 0])]
    return middle_weights(model.points, model.areas, line, x, half=True)


def along_middle(model: ReducedModel, x: Array) -> Array:
    """Weights (places, nodes) of the nodal tractions at places x (mm) of z = 0, on the facets."""
    corners = model.points[model.facets][:, :, [0, 2]]
    weights = np.zeros((len(x), model.nodes))
    edges = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
    inverse = np.linalg.inv(edges)
    for row, place in enumerate(x):
        local = np.einsum("fab,fb->fa", inverse, np.array([place, 0.0]) - corners[:, 0])
        shares = np.column_stack([1.0 - local.sum(axis=1), local])
        facet = int(shares.min(axis=1).argmax())
        weights[row, model.facets[facet]] = shares[facet]
    return weights
