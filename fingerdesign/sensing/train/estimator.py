"""Teaching a design's estimator: random grip paths on its model, noise upon them, a small network.

    result = teach(problem, design, digest)
    result.estimator.to_json(), result.stick_error

The network is scikit-learn's multilayer perceptron (a well-kept trainer; what it learns is run by
numpy alone, control/estimator.py). Every random grip path is sampled at several noises, so that one
network serves all amplifiers. Errors are on grips, and so on frictions, that are held out of it:
where many fingers are taught, on grips of other fingers, of which nothing is taught; where one is,
on other grips of that same finger.
"""

import math
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fingerdesign.analysis.detection import REFERENCE_NOISE
from fingerdesign.analysis.stages import one_thread
from fingerdesign.arrays import Array
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.estimator import (
    LEAST_FORCE,
    Band,
    FingerCurves,
    GripEstimator,
    Layer,
    Moment,
    feature_count,
    features,
    outputs_of,
    standardised,
)
from fingerdesign.control.plants.plant import CondensedPlant, Truth
from fingerdesign.errors import SolverError
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.progress import Report

# Friction is drawn evenly in its logarithm; a random grip path presses to a small force and then
# strings together what hands do: press on, pull until some share of the friction is in use, climb
# with both forces growing in some ratio, ease off. The steps are as long as a controller's. Noise
# is no part of it: it is added when the grips are sampled, as often as wanted.

FRICTIONS = (0.15, 1.0)
_PRELOAD = (0.15, 1.0)  # N
_PRESS = (0.001, 0.01)  # mm a step
_PULL = (0.02, 0.2)  # of the friction limit a step
_USED = (0.3, 1.05)  # where a pull ends
_SLOPE = (0.2, 1.3)  # dF_t / (mu dF_n) of a climb
_SOFT = 5.0  # N/mm: a finger's least stiffness against shear that is reckoned with
_SLIPS = 2  # steps of complete slip, then the grip is over
_KINDS, _SHARES = ("press", "pull", "climb", "ease"), (0.2, 0.35, 0.35, 0.1)


@dataclass(frozen=True)
class RandomGripPath:
    """One grip without noise: moments and truths, step by step, and its friction coefficient.

    curves: of its own finger, where that is not the one that is taught for.
    """

    friction_coefficient: float
    moments: tuple[Moment, ...]
    truths: tuple[Truth, ...]
    curves: FingerCurves | None = None

    @property
    def used(self) -> tuple[float, ...]:
        """F_t / (mu F_n) of each step, 0 without contact."""
        mu = self.friction_coefficient
        return tuple(
            t.tangential_force / (mu * t.normal_force) if t.normal_force > 0.0 else 0.0
            for t in self.truths
        )


def wander(
    problem: ContactProblem,
    face: str,
    rng: np.random.Generator,
    steps: int,
    max_approach: float,
) -> RandomGripPath:
    """A random grip path of ``steps`` steps, fewer where it slips or reaches ``max_approach``."""
    friction = float(np.exp(rng.uniform(*np.log(FRICTIONS))))
    plant = CondensedPlant(problem.with_friction(friction), face)
    moments: list[Moment] = []
    truths: list[Truth] = []
    slipped = 0
    for dx, dy in _moves(plant, friction, rng):
        try:
            sample = plant.move(dx, dy)
        except SolverError:
            break  # what no model can say teaches nothing; the steps before it stand
        truth = plant.truth()
        moments.append(Moment(sample, dx, dy))
        truths.append(truth)
        slipped += truth.complete_slip
        if len(moments) == steps or slipped == _SLIPS or truth.approach > max_approach:
            break
    return RandomGripPath(friction, tuple(moments), tuple(truths))


def _moves(
    plant: CondensedPlant, friction: float, rng: np.random.Generator
) -> Iterator[tuple[float, float]]:
    """Moves without end, each decided on the truth after the last."""
    preload, step = rng.uniform(*_PRELOAD), rng.uniform(*_PRESS)
    while plant.truth().normal_force < preload:
        yield 0.0, step
    stiffness = _Stiffness(plant)
    while True:
        kind = str(rng.choice(_KINDS, p=_SHARES))
        dy = float(rng.uniform(*_PRESS))
        if kind == "press":
            for _ in range(rng.integers(1, 7)):
                yield 0.0, dy
        elif kind == "pull":
            until, share = rng.uniform(*_USED), rng.uniform(*_PULL)
            for _ in range(12):
                limit = friction * plant.truth().normal_force
                if plant.truth().tangential_force >= until * limit:
                    break
                yield stiffness.motion(share * limit), 0.0
        elif kind == "climb":
            slope = float(rng.uniform(*_SLOPE)) * friction
            for _ in range(rng.integers(3, 13)):
                yield stiffness.motion(slope * stiffness.pressing * dy), dy
        else:
            for _ in range(rng.integers(1, 4)):
                limit = friction * plant.truth().normal_force
                yield -stiffness.motion(rng.uniform(0.01, 0.05) * limit), 0.0


