"""A design's estimator, taught when first wanted and kept by content.

    result = training_result_for(design, report=print)
    result.estimator, result.stick_error()

What it is taught on is the model that grips run on (model.py). It is kept in the user's cache by
what it depends on: finger, gages, stage travel, fidelity, number of grips and seed.
"""

import hashlib
import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, replace

import numpy as np

from fingerdesign.analysis.case import Case, gage_array
from fingerdesign.analysis.stages import one_thread
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.controllers.regulator import Regulator, RegulatorTable
from fingerdesign.control.episode import run_episode
from fingerdesign.control.estimator import FORMAT, EstimatorError, GripEstimator, Moment
from fingerdesign.control.plants.lift import LiftPlant, Relaxation
from fingerdesign.control.plants.plant import CondensedPlant, Plant, Truth
from fingerdesign.control.plants.rig import ImperfectPlant
from fingerdesign.control.roster import Object, needs_training
from fingerdesign.control.signals import Sample
from fingerdesign.design.digest import content_digest
from fingerdesign.design.grip import Grip
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.runtime.cache import Cache
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.progress import Report
from fingerdesign.runtime.registry import CONTROLLERS, own_values
from fingerdesign.sensing.model import (
    CONTACT_SIZE_MM,
    FIDELITIES,
    MESHED,
    bench_problem,
    grip_problem,
)
from fingerdesign.sensing.perturb.finger import OF_OBJECTS, Unlike, facing, taught_faults, unlike
from fingerdesign.sensing.train.estimator import (
    BANDS,
    FRICTIONS,
    RandomGripPath,
    Settings,
    TrainingResult,
    finger_curves,
    teach,
    wandering,
)
from fingerdesign.version import __version__

# Grips by the regulator's own hand, to be taught on: what it meets is not what random paths meet.
#
# A network that has learnt from random paths errs most where its own errors lead it: it stops a
# probe too soon, say, and climbs where nothing slips. So a pilot grips fingers that it has not
# seen, and what was true there is taught beside the random paths (the idea is DAgger's: Ross,
# Gordon, Bagnell 2011, "A reduction of imitation learning ... to no-regret online learning"). On
# fingers with tilts, places and moduli unlike the model's, that and probing at a newton and a half
# took the share of lifts without a fault from 77 to 88 %, all faults at once.

_MASSES_G = (80.0, 1200.0)
_HANGS = 2  # steps that a lifted object is held for
# Of what grips, in every second of its lifts: how much less friction is in motion, and forces that
# relax in a minute. Of every lift: samples that come late. A hand that pulls more slowly, that a
# creeping finger leads astray or that feels more slip than Coulomb's meets other moments.
_KINETIC, _RELAXES, _LATE = 0.2, 0.15, 2
_LEAST = 3  # moments, of a grip that teaches anything
# Of the hand that grips, drawn evenly, so that what is taught suits whatever the design chooses.
_TARGET, _PROBE, _PULL = (0.6, 0.85), (0.6, 1.8), (0.015, 0.05)


