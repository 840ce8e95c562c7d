"""Training of a design's estimator: random grip paths on its model, noise, a small network.

Every grip is sampled at several noises, so that one network serves several amplifiers. Errors are
those on held-out grips, and so on other friction coefficients: grips of other fingers, where many
perturbed fingers share the grips; other grips of the same finger, where there is one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import starmap

import numpy as np

from fingerdesign.analysis.detection import REFERENCE_NOISE
from fingerdesign.arrays import Array
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.errors import SolverError
from fingerdesign.runtime.progress import Report
from fingerdesign.runtime.streams import stream
from fingerdesign.sensing.train.network import fit_band
from fingerdesign.sensing.train.paths import RandomGripPath, Settings, random_grip_paths
from fingerdesign.sensing.train.samples import finger_curves, sample, sample_grips, with_turn_radius

# Each band of gage noise, microstrain, has a network. A common one has errors that are a sixth
# larger in the lower band.
BANDS = ((0.25, 1.6), (1.6, 15.0))
NOISES = (0.5, 1.0, 2.0, 5.0, 10.0)  # The gage noises at which errors are measured, microstrain.
_HELD_OUT = 0.15  # This fraction of the grips is held out, of whole fingers where there are many.
_EDGES, _LEAST_STD = 12, 1e-3  # Parts of the table of standard deviations, and its least value.
_LEAST_SAMPLES = 10  # Training needs so many samples for each feature.


@dataclass(frozen=True)
class TrainingResult:
    """The estimator and its errors (root mean square) on held-out grips, by noise.

    judged_grips: the number of held-out grips; judged_fingers: the number of their fingers, 0 where
    they are other grips of the training fingers.
    """

    estimator: GripEstimator
    noises_microstrain: tuple[float, ...]
    stick_errors: tuple[float, ...]
    friction_utilisation_errors: tuple[float, ...]
    samples: int
    judged_grips: int
    judged_fingers: int


def train_estimator(
    problem: ContactProblem,
    design: str,
    settings: Settings,
    report: Report = lambda message: None,
    grips: Sequence[RandomGripPath] | None = None,
    workers: int = 1,
    bands: Sequence[tuple[float, float]] = BANDS,
) -> TrainingResult:
    """Train the networks. design: the content digest that the estimator is for; grips: used instead
    of random grip paths on the problem, those of one finger together and sharing their curves; the
    first are held out. A finger with held-out grips and training grips is no test finger, unless
    there is no other. bands: of noise, a network each.

    Raises SolverError where the model gives too few samples.
    """
    if grips is None:
        grips = random_grip_paths(problem, settings, report, workers)
    count = max(1, round(_HELD_OUT * len(grips)))
    held_out, training = grips[:count], grips[count:]
    own = finger_curves(problem, settings.face, settings.bounds)
    curves = with_turn_radius(own, problem, settings)
    jobs = []
    for noises in bands:
        inputs, outputs, weights = sample_grips(training, curves, settings, noises, workers)
        if len(inputs) < _LEAST_SAMPLES * inputs.shape[1]:
            raise SolverError(
                f"{len(inputs)} samples are too few to train {inputs.shape[1]} features: more "
                "grips, or a longer travel of the stage (grip.max_approach_mm)"
            )
        report(f"training on {len(inputs)} samples with noise up to {noises[1]:g} microstrain")
        seed, fingers, replicates = settings.seed, settings.fingers, settings.replicates
        jobs.append((inputs, outputs, weights, noises[1], seed, fingers, replicates))
    # In this process alone: another one adds up in another order, and the last digits differ.
    networks = tuple(starmap(fit_band, jobs))
    samples = sum(len(job[0]) for job in jobs)
    estimator = GripEstimator(design, curves, REFERENCE_NOISE, networks)
    known = {id(each.curves) for each in training}
    others = [each for each in held_out if id(each.curves) not in known]
    fingers = len({id(each.curves) for each in others})
    return _measure_errors(estimator, others or held_out, settings, samples, fingers)


def _measure_errors(
    estimator: GripEstimator,
    grips: Sequence[RandomGripPath],
    settings: Settings,
    samples: int,
    fingers: int,
) -> TrainingResult:
    """Measure errors on held-out grips by noise, and give each band its standard deviations, over
    all of its noises: the predicted error knows the noise."""
    stick, utilisation = [], []
    found: dict[float, list[tuple[Array, Array]]] = {}
    for noise in NOISES:
        rng = stream(settings.seed, "noise of held-out grips", f"{noise:g}")
        sampled = [sample(each, estimator.curves, settings, rng, noise) for each in grips]
        truths = np.concatenate([each[1] for each in sampled])
        band = estimator.at_noise(noise).band
        outputs = band.evaluate(np.concatenate([each[0] for each in sampled]))
        off = np.clip(outputs[:, :2], 0.0, 1.0) - truths
        stick.append(float(np.sqrt((off[:, 0] ** 2).mean())))
        utilisation.append(float(np.sqrt((off[:, 1] ** 2).mean())))
        if noise <= band.most_noise:
            found.setdefault(band.most_noise, []).append((outputs[:, 2], off[:, 1]))
    bands = []
    for each in estimator.bands:
        spread = _std_table(*map(np.concatenate, zip(*found[each.most_noise], strict=True)))
        bands.append(replace(each, spread=spread))
    estimator = replace(estimator, bands=tuple(bands))
    errors = tuple(stick), tuple(utilisation)
    return TrainingResult(estimator, NOISES, *errors, samples, len(grips), fingers)


def _std_table(predicted_error: Array, off: Array) -> Array:
    """Standard deviations (k, 2) of the friction utilisation by its predicted error: upper edges of
    parts with equally many cases, and the root mean square error of each part."""
    order = np.argsort(predicted_error)
    parts = np.array_split(order, min(_EDGES, len(order)))
    rows = np.array(
        [[predicted_error[each[-1]], np.sqrt((off[each] ** 2).mean())] for each in parts]
    )
    return np.asarray(np.maximum(rows, _LEAST_STD))