class _Stiffness:
    """dF_t/dx and dF_n/dy, N/mm, as the last moves showed them."""

    def __init__(self, plant: CondensedPlant) -> None:
        self._plant = plant
        self._before = plant.truth()
        self._pulling = 0.0

    @property
    def pressing(self) -> float:
        truth = self._plant.truth()
        return 1.5 * truth.normal_force / max(truth.approach, 1e-6)

    def motion(self, force: float) -> float:
        """dx, mm, for so much more F_t, N."""
        now, before = self._plant.truth(), self._before
        moved = now.shear - before.shear
        if moved > 1e-6:
            self._pulling = (now.tangential_force - before.tangential_force) / moved
        self._before = now
        return force / max(self._pulling, 0.3 * self.pressing, _SOFT)


# Of a gage's sample, microstrain. One network for both errs by a sixth more in the quieter band.
BANDS = ((0.25, 1.6), (1.6, 15.0))
NOISES = (0.5, 1.0, 2.0, 5.0, 10.0)  # that training results are judged at
_STEPS = 60
_HELD_OUT = 0.15  # of the random grip paths: these, of whole fingers where there are many
_HIDDEN = (128, 64)
_TEACHING = ((2e-3, 40), (5e-4, 20), (1e-4, 15))  # learning rate, epochs; each from the last's end
# Of more samples, and where fingers are unlike, fewer epochs: else they are learnt by heart.
_ROWS, _UNLIKE = 100_000, 0.45
_PENALTY = 1e-3
_PART = 50  # grips that a worker makes at once
_EDGES, _LEAST_SPREAD = 12, 1e-3  # parts that the spread is told in
_GAIN_SPREAD = 0.01  # of the gages' gains, drawn anew for each hearing
_DYING = 0.25  # of the grips, in which one gage dies


@dataclass(frozen=True)
class Settings:
    """How much is taught. face, bounds and force_noise (N) are the rig's; fingers: among
    how many unlike ones the grips are shared out (1: the design's own model)."""

    face: str
    bounds: Bounds
    grips: int = 3000
    hearings: int = 2
    force_noise: float = 0.005
    seed: int = 0
    fingers: int = 1


@dataclass(frozen=True)
class TrainingResult:
    """The estimator and its errors (root mean square) on held-out grips, by noise.

    judged_grips: how many those are; judged_fingers: of how many fingers of which nothing was
    taught, 0 where they are other grips of what was. None: not recorded (an estimator of an earlier
    version).
    """

    estimator: GripEstimator
    noises: tuple[float, ...]
    stick_errors: tuple[float, ...]
    used_errors: tuple[float, ...]
    samples: int
    judged_grips: int | None = None
    judged_fingers: int | None = None

    def stick_error(self, noise: float = REFERENCE_NOISE) -> float:
        """Of the stick ratio at a noise that was judged. ValueError for another."""
        return self.stick_errors[self.noises.index(noise)]


def teach(
    problem: ContactProblem,
    design: str,
    settings: Settings,
    report: Report = lambda message: None,
    grips: Sequence[RandomGripPath] | None = None,
    workers: int = 1,
    bands: Sequence[tuple[float, float]] = BANDS,
) -> TrainingResult:
    """Teach the network. design: the content digest that it is for; grips: instead of random grip
    paths on the problem, those of one finger together and sharing their curves; the first are held
    out. Of a finger that is held out in part nothing is judged, unless there is no other. bands: of
    noise, a network each.

    Raises SolverError where the model gives too few grips to teach anything.
    """
    if grips is None:
        grips = random_grip_paths(problem, settings, report, workers)
    held = max(1, round(_HELD_OUT * len(grips)))
    curves = finger_curves(problem, settings.face, settings.bounds)
    taught, samples = [], 0
    for noises in bands:
        inputs, outputs = _sampled(grips[held:], curves, settings, noises)
        if len(inputs) < 10 * inputs.shape[1]:
            raise SolverError(
                f"{len(inputs)} samples teach {inputs.shape[1]} features nothing: more grips, or a "
                "longer way of the stage (grip.max_approach_mm)"
            )
        report(f"teaching {len(inputs)} samples with noise up to {noises[1]:g} microstrain")
        taught.append(fit(inputs, outputs, noises[1], settings.seed, settings.fingers))
        samples += len(inputs)
    estimator = GripEstimator(design, curves, REFERENCE_NOISE, tuple(taught))
    known = {id(each.curves) for each in grips[held:]}
    others = [each for each in grips[:held] if id(each.curves) not in known]
    fingers = len({id(each.curves) for each in others})
    return judge(estimator, others or grips[:held], settings, samples, fingers)


