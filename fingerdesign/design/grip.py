"""The ``[grip]`` table: the lifts that are simulated next to the fundamental case."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import ConfigDict, Field, TypeAdapter, WrapValidator, model_validator
from pydantic_core import PydanticCustomError

from fingerdesign.arrays import Array
from fingerdesign.design.base import (
    LEAST,
    Many,
    Named,
    Pair,
    Table,
    bounded,
    key,
    positive,
    refuse,
    refuse_key,
    table_fields,
)
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.runtime.streams import stream

GRAVITY = 9.80665  # m/s^2
FORCE_NOISE_N = 0.005  # A good force cell's standard deviation of a sample.
# A milligram, and a friction below that of ice on ice or of any rubber: lighter and slipperier
# objects are errors of units, and forces divide by both.
LEAST_MASS_G, MOST_MASS_G, LEAST_FRICTION = 1e-3, 1e5, 1e-3

PlantName = Literal["finger", "lift"]
OppositeName = Literal["mirror", "bare"]
_Share = Annotated[float, Field(gt=0, lt=1)]
_Seconds = Annotated[float, Field(gt=0, le=1e6)]
_PlateNumber = Annotated[int, Field(ge=0, le=100_000)]
Friction = Annotated[float, Field(ge=LEAST_FRICTION, le=5)]
_Mass = Annotated[float, Field(ge=LEAST_MASS_G, le=MOST_MASS_G)]
_STRICT = ConfigDict(strict=True, allow_inf_nan=False)
_ONE: TypeAdapter[float] = TypeAdapter(_Mass, config=_STRICT)
_BOTH: TypeAdapter[tuple[float, float]] = TypeAdapter(Pair[_Mass, _Mass], config=_STRICT)


class Tug(Table):
    """``[[grip.tugs]]``: something pulls at the lifted object."""

    step_after_lift: int = Field(
        ge=1, le=100_000, description="first control step of it; 1 is the next after the lift"
    )
    extra_force_N: float = Field(
        ge=-1e5, le=1e5, description="down where positive, on top of the weight"
    )
    duration_steps: int = bounded(1, 1, 100_000, "control steps it lasts")


class WeightChange(Table):
    """``[[grip.weight_changes]]``: the lifted object has another mass from a step on."""

    step_after_lift: int = Field(ge=1, le=100_000, description="1 is the next after the lift")
    object_mass_g: _Mass = Field(description="its mass from then on")


def weight_per_finger(object_mass_g: float) -> float:
    """m g / 2 in N: two like fingers carry half the weight each.

    >>> round(weight_per_finger(200.0), 4)
    0.9807
    """
    return 0.5e-3 * GRAVITY * object_mass_g


def mass_at(step: int, mass_g: float, changes: Iterable[WeightChange]) -> float:
    """The object's mass ``step`` control steps after the lift, g; changes in their order in
    time."""
    for change in sorted(changes, key=lambda each: each.step_after_lift):
        mass_g = change.object_mass_g if change.step_after_lift <= step else mass_g
    return mass_g


def pull_at(
    step: int, mass_g: float, tugs: Iterable[Tug], changes: Iterable[WeightChange]
) -> float:
    """Return the force that pulls at the object ``step`` control steps after the lift, N."""
    extra, mass_g = 0.0, mass_at(step, mass_g, changes)
    for tug in tugs:
        if 0 <= step - tug.step_after_lift < tug.duration_steps:
            extra += tug.extra_force_N
    return 1e-3 * GRAVITY * mass_g + extra


def lifting_tugs(
    mass_g: float, tugs: Sequence[Tug], changes: Sequence[WeightChange]
) -> Iterator[tuple[int, float]]:
    """Find every tug that lifts the object out of the fingers: its number, and the least force that
    then pulls at the object, N (below 0).

    The force changes where something begins; between it can only return.
    """
    begins = [tug.step_after_lift for tug in tugs] + [each.step_after_lift for each in changes]
    for number, tug in enumerate(tugs):
        last = tug.step_after_lift + tug.duration_steps - 1
        during = [step for step in begins if tug.step_after_lift <= step <= last]
        least = min(pull_at(step, mass_g, tugs, changes) for step in during)
        if tug.extra_force_N < 0.0 and least < 0.0:
            yield number, least


class HardwareTable(Table):
    """``[grip.hardware]``: imperfections of sensors and stage; the defaults are perfect."""

    gage_noise_microstrain: float = bounded(
        0.0, 0, 1e5, "standard deviation of one sample; 0.5 is a good strain amplifier at 100 Hz"
    )
    gage_noise_microvolt_per_V: float = bounded(
        0.0,
        0,
        1e5,
        "standard deviation of one sample of the bridge's output, the amplifier's own; counts "
        "in addition to the noise in microstrain, in squares",
    )
    drift_microstrain_per_s: float = bounded(
        0.0, 0, 1e5, "each gage drifts steadily, at a rate of this standard deviation"
    )
    gain_spread: float = bounded(0.0, 0, 1, "standard deviation of the gages' relative gain errors")
    dead_gages: Many[_PlateNumber] = key(
        (), "plates (from 0) whose gages do not respond", max_length=1000
    )
    dying_gages: Many[_PlateNumber] = key(
        (), "plates whose gages die during the grip: read 0", max_length=1000
    )
    dying_after_s: float = bounded(0.1, 0, 1e5, "when they do, from the first contact on")
    gage_cross_talk: float = bounded(
        0.0, -1, 1, "part of its neighbours' readings in the row that each gage reads too"
    )
    warming_microstrain: float = bounded(
        0.0, -1e5, 1e5, "reading of all gages from the change of temperature since first contact"
    )
    warming_time_s: float = positive(3.0, 1e6, "time constant of that")
    quantisation_microstrain: float = bounded(0.0, 0, 1e5, "step of the converter; 0: none")
    force_noise_N: float = bounded(0.0, 0, 1e5, "standard deviation of one sample of either force")
    torque_noise_Nmm: float | None = bounded(
        None,
        0,
        1e5,
        "standard deviation of one sample of the torque about the contact's normal; without it the "
        "force cell has two axes alone",
        example=0.05,
    )
    force_gain_spread: float = bounded(
        0.0, 0, 1, "standard deviation of the two force cells' relative gain errors"
    )
    force_cross_talk: float = bounded(
        0.0, -1, 1, "part of the normal force that the tangential cell reads too"
    )
    sample_rate_Hz: float = positive(100.0, 1e6, "samples, and control steps, a second")
    delay_samples: int = bounded(0, 0, 1000, "delay of everything that the controller receives")
    actuator_lag_s: float = bounded(
        0.0, 0, 10, "time constant with which each axis of the stage follows its target"
    )
    backlash_mm: float = bounded(0.0, 0, 5, "travel that each axis of the stage loses at a turn")
    stage_step_mm: float = bounded(0.0, 0, 5, "the stage moves in whole steps of this; 0: any way")
    specimen: int = bounded(
        0, 0, 2**32 - 1, "which of many such rigs: its gains are drawn from this number"
    )

    def at_rest(self, samples: int = 100) -> HardwareTable:
        """Return the same rig at rest: it takes the mean of ``samples`` at each point.

        Noise falls with the square root of their number. There is no delay, drift, warming or lag,
        as gages are zeroed between, and none dies. Gains, cross-talk, dead gages and the stage are
        unchanged.
        """
        fall, torque = 1.0 / np.sqrt(samples), self.torque_noise_Nmm
        rested = {
            "gage_noise_microstrain": float(self.gage_noise_microstrain * fall),
            "gage_noise_microvolt_per_V": float(self.gage_noise_microvolt_per_V * fall),
            "force_noise_N": float(self.force_noise_N * fall),
            "torque_noise_Nmm": torque if torque is None else float(torque * fall),
            "drift_microstrain_per_s": 0.0,
            "warming_microstrain": 0.0,
            "dying_gages": (),
            "delay_samples": 0,
            "actuator_lag_s": 0.0,
        }
        return self.model_copy(update=rested)

    def gains(self, plates: Sequence[int]) -> Array:
        """Reading per true strain (g,) of the gages of these plates: 1 but for the spread, 0 dead.
        A plate's gain is its own, whichever other gages there are."""
        gains = np.ones(len(plates))
        if self.gain_spread > 0.0:  # a generator a plate takes as long as a step of a grip
            draws = [stream(self.specimen, "gage gain", p).standard_normal() for p in plates]
            gains += self.gain_spread * np.array(draws)
        dead = np.isin(plates, self.dead_gages)
        return np.where(dead, 0.0, gains)

    def force_gains(self) -> Array:
        """Return measured per true force, normal and tangential, (2,)."""
        if self.force_gain_spread == 0.0:
            return np.ones(2)
        draw = stream(self.specimen, "force gains").standard_normal(2)
        return np.asarray(1.0 + self.force_gain_spread * draw)


