"""A grip's increments followed and solved anew, in one run; and a grid of lifts."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.analysis.stages import one_thread
from fingerdesign.arrays import Array
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.checks.starter import shipped_path
from fingerdesign.contact.increment import Workspace, solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.signals import Sample
from fingerdesign.runtime.journal import Journal
from fingerdesign.runtime.machine import processor_seconds, usable_cores
from fingerdesign.trials.bench import FRICTIONS, MASSES_G, ControlGrid, GripBench
from fingerdesign.trials.run import KIND, run_batches
from fingerdesign_bench.check import Check
from fingerdesign_bench.speed.speed_worker import GRIP_SPACE, STEPS, grip_problem, one_grip

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

MEAN_MS = {"3d": 1.5, "plane-strain": 0.25}
WORST_MS = {"3d": 5.0, "plane-strain": 1.0}
LIFTS_S = 20.0  # for a hundred lifts of so many steps
SAME = 1e-6  # of the largest nodal force: each path goes on from its own increments


class _Recorded(CondensedPlant):
    """Keeps the motions that it was moved to."""

    def __init__(self, problem: ContactProblem, face: str) -> None:
        super().__init__(problem, face)
        self.motions: list[Motion] = []

    def move(self, dx: float, dy: float) -> Sample:
        sample = super().move(dx, dy)
        self.motions.append(self._history.state.motion)
        return sample


def step_checks(fidelities: Sequence[str] = ("3d", "plane-strain")) -> list[Check]:
    """Mean and worst milliseconds a step, how many times sooner, and the difference of forces."""
    checks = []
    for fidelity in fidelities:
        design, problem, motions = recorded_grip(fidelity)
        own = problem.with_friction(design.grip.friction_coefficients[0])
        anew, followed, difference = replayed(own, motions)
        where = f"{fidelity}, {own.shape[0]} contact nodes, {len(motions)} steps"
        ratio = anew.mean() / followed.mean()
        if fidelity == "3d":
            checks.append(lift_check(design, problem))
        checks += [
            Check(
                f"{where}: mean ms, {ratio:.1f} times sooner", MEAN_MS[fidelity], followed.mean()
            ),
            Check(f"{where}: worst ms", WORST_MS[fidelity], followed.max()),
            Check(f"{where}: difference of forces", SAME, difference),
        ]
    return checks


def recorded_grip(fidelity: str) -> tuple[Design, ContactProblem, list[Motion]]:
    """maeno2000, what it is facing the fundamental scene's plane, and the motions of a lift."""
    values = GRIP_SPACE if fidelity == "3d" else {}
    design = with_values(load_design(shipped_path("maeno2000")), values)
    problem, _ = grip_problem(design, fidelity)
    own = problem.with_friction(design.grip.friction_coefficients[0])
    moves, _ = one_grip(design, problem, 1.0)
    plant = _Recorded(own, design.gages.face)
    one_grip(design, problem, moves / (1.1 * STEPS), plant)
    return design, problem, plant.motions


def replayed(problem: ContactProblem, motions: Sequence[Motion]) -> tuple[Array, Array, float]:
    """Milliseconds (n,) of each increment solved anew and followed; the forces' difference."""
    states = [ContactState.untouched(problem)] * 2
    spaces = [Workspace(follows=False), Workspace()]
    spent, worst = np.zeros((2, len(motions))), 0.0
    with one_thread():
        for k, motion in enumerate(motions):
            forces = []
            for which, (state, workspace) in enumerate(zip(states, spaces, strict=True)):
                start = time.process_time()  # one thread; other programs do not count
                increment = solve_increment(problem, state, motion, workspace)
                spent[which, k] = 1e3 * (time.process_time() - start)
                states[which] = increment.state
                forces.append(increment.multiplier)
            scale = max(float(np.abs(forces[0]).max()), 1e-300)
            worst = max(worst, float(np.abs(forces[1] - forces[0]).max()) / scale)
    return spent[0], spent[1], worst


def lift_check(design: Design, problem: ContactProblem) -> Check:
    """Seconds of a hundred lifts over friction and weight, as ``study-control`` runs them.

    On the cores at hand, the model sent once to each process; brought to ``STEPS`` steps a lift.
    """
    grip, face = design.grip, design.gages.face
    grid = ControlGrid(FRICTIONS, MASSES_G, (0.0,), tug=None)
    plates = tuple(range(len(problem.model.gage_x)))
    own = problem.with_friction(grip.bench_friction_coefficient)
    bench = GripBench(own, face, plates, grip, grid)
    workers, batches = usable_cores(), list(grid.batches(("reactive",)))
    with TemporaryDirectory() as folder, Journal(Path(folder) / "lifts", KIND, "") as journal:
        start, before = time.perf_counter(), processor_seconds()
        grips = run_batches(bench, batches, journal, workers).values()
        seconds, work = time.perf_counter() - start, processor_seconds() - before
    steps = sum(each.steps for each in grips)
    share = STEPS * len(grips) / steps
    name = f"3d, {len(grips)} lifts of {STEPS} steps ({steps} run): {share * work:.0f} core-seconds"
    return Check(f"{name} on {workers} cores", LIFTS_S, share * seconds, "s")
