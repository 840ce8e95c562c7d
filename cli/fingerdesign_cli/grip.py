"""``fingerdesign grip``: lift an object of a weight and friction unknown to the controller."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import with_values
from fingerdesign.design.faults import undexed
from fingerdesign.errors import DesignError, Fault
from fingerdesign_cli.analyse import answer_of
from fingerdesign_cli.inputs import read_case, read_estimator
from fingerdesign_cli.terminal import number, print_json, print_table, progress, where_report

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.records.result import GripResult, Result


def grip(
    design_file: Path,
    out: Path,
    controller: str | None,
    frictions: tuple[float, ...],
    mass_g: float | None,
    fidelity: str,
    estimator_file: Path | None,
    go_on: bool,
    page: bool | None,
    cad: bool | None,
    fresh: bool,
    quiet: bool,
    as_json: bool,
) -> int:
    """Lift an object with DESIGN by the design's [grip] table, once per friction coefficient."""
    changes = {
        "--controller": ("grip.controller", controller),
        "--friction": ("grip.friction_coefficients", list(frictions) or None),
        "--mass-g": ("grip.object_mass_g", mass_g),
    }
    design, _ = read_case(design_file)
    design = _with_options(design, changes)
    if design.plates.number < 2:
        remedy = "add plates: without gages there is nothing to feel"
        raise DesignError([Fault("plates.count", design.plates.number, "at least 2", remedy)])

    estimator = None if estimator_file is None else read_estimator(estimator_file)

    with progress(design.design.name, quiet) as show:
        case = Case(design, None, fidelity, go_on=go_on, estimator=estimator)
        result = answer_of(case, out, show, page, cad, fresh)
    _report(result, out, quiet, as_json)
    return 0 if result.status == "ok" else 1


def _with_options(design: Design, options: Mapping[str, tuple[str, object]]) -> Design:
    """Set the keys of the options that were given; their faults name the option."""
    from dataclasses import replace

    given = {key: (name, value) for name, (key, value) in options.items() if value is not None}
    if not given:
        return design
    try:
        return with_values(design, {key: value for key, (_, value) in given.items()})
    except DesignError as error:
        faults = [
            replace(fault, key=f"{given[undexed(fault.key)][0]} ({fault.key})")
            if undexed(fault.key) in given
            else fault
            for fault in error.faults
        ]
        raise DesignError(faults) from None


def _report(result: Result, out: Path, quiet: bool, as_json: bool) -> None:
    from dataclasses import asdict

    folder = out / result.design
    if as_json:
        print_json(
            {
                "design": result.design,
                "status": result.status,
                "failure": result.failure,
                "folder": str(folder),
                "grips": [asdict(grip) for grip in result.grips],
            }
        )
    elif not quiet and result.status == "ok":
        headings = ["friction", "ends", "F_n N", "F_t N", "margin", "least stick", "holds"]
        headings += ["without the rule", "steps"]
        first = result.grips[0]
        title = f"{result.design}: {first.object_mass_g:g} g, {first.controller}, {result.fidelity}"
        print_table(title, headings, [_row(grip) for grip in result.grips])
        click.echo(where_report(folder))
    if result.failure:
        click.echo(f"{result.design} failed: {result.failure}", err=True)


def _row(grip: GripResult) -> list[str]:
    ends = "slips" if grip.gross_slip else "lifted" if grip.lifted else "not lifted"
    free = {True: "slips", False: "does not slip", None: "-"}[grip.slips_without_rule]
    return [
        f"{grip.friction_coefficient:g}",
        ends,
        number(grip.final_normal_force_N),
        number(grip.final_tangential_force_N),
        number(grip.safety_margin),
        number(grip.minimum_stick_ratio),
        f"{grip.holds}",
        free,
        f"{grip.steps}",
    ]
