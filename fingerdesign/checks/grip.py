"""Faults between the keys of ``[grip]``: the object, the hardware, the stage's motions."""

from collections.abc import Iterator, Sequence

from fingerdesign.design.grip import Grip, lifting_tugs
from fingerdesign.design.schema import Design, Part
from fingerdesign.errors import Fault

_LEAST_GAGES = 2  # A rig is calibrated by the gages that respond; one cannot be compared.
_FOLLOWED = 2.0  # After so many time constants a stage that lags has reached its depth.
_PRESS_SAMPLES = 1050  # The bench waits so many samples for its quick press (control/calibration).
_SWELLING = 0.02  # Free strain up to which small strains are a good model.
_BENCH_SHEAR = 0.05  # The bench shears by this part of the preload (control/calibration).
_MOST_MOVES = 5000  # A grip takes about 50 moves; more than this is an error of units.


def grip_faults(design: Design) -> list[Fault]:
    """Find the faults of the object and the hardware, and of the stage's motions against each other
    and against the body."""
    grip = design.grip
    dead = grip.hardware.dead_gages
    faults = [
        *_lift_faults(grip),
        *_warming_faults(design),
        *_drop_faults(grip),
        *_dead_gage_faults(design, "dead_gages"),
        *_dead_gage_faults(design, "dying_gages", dead),
        *_stage_faults(grip),
    ]
    if grip.opposite == "bare" and design.mesh.mesher == "file":
        remedy = "the mesh's file holds the plates: take the mirror image"
        faults.append(Fault("grip.opposite", "bare", "'mirror' with mesh.mesher = 'file'", remedy))
    most = design.body.base_height_mm
    if grip.max_approach_mm > most:
        bound = f"at most body.base_height_mm = {most:g}"
        remedy = "shorten the stage's travel: the model is of small strains"
        faults.append(Fault("grip.max_approach_mm", grip.max_approach_mm, bound, remedy))
    travel = f"at most grip.max_approach_mm = {grip.max_approach_mm:g}"
    for key in ("preload_mm", "approach_step_mm"):
        value = getattr(grip, key)
        if value > grip.max_approach_mm:
            faults.append(Fault(f"grip.{key}", value, travel, "the stage could not move so far"))
    if grip.preload_mm == grip.max_approach_mm:
        bound = f"below grip.max_approach_mm = {grip.max_approach_mm:g}"
        faults.append(Fault("grip.preload_mm", grip.preload_mm, bound, "leave travel to grip with"))
    least = grip.max_approach_mm / _MOST_MOVES
    if grip.approach_step_mm < least:
        bound = f"at least grip.max_approach_mm / {_MOST_MOVES} = {least:g}"
        remedy = "the travel would take too many moves"
        faults.append(Fault("grip.approach_step_mm", grip.approach_step_mm, bound, remedy))
    return faults


def _drop_faults(grip: Grip) -> list[Fault]:
    """Find a length of slide without inertia: nothing slides then."""
    if grip.inertia or grip.drop_mm == type(grip).model_fields["drop_mm"].default:
        return []
    remedy = "set grip.inertia = true, or leave it out: without inertia what slips has dropped"
    return [Fault("grip.drop_mm", grip.drop_mm, "left out where grip.inertia is false", remedy)]


def _lift_faults(grip: Grip) -> list[Fault]:
    """Find the faults of keys that need an object which hangs from the fingers."""
    if grip.plant != "lift":
        return list(_unused_lift_keys(grip))
    return [*_event_faults(grip), *_tug_faults(grip), *_turning_faults(grip)]


def _turning_faults(grip: Grip) -> Iterator[Fault]:
    """Find what a lift of an object that turns does not know."""
    if not grip.off_centre_mm:
        return
    remedy = "leave one of them out: an object that turns is held by two like fingers, at rest"
    for name, bound in (("opposite", "'mirror'"), ("inertia", "false")):
        if (value := getattr(grip, name)) != Grip.model_fields[name].default:
            shown = "true" if value is True else value
            yield Fault(f"grip.{name}", shown, f"{bound} with grip.off_centre_mm", remedy)


def _events(grip: Grip) -> list[tuple[str, int]]:
    """List key and step of each tug and each change of weight."""
    return [
        (f"grip.{table}[{k}]", each.step_after_lift)
        for table in ("tugs", "weight_changes")
        for k, each in enumerate(getattr(grip, table))
    ]


def _unused_lift_keys(grip: Grip) -> Iterator[Fault]:
    """Find keys that only the plant "lift" reads."""
    remedy = 'set grip.plant = "lift": there alone an object hangs from the fingers'
    for key, _ in _events(grip):
        yield Fault(key, "given", "left out", remedy)
    for name, bound in (
        ("opposite", "'mirror'"),
        ("off_centre_mm", "0"),
        ("hold_steps", "0"),
        ("relaxation_per_minute", "0"),
        ("rubber_memory", "left out"),
        ("warming_K", "0"),
        ("inertia", "false"),
    ):
        value = getattr(grip, name)
        if value != Grip.model_fields[name].default:
            shown = {"rubber_memory": "given", "inertia": "true"}.get(name, value)
            yield Fault(f"grip.{name}", shown, bound, remedy)


