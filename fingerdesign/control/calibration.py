"""Calibration of a rig on its own finger before any grip: bench moves, gages and forces only.

1. Press without shear as far as the stage goes and record readings against F_n. A grip moves both
   ways at once, and F_n strains the gages more than F_t does: this record takes F_n's part out.
2. Press to the preload of a grip and shear a little. Nearly everything sticks, so the response of
   the gages to F_t is the design's own scale, and dF_t/dx the first guess of the stiffness.
3. The same at a few depths more, up to all of the stage's: the response grows as the contact does.
4. One quick press: how many samples it takes until it is measured.
5. Slide one way, then the other, until F_t rises no more. Friction is the same both ways, so the
   mean of both F_t / F_n is what the cell of F_t feels of F_n: a hundredth of F_n is a twentieth
   of what a slippery object is held by.

The press takes the same steps as a grip: coarser ones, with straight lines between, put kinks into
what is taken out, and a kink looks like a fall of A (steps growing by 4 % of the depth were tried:
two false holds more at mu = 0.3).

The surface on the bench is not the object's: its friction is a parameter of the bench. Pressed
without shear, the finger hardly responds to the friction.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Self

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.plants.plant import Plant, PlantMaker, press
from fingerdesign.control.signals import Calibration, NormalCalibration, line_of, response
from fingerdesign.design.grip import Grip
from fingerdesign.errors import SolverError

LEAST_GAGES = 2  # A hand's finger has so many: the rule compares them.
LEAST_SHEARS = 2
Shear = tuple[float, Array, float]  # F_n before a small shear, microstrain per N of F_t, dF_t/dx
# The first shear is this fraction of the preload: F_t is then 2 % of F_n, far from slip at any
# usual friction.
_SMALL_SHEAR = 0.05
# Each of so many depths is sheared by this fraction of itself: F_t is then 8 % of F_n, which noise
# at rest changes by some per cent only.
DEPTHS, STICKING_SHEAR = 6, 0.2
# The slides are at this fraction of the stage's travel, in steps of this fraction of the depth.
SLIDE_DEPTH, _SLIDE_STEP = 0.5, 0.4
# A smaller rise of F_t in a step, as a fraction of it, is none; a slide has at most so many steps.
_RISES, _MOST_SLIDES = 0.01, 40
# So many samples are averaged; more samples than any hardware's delay are waited for.
_MEAN, _PATIENCE = 10, 1100


@dataclass(frozen=True)
class Bounds:
    """Limits of a grip: mm, mm, mm, control steps."""

    preload: float
    approach_step: float
    max_approach: float
    max_steps: int

    @classmethod
    def of(cls, grip: Grip) -> Self:
        """Read a design's ``[grip]`` table."""
        return cls(grip.preload_mm, grip.approach_step_mm, grip.max_approach_mm, grip.max_steps)


def calibrate(
    make_plant: PlantMaker, gage_x: Array, bounds: Bounds, make_moving: PlantMaker | None = None
) -> Calibration:
    """Run the bench moves, each on a fresh plant.

    make_plant: at rest at each point; make_moving: as the rig feels a grip, None without a delay.
    Raises SolverError where the plant fails, or where nothing is measured: no gages, no force.
    """
    in_line = len(line_of(gage_x))
    if in_line < LEAST_GAGES:
        raise SolverError(
            f"the grip's rule needs at least {LEAST_GAGES} gages in a row along x, the design has "
            f"{in_line}; add plates"
        )
    samples = list(press(make_plant(), bounds.max_approach, bounds.approach_step))
    forces = np.array([0.0, *(sample.normal_force for sample in samples)])
    approach = np.linspace(0.0, bounds.max_approach, len(forces))  # press moves evenly
    readings = np.array([np.zeros_like(samples[0].readings), *(s.readings for s in samples)])
    # A mesh may have no node on the crest: F_n begins some steps after first contact.
    begin = max(int(np.argmax(forces > 0.0)) - 1, 0)
    forces, approach, readings = forces[begin:], approach[begin:], readings[begin:]
    if len(forces) < 2 or not (np.diff(forces) > 0.0).all():
        raise SolverError("pressed without shear, the normal force does not rise at every step")
    normal = NormalCalibration(forces, readings)

    plant = make_plant()
    *_, pressed = press(plant, bounds.preload, bounds.approach_step)
    shear = _SMALL_SHEAR * bounds.preload
    sheared = plant.move(shear, 0.0)
    rise = sheared.tangential_force - pressed.tangential_force
    if not rise > 0.0:
        raise SolverError(f"a shear of {shear:g} mm at the preload gives no tangential force")
    full_stick = response(pressed, sheared, normal)
    if not full_stick.max() > 0.0:
        raise SolverError("no gage answers to a shear at the preload")
    sticking, stiffness = rising(_sheared(make_plant, bounds, normal))
    delay = 0
    if make_moving is not None:
        force = float(np.interp(bounds.preload, approach, forces))
        delay = delay_of(_quick_press(make_moving(), bounds.preload), force)
    return Calibration(
        gage_x=np.asarray(gage_x, dtype=float),
        normal=normal,
        full_stick=full_stick,
        tangential_stiffness=rise / shear,
        sticking=sticking,
        stiffness=stiffness,
        approach=approach,
        delay=delay,
        cross_talk=_cross_talk(make_plant, bounds),
    )