class _Written:
    """A plant that writes down what truly happens, before any noise."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self.moments: list[Moment] = []
        self.truths: list[Truth] = []

    def move(self, dx: float, dy: float) -> Sample:
        sample = self._plant.move(dx, dy)
        self.moments.append(Moment(sample, dx, dy))
        self.truths.append(self._plant.truth())
        return sample

    def truth(self) -> Truth:
        return self._plant.truth()


def own_grips(
    bench: ContactProblem,
    held: Iterable[ContactProblem],
    face: str,
    grip: Grip,
    pilot: GripEstimator,
    seed: int,
) -> list[RandomGripPath]:
    """Lifts by a regulator that believes ``pilot``; without noise, as random paths are.

    bench: the finger against its bench's plane; held: against what it grips, a lift each. Friction,
    weight, the gages' noise, what comes late, relaxes or slides more easily, and the hand's own
    settings are drawn from the seed. Raises SolverError where the bench fails.
    """
    bounds = Bounds.of(grip)
    known = calibrate(lambda: CondensedPlant(bench, face), bench.model.gage_x, bounds)
    rng, found = np.random.default_rng([seed, 3]), []

    def drawn(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(*np.log((low, high)))))

    for met in held:
        friction, mass, noise = drawn(*FRICTIONS), drawn(*_MASSES_G), drawn(*BANDS[0])
        table = RegulatorTable(
            target=rng.uniform(*_TARGET), probe_force_N=drawn(*_PROBE), pull_share=drawn(*_PULL)
        )
        hand = Regulator(grip, table, Object(estimator=pilot.at_noise(noise)))
        relaxes, slides = rng.uniform(0.0, (_RELAXES, _KINETIC)) * rng.integers(0, 2, 2)
        creep = Relaxation(float(relaxes), grip.hardware.sample_rate_Hz) if relaxes else None
        own = met.with_friction(friction), face, mass, None, (), creep, 1.0 - float(slides)
        plant, delay = _Written(LiftPlant(*own)), int(rng.integers(0, _LATE + 1))
        hardware = grip.hardware.model_copy(
            update={
                "delay_samples": delay,
                "gage_noise_microstrain": noise,
                "gage_noise_microvolt_per_V": 0.0,
            }
        )
        with suppress(SolverError):  # what came before the model's end stands
            imperfect = ImperfectPlant(plant, hardware, rng)
            bench_says = replace(known, delay=delay)
            run_episode(imperfect, hand, bench_says, bounds, friction, mass, _HANGS)
        if len(plant.moments) > _LEAST:
            found.append(RandomGripPath(friction, tuple(plant.moments), tuple(plant.truths)))
    return found


TEACHING = 9  # raise it when what is taught, or how, changes

_PILOTS = 3  # of so many fingers one teaches the pilot


def training_result_for(
    design: Design,
    problem: ContactProblem | None = None,
    report: Report = lambda message: None,
    workers: int = 1,
    fidelity: str = "plane-strain",
) -> TrainingResult:
    """What was taught on a design, from the cache where it has been taught before.

    problem: the design's grip_problem of this fidelity, where it has been made already. Raises what
    :func:`grip_problem` and :func:`teach` raise.
    """
    settings = settings_of(design)
    key = training_key(design, settings, fidelity)
    kept = Cache("training")
    found = _read(kept.text(f"{key}.txt"))
    if found is not None:
        return found
    problem = grip_problem(design, fidelity, report=report) if problem is None else problem
    grips = None
    if settings.fingers > 1:
        grips = _grips_of_others(design, problem, settings, fidelity, report, workers)
    result = teach(problem, key, settings, report, grips, workers=workers)
    kept.put_text(f"{key}.txt", training_text(result))
    return result


def settings_of(design: Design) -> Settings:
    """How much a design's estimator is taught."""
    grip = design.grip
    own = own_values(grip, CONTROLLERS.find("regulator", "grip.controller"))
    return Settings(
        face=design.gages.face,
        bounds=Bounds.of(grip),
        grips=own.taught_grips,
        hearings=1 if own.taught_fingers > 1 else 2,
        seed=grip.seed,
        fingers=own.taught_fingers,
    )


