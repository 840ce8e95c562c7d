"""Plates that no fixture can hold: webs, crossing legs, exits in the contact zone; with remedies.

Each fault names the key that is owed the change; bounds are found by trying, and only told where
the changed design is sound.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.design.plate_rows import plate_rows
from fingerdesign.errors import Fault
from fingerdesign.mold import slots
from fingerdesign.mold.fixture import in_walls, leg_exits, slots_on
from fingerdesign.mold.fixture_trials import (
    CLOSE,
    Frames,
    Legs,
    again,
    least_value,
    row_of,
    worst_exit,
    worst_web,
)
from fingerdesign.mold.frames import leg_bar, scale_of
from fingerdesign.mold.leg_gaps import crossing_legs, least_gap_mm, leg_gaps
from fingerdesign.mold.leg_room import Room
from fingerdesign.mold.plan import SIDES, Leg
from fingerdesign.mold.web_faults import demanded, no_web

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.profiles import Limits

_ONE_ANGLE = 0.01  # degrees


def fixture_faults(
    design: Design, frames: Frames, legs: Legs, limits: Limits, corner: float | None
) -> list[Fault]:
    """Every fault of a design's legs and slots, the worst of each kind."""
    found = [*_leg_width(design), *_crossings(design, frames, legs)]
    draft = _draft(design, frames, legs, limits)
    worst = worst_web(design, frames, legs, limits)
    high = worst_exit(design, frames, legs, limits)
    if draft is not None:
        found.append(draft)
    elif worst is not None or high is not None:
        given = demanded(design, worst, high)
        if given is not None:
            found.append(given)
        else:
            found += [] if high is None else [_too_high(design, limits, *high)]
            found += [] if worst is None else [no_web(design, limits, worst)]
    found += _jig(design, frames, legs, limits)
    found += _blocked(design, frames, legs, limits, corner)
    unique: dict[str, Fault] = {}
    for fault in found:
        unique.setdefault(fault.key, fault)
    return list(unique.values())


def _leg_width(design: Design) -> list[Fault]:
    given = design.mold.leg_mm
    lengths = [row.table.length_mm for row in plate_rows(design)]
    if given is None or not lengths or given <= min(lengths):
        return []
    bound = f"at most plates.length_mm = {min(lengths):g}"
    return [Fault("mold.leg_mm", given, bound, "narrow the legs, or remove it")]


def _crossings(design: Design, frames: Frames, legs: Legs) -> list[Fault]:
    if not legs:
        return []
    least = least_gap_mm(design)
    by_index = {frame.index: frame for frame in frames}
    bars = tuple(leg_bar(by_index[leg.plate], leg, leg.exit) for leg in legs)
    gaps = leg_gaps(design, scale_of(design), legs, bars, frames)
    worst = int(np.argmin(gaps))
    told: tuple[int, str, float] | None = None
    if gaps[worst] < least - CLOSE:
        told = (legs[worst].plate, "other plates or the core", float(gaps[worst]))
    for one, two, distance in crossing_legs(design, legs, frames):
        if told is None or distance < told[2]:
            told = (two.plate, f"the legs of plate {one.plate}", distance)
    if told is None:
        return []
    plate, what, distance = told
    key, value = row_of(design, plate).blame(plate, "cover_mm")
    near = "cross them" if distance == 0.0 else f"come within {distance:.3g}"
    bound = f"such that legs stay {least:g} mm from {what} (those of plate {plate} {near})"
    return [Fault(key, value, bound, "move the rows apart, or the plates out of the legs' way")]


def _draft(design: Design, frames: Frames, legs: Legs, limits: Limits) -> Fault | None:
    """The draft that alone makes a plug narrower than the contact zone."""
    worst = worst_exit(design, frames, legs, limits)
    if worst is None:
        return None
    leg, room, nearest = worst
    draft = room.greatest_draft(leg.side, nearest)
    if draft is None:
        return None
    bound = (
        f"at most {math.floor(100.0 * draft) / 100.0:g}, such that the seam beside the contact "
        f"insert, which ends short of plate {leg.plate}'s legs, stays outside {_zone(room, leg)}"
    )
    remedy = "lower it, or lower mold.insert_mm"
    return Fault("mold.draft_deg", design.mold.draft_deg, bound, remedy)