def _one_or_range(value: Any, _handler: Any) -> float | tuple[float, float]:
    """A mass, or the lightest and the heaviest; equal ones are one mass."""
    if not isinstance(value, list | tuple):
        return _ONE.validate_python(value)
    light, heavy = _BOTH.validate_python(value)
    if light > heavy:
        raise refuse(value, "[lightest, heaviest]", f"write [{heavy:g}, {light:g}]")
    return light if light == heavy else (light, heavy)


Masses = Annotated[_Mass | Pair[_Mass, _Mass], WrapValidator(_one_or_range)]


def _or_auto(schema: dict[str, Any]) -> None:
    """In a key's JSON schema: its number, or "auto"."""
    number = {key: schema.pop(key) for key in list(schema) if key not in ("default", "title")}
    words = number.pop("description")
    both = [number, {"const": "auto"}]
    schema |= {"anyOf": both, "default": "auto", "description": words}


def _followed(default: float | None, least: float, most: float, description: str) -> Any:
    """A number's key that follows finger and object where it is absent or "auto"."""
    words = f'{description}; absent or "auto": by grip.defaults'
    return key(default, words, ge=least or LEAST, le=most, json_schema_extra=_or_auto)


class Grip(Table):
    """Lift of an object by two like fingers; the object moves relative to each finger's base.

    One set of controller parameters serves every friction coefficient: the controller is given
    neither the friction nor the mass.
    """

    # Left out or "auto" they follow the finger (checks/follow.py); model_fields_set holds the rest.
    FOLLOWING: ClassVar[tuple[str, ...]] = (
        *("max_approach_mm", "preload_mm", "approach_step_mm", "shear_step_mm", "max_steps"),
        *("curve_per_N", "force_floor_N", "hold_force_N", "fundamental_approach_mm"),
    )
    defaults: Literal["follow", "fixed"] = key(
        "follow",
        "follow: keys left out follow finger and object; fixed: they are those of a "
        "rubber of 5 MPa and 500 g",
    )

    friction_coefficients: Many[Friction] = key(
        (0.3, 0.5, 0.8),
        "one lift each; the controller is not given it",
        min_length=1,
        max_length=100,
    )
    kinetic_share: float = key(
        1.0, "part of the friction coefficient that is left where the contact slides", gt=0, le=1
    )
    object_mass_g: Masses = key(
        500.0,
        "two fingers carry half the weight each; [lightest, heaviest]: both are "
        "lifted, and where both pass one between them, and the worst counts",
    )
    plant: PlantName = key(
        "finger",
        "finger: one finger on a stage, lifted where 2 F_t exceeds the weight, as in "
        "the paper; lift: two fingers and the object on its support, which then hangs from them",
    )
    opposite: OppositeName = key(
        "mirror",
        "lift: the other finger; mirror: a mirror image, half of all forces each; "
        "bare: the same body without plates, a second model",
    )
    off_centre_mm: float = bounded(
        0.0,
        -200,
        200,
        "lift, in 3-D: z of the object's centre of mass from the middle of the contact; its weight "
        "turns the object between the fingers, and more than 10 degrees is a drop",
    )
    hold_steps: int = bounded(
        0, 0, 100_000, "lift: control steps for which the lifted object is held on"
    )
    relaxation_per_minute: float = bounded(
        0.0, 0, 0.9, "lift: part of its forces that a finger held still loses in a minute"
    )
    rubber_memory: Many[Pair[_Share, _Seconds]] = key(
        (),
        "lift: a Prony series of the rubber, [share, time in s] each: of a force held "
        "at the same motions the part that is lost with that time constant",
        max_length=20,
        examples=[[[0.1, 0.05], [0.1, 2.0]]],
    )
    warming_K: float = bounded(
        0.0, -200, 200, "lift: rise of the fingers' temperature from first contact on; they expand"
    )
    warming_s: float = positive(60.0, 1e6, "time constant of that")
    inertia: bool = key(
        False,
        "lift: an object that friction cannot carry slides by its mass, and is caught "
        "or dropped; else it has dropped at once",
    )
    drop_mm: float = positive(
        10.0, 1e4, "with inertia: an object that slides farther than this has dropped"
    )
    tugs: Many[Tug] = key((), "lift: pulls at the object while it hangs", max_length=1000)
    weight_changes: Many[WeightChange] = key(
        (), "lift: changes of the hanging object's mass", max_length=1000
    )
    hardware: HardwareTable = Field(default_factory=HardwareTable)
    controller: Annotated[str, Named(CONTROLLERS)] = key(
        "paper",
        "paper: the flow chart of Maeno et al. 2000, Fig. 9; oracles are given "
        "friction and mass and hold 1.2 or 1.5 times the least force",
    )
    preload_mm: float = _followed(0.03, 0, 50, "approach before the first tangential move")
    approach_step_mm: float = _followed(0.004, 0, 5, "normal move of one control step")
    shear_step_mm: float = _followed(0.03, 0, 5, "largest tangential move of one control step")
    max_steps: int = _followed(200, 1, 100_000, "give up after so many")
    max_approach_mm: float = _followed(0.4, 0, 50, "stage travel; the contact zone must hold it")
    curve_per_N: float = _followed(
        0.1, 0, 1e3, "F_t rises by this times the square of F_n's rise since the last hold"
    )
    threshold_share: float = key(
        0.4,
        "a gage counts as over stick where its response to F_t exceeds this share of "
        "the strongest gage's at full stick (the rig measures that itself)",
        gt=0,
        lt=1,
    )
    force_floor_N: float = _followed(0.1, 0, 1e3, "change of F_t that a response is made from")
    dead_band_mm: float = bounded(
        0.05,
        0,
        50,
        "the stick region shrinks once the gage area is this far below its largest "
        "value since the last hold",
    )
    hold_force_N: float = _followed(
        0.5, 0, 1e3, "a hold (dx = 0) lasts until F_n has risen by this; at least one step"
    )
    fundamental_approach_mm: float | None = _followed(
        None,
        0,
        50,
        "how deep the fundamental case presses, its shears in proportion; with fixed defaults: as "
        "the shipped scene says",
    )
    bench_friction_coefficient: float = positive(
        0.5, 5, "of the surface that the rig is calibrated on, not of the object"
    )
    warning_stick_ratio: float = bounded(
        0.3, 0, 1, "for reports: a controller that reports a stick ratio below it warns of slip"
    )
    seed: int = bounded(0, 0, 2**32 - 1, "seed of all noise")

    @property
    def masses_g(self) -> tuple[float, ...]:
        """The masses that decide, lightest first: the ends of the range, or the one."""
        mass = self.object_mass_g
        return mass if isinstance(mass, tuple) else (mass,)

    @property
    def lightest_g(self) -> float:
        """The least mass: it has the least force that holds, and the least signal."""
        return self.masses_g[0]

    @property
    def heaviest_g(self) -> float:
        """The greatest mass: it takes the most travel."""
        return self.masses_g[-1]

    @property
    def middle_g(self) -> float | None:
        """The mass between the ends, evenly in the logarithm; None of one mass."""
        if len(self.masses_g) == 1:
            return None
        return float(f"{np.sqrt(self.lightest_g * self.heaviest_g):.3g}")

    def most_pull(self, mass_g: float) -> float | None:
        """The most that pulls at an object in the steps of tugs and changes of its mass, N; None
        without any. It changes only where one of them begins or ends."""
        spans = [(each.step_after_lift, each.duration_steps) for each in self.tugs]
        spans += [(each.step_after_lift, 1) for each in self.weight_changes]
        steps = {step for first, count in spans for step in (first, first + count)}
        during = [s for s in steps if any(0 <= s - first < count for first, count in spans)]
        events = self.tugs, self.weight_changes
        return max((pull_at(step, mass_g, *events) for step in during), default=None)

    def pulled_g(self, mass_g: float) -> float:
        """The mass that weighs as much as the most that pulls at an object until the end, g."""
        return max(mass_g, 1e3 * (self.most_pull(mass_g) or 0.0) / GRAVITY)

    @model_validator(mode="before")
    @classmethod
    def _without_auto(cls, data: Any) -> Any:
        """A key that is "auto" is left out."""
        if not isinstance(data, Mapping):
            return data
        return {k: v for k, v in data.items() if not (v == "auto" and k in cls.FOLLOWING)}

    def _misfits(self) -> Iterable[PydanticCustomError]:
        """Rubber keeps some of its force at all times."""
        key = "grip.rubber_memory"
        if sum(share for share, _ in self.rubber_memory) >= 1.0:
            yield refuse_key(self, key, "shares of less than 1 together", "lose less")


# The tables of the controllers, ``[grip.NAME]``, each from the file that holds its controller.
table_fields(Grip, CONTROLLERS, before="seed")