def _event_faults(grip: Grip) -> Iterator[Fault]:
    """Find events after the end, a rubber described twice, and two weights in one step."""
    bound, remedy = f"at most grip.hold_steps = {grip.hold_steps}", "hold the object longer"
    for key, step in _events(grip):
        if step > grip.hold_steps:
            yield Fault(f"{key}.step_after_lift", step, bound, f"{remedy}, or begin sooner")
    if (share := grip.relaxation_per_minute) and grip.rubber_memory:
        both, one = "0 where grip.rubber_memory is given", "give either: both are the same rubber"
        yield Fault("grip.relaxation_per_minute", share, both, one)
    seen = set[int]()
    for k, each in enumerate(grip.weight_changes):
        if (step := each.step_after_lift) in seen:
            key = f"grip.weight_changes[{k}].step_after_lift"
            yield Fault(key, step, "a step of its own", "change the weight once")
        seen.add(step)


def _tug_faults(grip: Grip) -> Iterator[Fault]:
    """Find tugs that lift the object out of the fingers, together with events at the same time."""
    for k, least in lifting_tugs(grip.lightest_g, grip.tugs, grip.weight_changes):
        force = grip.tugs[k].extra_force_N
        bound = f"no more upward than the weight allows, {-force + least:.3g} N"
        remedy = "tug less, or lift a heavier object"
        yield Fault(f"grip.tugs[{k}].extra_force_N", force, bound, remedy)


def _warming_faults(design: Design) -> list[Fault]:
    """Find a finger that warms and whose expansion is not known, or too large."""
    if not (warmer := design.grip.warming_K):
        return []
    key, faults, parts = "grip.warming_K", [], set[Part]({"body"})
    if design.plates.number:
        parts.add("plates")
        if design.plates.model != "solid":
            bound, remedy = "0 where plates are no solids", 'set plates.model = "solid"'
            faults.append(Fault(key, warmer, bound, remedy))
    if design.body.core is not None:
        parts.add("core")
    if unknown := sorted(part for part in parts if design.expansion_of(part) is None):
        bound = f"0 where the expansion of the {' and the '.join(unknown)} is not known"
        faults.append(Fault(key, warmer, bound, "give expansion_per_K of its material"))
    most = max(design.expansion_of(part) or 0.0 for part in parts)
    if most * abs(warmer) > _SWELLING:
        bound = f"within {_SWELLING / most:.3g} K, where a material expands by {_SWELLING:.0%}"
        faults.append(Fault(key, warmer, bound, "warm less: strains are taken as small"))
    return faults


def _dead_gage_faults(design: Design, name: str, before: Sequence[int] = ()) -> list[Fault]:
    """Find the faults of one list of gages that fail; ``before``: those that have failed
    already."""
    dead, plates = list(getattr(design.grip.hardware, name)), design.plates.number
    step = 2 if design.gages.grid == "double_axial" else 1
    bridges = plates // step
    most = max(bridges - _LEAST_GAGES - len(set(before)), 0)
    present = f"plates 0 to {plates - 1}" if plates else "empty: the design has no plates"
    counted = f"at most {most} of the design's {bridges}{', dead ones counted' * bool(before)}"
    rules: tuple[tuple[list[int], str, str], ...] = (
        (dead if len(set(dead)) < len(dead) else [], "each once", "name a plate once"),
        ([each for each in dead if each >= plates], present, "name plates of the design"),
        (
            [each for each in dead if each % step],
            "even: the bridge of two plates goes by the first",
            "name the plate before",
        ),
        (
            sorted(set(dead) & set(before)),
            "other than grip.hardware.dead_gages",
            "name a plate once",
        ),
        (
            dead if len(dead) > most else [],
            counted,
            f"leave {_LEAST_GAGES} gages that respond: a rig is calibrated by them",
        ),
    )
    key = f"grip.hardware.{name}"
    return [Fault(key, wrong, bound, remedy) for wrong, bound, remedy in rules if wrong][:1]


def _stage_faults(grip: Grip) -> list[Fault]:
    """Find a stage that the finger cannot be calibrated with: so coarse that some of the bench's
    moves would be no move at all, or so slow that its quick press is not measured in time."""
    hardware, faults = grip.hardware, []
    step = hardware.stage_step_mm
    least = min(0.5 * grip.approach_step_mm, _BENCH_SHEAR * grip.preload_mm)
    if step > least:
        half = f"half of grip.approach_step_mm, {_BENCH_SHEAR:g} grip.preload_mm"
        remedy = "take a finer stage, or longer moves"
        bound = f"at most {least:.4g}: {half}"
        faults.append(Fault("grip.hardware.stage_step_mm", step, bound, remedy))
    samples = (_PRESS_SAMPLES - hardware.delay_samples) / _FOLLOWED
    if hardware.actuator_lag_s * hardware.sample_rate_Hz > samples:
        most = samples / hardware.sample_rate_Hz
        bound = f"at most {most:.4g}, {samples:g} samples: the bench's press is measured by then"
        remedy = "take a faster stage, a lower sample_rate_Hz or a shorter delay"
        faults.append(Fault("grip.hardware.actuator_lag_s", hardware.actuator_lag_s, bound, remedy))
    return faults