def _sampled(
    grips: Sequence[RandomGripPath],
    curves: FingerCurves,
    settings: Settings,
    noises: tuple[float, float],
) -> tuple[Array, Array]:
    """All grips, each with a noise drawn evenly in its logarithm between two; in some of them a
    gage dies."""
    rng, found = np.random.default_rng([settings.seed, 1]), []
    for each in [each for each in grips for _ in range(settings.hearings)]:
        noise = float(np.exp(rng.uniform(*np.log(noises))))
        heard = _dying(each, rng) if rng.uniform() < _DYING else each
        found.append(sample(heard, curves, settings, rng, noise))
    return np.concatenate([each[0] for each in found]), np.concatenate([each[1] for each in found])


def _dying(grip: RandomGripPath, rng: np.random.Generator) -> RandomGripPath:
    """The same, and from some moment on one of the gages answers to nothing."""
    gages = len(grip.moments[0].sample.readings)
    one, since = rng.integers(gages), rng.integers(len(grip.moments))
    alive = np.arange(gages) != one
    dead = (
        replace(each, sample=replace(each.sample, readings=alive * each.sample.readings))
        for each in grip.moments[since:]
    )
    return replace(grip, moments=(*grip.moments[:since], *dead))


def random_grip_paths(
    problem: ContactProblem,
    settings: Settings,
    report: Report = lambda message: None,
    workers: int = 1,
) -> list[RandomGripPath]:
    """The grips, each from its own seed: the same whatever the number of worker processes."""
    parts = [range(k, min(k + _PART, settings.grips)) for k in range(0, settings.grips, _PART)]
    found: list[RandomGripPath] = []
    with Pool(workers, shared=(problem, settings)) if workers > 1 else nullcontext() as pool:
        here = (_wander(problem, settings, part) for part in parts)
        for each in pool.in_order(_wander, [(part,) for part in parts]) if pool else here:
            found += each
            report(f"grips: {len(found)} of {settings.grips}")
    return found


def _wander(problem: ContactProblem, settings: Settings, part: range) -> list[RandomGripPath]:
    return wandering([problem] * len(part), settings, settings.seed, part.start)


def wandering(
    problems: Iterable[ContactProblem], settings: Settings, seed: int, first: int = 0
) -> list[RandomGripPath]:
    """A random grip path on each problem, numbered from ``first``; each from its own seed."""
    most = settings.bounds.max_approach
    return [
        wander(each, settings.face, np.random.default_rng([seed, 0, number]), _STEPS, most)
        for number, each in enumerate(problems, first)
    ]


def finger_curves(problem: ContactProblem, face: str, bounds: Bounds) -> FingerCurves:
    """What the finger's own bench would show without noise; see FingerCurves."""
    found = calibrate(lambda: CondensedPlant(problem, face), problem.model.gage_x, bounds)
    return FingerCurves.of(found)


def sample(
    grip: RandomGripPath,
    curves: FingerCurves,
    settings: Settings,
    rng: np.random.Generator,
    noise: float,
) -> tuple[Array, Array]:
    """Features (k, f) and truths (k, 2): stick ratio, used; of one grip with noise upon it.

    noise: of a gage's sample, microstrain.
    """
    gains = 1.0 + _GAIN_SPREAD * rng.standard_normal(len(grip.moments[0].sample.readings))
    history = [_noisy(each, noise, gains, settings.force_noise, rng) for each in grip.moments]
    own = grip.curves or curves  # as a rig measures them through its own gages
    own = replace(own, pressed=gains * own.pressed, sticking=gains * own.sticking)
    rows, truths = [], []
    for k, (truth, used) in enumerate(zip(grip.truths, grip.used, strict=True)):
        if k == 0 or truth.stick_ratio is None or truth.normal_force < 2.0 * LEAST_FORCE:
            continue
        rows.append(features(history[: k + 1], own, noise))
        truths.append([truth.stick_ratio, used])
    count = feature_count(len(gains))
    return np.array(rows).reshape(-1, count), np.array(truths).reshape(-1, 2)


def _noisy(
    moment: Moment, noise: float, gains: Array, force_noise: float, rng: np.random.Generator
) -> Moment:
    sample = moment.sample
    readings = gains * sample.readings + noise * rng.standard_normal(len(gains))
    stir = force_noise * rng.standard_normal(2)
    return replace(
        moment,
        sample=replace(
            sample,
            readings=readings,
            normal_force=sample.normal_force + float(stir[0]),
            tangential_force=sample.tangential_force + float(stir[1]),
        ),
    )


