"""Errors of meshes against fine ones, estimated and true: the count for the docs.

    python -m tests.support.mesh_errors         # plane strain, fourteen fingers and scenes
    python -m tests.support.mesh_errors others  # those that the orders were not chosen by
    python -m tests.support.mesh_errors 3d      # swept fingers, minutes
    python -m tests.support.mesh_errors tetwild # the same fingers by fTetWild, more minutes

Columns: distance to the second mesh's answer, estimated error, true error, their ratio. An estimate
counts as right within a factor of two, or where both are under a fifth of what the default mesh is
made for (``GOAL``).
"""

import sys
import time
from collections.abc import Iterator
from dataclasses import asdict

from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.fidelity.readings import Readings, readings_of
from fingerdesign.analysis.mesh_error import (
    AGAINST_TETRAHEDRA,
    COARSER,
    ORDERS,
    estimate,
    family_mesh,
)
from fingerdesign.analysis.path import follow_path, problem_at_touch
from fingerdesign.analysis.path_error import distances
from fingerdesign.analysis.stages import condense, in_wide_zone, zone_of
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.scene import Scene
from fingerdesign.design.shipped import load_scene
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.make import mesh_finger
from fingerdesign.mesh.types import Mesh
from fingerdesign.runtime.threads import one_thread

GOAL = {"normal_force": 0.003, "tangential_force": 0.003, "stick_ratio": 0.01, "gages": 0.01}
FINE = {"plane-strain": 0.4, "3d": 0.7}  # Sizes of the fine mesh over the default's.
PLANE_STRAIN = (
    *((name, "") for name in ("maeno2000", "tees", "sensitive", "fine_tees", "narrow", "boned")),
    *((name, "") for name in ("homogeneous", "wide", "block")),
    *((name, scene) for name in ("maeno2000", "sensitive") for scene in ("pull", "slope")),
    ("tees", "pull"),
)
OTHERS = (  # that the orders were not chosen by
    ("both_ways", ""),
    ("fine_tees", "slope"),
    ("narrow", "slope"),
    ("boned", "slope"),
    ("wide", "pull"),
    ("block", "pull"),
)
SPACE = (("maeno2000", ""), ("tees", ""), ("sensitive", ""), ("homogeneous", ""))


def answer(case: Case, scene: Scene, zone: Zone, mesh: Mesh) -> tuple[Readings, float]:
    """Readings of the scene's path on a mesh, and the CPU seconds from the mesh on."""
    start = time.process_time()
    model = condense(case.design, mesh, zone, scene).reduced
    problem = problem_at_touch(model, scene.object, case.design.body)
    with one_thread():
        steps = follow_path(problem, scene, case.design)
    return readings_of(steps, case.design.gages.face), time.process_time() - start


def errors(name: str, scene_name: str, kind: str) -> tuple[float, ...]:
    """Print a finger's errors; the estimates over the true errors, 1 where both are small."""
    fidelity = "plane-strain" if kind == "plane-strain" else "3d"
    design = load_design(name)
    flat = fidelity == "plane-strain"
    swept = design if flat else with_values(design, {"mesh.mesher": "sweep"})
    scene = load_scene(scene_name) if scene_name else fundamental_scene(design)
    case = Case(swept, scene, fidelity, fields=False, grips=False)

    def work(zone: Zone) -> tuple[float, ...]:
        truth, _ = answer(case, scene, zone, family_mesh(case, zone, FINE[fidelity]))
        own, coarser = family_mesh(case, zone, 1.0), COARSER[fidelity]
        orders: dict[str, float] | None = ORDERS[fidelity]
        if kind == "tetwild":
            own, coarser, orders = (
                mesh_finger(design, zone, case.symmetric),
                AGAINST_TETRAHEDRA,
                None,
            )
        main, took = answer(case, scene, zone, own)
        second, less = answer(case, scene, zone, family_mesh(case, zone, coarser))
        print(f"{name}, {scene_name or 'fundamental'}: {took:.2f} s, second {less:.2f} s")
        apart, true = distances(second, main), distances(main, truth)
        return tuple(_ratios(apart, asdict(estimate(apart, coarser, orders)), true))

    return in_wide_zone(design, zone_of(case, scene), work)


def _ratios(
    apart: dict[str, float], estimated: dict[str, float], true: dict[str, float]
) -> Iterator[float]:
    for key, goal in GOAL.items():
        small = max(estimated[key], true[key]) < 0.2 * goal
        ratio = 1.0 if small else estimated[key] / max(true[key], 1e-12)
        numbers = f"{apart[key]:9.5f} {estimated[key]:9.5f} {true[key]:9.5f} {ratio:6.2f}"
        print(f"    {key:17s} {numbers}", flush=True)
        yield ratio


if __name__ == "__main__":
    kind = sys.argv[1] if len(sys.argv) > 1 else "plane-strain"
    cases = {"plane-strain": PLANE_STRAIN, "others": OTHERS}.get(kind, SPACE)
    kind = "plane-strain" if kind == "others" else kind
    found = [ratio for each in cases for ratio in errors(*each, kind)]
    right = sum(0.5 <= each <= 2.0 for each in found)
    print(f"within a factor of two: {right} of {len(found)}")
