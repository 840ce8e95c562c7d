"""The fidelity ladder: no more model than the scene needs.

    ladder = climb(design, scene, tolerance=0.02)
    ladder.chosen.readings, ladder.estimate.worst, [each.why for each in ladder.tried]

A coarse finger in space and plane strain come first: what they differ by is what plane strain costs
here. Where that is near the tolerance, the section is refined, and taken as soon as a finger in
space confirms it. Else the finger is refined, each answer judged by the one before, sizes that
cannot suffice skipped, until the estimate is under the tolerance.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from fingerdesign.analysis.fidelity.estimate import Estimate, difference, discretisation
from fingerdesign.analysis.fidelity.models import InTurn, Model
from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.analysis.fidelity.rungs import SECTION_SCALES, SPACE_SCALES, can_be_section, rung
from fingerdesign.analysis.verdicts import QUANTITIES
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.records.result import TriedModel
from fingerdesign.runtime.progress import Report

LEAST_TOLERANCE, MOST_TOLERANCE = 1e-3, 0.5
MOST_DOFS = 350_000  # forecast from the rung before: 40 s and 6 GB here, and the next far more
GROWTH = 2.5  # equations by size: to this power
_AIM = 0.9  # of the tolerance: what a size must promise to be tried next
_HARDLY = 1.15  # times finer: less tells nothing of the error
_HOPELESS = 2.0  # times the tolerance: plane strain so far from a coarse finger is given up
_SMALL = 0.2  # of the tolerance: plane strain's own error
WORDS = QUANTITIES | {"gage": "gage readings"}


class Answer(Protocol):
    """The part of a solved model that the ladder reads (models.Solved, or a record of one)."""

    @property
    def model(self) -> Model: ...
    @property
    def readings(self) -> Readings: ...
    @property
    def dofs(self) -> int: ...
    @property
    def contact_nodes(self) -> int: ...
    @property
    def total(self) -> float: ...


Solve = Callable[["Design", "Scene", Model], Answer]


@dataclass
class Ladder:
    """Models in the order of trial, and the one that is enough (or the last, where none is)."""

    tolerance: float
    tried: list[TriedModel] = field(default_factory=list)
    solved: Answer | None = None
    estimate: Estimate | None = None
    why_ended: str = ""

    @property
    def chosen(self) -> Answer:
        """The model whose answer is taken. ValueError before there is one."""
        if self.solved is None:
            raise ValueError("no model has been tried")
        return self.solved

    @property
    def reached(self) -> bool:
        """True if the estimate is under the tolerance."""
        return self.estimate is not None and self.estimate.worst <= self.tolerance

    @property
    def seconds(self) -> float:
        """Seconds of all models together."""
        return sum(each.seconds for each in self.tried)

    def add(self, solved: Answer, estimate: Estimate | None, why: str) -> None:
        """Note a rung; no estimate: nothing to judge it by."""
        flat = solved.model.dimension == "plane strain"
        errors = None if estimate is None else dict(estimate.by_quantity)
        size = (solved.dofs, solved.contact_nodes, solved.total)
        self.tried.append(TriedModel(solved.model.name, 2 if flat else 3, *size, errors, why))


def climb(
    design: Design,
    scene: Scene,
    tolerance: float,
    solver: Solve | None = None,
    report: Report = lambda message: None,
    most_dofs: float = MOST_DOFS,
    scales: Sequence[float] = SPACE_SCALES,
) -> Ladder:
    """The cheapest model whose estimated error is under ``tolerance`` (a part of one).

    most_dofs: models that are forecast to have more equations are not tried; scales: of the sizes
    in space, falling. Where even the finest is over the tolerance, that one is chosen, and
    ``reached`` is False. Raises FingerDesignError where a model fails.
    """
    ladder, solver = Ladder(tolerance), solver or InTurn()
    scale, left = scales[0], list(scales[1:])
    report(f"in space, sizes x {scale:g}")
    now = solver(design, scene, rung(design, scene, "3-D", scale))
    ladder.add(now, None, "the first in space: it judges those below")
    section = None
    if can_be_section(design, scene):
        section = _section(ladder, design, scene, now, solver, report)
    if _section_suffices(ladder, section, now):
        return ladder
    before, coarser = now, scale
    while left:
        scale = left.pop(0)
        report(f"in space, sizes x {scale:g}")
        now = solver(design, scene, rung(design, scene, "3-D", scale))
        ratio = refinement(now, before, coarser / scale)
        if ratio < _HARDLY and left:
            ladder.add(now, None, "hardly finer than the one before: judges nothing")
            continue
        estimate = discretisation(now.readings, before.readings, ratio)
        ladder.solved, ladder.estimate = now, estimate
        ladder.add(now, estimate, _words(estimate, tolerance))
        if _section_suffices(ladder, section, now) or ladder.reached:
            return ladder
        left = _worth_trying(ladder, now, estimate, scale, left, most_dofs)
        before, coarser = now, scale
    ladder.why_ended = ladder.why_ended or "no finer size is on the ladder"
    return ladder


def _worth_trying(
    ladder: Ladder, now: Answer, estimate: Estimate, scale: float, left: list[float], most: float
) -> list[float]:
    """The sizes that are left after an answer at ``scale``: of at most so many equations, without
    the first ones that promise too little. Why the ladder ends where one has more is noted."""
    dofs = [now.dofs * (scale / each) ** GROWTH for each in left]
    affordable = [each for each, own in zip(left, dofs, strict=True) if own <= most]
    if len(affordable) < len(left):
        beyond = f"the next one would have about {dofs[len(affordable)]:.0f} equations"
        ladder.why_ended = f"{beyond}, over the ladder's {most:.0f}"
    aim = _AIM * ladder.tolerance
    while len(affordable) > 1 and estimate.refined(scale / affordable[0]).worst > aim:
        affordable.pop(0)
    return affordable


def refinement(fine: Answer, coarse: Answer, ratio: float) -> float:
    """The true refinement of an answer: ``ratio`` of sizes, but no more than its equations show.

    Layers come in whole numbers, and small parts keep their elements small: requested sizes may
    not be those made.
    """
    grown = float(fine.dofs / max(coarse.dofs, 1)) ** (1.0 / GROWTH)
    return float(max(min(ratio, grown), 1.0 + 1e-6))


def tolerance_faults(tolerance: float) -> list[Fault]:
    """The fault of a tolerance that no ladder can be held to."""
    if LEAST_TOLERANCE <= tolerance <= MOST_TOLERANCE:
        return []
    bound = f"between {LEAST_TOLERANCE:g} and {MOST_TOLERANCE:g} (0.02: two percent)"
    return [Fault("--accuracy", tolerance, bound, "choose one in between")]


def _section(
    ladder: Ladder, design: Design, scene: Scene, space: Answer, solver: Solve, report: Report
) -> tuple[Answer, Estimate] | None:
    """Plane strain where it may do, refined until its own error is a small part of the tolerance,
    and that error; None where the coarse finger in space is too far from it."""
    report("plane strain")
    scale = SECTION_SCALES[0]
    now = solver(design, scene, rung(design, scene, "plane strain", scale))
    price = difference(now.readings, space.readings)
    words = f"plane strain costs about {percent(price.worst)} here ({WORDS[price.worst_quantity]})"
    if price.worst > _HOPELESS * ladder.tolerance:
        ladder.add(now, price, f"{words}, target {percent(ladder.tolerance)}: given up")
        return None
    ladder.add(now, price, f"{words}: refined")
    own = price
    for finer in SECTION_SCALES[1:]:
        before, coarser, scale = now, scale, finer
        now = solver(design, scene, rung(design, scene, "plane strain", scale))
        own = discretisation(now.readings, before.readings, coarser / scale)
        ladder.add(now, None, f"plane strain, itself within {percent(own.worst)}")
        if own.worst <= _SMALL * ladder.tolerance:
            break
    return now, own


def _section_suffices(
    ladder: Ladder, section: tuple[Answer, Estimate] | None, space: Answer
) -> bool:
    """Take plane strain where it is close enough to the finger in space as far as that is known."""
    if section is None:
        return False
    answer, own = section
    estimate = difference(answer.readings, space.readings).plus(own)
    if estimate.worst > ladder.tolerance:
        return False
    ladder.solved, ladder.estimate = answer, estimate
    why = f"{_words(estimate, ladder.tolerance)}; judged by {space.model.name}"
    ladder.add(answer, estimate, why)
    ladder.tried[-1] = replace(ladder.tried[-1], seconds=0.0)  # it was counted when it was solved
    return True


def _words(estimate: Estimate, tolerance: float) -> str:
    name, worst = WORDS[estimate.worst_quantity], estimate.worst
    judged = "enough" if worst <= tolerance else "not enough"
    return f"{judged}: {name} within {percent(worst)}, target {percent(tolerance)}"


def percent(share: float) -> str:
    """Two digits: "3.1 %", "120 %".

    >>> percent(0.0314), percent(1.234), percent(0.1)
    ('3.1 %', '120 %', '10 %')
    """
    return f"{float(f'{100.0 * share:.2g}'):g} %"