def _cross_talk(make_plant: PlantMaker, bounds: Bounds) -> float:
    """Half the sum of F_t / F_n as it slides to either side; 0 where friction holds it to the end.

    Of two gains g and a cross-talk c, F_t = g_t (+-mu F_n + c F_n), and F_n = g_n F_n.
    """
    right, left = (_slid(make_plant(), bounds, way) for way in (1.0, -1.0))
    return 0.0 if right is None or left is None else 0.5 * (right + left)


def _slid(plant: Plant, bounds: Bounds, way: float) -> float | None:
    """F_t / F_n once it rises no more, twice as far as that was seen; None where it always does."""
    depth = SLIDE_DEPTH * bounds.max_approach
    for sample in press(plant, depth, max(bounds.approach_step, 0.2 * depth)):
        before = sample
    for steps in range(1, _MOST_SLIDES):
        now = plant.move(way * _SLIDE_STEP * depth, 0.0)
        rise = way * (now.tangential_force - before.tangential_force)
        if rise < _RISES * abs(now.tangential_force):
            now = plant.move(way * steps * _SLIDE_STEP * depth, 0.0)
            return now.tangential_force / now.normal_force
        before = now
    return None


def delay_of(forces: Iterable[float], force: float) -> int:
    """Samples of F_n from a quick press until ``force`` (N): the likeliest step in noise.

    Raises SolverError where it is not reached.
    """
    measured: list[float] = []
    for each in islice(forces, _PATIENCE):
        measured.append(each)
        if len(measured) >= _MEAN and np.mean(measured[-_MEAN:]) >= 0.75 * force:
            break
    else:
        raise SolverError(f"a quick press is not measured within {len(measured)} samples")
    still, pressed = np.square(measured), np.square(np.array(measured) - force)
    return int(np.argmin([0.0, *np.cumsum(still - pressed)]))


def _quick_press(plant: Plant, preload: float) -> Iterator[float]:
    """Normal forces from a press in one move on, N."""
    yield plant.move(0.0, preload).normal_force
    while True:
        yield plant.move(0.0, 0.0).normal_force


def _sheared(make_plant: PlantMaker, bounds: Bounds, normal: NormalCalibration) -> Iterator[Shear]:
    """Small shears at a few depths; as noisy as without a rise of F_t, a depth gives nothing."""
    for depth in np.geomspace(bounds.preload, bounds.max_approach, DEPTHS).tolist():
        plant = make_plant()
        *_, before = press(plant, depth, max(bounds.approach_step, 0.2 * depth))
        shear = STICKING_SHEAR * depth
        now = plant.move(shear, 0.0)
        rise = now.tangential_force - before.tangential_force
        if rise > 0.0:
            alone = normal.at(now.normal_force) - normal.at(before.normal_force)
            response = (now.readings - before.readings - alone) / rise
            yield before.normal_force, response, rise / shear


def rising(sheared: Iterable[Shear]) -> tuple[NormalCalibration, Array]:
    """Responses (k, g) by the F_n (k,) of shears, and dF_t/dx (k,), N/mm; those that rise.

    Raises SolverError where they are too few.
    """
    found: list[Shear] = []
    for each in sheared:
        if each[2] > 0.0 and (not found or each[0] > found[-1][0]):
            found.append(each)
    if len(found) < LEAST_SHEARS:
        raise SolverError("sheared on the bench, the finger gives no rising tangential force")
    forces, responses, stiffness = (np.array(each) for each in zip(*found, strict=True))
    return NormalCalibration(forces, responses), stiffness
