"""Hands-on hours of a casting, step by step, from the program's own counts; waiting is not in them.

Minutes for each thing are assumed (those of a practised technician with a stereo microscope); the
order of magnitude is theirs, the counts are the design's.
"""

from collections.abc import Iterator

from typing_extensions import TypedDict

from fingerdesign.layout.leads import lead_words, leads_as_cast
from fingerdesign.mold.products.casting import Casting
from fingerdesign.records.base import Size, closed

JOINT_MIN = 5.0  # strip, tin, solder, wash and seal a joint of thin wire
_THICK_JOINT_MIN = 3.0  # of wire above
_THICK_MM = 0.15


@closed
class HoursData(TypedDict):
    """Hands-on time of a step: of a bare finger, and of one with gages and leads."""

    step: str
    counts: str
    bare_h: Size
    wired_h: Size


def hours_of(casting: Casting) -> tuple[HoursData, ...]:
    """The steps with their counts and hours."""
    return tuple(
        HoursData(
            step=step,
            counts=counts,
            bare_h=round(bare / 60.0, 2),
            wired_h=round(wired / 60.0, 2) if casting.plan.frames else 0.0,
        )
        for step, counts, bare, wired in _steps(casting)
    )


def joints_of(casting: Casting) -> int:
    """Number of soldered joints at the gages; none where film brings its traces."""
    made = casting.gage is not None and casting.gage.to_measure
    if not casting.patterns or made or casting.design.mold.leads == "leg":
        return 0
    return casting.design.gages.lead_count * len(casting.plan.frames)


def _steps(casting: Casting) -> Iterator[tuple[str, str, float, float]]:
    """Step, counts, and minutes of a bare and of a wired finger."""
    plan, design, parts = casting.plan, casting.design, casting.meshes.parts
    printed = sum(part.made == "process" for part in parts)
    sheets = sum(part.made == "sheet" for part in parts)
    machined = design.mold.process == "machined"
    each = 5.0 if machined else 12.0
    yield "coupon", "1 coupon", 45.0, 0.0
    words = f"{printed} parts, {sheets} sheets"
    yield "make and clean the parts", words, each * printed + 5.0 * sheets + 20.0, 0.0
    coats = 2 if design.mold.process == "sla" and design.mold.cure == "platinum" else 0
    yield "sand, polish, coat", f"{coats} coats", 40.0 + 15.0 * coats, 10.0 + 15.0 * coats
    if plates := len(plan.frames):
        yield "cut and deburr plates", f"{plates} plates", 2.0 * plates, 2.0 * plates
        yield from _gages(casting, plates)
    slots = sum(len(side.slots) * (2 if side.outer else 1) for side in plan.sides)
    closing = f"{slots} slots, {len(plan.bolts)} bolts"
    minutes = 20.0 + 1.0 * slots + 2.0 * len(plan.bolts)
    step = "thread plates, close the mold" if plates else "close the mold"
    yield step, closing, minutes, 1.5 * minutes
    yield "mix, de-air, pour", f"{casting.silicone['mass_g']:.1f} g", 40.0, 40.0
    legs = len(plan.legs)
    yield "open, trim", f"{legs} legs", 30.0 + 0.5 * legs, 30.0 + 1.0 * legs
    if plates:
        yield "calibrate", f"{plates} plates", 0.0, 60.0


def _gages(casting: Casting, plates: int) -> Iterator[tuple[str, str, float, float]]:
    design, joints = casting.design, joints_of(casting)
    if joints:
        gages = design.gages.faces * plates
        yield "bond gages", f"{gages} gages", 0.0, 6.0 * gages
        leads = leads_as_cast(design, casting.gage)
        minutes = JOINT_MIN if leads.diameter_mm <= _THICK_MM else _THICK_JOINT_MIN
        words = f"{joints} joints: {lead_words(design, leads)}"
        yield "solder and seal leads", words, 0.0, minutes * joints
        yield "bundle and number leads", f"{plates} bundles", 0.0, 3.0 * plates
    else:
        yield "check films, connect legs", f"{plates} legs", 0.0, 4.0 * plates


def hours_words(hours: tuple[HoursData, ...] | list[HoursData]) -> str:
    """Both sums and the longest step, for the verdict."""
    bare, wired = sum(e["bare_h"] for e in hours), sum(e["wired_h"] for e in hours)
    longest = max(hours, key=lambda each: each["wired_h"] or each["bare_h"])
    more = f", {wired:.0f} h more for the wired one" if wired else ""
    return (
        f"{bare:.0f} h for the bare finger{more}; longest: {longest['step']}, "
        f"{longest['counts']}, {longest['wired_h'] or longest['bare_h']:.0f} h"
    )
