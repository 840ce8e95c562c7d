"""The finger that the paper's figures are remade with, and its twin of rubber alone.

Both in plane strain, as the paper's model. The twin is the same body with the plates left out of
the model (``plates.model = "none"``): the paper's "homogeneous elastic body".
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.path import problem_at_touch
from fingerdesign.analysis.stages import condense, make_mesh
from fingerdesign.arrays import Array, BoolArray
from fingerdesign.checks.load import with_values
from fingerdesign.contact.measures import completely_slips, level_sets
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.fem.model import FiniteElementModel
from fingerdesign.layout.zone import Zone

Rows = list[tuple[float, float]]

FRICTIONS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)  # The paper calls them "different".
_LEAST_GAGES = 3  # Fewer gages show no area.


@dataclass(frozen=True)
class PaperCase:
    """Two condensed fingers that face the fundamental scene's object at its friction.

    gage_x (g,) mm. approach: the scene's largest, mm. rows: the scene's, (approach, shear) mm.
    """

    design: Design
    scene: Scene
    rows: Rows
    finger: ContactProblem
    twin: ContactProblem
    twin_model: FiniteElementModel
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
    case = Case(design, None, "plane-strain", fields=False)
    if len(case.gage_array) < _LEAST_GAGES:
        remedy = "add plates in one row along x: the figures are about an array of gages"
        bound = f"at least {_LEAST_GAGES} in one row along x"
        raise DesignError([Fault("plates.count", len(case.gage_array), bound, remedy)])
    refuse(case, scene)
    return case


def build_case(design: Design, scene: Scene, zone: Zone) -> PaperCase:
    """Mesh and condense the finger and its twin; both have the same contact candidates."""
    case = check_case(design, scene)
    model = condense(design, make_mesh(design, "plane-strain", zone), zone, scene)
    finger = problem_at_touch(model.reduced, scene.object, design.body)
    finger = replace(finger, model=finger.model.with_gages(case.gage_array))
    alone = with_values(design, {"plates.model": "none"})
    twin_model = condense(alone, make_mesh(alone, "plane-strain", zone), zone, scene)
    return PaperCase(
        design=design,
        scene=scene,
        rows=[(row[0], row[1]) for row in scene.path.rows],
        finger=finger,
        twin=problem_at_touch(twin_model.reduced, scene.object, design.body),
        twin_model=twin_model,
        dofs=model.dofs,
    )


def follow_rows(problem: ContactProblem, rows: Sequence[tuple[float, float]]) -> Iterator[Step]:
    """The increments of ``rows`` up to complete slip, its first increment included."""
    for step in follow(problem, [Motion(*row) for row in rows]):
        yield step
        if completely_slips(step.measures, problem.model.dimension):
            return


def above(problem: ContactProblem, step: Step, x: Array) -> tuple[BoolArray, BoolArray]:
    """Masks of ``x``: the surface straight above touches; it sticks."""
    order = np.argsort(problem.model.points[:, 0])
    places = problem.model.points[order, 0]
    touching, sticking = (  # beyond the candidates nothing touches
        np.interp(x, places, level[order], left=-1.0, right=-1.0) > 0.0
        for level in level_sets(problem, step.increment)
    )
    return touching, touching & sticking
