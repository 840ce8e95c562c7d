"""Forecast of a training's duration, from a few grips on the design's own model."""

from time import perf_counter

from fingerdesign.contact.problem import ContactProblem
from fingerdesign.runtime.streams import stream
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing.train.paths import Settings, random_grip_path

_TRIED = 4  # grips that are timed
# A lift of the behaviour policy takes so many times as long as a random grip path; a third of all
# grips are lifts of fingers.
_LIFT, _LIFTS = 1.6, 1.0 / 3.0
# Sampling and networks, of both bands, by moment of a grip: measured on two slow cores.
_SECONDS_A_MOMENT = 2.0e-3


def training_seconds(
    problem: ContactProblem, settings: Settings, model_s: float, workers: int
) -> float:
    """Seconds of a training in ``workers`` processes, on this machine as it is busy now.

    problem: the design's own; model_s: seconds that it took. Within a factor of two.
    """
    start, moments = perf_counter(), 0
    with one_thread():
        for number in range(_TRIED):
            rng = stream(settings.seed, "forecast of a training", number)
            moments += len(random_grip_path(problem, settings, rng).moments)
    grip_s = (perf_counter() - start) / _TRIED
    many = settings.fingers > 1
    grips_s = settings.grips * grip_s * (1.0 + (_LIFTS * (_LIFT - 1.0) if many else 0.0))
    models_s = settings.fingers * model_s if many else 0.0
    rows = settings.grips * settings.replicates * moments / _TRIED
    return (grips_s + models_s) / workers + _SECONDS_A_MOMENT * rows


def forecast_words(seconds: float) -> str:
    """Words for a duration: "about 20 s", "about 35 min"."""
    if seconds < 90.0:
        return f"about {max(10.0 * round(seconds / 10.0), 10.0):.0f} s"
    return f"about {max(seconds / 60.0, 2.0):.0f} min"
