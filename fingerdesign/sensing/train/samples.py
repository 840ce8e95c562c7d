"""Samples of grips: features and truths with a rig's noise, gains and failing gages upon them."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.contact.turning import turn_radius
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.features import LEAST_FORCE, FingerCurves, Moment, feature_rows
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.signals import Sample
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.streams import stream
from fingerdesign.sensing.train.paths import PART, RandomGripPath, Settings, drawn_evenly

_RADII = 8  # The turn radius is computed at so many depths.
GAIN_STD = 0.01  # The standard deviation of the gages' gains, drawn again for each replicate.
_FAILURES = 0.5  # One gage fails in this fraction of the grips.


def finger_curves(problem: ContactProblem, face: str, bounds: Bounds) -> FingerCurves:
    """Measure what the finger's own bench would show without noise; see FingerCurves."""
    found = calibrate(lambda: CondensedPlant(problem, face), problem.model.gage_x, bounds)
    return FingerCurves.of(found)


def with_turn_radius(
    curves: FingerCurves, problem: ContactProblem, settings: Settings
) -> FingerCurves:
    """The curves with the turn radius of a whole finger in 3-D; unchanged for a section, half a
    finger, and a rig whose cell measures no torque."""
    whole = problem.model.dimension == 3 and problem.model.symmetry_factor == 1
    if settings.torque_noise is None or not whole:
        return curves
    depths = np.geomspace(settings.bounds.preload, settings.bounds.max_approach, _RADII)
    radii = [turn_radius(problem, float(each)) for each in depths]
    return replace(curves, turn_radius=np.interp(curves.approach, depths, radii))


def sample_grips(
    grips: Sequence[RandomGripPath],
    curves: FingerCurves,
    settings: Settings,
    noises: tuple[float, float],
    workers: int = 1,
) -> tuple[Array, Array, Array]:
    """Sample all grips, each with a noise drawn evenly in its logarithm between two; in some of
    them a gage fails. The same for any number of worker processes.

    Returns features (n, f), truths (n, 2), and weights (n,): one over the grip's friction
    coefficient. The same error of the friction utilisation costs more on a smooth object, which
    needs more force: weighted, 383 of 400 lifts with all faults are good, and 370 without.
    """
    parts = [(k, grips[k : k + PART]) for k in range(0, len(grips), PART)]
    own = (curves, settings, noises)
    with Pool(workers, shared=own) if workers > 1 else nullcontext() as pool:
        here = (_sampled_part(*own, *each) for each in parts)
        found = list(pool.in_order(_sampled_part, parts) if pool else here)
    inputs, truths, weights = map(np.concatenate, zip(*found, strict=True))
    return inputs, truths, weights


def _sampled_part(
    curves: FingerCurves,
    settings: Settings,
    noises: tuple[float, float],
    first: int,
    grips: Sequence[RandomGripPath],
) -> tuple[Array, Array, Array]:
    """Sample some grips, numbered from ``first``, each replicate from its own seed."""
    least, most = noises
    found = []
    for number, own in enumerate(grips, first):
        for replicate in range(settings.replicates):
            words = f"{least:g} to {most:g}"
            rng = stream(settings.seed, "noise of a training", words, number, replicate)
            noise = drawn_evenly(rng, least, most)
            grip = _with_failing_gage(own, rng) if rng.uniform() < _FAILURES else own
            inputs, truths = sample(grip, curves, settings, rng, noise)
            weights = np.full(len(inputs), 1.0 / grip.friction_coefficient)
            found.append((inputs, truths, weights))
    inputs, truths, weights = map(np.concatenate, zip(*found, strict=True))
    return inputs, truths, weights


def _with_failing_gage(grip: RandomGripPath, rng: np.random.Generator) -> RandomGripPath:
    """The same grip; from some moment on one of the gages reads 0.

    Gages that fail earlier, also while the behaviour policy grips, make estimates more exact (their
    friction utilisation by a tenth) and surer of themselves: of 450 lifts of film_tees with all
    faults 427 are good then, and 438 with the estimator that ships.
    """
    gages = len(grip.moments[0].sample.readings)
    one, since = rng.integers(gages), rng.integers(len(grip.moments))
    alive = np.arange(gages) != one
    dead = (
        replace(each, sample=replace(each.sample, readings=alive * each.sample.readings))
        for each in grip.moments[since:]
    )
    return replace(grip, moments=(*grip.moments[:since], *dead))


def sample(
    grip: RandomGripPath,
    curves: FingerCurves,
    settings: Settings,
    rng: np.random.Generator,
    noise: float,
) -> tuple[Array, Array]:
    """Features (k, f) and truths (k, 2), stick ratio and friction utilisation, of a noisy grip.

    noise: standard deviation of a gage's sample, microstrain.
    """
    gains = 1.0 + GAIN_STD * rng.standard_normal(len(grip.moments[0].sample.readings))
    history = [_noisy(each, noise, gains, settings, rng) for each in grip.moments]
    own = (grip.curves or curves).turning_as(curves)
    # A rig measures the curves through its own gages, so they have the same gains.
    own = replace(own, pressed=gains * own.pressed, sticking=gains * own.sticking)
    rows, truths = [], []
    for k, truth in enumerate(grip.truths):
        if k > 0 and truth.stick_ratio is not None and truth.normal_force >= 2.0 * LEAST_FORCE:
            rows.append(k)
            truths.append([truth.stick_ratio, grip.friction_utilisation[k]])
    inputs = feature_rows(history, own, noise, np.array(rows, dtype=int))
    return inputs, np.array(truths).reshape(-1, 2)


def _noisy(
    moment: Moment, noise: float, gains: Array, settings: Settings, rng: np.random.Generator
) -> Moment:
    sample, torque = moment.sample, moment.sample.torque
    readings = gains * sample.readings + noise * rng.standard_normal(len(gains))
    normal, tangential = (settings.force_noise * rng.standard_normal(2)).tolist()
    if torque is not None:
        own = settings.torque_noise
        torque = None if own is None else torque + own * float(rng.standard_normal())
    forces = sample.normal_force + normal, sample.tangential_force + tangential
    return replace(moment, sample=Sample(readings, *forces, sample.lifted, torque))
