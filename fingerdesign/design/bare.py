"""A finger without its plates: the other side of a rig that reads one finger alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


def without_plates(design: Design) -> Design:
    """The same body, mesh and grip, and nothing in the rubber but a core if there is one."""
    from fingerdesign.design.io import with_values

    gone = ("plates.placement", "plates.rows", "grip.hardware.dead_gages", "assumed")
    return with_values(design, {"plates.count": 0, **dict.fromkeys(gone)})
