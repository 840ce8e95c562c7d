"""Faults between the keys of ``[grip]`` that say what is gripped, and with what hardware."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fingerdesign.errors import Fault

if TYPE_CHECKING:
    from fingerdesign.design.grip import Grip
    from fingerdesign.design.schema import Design

_GRAVITY = 9.80665  # m/s^2
_LEAST_GAGES = 2
_BENCH_SHEAR = 0.05  # of the preload: what the bench shears by (control/calibration.py)


def plant_faults(design: Design) -> list[Fault]:
    """Faults of ``[grip]``'s plant: a lift's keys without a lift, gages that are not there, a
    stage too coarse."""
    faults = [*_lift_faults(design.grip), *_dead_gage_faults(design), *_stage_faults(design.grip)]
    if design.grip.opposite == "bare" and design.mesh.mesher == "file":
        remedy = "the mesh's file holds the plates: take the mirror image"
        faults.append(Fault("grip.opposite", "bare", "'mirror' with mesh.mesher = 'file'", remedy))
    return faults


def _lift_faults(grip: Grip) -> list[Fault]:
    events = [
        (f"grip.{table}[{k}]", each.step_after_lift)
        for table in ("tugs", "weight_changes")
        for k, each in enumerate(getattr(grip, table))
    ]
    if grip.plant != "lift":
        remedy = 'set grip.plant = "lift": there alone an object hangs from the fingers'
        faults = [Fault(key, "given", "left out", remedy) for key, _ in events]
        if grip.opposite != "mirror":
            faults.append(Fault("grip.opposite", grip.opposite, "'mirror'", remedy))
        if grip.hold_steps:
            faults.append(Fault("grip.hold_steps", grip.hold_steps, "0", remedy))
        return faults
    bound = f"at most grip.hold_steps = {grip.hold_steps}"
    remedy = "hold the object on for longer, or begin sooner"
    late = [
        Fault(f"{key}.step_after_lift", step, bound, remedy)
        for key, step in events
        if step > grip.hold_steps
    ]
    return late + _twice_faults(grip) + _upward_faults(grip)


def _twice_faults(grip: Grip) -> list[Fault]:
    """Weight changes at one step: none of them would be the one meant."""
    steps = [each.step_after_lift for each in grip.weight_changes]
    bound = "a step of its own"
    return [
        Fault(f"grip.weight_changes[{k}].step_after_lift", step, bound, "change the weight once")
        for k, step in enumerate(steps)
        if step in steps[:k]
    ]


def _upward_faults(grip: Grip) -> list[Fault]:
    """Tugs that lift the object out of the fingers, wherever something else begins beside them."""
    begins = [each.step_after_lift for each in grip.tugs]
    begins += [each.step_after_lift for each in grip.weight_changes]
    faults = []
    for k, tug in enumerate(grip.tugs):
        last = tug.step_after_lift + tug.duration_steps - 1
        steps = [step for step in begins if tug.step_after_lift <= step <= last]
        least = min((_weight(grip, step) for step in steps), default=0.0)
        if tug.extra_force_N < 0.0 and least < 0.0:
            bound = f"no more upward than the weight allows, {-tug.extra_force_N + least:.3g} N"
            remedy = "tug less, or lift a heavier object"
            key = f"grip.tugs[{k}].extra_force_N"
            faults.append(Fault(key, tug.extra_force_N, bound, remedy))
    return faults


def _weight(grip: Grip, step: int) -> float:
    """What pulls at the object ``step`` control steps after the lift, N."""
    changes = [each for each in grip.weight_changes if each.step_after_lift <= step]
    last = max(changes, key=lambda each: each.step_after_lift, default=None)
    mass = grip.object_mass_g if last is None else last.object_mass_g
    tugs = (
        tug.extra_force_N
        for tug in grip.tugs
        if tug.step_after_lift <= step < tug.step_after_lift + tug.duration_steps
    )
    return 1e-3 * _GRAVITY * mass + sum(tugs)


def _dead_gage_faults(design: Design) -> list[Fault]:
    dead, plates = design.grip.hardware.dead_gages, design.plates.number
    if len(set(dead)) < len(dead):
        return [Fault("grip.hardware.dead_gages", list(dead), "each once", "say a plate once")]
    wrong = [plate for plate in dead if plate >= plates]
    if not wrong:
        if len(dead) <= max(plates - _LEAST_GAGES, 0):
            return []
        bound = f"at most {max(plates - _LEAST_GAGES, 0)} of the design's {plates}"
        remedy = f"leave {_LEAST_GAGES} gages that answer: a rig is calibrated by them"
        return [Fault("grip.hardware.dead_gages", list(dead), bound, remedy)]
    bound = f"plates 0 to {plates - 1}" if plates else "empty: the design has no plates"
    return [Fault("grip.hardware.dead_gages", wrong, bound, "name plates that there are")]


def _stage_faults(grip: Grip) -> list[Fault]:
    """A stage too coarse for the moves that calibrate the finger: some would be no move at all."""
    step = grip.hardware.stage_step_mm
    least = min(0.5 * grip.approach_step_mm, _BENCH_SHEAR * grip.preload_mm)
    if step <= least:
        return []
    bound = f"at most {least:.4g}: half of grip.approach_step_mm, {_BENCH_SHEAR:g} grip.preload_mm"
    remedy = "take a finer stage, or longer moves"
    return [Fault("grip.hardware.stage_step_mm", step, bound, remedy)]
