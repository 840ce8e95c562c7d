"""The information of a design's gages about the stick ratio: how much, with how few, and which.

    found = observe(design, noise=0.5)
    found.count(5).stick_error, found.advice

Grips are those that the regulator's estimator is trained on (sensing/train), on the model that
grips run on, in three parts: for training, for choosing, for testing. Gages are ranked by a quick
learner on the second part; a few counts are confirmed by a network on the third. The error without
gages, from forces and moves alone, is given too: the worth of gages is what they take off it.
Errors are root mean squares of the stick ratio and of the friction utilisation F_t / (mu F_n).
"""

import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.analysis.detection import REFERENCE_NOISE
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.control.features import FingerCurves
from fingerdesign.design.digest import content_digest
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing import model
from fingerdesign.sensing.train.network import without_convergence_warnings
from fingerdesign.sensing.train.paths import RandomGripPath, Settings, random_grip_paths
from fingerdesign.sensing.train.result import settings_of
from fingerdesign.sensing.train.samples import finger_curves
from fingerdesign.validate.gages.learners import (
    LEAST_GRIPS,
    Errors,
    Network,
    QuickLearner,
    Samples,
    network_errors,
    sample_all,
    train_network,
)
from fingerdesign.validate.gages.ranking import Chosen, Elimination, eliminate, floors, layouts
from fingerdesign.validate.gages.record import (
    Count,
    Dead,
    Gage,
    Layout,
    NoiseLevel,
    Observability,
    Pressing,
)

GRIPS = 600
MOST_NOISE = 1e3  # microstrain
MOST_GRIPS = 100_000  # An estimator is trained on no more either.
_FEW = (5, 4, 3, 2)
_LEVELS = (0.0, 0.008, 0.04, 0.2, 1.0, 4.0, 20.0)  # Noises to try, over the requested one.
_DEPTHS = (0.1, 0.3, 1.0)  # Depths of the pressings, over the stage's travel.


@dataclass(frozen=True)
class _Work:
    """Objects that the steps of a study share; replicates: the same grips with other noise."""

    problem: ContactProblem
    settings: Settings
    replicates: tuple[Samples, ...]
    curves: FingerCurves
    learner: QuickLearner
    elimination: Elimination
    pool: ThreadPoolExecutor
    report: Report

    @property
    def sampled(self) -> Samples:
        return self.replicates[0]


def refuse(design: Design, noise: float, grips: int) -> None:
    """Raise a DesignError with every fault of the request, before any work."""
    faults = []
    gages = len(gage_array(design))
    if gages < 2:
        remedy = "add plates along x: with fewer there is no choice of gages"
        faults.append(Fault("gages in the array along x", gages, "at least 2", remedy))
    if not 0.0 <= noise <= MOST_NOISE:  # NaN fails this test too.
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
    """Study a design at a gage noise, microstrain. workers: processes, then threads.

    Raises DesignError for fewer than 2 gages or an impossible noise, and what
    :func:`grip_problem` and :func:`random_grip_paths` raise.
    """
    refuse(design, noise, grips)
    start = time.perf_counter()
    problem = model.grip_problem(design, fidelity, report=report)
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
    """Study a model by grips that exist; plates are numbered from 0."""
    from threadpoolctl import threadpool_limits

    start = time.perf_counter()
    report(f"sampling {len(grips)} grips")
    curves = finger_curves(problem, settings.face, settings.bounds)
    sampled = sample_all(grips, curves, settings, noise, silent=True)
    replicates = sampled, sample_all(grips, curves, settings, noise, replicate=1)
    quiet = without_convergence_warnings()
    with threadpool_limits(1), quiet, ThreadPoolExecutor(max(workers, 1)) as pool:
        learner = QuickLearner(sampled, settings.seed)
        elimination = eliminate(learner, sampled.gages, pool, report)
        work = _Work(problem, settings, replicates, curves, learner, elimination, pool, report)
        levels = _noise_levels(work, grips, noise)
        tried, best = _layouts(work)
        counts, whole = _counts(work, best)
        gages = _gages(work, whole)
        dead = _dead(work, gages, whole)
    motions = [Motion(depth * settings.bounds.max_approach, 0.0) for depth in _DEPTHS]
    pressed = [step.measures for step in follow(problem, motions)]
    forces = [each.normal_force for each in pressed]
    return Observability(
        noise=noise,
        grips=len(grips),
        samples=len(sampled.inputs),
        seed=settings.seed,
        gages=gages,
        counts=counts,
        layouts=tried,
        noises=levels,
        pressings=tuple(Pressing(m.normal_force, 0.5 * m.contact_width) for m in pressed),
        floors=floors(problem, settings.face, forces, noise, report),
        dead=dead,
        seconds=time.perf_counter() - start,
    )


