"""Tables of a mold's report, from its record."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from fingerdesign.mold.part import axis_name
from fingerdesign.report.table import Table, number_text

if TYPE_CHECKING:
    from fingerdesign.mold.record import CheckData, HoleData, MoldData

DASH = "–"
HOLES = {
    "gate": "gate: pour in here",
    "riser": "riser",
    "vent": "vent",
    "lock": "lock: rubber rises in it and holds",
    "screw": "screw of the core",
    "wires": "leads of the gages, with a pocket for their knot",
}
HOLDING = {
    "wall": "closed, no plate leaves here",
    "comb": "comb: a cut sheet is the finger's face",
    "slots": "slots through the wall",
}
OFFSETS = {"along_x": "along x", "in_height": "in height", "turned": "turned"}
LIMITS = {
    "wall_mm": "least wall",
    "feature_mm": "least web, rib or tip",
    "hole_mm": "least hole",
    "slot_mm": "least slot",
    "clearance_mm": "clearance, all round",
    "pin_mm": "least pin",
    "tolerance_mm": "tolerance of a place",
}


def words(name: str) -> str:
    """A name of the program's own without underscores."""
    return name.replace("_", " ")


def table(
    key: str, caption: str, columns: Sequence[str], texts: Iterable[int], rows: Iterable[Any]
) -> Table:
    """A table whose cells may be numbers; ``texts``: the columns that are none."""
    cells = tuple(tuple(map(str, row)) for row in rows)
    return Table(key, caption, tuple(columns), cells, frozenset(texts))


def labels(holes: list[HoleData]) -> list[str]:
    """A label a hole: its kind's letter, and a number where there are more of them.

    >>> labels([{"kind": "gate"}, {"kind": "vent"}, {"kind": "vent"}])
    ['G', 'V1', 'V2']
    """
    kinds = [hole["kind"] for hole in holes]
    numbers = [kinds[: k + 1].count(kind) for k, kind in enumerate(kinds)]
    return [
        f"{kind[0].upper()}{number if kinds.count(kind) > 1 else ''}"
        for kind, number in zip(kinds, numbers, strict=True)
    ]


def made_words(data: MoldData) -> dict[str, str]:
    """Words for the making of a part, by ``made`` of the record."""
    process = "machined" if data["process"]["name"] == "machined" else "print"
    return {"process": process, "sheet": "cut sheet", "metal": "cut"}


def parts_table(data: MoldData) -> Table:
    """The parts by their numbers in the picture, in the order in which they come off."""
    made = made_words(data)
    rows = [
        (
            part["number"],
            words(part["name"]),
            made[part["made"]],
            axis_name(part["draw"]) if part["draw"] else "stays on the finger",
            part["order"] if part["draw"] else DASH,
            " x ".join(f"{size:.1f}" for size in part["size_mm"]),
            f"{1e-3 * part['volume_mm3']:.2f}",
            ", ".join(part["files"]),
        )
        for part in data["parts"]
    ]
    columns = ("", "part", "made", "drawn", "order", "size (mm)", "volume (cm³)", "files")
    return table("parts", "Parts, by their numbers in the picture", columns, (1, 2, 3, 7), rows)


def holes_table(holes: list[HoleData]) -> Table:
    """The holes of the base plate, by their labels in its plan."""
    rows = [
        (
            label,
            HOLES[hole["kind"]],
            f"{hole['x_mm']:.2f}",
            f"{hole['z_mm']:.2f}",
            f"{hole['diameter_mm']:.2f}",
            f"{hole['outer_diameter_mm']:.2f}",
        )
        for label, hole in zip(labels(holes), holes, strict=True)
    ]
    columns = ("", "hole", "x (mm)", "z (mm)", "diameter inside (mm)", "at the back (mm)")
    return table("base-holes", "Holes of the base plate", columns, (0, 1), rows)


def coupon_table(data: MoldData) -> Table:
    """The rows of the test coupon, and the limits that they show."""
    limits: dict[str, Any] = {**data["process"]["limits"]}
    rows = [
        (
            each["kind"],
            ", ".join(map(str, each["sizes_mm"])),
            each["measure"],
            each["key"],
            f"{limits[each['key']]:g}",
        )
        for each in data["coupon"]
    ]
    columns = ("row", "sizes (mm)", "found", "name", "planned with (mm)")
    return table("coupon", "What the coupon shows", columns, (0, 1, 2, 3), rows)


def patterns_table(data: MoldData) -> Table:
    """The different plates, as cut."""
    rows = [
        (
            words(each["name"]),
            each["count"],
            f"{each['width_mm']:.3f}",
            f"{each['length_mm']:.3f}",
            f"{each['thickness_mm']:g}",
            number_text(each["bend_radius_mm"]),
            words(each["material"]),
        )
        for each in data["plates"]
    ]
    columns = ("flat pattern", "count", "width (mm)", "length with legs (mm)", "thickness (mm)")
    more = ("bend radius (mm)", "material")
    return table("patterns", "Different plates, as cut", (*columns, *more), (0, 6), rows)


def fixture_table(data: MoldData) -> Table:
    """The holders of the plates at each side."""
    rows = [
        (
            each["side"],
            HOLDING[each["holding"]],
            each["slots"] or DASH,
            number_text(each["narrowest_slot_mm"]),
            number_text(each["sheet_mm"], 2),
            number_text(each["held_over_mm"] or None, 2),
            (2 if each["pushed"] else 1) if each["slots"] else DASH,
        )
        for each in data["fixture"]
    ]
    columns = ("side", "held by", "slots", "least width (mm)", "sheet (mm)", "held over (mm)")
    return table("fixture", "Fixture", (*columns, "sheets that hold a leg"), (0, 1), rows)


