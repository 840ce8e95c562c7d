"""A design's training result: made when it is first needed, cached by content.

The training model is the one that grips run on (sensing/model.py). An estimator is for a finger:
its body, gages, stage travel and fidelity. The cache's key also holds the number of grips, the seed
and the training's version.
"""

import hashlib
import json
from dataclasses import asdict
from time import perf_counter

from fingerdesign.analysis.case import gage_array
from fingerdesign.checks.load import with_values
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Bounds
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.former_estimator import NAME, OLDEST, PRESENT
from fingerdesign.design.digest import content_digest
from fingerdesign.design.grip import FORCE_NOISE_N
from fingerdesign.design.schema import Design
from fingerdesign.errors import EstimatorError, Fault
from fingerdesign.mesh.make import mesher_name
from fingerdesign.runtime.cache import Cache
from fingerdesign.runtime.progress import Report
from fingerdesign.runtime.registry import CONTROLLERS, own_values
from fingerdesign.runtime.streams import stream
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing.model import (
    CONTACT_SIZE_MM,
    FIDELITIES,
    MESHED,
    grip_problem,
    layers_for_many,
    meshed_for_grips,
    seconds_of_many,
)
from fingerdesign.sensing.train.estimator import TrainingResult, train_estimator
from fingerdesign.sensing.train.family import (
    TURNING,
    Family,
    forget,
    grips_of_family,
    turns_objects,
)
from fingerdesign.sensing.train.network import share_of_epochs
from fingerdesign.sensing.train.paths import Settings, random_grip_path
from fingerdesign.version import __version__

TRAINING = 17  # Raise it when the training data or the training itself changes.
# Of the model alone; of perturbed fingers, each with other noise, gains and a gage that dies at
# another moment. On 1440 grips of 24 fingers the friction utilisation of others is off by 0.114
# with one of them, by 0.109 with four, by 0.108 with six.
_REPLICATES = 2, 4
_ANY_SHARE = 0.5  # An estimator reads gages, not their area.
_TRIED = 4  # Grips that are timed for the forecast.
# A lift of the behaviour policy takes so many times as long as a random grip path; a third of all
# grips are lifts of fingers.
_LIFT, _LIFTS = 1.6, 1.0 / 3.0
# Of both bands, on two busy cores: to sample a moment of a grip; to train on a sample, all epochs.
_SAMPLING_S, _TRAINING_S = 1.2e-4, 2.0e-3


def training_result_for(
    design: Design,
    report: Report = lambda message: None,
    workers: int = 1,
    fidelity: str = "plane-strain",
) -> TrainingResult:
    """Train on a design, or take the result from the cache. How long it will take is reported
    before it begins.

    Raises what :func:`grip_problem` and :func:`train_estimator` raise.
    """
    settings = settings_of(design)
    key = training_key(design, settings, fidelity)
    cache = Cache("training")
    found = _read(cache.text(f"{key}.txt"))
    if found is not None:
        return found
    problem = grip_problem(design, fidelity, report=report)
    seconds = training_seconds(problem, settings, seconds_of_many(design, fidelity), workers)
    if turns_objects(settings, fidelity) and problem.model.symmetry_factor == 2:
        problem = grip_problem(design, fidelity, report=report, whole=True)
        seconds *= 1.0 + 1.0 / TURNING  # A whole finger takes twice the work.
    begun, whole = perf_counter(), forecast_words(seconds)
    report(f"training on {settings.grips} grips, {settings.fingers} fingers: {whole}")
    grips = None
    if settings.fingers > 1:
        family = Family(design, settings, fidelity, key)

        def shown(message: str) -> None:
            left = seconds - (perf_counter() - begun)
            words = f"{forecast_words(left)} left" if left > 0.0 else f"longer than {whole}"
            report(f"{message}; {words}")

        try:
            grips = grips_of_family(family, problem, shown, workers)
        except KeyboardInterrupt as stopped:
            words = "the training's finished fingers are stored: run the same command to go on"
            raise KeyboardInterrupt(words) from stopped
    own = finger_key(design, fidelity)
    result = train_estimator(problem, own, settings, report, grips, workers=workers)
    text = training_text(result)
    cache.put_text(f"{key}.txt", text)
    forget(key)
    # The file has fewer digits: who trains has the same numbers as who reads it.
    return _read(text) or result


