"""Gaps between pins and their sockets, keys and their grooves, measured in the closed mold."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from fingerdesign.arrays import Array
from fingerdesign.mold.checks.assembly import Assembly
from fingerdesign.mold.checks.triangles import areas, curved_area, heights, topology, volume
from fingerdesign.mold.part import BASE, Check, PartMesh
from fingerdesign.mold.plan.plan import Key, Pin

# Whether each part's triangles are those of one solid, and of the exact solid they stand for.

# The kernel merges vertices closer than 1e-7 mm; anything flatter than this is rounding.
LEAST_HEIGHT_MM = 1e-6
VOLUME_SHARE = 1e-3
EXACT_SHARE = 1e-6  # of the kernel's own volumes
SINGLE = 2.0**-24


def part_checks(part: PartMesh, chord_mm: float) -> list[Check]:
    """Topology, triangles, volume and chord of one part. Rubber alone may enclose a core."""
    found = topology(part.triangles)
    least = float(heights(part.vertices, part.triangles).min())

    def none_of(name: str, count: int, unit: str, what: str) -> Check:
        sentence = f"{part.name}: {count} {what}" if count else f"{part.name}: no {what}"
        return Check(name, part.name, count == 0, float(count), 0.0, unit, sentence)

    return [
        none_of("watertight", found.open_edges, "edges", "edges that two triangles do not share"),
        none_of("winding", found.turned_edges, "edges", "edges that two triangles run alike"),
        none_of("manifold", found.extra_fans, "vertices", "vertices where shells merely touch"),
        Check(
            "one shell",
            part.name,
            found.shells == 1 or part.made == "silicone",
            float(found.shells),
            1.0,
            "shells",
            f"{part.name}: {found.shells} shells of triangles",
        ),
        Check(
            "no degenerate triangles",
            part.name,
            least > LEAST_HEIGHT_MM,
            least,
            LEAST_HEIGHT_MM,
            "mm",
            f"{part.name}: the flattest of {len(part.triangles)} triangles is {least:.2g} mm high",
        ),
        _written(part),
        _volume(part),
        Check(
            "chord",
            part.name,
            part.chord <= chord_mm,
            part.chord,
            chord_mm,
            "mm",
            f"{part.name}: triangles leave the exact surface by at most {part.chord:.4f} mm",
        ),
    ]


def _written(part: PartMesh) -> Check:
    """STL holds single precision: vertices that become one there would open or pinch the mesh."""
    used = np.unique(part.triangles)
    rounded = part.vertices[used].astype(np.float32)
    lost = len(used) - len(np.unique(rounded, axis=0))
    sentence = f"{part.name}: {lost} of {len(used)} vertices fall onto others in single precision"
    return Check("as written", part.name, lost == 0, float(lost), 0.0, "vertices", sentence)


def _volume(part: PartMesh) -> Check:
    """Triangles within a chord of a curved face enclose at most chord times its area more or less:
    holes, smaller as polygons, leave a wall heavier. Vertices are single."""
    found = volume(part.vertices, part.triangles)
    error = abs(found - part.volume) / abs(part.volume)
    rounded = SINGLE * float(np.abs(part.vertices).max())
    slack = part.chord * curved_area(part.vertices, part.triangles)
    slack += rounded * float(areas(part.vertices, part.triangles).sum())
    bound = slack / abs(part.volume) + EXACT_SHARE
    if part.made == "metal":  # a bent plate's two faces err alike
        bound = min(VOLUME_SHARE, bound)
    sentence = (
        f"{part.name}: its triangles enclose {found:.4f} mm^3, the exact solid "
        f"{part.volume:.4f} mm^3 ({error:.1e} apart)"
    )
    return Check("volume", part.name, bool(error <= bound), error, bound, "1", sentence)


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
