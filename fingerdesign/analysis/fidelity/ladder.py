"""The fidelity ladder: no more model than the scene needs.

    ladder = climb(design, scene, tolerance=0.02)
    ladder.chosen.readings, ladder.estimate.worst, [each.why for each in ladder.tried]

A coarse finger in space and plane strain come first: what they differ by is what plane strain costs
here. Where that is near the tolerance, the section is refined, and taken as soon as a finger in
space confirms it. Else the finger is refined, each answer judged by the one before, sizes that
cannot suffice skipped, until the estimate is under the tolerance. Formulas, where they speak of the
scene, are reported and never taken: the plane strain that judges them costs a tenth of a second.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from fingerdesign.analysis.case import Case, Clock
from fingerdesign.analysis.fidelity.models import InTurn, Model, Solved
from fingerdesign.analysis.fidelity.readings import NOT_PULLED, Readings, errors
from fingerdesign.analysis.fidelity.rungs import SECTION_SCALES, SPACE_SCALES, can_be_section, rung
from fingerdesign.arrays import Array
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault, SolverError
from fingerdesign.fem.model import FiniteElementModel
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.zone import Zone
from fingerdesign.records.result import LadderSummary, TriedModel
from fingerdesign.runtime.progress import Report

# The lowest rung: a straight finger without plates, by formulas (numpy only).
#
# Hertz's line contact on a layer of the crest's height (Johnson, Contact Mechanics, 1985, eq. 5.56)
#
#     approach(a) = a^2 / (4 R) (2 ln(2 d / a) - nu / (1 - nu)),   P(a) = pi E* a^2 L / (4 R)
#
# and, pulled sideways under a held force, Cattaneo's partial slip as the difference of two such
# contacts (Jaeger 1998; Ciavarella 1998), of half-widths a and c:
#
#     Q = mu (P(a) - P(c)),   shear = mu (yield(a) - yield(c)),   stick ratio c / a
#     yield(a) = a^2 / (4 R) (2 ln(2 d / a) + (2 - nu) / (1 - nu))
#
# The last is eq. 5.56 for a force along the surface: Flamant's displacement below it has its other
# constant the other way round (Timoshenko and Goodier, Theory of Elasticity, 1970, art. 36).

NAME = "formulas: Hertz on a layer, Cattaneo"
_STEPS = 60


def analytic_readings(design: Design, scene: Scene) -> Readings | None:
    """The readings of the path by formulas; None where these do not hold.

    They hold for an arc without plates or core under a level plane that is pressed, never let go,
    and pulled one way only at constant approach or force.
    """
    body, rigid = design.body, scene.object
    plain = body.shape == "arc" and body.edge_radius_mm is None and body.core is None
    if not plain or design.plates.number or not rigid.flat or rigid.tilt_deg:
        return None
    rows = np.array([row[:2] for row in scene.path.rows])
    if not scene.path.mirrors_in_z or not _monotone(rows):
        return None
    law = _Layer(design)
    found = []
    friction = rigid.friction_coefficient
    for normal, pull in rows:
        if scene.path.control == "force":
            half = law.inverse(law.force, normal)
            grip = law.inverse(law.force, max(normal - pull / max(friction, 1e-12), 0.0))
        else:
            half = law.inverse(law.approach, normal)
            left = law.sideways(half) - pull / max(friction, 1e-12)
            grip = law.inverse(law.sideways, max(left, 0.0))
        tangential = friction * (law.force(half) - law.force(grip))
        found.append((law.force(half), tangential, 2.0 * half, grip / half if half > 0.0 else 0.0))
    normal_force, tangential_force, width, stick = np.array(found).T
    none = np.empty((len(found), 0, 2))
    return Readings(normal_force, tangential_force, width, stick, none, design.gages.face)


class _Layer:
    """Force and approach of a half-width on the finger's layer, both rising up to ``widest``."""

    def __init__(self, design: Design) -> None:
        body, material = design.body, design.material_of("body")
        self.nu = material.poissons_ratio
        self.radius, self.depth = body.arc_radius_mm, body.depth_mm
        self.modulus = material.youngs_modulus_MPa / (1.0 - self.nu**2)
        self.height = float(crest_height(body))
        most = 2.0 * self.height * math.exp(-0.5 / (1.0 - self.nu))
        self.widest = min(0.5 * body.width_mm, most)

    def force(self, half: float) -> float:
        """N on the whole finger."""
        return math.pi * self.modulus * half**2 * self.depth / (4.0 * self.radius)

    def approach(self, half: float) -> float:
        """mm, along the normal."""
        return self._yields(half, -self.nu / (1.0 - self.nu))

    def sideways(self, half: float) -> float:
        """mm along the surface, where all of it slips at a friction coefficient of 1."""
        return self._yields(half, (2.0 - self.nu) / (1.0 - self.nu))

    def _yields(self, half: float, constant: float) -> float:
        if half <= 0.0:
            return 0.0
        layer = 2.0 * math.log(2.0 * self.height / half) + constant
        return half**2 / (4.0 * self.radius) * layer

    def inverse(self, law: Callable[[float], float], value: float) -> float:
        """The half-width, mm, at which a rising law has a value."""
        if value <= 0.0:
            return 0.0
        low, high = 0.0, self.widest
        for _ in range(_STEPS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if law(middle) < value else (low, middle)
        return low


def _monotone(rows: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> bool:
    """Whether the first column never falls, and the second rises only while the first is held."""
    steps = np.diff(rows, axis=0)
    pulled = rows[:, 1] != 0.0
    held = (steps[:, 0] == 0.0) | (~pulled[1:])
    return bool((steps >= 0.0).all() and held.all() and rows[0, 1] == 0.0)


# The error of a model, estimated from its difference to the one before it.
#
# An answer on elements of size h is taken to be off by c h^p. Two answers with sizes in the ratio
# rho = h_coarse / h_fine differ by D, so the finer one is off by about
#
#     D / (rho^p - 1)
#
# (Richardson), p = ORDERS by quantity: plates' ends are singular, borders of contact and stick move
# by parts of a facet. They were settled on three fingers of another seed than the bench's: the
# largest whole or half orders at which four of five errors are under their estimate. (Median share
# of the estimate, and in 95 of 100 cases: F_n 0.24, 1.4; F_t 0.51, 0.91; stick ratio 0.36, 1.3;
# gages 0.29, 1.0.)
#
# A quantity's error is that of 95 % of its readings; of the path, that of its worst quantity. Stick
# ratios count where something pulls sideways: under approach alone they say how the path was cut
# into increments.

# Goals are what a controller reads, not energies. Contact width is reported, but not read.
GOALS = ("normal_force", "tangential_force", "stick_ratio", "gage")
ORDERS = {"normal_force": 1.0, "tangential_force": 2.0, "stick_ratio": 2.0, "gage": 1.0}
_PULLED = 1e-3  # of the path's largest F_t
SHARE = 0.95  # of the readings of a quantity that an error is meant for


@dataclass(frozen=True)
class Estimate:
    """Estimated errors by quantity, parts of one (see readings.errors for what they relate to)."""

    by_quantity: dict[str, float]

    @property
    def worst(self) -> float:
        """Of the quantity that is worst."""
        return max(self.by_quantity.values(), default=0.0)

    @property
    def worst_quantity(self) -> str:
        """Which quantity that is."""
        return max(self.by_quantity, key=lambda name: self.by_quantity[name])

    def plus(self, other: Estimate) -> Estimate:
        """Both errors together, at their worst."""
        names = {**self.by_quantity, **other.by_quantity}
        return Estimate(
            {n: self.by_quantity.get(n, 0.0) + other.by_quantity.get(n, 0.0) for n in names}
        )

    def refined(self, ratio: float) -> Estimate:
        """What is left of the errors on sizes ``ratio`` times smaller."""
        return Estimate({n: each / ratio ** ORDERS[n] for n, each in self.by_quantity.items()})


def difference(found: Readings, other: Readings) -> Estimate:
    """How far 95 % of the readings of each quantity are from ``other`` at the most."""
    return Estimate({name: of_most(each) for name, each in goal_errors(found, other).items()})


def goal_errors(found: Readings, truth: Readings) -> dict[str, Array]:
    """Errors of what a scene reads, by quantity, each in one row."""
    apart = errors(found, truth)
    every = {name: apart[name].reshape(-1) for name in GOALS}
    pull = np.abs(truth.tangential_force)
    most = float(pull.max(initial=0.0))
    if most > NOT_PULLED * np.abs(truth.normal_force).max(initial=0.0):
        every["stick_ratio"] = every["stick_ratio"][pull > _PULLED * most]
    return every


def of_most(values: Array) -> float:
    """The value that SHARE of all do not exceed; 0 of none."""
    flat = np.asarray(values).reshape(-1)
    return float(np.quantile(flat, SHARE)) if flat.size else 0.0


def discretisation(fine: Readings, coarse: Readings, ratio: float) -> Estimate:
    """The finer answer's own error, sizes being in ``ratio`` > 1. ValueError for another ratio."""
    if not ratio > 1.0:
        raise ValueError(f"ratio = {ratio} must be above 1: the coarser size over the finer one")
    apart = difference(coarse, fine).by_quantity
    return Estimate({name: each / (ratio ** ORDERS[name] - 1.0) for name, each in apart.items()})


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
MOST_DOFS = 350_000  # forecast from the rung before: 40 s and 6 GB here, and the next far more
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


@dataclass
class Ladder:
    """What was tried, in order, and the one that is enough (or the last, where none is)."""

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
        """Whether the estimate is under the tolerance."""
        return self.estimate is not None and self.estimate.worst <= self.tolerance

    @property
    def seconds(self) -> float:
        """What all of them cost together."""
        return sum(each.seconds for each in self.tried)

    def add(self, solved: Answer, estimate: Estimate | None, why: str) -> None:
        """Note a rung; no estimate: nothing to judge it by."""
        self.tried.append(
            TriedModel(
                solved.model.name,
                2 if solved.model.dimension == "plane strain" else 3,
                solved.dofs,
                solved.contact_nodes,
                solved.total,
                None if estimate is None else dict(estimate.by_quantity),
                why,
            )
        )


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
        beyond = [each for each in left if now.dofs * (scale / each) ** GROWTH > most_dofs]
        if beyond:
            ladder.why_ended = (
                f"the next one would have about {now.dofs * (scale / beyond[0]) ** GROWTH:.0f} "
                f"equations, over the ladder's {most_dofs:.0f}"
            )
        left = left[: len(left) - len(beyond)]
        # A size that promises too little is not tried.
        while len(left) > 1 and estimate.refined(scale / left[0]).worst > _AIM * tolerance:
            left.pop(0)
        before, coarser = now, scale
    ladder.why_ended = ladder.why_ended or "no finer size is on the ladder"
    return ladder


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
    return [Fault("--tolerance", tolerance, bound, "choose one in between")]


def _section(
    ladder: Ladder, design: Design, scene: Scene, space: Answer, solver: Solve, report: Report
) -> tuple[Answer, Estimate] | None:
    """Plane strain where it may do, refined until its own error is a small part of the tolerance,
    and that error; None where the coarse finger in space is too far from it."""
    report("plane strain")
    formulas = analytic_readings(design, scene)
    if formulas is not None:
        off = difference(formulas, space.readings)
        words = (
            f"off by {percent(off.worst)} ({WORDS[off.worst_quantity]}) from the coarse finger in "
            "space; reported, never taken"
        )
        ladder.tried.append(TriedModel(NAME, 2, 0, 0, 0.0, dict(off.by_quantity), words))
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


# From the ladder's choice to what an analysis goes on with: its case, model, zone and words.


@dataclass(frozen=True)
class Choice:
    """The case as it is modelled, condensed, with the zone that it needed and why it was chosen.

    summary: of the ladder that chose it; None where none did.
    """

    case: Case
    model: FiniteElementModel
    zone: Zone
    notes: list[str]
    summary: LadderSummary | None = None


def choose(case: Case, scene: Scene, zone: Zone, clock: Clock, report: Report) -> Choice:
    """Climb the ladder for a case of fidelity "auto"; all that it tries is on ``clock``.

    Raises FingerDesignError where a model fails.
    """
    in_turn = InTurn(zone)

    def solver(design: Design, path: Scene, model: Model) -> Answer:
        solved = in_turn(design, path, model)
        clock.add(solved.seconds)
        return solved

    ladder = climb(case.design, scene, case.tolerance, solver, report)
    chosen = ladder.chosen
    if not isinstance(chosen, Solved) or chosen.built is None:
        raise SolverError("the ladder's choice holds no model")
    fidelity = "plane-strain" if chosen.model.dimension == "plane strain" else "3d"
    summary = LadderSummary(
        tolerance=ladder.tolerance,
        reached=ladder.reached,
        chosen=chosen.model.name,
        error_estimates={} if ladder.estimate is None else dict(ladder.estimate.by_quantity),
        why_ended="" if ladder.reached else ladder.why_ended,
        models=tuple(ladder.tried),
    )
    notes = [f"chosen by --fidelity auto among {len(ladder.tried)}: {ladder.tried[-1].why}"]
    if not scene.path.mirrors_in_z:
        notes.append("the force along z and the twist moment have no error estimate of their own")
    own = replace(case, design=chosen.design, fidelity=fidelity)
    return Choice(own, chosen.built, chosen.zone, notes, summary)
