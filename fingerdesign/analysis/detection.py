"""Slip that gages can measure above an amplifier's noise (numpy only).

Hold both forces, let friction differ a little: readings e (g,) and stick ratio S move together,
and that is all that the gages say of S which the forces do not. With independent noise of
deviation sigma on each reading, no unbiased estimate from n samples in that state errs by less
than

    sigma / (|de/dS| sqrt(n)),      de/dS = (de/dmu) / (dS/dmu) at the same F_n and F_t

(Cramér, Mathematical Methods of Statistics, 1946, 32.3). The state is reached by pressing to F_n
and pulling at constant F_n. The model is taken as known exactly, gains and all: a rig does worse.
A change counts as measured where it is ``SEEN`` deviations of one sample, the usual limit of
detection (IUPAC, Compendium of Chemical Terminology: "limit of detection").
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from fingerdesign.analysis.slip_study import stick_response
from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces, solve_forces
from fingerdesign.contact.increment import Workspace
from fingerdesign.contact.measures import measure
from fingerdesign.contact.problem import ContactProblem, ContactState
from fingerdesign.control.signals import gage_readings
from fingerdesign.design.gages import METAL_FACTOR
from fingerdesign.design.grip import HardwareTable
from fingerdesign.errors import SolverError
from fingerdesign.records.result import MeasuredState

REFERENCE_NOISE = 0.5  # microstrain, of a good strain amplifier at 100 Hz with metal foil
SEEN = 3.0
# A hand that steers by the stick ratio starts to hold near 0.3 and has lost the object at 0: a
# third of that way. Gages that say nothing leave an error of 0.23, the spread of the ratio itself.
WANTED_STICK_CHANGE = 0.1
UNSEEN_STICK_CHANGE = 0.3  # the whole of that way: such gages cannot be steered by at all
HELD_USED = 2.0 / 3.0  # of the friction limit: a margin of 1.5, the most that people keep
_USED = (0.3, 0.6, 0.9)
_APART = 1.05  # friction above and below
_LEAST_CHANGE = 1e-4  # Of the stick ratio: smaller changes are rounding noise.


def amplifier_noise(hardware: HardwareTable, gage_factor: float = METAL_FACTOR) -> float:
    """Standard deviation of one sample of a gage, microstrain, with the converter's step, in
    squares.

    It is as ``[grip.hardware]`` says. Where that says nothing it is the reference amplifier's: a
    voltage, so that its strain falls as the gage factor rises.
    """
    own = hardware.gage_noise_microstrain or REFERENCE_NOISE * METAL_FACTOR / gage_factor
    return float(np.hypot(own, hardware.quantisation_microstrain / math.sqrt(12.0)))


def stick_changes(
    problem: ContactProblem,
    face: str,
    normal: float,
    friction: float,
    used: Sequence[float] = _USED,
) -> list[float]:
    """|de/dS|, microstrain, along one pull at ``normal`` N, at shares ``used`` of the friction
    limit; as far as it is carried, and where the stick ratio changes at all."""
    above = _pull(problem.with_friction(friction * _APART), face, normal, friction, used)
    below = _pull(problem.with_friction(friction / _APART), face, normal, friction, used)
    return [
        float(np.linalg.norm(more[0] - less[0])) / abs(more[1] - less[1])
        for more, less in zip(above, below, strict=False)
        if abs(more[1] - less[1]) > _LEAST_CHANGE
    ]


def _pull(
    problem: ContactProblem, face: str, normal: float, friction: float, used: Sequence[float]
) -> list[tuple[Array, float]]:
    """Readings and stick ratio at each share of the friction limit, as far as it is carried."""
    state, found, workspace = ContactState.untouched(problem), [], Workspace()
    for share in (0.0, *used):
        forces = Forces(normal, share * friction * normal)
        try:
            increment = solve_forces(problem, state, forces, workspace)
        except SolverError:
            break
        state = increment.state
        reported = measure(problem, increment)
        if share > 0.0 and reported.stick_ratio is not None:
            found.append((gage_readings(reported.gages, face), reported.stick_ratio))
    return found


def measured_states(
    problem: ContactProblem, face: str, loads: Iterable[tuple[float, float]], noise: float
) -> tuple[MeasuredState, ...]:
    """Smallest slip that one sample in ``noise`` (microstrain) shows under each load.

    loads: (friction, F_n in N), held with a margin of 1.5; those that the model does not reach, or
    whose gages are silent, are left out.
    """
    found = []
    for friction, normal in loads:
        own = problem.with_friction(friction)
        try:
            pressed = solve_forces(own, ContactState.untouched(own), Forces(normal, 0.0))
            response = float(np.abs(stick_response(own, pressed, face)).max(initial=0.0))
        except SolverError:
            continue
        changes = stick_changes(problem, face, normal, friction, (HELD_USED,))
        if not changes or not changes[0] > 0.0 or not response > 0.0:
            continue
        found.append(
            MeasuredState(
                friction_coefficient=friction,
                normal_force_N=normal,
                tangential_force_N=HELD_USED * friction * normal,
                response_microstrain_per_N=response,
                stick_change_microstrain=changes[0],
                smallest_stick_change=SEEN * noise / changes[0],
                smallest_force_change_N=SEEN * noise / response,
            )
        )
    return tuple(found)