def plates_table(data: MoldData) -> Table:
    """The place of each plate in the mold."""
    rows = [
        (
            each["plate"],
            words(each["pattern"]).replace("plate ", "") or DASH,
            number_text(each["x_mm"]),
            number_text(each["y_mm"]),
            number_text(each["z_mm"]),
            each["along"],
            number_text(each["angle_deg"], 2),
            ", ".join(each["held_at"]) or DASH,
        )
        for each in data["placements"]
    ]
    columns = ("plate", "pattern", "x (mm)", "y (mm)", "z (mm)", "row along", "angle (°)")
    caption = "Place of each plate in the mold (centres; angle from its row's axis)"
    return table("plates", caption, (*columns, "held at"), (1, 5, 7), rows)


def effects_table(placement: Any) -> Table:
    """The effects of plates off their places; placement: the record's, with its numbers."""

    def offsets(changes: Iterable[Any], of: str) -> Iterator[tuple[str, str, Any]]:
        for each in changes:
            yield of + OFFSETS[each["name"]], f"{each['largest']:.3g} {each['unit']}", each

    row = placement.get("row", {"changes": ()})
    every = [
        *offsets(placement["changes"], "against its neighbours "),
        ("against its neighbours, together", DASH, placement["together"]),
        *offsets(row["changes"], "the whole row "),
    ]
    if "together" in row:
        both = placement["together"], row["together"]
        sums = {key: math.hypot(*(each[key] for each in both)) for key in ("rms", "worst")}
        every.append(("all together", DASH, {**sums, "worst_plate": DASH}))
    rows = [
        (name, size, f"{100 * each['rms']:.2f}", f"{100 * each['worst']:.2f}", each["worst_plate"])
        for name, size, each in every
    ]
    columns = ("off", "by up to", "RMS (%)", "worst (%)", "worst plate")
    caption = "Change of a gage's reading, % of the largest reading of its row"
    return table("effects", caption, columns, (0,), rows)


def bill_table(data: MoldData) -> Table:
    """The bill of materials."""
    rows = [
        (
            item["when"],
            words(item["item"]),
            item["count"],
            item["made"],
            item["material"],
            item["size"],
            number_text(item["mass_g"], 1),
        )
        for item in data["bill"]
    ]
    columns = ("when", "item", "count", "made", "material", "size", "mass (g)")
    return table("bill", "What has to lie on the bench", columns, (0, 1, 3, 4, 5), rows)


def hours_table(data: MoldData) -> Table:
    """Hands-on hours by step."""
    rows = [(e["step"], e["counts"], e["bare_h"], e["wired_h"]) for e in data["hours"]]
    sums = (sum(each["bare_h"] for each in data["hours"]), sum(e["wired_h"] for e in data["hours"]))
    rows.append(("all", DASH, round(sums[0], 1), round(sums[1], 1)))
    columns = ("step", "counts", "bare finger (h)", "wired, beyond it (h)")
    caption = "Hands-on hours (minutes for each thing are assumed; waiting is left out)"
    return table("hours", caption, columns, (0, 1), rows)


def checks_table(key: str, caption: str, checks: Sequence[CheckData]) -> Table:
    """Checks, one a row."""
    rows = [(each["name"], *_measured(each)) for each in checks]
    columns = ("check", "part", "measured", "bound", "unit", "what was found")
    return table(f"checks-{key}", f"{caption}: {len(checks)}", columns, (0, 1, 4, 5), rows)


def kinds_table(checks: list[CheckData]) -> Table:
    """The kinds of checks, and of each the one that is nearest its bound."""
    rows = [
        (near["name"], each["checked"], each["failed"] or DASH, *_measured(near))
        for each in kinds_of(checks)
        for near in [each["nearest"]]
    ]
    columns = ("check", "checked", "failed", "nearest its bound", "measured", "bound", "unit")
    caption = "What was checked; of each kind the one that is nearest its bound"
    return table("checks-kinds", caption, (*columns, "what was found"), (0, 3, 6, 7), rows)


def _measured(check: CheckData) -> tuple[str, ...]:
    """Part, measure, bound, unit and finding of a check."""
    sizes = measure(check["measured"]), measure(check["bound"])
    return words(check["part"]) or "mold", *sizes, check["unit"] or DASH, check["sentence"]


def limits_table(data: MoldData) -> Table:
    """The least sizes that the process makes."""
    limits: dict[str, Any] = {**data["process"]["limits"]}
    rows = [(name, f"{limits[key]:g}") for key, name in LIMITS.items()]
    caption = f"What the process holds ({data['process']['name']}), mm"
    return table("limits", caption, ("limit", "mm"), (0,), rows)


def kinds_of(checks: list[CheckData]) -> list[dict[str, Any]]:
    """Count each kind of check: how often, how many failed, and the one nearest its bound."""
    found = []
    for name in dict.fromkeys(check["name"] for check in checks):
        alike = [check for check in checks if check["name"] == name]
        failed = [check for check in alike if not check["ok"]]
        nearest = min(failed or alike, key=_room)
        found.append({"checked": len(alike), "failed": len(failed), "nearest": nearest})
    return found


def _room(check: CheckData) -> float:
    """Distance of a measure from its bound, relative to the larger; 0: at it, or not reported."""
    measured, bound = check["measured"], check["bound"]
    if measured is None or bound is None:
        return 0.0
    most = max(abs(measured), abs(bound))
    return float(abs(measured - bound) / most) if most > 0.0 else 0.0


def measure(value: float | None) -> str:
    """A measured value in four digits; a dash where there is none.

    >>> measure(0.123456), measure(None), measure(0.0), measure(15.0)
    ('0.1235', '–', '0', '15')
    """
    if value is None or not math.isfinite(value):
        return DASH
    return "0" if abs(value) < 1e-12 else f"{value:.4g}"