def training_seconds(
    problem: ContactProblem, settings: Settings, model_s: float, workers: int
) -> float:
    """Seconds of a training in ``workers`` processes, on this machine as it is busy now.

    problem: the design's own; model_s: of each finger's model. Within a factor of two.
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
    trained = rows * share_of_epochs(rows, settings.fingers, settings.replicates)
    return (grips_s + models_s) / workers + _SAMPLING_S * rows + _TRAINING_S * trained


def forecast_words(seconds: float) -> str:
    """Words for a duration: "about 20 s", "about 35 min"."""
    if seconds < 90.0:
        return f"about {max(10.0 * round(seconds / 10.0), 10.0):.0f} s"
    return f"about {max(seconds / 60.0, 2.0):.0f} min"


def settings_of(design: Design) -> Settings:
    """The settings of a design's training."""
    grip = design.grip
    own = own_values(grip, CONTROLLERS.find("regulator", "grip.controller"))
    return Settings(
        face=design.gages.face,
        bounds=Bounds.of(grip),
        grips=own.training_grips,
        replicates=_REPLICATES[own.training_fingers > 1],
        force_noise=grip.hardware.force_noise_N or FORCE_NOISE_N,
        torque_noise=grip.hardware.torque_noise_Nmm,
        seed=grip.seed,
        fingers=own.training_fingers,
    )


def training_key(design: Design, settings: Settings, fidelity: str = "plane-strain") -> str:
    """SHA-256 of all that a training depends on: the finger, its amount, this version."""
    content = [TRAINING, __version__, finger_key(design, fidelity), asdict(settings)]
    if fidelity == "3d":
        content.append(layers_for_many(design))
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def finger_key(design: Design, fidelity: str = "plane-strain", number: int = PRESENT) -> str:
    """SHA-256 of the finger that an estimator is for, its stage's travel and its model; without
    names, controllers and what the paper's rule makes of the gages. number: of the file's format.
    """
    grip, solid = design.grip, fidelity == "3d"
    gages = design.gages.model_copy(update={"area_share": _ANY_SHARE})
    meshed = meshed_for_grips(design, fidelity)
    if solid:
        meshed = with_values(meshed, {"mesh.mesher": mesher_name(meshed)})
    content = [
        f"{NAME}{number}",
        content_digest(design.body),
        content_digest(design.plates),
        content_digest(gages),
        {name: content_digest(each) for name, each in sorted(design.materials.items())},
        content_digest(meshed.mesh if solid else meshed.mesh.section),
        Bounds.of(grip).max_approach,
        grip.bench_friction_coefficient,
        *([fidelity, CONTACT_SIZE_MM[fidelity], MESHED] if solid else []),
    ]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def finger_keys(design: Design, fidelity: str) -> list[str]:
    """The keys of :func:`finger_key` in every format that is read, the present one first: a file of
    a former format keeps its key."""
    return [finger_key(design, fidelity, number) for number in range(PRESENT, OLDEST - 1, -1)]


def estimator_faults(
    design: Design, estimator: GripEstimator, fidelity: str | None = None
) -> list[Fault]:
    """Faults of gripping with ``estimator`` on a design: it was trained on another finger.

    Empty where it was trained on this one, at this fidelity (None: at any), with the same stage
    travel.
    """
    remedy = "train one on this design: fingerdesign train DESIGN"
    target, gages = len(gage_array(design)), estimator.gages
    if gages != target:
        value = f"one for {gages} gages"
        return [Fault("estimator", value, f"one for the design's {target} gages", remedy)]
    known = {key: each for each in FIDELITIES for key in finger_keys(design, each)}
    own = known.get(estimator.design)
    if own is not None and fidelity in FIDELITIES and own != fidelity:
        remedy = f"--fidelity {own}, or fingerdesign train DESIGN --fidelity {fidelity}"
        return [Fault("estimator", f"trained in {own}", f"one trained in {fidelity}", remedy)]
    if own is None:
        value = f"one trained on {estimator.design[:12]}"
        key = finger_key(design)[:12]
        bound = f"one trained on this design ({key}: its finger, gages and stage)"
        return [Fault("estimator", value, bound, remedy)]
    return []


def training_text(result: TrainingResult) -> str:
    """The training result as JSON: the estimator, and its errors by noise."""
    record = vars(result) | {"estimator": json.loads(result.estimator.to_json())}
    return json.dumps(record, allow_nan=False) + "\n"


def _read(text: str | None) -> TrainingResult | None:
    """Read a cached result; None where there is none, or one of another format."""
    try:
        estimator, noises, stick, utilisation, *counts = json.loads(text or "").values()
        known = GripEstimator.from_json(json.dumps(estimator))
        errors = tuple(stick), tuple(utilisation)
        return TrainingResult(known, tuple(noises), *errors, *map(int, counts))
    except (ValueError, TypeError, AttributeError, EstimatorError):
        return None
