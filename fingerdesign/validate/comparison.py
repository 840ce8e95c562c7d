"""Two models' answers against each other: at equal motion, and at equal force.

Errors are those of fidelity.readings: F_n relative to its row's, F_t and contact width to the
path's largest, stick ratios absolute, gage strains to the largest reading of their row. What cannot
differ has no error: forces at equal force, F_t where the finger is hardly pulled at all (its
rounding is compared with nothing), gages where there are none, all but gages where one model is
read in two ways.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from fingerdesign.analysis.fidelity.models import Solved
from fingerdesign.analysis.fidelity.readings import QUANTITIES, Readings, errors
from fingerdesign.analysis.path import PathStopped
from fingerdesign.contact.measures import COMPLETE_SLIP
from fingerdesign.contact.problem import Motion
from fingerdesign.design.scene import LEAST_FORCE_N, Scene, ScenePath
from fingerdesign.errors import SolverError
from fingerdesign.validate.record import AnswerData, ComparisonData, Errors, Side, Spread

FULL_SLIP = 0.95  # of mu F_n: from there on a given F_t has no unique motion, or none
# Of the largest F_n: less F_t than that is no pull. Pressed and twisted alone, a block with plates
# at 45 degrees showed 0.5 % on a coarse mesh and 0.1 % on a finer one.
_NO_PULL = 1e-2
FORCES = ("normal_force", "tangential_force")
_LEAST_PRESS = 1e-3  # of the largest F_n: a first touch with less says nothing


@dataclass(frozen=True)
class Answer:
    """Answer of a model along the scene's path: readings, the object's motions, its cost.

    along: its readings over another path of the same object; None where that cannot be solved.
    """

    name: str
    readings: Readings
    motions: tuple[Motion, ...]
    seconds: float
    dofs: int
    dimension: int
    along: Callable[[Scene], Readings] | None = None

    def data(self) -> AnswerData:
        """The answer as the record holds it."""
        return AnswerData(
            model=self.name,
            dimension=2 if self.dimension == 2 else 3,
            dofs=self.dofs,
            seconds=self.seconds,
            normal_force_N=self.readings.normal_force.tolist(),
            tangential_force_N=self.readings.tangential_force.tolist(),
            contact_width_mm=self.readings.contact_width.tolist(),
            stick_ratio=self.readings.stick_ratio.tolist(),
            gages_microstrain=self.readings.reading.tolist(),
        )


def answer_of(solved: Solved, name: str = "") -> Answer:
    """The answer of a model of small strains."""
    return Answer(
        name or solved.model.name,
        solved.readings,
        tuple(step.increment.motion for step in solved.steps),
        solved.total,
        solved.dofs,
        solved.mesh.dimension,
        solved.along,
    )


def compare(label: str, found: Answer, truth: Answer, scene: Scene) -> ComparisonData:
    """``found`` against ``truth`` along the scene's path; ``found`` follows the other's forces."""
    missing: list[str] = []
    sides: dict[str, Side | None] = {}
    for name, of in (("motion", _equal_motion), ("force", _equal_force)):
        try:
            sides[name] = of(found, truth, scene)
        except SolverError as error:
            sides[name] = None
            missing.append(f"equal {name}: {error}")
    return ComparisonData(
        label, found.data(), truth.data(), sides["motion"], sides["force"], tuple(missing)
    )


def compare_gages(label: str, found: Answer, truth: Answer) -> ComparisonData:
    """One model read in two ways: forces, motions and contact are the same, whichever is given."""
    same = [name for name in QUANTITIES if name != "gage"]
    side = side_of(found.readings, truth.readings, same=same)
    return ComparisonData(label, found.data(), truth.data(), side, side, ())


def side_of(
    found: Readings, truth: Readings, left_out: int = 0, note: str = "", same: Sequence[str] = ()
) -> Side:
    """Greatest and median errors of readings row by row; of what is the ``same`` in both: none."""
    apart = errors(found, truth)
    none = {*same} if _pulled(found, truth) else {*same, "tangential_force"}
    spread: dict[str, Spread | None] = {}
    for name in QUANTITIES:
        values = apart[name].reshape(-1)
        reported = values.size and name not in none
        spread[name] = Spread(float(values.max()), float(np.median(values))) if reported else None
    by_gage = tuple(float(value) for value in apart["gage"].max(axis=0, initial=0.0))
    return Side(found.rows, left_out, note, cast(Errors, spread), by_gage)


def _equal_motion(found: Answer, truth: Answer, scene: Scene) -> Side:
    if scene.path.control == "motion":
        return side_of(found.readings, truth.readings)
    rows = tuple((m.approach, m.shear) for m in truth.motions)
    path = ScenePath(increments_mm=rows, substeps=scene.path.substeps)
    return _followed(found, truth.readings, scene, path, 0, "")


def _equal_force(found: Answer, truth: Answer, scene: Scene) -> Side:
    if scene.path.control == "force":
        return side_of(found.readings, truth.readings, same=FORCES)
    if any(any(row[2:]) for row in scene.path.rows):
        raise SolverError("a path of forces has no shear_z and no twist, this scene's has")
    first, last, note = usable_rows(truth, scene)
    if last <= first:
        raise SolverError("no row of this path presses and still sticks somewhere")
    inside = truth.readings.part(slice(first, last))
    rows = tuple(
        (float(n), float(t))
        for n, t in zip(inside.normal_force, inside.tangential_force, strict=True)
    )
    path = ScenePath(increments_N=rows, control="force", substeps=scene.path.substeps)
    return _followed(found, inside, scene, path, truth.readings.rows - len(rows), note)


def usable_rows(truth: Answer, scene: Scene) -> tuple[int, int, str]:
    """First row that presses, and the one after it that is at complete slip or lets go.

    What comes after complete slip is left out too: it depends on how far the finger slid.
    """
    found, law = truth.readings, scene.object.law
    least = max(LEAST_FORCE_N, _LEAST_PRESS * float(found.normal_force.max(initial=0.0)))
    presses = found.normal_force >= least
    first = int(np.argmax(presses)) if presses.any() else found.rows
    pulled = np.abs(found.tangential_force)
    slips = found.stick_ratio < COMPLETE_SLIP[truth.dimension]
    if scene.object.tilt_deg == 0.0 and law.is_coulomb:
        slips = slips | (pulled > FULL_SLIP * law.coefficient * found.normal_force)
    stops = np.flatnonzero((slips | ~presses)[first:])
    last = first + int(stops[0]) if len(stops) else found.rows
    notes = [f"{_rows(first)} before it presses"] if first else []
    if last < found.rows:
        notes.append(f"{_rows(found.rows - last)} from complete slip or release on")
    return first, last, "; ".join(notes)


def _followed(
    found: Answer, truth: Readings, scene: Scene, path: ScenePath, left_out: int, note: str
) -> Side:
    """``found`` along ``path`` as far as it has an answer; what is left out is counted."""
    if found.along is None:
        raise SolverError(f"{found.name} follows no other path")
    rows, key = path.rows, path.key.removeprefix("path.")
    count, why = len(rows), ""
    while count:
        shorter = path.model_copy(update={key: rows[:count]})
        try:
            readings = found.along(scene.model_copy(update={"path": shorter}))
        except SolverError as error:
            reached = len(error.increments) if isinstance(error, PathStopped) else count - 1
            count, why = min(reached, count - 1), str(error)
            continue
        lost = len(rows) - count
        if lost:
            reason = f"{_rows(lost)} that it cannot follow ({why})"
            note = f"{note}; {reason}" if note else reason
        same = FORCES if path.control == "force" else ()
        return side_of(readings, truth.part(slice(count)), left_out + lost, note, same)
    raise SolverError(f"it cannot follow even the first row: {why}")


def _pulled(found: Readings, truth: Readings) -> bool:
    """True if F_t of either is more than rounding."""
    pulls = np.abs([*found.tangential_force, *truth.tangential_force])
    press = np.abs(truth.normal_force).max(initial=0.0)
    return bool(pulls.max(initial=0.0) > _NO_PULL * press)


def _rows(count: int) -> str:
    return f"{count} row{'s' * (count != 1)}"
