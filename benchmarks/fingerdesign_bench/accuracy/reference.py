"""The cases whose answers two other codes agree on, solved by the pipeline's own stages."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fingerdesign.checks.load import parse_design
from fingerdesign.contact.measures import limits
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.design.io import parse_scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import shipped_text
from fingerdesign.layout.bodies import crest_height
from fingerdesign.shapes.objects import Plane
from fingerdesign_bench.check import Check, two_codes

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
_GAMMA_POINTS = ("gamma_x-4", "gamma_x-2", "gamma_x0", "gamma_x2", "gamma_x4")


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


def plane_strain_checks() -> list[Check]:
    """F_n, F_t, shear strain, peak pressure and limits against the two-code table."""
    table = two_codes()
    solved = solve_reference(
        parse_design(HOMOGENEOUS.format(depth=1.0, mesher="tetwild")), "plane-strain"
    )
    rows = table["plane_strain"]
    measures = [step.measures for step in solved.steps]
    gamma = np.array([[row[name] for name in _GAMMA_POINTS] for row in rows])
    return [
        Check("plane strain: F_n, relative", 3e-3, _relative(measures, rows, "Fn")),
        Check("plane strain: F_t, relative", 3e-3, _relative(measures, rows, "Ft")),
        Check(
            "plane strain: shear strain at y = 10.5",
            3e-4,
            float(
                max(np.abs(m.points[:, 3] - g).max() for m, g in zip(measures, gamma, strict=True))
            ),
        ),
        Check(
            "plane strain: peak pressure, relative",
            1.5e-2,
            max(abs(m.peak_pressure / r["pmax"] - 1) for m, r in zip(measures, rows, strict=True)),
        ),
        Check(
            "plane strain: contact limits",
            0.15,
            _limit_error(solved, table["contact_limits_mm"], 0),
            "mm",
        ),
        Check(
            "plane strain: stick limits",
            0.15,
            _limit_error(solved, table["stick_limits_mm"], 1),
            "mm",
        ),
    ]


def three_d_checks(mesher: str) -> list[Check]:
    """F_n and F_t of the free-ended finger of depth 10 by the given mesher."""
    design = parse_design(HOMOGENEOUS.format(depth=10.0, mesher=mesher))
    solved = solve_reference(design, "3d")
    # Increments 4, 8, 12 and 16, the row of the published comparison. At the first shear, left
    # out here, F_t is 0.8 N and a tetwild mesh is off by up to 0.6 % (0.2 % of it the codes').
    rows = two_codes()["three_d_depth_10"][3::4]
    measures = [step.measures for step in solved.steps][3::4]
    return [
        Check(f"3-D {mesher}: F_n, relative", 5e-3, _relative(measures, rows, "Fn")),
        Check(f"3-D {mesher}: F_t, relative", 5e-3, _relative(measures, rows, "Ft")),
    ]


def one_plate_checks() -> list[Check]:
    """Strain at the plate's centre: mid-fibre and both faces, by a gage of 0.05 mm."""
    solved = solve_one_plate()
    worst: dict[str, float] = dict.fromkeys(("F_n", "mid-fibre", "upper face", "lower face"), 0.0)
    for row in two_codes()["one_plate"]:
        measures = solved.steps[row["increment"] - 1].measures
        upper, lower = measures.gages[0] * 1e6
        got = {
            "F_n": measures.normal_force / row["Fn"],
            "mid-fibre": 0.5 * (upper + lower) / row["mid"],
            "upper face": upper / row["upper"],
            "lower face": lower / row["lower"],
        }
        worst = {name: max(worst[name], abs(ratio - 1.0)) for name, ratio in got.items()}
    return [
        Check(f"one plate: {name}, relative", 3e-3 if name == "F_n" else 2e-2, error)
        for name, error in worst.items()
    ]


def solve_one_plate(gage_length: float = 0.05) -> Solved:
    """The one-plate case, its gage short enough to read the strain at the centre."""
    design = parse_design(ONE_PLATE.format(gage=gage_length))
    return solve_reference(design, "plane-strain")


def _relative(measures: list[Any], rows: list[dict[str, float]], key: str) -> float:
    """Worst relative error over the increments whose reference is not zero."""
    name = {"Fn": "normal_force", "Ft": "tangential_force"}[key]
    return max(
        abs(float(getattr(m, name)) / row[key] - 1.0)
        for m, row in zip(measures, rows, strict=True)
        if row[key]
    )


def _limit_error(solved: Solved, table: dict[str, list[float]], which: int) -> float:
    worst = 0.0
    for number, wanted in table.items():
        got = limits(solved.problem, solved.steps[int(number) - 1].increment)[which]
        worst = max(worst, float(np.abs(got - np.array(wanted)).max()))
    return worst
