"""Faults between the keys of ``[grip]``: the object, the hardware, the stage's motions."""

from collections.abc import Iterator, Sequence
from itertools import chain

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
    hanging = grip.plant == "lift"
    of_lift = (_event_faults, _tug_faults, _turning_faults) if hanging else (_unused_lift_keys,)
    return [
        *chain.from_iterable(find(grip) for find in of_lift),
        *_warming_faults(design),
        *_drop_faults(grip),
        *_dead_gage_faults(design, "dead_gages"),
        *_dead_gage_faults(design, "dying_gages", grip.hardware.dead_gages),
        *_stage_faults(grip),
        *_travel_faults(design),
    ]


def _travel_faults(design: Design) -> Iterator[Fault]:
    """Find another finger that cannot be made, and a travel too long or too short for the moves."""
    grip, travel = design.grip, design.grip.max_approach_mm
    if grip.opposite == "bare" and design.mesh.mesher == "file":
        remedy = "the mesh's file holds the plates: take the mirror image"
        yield Fault("grip.opposite", "bare", "'mirror' with mesh.mesher = 'file'", remedy)
    if travel > (most := design.body.base_height_mm):
        remedy = "shorten the stage's travel: the model is of small strains"
        bound = f"at most body.base_height_mm = {most:g}"
        yield Fault("grip.max_approach_mm", travel, bound, remedy)
    bound = f"grip.max_approach_mm = {travel:g}"
    for key in ("preload_mm", "approach_step_mm"):
        if (value := getattr(grip, key)) > travel:
            yield Fault(f"grip.{key}", value, f"at most {bound}", "lower it, or raise the travel")
    if grip.preload_mm == travel:
        yield Fault("grip.preload_mm", travel, f"below {bound}", "leave travel to grip with")
    if (step := grip.approach_step_mm) < (least := travel / _MOST_MOVES):
        bound = f"at least grip.max_approach_mm / {_MOST_MOVES} = {least:g}"
        yield Fault("grip.approach_step_mm", step, bound, "the travel would take too many moves")


def _drop_faults(grip: Grip) -> Iterator[Fault]:
    """Find a length of slide without inertia: nothing slides then."""
    if not grip.inertia and grip.drop_mm != Grip.model_fields["drop_mm"].default:
        remedy = "set grip.inertia = true, or leave it out: without inertia what slips has dropped"
        yield Fault("grip.drop_mm", grip.drop_mm, "left out where grip.inertia is false", remedy)


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
    bounds = {"opposite": "'mirror'", "off_centre_mm": "0", "hold_steps": "0"}
    bounds |= {"relaxation_per_minute": "0", "rubber_memory": "left out", "warming_K": "0"}
    for name, bound in (bounds | {"inertia": "false"}).items():
        if (value := getattr(grip, name)) != Grip.model_fields[name].default:
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


def _warming_faults(design: Design) -> Iterator[Fault]:
    """Find a finger that warms and whose expansion is not known, or too large."""
    if not (warmer := design.grip.warming_K):
        return
    key, parts = "grip.warming_K", set[Part]({"body"})
    if design.plates.number:
        parts.add("plates")
        if design.plates.model != "solid":
            bound, remedy = "0 where plates are no solids", 'set plates.model = "solid"'
            yield Fault(key, warmer, bound, remedy)
    if design.body.core is not None:
        parts.add("core")
    if unknown := sorted(part for part in parts if design.expansion_of(part) is None):
        bound = f"0 where the expansion of the {' and the '.join(unknown)} is not known"
        yield Fault(key, warmer, bound, "give expansion_per_K of its material")
    most = max(design.expansion_of(part) or 0.0 for part in parts)
    if most * abs(warmer) > _SWELLING:
        bound = f"within {_SWELLING / most:.3g} K, where a material expands by {_SWELLING:.0%}"
        yield Fault(key, warmer, bound, "warm less: strains are taken as small")


def _dead_gage_faults(design: Design, name: str, before: Sequence[int] = ()) -> list[Fault]:
    """Find the faults of one list of gages that fail; ``before``: those that failed already."""
    dead, plates = list(getattr(design.grip.hardware, name)), design.plates.number
    step = 2 if design.gages.grid == "double_axial" else 1
    bridges = plates // step
    most = max(bridges - _LEAST_GAGES - len(set(before)), 0)
    twice = dead if len(set(dead)) < len(dead) else []
    absent, second = [k for k in dead if k >= plates], [k for k in dead if k % step]
    again, too_many = sorted(set(dead) & set(before)), dead if len(dead) > most else []
    present = f"plates 0 to {plates - 1}" if plates else "empty: the design has no plates"
    first = "even: the bridge of two plates goes by the first"
    counted = f"at most {most} of the design's {bridges}{', dead ones counted' * bool(before)}"
    left = f"leave {_LEAST_GAGES} gages that respond: a rig is calibrated by them"
    rules = (
        (twice, "each once", "name a plate once"),
        (absent, present, "name plates of the design"),
        (second, first, "name the plate before"),
        (again, "other than grip.hardware.dead_gages", "name a plate once"),
        (too_many, counted, left),
    )
    key = f"grip.hardware.{name}"
    return [Fault(key, wrong, bound, remedy) for wrong, bound, remedy in rules if wrong][:1]


def _stage_faults(grip: Grip) -> Iterator[Fault]:
    """Find a stage that the finger cannot be calibrated with: so coarse that some of the bench's
    moves would be no move at all, or so slow that its quick press is not measured in time."""
    hardware, step = grip.hardware, grip.hardware.stage_step_mm
    least = min(0.5 * grip.approach_step_mm, _BENCH_SHEAR * grip.preload_mm)
    if step > least:
        half = f"half of grip.approach_step_mm, {_BENCH_SHEAR:g} grip.preload_mm"
        bound = f"at most {least:.4g}: {half}"
        remedy = "take a finer stage, or longer moves"
        yield Fault("grip.hardware.stage_step_mm", step, bound, remedy)
    samples = (_PRESS_SAMPLES - hardware.delay_samples) / _FOLLOWED
    if hardware.actuator_lag_s * hardware.sample_rate_Hz > samples:
        most = samples / hardware.sample_rate_Hz
        bound = f"at most {most:.4g}, {samples:g} samples: the bench's press is measured by then"
        remedy = "take a faster stage, a lower sample_rate_Hz or a shorter delay"
        yield Fault("grip.hardware.actuator_lag_s", hardware.actuator_lag_s, bound, remedy)
