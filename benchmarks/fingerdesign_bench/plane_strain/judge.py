"""``fingerdesign bench plane-strain``: the study of where plane strain holds, run and judged."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fingerdesign.mesh.section.netgen import start_mesher
from fingerdesign.runtime.progress import Report
from fingerdesign.validate.plane_strain import QUANTITIES, PlaneStrainMap, Table, map_of
from fingerdesign_bench.check import Check, Shown
from fingerdesign_bench.machine import machine
from fingerdesign_bench.plane_strain.chart import draw_map
from fingerdesign_bench.plane_strain.file import points_of, read_study, shipped_study
from fingerdesign_bench.plane_strain.rule import Rule, fitted
from fingerdesign_bench.plane_strain.run import JOURNAL, run_study
from fingerdesign_bench.plane_strain.table import table_of

FINER = "finer"  # the one-off model that shows what the meshes leave
# Known before (two codes; R = 20, nu = 0.49, approach 0.4, no plates): depth over height and a/H
# of those fingers, and by how much plane strain overstates F_n.
KNOWN = ((10.0 / 12.68, 0.31), (40.0 / 12.68, 0.12))
_KNOWN_WIDTH, _KNOWN_RATIO = 2.5 / 12.68, 0.49
RULES = (("normal_force", 0.0), ("normal_force", 1.0), ("gage_face", 1.0), ("gage_both", 1.0))
RULES_TITLE = "Rules fitted to the map; x = nu^2 / (1 - nu^2)"
RULE_HEADINGS = ("error of", "span/depth", "rule", "off", "at worst")
_LEAST_UNSURE = 0.01
_NINE_OF_TEN = 90.0


def measure_plane_strain(folder: Path, report: Report, quick: bool, study: Path | None) -> Shown:
    """Run the study, or what of it ``folder`` has no record of; the map and its rules.

    The record has the table that ships: points, also, rules, uncertainty.
    """
    begun = machine()
    points = list(points_of(read_study(study if study is not None else shipped_study()), quick))
    start_mesher()
    chart, rules = judged(table_of(run_study(points, folder / JOURNAL, report)))
    return Shown(
        "Plane strain",
        checks_of(chart, rules),
        begun,
        chart.table,
        paths=[draw_map(chart, folder / "plane_strain.png")],
        tables=[(RULES_TITLE, RULE_HEADINGS, [rule.row() for rule in rules])],
    )


def judged(table: Table) -> tuple[PlaneStrainMap, list[Rule]]:
    """Fit the rules and say how sure a look-up is."""
    chart = map_of(table)
    spans = {float(span) for span in chart.span}
    rules = [fitted(chart, name, span) for name, span in RULES if span in spans]
    table["rules"] = [rule.as_dict() for rule in rules]
    table["uncertainty"] = uncertainty(chart)
    return map_of(table), rules


def checks_of(chart: PlaneStrainMap, rules: Sequence[Rule]) -> list[Check]:
    """Checks of earlier knowledge, of the rules and of the meshes."""
    found = []
    if chart.inside(_KNOWN_RATIO, 0.0, KNOWN[0][0], _KNOWN_WIDTH):
        for depth, known in KNOWN:
            error = chart.error("normal_force", _KNOWN_RATIO, 0.0, depth, _KNOWN_WIDTH)
            name = f"F_n in plane strain, D/H = {depth:.2f}: off {known:.0%} by"
            found.append(Check(name, 0.02, abs(error - known)))
    if meshes := mesh_errors(chart):
        for words, quantity, target in (
            ("F_n", "normal_force", 0.01),
            ("gages", "gage_face", 0.05),
        ):
            name = f"{words}: errors change on finer meshes by"
            found.append(Check(name, target, meshes[quantity]))
    for rule in rules:
        if rule.quantity == "normal_force":
            where = "no plates" if rule.span == 0.0 else "plates of full span"
            found.append(Check(f"rule for F_n, {where}: worst distance", 0.05, rule.off))
            deeper = beyond_the_grid(chart, rule)
            if deeper is not None:
                found.append(Check(f"the same, deeper than the grid, {where}", 0.02, deeper))
    return found


def uncertainty(chart: PlaneStrainMap) -> dict[str, dict[str, float]]:
    """By quantity: an absolute part (the meshes') and a relative one, which together hold nine of
    ten errors of the one-off models against the map's."""
    meshes = mesh_errors(chart)
    found = {}
    for quantity in QUANTITIES:
        absolute = max(_LEAST_UNSURE, meshes.get(quantity, 0.0))
        shares = [
            max(0.0, abs(own - looked) - absolute) / max(abs(looked), _LEAST_UNSURE)
            for name, looked, own in against_map(chart, quantity)
            if name != FINER
        ]
        relative = float(np.percentile(shares, _NINE_OF_TEN)) if shares else 1.0
        sure = {"absolute": absolute, "relative": relative}
        found[quantity] = {name: float(f"{value:.3g}") for name, value in sure.items()}
    return found


def against_map(chart: PlaneStrainMap, quantity: str) -> list[tuple[str, float, float]]:
    """Name, the map's error and its own of each one-off model and approach that lies within it."""
    found = []
    for each in chart.table["also"]:
        place = (each["poissons_ratio"], each["span_over_depth"], each["depth_over_height"])
        if not chart.depth[0] <= each["depth_over_height"] <= chart.depth[-1]:
            continue
        for row in each["rows"]:
            looked = chart.error(quantity, *place, row["half_width_over_height"])
            if row[quantity] is not None and np.isfinite(looked):
                found.append((each["name"], looked, float(row[quantity])))
    return found


def beyond_the_grid(chart: PlaneStrainMap, rule: Rule) -> float | None:
    """The rule's worst distance to the one-off models deeper than the grid; None: there is none."""
    away = []
    for each in chart.table["also"]:
        if each["span_over_depth"] != rule.span or each["depth_over_height"] <= chart.depth[-1]:
            continue
        for row in each["rows"]:
            place = (each["poissons_ratio"], each["depth_over_height"])
            error = float(rule.error(*place, row["half_width_over_height"]))
            away.append(abs(error - row[rule.quantity]))
    return max(away, default=None)


def mesh_errors(chart: PlaneStrainMap) -> dict[str, float]:
    """By quantity, the greatest change of the errors on finer meshes; empty where none were run."""
    changes = {
        quantity: [abs(own - at) for name, at, own in against_map(chart, quantity) if name == FINER]
        for quantity in QUANTITIES
    }
    return {quantity: max(each) for quantity, each in changes.items() if each}
