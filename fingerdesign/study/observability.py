"""What a design's gages can tell of the stick ratio: how well, with how few, and which.

    found = observe(design, noise=0.5)
    found.count(5).stick_error, found.advice

Grips are those that the regulator's estimator is taught on (teach.py), on the plane-strain model
that grips run on, in three parts: taught, chosen by, judged. Gages are ranked by a quick learner on
the second part; a few counts are confirmed by a network on the third, which nothing was taught on
or chosen by. What forces and moves tell without any gage stands beside it: gages are worth what
they take off that. Errors are of stick ratio and of ``used`` = F_t / (mu F_n), root mean squares.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.contact.increment import ContactState, solve_increment
from fingerdesign.contact.measures import measure
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.progress import Tell
from fingerdesign.study.grip_paths import Wandering
from fingerdesign.study.observability_floor import floors
from fingerdesign.study.observability_heard import LEAST_GRIPS, Heard, hear_all
from fingerdesign.study.observability_learn import (
    Errors,
    Network,
    QuickLearner,
    ends_as_meant,
    judged_errors,
    teach_network,
)
from fingerdesign.study.observability_record import (
    Count,
    Dead,
    Gage,
    Layout,
    NoiseLevel,
    Observability,
    Pressing,
)
from fingerdesign.study.observability_search import Elimination, Kept, eliminate, layouts
from fingerdesign.study.teach import REFERENCE_NOISE, Settings, finger_curves, wanderings

if TYPE_CHECKING:
    from fingerdesign.control.estimator import FingerCurves
    from fingerdesign.design.schema import Design


GRIPS = 600
MOST_NOISE = 1e3  # microstrain
MOST_GRIPS = 100_000  # as many as an estimator may be taught on
_FEW = (5, 4, 3, 2)
_LEVELS = (0.0, 0.008, 0.04, 0.2, 1.0, 4.0, 20.0)  # times the noise asked for
_PRESSED = (0.1, 0.3, 1.0)  # of the stage's way


@dataclass(frozen=True)
class _Work:
    hearings: tuple[Heard, ...]  # of the same grips, each with noise of its own
    curves: FingerCurves
    learner: QuickLearner
    elimination: Elimination
    pool: ThreadPoolExecutor
    tell: Tell

    @property
    def heard(self) -> Heard:
        return self.hearings[0]


def refuse(design: Design, noise: float, grips: int) -> None:
    """DesignError with every fault of what is asked, before any work."""
    from fingerdesign.case import gage_array

    faults = []
    gages = len(gage_array(design))
    if gages < 2:
        remedy = "add plates along x: with fewer there is no choice to judge"
        faults.append(Fault("gages in the array along x", gages, "at least 2", remedy))
    faults += option_faults(noise, grips)
    if faults:
        raise DesignError(faults, design.design.name)


def option_faults(noise: float, grips: int) -> list[Fault]:
    """What is wrong with a noise (microstrain) and a number of grips."""
    faults = []
    if not 0.0 <= noise <= MOST_NOISE:  # NaN too
        bound = f"from 0 to {MOST_NOISE:g} microstrain"
        faults.append(Fault("noise", noise, bound, "give the deviation of one sample of a gage"))
    if not LEAST_GRIPS <= grips <= MOST_GRIPS:
        bound = f"from {LEAST_GRIPS} to {MOST_GRIPS}"
        faults.append(Fault("grips", grips, bound, f"{GRIPS} are enough"))
    return faults


def observe(
    design: Design,
    noise: float = REFERENCE_NOISE,
    grips: int = GRIPS,
    tell: Tell = lambda message: None,
    workers: int = 1,
) -> Observability:
    """The study of a design at a gage noise, microstrain. workers: processes, then threads.

    Raises DesignError for fewer than 2 gages or an impossible noise, and what
    :func:`grip_model.grip_problem` and :func:`teach.wanderings` raise.
    """
    from fingerdesign.case import gage_array
    from fingerdesign.design.digest import content_digest
    from fingerdesign.study.grip_model import grip_problem
    from fingerdesign.study.lessons import settings_of

    refuse(design, noise, grips)
    start = time.perf_counter()
    problem = grip_problem(design, tell=tell)
    settings = replace(settings_of(design), grips=grips)
    made = wanderings(problem, settings, tell, workers)
    found = observe_grips(problem, settings, made, noise, tell, workers)
    return replace(
        found,
        design=design.design.name,
        digest=content_digest(design),
        gages=tuple(
            replace(each, plate=plate)
            for each, plate in zip(found.gages, gage_array(design), strict=True)
        ),
        seconds=time.perf_counter() - start,
    )


def observe_grips(
    problem: ContactProblem,
    settings: Settings,
    grips: Sequence[Wandering],
    noise: float = REFERENCE_NOISE,
    tell: Tell = lambda message: None,
    workers: int = 1,
) -> Observability:
    """The same of a model and grips that have been made; plates are numbered from 0."""
    from threadpoolctl import threadpool_limits

    faults = option_faults(noise, len(grips))
    if len(problem.model.gage_x) < 2:
        faults.append(Fault("gages", len(problem.model.gage_x), "at least 2", "add gages"))
    if faults:
        raise DesignError(faults)
    start = time.perf_counter()
    tell(f"hearing {len(grips)} grips")
    curves = finger_curves(problem, settings.face, settings.max_approach)
    heard = hear_all(grips, curves, settings, noise, silent=True)
    hearings = heard, hear_all(grips, curves, settings, noise, hearing=1)
    with threadpool_limits(1), ends_as_meant(), ThreadPoolExecutor(max(workers, 1)) as pool:
        learner = QuickLearner(heard, settings.seed)
        elimination = eliminate(learner, heard.gages, pool, tell)
        work = _Work(hearings, curves, learner, elimination, pool, tell)
        levels = _noise_levels(work, settings, grips, noise)
        tried, best = _layouts(work, problem)
        counts, whole = _counts(work, settings, best)
        gages = _gages(work, problem, whole)
        dead = _dead(work, settings, gages, whole)
    pressings = _pressings(problem, settings.max_approach)
    forces = [each.normal_force_N for each in pressings]
    return Observability(
        noise=noise,
        grips=len(grips),
        samples=len(heard.inputs),
        seed=settings.seed,
        gages=gages,
        counts=counts,
        layouts=tried,
        noises=levels,
        pressings=pressings,
        floors=floors(problem, settings.face, forces, noise, tell),
        dead=dead,
        seconds=time.perf_counter() - start,
    )


def _layouts(work: _Work, problem: ContactProblem) -> tuple[tuple[Layout, ...], dict[int, Kept]]:
    """Ways of placing few gages, and the best by number; all gages, half and none among these."""
    gages, own = work.heard.gages, work.elimination
    tried: list[Layout] = []
    best: dict[int, Kept] = {gages: tuple(range(gages))}
    for count in sorted({(gages + 1) // 2, *_FEW}, reverse=True):
        if count >= gages:
            continue
        work.tell(f"trying layouts of {count} gages")
        named = {"searched": own.counts[count]} if count in own.counts else {}
        named |= {k: v for k, v in layouts(problem.model.gage_x, count).items() if len(v) == count}
        found = list(work.pool.map(work.learner.errors, named.values()))
        tried += [
            Layout(name, kept, each.stick, each.used)
            for (name, kept), each in zip(named.items(), found, strict=True)
        ]
        best[count] = list(named.values())[int(np.argmin([each.both for each in found]))]
    return tuple(tried), {**best, 0: ()}


def _counts(
    work: _Work, settings: Settings, best: dict[int, Kept]
) -> tuple[tuple[Count, ...], Network]:
    heard = work.heard

    def teach(kept: Kept) -> tuple[Network, Errors]:
        network = teach_network(work.hearings, kept, settings.seed)
        found = judged_errors(network, heard)
        work.tell(f"taught a network with {len(kept)} gages")
        return network, found

    taught = dict(zip(best, work.pool.map(teach, best.values()), strict=True))
    sets = {**work.elimination.counts, **best}
    counts = []
    for count in sorted(sets, reverse=True):
        kept = sets[count]
        quick = work.elimination.sets.get(kept) or work.learner.errors(kept)
        found = taught[count][1] if count in taught else None
        counts.append(
            Count(
                kept,
                quick.stick,
                quick.used,
                None if found is None else found.stick,
                None if found is None else found.used,
                None if found is None else found.stick_spread,
            )
        )
    return tuple(counts), taught[heard.gages][0]


def _gages(work: _Work, problem: ContactProblem, whole: Network) -> tuple[Gage, ...]:
    heard, own = work.heard, work.elimination
    all_of_them = own.sets[tuple(range(heard.gages))]
    alive = judged_errors(whole, heard)
    found = []
    for k, x in enumerate(problem.model.gage_x):
        dead = judged_errors(whole, heard, heard.with_dead(k))
        found.append(
            Gage(
                plate=k,
                x_mm=float(x),
                response_microstrain_per_N=float(np.abs(work.curves.sticking[:, k]).max()),
                rank=heard.gages - own.order.index(k),
                untold_stick_cost=dead.stick - alive.stick,
                untold_used_cost=dead.used - alive.used,
                told_stick_cost=own.without[k].stick - all_of_them.stick,
                told_used_cost=own.without[k].used - all_of_them.used,
            )
        )
    return tuple(found)


def _dead(work: _Work, settings: Settings, gages: Sequence[Gage], whole: Network) -> Dead:
    """What the gage costs that is missed most when it reads 0 unnoticed, and when it is known."""
    heard = work.heard
    worst = int(np.argmax([each.untold_stick_cost for each in gages]))
    work.tell("teaching a network without the gage that is missed most")
    rest = [k for k in range(heard.gages) if k != worst]
    told = judged_errors(teach_network(work.hearings, rest, settings.seed), heard)
    alive = judged_errors(whole, heard).stick
    return Dead(worst, alive, alive + gages[worst].untold_stick_cost, told.stick)


def _noise_levels(
    work: _Work, settings: Settings, grips: Sequence[Wandering], noise: float
) -> tuple[NoiseLevel, ...]:
    """All gages by noise, by the quick learner; the noise asked for is among them."""
    every = tuple(range(work.heard.gages))
    unit = noise if noise > 0.0 else REFERENCE_NOISE
    found = []
    for share in _LEVELS:
        level = share * unit
        work.tell(f"hearing at {level:g} microstrain")
        if level == noise:
            errors = work.elimination.sets[every]
        else:
            heard = hear_all(grips, work.curves, settings, level)
            errors = QuickLearner(heard, settings.seed).errors(every)
        found.append(NoiseLevel(level, errors.stick, errors.used))
    return tuple(found)


def _pressings(problem: ContactProblem, max_approach: float) -> tuple[Pressing, ...]:
    state, found = ContactState.untouched(problem), []
    for share in _PRESSED:
        increment = solve_increment(problem, state, Motion(share * max_approach, 0.0))
        state = increment.state
        told = measure(problem, increment)
        found.append(Pressing(told.normal_force, 0.5 * told.contact_width))
    return tuple(found)
