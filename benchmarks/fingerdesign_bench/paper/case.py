"""The finger that the paper's figures are remade with, its twin of rubber alone, and the paths.

All in plane strain, as the paper's model. The twin is the same body with the plates left out of the
model (``plates.model = "none"``): the paper's "homogeneous elastic body". Its strains are read
where the gages are, and at some depths under the surface above each.

Three ways are gone from no contact to complete slip, since what partial slip says may depend on it:

similar  the fundamental scene's approach, and its shear in proportion to the friction coefficient
same     one and the same motion for all friction coefficients, until each slips as a whole
growing  as similar, but the approach grows to the end, as it does in a grip
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.path import object_at_touch
from fingerdesign.analysis.slip_study import refined_rows, scaled_rows
from fingerdesign.analysis.stages import condense, make_mesh
from fingerdesign.arrays import Array, BoolArray
from fingerdesign.checks.load import with_values
from fingerdesign.contact.measures import completely_slips, level_sets
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.surface import surface_of

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.fem.model import FiniteElementModel
    from fingerdesign.layout.zone import Zone

Rows = list[tuple[float, float]]

FRICTIONS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)  # the paper says no more than "different"
PIECES = 5  # that a row of the scene is cut into, so that relations rest on enough increments
DEPTHS = (0.1, 0.2, 0.4, 0.8, 1.2)  # mm under the surface, where the twin's shear strain is read
PATHS = {
    "similar": "shear in proportion to μ",
    "same": "one motion for all",
    "growing": "approach growing to the end",
}
GROWING_SHARE = (0.4, 0.7, 0.88, 0.92, 0.95, 0.97, 0.985, 1.0)  # a harder scene: never held
_SAME_STEPS = 16  # shear increments of the same motion up to complete slip at the least friction
_LEAST_GAGES = 3


@dataclass(frozen=True)
class PaperCase:
    """Two condensed fingers that face the fundamental scene's object at its friction.

    gage_x (g,) mm; points of the twin: first the gages' places, then DEPTHS by DEPTHS under the
    surface above each. approach: the scene's largest, mm. rows: the scene's, (approach, shear) mm.
    """

    design: Design
    scene: Scene
    rows: Rows
    finger: ContactProblem
    twin: ContactProblem
    twin_model: FiniteElementModel
    depths: tuple[float, ...]
    dofs: int

    @property
    def gage_x(self) -> Array:
        return self.finger.model.gage_x

    @property
    def approach(self) -> float:
        return max(approach for approach, _ in self.rows)

    @property
    def face(self) -> str:
        return self.design.gages.face

    @property
    def friction(self) -> float:
        """The scene's."""
        return self.finger.friction_coefficient

    def steps(self, problem: ContactProblem) -> list[Step]:
        """One of the fingers along the scene's rows."""
        return list(follow(problem, [Motion(*row) for row in self.rows]))


def check_case(design: Design, scene: Scene) -> Case:
    """The case, with every fault of the design that keeps the figures from being made."""
    from fingerdesign.analysis.forecast.limits import refuse

    case = Case(design, None, "plane-strain", fields=False)
    if len(case.gage_array) < _LEAST_GAGES:
        remedy = "add plates in one row along x: the figures are about an array of gages"
        bound = f"at least {_LEAST_GAGES} in one row along x"
        raise DesignError([Fault("plates.count", len(case.gage_array), bound, remedy)])
    refuse(case, scene)
    return case


def build_case(case: Case, scene: Scene, zone: Zone) -> PaperCase:
    """Mesh and condense the finger and its twin; both have the same contact candidates."""
    design = case.design
    model = condense(design, make_mesh(design, "plane-strain", zone), zone, scene)
    rigid = object_at_touch(scene.object, design.body)
    friction = scene.object.friction_coefficient
    finger = contact_problem(model.reduced, rigid, friction)
    finger = replace(finger, model=finger.model.with_gages(case.gage_array))
    alone = with_values(design, {"plates.model": "none"})
    depths, points = _places(design, finger.model.gage_positions)
    readout = scene.readout.model_copy(update={"points_mm": tuple(map(tuple, points.tolist()))})
    pointed = scene.model_copy(update={"readout": readout})
    twin_model = condense(alone, make_mesh(alone, "plane-strain", zone), zone, pointed)
    return PaperCase(
        design=design,
        scene=scene,
        rows=[(row[0], row[1]) for row in scene.path.rows],
        finger=finger,
        twin=contact_problem(twin_model.reduced, rigid, friction),
        twin_model=twin_model,
        depths=depths,
        dofs=model.dofs,
    )


def path_rows(case: PaperCase, path: str, friction: float) -> Rows:
    """Rows (approach, shear), mm, of one of :data:`PATHS` at a friction coefficient."""
    factor = friction / case.friction
    if path == "similar":
        return refined_rows(scaled_rows(case.rows, factor), PIECES)
    shears = [shear for _, shear in case.rows]
    if path == "growing":
        given = np.linspace(0.0, 1.0, len(GROWING_SHARE))
        shares = np.interp(np.linspace(0.0, 1.0, len(shears)), given, GROWING_SHARE)
        growing = [
            (share * case.approach, shear) for share, shear in zip(shares, shears, strict=True)
        ]
        return refined_rows(scaled_rows(growing, factor), PIECES)
    if path == "same":
        press = refined_rows([(case.approach, 0.0)], 2 * PIECES)
        least, most = (f / case.friction * shears[-1] for f in (FRICTIONS[0], FRICTIONS[-1]))
        step = least / _SAME_STEPS
        count = int(np.ceil(most / step))
        return press + [(case.approach, step * k) for k in range(1, count + 1)]
    raise ValueError(f"path = {path!r}: must be one of {', '.join(PATHS)}")


def follow_rows(problem: ContactProblem, rows: Sequence[tuple[float, float]]) -> Iterator[Step]:
    """The increments of ``rows`` up to complete slip, its first increment included."""
    for step in follow(problem, [Motion(*row) for row in rows]):
        yield step
        if completely_slips(step.measures, problem.model.dimension):
            return


def above(problem: ContactProblem, step: Step, x: Array) -> tuple[BoolArray, BoolArray]:
    """Whether the surface straight above each of ``x`` touches, and whether it sticks."""
    order = np.argsort(problem.model.points[:, 0])
    places = problem.model.points[order, 0]
    touching, sticking = (  # beyond the candidates nothing touches
        np.interp(x, places, level[order], left=-1.0, right=-1.0) > 0.0
        for level in level_sets(problem, step.increment)
    )
    return touching, touching & sticking


def surface_heights(design: Design, x: Array) -> Array:
    """y of the undeformed surface above ``x`` on z = 0, mm."""
    return np.asarray(surface_of(design.body).height(x, np.zeros_like(x)))


def _places(design: Design, gages: Array) -> tuple[tuple[float, ...], Array]:
    """Of DEPTHS, those that stay clear of the base under every gage, and the twin's readout points
    (p, 3): at the gages, then at each of these depths under the surface."""
    x = gages[:, 0]
    top = surface_heights(design, x)
    depths = tuple(depth for depth in DEPTHS if depth < 0.5 * top.min())
    under = [np.column_stack([x, top - depth, np.zeros_like(x)]) for depth in depths]
    return depths, np.vstack([gages * [1.0, 1.0, 0.0], *under])
