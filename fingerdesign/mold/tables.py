"""Tables of a mold's report, from its record."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from fingerdesign.mold.part import axis_name
from fingerdesign.mold.record import CheckData, HoleData, MoldData
from fingerdesign.report.page import texts_of
from fingerdesign.report.table import Table, number_text

TEMPLATES = Path(__file__).parent / "templates"
WORDS = texts_of(TEMPLATES / "page.toml")
DASH = "–"


def words(name: str) -> str:
    """A name of the program's own without underscores."""
    return name.replace("_", " ")


def table(key: str, caption: str, texts: Iterable[int], rows: Iterable[Mapping[str, Any]]) -> Table:
    """A table of rows, one or more, that are cells, which may be numbers, by their columns;
    ``texts``: the columns that are none."""
    first, *others = rows
    cells = (tuple(map(str, row.values())) for row in (first, *others))
    return Table(key, caption, tuple(first), tuple(cells), frozenset(texts))


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
    rows = (
        {
            "": part["number"],
            "part": words(part["name"]),
            "made": made[part["made"]],
            "drawn": axis_name(part["draw"]) if part["draw"] else "stays on the finger",
            "order": part["order"] if part["draw"] else DASH,
            "size (mm)": " x ".join(f"{size:.1f}" for size in part["size_mm"]),
            "volume (cm³)": f"{1e-3 * part['volume_mm3']:.2f}",
            "files": ", ".join(part["files"]),
        }
        for part in data["parts"]
    )
    return table("parts", "Parts, by their numbers in the picture", (1, 2, 3, 7), rows)


def holes_table(holes: list[HoleData]) -> Table:
    """The holes of the base plate, by their labels in its plan."""
    rows = (
        {
            "": label,
            "hole": WORDS["holes"][hole["kind"]],
            "x (mm)": f"{hole['x_mm']:.2f}",
            "z (mm)": f"{hole['z_mm']:.2f}",
            "diameter inside (mm)": f"{hole['diameter_mm']:.2f}",
            "at the back (mm)": f"{hole['outer_diameter_mm']:.2f}",
        }
        for label, hole in zip(labels(holes), holes, strict=True)
    )
    return table("base-holes", "Holes of the base plate", (0, 1), rows)


def coupon_table(data: MoldData) -> Table:
    """The rows of the test coupon, and the limits that they show."""
    limits: dict[str, Any] = {**data["process"]["limits"]}
    rows = (
        {
            "row": each["kind"],
            "sizes (mm)": ", ".join(map(str, each["sizes_mm"])),
            "found": each["measure"],
            "name": each["key"],
            "planned with (mm)": f"{limits[each['key']]:g}",
        }
        for each in data["coupon"]
    )
    return table("coupon", "What the coupon shows", (0, 1, 2, 3), rows)


def patterns_table(data: MoldData) -> Table:
    """The different plates, as cut."""
    rows = (
        {
            "flat pattern": words(each["name"]),
            "count": each["count"],
            "width (mm)": f"{each['width_mm']:.3f}",
            "length with legs (mm)": f"{each['length_mm']:.3f}",
            "thickness (mm)": f"{each['thickness_mm']:g}",
            "bend radius (mm)": number_text(each["bend_radius_mm"]),
            "material": words(each["material"]),
        }
        for each in data["plates"]
    )
    return table("patterns", "Different plates, as cut", (0, 6), rows)


def fixture_table(data: MoldData) -> Table:
    """The holders of the plates at each side."""
    rows = (
        {
            "side": each["side"],
            "held by": WORDS["holding"][each["holding"]],
            "slots": each["slots"] or DASH,
            "least width (mm)": number_text(each["narrowest_slot_mm"]),
            "sheet (mm)": number_text(each["sheet_mm"], 2),
            "held over (mm)": number_text(each["held_over_mm"] or None, 2),
            "sheets that hold a leg": (2 if each["pushed"] else 1) if each["slots"] else DASH,
        }
        for each in data["fixture"]
    )
    return table("fixture", "Fixture", (0, 1), rows)


