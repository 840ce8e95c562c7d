"""The cases whose answers two other codes agree on, solved by the pipeline's own stages."""

from dataclasses import dataclass

from fingerdesign.checks.load import parse_design
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.design.io import parse_scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import shipped_text
from fingerdesign.layout.bodies import crest_height
from fingerdesign.shapes.objects import Plane

HOMOGENEOUS = """
design.name = "two-codes"
body.depth_mm = {depth}
plates.count = 0
materials.silicone.poissons_ratio = 0.3
mesh.mesher = "{mesher}"
"""
ONE_PLATE = """
design.name = "one-plate"
body.depth_mm = 1.0
plates.placement = [[0.0, 10.5, 45.0]]
gages.length_mm = {gage}
"""


@dataclass(frozen=True)
class Solved:
    """A design taken through the reference path."""

    problem: ContactProblem
    steps: list[Step]
    dofs: int


def solve_reference(design: Design, fidelity: str, friction: float = 0.5) -> Solved:
    """Mesh, condense and load a design along the shipped sixteen increments."""
    from fingerdesign.analysis.stages import condense, make_mesh
    from fingerdesign.layout.zone import candidate_zone, greatest_approach

    scene = parse_scene(shipped_text("reference_plane_strain", "scene"))
    if fidelity != "plane-strain":
        scene = scene.model_copy(update={"readout": type(scene.readout)()})
    zone = candidate_zone(design, scene.object, greatest_approach(design, scene))
    mesh = make_mesh(design, fidelity, zone)
    model = condense(design, mesh, zone, scene).reduced
    problem = contact_problem(model, Plane(crest_height(design.body)), friction)
    steps = list(follow(problem, [Motion(*row) for row in scene.path.rows]))
    return Solved(problem, steps, mesh.points.size)


def solve_one_plate(gage_length: float = 0.05) -> Solved:
    """The one-plate case, its gage short enough to read the strain at the centre."""
    design = parse_design(ONE_PLATE.format(gage=gage_length))
    return solve_reference(design, "plane-strain")