def fit(inputs: Array, outputs: Array, most_noise: float, seed: int, fingers: int = 1) -> Band:
    """Train one network on features (n, f) and truths (n, 2); its spread is not known yet."""
    center, scale = standard(inputs)
    fewer = min(_UNLIKE if fingers > 1 else 1.0, _ROWS / len(inputs))
    teaching = [(rate, math.ceil(fewer * epochs)) for rate, epochs in _TEACHING]
    rows = standardised(inputs, center, scale).astype(np.float32)  # twice as fast to train on
    with one_thread(), ends_as_meant():
        doubt = _doubt(rows, outputs, teaching, seed)
        layers = trained(rows, np.column_stack([outputs, doubt]), teaching, seed)
    return Band(most_noise, center, scale, layers, np.array([[1.0, 1.0]]))


def _doubt(
    rows: NDArray[np.float32], truths: Array, teaching: Sequence[tuple[float, int]], seed: int
) -> Array:
    """The third thing to be learnt (n,): how far off ``used`` will be, so that a hand may lean on
    what is sure. Of each half of the grips, what a network taught on the other half says wrong:

        doubt = sqrt(|error|) / 3

    The root, for errors are many small ones and few large; a third, for it is to cost the others
    little.
    """
    found, half = np.zeros(len(rows)), len(rows) // 2
    for judged in (slice(0, half), slice(half, None)):
        others = np.ones(len(rows), dtype=bool)
        others[judged] = False
        layers = trained(rows[others], truths[others], teaching, seed)
        off = np.clip(outputs_of(layers, rows[judged])[:, 1], 0.0, 1.0) - truths[judged, 1]
        found[judged] = np.sqrt(np.abs(off)) / 3.0
    return found


def standard(rows: Array) -> tuple[Array, Array]:
    """Center and scale (f,) of rows (n, f), of what is not NaN in them."""
    seldom = np.isnan(rows).all(axis=0)
    rows = np.where(seldom, 0.0, rows)
    return np.nanmean(rows, axis=0), np.maximum(np.nanstd(rows, axis=0), 1e-9)


@contextmanager
def ends_as_meant() -> Iterator[None]:
    """No warnings of networks that end after their epochs; around all threads, not in each."""
    from sklearn.exceptions import ConvergenceWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        yield


def trained(
    rows: NDArray[np.float32], truths: Array, teaching: Sequence[tuple[float, int]], seed: int
) -> tuple[Layer, ...]:
    """The layers of a network trained on standardised rows (n, f) and truths (n, outputs).

    teaching: learning rates and epochs, each from the last one's end. Inside
    :func:`ends_as_meant`, which threads share.
    """
    from sklearn.neural_network import MLPRegressor

    network = MLPRegressor(
        hidden_layer_sizes=_HIDDEN,
        alpha=_PENALTY,
        batch_size=min(256, len(rows)),
        tol=0.0,
        n_iter_no_change=10_000,  # its own test of convergence ends it far too early here
        warm_start=True,
        random_state=seed,
    )
    for rate, epochs in teaching:
        network.learning_rate_init, network.max_iter = rate, epochs
        network.fit(rows, truths.astype(np.float32))
    return tuple(
        Layer(np.asarray(weight, dtype=float), np.asarray(bias, dtype=float))
        for weight, bias in zip(network.coefs_, network.intercepts_, strict=True)
    )


def judge(
    estimator: GripEstimator,
    grips: Sequence[RandomGripPath],
    settings: Settings,
    samples: int = 0,
    fingers: int = 0,
) -> TrainingResult:
    """Errors on held-out grips, of so many other fingers (0: of the same one), by noise; each band
    is given its spread."""
    stick, used = [], []
    for noise in NOISES:
        rng = np.random.default_rng([settings.seed, 2])
        sampled = [sample(each, estimator.curves, settings, rng, noise) for each in grips]
        truths = np.concatenate([each[1] for each in sampled])
        band = estimator.at_noise(noise).band
        said = band.evaluate(np.concatenate([each[0] for each in sampled]))
        off = np.clip(said[:, :2], 0.0, 1.0) - truths
        stick.append(float(np.sqrt((off[:, 0] ** 2).mean())))
        used.append(float(np.sqrt((off[:, 1] ** 2).mean())))
        known = replace(band, spread=_spread(said[:, 2], off[:, 1]))
        bands = tuple(known if each is band else each for each in estimator.bands)
        estimator = replace(estimator, bands=bands)
    errors = tuple(stick), tuple(used)
    return TrainingResult(estimator, NOISES, *errors, samples, len(grips), fingers)


def _spread(doubt: Array, off: Array) -> Array:
    """Standard deviations (k, 2) of ``used`` by the doubt of it: upper edges, each with as many
    cases, and the root mean square of those below."""
    order = np.argsort(doubt)
    parts = np.array_split(order, min(_EDGES, len(order)))
    rows = np.array([[doubt[each[-1]], np.sqrt((off[each] ** 2).mean())] for each in parts])
    return np.asarray(np.maximum(rows, _LEAST_SPREAD))