def _grips_of_others(
    design: Design,
    problem: ContactProblem,
    settings: Settings,
    fidelity: str,
    report: Report,
    workers: int,
) -> list[RandomGripPath]:
    """Grips of fingers and objects that are unlike the model: random paths of all; and of those
    that come after a pilot has learnt from the first ones, which stand last, its own."""
    found: list[RandomGripPath] = []
    pilots = -(-settings.fingers // _PILOTS)

    def made(numbers: range, pilot: GripEstimator | None) -> list[RandomGripPath]:
        grips: list[RandomGripPath] = []
        for each in pool.in_order(_grips_of, [(number, pilot) for number in numbers]):
            grips += each
            count = len(found) + len(grips)
            report(f"grips: {count} of {settings.grips}, {settings.fingers} fingers")
        return grips

    with Pool(workers, shared=(design, settings, fidelity)) as pool:
        found = made(range(pilots), None)
        pilot = teach(problem, "pilot", settings, report, found, bands=BANDS[:1]).estimator
        return made(range(pilots, settings.fingers), pilot) + found


def _grips_of(
    design: Design, settings: Settings, fidelity: str, number: int, pilot: GripEstimator | None
) -> list[RandomGripPath]:
    """Those of one finger, with the curves that its bench would show; half by the pilot's hand.

    Each grip is of an object of its own, which costs no other model. None where no draw of the
    finger is sound."""
    faults, count = taught_faults(design), -(-settings.grips // settings.fingers)
    seed, *others = np.random.SeedSequence([settings.seed, number]).generate_state(1 + count)
    try:
        finger = unlike(design, faults, int(seed)).design
    except DesignError:
        return []
    kinds = OF_OBJECTS & set(faults)
    drawn = [
        unlike(finger, kinds | {"patches"} if number % 2 else kinds, int(each))
        for number, each in enumerate(others)
    ]
    bench = bench_problem(finger, [each.held for each in drawn], fidelity)
    own = 0 if pilot is None else count // 2

    def held(objects: Sequence[Unlike]) -> Iterator[ContactProblem]:
        return (facing(bench, each) for each in objects)  # one at a time: they are large

    curves = finger_curves(bench, settings.face, settings.bounds)
    with one_thread():
        grips = wandering(held(drawn[own:]), settings, int(seed))
        if pilot is not None:
            mine = held(drawn[:own])
            grips += own_grips(bench, mine, settings.face, design.grip, pilot, int(seed))
        return [replace(each, curves=curves) for each in grips]


def training_key(design: Design, settings: Settings, fidelity: str = "plane-strain") -> str:
    """SHA-256 of all that an estimator depends on; of the design without names and controllers."""
    grip, solid = design.grip, fidelity == "3d"
    content = [
        TEACHING,
        FORMAT,
        __version__,
        content_digest(design.body),
        content_digest(design.plates),
        content_digest(design.gages),
        {name: content_digest(each) for name, each in sorted(design.materials.items())},
        content_digest(design.mesh if solid else design.mesh.section),
        asdict(settings),
        grip.bench_friction_coefficient,
        *([fidelity, CONTACT_SIZE_MM[fidelity], MESHED] if solid else []),
    ]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def estimator_faults(
    design: Design, estimator: GripEstimator, fidelity: str | None = None
) -> list[Fault]:
    """What is wrong with gripping by ``estimator`` on a design: it was taught on another finger.

    Empty where it was taught on this one, at this fidelity (None: at any), with the same stage
    travel, number of grips and seed.
    """
    remedy = "teach it on this design: fingerdesign train DESIGN"
    wanted, gages = len(gage_array(design)), estimator.gages
    if gages != wanted:
        value = f"one for {gages} gages"
        return [Fault("--estimator", value, f"one for the design's {wanted} gages", remedy)]
    keys = [training_key(design, settings_of(design), each) for each in FIDELITIES]
    known = dict(zip(keys, FIDELITIES, strict=True))
    own = known.get(estimator.design)
    if own is not None and fidelity in FIDELITIES and own != fidelity:
        where = f"fingerdesign train DESIGN --fidelity {fidelity}"
        return [Fault("--estimator", f"taught in {own}", f"one taught in {fidelity}", where)]
    if own is None:
        value = f"one taught on {estimator.design[:12]}"
        bound = f"one taught on this design ({keys[0][:12]}: its finger, gages and stage)"
        return [Fault("--estimator", value, bound, remedy)]
    return []


def training_text(result: TrainingResult) -> str:
    """The training result as JSON: the estimator, and its errors by noise."""
    record = {
        "estimator": json.loads(result.estimator.to_json()),
        "noises_microstrain": result.noises,
        "stick_errors": result.stick_errors,
        "friction_utilisation_errors": result.used_errors,
        "samples": result.samples,
        "judged_grips": result.judged_grips,
        "judged_fingers": result.judged_fingers,
    }
    return json.dumps(record, allow_nan=False) + "\n"


def _read(text: str | None) -> TrainingResult | None:
    """What is kept; None where there is nothing, or something of another format."""
    try:
        estimator, noises, stick, used, samples, *judged = json.loads(text or "").values()
        known = GripEstimator.from_json(json.dumps(estimator))
        errors = tuple(stick), tuple(used)
        return TrainingResult(known, tuple(noises), *errors, int(samples), *judged)
    except (ValueError, TypeError, AttributeError, EstimatorError):
        return None


def with_estimator(case: Case, report: Report) -> Case:
    """The case with what its regulator grips by, taught on the design where none is given: in 3-D
    where the case is, for one taught in plane strain drops every second object there.

    Raises DesignError for an estimator of another finger, or taught at another fidelity.
    """
    if not case.runs_grips or not needs_training(case.design.grip.controller):
        return case

    if case.estimator is None:
        fidelity = "3d" if case.fidelity == "3d" else "plane-strain"
        found = training_result_for(case.design, report=report, fidelity=fidelity)
        return replace(case, estimator=found.estimator)
    if faults := estimator_faults(case.design, case.estimator, case.fidelity):
        raise DesignError(faults)
    return case
