"""Texts for the caster, made from the design: casting notes step by step, and warnings.

The words are in ``templates``; here are the numbers that they are made from.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from fingerdesign.checks.design import is_sound
from fingerdesign.checks.load import with_values
from fingerdesign.design.grip import GRAVITY
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.layout.fitting import sheet_words
from fingerdesign.layout.gaps import PlateGap, least_gap
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mold.part import COUPON, COUPON_COMB, axis_name
from fingerdesign.mold.plan.base import TILT_DEG
from fingerdesign.mold.plan.fixture.legs import leg_bend
from fingerdesign.mold.plan.plan import MoldPlan, spacer_height
from fingerdesign.mold.products.bill import bolts_in_words, comb_made, primer_words, spare_of
from fingerdesign.mold.products.casting import Casting, density_of
from fingerdesign.mold.products.drawing import numbers_text
from fingerdesign.report.page import macros, texts_of

TEMPLATES = Path(__file__).parents[1] / "templates"
_STEEP = 0.2  # sine of a plate's angle, from which a pitch parts plates
_PITCHES = 100  # A curved surface turns plates toward each other: some tenths of a millimetre.
SURFACE_TENSION_N_M = 0.021  # of silicone oils; cured and uncured rubber differ little


Up = Literal["+x", "-x", "+y", "-y", "+z", "-z", "+Y"]  # the last: +y, seen from behind
PLATES = "plates"  # all of them, among the names of a view
_VIEW = re.compile(r"\[(put|take|move) ([+-][xyzY])(?: ([-.\d]+),([-.\d]+))?: ([\w ]+)\] *")
Verb = Literal["put", "take", "move"]
_WORDS = texts_of(TEMPLATES / "page.toml")["things"]


@dataclass(frozen=True)
class View:
    """The subject of a step's picture: parts (and PLATES, and the rubber) that it puts in their
    places, takes away or moves there, and the axis of mold space that is up on the bench; ``way``:
    (x, y) along which they are moved, None as they are drawn."""

    section: str
    step: int
    up: Up
    verb: Verb
    names: tuple[str, ...]
    way: tuple[float, float] | None = None

    @property
    def words(self) -> str:
        """Describe what is seen, as a sentence.

        >>> View("Cure and open", 3, "+y", "take", ("contact_insert",)).words
        'Step 3 of "Cure and open": contact insert is taken off.'
        """
        names = [_WORDS.get(name, name.replace("_", " ")) for name in self.names]
        listed = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
        several = len(names) > 1 or any(word.endswith("s") for word in names[0].split())
        verb = "are" if several else "is"
        done = {"take": "taken off", "put": "put in place", "move": "moved"}[self.verb]
        return f'Step {self.step} of "{self.section}": {listed} {verb} {done}.'


def windows_volume(plan: MoldPlan) -> float:
    """Volume of the largest window behind a comb, mm^3: of the air that clay displaces."""
    windows = ((*s.window, plan.wall(s.side) - s.sheet) for s in plan.sides if s.window)
    sizes = ((high - low) * (plan.crest - bottom) * deep for low, high, bottom, deep in windows)
    return max(sizes, default=0.0)


def casting_notes(casting: Casting) -> tuple[list[dict[str, Any]], list[View]]:
    """Write sections of steps, in the order of the work, and the views that show them; what this
    mold does not need is left out."""
    return _sections(macros(TEMPLATES / "notes.j2").notes(_of_notes(casting)))


def _of_notes(casting: Casting) -> dict[str, Any]:
    """A casting with what else its notes name."""
    mold, plan, coupon = casting.design.mold, casting.plan, casting.meshes.coupon
    bar = next(part for part in coupon if part.name == COUPON)
    polyurethane = casting.design.body.material.startswith("polyurethane")
    platinum = mold.cure == "platinum" and not polyurethane
    return vars(casting) | {
        "design": casting.design,
        "gage": casting.gage,
        "bolts": bolts_in_words(plan),  # as they are bought, by axis
        "comb_made": comb_made(plan),
        "legged": mold.leads == "leg" and bool(plan.legs),  # front legs have the leads
        "platinum": platinum,
        "coated": mold.process == "sla" and platinum,  # prints, which would stop the cure
        "polyurethane": polyurethane,
        "apart": least_gap(casting.trial),  # of the coupon's plates
        "bar": round(float(np.ptp(bar.vertices[:, 0])), 3),  # its length, mm
        "cell_combs": " ".join(e.name for e in coupon if e.name.startswith(COUPON_COMB)),
        # mm, by which plates end inside the back wall's outer face
        "inside": round(plan.reach("-z") - plan.tips.get("-z", plan.reach("-z")), 2),
        "tilt": TILT_DEG,
        "numbers": numbers_text,
        "spare": spare_of,
        "axis_name": axis_name,
        "primer": primer_words,
        "spacer": spacer_height,
        "window_mm3": windows_volume,
        "bend": leg_bend,
    }


def _sections(text: str) -> tuple[list[dict[str, Any]], list[View]]:
    """Part a text into sections of steps and the views that its steps name; what was not put in
    its place before is not taken off."""
    sections = [section.partition("\n") for section in text.split("§ ")[1:]]
    made: list[dict[str, Any]] = []
    views, there = [], {"leg_ends", "leg_stubs"}
    for title, _, lines in sections:
        steps = _items(lines)
        for number, step in enumerate(steps, start=1):
            for verb, up, x, y, names in _VIEW.findall(step):
                way = (float(x), float(y)) if x else None
                shown = tuple(n for n in names.split() if verb != "take" or n in there)
                there |= set(shown) if verb == "put" else set()
                views.append(View(title, number, up, verb, shown, way))
        if steps:
            made.append({"title": title, "steps": [_VIEW.sub("", step) for step in steps]})
    return made, views


class BridgedGap(NamedTuple):
    """Two plates between which air stays: pressures of wetting and of buoyancy, Pa, the distance
    that would let it go, mm, and a sound pitch that gives it; None: no pitch, or placed plates."""

    gap: PlateGap
    wetting: float
    buoyancy: float
    apart: float
    pitch: float | None


def warnings_of(plan: MoldPlan, placement: Mapping[str, Any]) -> list[str]:
    """Warnings to the caster, found from the design: a sentence each."""
    given = plan, placement_worst(placement), bridged_gap(plan)
    own = _items(macros(TEMPLATES / "notes.j2").warnings(*given))
    return sheet_words(plan.design) + cautions_of(plan.design) + own


def cautions_of(design: Design) -> list[str]:
    """Warnings that hold of every finger of this rubber, cure and process."""
    return _items(macros(TEMPLATES / "notes.j2").cautions(design))


def bridged_gap(plan: MoldPlan) -> BridgedGap | None:
    """The closest two plates, where rubber that closes the gap between them keeps the air in it.
    None where buoyancy is the greater, or where the gap is wider than the plates are high: no
    channel.

    Wetting holds a meniscus across a gap g by 2 gamma / g; a bubble as high as the plate lifts by
    rho g h.
    """
    design, gap = plan.design, least_gap(plan.frames)
    if gap is None:
        return None
    frame = next(frame for frame in plan.frames if frame.index == gap.first)
    sine, cosine = (abs(f(math.radians(frame.angle_deg))) for f in (math.sin, math.cos))
    high = frame.length * sine + frame.thickness * cosine
    if not 0.0 < gap.distance < high:
        return None
    wetting = 2.0 * SURFACE_TENSION_N_M / (1e-3 * gap.distance)
    buoyancy = 1e3 * density_of(design) * GRAVITY * 1e-3 * high
    if wetting <= buoyancy:
        return None
    apart = min(high, gap.distance * wetting / buoyancy)
    pitch, more = None, (apart - gap.distance) / (sine if sine > _STEEP else 1.0)
    if design.plates.placement is None:
        pitch = _sound_pitch(design, design.plates.pitch_mm + more, apart)
    return BridgedGap(gap, wetting, buoyancy, apart, pitch)


def _sound_pitch(design: Design, least: float, apart: float) -> float | None:
    """The first pitch from ``least`` mm on, in hundredths, whose plates are ``apart`` mm from each
    other; None where a design with it is not sound."""
    first = math.ceil(100.0 * least)
    for pitch in (number / 100.0 for number in range(first, first + _PITCHES)):
        try:
            trial = with_values(design, {"plates.pitch_mm": pitch})
        except DesignError:
            return None
        gap = least_gap(plate_frames(trial)) if is_sound(trial) else None
        if gap is None or gap.distance >= apart:
            return None if gap is None else pitch
    return None


def placement_worst(placement: Mapping[str, Any] | None) -> float:
    """Greatest change of a reading by plates off their places, over the largest; 0: not known."""
    if placement is None or placement.get("reason") is not None:
        return 0.0
    row = placement.get("row", {"together": {"worst": 0.0}})
    return math.hypot(placement["together"]["worst"], row["together"]["worst"])


def unknown_effect(reason: str, of: str = "the plates' tolerance does") -> dict[str, Any]:
    """The record of an effect on the readings where there are no numbers."""
    sentence = f"What {of} to the gages is not known: {reason}."
    return {"reason": reason, "sentences": [sentence]}


def percent(share: float) -> str:
    """A share in percent, two digits.

    >>> percent(0.0312), percent(1.234)
    ('3.1 %', '120 %')
    """
    value = 100.0 * share
    if value >= 10.0:
        value = round(value, 1 - math.floor(math.log10(value)))
        return f"{value:.0f} %"
    return f"{value:.2g} %"


def effect_sentences(design: Design, found: Mapping[str, Any], row: Mapping[str, Any]) -> list[str]:
    """Sentences on the effect of placement: of all together, of the plates, of the whole row.

    They are a ``guide`` where they are of plane strain; ``embedded``: legs stay in the rubber.
    """
    constant = design.body.shape in ("arc", "block") and design.extruded
    guide = found["fidelity"] == "plane-strain" and not constant
    embedded = any(frame.span < design.body.depth_mm - 1e-9 for frame in plate_frames(design))
    of = {"found": found, "row": row, "worst": placement_worst({**found, "row": row})}
    of |= {"guide": guide, "embedded": embedded, "percent": percent}
    return _items(macros(TEMPLATES / "notes.j2").effect(of))


def _items(text: str) -> list[str]:
    """The items of a list, each from its bullet on."""
    return [" ".join(item.split()) for item in text.split("• ")[1:]]
