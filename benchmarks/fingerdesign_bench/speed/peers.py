"""``fingerdesign bench peers``: Siconos and GetFEM on our problems, next to ours in the same run.

Condensed: Siconos gets our compliance, the offsets and the last forces of each increment, and must
give our nodal forces to a millionth. Full: GetFEM gets our mesh. Each runs on one thread under the
system's own Python (peers_worker.py), in turn with ours; times are processor time, the least of the
repeats, so a busy machine matters little.
"""

import json
import os
import subprocess
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.path import problem_at_touch
from fingerdesign.analysis.stages import make_mesh, zone_of
from fingerdesign.arrays import Array, IntArray
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.contact.increment import Increment, Workspace, solve_increment
from fingerdesign.contact.laws import status_of
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.signals import Sample
from fingerdesign.design.io import parse_scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import shipped_text
from fingerdesign.errors import SolverError
from fingerdesign.fem.model import build_model
from fingerdesign.fem.readout import gage_rows
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mesh.types import Mesh
from fingerdesign.runtime.progress import Report
from fingerdesign.runtime.threads import one_thread
from fingerdesign_bench.check import Shown
from fingerdesign_bench.machine import machine
from fingerdesign_bench.speed import peers_worker
from fingerdesign_bench.speed.speed_worker import GRIP_SPACE, STEPS, grip_problem, one_grip

PYTHON = Path("/usr/bin/python3")
PACKAGES = {"siconos": "python3-siconos", "getfem": "python3-getfem"}
_TIME_LIMIT_S = 3600.0  # for one call of a peer
_GRIP_EVERY = 13  # of the steps of a grip: about twenty
_LONG_PATH = 200  # increments
# Quadratic displacements without pressures, as GetFEM's; meshes that it takes seconds a row for.
MESHES: dict[str, dict[str, Any]] = {
    "plane-strain": {"mesh.section.contact_size_mm": 0.2, "mesh.section.plate_size_mm": 0.3},
    "3d": {
        "mesh.mesher": "sweep",
        "mesh.layers": 2,
        "mesh.section.contact_size_mm": 0.5,
        "mesh.section.plate_size_mm": 1.0,
        "mesh.section.plate_end_size_mm": 0.9,
        "mesh.section.far_size_mm": 4.0,
        "mesh.section.gradation": 0.8,
    },
}
# Where the contact's own two laws come together, so that the gages can be compared.
_FINER = {"mesh.layers": 3, "mesh.contact_size_mm": 0.3}
_TITLES = {
    "condensed": "Condensed: Siconos and ours, an increment",
    "full": "Full: GetFEM and ours, on one mesh",
}
Row = dict[str, Any]  # heading -> text, number, or None where nothing converged


class _Recorded(CondensedPlant):
    """A plant that records its motions."""

    def __init__(self, problem: ContactProblem, face: str) -> None:
        super().__init__(problem, face)
        self.motions: list[Motion] = []

    def move(self, dx: float, dy: float) -> Sample:
        sample = super().move(dx, dy)
        self.motions.append(self._history.state.motion)
        return sample


def installed() -> dict[str, str]:
    """Versions of the peers that the system's own Python can import; none without its numpy."""
    if not PYTHON.exists():
        return {}
    numpy = subprocess.run([PYTHON, "-c", "import numpy"], check=False, capture_output=True)
    return {} if numpy.returncode else dict(work("probe", {}))


def peers(_folder: Path, report: Report, quick: bool) -> Shown:
    """Compare with the peers that are installed; fails where none is."""
    found = installed()
    absent = [
        f"{name} is not installed for {PYTHON} (Debian: {package}): left out"
        for name, package in PACKAGES.items()
        if name not in found
    ]
    if not found:
        return Shown(notes=absent, listed={"missing": absent}, fails=True)
    begun = machine()
    rows = dict(zip(_TITLES, measure_peers(found, report, quick), strict=True))
    tables = []
    for name, own in rows.items():
        headings = list(dict.fromkeys(key for row in own for key in row))
        cells = [[cell(row.get(heading)) for heading in headings] for row in own]
        tables.append((_TITLES[name], headings, cells))
    record = {"installed": found, **rows}
    return Shown(machine=begun, record=record, tables=tables, notes=absent, listed=record)


