"""The tables of a mold's report, from what mold_report.json holds."""

from __future__ import annotations

from typing import Any

from fingerdesign.report.numbers import number_text
from fingerdesign.report.table import Table

DASH = "–"
MADE = {"process": "print", "sheet": "cut sheet", "metal": "cut", "silicone": "cast"}
HOLDING = {
    "wall": "closed, no plate leaves here",
    "comb": "comb: a cut sheet is the finger's face",
    "jig": "jig: two sheets, shifted to clamp",
    "slots": "slots through the wall",
}


def parts_table(data: dict[str, Any]) -> Table:
    """Parts by number, in the order in which they come off."""
    made = {**MADE, "process": {"machined": "machined"}.get(data["process"]["name"], "print")}
    rows = []
    for part in data["parts"]:
        size = " x ".join(f"{value:.1f}" for value in part["size_mm"])
        draw = "stays on the finger" if part["draw"] is None else _direction(part["draw"])
        rows.append(
            (
                str(part["number"]),
                as_words(part["name"]),
                made[part["made"]],
                draw,
                DASH if part["draw"] is None else str(part["order"]),
                size,
                f"{1e-3 * part['volume_mm3']:.2f}",
                ", ".join(part["files"]),
            )
        )
    columns = (*("", "part", "made", "drawn", "order", "size (mm)", "volume (cm³)", "files"),)
    texts = frozenset({1, 2, 3, 7})
    return Table("parts", "Parts, by their numbers in the picture", columns, tuple(rows), texts)


def hardware_text(data: dict[str, Any]) -> str:
    """What is bought or cut to hold the parts together, in words; "" without any.

    >>> hardware_text({"bill": [{"item": "bolt", "count": 2, "size": "M3 x 35"}]})
    '2 bolts (M3 x 35)'
    """
    held = ("bolt", "threaded rod", "nut", "washer", "dowel pin", "core pin", "core screw", "shim")
    reported = [
        f"{item['count']} {item['item']}{'s' if item['count'] > 1 else ''} ({item['size']})"
        for item in data["bill"]
        if item["item"] in held
    ]
    return "; ".join(reported)


def plates_table(data: dict[str, Any]) -> Table | None:
    """Where each plate stands; None without plates."""
    if not data["placements"]:
        return None
    rows = tuple(
        (
            str(each["plate"]),
            as_words(each["pattern"]).removeprefix("plate ") or DASH,
            number_text(each["x_mm"]),
            number_text(each["y_mm"]),
            number_text(each["z_mm"]),
            each["along"],
            number_text(each["angle_deg"], 2),
            ", ".join(each["held_at"]) or DASH,
        )
        for each in data["placements"]
    )
    columns = ("plate", "pattern", "x (mm)", "y (mm)", "z (mm)", "row along", "angle (°)")
    caption = "Where each plate stands in the mold (centres; angle from its row's axis)"
    return Table("plates", caption, (*columns, "held at"), rows, frozenset({1, 5, 7}))


def patterns_table(data: dict[str, Any]) -> Table | None:
    """The different plates as cut; None without plates."""
    if not data["plates"]:
        return None
    rows = tuple(
        (
            as_words(each["name"]),
            str(each["count"]),
            f"{each['width_mm']:.3f}",
            f"{each['length_mm']:.3f}",
            f"{each['thickness_mm']:g}",
            DASH if each["bend_radius_mm"] is None else f"{each['bend_radius_mm']:.3f}",
            as_words(each["material"]),
        )
        for each in data["plates"]
    )
    columns = (
        *("flat pattern", "count", "width (mm)", "length with legs (mm)", "thickness (mm)"),
        *("bend radius (mm)", "material"),
    )
    return Table("patterns", "Different plates, as cut", columns, rows, frozenset({0, 6}))


def fixture_table(data: dict[str, Any]) -> Table:
    """How each side is closed and holds plates."""
    rows = tuple(
        (
            each["side"],
            HOLDING[each["holding"]],
            str(each["slots"] or DASH),
            number_text(each["narrowest_slot_mm"]),
            number_text(each["shim_mm"] or None),
            number_text(each["sheet_mm"], 2),
            number_text(each["shift_mm"]),
        )
        for each in data["fixture"]
    )
    columns = ("side", "held by", "slots", "least width (mm)", "shim (mm)", "sheet (mm)")
    return Table("fixture", "Fixture", (*columns, "shift (mm)"), rows, frozenset({0, 1}))


def effects_table(placement: dict[str, Any] | None) -> Table | None:
    """What a plate off its place changes; None where it is not known."""
    if placement is None or placement.get("reason") is not None:
        return None
    names = {"along_x": "along x", "in_height": "in height", "turned": "turned"}
    rows = [
        (
            names.get(each["name"], each["name"]),
            f"{each['largest']:.3g} {each['unit']}",
            f"{100.0 * each['rms']:.2f}",
            f"{100.0 * each['worst']:.2f}",
            str(each["worst_plate"]),
        )
        for each in placement["changes"]
    ]
    both = placement["together"]
    sums = (f"{100.0 * both['rms']:.2f}", f"{100.0 * both['worst']:.2f}", str(both["worst_plate"]))
    rows.append(("these together", DASH, *sums))
    if "row" in placement:
        rows += [
            (
                f"the whole row {names[each['name']]}",
                f"{each['largest']:.3g} {each['unit']}",
                f"{100.0 * each['rms']:.2f}",
                f"{100.0 * each['worst']:.2f}",
                str(each["worst_plate"]),
            )
            for each in placement["row"]["changes"]
        ]
    columns = ("off", "by up to", "RMS (%)", "worst (%)", "worst plate")
    caption = "Change of a gage's reading, % of the largest reading of its row"
    return Table("effects", caption, columns, tuple(rows), frozenset({0}))


def bill_table(data: dict[str, Any]) -> Table | None:
    """The bill of materials; None where nothing was made."""
    if not data["bill"]:
        return None
    rows = tuple(
        (
            as_words(item["item"]),
            str(item["count"]),
            item["made"],
            item["material"],
            item["size"],
            number_text(item["mass_g"], 1),
        )
        for item in data["bill"]
    )
    columns = ("item", "count", "made", "material", "size", "mass (g)")
    return Table("bill", "What has to lie on the bench", columns, rows, frozenset({0, 2, 3, 4}))


def limits_table(data: dict[str, Any]) -> Table:
    """What the process was taken to hold."""
    words = {
        "wall_mm": "least wall",
        "feature_mm": "least web, rib or tip",
        "hole_mm": "least hole",
        "slot_mm": "least slot",
        "clearance_mm": "clearance, all round",
        "pin_mm": "least pin",
        "tolerance_mm": "tolerance of a place",
    }
    limits = data["process"]["limits"]
    rows = tuple((text, f"{limits[key]:g}") for key, text in words.items())
    caption = f"What the process holds ({data['process']['name']}), mm"
    return Table("limits", caption, ("limit", "mm"), rows, frozenset({0}))


def _direction(draw: list[float]) -> str:
    """A draw by its axis, or its three shares where it is oblique.

    >>> _direction([0.0, 1.0, 0.0]), _direction([0.0, 0.0, -1.0])
    ('+y', '-z')
    """
    for axis, share in zip("xyz", draw, strict=True):
        if abs(abs(share) - 1.0) < 1e-9:
            return f"{'+' if share > 0 else '-'}{axis}"
    return ", ".join(f"{share:.3f}" for share in draw)


def as_words(name: str) -> str:
    """A name as a reader meets it: without underscores."""
    return name.replace("_", " ")
