"""Errors of paths against 256 increments a row, estimated and true: the count for the docs.

    python -m tests.support.path_errors      # plane strain, twelve fingers and scenes
    python -m tests.support.path_errors 3d   # three fingers in space: minutes of meshing

Columns: CPU time over that of one increment a row; true errors with one increment a row, with the
default; the estimate over the true error. An estimate counts as right within a factor of two, or
where both are under a fifth of what the default is made for (``GOAL``).
"""

import sys
import time
from collections.abc import Iterator
from dataclasses import asdict

from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.fidelity.readings import readings_of
from fingerdesign.analysis.path import problem_at_touch, targets
from fingerdesign.analysis.path_error import distances, path_error
from fingerdesign.analysis.stages import condense, in_wide_zone, make_mesh, zone_of
from fingerdesign.checks.load import load_design
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.design.scene import Scene
from fingerdesign.design.shipped import load_scene
from fingerdesign.layout.zone import Zone
from fingerdesign.runtime.threads import one_thread

GOAL = {"normal_force": 0.01, "tangential_force": 0.01, "stick_ratio": 0.01, "gages": 0.005}
FINE = 256  # 64 equal ones are off by a fifth of a per cent themselves, in F_t of a first row
PLANE_STRAIN = (
    *((name, "") for name in ("maeno2000", "tees", "sensitive", "fine_tees", "narrow", "boned")),
    *(("maeno2000", scene) for scene in ("pull", "slope")),
    *(("sensitive", scene) for scene in ("pull", "slope")),
    ("tees", "pull"),
    ("homogeneous", ""),
)
SPACE = (("maeno2000", ""), ("tees", ""), ("sensitive", ""))


def followed(
    problem: ContactProblem, scene: Scene, substeps: int | None
) -> tuple[list[Step], float]:
    """Steps of the scene's path, and the CPU seconds that they took."""
    start = time.process_time()
    with one_thread():
        steps = list(follow(problem, targets(scene.path), substeps))
    return steps, time.process_time() - start


def condensed(name: str, scene: Scene, fidelity: str) -> ContactProblem:
    """A shipped finger facing the scene's object, on its default mesh."""
    design = load_design(name)
    case = Case(design, scene, fidelity, fields=False, grips=False)

    def work(zone: Zone) -> ContactProblem:
        model = condense(design, make_mesh(design, fidelity, zone, case.symmetric), zone, scene)
        problem = problem_at_touch(model.reduced, scene.object, design.body)
        followed(problem, scene, 1)
        return problem

    return in_wide_zone(design, zone_of(case, scene), work)


def errors(name: str, scene_name: str, fidelity: str) -> tuple[float, ...]:
    """Print a finger's errors; the estimates over the true errors, 1 where both are small."""
    design = load_design(name)
    scene = load_scene(scene_name) if scene_name else fundamental_scene(design)
    problem, face = condensed(name, scene, fidelity), design.gages.face
    one, once = followed(problem, scene, 1)
    cut, seconds = followed(problem, scene, None)
    truth = readings_of(followed(problem, scene, FINE)[0], face)
    before, after = (distances(readings_of(each, face), truth) for each in (one, cut))
    found = path_error(problem, scene.path, face, cut)
    assert found is not None
    estimated = asdict(found)
    print(f"{name}, {scene_name or 'fundamental'}: x {seconds / once:.2f}")
    ratios = []
    for key, goal in GOAL.items():
        small = max(estimated[key], after[key]) < 0.2 * goal
        ratios.append(1.0 if small else estimated[key] / max(after[key], 1e-12))
        numbers = f"{before[key]:9.4f} {after[key]:9.4f} {estimated[key]:9.4f} {ratios[-1]:6.2f}"
        print(f"    {key:17s} {numbers}", flush=True)
    return tuple(ratios)


def ratios(fidelity: str) -> Iterator[float]:
    """The estimates over the true errors, of every finger, scene and quantity."""
    for name, scene in PLANE_STRAIN if fidelity == "plane-strain" else SPACE:
        yield from errors(name, scene, fidelity)


if __name__ == "__main__":
    found = list(ratios(sys.argv[1] if len(sys.argv) > 1 else "plane-strain"))
    right = sum(0.5 <= each <= 2.0 for each in found)
    print(f"within a factor of two: {right} of {len(found)}")