def measure_peers(found: dict[str, str], report: Report, quick: bool) -> tuple[list[Row], ...]:
    """Rows of the condensed and of the full problem, by those ``found`` by installed().

    quick: plane strain alone, fewer repeats. Raises SolverError where a peer's process fails.
    """
    condensed, full = [], []
    for fidelity in ("plane-strain",) if quick else ("plane-strain", "3d"):
        if "siconos" in found:
            problem, own, grip = recorded_grip(fidelity)
            scene = parse_scene(shipped_text("reference_plane_strain", "scene"))
            rows = [Motion(*row) for row in scene.path.rows]
            for name, each, motions, every in (
                ("16 increments", problem, rows, 1),
                ("grip", own, grip, _GRIP_EVERY),
            ):
                path = f"{fidelity}, {problem.shape[0]} nodes, {name}"
                report(f"condensed, {path}")
                condensed += _condensed(path, each, motions, every)
        if "getfem" in found:
            report(f"full, {fidelity}")
            full.append(_full(fidelity, 1 if quick else 2))
    if "getfem" in found and not quick:
        for plates in (1, 15):
            report(f"full, 3d, finer, {plates} plates")
            full.append(_full("3d", 1, {"plates.count": plates, **_FINER}))
    return condensed, full


def recorded_grip(fidelity: str) -> tuple[ContactProblem, ContactProblem, list[Motion]]:
    """maeno2000 facing the fundamental scene's plane, at that scene's friction and at that of a
    lift, and the motions of the lift."""
    values = GRIP_SPACE if fidelity == "3d" else {}
    design = with_values(load_design("maeno2000"), values)
    problem, _ = grip_problem(design, fidelity)
    own = problem.with_friction(design.grip.friction_coefficients[0])
    moves, _ = one_grip(design, problem, 1.0)
    plant = _Recorded(own, design.gages.face)
    one_grip(design, problem, moves / (1.1 * STEPS), plant)
    return problem, own, plant.motions


def work(task: str, given: dict[str, Any]) -> dict[str, Any]:
    """The answer of peers_worker under the system's Python, on one thread. Raises SolverError."""
    with tempfile.TemporaryDirectory(prefix="fingerdesign-bench-") as folder:
        source, target = Path(folder, "in.npz"), Path(folder, "out.npz")
        np.savez(source, **given)
        threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
        own = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        try:
            done = subprocess.run(
                [PYTHON, peers_worker.__file__, task, source, target],
                env=own | threads,
                cwd=folder,
                capture_output=True,
                text=True,
                timeout=_TIME_LIMIT_S,
                check=False,
            )
        except subprocess.TimeoutExpired as error:
            raise SolverError(f"{task}: not done in {_TIME_LIMIT_S:g} s") from error
        if done.returncode != 0 or not target.exists():
            end = (done.stderr or done.stdout).strip()[-300:]
            raise SolverError(f"{task} under {PYTHON} ended with {done.returncode}: {end}")
        if task == "probe":
            return dict(json.loads(target.read_text("utf-8")))
        with np.load(target) as answer:
            return dict(answer)


def _condensed(
    path: str, problem: ContactProblem, motions: Sequence[Motion], every: int
) -> list[Row]:
    """A row a method of Siconos, over every so many of the motions."""
    chosen = range(every - 1, len(motions), every)
    own, ours = _ours(problem, motions, chosen)
    given = ours | {
        "compliance": problem.compliance,
        "friction": problem.friction_coefficient,
        "scale": problem.typical_compliance,
    }
    found = work("condensed", given)  # the first call also looks for tolerances
    own = np.minimum(own, _ours(problem, motions, chosen)[0])
    again = work("condensed", given | {"tolerance": found["tolerance"]})
    found["seconds"] = np.minimum(found["seconds"], again["seconds"])
    own = np.minimum(own, _ours(problem, motions, chosen)[0])
    each = [dict(zip(found, values, strict=True)) for values in zip(*found.values(), strict=True)]
    return [
        {"problem": path, **_compared(problem, ours, own, method)}
        if method["converged"].any()
        else {"problem": path, "method": str(method["names"]), "failed": "all"}
        for method in each
    ]


