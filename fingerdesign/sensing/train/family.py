"""Grips of perturbed fingers, for the training of an estimator.

The grips of a finger that are made are in the cache until the training has ended: one that was
interrupted goes on from there.
"""

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from fingerdesign.arrays import Array
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.contact.turning import turning
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.features import FingerCurves, Moment
from fingerdesign.control.plants.plant import Truth
from fingerdesign.control.signals import Sample
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.runtime.cache import GARBLED, Cache, code_digest, packed, unpacked
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.progress import Report
from fingerdesign.runtime.streams import seed_for
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing.model import BenchFinger, layers_for_many
from fingerdesign.sensing.perturb.faults import OF_OBJECTS
from fingerdesign.sensing.perturb.finger import PerturbedFinger, facing, perturb, training_faults
from fingerdesign.sensing.train.estimator import BANDS, train_estimator
from fingerdesign.sensing.train.paths import RandomGripPath, Settings, grip_paths_on
from fingerdesign.sensing.train.policy import policy_grips
from fingerdesign.sensing.train.samples import finger_curves

# One in so many fingers holds objects that turn, where the rig measures torque: whole, it takes
# twice the work of half a finger.
TURNING = 6
_HOME = Path(__file__).parents[2]
_CARRIES_N = 1.0  # F_t for the springs of an object that turns, which hardly count.
# One in so many objects has patches, or friction that falls with the pressure. Such increments take
# twice the work, and of an object that turns far more: there it is left out.
_PATCHY, _FALLING = 2, 4
_FIRST_PART = 3  # One in so many fingers trains the behaviour policy.
_MOST_FINGERS, _MOST_MB = 1000, 1500.0  # Of trainings that never ended.
_KINDS: dict[str, type] = {
    kind.__name__: kind for kind in (FingerCurves, RandomGripPath, Moment, Sample, Truth)
}


@dataclass(frozen=True)
class Family:
    """A design whose perturbed fingers share the grips of a training; key: the training's."""

    design: Design
    settings: Settings
    fidelity: str
    key: str


def grips_of_family(
    family: Family, problem: ContactProblem, report: Report, workers: int
) -> list[RandomGripPath]:
    """Make grips of perturbed fingers and objects. A first part of the fingers makes random paths,
    which train the behaviour policy; the others make half of their grips with it. These others come
    first, so that held-out grips are theirs."""
    settings = family.settings
    first = -(-settings.fingers // _FIRST_PART)
    done: list[RandomGripPath] = []

    def make(numbers: range, policy: GripEstimator | None) -> list[RandomGripPath]:
        grips: list[RandomGripPath] = []
        for each in pool.in_order(_grips_of_finger, [(number, policy) for number in numbers]):
            grips += each
            count = len(done) + len(grips)
            report(f"grips: {count} of {settings.grips}, {settings.fingers} fingers")
        return grips

    with Pool(workers, shared=(family,)) as pool:
        done = make(range(first), None)
        # Sampled once: of a surer pilot the estimator learns to drop more, 26 of 240 lifts, not 4.
        once = replace(settings, replicates=1)
        pilot = train_estimator(problem, "pilot", once, report, done, workers, bands=BANDS[:1])
        # A file has fewer digits: who stores the pilot makes the same grips as who does not.
        policy = GripEstimator.from_json(pilot.estimator.to_json())
        return make(range(first, settings.fingers), policy) + done


def _grips_of_finger(
    family: Family, number: int, policy: GripEstimator | None
) -> list[RandomGripPath]:
    """Take the grips of a finger from the cache, or make them."""
    content = "random paths" if policy is None else policy.to_json()
    code = code_digest(_HOME)
    digest = hashlib.sha256(f"{code} {content}".encode()).hexdigest()
    name, cache = f"{family.key}.{number}.{digest[:16]}.npz", _fingers()
    stored = cache.arrays(name)
    with suppress(*GARBLED):  # Such a file is made again.
        if stored is not None:
            curves, *grips = unpacked(stored[1], stored[0], _KINDS)
            return [replace(each, curves=curves) for each in grips]
    grips = _made(family, number, policy)
    if grips:
        arrays: dict[str, Array] = {}
        about = packed((grips[0].curves, *(replace(each, curves=None) for each in grips)), arrays)
        cache.put_arrays(name, arrays, about)
    return grips


def _fingers() -> Cache:
    return Cache("trained fingers", _MOST_FINGERS, most_MB=_MOST_MB)


def forget(key: str) -> None:
    """Remove the fingers of a training that has ended from the cache."""
    for each in _fingers().folder.glob(f"{key}.*.npz"):
        each.unlink(missing_ok=True)


def _made(family: Family, number: int, policy: GripEstimator | None) -> list[RandomGripPath]:
    """Make the grips of one perturbed finger, with the curves that its bench would show; half of
    them by the behaviour policy. Some hold objects that turn, where the rig measures it.

    Each grip is of another object, which needs no other model. Empty where no draw of the finger is
    sound.
    """
    design, settings = family.design, family.settings
    faults, count = training_faults(design), -(-settings.grips // settings.fingers)
    seed, *others = finger_seeds(settings.seed, number, count)
    turns = turns_objects(settings, family.fidelity) and number % TURNING == 0
    off = {"off_centre"} if turns else set()
    try:
        finger = perturb(design, {*faults, *off}, seed).design
    except DesignError:
        return []
    kinds = (OF_OBJECTS & set(faults)) | off | {"patches"}
    drawn = []
    for k, each in enumerate(others):
        smooth = {"patches"} if k % _PATCHY == 0 else set()
        alike = {"exponent"} if turns or (k + number) % _FALLING else set()
        drawn.append(perturb(finger, kinds - smooth - alike, each))
    objects = tuple(each.object for each in drawn)
    layers = layers_for_many(design)
    bench = BenchFinger(finger, objects, family.fidelity, layered=layers).model()[1]
    own = 0 if policy is None else count // 2

    def problems(objects: Sequence[PerturbedFinger]) -> Iterator[ContactProblem]:
        for each in objects:  # One at a time, for they are large.
            problem, arm = facing(bench, each), each.design.grip.off_centre_mm
            yield turning(problem, arm, _CARRIES_N) if arm else problem

    curves = finger_curves(bench, settings.face, settings.bounds)
    with one_thread():
        grips = grip_paths_on(problems(drawn[own:]), settings, seed)
        if policy is not None:
            mine = problems(drawn[:own])
            grips += policy_grips(bench, mine, settings.face, design.grip, policy, seed)
        return [replace(each, curves=curves) for each in grips if each.moments]


def turns_objects(settings: Settings, fidelity: str) -> bool:
    """True where objects that turn are trained on."""
    return fidelity == "3d" and settings.torque_noise is not None


def finger_seeds(seed: int, number: int, objects: int) -> list[int]:
    """The seed of a training's finger, then those of its objects."""
    others = [seed_for(seed, "trained object", number, each) for each in range(objects)]
    return [seed_for(seed, "trained finger", number), *others]