def plates_table(data: MoldData) -> Table:
    """The place of each plate in the mold."""
    rows = (
        {
            "plate": each["plate"],
            "pattern": words(each["pattern"]).replace("plate ", "") or DASH,
            "x (mm)": number_text(each["x_mm"]),
            "y (mm)": number_text(each["y_mm"]),
            "z (mm)": number_text(each["z_mm"]),
            "row along": each["along"],
            "angle (°)": number_text(each["angle_deg"], 2),
            "held at": ", ".join(each["held_at"]) or DASH,
        }
        for each in data["placements"]
    )
    caption = "Place of each plate in the mold (centres; angle from its row's axis)"
    return table("plates", caption, (1, 5, 7), rows)


def effects_table(placement: Any) -> Table:
    """The effects of plates off their places; placement: the record's, with its numbers."""

    def offsets(changes: Iterable[Any], of: str) -> Iterator[tuple[str, str, Any]]:
        for each in changes:
            name = of + WORDS["offsets"][each["name"]]
            yield name, f"{each['largest']:.3g} {each['unit']}", each

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
    rows = (
        {
            "off": name,
            "by up to": size,
            "RMS (%)": f"{100 * each['rms']:.2f}",
            "worst (%)": f"{100 * each['worst']:.2f}",
            "worst plate": each["worst_plate"],
        }
        for name, size, each in every
    )
    caption = "Change of a gage's reading, % of the largest reading of its row"
    return table("effects", caption, (0,), rows)


def bill_table(data: MoldData) -> Table:
    """The bill of materials."""
    rows = (
        {
            "when": item["when"],
            "item": words(item["item"]),
            "count": item["count"],
            "made": item["made"],
            "material": item["material"],
            "size": item["size"],
            "mass (g)": number_text(item["mass_g"], 1),
        }
        for item in data["bill"]
    )
    return table("bill", "What has to lie on the bench", (0, 1, 3, 4, 5), rows)


def hours_table(data: MoldData) -> Table:
    """Hands-on hours by step."""
    hours = data["hours"]
    every = [(e["step"], e["counts"], e["bare_h"], e["wired_h"]) for e in hours]
    bare, wired = sum(e["bare_h"] for e in hours), sum(e["wired_h"] for e in hours)
    every.append(("all", DASH, round(bare, 1), round(wired, 1)))
    columns = ("step", "counts", "bare finger (h)", "wired, beyond it (h)")
    rows = (dict(zip(columns, row, strict=True)) for row in every)
    caption = "Hands-on hours (minutes for each thing are assumed; waiting is left out)"
    return table("hours", caption, (0, 1), rows)


def checks_table(key: str, caption: str, checks: Sequence[CheckData]) -> Table:
    """Checks, one a row."""
    rows = ({"check": each["name"], "part": _part(each), **_measured(each)} for each in checks)
    return table(f"checks-{key}", f"{caption}: {len(checks)}", (0, 1, 4, 5), rows)


def kinds_table(checks: list[CheckData]) -> Table:
    """The kinds of checks, and of each the one that is nearest its bound."""
    rows = (
        {
            "check": near["name"],
            "checked": each["checked"],
            "failed": each["failed"] or DASH,
            "nearest its bound": _part(near),
            **_measured(near),
        }
        for each in kinds_of(checks)
        for near in [each["nearest"]]
    )
    caption = "What was checked; of each kind the one that is nearest its bound"
    return table("checks-kinds", caption, (0, 3, 6, 7), rows)


def _part(check: CheckData) -> str:
    return words(check["part"]) or "mold"


def _measured(check: CheckData) -> dict[str, str]:
    return {
        "measured": measure(check["measured"]),
        "bound": measure(check["bound"]),
        "unit": check["unit"] or DASH,
        "what was found": check["sentence"],
    }


def limits_table(data: MoldData) -> Table:
    """The least sizes that the process makes."""
    limits: dict[str, Any] = {**data["process"]["limits"]}
    rows = ({"limit": name, "mm": f"{limits[key]:g}"} for key, name in WORDS["limits"].items())
    caption = f"What the process holds ({data['process']['name']}), mm"
    return table("limits", caption, (0,), rows)


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