def _ours(
    problem: ContactProblem, motions: Sequence[Motion], chosen: range
) -> tuple[Array, dict[str, Array]]:
    """Seconds (2, k) of the ``chosen`` increments, from zero forces and along the path; their
    offsets, last forces and answers (k, m, dim)."""
    state, workspace = ContactState.untouched(problem), Workspace()
    seconds, rows = [], []
    with one_thread():
        for k, motion in enumerate(motions):
            if k in chosen:
                bare = replace(state, multiplier=np.zeros_like(state.multiplier))
                cold, _ = _timed(problem, bare, motion, Workspace(follows=False))
            warm, increment = _timed(problem, state, motion, workspace)
            if k in chosen:
                seconds.append((cold, warm))
                offset = problem.offset(motion, state.slip)
                rows.append((offset, state.multiplier, increment.multiplier))
            state = increment.state
    arrays = np.array(rows).swapaxes(0, 1)
    return np.array(seconds).T, dict(zip(("offset", "start", "reference"), arrays, strict=True))


def _timed(
    problem: ContactProblem, state: ContactState, motion: Motion, workspace: Workspace
) -> tuple[float, Increment]:
    start = time.process_time()
    increment = solve_increment(problem, state, motion, workspace)
    return time.process_time() - start, increment


def _compared(
    problem: ContactProblem, ours: dict[str, Array], own: Array, found: dict[str, Any]
) -> Row:
    """Mean times, theirs and ours from zero and along the path, over the increments solved.

    total: largest difference of the forces' sum over its length; statuses: nodes open, sticking or
    sliding other than ours, of all increments'.
    """
    good = found["converged"]
    ms, cold, warm = (1e3 * float(each[good].mean()) for each in (found["seconds"], *own))
    total, statuses = 0.0, 0
    for k in np.flatnonzero(good):
        pair = ours["reference"][k], found["forces"][k]
        before, after = (problem.to_global(forces).sum(axis=0) for forces in pair)
        total = max(total, float(np.linalg.norm(after - before) / np.linalg.norm(before)))
        first, second = (_status(problem, ours["offset"][k], forces) for forces in pair)
        statuses += int((first != second).sum())
    return {
        "method": str(found["names"]),
        "ms": ms,
        "ours cold": cold,
        "ratio": ms / cold,
        "ours warm": warm,
        "ratio to warm": ms / warm,
        "failed": f"{len(good) - int(good.sum())} of {len(good)}",
        "tolerance": "{1:.0e} to {0:.0e}".format(*np.sort(found["tolerance"][good])[[0, -1]]),
        "total": total,
        "statuses": statuses,
    }


def _status(problem: ContactProblem, offset: Array, forces: Array) -> IntArray:
    motion = (problem.compliance @ forces.reshape(-1)).reshape(offset.shape) + offset
    return status_of(forces, motion, problem.self_compliance, problem.friction)


