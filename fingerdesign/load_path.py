"""The scene's path, followed row by row; what is solved is kept where a row has no answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.path import Step, follow
from fingerdesign.design.layout import crest_height
from fingerdesign.design.scene_checks import MOST_MOTION
from fingerdesign.errors import SolverError
from fingerdesign.records import increment_result
from fingerdesign.scene_contact import targets

if TYPE_CHECKING:
    from fingerdesign.contact.problem import ContactProblem, Motion
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.results import IncrementResult


class PathStopped(SolverError):
    """A row of the path has no accepted answer; ``increments`` holds those before it."""

    def __init__(self, message: str, increments: tuple[IncrementResult, ...]) -> None:
        super().__init__(message)
        self.increments = increments


def follow_path(problem: ContactProblem, scene: Scene, design: Design) -> list[Step]:
    """One step a row. Raises ZoneExhausted where the candidates do not reach far enough, and
    PathStopped where a row has no accepted answer or leads farther than small strains allow."""
    path, steps, face = scene.path, list[Step](), design.gages.face
    most = MOST_MOTION * float(crest_height(design.body))
    try:
        for step in follow(problem, targets(path), substeps=path.substeps):
            _refuse_far(step.increment.motion, most)
            steps.append(step)
    except ZoneExhausted:
        raise
    except SolverError as error:
        where = f"row {len(steps) + 1} of {len(path.rows)} ({path.key}[{len(steps)}])"
        solved = tuple(increment_result(step, face) for step in steps)
        raise PathStopped(f"{where}: {error}", solved) from error
    return steps


def _refuse_far(motion: Motion, most: float) -> None:
    """Motions that forces led to are held to what prescribed ones are."""
    if max(abs(motion.approach), abs(motion.shear)) > most:
        raise SolverError(
            f"the forces lead to {motion}: more than {most:.4g} mm, half of the finger's height, "
            "where strains are small no more; ask for less force"
        )
