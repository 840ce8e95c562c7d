"""What a design's gages can tell of the stick ratio: how well, with how few, and which.

    found = observe(design, noise=0.5)
    found.count(5).stick_error, found.advice

Grips are those that the regulator's estimator is taught on (teach.py), on the plane-strain model
that grips run on, in three parts: taught, chosen by, judged. Gages are ranked by a quick learner on
the second part; a few counts are confirmed by a network on the third, which nothing was taught on
or chosen by. What forces and moves tell without any gage stands beside it: gages are worth what
they take off that. Errors are of stick ratio and of ``used`` = F_t / (mu F_n), root mean squares.
"""

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.analysis.detection import REFERENCE_NOISE, stick_changes
from fingerdesign.arrays import Array
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.control.estimator import LAGS, FingerCurves
from fingerdesign.design.digest import content_digest
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.train.estimator import (
    RandomGripPath,
    Settings,
    ends_as_meant,
    finger_curves,
    random_grip_paths,
)
from fingerdesign.validate.gages.learners import (
    LEAST_GRIPS,
    Errors,
    Network,
    QuickLearner,
    Samples,
    judged_errors,
    sample_all,
    teach_network,
)
from fingerdesign.validate.gages.record import (
    Count,
    Dead,
    Floor,
    Gage,
    Layout,
    NoiseLevel,
    Observability,
    Pressing,
)

# The least error that any unbiased estimate can have from the gages: Cramér and Rao's bound, by the
# change of readings with the stick ratio that analysis/detection.py finds.

WINDOW = max(LAGS) + 1  # samples that the estimator looks back on
_FRICTIONS = (0.2, 0.4, 0.8)


def floors(
    problem: ContactProblem,
    face: str,
    normal_forces: Sequence[float],
    noise: float,
    report: Callable[[str], None] = lambda message: None,
) -> tuple[Floor, ...]:
    """Medians over frictions and shares of friction in use, for each normal force (N).

    Forces at which the model finds no state are left out. Raises SolverError for silent gages.
    """
    found = []
    for normal in normal_forces:
        report(f"the least error at {normal:.3g} N")
        states = [c for mu in _FRICTIONS for c in stick_changes(problem, face, normal, mu)]
        if states:
            change = float(np.median(states))  # microstrain per unit of stick ratio
            if not change > 0.0:
                raise SolverError("no gage answers to anything: their strains are all 0")
            found.append(Floor(normal, change, noise / change, noise / change / WINDOW**0.5))
    return tuple(found)


# Which gages to keep: backward elimination, and the layouts that one would try unasked.

Kept = tuple[int, ...]

_ONE_BY_ONE = 12  # with more gages than these, two go at a time


@dataclass(frozen=True)
class Elimination:
    """Gages taken away, least missed first.

    sets: kept gages -> errors, from all to none. without: for each gage the errors of all others.
    order: gages as they went; the last is the one that is missed most.
    """

    sets: dict[Kept, Errors]
    without: tuple[Errors, ...]
    order: Kept

    @property
    def counts(self) -> dict[int, Kept]:
        """The gages that were kept, by how many."""
        return {len(kept): kept for kept in self.sets}


def eliminate(learner: QuickLearner, gages: int, pool: Executor, report: Report) -> Elimination:
    """Take away what is missed least, by refitting without each in turn."""
    kept: Kept = tuple(range(gages))
    sets = {kept: learner.errors(kept)}
    order: list[int] = []
    without: tuple[Errors, ...] = ()
    while kept:
        report(f"ranking gages: {len(kept)} left of {gages}")
        rest = [tuple(k for k in kept if k != each) for each in kept]
        found = list(pool.map(learner.errors, rest))
        without = without or tuple(found)
        cheapest = np.argsort([each.both for each in found], kind="stable")
        out = [kept[k] for k in cheapest[: 2 if len(kept) > _ONE_BY_ONE else 1]]
        order += out
        kept = tuple(k for k in kept if k not in out)
        known = dict(zip(rest, found, strict=True))
        sets[kept] = known[kept] if kept in known else learner.errors(kept)
    return Elimination(sets, without, tuple(order))


