"""Gaps between pins and their sockets, keys and their grooves, measured in the closed mold."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from fingerdesign.arrays import Array
from fingerdesign.mold.checks.assembly import Assembly
from fingerdesign.mold.part import BASE, Check
from fingerdesign.mold.plan import Key, Pin

AROUND = 12
ALONG = (0.25, 0.5, 0.75)
_REACH_MM = 50.0
_ROUND_MM = 0.05  # a round face may be this far off its radius in triangles


def fit_checks(assembly: Assembly) -> list[Check]:
    """The least gap of every pin and key against the clearance that was planned."""
    found = [
        check
        for number, pin in enumerate(assembly.plan.pins, 1)
        for check in _pin(assembly, number, pin)
    ]
    return found + [_key(assembly, key) for key in assembly.plan.keys]


def gap(start: Array, direction: Array, inner: Manifold | None, outer: Manifold) -> float:
    """From where a ray leaves ``inner`` (None: from its start) to where it enters ``outer``, mm;
    negative where it enters before; infinite where it does not meet ``outer``."""
    end = tuple((start + _REACH_MM * direction).tolist())
    first = 0.0
    if inner is not None:
        hits = inner.ray_cast(tuple(start.tolist()), end)
        first = _REACH_MM * hits[0].distance if hits else float("inf")
    hits = outer.ray_cast(tuple(start.tolist()), end)
    return _REACH_MM * hits[0].distance - first if hits else float("inf")


def _pin(assembly: Assembly, number: int, pin: Pin) -> list[Check]:
    """A pin in its socket and in the combs that it passes; and in a jig's sheets, which rest on it:
    their holes are moved by the clearance, so that the pins hold the clamp."""
    solids = assembly.solids
    free = (pin.into, *(name for name in solids if name.startswith("comb_")))
    resting = tuple(name for name in solids if name.startswith("jig_"))
    what = f"pin {number} of {pin.on} in {pin.into}"
    found = [_fit(assembly, what, pin.into, _least_gap(assembly, pin, free), pin.clearance)]
    least = _least_gap(assembly, pin, resting) if resting else np.inf
    if np.isfinite(least):
        what = f"pin {number} of {pin.on} in the jig's sheets"
        found.append(_fit(assembly, what, pin.into, least, 0.0))
    return found


def _least_gap(assembly: Assembly, pin: Pin, names: tuple[str, ...]) -> float:
    """The least gap, mm, of a pin to parts beside it; infinite where there is none."""
    root, axis = np.array(pin.root), np.array(pin.direction)
    helper = np.eye(3)[np.argmin(np.abs(axis))]
    first = np.cross(axis, helper) / np.linalg.norm(np.cross(axis, helper))
    second = np.cross(axis, first)
    reach = 0.5 * pin.length if pin.dowel else pin.length
    lean = np.arctan2(0.5 * (pin.diameter - pin.tip_diameter), pin.length)
    gaps = []
    for share in ALONG:
        radius = 0.5 * (pin.diameter + share * (pin.tip_diameter - pin.diameter))
        for turn in 2.0 * np.pi * (np.arange(AROUND) + 0.5) / AROUND:
            out = np.cos(turn) * first + np.sin(turn) * second
            start = root + share * reach * axis
            found = _beside_pin(assembly, pin, start, out, radius, names)
            gaps.append(found * np.cos(lean))
    return float(min(gaps))


def _beside_pin(
    assembly: Assembly, pin: Pin, start: Array, out: Array, radius: float, names: tuple[str, ...]
) -> float:
    """From a pin to what is beside it of the parts named; infinite where it still is within the
    part that it stands on."""
    solids = assembly.solids
    beside = [gap(start, out, None, solids[name]) for name in names]
    if pin.dowel:
        return min(beside) - radius
    end = tuple((start + _REACH_MM * out).tolist())
    own = solids[pin.on].ray_cast(tuple(start.tolist()), end)
    at = _REACH_MM * own[0].distance if own else float("inf")
    return min(beside) - at if at < radius + _ROUND_MM else float("inf")


def _key(assembly: Assembly, key: Key) -> Check:
    low, high = np.array(key.low), np.array(key.high)
    along = 2 if high[2] - low[2] > high[0] - low[0] else 0
    side = np.eye(3)[2 - along]
    lean = np.cos(np.radians(key.draft_deg))
    gaps = []
    for share in ALONG:
        start = 0.5 * (low + high)
        start[along] = low[along] + share * (high[along] - low[along])
        up = np.array([0.0, 1.0, 0.0])
        for direction, slope in ((side, lean), (-side, lean), (up, 1.0)):
            solids = assembly.solids[BASE], assembly.solids[key.into]
            gaps.append(slope * gap(start, direction, *solids))
    return _fit(assembly, f"key of {BASE} in {key.into}", key.into, min(gaps), key.clearance)


def _fit(assembly: Assembly, what: str, part: str, least: float, planned: float) -> Check:
    """A socket's chords lie inside its circle, by at most a chord."""
    bound = planned - assembly.chord - 1e-6
    if not np.isfinite(least):
        return Check("clearance", part, False, None, planned, "mm", f"{what}: there is none")
    sentence = f"{what}: least gap {least:.3f} mm, {planned:g} mm planned"
    return Check("clearance", part, bool(least >= bound), least, bound, "mm", sentence)
