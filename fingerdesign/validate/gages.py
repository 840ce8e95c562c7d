"""One solved finger read by other gages: as points, over the depth, along z."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.layout.frames import plate_frames
from fingerdesign.validate.comparison import (
    Answer,
    Comparison,
    Side,
    answer_of,
    compare_gages,
    side_of,
)

if TYPE_CHECKING:
    from fingerdesign.validate.solves import Reader


POINT = 0.05  # of the gage's length and width: short enough to be a point, long enough to round


PLACES = (0.0, 0.25, 0.5, 0.75, 1.0)  # from the middle to where the gage meets the plate's end


@dataclass(frozen=True)
class AlongZ:
    """Gages at z_mm (k,) from their plates' middles against those in the middle: one Side each."""

    z_mm: tuple[float, ...]
    sides: tuple[Side, ...]


def point_gage(reader: Reader) -> Comparison:
    """The strain at the gage's middle against its mean over length and width."""
    gages = reader.solved.design.gages
    small = gages.model_copy(
        update={"length_mm": POINT * gages.length_mm, "width_mm": POINT * gages.width_mm}
    )
    truth = _answer(reader, f"mean over {gages.length_mm:g} x {gages.width_mm:g} mm")
    found = replace(truth, name="a point", readings=reader.read(small))
    return compare_gages("a point for the gage's face", found, truth)


def depth_average(reader: Reader, span: float) -> Comparison:
    """The mean over the plate's whole span against the gage's own width."""
    gages = reader.solved.design.gages
    wide = gages.model_copy(update={"width_mm": span, "z_mm": 0.0})
    truth = _answer(reader, f"{gages.width_mm:g} mm wide at z = {gages.z_mm:g} mm")
    found = replace(truth, name=f"{span:g} mm wide", readings=reader.read(wide))
    return compare_gages(f"{span:g} mm wide for {gages.width_mm:g} mm", found, truth)


def along_z(reader: Reader) -> AlongZ | None:
    """What gages off the middle read; None without plates or where there is no room to move."""
    frames, gages = plate_frames(reader.solved.design), reader.solved.design.gages
    if not frames:
        return None
    room = 0.5 * (min(frame.span for frame in frames) - gages.width_mm)
    if room <= 0.0:
        return None
    places = tuple(float(place) for place in np.round(room * np.array(PLACES), 6))
    own = reader.own if gages.z_mm == 0.0 else reader.read(gages.model_copy(update={"z_mm": 0.0}))
    read = [own]
    read += [reader.read(gages.model_copy(update={"z_mm": place})) for place in places[1:]]
    return AlongZ(places, tuple(side_of(each, read[0]) for each in read))


def _answer(reader: Reader, name: str) -> Answer:
    return replace(answer_of(reader.solved, name), readings=reader.own)
