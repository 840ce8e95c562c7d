"""One timed case in a process of its own.

A new process makes "cold" mean something, and its peak memory is that of the case alone. Before the
clock starts every module is imported and the mesher's process has made one small mesh.
"""

import resource
import time
from dataclasses import replace
from typing import Any

from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.path import problem_at_touch
from fingerdesign.analysis.stages import condense, make_mesh, zone_of
from fingerdesign.checks.load import load_design, parse_design, with_values
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.controllers.flow_chart import PaperController
from fingerdesign.control.episode import run_episode
from fingerdesign.control.plants.plant import CondensedPlant, Plant
from fingerdesign.design.io import parse_scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import shipped_text
from fingerdesign.fem.model import build_model
from fingerdesign.layout.zone import candidate_zone, greatest_approach
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.runtime.threads import one_thread

# The body of the two-code table, at the Poisson's ratio of a rubber.
HOMOGENEOUS = """
design.name = "speed"
plates.count = 0
body.depth_mm = {depth}
materials.silicone.poissons_ratio = 0.49
[mesh]
mesher = "sweep"
contact_size_mm = {contact}
far_size_mm = {far}
layers = {layers}
[mesh.section]
contact_size_mm = {contact}
far_size_mm = {far}
"""
STEPS = 200  # of a grip
GRIP_SPACE = {"mesh.mesher": "sweep", "mesh.contact_size_mm": 0.4, "mesh.layers": 6}


def timed_path(case: dict[str, Any]) -> dict[str, Any]:
    """Model and the sixteen shipped increments, ``runs`` times over; the first run is the cold one.

    case: fidelity ("plane-strain" or "3d"), contact, far (mm), layers, runs.
    """
    depth = 1.0 if case["fidelity"] == "plane-strain" else 10.0
    sizes = {key: case[key] for key in ("contact", "far", "layers")}
    design = parse_design(HOMOGENEOUS.format(depth=depth, **sizes))
    scene = parse_scene(shipped_text("reference_plane_strain", "scene"))
    scene = scene.model_copy(update={"readout": type(scene.readout)()})
    tiny = HOMOGENEOUS.format(depth=1.0, contact=1.0, far=3.0, layers=1)
    mesh_section(parse_design(tiny), 2.0)
    base = _memory_MB()
    runs = [_one_path(case["fidelity"], design, scene) for _ in range(case["runs"])]
    return {"runs": runs, "memory_MB": _memory_MB(), "base_MB": base}


def _one_path(fidelity: str, design: Design, scene: Any) -> dict[str, Any]:
    start = time.perf_counter()
    zone = candidate_zone(design, scene.object, greatest_approach(design, scene))
    mesh = make_mesh(design, fidelity, zone)
    meshed = time.perf_counter()
    # Condensed, not read from the store: it is timed.
    model = build_model(design, mesh, zone.half_width, None, zone.half_depth)
    problem = problem_at_touch(model.reduced, scene.object, design.body)
    modelled = time.perf_counter()
    each = []
    with one_thread():
        before = modelled
        for _step in follow(problem, [Motion(*row) for row in scene.path.rows]):
            now = time.perf_counter()
            each.append(now - before)
            before = now
    return {
        "dofs": model.dofs,
        "contact_nodes": model.reduced.nodes,
        "mesh_s": meshed - start,
        "assemble_s": model.timings["assemble"],
        "condense_s": model.timings["condense"],
        "model_s": modelled - start,
        "increments_s": each,
        "total_s": time.perf_counter() - start,
    }


def timed_grip(case: dict[str, Any]) -> dict[str, Any]:
    """A lift of the reference finger in 200 moves or more: its own grip, with finer steps.

    case: fidelity, runs, and values (dotted design keys). Model and calibration are not counted.
    """
    design = with_values(load_design("maeno2000"), case["values"])
    problem, contact = grip_problem(design, case["fidelity"])
    moves, _ = one_grip(design, problem, 1.0)
    share = moves / (1.1 * STEPS)
    runs = []
    for _ in range(case["runs"]):
        moves, seconds = one_grip(design, problem, share)
        runs.append({"moves": moves, "seconds": seconds, "per_200": seconds / moves * STEPS})
    return {"runs": runs, "memory_MB": _memory_MB(), **contact}


def grip_problem(design: Design, fidelity: str) -> tuple[Any, dict[str, Any]]:
    scene = fundamental_scene()
    # Facets alike all over: as many nodes as the bounds on a step's time hold for.
    zone = replace(zone_of(Case(design, None, fidelity), scene), inner=None)
    model = condense(design, make_mesh(design, fidelity, zone), zone, scene)
    problem = problem_at_touch(model.reduced, scene.object, design.body)
    return problem, {"dofs": model.dofs, "contact_nodes": model.reduced.nodes}


def one_grip(
    design: Design, problem: Any, share: float, plant: Plant | None = None
) -> tuple[int, float]:
    """Moves and seconds of one lift (of ``plant``) with steps of ``share`` of the design's."""
    values = {
        f"grip.{key}": share * getattr(design.grip, key)
        for key in ("approach_step_mm", "shear_step_mm")
    }
    grip = with_values(design, values | {"grip.max_steps": 5 * STEPS}).grip
    bounds = Bounds.of(grip)
    face, friction = design.gages.face, grip.friction_coefficients[0]
    bench = problem.with_friction(grip.bench_friction_coefficient)
    own = problem.with_friction(friction)
    with one_thread():
        calibration = calibrate(lambda: CondensedPlant(bench, face), problem.model.gage_x, bounds)
        start = time.perf_counter()
        episode = run_episode(
            plant or CondensedPlant(own, face),
            PaperController(grip),
            calibration,
            bounds,
            friction,
            grip.heaviest_g,
        )
        seconds = time.perf_counter() - start
    return len(episode.trace.approach), seconds


def _memory_MB() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
