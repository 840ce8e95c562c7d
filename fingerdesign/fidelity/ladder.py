"""The fidelity ladder: no more model than the scene needs.

    ladder = climb(design, scene, tolerance=0.02)
    ladder.chosen.readings, ladder.estimate.worst, [each.why for each in ladder.tried]

Where formulas speak of the scene, what they say is told; the plane strain that judges them costs a
tenth of a second and says more, so they are never the answer.

A coarse finger in space and plane strain come first: what they differ by is what plane strain costs
here. Where that is near the tolerance, the section is refined, and taken as soon as a finger in
space confirms it. Else the finger is refined, each answer judged by the one before (estimate.py),
sizes that cannot suffice skipped, until the estimate is under the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from fingerdesign.errors import DesignError, Fault
from fingerdesign.fidelity.analytic import NAME, analytic_readings
from fingerdesign.fidelity.estimate import Estimate, difference, discretisation
from fingerdesign.fidelity.models import InTurn, Model
from fingerdesign.fidelity.rungs import SECTION_SCALES, SPACE_SCALES, can_be_section, rung
from fingerdesign.runtime.progress import Tell

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.fidelity.readings import Readings


class Answer(Protocol):
    """What the ladder sees of a solved model (models.Solved, or a record of one)."""

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

LEAST_TOLERANCE, MOST_TOLERANCE = 1e-3, 0.5
MOST_DOFS = (
    350_000  # forecast from the rung before: 40 s and 6 GB here, and what comes next far more
)
GROWTH = 2.5  # equations by size: to this power
_AIM = 0.9  # of the tolerance: what a size must promise to be tried next
_HARDLY = 1.15  # times finer: less tells nothing of the error
_HOPELESS = 2.0  # times the tolerance: plane strain so far from a coarse finger is given up
_SMALL = 0.2  # of the tolerance: plane strain's own error
WORDS = {
    "normal_force": "F_n",
    "tangential_force": "F_t",
    "stick_ratio": "stick ratio",
    "gage": "gage readings",
}


@dataclass(frozen=True)
class Tried:
    """One rung: its model, what it cost, its estimated errors (None: nothing to judge it by)."""

    name: str
    dimension: str
    dofs: int
    contact_nodes: int
    seconds: float
    estimate: Estimate | None
    why: str


@dataclass
class Ladder:
    """What was tried, in order, and the one that is enough (or the last, where none is)."""

    tolerance: float
    tried: list[Tried] = field(default_factory=list)
    solved: Answer | None = None
    estimate: Estimate | None = None
    why_ended: str = ""

    @property
    def chosen(self) -> Answer:
        """The model whose answer stands. ValueError before there is one."""
        if self.solved is None:
            raise ValueError("no model has been tried")
        return self.solved

    @property
    def reached(self) -> bool:
        """Whether the estimate is under the tolerance."""
        return self.estimate is not None and self.estimate.worst <= self.tolerance

    @property
    def seconds(self) -> float:
        """What all of them cost together."""
        return sum(each.seconds for each in self.tried)

    def add(self, solved: Answer, estimate: Estimate | None, why: str) -> None:
        """Note a rung."""
        self.tried.append(
            Tried(
                solved.model.name,
                solved.model.dimension,
                solved.dofs,
                solved.contact_nodes,
                solved.total,
                estimate,
                why,
            )
        )


def climb(
    design: Design,
    scene: Scene,
    tolerance: float,
    solver: Solve | None = None,
    tell: Tell = lambda message: None,
    most_dofs: float = MOST_DOFS,
    scales: Sequence[float] = SPACE_SCALES,
) -> Ladder:
    """The cheapest model whose estimated error is under ``tolerance`` (a part of one).

    most_dofs: models that are forecast to have more equations are not tried; scales: of the sizes
    in space, falling. Where even the finest is over the tolerance, that one is chosen, and
    ``reached`` is False. Raises DesignError for a tolerance out of range, FingerDesignError where a
    model fails.
    """
    if faults := tolerance_faults(tolerance):
        raise DesignError(faults)
    ladder, solver = Ladder(tolerance), solver or InTurn()
    scale, left = scales[0], list(scales[1:])
    tell(f"in space, sizes x {scale:g}")
    now = solver(design, scene, rung(design, scene, "3-D", scale))
    ladder.add(now, None, "the first in space: it judges those below")
    section = None
    if can_be_section(design, scene):
        section = _section(ladder, design, scene, now, solver, tell)
    if section is not None and _section_suffices(ladder, section, now):
        return ladder
    before, coarser = now, scale
    while left:
        scale = left.pop(0)
        tell(f"in space, sizes x {scale:g}")
        now = solver(design, scene, rung(design, scene, "3-D", scale))
        ratio = refinement(now, before, coarser / scale)
        if ratio < _HARDLY and left:
            ladder.add(now, None, "hardly finer than the one before: judges nothing")
            continue
        estimate = discretisation(now.readings, before.readings, ratio)
        ladder.solved, ladder.estimate = now, estimate
        ladder.add(now, estimate, _words(estimate, tolerance))
        if section is not None and _section_suffices(ladder, section, now):
            return ladder
        if ladder.reached:
            return ladder
        beyond = [each for each in left if now.dofs * (scale / each) ** GROWTH > most_dofs]
        if beyond:
            ladder.why_ended = (
                f"the next one would have about {now.dofs * (scale / beyond[0]) ** GROWTH:.0f} "
                f"equations, over the ladder's {most_dofs:.0f}"
            )
        left = left[: len(left) - len(beyond)]
        while len(left) > 1 and _too_coarse(estimate, scale, left[0], tolerance):
            left.pop(0)
        before, coarser = now, scale
    ladder.why_ended = ladder.why_ended or "no finer size is on the ladder"
    return ladder


def refinement(fine: Answer, coarse: Answer, ratio: float) -> float:
    """How much finer an answer really is: ``ratio`` of sizes, but no more than its equations say.

    Layers come in whole numbers, and small parts keep their elements small: sizes asked for may
    not be those made.
    """
    grown = float(fine.dofs / max(coarse.dofs, 1)) ** (1.0 / GROWTH)
    return float(max(min(ratio, grown), 1.0 + 1e-6))


def tolerance_faults(tolerance: float) -> list[Fault]:
    """The fault of a tolerance that no ladder can be held to."""
    if LEAST_TOLERANCE <= tolerance <= MOST_TOLERANCE:
        return []
    bound = f"between {LEAST_TOLERANCE:g} and {MOST_TOLERANCE:g} (0.02: two percent)"
    return [Fault("--tolerance", tolerance, bound, "choose one in between")]


@dataclass(frozen=True)
class _Section:
    """Plane strain as fine as the tolerance asks, and its own error."""

    answer: Answer
    own: Estimate


def _section(
    ladder: Ladder, design: Design, scene: Scene, space: Answer, solver: Solve, tell: Tell
) -> _Section | None:
    """Plane strain where it may do, refined until its own error is a small part of the tolerance;
    None where the coarse finger in space is too far from it."""
    tell("plane strain")
    formulas = analytic_readings(design, scene)
    if formulas is not None:
        off = difference(formulas, space.readings)
        ladder.tried.append(Tried(NAME, "plane strain", 0, 0, 0.0, off, _formula_words(off)))
    scale = SECTION_SCALES[0]
    now = solver(design, scene, rung(design, scene, "plane strain", scale))
    price = difference(now.readings, space.readings)
    hopeless = price.worst > _HOPELESS * ladder.tolerance
    ladder.add(now, price, _section_words(price, ladder.tolerance))
    if hopeless:
        return None
    own = price
    for finer in SECTION_SCALES[1:]:
        before, coarser, scale = now, scale, finer
        now = solver(design, scene, rung(design, scene, "plane strain", scale))
        own = discretisation(now.readings, before.readings, coarser / scale)
        ladder.add(now, None, f"plane strain, itself within {percent(own.worst)}")
        if own.worst <= _SMALL * ladder.tolerance:
            break
    return _Section(now, own)


def _section_suffices(ladder: Ladder, section: _Section, space: Answer) -> bool:
    """Take plane strain where it is close enough to the finger in space as far as that is known."""
    estimate = difference(section.answer.readings, space.readings).plus(section.own)
    if estimate.worst > ladder.tolerance:
        return False
    ladder.solved, ladder.estimate = section.answer, estimate
    ladder.tried.append(
        Tried(
            section.answer.model.name,
            "plane strain",
            section.answer.dofs,
            section.answer.contact_nodes,
            0.0,
            estimate,
            f"{_words(estimate, ladder.tolerance)}; judged by {space.model.name}",
        )
    )
    return True


def _too_coarse(estimate: Estimate, scale: float, finer: float, tolerance: float) -> bool:
    """Whether a finer size promises too little to be tried."""
    return bool(estimate.refined(scale / finer).worst > _AIM * tolerance)


def _words(estimate: Estimate, tolerance: float) -> str:
    name, worst = WORDS[estimate.worst_quantity], estimate.worst
    if worst <= tolerance:
        return f"enough: {name} within {percent(worst)}, {percent(tolerance)} asked"
    return f"not enough: {name} within {percent(worst)}, {percent(tolerance)} asked"


def percent(share: float) -> str:
    """Two digits: "3.1 %", "120 %".

    >>> percent(0.0314), percent(1.234), percent(0.1)
    ('3.1 %', '120 %', '10 %')
    """
    return f"{float(f'{100.0 * share:.2g}'):g} %"


def _formula_words(off: Estimate) -> str:
    name, worst = WORDS[off.worst_quantity], off.worst
    return f"off by {percent(worst)} ({name}) from the coarse finger in space; told, never taken"


def _section_words(price: Estimate, tolerance: float) -> str:
    name, worst = WORDS[price.worst_quantity], price.worst
    words = f"plane strain costs about {percent(worst)} here ({name})"
    if worst > _HOPELESS * tolerance:
        return f"{words}, {percent(tolerance)} asked: given up"
    return f"{words}: refined"
