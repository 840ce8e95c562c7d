"""One way of modelling a finger in a scene, and what it answers: the rungs' and checks' workhorse.

    solved = solve(design, scene, Model("3-D", sizes, layers=6))
    solved.readings.normal_force

A model is a dimension, element sizes and a model of the plates. A condensed model stays,
so further paths (another friction, forces instead of motions) cost their increments alone.
"""

import time
from dataclasses import dataclass, field
from typing import Literal

from fingerdesign.analysis.case import Case, Clock
from fingerdesign.analysis.fidelity.readings import Readings, readings_of
from fingerdesign.analysis.path import follow_path, problem_at_touch
from fingerdesign.analysis.stages import condense, in_wide_zone, make_mesh, zone_of
from fingerdesign.checks.load import with_values
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.fem.model import FiniteElementModel
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.make import mesher_name
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.types import Mesh
from fingerdesign.runtime.threads import one_thread

Dimension = Literal["plane strain", "3-D"]
Plates = Literal["solid", "sheet", "none"]


@dataclass(frozen=True)
class Model:
    """The way in which one solve models a finger.

    sizes: element edges, as of a section. layers: of an extruded finger, in half its depth. plates,
    mesher (where it is in space) and element: None as the design says.
    """

    dimension: Dimension
    sizes: SectionMesh
    layers: int = 8
    plates: Plates | None = None
    mesher: str | None = None
    element: str | None = None

    @property
    def name(self) -> str:
        """A few words: "3-D, 0.4 mm, 8 layers"."""
        words = [self.dimension, f"{self.sizes.contact_size_mm:.3g} mm"]
        words += [f"{self.layers} layers"] if self.mesher == "sweep" else []
        words += [f"plates {self.plates}"] if self.plates else []
        return ", ".join(words)


@dataclass
class Solved:
    """An answer, what it took, and the condensed problem that gave it.

    built: the factored model, for fields; None where it has been dropped for its memory.
    """

    design: Design
    scene: Scene
    model: Model
    mesh: Mesh
    zone: Zone
    built: FiniteElementModel | None
    problem: ContactProblem
    readings: Readings
    steps: list[Step]
    dofs: int
    contact_nodes: int
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def total(self) -> float:
        """Seconds from the design to the last increment."""
        return sum(self.seconds.values())

    def along(self, scene: Scene) -> Readings:
        """The readings over another path of the same object, on the same condensed model.

        Raises SolverError where the path has no answer or leaves the candidate zone.
        """
        return readings_of(_follow(self.design, scene, self.problem), self.design.gages.face)


def design_for(design: Design, model: Model) -> Design:
    """The design with the keys of ``[mesh]`` and ``plates.model`` that the model asks for."""
    values: dict[str, object] = {}
    if model.dimension == "3-D":
        for name in ("contact_size_mm", "plate_size_mm", "far_size_mm"):
            values[f"mesh.{name}"] = max(getattr(model.sizes, name), 0.01)
        values["mesh.layers"] = model.layers
    if model.mesher is not None and model.mesher != design.mesh.mesher:
        values |= {"mesh.mesher": model.mesher}
    if model.plates is not None and design.plates.number:
        values |= {"plates.model": model.plates}
    if model.element is not None:
        values |= {"mesh.element": model.element}
    return with_values(design, values)


def solve(design: Design, scene: Scene, model: Model, zone: Zone | None = None) -> Solved:
    """Mesh, condense, follow the scene's path. Raises FingerDesignError where a stage fails.

    zone: of contact candidates, where more than the scene's own path is to be followed.
    """
    case = Case(design, scene, fields=False, grips=False)
    clock = Clock()

    def work(zone: Zone) -> Solved:
        own = design_for(design, model)
        with clock.stage("mesh"):
            mesh = _mesh(own, model, zone, case.symmetric)
        start = time.perf_counter()
        built = condense(own, mesh, zone, scene)
        assembled, total = built.timings["assemble"], time.perf_counter() - start
        clock.add({"assemble": assembled, "condense": total - assembled})
        with clock.stage("increments"):
            problem = problem_at_touch(built.reduced, scene.object, own.body)
            steps = _follow(own, scene, problem)
        return Solved(
            design=own,
            scene=scene,
            model=model,
            mesh=mesh,
            zone=zone,
            built=built,
            problem=problem,
            readings=readings_of(steps, own.gages.face),
            steps=steps,
            dofs=built.dofs,
            contact_nodes=built.reduced.nodes,
            seconds=clock.seconds,
        )

    return in_wide_zone(design, zone_of(case, scene) if zone is None else zone, work)


class InTurn:
    """Solves models of one finger in one scene, each in the candidate zone that the last needed.

    What the contact outgrew once, it would outgrow in every model: widening means meshing again.
    """

    def __init__(self, zone: Zone | None = None) -> None:
        self.zone = zone

    def __call__(self, design: Design, scene: Scene, model: Model) -> Solved:
        """Solve as :func:`solve`."""
        solved = solve(design, scene, model, self.zone)
        self.zone = solved.zone
        return solved


def _mesh(design: Design, model: Model, zone: Zone, symmetric: bool) -> Mesh:
    if model.dimension == "plane strain":
        return mesh_section(design, zone.half_width, model.sizes)
    if mesher_name(design) == "sweep":
        return extrude(design, zone, symmetric, model.sizes)
    return make_mesh(design, "3d", zone, symmetric)


def _follow(design: Design, scene: Scene, problem: ContactProblem) -> list[Step]:
    with one_thread():
        return follow_path(problem, scene, design)
