"""The network of an estimator: scikit-learn's multilayer perceptron, and its predicted error.

scikit-learn trains it; numpy alone evaluates it (control/estimator.py).

It has no memory but its features. On 12,000 grips of film_tees, with gages that die early
(samples.py), a recurrent network (a gated unit of 32 states, trained on whole grips) is no better:
the friction utilisation of other fingers without further faults is off by 0.112, here by 0.110; in
lifts with all faults by 0.16 to 0.20, here by 0.10 to 0.11. It relies on a past that drift, delay
and dead gages falsify. Nor does size help: 512 and 256 neurons have 0.109; on 1440 grips 64 and 32
err as 128 and 64 do. A half of the error's variance is between grips, a fiftieth between fingers.

On 2,000 random paths of 50 fingers it errs by 0.095. Told how the object leans, how round it is,
whether it has patches and how its friction falls, it errs by 0.090; with the plates' bending, or
with that and gages at a second z, by 0.096 to 0.098.
"""

import math
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.control.completion import Relations
from fingerdesign.control.estimator import Band, Layer, completed, outputs_of, standardised
from fingerdesign.runtime.threads import one_thread

Schedule = Sequence[tuple[float, int]]  # learning rates and epochs, each from the last one's end

_HIDDEN = (96, 32)
_SCHEDULE = ((2e-3, 40), (5e-4, 20), (1e-4, 15))
# With more samples, and with perturbed fingers, fewer epochs avoid overfitting; fewer in proportion
# where a grip is sampled several times.
_ROWS, _PERTURBED_EPOCHS = 100_000, 0.45
# The second is for perturbed fingers whose grips are sampled several times. On 1440 grips of 24
# fingers the friction utilisation of others is off by 0.109 with it, 0.115 with 0.3.
_PENALTY, _SAMPLED_AGAIN = 1e-3, 3e-2
_BATCH = 256
# scikit-learn's own test of convergence would end the training far too early here.
_NO_EARLY_END = 10_000


def fit_band(
    inputs: Array,
    outputs: Array,
    weights: Array,
    most_noise: float,
    seed: int,
    fingers: int = 1,
    replicates: int = 1,
) -> Band:
    """Train one network on features (n, f) and truths (n, 2); its std is not known yet.

    weights (n,): of the squared errors. replicates: how often each grip was sampled.
    """
    center, scale = center_and_scale(inputs)
    fewer = share_of_epochs(len(inputs), fingers, replicates)
    penalty = _SAMPLED_AGAIN if fingers > 1 and replicates > 1 else _PENALTY
    schedule = [(rate, math.ceil(fewer * epochs)) for rate, epochs in _SCHEDULE]
    known = standardised(inputs, center, scale)
    relations = Relations.of(known)
    # Single precision trains twice as fast.
    rows = completed(known, relations).astype(np.float32)
    with one_thread(), without_convergence_warnings():
        predicted_error = _predicted_error(rows, outputs, weights, schedule, seed, penalty)
        targets = np.column_stack([outputs, predicted_error])
        layers = train_layers(rows, targets, schedule, seed, weights, penalty)
    return Band(most_noise, center, scale, relations, layers, np.array([[1.0, 1.0]]))


def share_of_epochs(rows: float, fingers: int, replicates: int) -> float:
    """The share of the schedule's epochs that so many samples are trained for."""
    return min(_PERTURBED_EPOCHS / replicates if fingers > 1 else 1.0, _ROWS / rows)


def _predicted_error(
    rows: NDArray[np.float32],
    truths: Array,
    weights: Array,
    schedule: Schedule,
    seed: int,
    penalty: float,
) -> Array:
    """The third output to train (n,): the expected error of the friction utilisation, so that a
    hand can rely on accurate estimates. It is the error on each half of the grips of a network that
    was trained on the other half:

        predicted error = sqrt(|error|) / 3

    The root is taken because many errors are small and few large; the third, so that this output
    costs the others little accuracy.
    """
    found, half = np.zeros(len(rows)), len(rows) // 2
    for tested in (slice(0, half), slice(half, None)):
        others = np.ones(len(rows), dtype=bool)
        others[tested] = False
        weighed = weights[others]
        layers = train_layers(rows[others], truths[others], schedule, seed, weighed, penalty)
        off = np.clip(outputs_of(layers, rows[tested])[:, 1], 0.0, 1.0) - truths[tested, 1]
        found[tested] = np.sqrt(np.abs(off)) / 3.0
    return found


def center_and_scale(rows: Array) -> tuple[Array, Array]:
    """Mean and standard deviation (f,) of rows (n, f), of finite numbers; 0 and 1e-9 of a column
    without any."""
    rows = np.where(np.isinf(rows), np.nan, rows)
    empty = np.isnan(rows).all(axis=0)
    rows = np.where(empty, 0.0, rows)
    return np.nanmean(rows, axis=0), np.maximum(np.nanstd(rows, axis=0), 1e-9)


@contextmanager
def without_convergence_warnings() -> Iterator[None]:
    """Silence the warnings of networks that end after their epochs; enter it around all threads.

    An interruption ends a network's training early and is no more than a warning: it is raised on.
    """
    from sklearn.exceptions import ConvergenceWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        warnings.filterwarnings("error", "Training interrupted", UserWarning)
        try:
            yield
        except UserWarning as stopped:
            raise KeyboardInterrupt from stopped


def train_layers(
    rows: NDArray[np.float32],
    truths: Array,
    schedule: Schedule,
    seed: int,
    weights: Array | None = None,
    penalty: float = _PENALTY,
) -> tuple[Layer, ...]:
    """Train a network on standardised rows (n, f) and truths (n, outputs); its layers.

    weights (n,): of the squared errors, in any unit; None: all alike.
    Call it inside :func:`without_convergence_warnings`, which threads share.
    """
    from sklearn.neural_network import MLPRegressor

    network = MLPRegressor(
        hidden_layer_sizes=_HIDDEN,
        alpha=penalty,
        batch_size=min(_BATCH, len(rows)),
        tol=0.0,
        n_iter_no_change=_NO_EARLY_END,
        warm_start=True,
        random_state=seed,
    )
    # Their mean is 1, so that the penalty means the same with all weights.
    own = None if weights is None else (weights / weights.mean()).astype(np.float32)
    for rate, epochs in schedule:
        network.learning_rate_init, network.max_iter = rate, epochs
        network.fit(rows, truths.astype(np.float32), sample_weight=own)
    return tuple(
        Layer(np.asarray(weight, dtype=float), np.asarray(bias, dtype=float))
        for weight, bias in zip(network.coefs_, network.intercepts_, strict=True)
    )