def layouts(gage_x: Array, count: int) -> dict[str, Kept]:
    """Ways of placing ``count`` of the gages at ``gage_x`` (mm) that need no search.

    "spread": evenly over the array; "middle": neighbours about x = 0; "ends": half at each end.
    """
    order = np.argsort(gage_x, kind="stable")
    rank = np.arange(len(gage_x))
    even = np.unique(np.round(np.linspace(0, len(rank) - 1, count)).astype(int))
    near = rank[np.argsort(np.abs(gage_x[order]), kind="stable")[:count]]
    ends = [*rank[: (count + 1) // 2], *rank[len(rank) - count // 2 :]]
    return {
        name: tuple(sorted(int(order[k]) for k in places))
        for name, places in (("spread", even), ("middle", near), ("ends", ends))
    }


GRIPS = 600
MOST_NOISE = 1e3  # microstrain
MOST_GRIPS = 100_000  # as many as an estimator may be taught on
_FEW = (5, 4, 3, 2)
_LEVELS = (0.0, 0.008, 0.04, 0.2, 1.0, 4.0, 20.0)  # times the noise asked for
_PRESSED = (0.1, 0.3, 1.0)  # of the stage's way


@dataclass(frozen=True)
class _Work:
    hearings: tuple[Samples, ...]  # of the same grips, each with noise of its own
    curves: FingerCurves
    learner: QuickLearner
    elimination: Elimination
    pool: ThreadPoolExecutor
    report: Report

    @property
    def sampled(self) -> Samples:
        return self.hearings[0]


def refuse(design: Design, noise: float, grips: int) -> None:
    """DesignError with every fault of what is asked, before any work."""
    faults = []
    gages = len(gage_array(design))
    if gages < 2:
        remedy = "add plates along x: with fewer there is no choice to judge"
        faults.append(Fault("gages in the array along x", gages, "at least 2", remedy))
    if not 0.0 <= noise <= MOST_NOISE:  # NaN too
        bound = f"from 0 to {MOST_NOISE:g} microstrain"
        faults.append(Fault("noise", noise, bound, "give the deviation of one sample of a gage"))
    if not LEAST_GRIPS <= grips <= MOST_GRIPS:
        bound = f"from {LEAST_GRIPS} to {MOST_GRIPS}"
        faults.append(Fault("grips", grips, bound, f"{GRIPS} are enough"))
    if faults:
        raise DesignError(faults, design.design.name)


def observe(
    design: Design,
    noise: float = REFERENCE_NOISE,
    grips: int = GRIPS,
    report: Report = lambda message: None,
    workers: int = 1,
    fidelity: str = "plane-strain",
) -> Observability:
    """The study of a design at a gage noise, microstrain. workers: processes, then threads.

    Raises DesignError for fewer than 2 gages or an impossible noise, and what
    :func:`grip_problem` and :func:`random_grip_paths` raise.
    """
    from fingerdesign.sensing.model import grip_problem
    from fingerdesign.sensing.train.result import settings_of

    refuse(design, noise, grips)
    start = time.perf_counter()
    problem = grip_problem(design, fidelity, report=report)
    settings = replace(settings_of(design), grips=grips)
    made = random_grip_paths(problem, settings, report, workers)
    found = observe_grips(problem, settings, made, noise, report, workers)
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
    grips: Sequence[RandomGripPath],
    noise: float = REFERENCE_NOISE,
    report: Report = lambda message: None,
    workers: int = 1,
) -> Observability:
    """The same of a model and grips that have been made; plates are numbered from 0."""
    from threadpoolctl import threadpool_limits

    start = time.perf_counter()
    report(f"hearing {len(grips)} grips")
    curves = finger_curves(problem, settings.face, settings.bounds)
    sampled = sample_all(grips, curves, settings, noise, silent=True)
    hearings = sampled, sample_all(grips, curves, settings, noise, hearing=1)
    with threadpool_limits(1), ends_as_meant(), ThreadPoolExecutor(max(workers, 1)) as pool:
        learner = QuickLearner(sampled, settings.seed)
        elimination = eliminate(learner, sampled.gages, pool, report)
        work = _Work(hearings, curves, learner, elimination, pool, report)
        levels = _noise_levels(work, settings, grips, noise)
        tried, best = _layouts(work, problem)
        counts, whole = _counts(work, settings, best)
        gages = _gages(work, problem, whole)
        dead = _dead(work, settings, gages, whole)
    pressings = _pressings(problem, settings.bounds.max_approach)
    forces = [each.normal_force_N for each in pressings]
    return Observability(
        noise=noise,
        grips=len(grips),
        samples=len(sampled.inputs),
        seed=settings.seed,
        gages=gages,
        counts=counts,
        layouts=tried,
        noises=levels,
        pressings=pressings,
        floors=floors(problem, settings.face, forces, noise, report),
        dead=dead,
        seconds=time.perf_counter() - start,
    )


def _layouts(work: _Work, problem: ContactProblem) -> tuple[tuple[Layout, ...], dict[int, Kept]]:
    """Ways of placing few gages, and the best by number; all gages, half and none among these."""
    gages, own = work.sampled.gages, work.elimination
    tried: list[Layout] = []
    best: dict[int, Kept] = {gages: tuple(range(gages))}
    for count in sorted({(gages + 1) // 2, *_FEW}, reverse=True):
        if count >= gages:
            continue
        work.report(f"trying layouts of {count} gages")
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
    sampled = work.sampled

    def teach(kept: Kept) -> tuple[Network, Errors]:
        network = teach_network(work.hearings, kept, settings.seed)
        found = judged_errors(network, sampled)
        work.report(f"taught a network with {len(kept)} gages")
        return network, found

    taught = dict(zip(best, work.pool.map(teach, best.values()), strict=True))
    sets = {**work.elimination.counts, **best}
    counts = []
    for count in sorted(sets, reverse=True):
        kept = sets[count]
        quick = work.elimination.sets.get(kept) or work.learner.errors(kept)
        found = taught[count][1] if count in taught else None
        known = (found.stick, found.used, found.stick_spread) if found else (None, None, None)
        counts.append(Count(kept, quick.stick, quick.used, *known))
    return tuple(counts), taught[sampled.gages][0]


def _gages(work: _Work, problem: ContactProblem, whole: Network) -> tuple[Gage, ...]:
    sampled, own = work.sampled, work.elimination
    all_of_them = own.sets[tuple(range(sampled.gages))]
    alive = judged_errors(whole, sampled)
    found = []
    for k, x in enumerate(problem.model.gage_x):
        dead = judged_errors(whole, sampled, sampled.with_dead(k))
        found.append(
            Gage(
                plate=k,
                x_mm=float(x),
                response_microstrain_per_N=float(np.abs(work.curves.sticking[:, k]).max()),
                rank=sampled.gages - own.order.index(k),
                untold_stick_cost=dead.stick - alive.stick,
                untold_used_cost=dead.used - alive.used,
                told_stick_cost=own.without[k].stick - all_of_them.stick,
                told_used_cost=own.without[k].used - all_of_them.used,
            )
        )
    return tuple(found)


def _dead(work: _Work, settings: Settings, gages: Sequence[Gage], whole: Network) -> Dead:
    """What the gage costs that is missed most when it reads 0 unnoticed, and when it is known."""
    sampled = work.sampled
    worst = int(np.argmax([each.untold_stick_cost for each in gages]))
    work.report("teaching a network without the gage that is missed most")
    rest = [k for k in range(sampled.gages) if k != worst]
    reported = judged_errors(teach_network(work.hearings, rest, settings.seed), sampled)
    alive = judged_errors(whole, sampled).stick
    return Dead(worst, alive, alive + gages[worst].untold_stick_cost, reported.stick)


def _noise_levels(
    work: _Work, settings: Settings, grips: Sequence[RandomGripPath], noise: float
) -> tuple[NoiseLevel, ...]:
    """All gages by noise, by the quick learner; the noise asked for is among them."""
    every = tuple(range(work.sampled.gages))
    unit = noise if noise > 0.0 else REFERENCE_NOISE
    found = []
    for share in _LEVELS:
        level = share * unit
        work.report(f"hearing at {level:g} microstrain")
        if level == noise:
            errors = work.elimination.sets[every]
        else:
            sampled = sample_all(grips, work.curves, settings, level)
            errors = QuickLearner(sampled, settings.seed).errors(every)
        found.append(NoiseLevel(level, errors.stick, errors.used))
    return tuple(found)


def _pressings(problem: ContactProblem, max_approach: float) -> tuple[Pressing, ...]:
    motions = [Motion(share * max_approach, 0.0) for share in _PRESSED]
    found = [step.measures for step in follow(problem, motions)]
    return tuple(Pressing(each.normal_force, 0.5 * each.contact_width) for each in found)
