"""Imperfect hardware around any plant: gages, amplifier, force cell, stage (numpy only).

The stage goes where it is sent in whole steps, with a lag, and loses its play at each turn; the
sensors add what is below, in this order, and report it some samples late:

    gage = round_q( gain * (strain + c neighbours) + drift t + w (1 - exp(-t / T)) + noise )
    F_n = gain F_n + noise,   F_t = gain (F_t + c F_n) + noise,   torque = torque + noise

with gain 0 for gages that are dead, or have died; neighbours are the next ones in the readings.

One move of the plant is one sample. Gains belong to a specimen of the hardware and are drawn from
its own number: a rig that is calibrated and then grips has the same gains both times. Noise and
drift come from the generator given: the same seed gives the same readings.
"""

from collections import deque
from collections.abc import Sequence

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.plants.plant import Plant, Truth
from fingerdesign.control.signals import Sample
from fingerdesign.design.grip import HardwareTable

Hardware = HardwareTable


class ImperfectPlant:
    """A plant as imperfect hardware moves and feels it; its truth is the plant's own.

    plates: numbers of the plates whose gages are read, in the order of the readings; without them
    0, 1, ... Equal draws for equal seeds, whatever the levels: two noise levels differ in scale
    alone. Before ``delay_samples`` moves the hand hears of an untouched finger. ValueError for
    noise that is not in microstrain.
    """

    def __init__(
        self,
        plant: Plant,
        hardware: Hardware,
        rng: np.random.Generator,
        plates: Sequence[int] | None = None,
    ) -> None:
        if hardware.gage_noise_microvolt_per_V > 0.0:
            raise ValueError("noise in microvolt per volt wants a bridge: take design.rig.hardware")
        self._plant, self._hardware, self._rng = plant, hardware, rng
        self._plates = plates
        self._gains: Array | None = None
        self._rates = self._force_gains = np.empty(0)
        self._dying = np.empty(0, dtype=bool)
        self._time = 0.0
        self._late: deque[Sample] = deque()
        fade = 0.0  # what is left of the way to where the stage is sent, after a sample's time
        if hardware.actuator_lag_s > 0.0:
            fade = float(np.exp(-1.0 / (hardware.sample_rate_Hz * hardware.actuator_lag_s)))
        self._axes = [_Axis(hardware.stage_step_mm, hardware.backlash_mm, fade) for _ in range(2)]

    def move(self, dx: float, dy: float) -> Sample:
        """Move as far as the stage does, read what the sensors say; see :class:`Plant`."""
        true = self._plant.move(self._axes[0].moved(dx), self._axes[1].moved(dy))
        self._time += 1.0 / self._hardware.sample_rate_Hz
        measured = self._measure(true)
        while len(self._late) < self._hardware.delay_samples:
            self._late.append(Sample(np.zeros_like(measured.readings), 0.0, 0.0))
        self._late.append(measured)
        return self._late.popleft()

    def truth(self) -> Truth:
        """The plant's state after the last move, for the judge."""
        return self._plant.truth()

    def _measure(self, true: Sample) -> Sample:
        hardware, gages = self._hardware, len(true.readings)
        if self._gains is None:
            plates = range(gages) if self._plates is None else self._plates
            self._gains = hardware.gains(list(plates))
            self._rates = hardware.drift_microstrain_per_s * self._rng.standard_normal(gages)
            self._dying = np.isin(plates, hardware.dying_gages)
            self._force_gains = hardware.force_gains()
        noise = self._rng.standard_normal(gages + 2)
        strain = true.readings
        if hardware.gage_cross_talk != 0.0:
            padded = np.pad(strain, 1)
            strain = strain + hardware.gage_cross_talk * (padded[:-2] + padded[2:])
        warmed = 1.0 - np.exp(-self._time / hardware.warming_time_s)
        died = self._dying & (self._time > hardware.dying_after_s)
        readings = np.where(died, 0.0, self._gains * strain) + self._rates * self._time
        readings += hardware.warming_microstrain * warmed
        readings += hardware.gage_noise_microstrain * noise[2:]
        if hardware.quantisation_microstrain > 0.0:
            step = hardware.quantisation_microstrain
            readings = step * np.round(readings / step)
        pulled = true.tangential_force + hardware.force_cross_talk * true.normal_force
        forces = self._force_gains * np.array([true.normal_force, pulled])
        normal, tangential = forces + hardware.force_noise_N * noise[:2]
        torque = None
        if hardware.torque_noise_Nmm is not None and true.torque is not None:
            torque = true.torque + hardware.torque_noise_Nmm * float(self._rng.standard_normal())
        return Sample(readings, float(normal), float(tangential), true.lifted, torque)


class _Axis:
    """One axis of a stage: whole steps, and play that a turn of the direction has to take up.

    Its drive follows where it is sent with a first-order lag, ``fade`` of what is missing being
    left after a move: x <- goal + fade (x - goal), exact for a goal that is set at once.
    The play lies behind at the start: the stage came up to touch in the positive direction.
    """

    def __init__(self, step: float, backlash: float, fade: float = 0.0) -> None:
        self._step, self._backlash, self._fade = step, backlash, fade
        self._requested = self._drive = 0.0
        self._play = 0.0  # way ahead of the drive, in the positive direction, until it pushes

    def moved(self, way: float) -> float:
        """Way of the stage, mm, when sent ``way``; steps left over are remembered."""
        if self._step == 0.0 and self._backlash == 0.0 and self._fade == 0.0:
            return way
        self._requested += way
        goal = self._requested
        if self._step > 0.0:
            goal = self._step * round(self._requested / self._step)
        goal += self._fade * (self._drive - goal)
        turned, self._drive = goal - self._drive, goal
        if turned >= 0.0:
            lost = min(self._play, turned)
            self._play -= lost
            return turned - lost
        lost = min(self._backlash - self._play, -turned)
        self._play += lost
        return turned + lost
