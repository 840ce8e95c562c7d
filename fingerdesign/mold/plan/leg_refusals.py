"""What keeps the legs of a fixture from being held: crossings, too little web, exits too high."""

import math

import numpy as np

from fingerdesign.mold.plan import slots
from fingerdesign.mold.plan.fixture import Fixture
from fingerdesign.mold.plan.plan import SIDES, Leg
from fingerdesign.mold.plan.refusals import Refusal

CLOSE_MM = 2e-6  # rounding


def leg_refusals(fixture: Fixture) -> list[Refusal]:
    """Refuse what is wrong with legs and slots, the worst of each kind, walls left out."""
    found = []
    given = fixture.design.mold.leg_mm
    least = min((row.table.length_mm for row in fixture.rows), default=math.inf)
    if given is not None and given > least:
        found.append(Refusal("wide_legs", "mold.leg_mm", given, {"least": least}))
    high = high_legs(fixture)
    return [
        *found,
        *_crossings(fixture),
        *high,
        *([] if high and high[0].kind == "seam_in_contact" else narrow_webs(fixture)),
    ]


def _crossings(fixture: Fixture) -> list[Refusal]:
    near = [
        (float(gap), leg.plate, "other plates or the core")
        for leg, gap in zip(fixture.legs, fixture.gaps(), strict=True)
        if gap < fixture.least_gap - CLOSE_MM
    ]
    for one, two, distance in fixture.crossings():
        near.append((distance, two.plate, f"the legs of plate {one.plate}"))
    if not near:
        return []
    distance, plate, what = min(near, key=lambda each: each[0])
    key, value = fixture.row(plate).blame(plate, "cover_mm")
    numbers = {"least": fixture.least_gap, "what": what, "plate": plate, "distance": distance}
    return [Refusal("crossing_legs", key, value, numbers)]


def high_legs(fixture: Fixture) -> list[Refusal]:
    """Refuse the leg that leaves most too near to the contact zone; where a smaller draft alone
    makes a plug that covers the zone, the draft."""
    room = fixture.room
    lacks = [room.least_exit(leg.side) - nearest for leg, nearest in fixture.high]
    worst = int(np.argmax(lacks)) if lacks else 0
    if not lacks or lacks[worst] <= CLOSE_MM:
        return []
    leg, nearest = fixture.high[worst]
    numbers = {"plate": leg.plate, "zone": _zone_text(fixture, leg), "web": room.web}
    draft = room.greatest_draft(leg.side, nearest)
    if draft is not None:
        numbers["most"] = math.floor(100.0 * draft) / 100.0
        now = fixture.design.mold.draft_deg
        return [Refusal("seam_in_contact", "mold.draft_deg", now, numbers)]
    key, value = fixture.row(leg.plate).blame(leg.plate, "cover_mm")
    return [Refusal("high_legs", key, value, numbers | {"nearest": nearest})]


def _zone_text(fixture: Fixture, leg: Leg) -> str:
    zone = fixture.room.zone(leg.side)
    if math.isinf(zone):
        return "the contact zone, which reaches the body's ends"
    return f"the contact zone and its margin, |{leg.side[1]}| = {zone:.3g}"


def narrow_webs(fixture: Fixture) -> list[Refusal]:
    """Refuse the two slots that lack most of the web between them."""
    design, found, worst = fixture.design, list[Refusal](), CLOSE_MM
    for side in SIDES:
        openings, holding = fixture.slots(side), fixture.holding(side)
        web = slots.least_web(design, holding, fixture.limits)
        first, second, distances = slots.webs(openings)
        if not len(distances):
            continue
        k = int(np.argmin(distances))
        distance = float(distances[k])
        if web - distance > worst:
            worst = web - distance
            one, two = openings[first[k]].plate, openings[second[k]].plate
            row = fixture.row(two)
            same = any(frame.index == one for frame in row.frames)
            key, value = row.blame(two, "pitch_mm" if same else "cover_mm")
            numbers = {
                "one": one,
                "two": two,
                "web": web,
                "least": slots.least_slot(design, holding, fixture.limits),
                "apart": f"{distance:.3g}" if distance else "they overlap",
                "name": "mold.comb.web_mm" if holding == "comb" else "mold.limits.feature_mm",
            }
            found = [Refusal("no_web", key, value, numbers)]
    return found
