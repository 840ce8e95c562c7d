"""The fidelity ladder: no more model than the scene needs.

    ladder = climb(design, scene, tolerance=0.02)
    ladder.chosen.readings, ladder.estimate.worst, [each.why for each in ladder.tried]

Where formulas speak of the scene, what they say is told; the plane strain that judges them costs a
tenth of a second and says more, so they are never the answer.

Plane strain and a coarse finger in space of like sizes come first: what they differ by is what
plane strain costs here. Where that is less than the tolerance, the section is refined instead of
the finger. Else the finger is refined, each answer judged by the one before (estimate.py), sizes
that cannot suffice skipped, until the estimate is under the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from fingerdesign.errors import DesignError, Fault
from fingerdesign.fidelity.analytic import NAME, analytic_readings
from fingerdesign.fidelity.estimate import ORDER, Estimate, difference, discretisation
from fingerdesign.fidelity.models import Model, solve
from fingerdesign.fidelity.rungs import SECTION_SCALES, SPACE_SCALES, can_be_section, rung

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.fidelity.readings import Readings

Tell = Callable[[str], None]


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
    solver: Solve = solve,
    tell: Tell = lambda message: None,
    most_dofs: float = MOST_DOFS,
) -> Ladder:
    """The cheapest model whose estimated error is under ``tolerance`` (a part of one).

    most_dofs: models that are forecast to have more equations are not tried. Where even the finest
    is over the tolerance, that one is chosen, and ``reached`` is False. Raises DesignError for a
    tolerance out of range, FingerDesignError where a model fails.
    """
    if faults := tolerance_faults(tolerance):
        raise DesignError(faults)
    ladder = Ladder(tolerance)
    section = can_be_section(design, scene)
    first = SPACE_SCALES[0]
    tell(f"in space, sizes x {first:g}")
    space = solver(design, scene, rung(design, scene, "3-D", first))
    if section:
        if _section_suffices(ladder, design, scene, space, solver, tell):
            return ladder
    else:
        ladder.add(space, None, "the first: nothing to judge it by yet")
    _climb_space(ladder, design, scene, space, solver, tell, most_dofs)
    return ladder


def tolerance_faults(tolerance: float) -> list[Fault]:
    """The fault of a tolerance that no ladder can be held to."""
    if LEAST_TOLERANCE <= tolerance <= MOST_TOLERANCE:
        return []
    bound = f"between {LEAST_TOLERANCE:g} and {MOST_TOLERANCE:g} (0.02: two percent)"
    return [Fault("--tolerance", tolerance, bound, "choose one in between")]


def _section_suffices(
    ladder: Ladder, design: Design, scene: Scene, space: Answer, solver: Solve, tell: Tell
) -> bool:
    """Whether plane strain does, judged by the coarse finger in space; then refined until it is."""
    tell("plane strain")
    coarse = solver(design, scene, rung(design, scene, "plane strain", SPACE_SCALES[0]))
    formulas = analytic_readings(design, scene)
    if formulas is not None:
        off = difference(formulas, space.readings)
        ladder.tried.append(Tried(NAME, "plane strain", 0, 0, 0.0, off, _formula_words(off)))
    price = difference(coarse.readings, space.readings)
    ladder.add(coarse, price, _section_words(price, ladder.tolerance))
    ladder.add(space, None, "the finger in space on the same section: judges plane strain")
    if price.worst > _AIM * ladder.tolerance:
        return False
    before, scale = coarse, SPACE_SCALES[0]
    for finer in (each for each in SECTION_SCALES if each < SPACE_SCALES[0]):
        tell(f"plane strain, sizes x {finer:g}")
        now = solver(design, scene, rung(design, scene, "plane strain", finer))
        estimate = price.plus(discretisation(now.readings, before.readings, scale / finer))
        enough = estimate.worst <= ladder.tolerance
        ladder.add(now, estimate, _words(estimate, ladder.tolerance))
        if enough:
            ladder.solved, ladder.estimate = now, estimate
            return True
        before, scale = now, finer
    return False


def _climb_space(
    ladder: Ladder,
    design: Design,
    scene: Scene,
    first: Answer,
    solver: Solve,
    tell: Tell,
    most_dofs: float,
) -> None:
    """Refine the finger in space until the estimate is under the tolerance, or to the end."""
    before, scale = first, SPACE_SCALES[0]
    left = list(SPACE_SCALES[1:])
    while left:
        finer = left.pop(0)
        tell(f"in space, sizes x {finer:g}")
        now = solver(design, scene, rung(design, scene, "3-D", finer))
        estimate = discretisation(now.readings, before.readings, scale / finer)
        ladder.solved, ladder.estimate = now, estimate
        ladder.add(now, estimate, _words(estimate, ladder.tolerance))
        if ladder.reached:
            return
        left = [each for each in left if now.dofs * (finer / each) ** GROWTH <= most_dofs]
        while len(left) > 1:
            promised = estimate.worst * (left[0] / finer) ** ORDER
            if promised <= _AIM * ladder.tolerance:
                break
            left.pop(0)
        before, scale = now, finer


def _words(estimate: Estimate, tolerance: float) -> str:
    name, worst = WORDS[estimate.worst_quantity], estimate.worst
    if worst <= tolerance:
        return f"enough: {name} within {100 * worst:.2g} %, {100 * tolerance:g} % asked"
    return f"not enough: {name} within {100 * worst:.2g} %, {100 * tolerance:g} % asked"


def _formula_words(off: Estimate) -> str:
    name, worst = WORDS[off.worst_quantity], off.worst
    return f"off by {100 * worst:.2g} % ({name}) from the coarse finger in space; told, never taken"


def _section_words(price: Estimate, tolerance: float) -> str:
    name, worst = WORDS[price.worst_quantity], price.worst
    if worst <= _AIM * tolerance:
        return f"plane strain costs {100 * worst:.2g} % here ({name}): refined further"
    return f"plane strain costs {100 * worst:.2g} % here ({name}), {100 * tolerance:g} % asked"
