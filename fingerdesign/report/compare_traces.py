"""A design's path and grips as the comparison page draws them: few digits, status run by run.

For drawing alone: what the page offers for download is the outcome's own numbers.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any

from fingerdesign.sweep.outcome import GripOutcome, Numbers, Traces

DIGITS = 4  # significant: a drawing is a thousand points wide


def packed_traces(traces: Traces) -> dict[str, Any]:
    """The keys of Traces, JSON-ready, numbers to DIGITS significant digits.

    status: of each increment its characters run by run, "3.12#2/" for 3 open, 12 stick, 2 slip.
    """
    found: dict[str, Any] = {
        name: rounded(getattr(traces, name))
        for name in (
            *("approach_mm", "shear_mm", "normal_force_N", "tangential_force_N", "stick_ratio"),
            *("contact_width_mm", "gage_x_mm", "contact_x_mm", "contact_z_mm"),
        )
    }
    found["gages"] = [rounded(readings) for readings in traces.gages]
    found["status"] = [runs(row) for row in traces.status]
    return found


def packed_grips(grips: Iterable[GripOutcome]) -> list[dict[str, Any]]:
    """What the page shows of each grip, JSON-ready; the path to DIGITS significant digits."""
    return [
        {
            "controller": grip.controller,
            "friction_coefficient": grip.friction_coefficient,
            "object_mass_g": grip.object_mass_g,
            "lifted": grip.lifted,
            "gross_slip": grip.gross_slip,
            "safety_margin": _number(grip.safety_margin),
            "peak_normal_force_N": _number(grip.peak_normal_force_N),
            "normal_force_N": rounded(grip.normal_force_N),
            "tangential_force_N": rounded(grip.tangential_force_N),
        }
        for grip in grips
    ]


def rounded(values: Numbers | Sequence[float | None]) -> list[float | int | None]:
    """To DIGITS significant digits, whole numbers without a point; what is no number is None.

    >>> rounded((1.23456, None, 120.0, 0.0, float("nan")))
    [1.235, None, 120, 0, None]
    """
    return [_number(value) for value in values]


def runs(status: str) -> str:
    """A row of characters as runs, each its length and the character.

    >>> runs("..##/"), runs("")
    ('2.2#1/', '')
    """
    return "".join(f"{len(list(group))}{character}" for character, group in groupby(status))


def unrolled(text: str) -> str:
    """What :func:`runs` was given.

    >>> unrolled("2.2#1/")
    '..##/'
    """
    return "".join(character * int(count) for count, character in re.findall(r"(\d+)(\D)", text))


def _number(value: float | None) -> float | int | None:
    if value is None or not math.isfinite(value):
        return None
    near = float(f"{value:.{DIGITS}g}")
    return int(near) if near == int(near) else near
