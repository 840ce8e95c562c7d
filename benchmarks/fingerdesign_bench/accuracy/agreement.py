"""``fingerdesign bench agreement``: one finger, meshed in several ways, gives the same answer.

The reference finger through the fundamental case: extruded and by fTetWild (twice), its plates as
solids and as sheets. Forces are compared relative to the largest of the path, gage readings to the
largest of their increment. Also what the default meshes cost.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Check

DESIGN = "maeno2000"
MOST_DOFS = 250_000  # displacements of the half model
# Seconds that issue 4 gives the default meshes; the solid's CAD and checks counted.
SECONDS = {"tetwild solid": 60.0, "tetwild sheet": 20.0, "extrude solid": 1.0}


@dataclass(frozen=True)
class Answer:
    """One way of meshing: what it cost and what it gave, an increment a row."""

    seconds: float
    dofs: int
    normal: Array
    tangential: Array
    gages: Array  # (increments, plates), microstrain

    def forces_off(self, other: Answer) -> tuple[float, float]:
        """Greatest differences of F_n and F_t, relative to the other's largest."""
        pairs = ((self.normal, other.normal), (self.tangential, other.tangential))
        first, second = (float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs)
        return first, second

    def gages_off(self, other: Answer) -> float:
        """Greatest difference of a reading, relative to the other's largest of its increment."""
        largest = np.abs(other.gages).max(axis=1, keepdims=True)
        return float((np.abs(self.gages - other.gages) / largest).max())


def answer(design: Design) -> Answer:
    """Mesh without the cache, condense, and follow the fundamental case in 3-D."""
    from fingerdesign.analysis.case import Case, fundamental_scene
    from fingerdesign.analysis.path import follow_path, object_at_touch
    from fingerdesign.analysis.stages import condense, one_thread, zone_of
    from fingerdesign.contact.problem import contact_problem
    from fingerdesign.mesh.section.extrude import extrude
    from fingerdesign.mesh.tetra.tetwild import tetrahedralise

    scene = fundamental_scene()
    zone = zone_of(Case(design), scene)
    start = time.perf_counter()
    if design.mesh.mesher == "extrude":
        mesh = extrude(design, zone)
    else:
        mesh = tetrahedralise(design, zone, use_cache=False)
    seconds = time.perf_counter() - start
    model = condense(design, mesh, zone, scene)
    rigid = object_at_touch(scene.object, design.body)
    problem = contact_problem(model.reduced, rigid, scene.object.friction_coefficient)
    with one_thread():
        steps = follow_path(problem, scene, design)
    both = np.array([step.measures.gages.reshape(-1, 2).mean(axis=1) for step in steps])
    return Answer(
        seconds=seconds,
        dofs=int(mesh.points.size),
        normal=np.array([step.measures.normal_force for step in steps]),
        tangential=np.array([step.measures.tangential_force for step in steps]),
        gages=1e6 * both,
    )


def agreement_checks(report: Report = lambda message: None) -> list[Check]:
    """The ways against each other, and what their meshes cost."""
    from fingerdesign.checks.load import with_values
    from fingerdesign.checks.starter import find_design
    from fingerdesign.mesh.section.netgen import start_mesher

    start_mesher()
    design = find_design(DESIGN)
    found: dict[str, Answer] = {}
    for mesher in ("extrude", "tetwild"):
        for model in ("solid", "sheet"):
            report(f"{mesher}, plates as {model}s")
            values = {"mesh.mesher": mesher, "plates.model": model}
            found[f"{mesher} {model}"] = answer(with_values(design, values))
    report("tetwild, plates as solids, again")
    again = answer(with_values(design, {"mesh.mesher": "tetwild"}))
    solid, sheet = found["tetwild solid"], found["tetwild sheet"]
    normal, tangential = solid.forces_off(found["extrude solid"])
    checks = [
        Check("fTetWild against extruded: F_n", 0.005, normal),
        Check("fTetWild against extruded: F_t", 0.005, tangential),
        Check("fTetWild against extruded: gages", 0.02, solid.gages_off(found["extrude solid"])),
        Check("sheets against solids, fTetWild: gages", 0.03, sheet.gages_off(solid)),
        Check(
            "sheets against solids, extruded: gages",
            0.03,
            found["extrude sheet"].gages_off(found["extrude solid"]),
        ),
        Check("fTetWild again: F_n", 0.003, again.forces_off(solid)[0]),
        Check("fTetWild again: gages", 0.02, again.gages_off(solid)),
    ]
    for name, seconds in SECONDS.items():
        checks.append(Check(f"default mesh, {name}: time", seconds, found[name].seconds, "s"))
        checks.append(Check(f"default mesh, {name}: P2 dofs", MOST_DOFS, found[name].dofs))
    return checks
