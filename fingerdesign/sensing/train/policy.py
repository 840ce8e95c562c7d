"""Grips of a behaviour policy: a regulator with a first estimator grips the training fingers.

A network that is trained on random paths alone errs most where its own errors lead: it stops a
probe too soon, say, and climbs where nothing slips. So a behaviour policy with a first estimator
grips other fingers, and its grips are added to the random paths (the idea is DAgger's: Ross,
Gordon, Bagnell 2011, "A reduction of imitation learning ... to no-regret online learning"). On
perturbed fingers this and probing at 1.5 N raised the lifts without a fault from 77 to 88 %, all
faults at once.
"""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace

from fingerdesign.contact.gross_slip import meeting
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.controllers.regulator import Regulator, RegulatorTable
from fingerdesign.control.episode import run_episode
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.plants.hardware import ImperfectPlant
from fingerdesign.control.plants.lift import LiftPlant, Relaxation, Timed
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.roster import Object
from fingerdesign.design.grip import Grip, weight_per_finger
from fingerdesign.errors import SolverError
from fingerdesign.runtime.streams import stream
from fingerdesign.sensing.train.estimator import BANDS
from fingerdesign.sensing.train.paths import FRICTIONS, RandomGripPath, RecordingPlant, drawn_evenly

_MASSES_G = (80.0, 1200.0)
_HANGS = 2  # A lifted object is held for so many steps.
# Half of the lifts have less friction in motion, by up to this fraction, and half have forces that
# relax by up to this fraction in a minute. In all of them samples come up to so many moves late. A
# hand on such a finger meets other moments than one on an elastic finger with Coulomb friction.
_KINETIC, _RELAXATION, _DELAY = 0.2, 0.15, 2
_LEAST_MOMENTS = 3  # A grip with no more moments is left out.
# The regulator's own settings are drawn too, so that the training suits any that a design chooses.
_TARGET, _PROBE_N, _PULL = (0.6, 0.85), (0.6, 1.8), (0.015, 0.05)


def policy_grips(
    bench: ContactProblem,
    objects: Iterable[ContactProblem],
    face: str,
    grip: Grip,
    policy: GripEstimator,
    seed: int,
) -> list[RandomGripPath]:
    """Lift each object with a regulator that uses the estimator ``policy``; without noise, as
    random paths are.

    bench: the finger against its bench's plane; objects: the finger against each object. Friction,
    weight, gage noise, delay, relaxation, kinetic friction and the regulator's settings are drawn
    from the seed. Raises SolverError where the bench fails.
    """
    bounds = Bounds.of(grip)
    known = calibrate(lambda: CondensedPlant(bench, face), bench.model.gage_x, bounds)
    found = []
    for number, problem in enumerate(objects):
        rng = stream(seed, "grip of the behaviour policy", number)
        ranges = (FRICTIONS, _MASSES_G, BANDS[0])
        friction, mass, noise = (drawn_evenly(rng, *each) for each in ranges)
        table = RegulatorTable(
            target=rng.uniform(*_TARGET),
            probe_force_N=drawn_evenly(rng, *_PROBE_N),
            pull_share=drawn_evenly(rng, *_PULL),
        )
        hand = Regulator(grip, table, Object(estimator=policy.at_noise(noise)))
        relaxes, slides = rng.uniform(0.0, (_RELAXATION, _KINETIC)) * rng.integers(0, 2, 2)
        creep = Relaxation(float(relaxes), grip.hardware.sample_rate_Hz) if relaxes else None
        lift = LiftPlant(
            meeting(problem, friction, weight_per_finger(mass) / friction),
            face,
            mass,
            timed=Timed(creep),
            kinetic_share=1.0 - float(slides),
            ratio_of_now=True,
        )
        plant, delay = RecordingPlant(lift), int(rng.integers(0, _DELAY + 1))
        noises = {"gage_noise_microstrain": noise, "gage_noise_microvolt_per_V": 0.0}
        hardware = grip.hardware.model_copy(update={"delay_samples": delay, **noises})
        with suppress(SolverError):  # The moments before the failure are valid.
            imperfect = ImperfectPlant(plant, hardware, rng)
            calibration = replace(known, delay=delay)
            run_episode(imperfect, hand, calibration, bounds, friction, mass, _HANGS)
        path = plant.path(friction)
        if len(path.moments) > _LEAST_MOMENTS:
            found.append(path)
    return found