def _full(fidelity: str, repeats: int, more: Mapping[str, object] | None = None) -> Row:
    """Ours from a mesh to the last row of the fundamental scene, and GetFEM on the same mesh.

    Set-up: to the condensed model, or to GetFEM's model; neither includes meshing. Gages, single
    ones and tees on both faces: the largest difference, of the path's largest reading (one plate's
    crosses zero); theirs are means of GetFEM's own displacement gradients over the rectangles.
    """
    scene = fundamental_scene()
    values = {"mesh.element": "P2", **MESHES[fidelity], **(more or {})}
    design = with_values(load_design("maeno2000"), values)
    zone = zone_of(Case(design, None, fidelity), scene)
    mesh = make_mesh(design, fidelity, zone)
    rows, friction = scene.path.rows, scene.object.friction_coefficient
    best = np.full((2, 1 + len(rows)), np.inf)  # seconds: theirs and ours, of set-up and each row
    for _ in range(repeats):
        with one_thread():
            times = [time.process_time()]
            model = build_model(design, mesh, zone.half_width, None, zone.half_depth)
            problem = problem_at_touch(model.reduced, scene.object, design.body)
            times.append(time.process_time())
            forces = []
            for step in follow(problem, [Motion(*row) for row in rows]):
                times.append(time.process_time())
                forces.append(step.increment.force)
        body = model.condensed.body
        given = {key: getattr(body, key) for key in ("fixed", "contact", "thickness")}
        given |= {"points": mesh.points, "cells": mesh.cells, "friction": friction}
        given |= {"young": body.youngs_modulus, "poisson": body.poissons_ratio}
        given |= {"crest": crest_height(design.body), "path": np.array(rows)[:, :2]}
        points, directions = _gage_points(design, mesh)
        given |= {"points_read": points.reshape(-1, mesh.dimension)}
        answer = work("full", given)
        theirs = [float(answer["setup"]), *answer["seconds"]]
        best = np.minimum(best, np.array([theirs, np.diff(times)]))
    totals = np.array(forces).sum(axis=1)
    errors = np.abs(answer["forces"] / totals - 1.0).max(axis=0)
    slopes = answer["gradients"].reshape(len(rows), *points.shape, mesh.dimension)
    strains = np.einsum("gda,rgqab,gdb->drg", directions, slopes, directions) / points.shape[1]
    fields = model.displacement_fields(np.array(forces)).reshape(len(rows), -1).T
    gages = []
    for weights in ((1.0, 0.0), (1.0, design.material_of("plates").poissons_ratio)):
        own = gage_rows(mesh, plate_frames(design), design.gages, weights) @ fields
        pair = np.stack([own.T, np.tensordot(weights[: len(strains)], strains, 1)])
        mine, other = pair.reshape(2, len(rows), -1, 2).mean(axis=3)
        gages.append(float(np.abs(other - mine).max() / np.abs(mine).max()))
    setup, increment = best[:, 0], best[:, 1:].mean(axis=1)
    long = setup + _LONG_PATH * increment
    size = f"{design.plates.number} plates, {model.dofs} dofs, {problem.shape[0]} nodes"
    return {
        "problem": f"{fidelity}, {size}",
        "set-up s": float(setup[0]),
        "ours s": float(setup[1]),
        "increment ms": 1e3 * float(increment[0]),
        "ours ms": 1e3 * float(increment[1]),
        "ratio": float(increment[0] / increment[1]),
        f"ratio, {_LONG_PATH} increments": float(long[0] / long[1]),
        "failed": f"{int((~answer['converged']).sum())} of {len(rows)}",
        "normal": float(errors[1]),
        "tangential": float(errors[0]),
        "gages": gages[0],
        "tees": gages[1],
    }


def _gage_points(design: Design, mesh: Mesh) -> tuple[Array, Array]:
    """Points (g, q, dim) spread over each gage's rectangle, a thousandth of the thickness inside
    its plate, and directions (g, 1 or 2, dim) along the plate and across; g: faces of plates. In a
    half model those at z < 0 are mirrored, which leaves both strains as they are."""
    gages, found, directions = design.gages, [], []
    spread: Array = np.arange(-29, 30, 2) / 60.0
    s, w = spread * gages.length_mm, spread * gages.width_mm
    for frame in plate_frames(design):
        for v in (0.499 * frame.thickness, -0.499 * frame.thickness):
            line, ways = frame.from_local(s, v), [frame.axis]
            if mesh.dimension == 3:
                across = frame.middle + gages.z_mm + w
                line = np.vstack([frame.to_space(line, each) for each in across])
                line[:, 2] = np.abs(line[:, 2]) if mesh.symmetric else line[:, 2]
                ways = [frame.direction(frame.axis), frame.to_space(np.zeros(2), 1.0)[0]]
            found.append(line)
            directions.append(ways)
    return np.array(found), np.array(directions)


def cell(value: float | str | None) -> str:
    """A value of a row in a table."""
    return value if isinstance(value, str) else "-" if value is None else f"{value:.3g}"
