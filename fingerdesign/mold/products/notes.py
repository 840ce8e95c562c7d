"""What a caster reads, made from the design: notes step by step, and what to be warned of.

The words stand in ``templates/notes.j2``; here are the numbers that they are made from.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import plate_frames
from fingerdesign.mold.part import WORDS, PartMesh, axis_name, comb_names, wall_name
from fingerdesign.mold.plan.base import TILT_DEG
from fingerdesign.mold.plan.legs import legs_share
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.products.bill import Silicone, bolt_length, bolt_words
from fingerdesign.mold.products.flat_pattern import FlatPattern
from fingerdesign.report.page import macros

TEMPLATE = Path(__file__).parents[1] / "templates" / "notes.j2"


@dataclass(frozen=True)
class Mixing:
    """Parts A and B by mass; how long it can be poured; how it cures. source: of the numbers;
    known: they are the material's own, not what is usual of its cure."""

    part_a: float
    part_b: float
    pot_life: str
    cure: str
    source: str
    known: bool = True

    def shares(self, mass_g: float) -> tuple[float, float]:
        """Masses of A and B, g, that make ``mass_g``.

        >>> Mixing(10.0, 1.0, "", "", "").shares(11.0)
        (10.0, 1.0)
        """
        whole = self.part_a + self.part_b
        return mass_g * self.part_a / whole, mass_g * self.part_b / whole


_ROOM = "at room temperature"
# Typical figures of the makers' data sheets at about 23 degrees C, by the material's name; then
# what is usual where it is not known by name, which the notes say: to be held against your tin.
MIXINGS: Mapping[str, Mixing] = MappingProxyType(
    {
        "dragon_skin_20": Mixing(1, 1, "25 min", f"4 h {_ROOM}", "Smooth-On"),
        "dragon_skin_30": Mixing(1, 1, "45 min", f"16 h {_ROOM}", "Smooth-On"),
        "sylgard_184": Mixing(10, 1, "1.5 h", f"48 h {_ROOM}, or 4 h at 60 degrees C", "Dow"),
        "platinum": Mixing(
            *(1, 1, "20 to 60 min", f"4 to 24 h {_ROOM}", "usual of platinum silicones", False)
        ),
        "condensation": Mixing(
            *(100, 5, "30 to 90 min", f"24 h {_ROOM}, in moist air", "usual of tin silicones"),
            known=False,
        ),
        "polyurethane": Mixing(
            *(1, 1, "10 to 20 min", f"16 to 24 h {_ROOM}", "usual of casting polyurethanes", False)
        ),
    }
)


def mixing_of(material: str, cure: str) -> Mixing:
    """How a material is mixed, or what is usual of its cure."""
    usual = "polyurethane" if material.startswith("polyurethane") else cure
    return MIXINGS.get(material, MIXINGS[usual])


def numbers_text(plates: Iterable[int]) -> str:
    """Whole numbers, runs shortened.

    >>> numbers_text([8, 0, 1, 2, 5, 7])
    '0-2, 5, 7-8'
    """
    runs: list[list[int]] = []
    for plate in sorted(plates):
        if runs and plate == runs[-1][-1] + 1:
            runs[-1].append(plate)
        else:
            runs.append([plate])
    return ", ".join(str(r[0]) if len(r) == 1 else f"{r[0]}-{r[-1]}" for r in runs)


def casting_notes(
    design: Design,
    plan: MoldPlan,
    parts: Sequence[PartMesh],
    patterns: Sequence[FlatPattern],
    silicone: Silicone,
) -> list[dict[str, Any]]:
    """Sections of steps, in the order of the work; what this mold does not need is left out."""
    bolts = sorted(plan.bolts, key=lambda bolt: str((bolt.size, bolt_length(bolt))))
    text = macros(TEMPLATE).notes(
        design=design,
        plan=plan,
        parts=parts,
        thickness=lambda part: round(float(np.ptp(part.vertices, axis=0).min()), 4),
        patterns=patterns,
        silicone=silicone,
        mixing=mixing_of(design.body.material, design.mold.cure),
        numbers=numbers_text,
        bolts={axis: [bolt_words(bolt) for bolt in bolts if bolt.axis == axis] for axis in "yz"},
        wall_name=wall_name,
        sheets_of=comb_names,
        front=WORDS,
        axis_name=axis_name,
        tilt=TILT_DEG,
    )
    sections = [section.partition("\n") for section in f"\n{text}".split("\n# ")[1:]]
    made = [{"title": title, "steps": _items(steps)} for title, _, steps in sections]
    return [section for section in made if section["steps"]]


def warnings_of(design: Design, plan: MoldPlan, placement: Mapping[str, Any]) -> list[str]:
    """What a caster has to be warned of, found from the design: a sentence each."""
    share, worst = legs_share(design, plan), placement_worst(placement)
    return _items(macros(TEMPLATE).warnings(design, plan, share, worst, WORDS))


def placement_worst(placement: Mapping[str, Any] | None) -> float:
    """The greatest change of a reading by plates off their places, over the largest reading; 0
    where it is not known."""
    if placement is None or placement.get("reason") is not None:
        return 0.0
    row = placement.get("row", {"together": {"worst": 0.0}})
    return math.hypot(placement["together"]["worst"], row["together"]["worst"])


def unknown_effect(reason: str) -> dict[str, Any]:
    """The record of plates off their places where there are no numbers."""
    sentence = f"What the plates' tolerance does to the gages is not known: {reason}."
    return {"reason": reason, "sentences": [sentence]}


def effect_sentences(design: Design, found: Mapping[str, Any], row: Mapping[str, Any]) -> list[str]:
    """What the numbers of ``placement.placement_effect`` say: of the plates, of the whole row."""
    guide = design.body.shape not in ("arc", "block") or not design.extruded
    embedded = any(frame.span < design.body.depth_mm - 1e-9 for frame in plate_frames(design))
    return _items(macros(TEMPLATE).effect(found, row, guide, embedded, percent))


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


def _items(text: str) -> list[str]:
    """The items of a list, each from a line that begins with a dash."""
    return [" ".join(item.split()) for item in f"\n{text}".split("\n- ")[1:]]