def _zone(room: Room, leg: Leg) -> str:
    zone = room.zone(leg.side)
    if not math.isfinite(zone):
        return "the contact zone, which reaches the body's ends"
    return f"the contact zone and its margin, |{leg.side[1]}| = {zone:.3g}"


def _too_high(design: Design, limits: Limits, leg: Leg, room: Room, nearest: float) -> Fault:
    row = row_of(design, leg.plate)
    key, value = row.blame(leg.plate, "cover_mm")

    def holds(trial: Design) -> bool:
        return worst_exit(trial, *again(trial, limits), limits) is None

    remedy = "lower the plates, mold.contact_margin_mm or grip.max_approach_mm"
    if not row.placed:
        cover = row.table.cover_mm
        deeper = least_value(design, key, cover, cover + row.frames[0].y, holds)
        if deeper is not None:
            remedy = f"raise {key} to at least {deeper:g}"
    bound = (
        f"such that legs' slots stay {room.web:g} mm below the contact surface, or leave the "
        f"finger beyond the seam outside {_zone(room, leg)} (plate {leg.plate}'s: {nearest:.3g})"
    )
    return Fault(key, value, bound, remedy)


def _jig(design: Design, frames: Frames, legs: Legs, limits: Limits) -> list[Fault]:
    for side in SIDES:
        here = slots.on_side(legs, side)
        if slots.holding_of(design, here) != "jig":
            continue
        openings = slots_on(design, frames, legs, limits, side)
        turns = [slot.angle_deg for slot in openings]
        worst = int(np.argmax(np.abs(np.array(turns) - turns[0])))
        if abs(turns[worst] - turns[0]) > _ONE_ANGLE:
            bound = (
                "'comb' or 'slots' where the plates of a side differ in angle: a jig clamps all of "
                f"them by one shift (plates {openings[0].plate} and {openings[worst].plate}: "
                f"{turns[0]:.4g} and {turns[worst]:.4g} degrees)"
            )
            remedy = "change it, or set plates.follow = 'level' with one angle"
            return [Fault("mold.plate_fixture", "jig", bound, remedy)]
    return []


def _blocked(
    design: Design, frames: Frames, legs: Legs, limits: Limits, corner: float | None
) -> list[Fault]:
    """Legs that would run through a wall which is drawn across them, or too near to the base."""
    loose = in_walls(design, legs)
    if not loose:
        return []
    room = Room.of(design, scale_of(design), limits)
    if corner is not None:
        room = replace(room, corner=corner)
    exits, openings = leg_exits(design, frames, loose, limits)
    found = []
    sunk = room.sunk(openings)
    worst = int(np.argmax(sunk))
    if sunk[worst] > CLOSE:
        plate = loose[worst].plate
        key, value = row_of(design, plate).blame(plate, "cover_mm")
        bound = (
            f"such that legs' slots stay {room.web:g} mm above the base "
            f"(plate {plate}'s: {float(openings.bottom[worst]):.3g})"
        )
        found.append(Fault(key, value, bound, "raise the plates: lower it"))
    into = room.blocked([leg.side for leg in loose], openings, exits)
    worst = int(np.argmax(into))
    if into[worst] > CLOSE:
        leg = loose[worst]
        row = row_of(design, leg.plate)
        key, value = row.blame(leg.plate, "pitch_mm" if len(row.frames) > 1 else "offset_mm")
        wall, other = ("end", "side") if leg.side.endswith("z") else ("side", "end")
        bound = (
            f"such that legs leave through the {wall} walls (those of plate {leg.plate} would run "
            f"through the {other} walls, which are drawn across them: they meet at |z| = "
            f"{room.corner:.3g}, {into[worst]:.3g} from there)"
        )
        found.append(Fault(key, value, bound, "move the plates inward: lower it or the count"))
    return found
