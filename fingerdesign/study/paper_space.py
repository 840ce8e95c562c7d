"""The dimensions that the paper does not give, sampled: candidates for its finger."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.design.forecast import summarise
from fingerdesign.design.io import parse_design, with_values
from fingerdesign.design.starter import shipped_text
from fingerdesign.errors import DesignError

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

# name -> (least, most, step), mm but for the gage's share of its plate. The skin is the rubber over
# the plate's upper corner at the crest, the approach that of the fundamental scene.
SPACE = {
    "arc_radius": (30.0, 60.0, 2.0),
    "width": (18.0, 24.0, 2.0),
    "base_height": (4.0, 12.0, 1.0),
    "plate_length": (0.6, 1.6, 0.1),
    "skin": (0.3, 0.9, 0.05),
    "pitch": (0.6, 1.1, 0.05),
    "gage_share": (0.3, 0.8, 0.05),
    "approach": (0.08, 0.2, 0.02),
}

# What the mold asks for.
LEAST_COVER_MM = 0.3  # over the plates' upper corners: a skin that survives the mold's opening
LEAST_GAP_MM = 0.25  # between plates: silicone must flow in without bubbles

_COARSE = {
    "mesh.section.contact_size_mm": 0.1,
    "mesh.section.plate_size_mm": 0.2,
    "mesh.section.plate_end_size_mm": 0.05,
    "mesh.section.far_size_mm": 2.0,
    "mesh.section.gradation": 0.5,
}


@dataclass(frozen=True)
class Candidate:
    """One point of SPACE: the design's dotted keys and the approach of its fundamental scene, mm.

    ``refused`` says why it was not analysed to the end; empty where nothing speaks against it.
    """

    number: int
    values: dict[str, float]
    approach: float
    refused: str = ""


def candidates(count: int, seed: int) -> list[Candidate]:
    """``count`` Sobol points of SPACE, rounded to its steps; those that cannot be cast refused."""
    from scipy.stats import qmc

    power = int(np.ceil(np.log2(max(count, 1))))
    points = qmc.Sobol(len(SPACE), seed=seed).random_base2(power)[:count]
    found = []
    for number, point in enumerate(points):
        place = {
            name: least + step * round(share * (most - least) / step)
            for share, (name, (least, most, step)) in zip(point, SPACE.items(), strict=True)
        }
        found.append(_checked(_candidate(number, place)))
    return found


def design_of(candidate: Candidate, coarse: bool) -> Design:
    """The shipped paper finger with the candidate's dimensions. Raises DesignError."""
    design = parse_design(shipped_text("maeno2000"), "maeno2000")
    values: dict[str, object] = {**candidate.values}
    return with_values(design, {**values, **_COARSE} if coarse else values)


def _candidate(number: int, place: dict[str, float]) -> Candidate:
    """Rounded to what a drawing says."""
    length = place["plate_length"]
    # Half of a plate of 0.1 mm at 45 degrees, up to its upper corner.
    rise = 0.5 * (length + 0.1) / np.sqrt(2.0)
    values = {
        "body.arc_radius_mm": place["arc_radius"],
        "body.width_mm": place["width"],
        "body.base_height_mm": place["base_height"],
        "plates.length_mm": length,
        "plates.cover_mm": 0.05 * np.ceil((place["skin"] + rise) / 0.05),
        "plates.pitch_mm": place["pitch"],
        "gages.length_mm": max(0.3, 0.1 * round(place["gage_share"] * length / 0.1)),
    }
    rounded = {key: round(float(value), 6) for key, value in values.items()}
    return Candidate(number, rounded, round(place["approach"], 6))


def _checked(candidate: Candidate) -> Candidate:
    try:
        summary = summarise(design_of(candidate, coarse=True))
    except DesignError as error:
        return replace(candidate, refused="; ".join(fault.key for fault in error.faults))
    assert summary.least_cover_mm is not None
    assert summary.least_gap_mm is not None
    if summary.least_cover_mm < LEAST_COVER_MM:
        return replace(candidate, refused="cover too thin")
    if summary.least_gap_mm < LEAST_GAP_MM:
        return replace(candidate, refused="plates too close")
    return candidate
