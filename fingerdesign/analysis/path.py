"""The scene's path, followed row by row; solved rows are recorded where a later one fails."""

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from typing import TypeVar

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.checks.scene import MOST_MOTION
from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.laws import OPEN
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.control.signals import gage_readings
from fingerdesign.design.scene import Scene, SceneObject, ScenePath
from fingerdesign.design.schema import Body, Design
from fingerdesign.errors import SolverError
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.surface import surface_of
from fingerdesign.records.arrays import ContactHistory
from fingerdesign.records.base import values_of
from fingerdesign.records.result import GageResult, IncrementResult, PointStrain
from fingerdesign.reduced import ReducedModel
from fingerdesign.shapes.objects import Plane, RigidObject, touching

MICRO = 1e6  # microstrain of a strain of one
Solved = TypeVar("Solved", bound=Step)


def object_at_touch(rigid: SceneObject, body: Body) -> RigidObject:
    """The scene's object where it first touches the undeformed finger, let down along y."""
    made = rigid.made()
    if isinstance(made, Plane) and made.direction == (0.0, -1.0, 0.0) and body.step is None:
        return made.at_height(surface_of(body).crest)
    return _let_down(rigid, body)[0]


def problem_at_touch(model: ReducedModel, rigid: SceneObject, body: Body) -> ContactProblem:
    """The finger against the scene's object where it first touches, with the object's friction."""
    return contact_problem(model, object_at_touch(rigid, body), rigid.law)


def touch_point(rigid: SceneObject, body: Body) -> tuple[float, float]:
    """Place (x, z), mm, at which the object first touches the undeformed finger."""
    point = _let_down(rigid, body)[1]
    return float(point[0]), float(point[2])


def _let_down(rigid: SceneObject, body: Body) -> tuple[RigidObject, Array]:
    """The object where it first touches, and the point (3,) where it does."""
    # Not of a STEP body, whose file may change.
    return (_found_touch if body.step is None else _found_touch.__wrapped__)(rigid, body)


@lru_cache(maxsize=256)  # The many objects of one finger: for its mesh, then for its contacts.
def _found_touch(rigid: SceneObject, body: Body) -> tuple[RigidObject, Array]:
    surface = surface_of(body)

    def height(x: Array, z: Array) -> Array:
        found = np.asarray(surface.height(x, z))
        return np.where(np.isfinite(found), found, -np.inf)  # no surface there: nothing to touch

    return touching(rigid.made(), height, 0.5 * body.width_mm, 0.5 * body.depth_mm)


def targets(path: ScenePath) -> list[Motion | Forces]:
    """One target a row: motions in mm and degrees, or forces in N."""
    if path.control == "force":
        return [Forces(row[0], row[1]) for row in path.rows]
    return [Motion(*row) for row in path.rows]


def steps_sideways(scene: Scene) -> bool:
    """True if anything in the scene leaves the plane of the section z = 0."""
    return not (scene.object.plane_in_z and scene.path.mirrors_in_z)


def closed_nodes(steps: Sequence[Step]) -> BoolArray:
    """The contact nodes (m,) that touch, a row a step."""
    return np.array([step.increment.status != OPEN for step in steps])


def deepest(steps: Sequence[Step]) -> float:
    """The greatest approach of the steps, mm."""
    return max(step.increment.motion.approach for step in steps)


def increment_result(step: Step, face: str) -> IncrementResult:
    """One row of ``increments`` in result.json."""
    measures, increment = step.measures, step.increment
    upper, lower = MICRO * measures.gages.T
    columns = (upper, lower, 0.5 * (upper + lower), 0.5 * (upper - lower))
    read = np.column_stack([*columns, gage_readings(measures.gages, face)]).tolist()
    gages = tuple(GageResult(plate, *row) for plate, row in enumerate(read))
    points = tuple(PointStrain(*strain) for strain in (MICRO * measures.points).tolist())
    sources = (measures, increment.motion, increment)
    return IncrementResult(**values_of(IncrementResult, *sources, gages=gages, points=points))


def contact_history(problem: ContactProblem, steps: Sequence[Step]) -> ContactHistory:
    """Nodal status, tractions (MPa) and slip (mm) of all increments."""
    model: ReducedModel = problem.model
    force = np.array([step.increment.force for step in steps])
    normal = np.array([step.increment.multiplier[:, 0] for step in steps])
    areas = np.array([model.areas if step.areas is None else step.areas for step in steps])
    plane = [0] if model.dimension == 2 else [0, 2]
    return ContactHistory(
        points=model.points,
        areas=model.areas / (model.depth if model.dimension == 2 else 1.0),
        facets=model.facets,
        status=np.array([step.increment.status for step in steps]),
        normal_traction=normal / areas,
        tangential_traction=force[:, :, plane] / areas[:, :, None],
        slip=np.array([step.increment.state.slip for step in steps]),
        symmetric=model.symmetry_factor == 2,
    )


class PathStopped(SolverError):
    """A row of the path has no accepted answer; ``increments`` holds those before it."""

    def __init__(self, message: str, increments: tuple[IncrementResult, ...]) -> None:
        super().__init__(message)
        self.increments = increments


def all_steps(steps: Iterable[Solved], path: ScenePath, face: str) -> list[Solved]:
    """One step a row. Raises ZoneExhausted where the candidates do not reach far enough, and
    PathStopped where a row has no accepted answer."""
    found: list[Solved] = []
    try:
        found.extend(steps)  # those before an error stay
    except ZoneExhausted:
        raise
    except SolverError as error:
        where = f"row {len(found) + 1} of {len(path.rows)} ({path.key}[{len(found)}])"
        solved = tuple(increment_result(step, face) for step in found)
        raise PathStopped(f"{where}: {error}", solved) from error
    return found


def follow_path(problem: ContactProblem, scene: Scene, design: Design) -> list[Step]:
    """One step a row. Errors as of :func:`all_steps`; PathStopped also where a row leads farther
    than small strains allow."""
    path, most = scene.path, MOST_MOTION * float(crest_height(design.body))

    def steps() -> Iterator[Step]:
        for step in follow(problem, targets(path), substeps=path.substeps):
            motion = step.increment.motion
            if max(abs(motion.approach), abs(motion.shear)) > most:  # as of prescribed ones
                raise SolverError(
                    f"the forces lead to {motion}: more than {most:.4g} mm, half of the finger's "
                    "height, where strains are small no more; ask for less force"
                )
            yield step

    return all_steps(steps(), path, design.gages.face)