def _layouts(work: _Work) -> tuple[tuple[Layout, ...], dict[int, Chosen]]:
    """Try layouts of few gages; the best by number, with all gages, half and none among these."""
    gages, own = work.sampled.gages, work.elimination
    tried: list[Layout] = []
    best: dict[int, Chosen] = {gages: tuple(range(gages))}
    for count in sorted({(gages + 1) // 2, *_FEW}, reverse=True):
        if count >= gages:
            continue
        work.report(f"trying layouts of {count} gages")
        named = {"searched": own.counts[count]} if count in own.counts else {}
        placed = layouts(work.problem.model.gage_centres_x, count)
        named |= {k: v for k, v in placed.items() if len(v) == count}
        found = list(work.pool.map(work.learner.errors, named.values()))
        tried += [
            Layout(name, chosen, each.stick, each.utilisation)
            for (name, chosen), each in zip(named.items(), found, strict=True)
        ]
        best[count] = list(named.values())[int(np.argmin([each.both for each in found]))]
    return tuple(tried), {**best, 0: ()}


def _counts(work: _Work, best: dict[int, Chosen]) -> tuple[tuple[Count, ...], Network]:
    """Errors by number of gages, the best layouts confirmed by networks; the network of all."""

    def confirm(chosen: Chosen) -> tuple[Network, Errors]:
        network = train_network(work.replicates, chosen, work.settings.seed)
        found = network_errors(network, work.sampled)
        work.report(f"trained a network with {len(chosen)} gages")
        return network, found

    confirmed = dict(zip(best, work.pool.map(confirm, best.values()), strict=True))
    sets = {**work.elimination.counts, **best}
    counts = []
    for count in sorted(sets, reverse=True):
        chosen = sets[count]
        quick = work.elimination.sets.get(chosen) or work.learner.errors(chosen)
        found = confirmed[count][1] if count in confirmed else None
        known = (found.stick, found.utilisation, found.stick_std) if found else (None, None, None)
        counts.append(Count(chosen, quick.stick, quick.utilisation, *known))
    return tuple(counts), confirmed[work.sampled.gages][0]


def _gages(work: _Work, whole: Network) -> tuple[Gage, ...]:
    """Rank of each gage, and the cost of its failure."""
    sampled, own = work.sampled, work.elimination
    every = own.sets[tuple(range(sampled.gages))]
    alive = network_errors(whole, sampled)
    found = []
    for k, x in enumerate(work.problem.model.gage_centres_x):
        dead = network_errors(whole, sampled, sampled.with_dead(k))
        found.append(
            Gage(
                plate=k,
                x_mm=float(x),
                response_microstrain_per_N=float(np.abs(work.curves.sticking[:, k]).max()),
                rank=sampled.gages - own.order.index(k),
                unnoticed_stick_cost=dead.stick - alive.stick,
                unnoticed_friction_utilisation_cost=dead.utilisation - alive.utilisation,
                known_stick_cost=own.without[k].stick - every.stick,
                known_friction_utilisation_cost=own.without[k].utilisation - every.utilisation,
            )
        )
    return tuple(found)


def _dead(work: _Work, gages: Sequence[Gage], whole: Network) -> Dead:
    """The cost of the most important gage: when it reads 0 unnoticed, and when that is known."""
    sampled = work.sampled
    worst = int(np.argmax([each.unnoticed_stick_cost for each in gages]))
    work.report("training a network without the most important gage")
    rest = [k for k in range(sampled.gages) if k != worst]
    known = network_errors(train_network(work.replicates, rest, work.settings.seed), sampled)
    alive = network_errors(whole, sampled).stick
    return Dead(worst, alive, alive + gages[worst].unnoticed_stick_cost, known.stick)


def _noise_levels(
    work: _Work, grips: Sequence[RandomGripPath], noise: float
) -> tuple[NoiseLevel, ...]:
    """Errors with all gages by noise, by the quick learner; the requested noise is among them."""
    every = tuple(range(work.sampled.gages))
    unit = noise if noise > 0.0 else REFERENCE_NOISE
    found = []
    for factor in _LEVELS:
        level = factor * unit
        work.report(f"sampling at {level:g} microstrain")
        if level == noise:
            errors = work.elimination.sets[every]
        else:
            sampled = sample_all(grips, work.curves, work.settings, level)
            errors = QuickLearner(sampled, work.settings.seed).errors(every)
        found.append(NoiseLevel(level, errors.stick, errors.utilisation))
    return tuple(found)
