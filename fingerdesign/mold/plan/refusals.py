"""Refusals of a mold: what cannot be made, by which key, with its bound and its remedy in words.

A step of the plan returns refusals with their numbers; their sentences stand here. A number in the
format ``least`` is rounded up to a micrometre, one in the format ``most`` down.
"""

import string
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fingerdesign.design.faults import at_least, at_most
from fingerdesign.errors import DesignError, Fault

# kind of a refusal -> what the key's value must be, what to do
SENTENCES: Mapping[str, tuple[str, str]] = {
    "thick_web": (
        "at most mold.limits.wall_mm = {limits.wall_mm:g}",
        "a web that can be made is no thicker than a wall that can",
    ),
    "thin_wall_limit": (
        "at least mold.limits.feature_mm = {limits.feature_mm:g}",
        "a web that can be made is no thicker than a wall that can",
    ),
    "thin_pins": (
        "at least {thick:least}: sockets are {limits.clearance_mm:g} wider all round, and tips at "
        "a draft of {draft:g} degrees at least {limits.feature_mm:g}",
        "thicken the pins, or lower mold.draft_deg or mold.limits.clearance_mm",
    ),
    "wide_sockets": (
        "at most a quarter of mold.limits.pin_mm, {most:most}",
        "pins in wider sockets locate nothing: lower it or take thicker pins",
    ),
    "thin_wall": (
        "at least the least wall, mold.limits.wall_mm = {limits.wall_mm:least} (mold.process = "
        "'{limits.name}')",
        "thicken it or take another process",
    ),
    "narrow_hole": (
        "at least the least hole, mold.limits.hole_mm = {limits.hole_mm:least} (mold.process = "
        "'{limits.name}')",
        "widen it or take another process",
    ),
    "thin_end_walls": (
        "at least {columns.wall_z:least}: {columns.size} bolts, pins of {columns.big:g} mm and "
        "walls of {limits.wall_mm:g} mm ('{limits.name}') between them",
        "leave it out: it is then computed, or set a smaller mold.bolt",
    ),
    "big_bolt": (
        "a bolt that fits the walls, {rim:most} mm high with their slots: {columns.size} needs "
        "{columns.rise:least} mm",
        "set mold.bolt = 'auto'",
    ),
    "thick_walls": (
        "at most {most:most}: the mold's walls are {rim:most} mm high",
        "take another mold.process or make the finger {higher:least} mm higher",
    ),
    "low_walls": (
        "a wall with room above and below pins of {columns.big:g} mm: the mold's walls, {rim:most} "
        "mm high, are {higher:least} mm too low",
        "take another mold.process or make the finger {higher:least} mm higher",
    ),
    "webs_on_pins": (
        "at most mold.limits.pin_mm = {columns.small:g}: pins end in webs that can be made",
        "lower it or raise mold.limits.pin_mm",
    ),
    "great_draft": (
        "at most {most:most}: pins of {columns.small:g} mm end thinner than {limits.feature_mm:g}",
        "lower it or raise mold.limits.pin_mm",
    ),
    "no_low_bolt": (
        "a bolt with room: for {columns.size}, along z it needs walls {columns.rise:least} mm high "
        "(they are {rim:most}); upright it needs {columns.rise:least} of the {side} wall's "
        "{length:.4g} mm next to what the wall holds",
        "move the plates' legs, or take a higher or deeper finger",
    ),
    "no_bolt": (
        "a bolt with room: {columns.size} needs upright {columns.rise:least} of the {side} wall's "
        "{length:.4g} mm next to what the wall holds",
        "move the plates' legs, or take a higher or deeper finger",
    ),
    "no_pin": (
        "a pin with room in the {side} wall, next to plates and seams: with its walls it takes "
        "{room:least} mm",
        "lower it, or move the plates' legs",
    ),
    "no_hole": (
        "of {what} with room on the finger's base: even {limits.hole_mm:most} mm, the least hole "
        "of '{limits.name}', is too wide next to {core}vents and walls of {limits.wall_mm:g} mm",
        "take a process with smaller holes (mold.limits.hole_mm), a wider finger or a narrower "
        "core",
    ),
    "no_leads": (
        "such that {bundles} bundles of leads leave through the finger's base, next to {holes}"
        "walls of {limits.wall_mm:g} mm",
        "take thinner wire, or mold.wire_mm = 0 and lead the wires out elsewhere",
    ),
    "thin_core": (
        "at least {least:least} for a mold: a pin of {pin:g} mm holds the core, with {web:g} mm of "
        "core above and below its hole",
        "thicken it or put it on the base (body.core.bottom_mm = 0)",
    ),
    "core_not_reached": (
        "where pins through the walls reach the core clear of the plates' slots and windows, with "
        "walls below them",
        "raise it, move it away from them or put it on the base (body.core.bottom_mm = 0)",
    ),
    "no_web": (
        "such that webs of {name} = {web:g} mm remain between slots of at least {least:g} mm "
        "(plates {one} and {two}: {apart})",
        "space the plates out, or lower plates.count",
    ),
    "much_for_webs": (
        "at most {most:most}, such that webs remain between the slots of plates {one} and {two}",
        "lower it, or space the plates out by plates.pitch_mm and plates.cover_mm",
    ),
    "much_for_height": (
        "at most {most:most}, such that plate {plate}'s slot stays below the contact surface",
        "lower it, or space the plates out by plates.pitch_mm and plates.cover_mm",
    ),
    "wide_legs": ("at most plates.length_mm = {least:g}", "narrow the legs, or remove it"),
    "crossing_legs": (
        "such that legs stay {least:g} mm from {what} (those of plate {plate} come within "
        "{distance:.3g})",
        "move the rows apart, or the plates out of the legs' way",
    ),
    "seam_in_contact": (
        "at most {most:g}, such that the seam next to the contact insert, which ends short of "
        "plate {plate}'s legs, stays outside {zone}",
        "lower it, or lower mold.insert_mm",
    ),
    "high_legs": (
        "such that legs' slots stay {web:g} mm below the contact surface, or leave the finger "
        "beyond the seam outside {zone} (plate {plate}'s: {nearest:.3g})",
        "lower the plates, mold.contact_margin_mm or grip.max_approach_mm",
    ),
    "low_slots": (
        "such that legs' slots stay {web:g} mm above the base (plate {plate}'s: {bottom:.3g})",
        "raise the plates: lower it",
    ),
    "legs_in_walls": (
        "such that legs leave through the {wall} walls (those of plate {plate} would run through "
        "the {other} walls, which are drawn across them: they meet at |z| = {corner:.3g}, "
        "{into:.3g} from there)",
        "move the plates inward: lower it or the count",
    ),
    "not_open": (
        "auto or closed: {why}",
        "set mold.pour = 'auto', which takes a closed mold where an open one cannot be",
    ),
    "thin_frames": (
        "at least {least:least}: pins, lugs and walls of {limits.wall_mm:g} mm ('{limits.name}') "
        "in half frames",
        "leave it out: it is then computed",
    ),
}


@dataclass(frozen=True)
class Refusal:
    """A reason why there is no mold: its kind among SENTENCES, the key at fault with its value, and
    the numbers of its sentences; ``remedy`` takes the place of the general one."""

    kind: str
    key: str
    value: object
    numbers: Mapping[str, Any]
    remedy: str = ""

    @property
    def fault(self) -> Fault:
        """The refusal as a fault, in words."""
        writer = _Writer()
        bound, remedy = (writer.vformat(text, (), self.numbers) for text in SENTENCES[self.kind])
        return Fault(self.key, self.value, bound, self.remedy or remedy)


class MoldRefused(DesignError):
    """There is no mold of a design: ``refusals`` say why."""

    def __init__(self, refusals: Sequence[Refusal], source: str) -> None:
        super().__init__([refusal.fault for refusal in refusals], source)
        self.refusals = tuple(refusals)


class _Writer(string.Formatter):
    """Text with numbers in the formats ``least`` and ``most``."""

    def format_field(self, value: Any, format_spec: str) -> Any:
        rounded = {"least": at_least, "most": at_most}.get(format_spec)
        return rounded(value) if rounded else super().format_field(value, format_spec)
