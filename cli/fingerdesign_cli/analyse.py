"""``fingerdesign analyse``: from design files to results and reports."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import click

from fingerdesign.analysis.answers import (
    DESIGN,
    PAGE,
    cached_answer,
    is_cached,
    missing,
)
from fingerdesign.analysis.case import Case
from fingerdesign.analysis.page.tables import detail_tables
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.faults import undexed
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import load_scene
from fingerdesign.errors import DesignError, Fault
from fingerdesign.mesh.section.netgen import start_mesher
from fingerdesign.records.result import GripResult, Result
from fingerdesign.records.result_files import RESULTS
from fingerdesign.runtime.progress import Progress
from fingerdesign_cli.inputs import estimator_for, read_case, refuse_foreign
from fingerdesign_cli.terminal import (
    WIDTH,
    details,
    number,
    open_page,
    opens,
    part_of,
    print_json,
    print_table,
    progress,
    say_block,
    say_details,
)


def analyse(
    designs: tuple[Path, ...],
    out: Path,
    scene_file: Path | None,
    fidelity: str,
    tolerance: float | None,
    go_on: bool,
    no_fields: bool,
    page: bool | None,
    cad: bool | None,
    fresh: bool,
    quiet: bool,
    as_json: bool,
) -> int:
    """Analyse each DESIGN: contact, gages, grips, and a result in OUT/NAME."""
    options: dict[str, Any] = {"go_on": go_on, "fields": not no_fields}
    if tolerance is not None:
        if fidelity != "auto":
            raise click.UsageError("--tolerance belongs to --fidelity auto; add that or leave it")
        options["tolerance"] = tolerance
    cases = _read(designs, scene_file, fidelity, out, fresh, **options)
    results: list[Result] = []
    for done, case in enumerate(cases):
        name = case.design.design.name
        with progress(name, quiet) as show:
            part = part_of(show, done, len(cases))
            results.append(answer_of(case, out, part, page, cad, fresh))
    _report(results, out, quiet, as_json)
    for result in results:
        open_page(out / result.design / PAGE)
    return 0 if all(result.status == "ok" for result in results) else 1


def answer_of(
    case: Case, out: Path, show: Progress, page: bool | None, cad: bool | None, fresh: bool
) -> Result:
    """Write OUT/NAME from the cached answer, or by an analysis, which alone loads the solvers."""
    page = page or (True if opens() else page)
    found = None if fresh else cached_answer(case, out, page, cad)
    if found is not None:
        show("analysed before: its answer is taken (--fresh analyses it again)")
        if any(missing(case, out, page, cad)):
            from fingerdesign.analysis.folder import complete_answer

            complete_answer(case, out, page, cad)
        return found
    from fingerdesign.pipeline import analyse_into

    return analyse_into(case, out, show, page, cad, fresh=True)


def _read(
    designs: tuple[Path, ...],
    scene_file: Path | None,
    fidelity: str,
    out: Path,
    fresh: bool,
    **options: Any,
) -> list[Case]:
    """Every fault of every file, of each design in its scene, and of --out, before any work."""
    wrong: list[DesignError] = []
    cases: list[Case] = []
    scene = None
    with _collected(wrong):
        scene = None if scene_file is None else load_scene(scene_file)
    for path in designs:
        with _collected(wrong):
            name = scene_file.stem if scene_file is not None else ""
            cases.append(Case(load_design(path), scene, fidelity, scene_name=name, **options))
    for case in cases:
        with _collected(wrong):
            if fresh or not is_cached(case):
                if case.fidelity == "plane-strain":
                    start_mesher()  # it loads while this process loads the rest
                from fingerdesign.analysis.forecast.limits import refuse

                refuse(case, case.path_scene)
        with _collected(wrong):
            refuse_foreign(RESULTS, out / case.design.design.name)
    names = [case.design.design.name for case in cases]
    twice = sorted({name for name in names if names.count(name) > 1})
    remedy = "rename: it names the folder"
    faults = [Fault("design.name", name, "different in each file", remedy) for name in twice]
    if wrong or faults:
        raise DesignError.together([*wrong, DesignError(faults)])
    return cases


@contextmanager
def _collected(wrong: list[DesignError]) -> Iterator[None]:
    """Add the block's refusal to the others; each names its own file."""
    try:
        yield
    except DesignError as error:
        wrong.append(error)


def _report(results: list[Result], out: Path, quiet: bool, as_json: bool) -> None:
    if as_json:
        keys = ("design", "status", "failure")
        print_json(
            [
                {key: getattr(r, key) for key in keys}
                | {"folder": str(out / r.design)}
                | ({"reached": r.ladder.reached} if r.ladder else {})
                for r in results
            ]
        )
        return
    if quiet:
        for r in results:
            if r.failure:
                click.echo(f"{r.design} failed: {r.failure}", err=True)
        return
    for result in results:
        folder = out / result.design
        say_block(verdict_view(result, str(folder / DESIGN)), folder)
        if details():
            _say_details(result)


def _say_details(result: Result) -> None:
    """Everything that the block leaves out: the model, each warning, tables of numbers."""
    if result.ladder:
        click.echo(f"{result.ladder.chosen}; {result.ladder.models[-1].why}")
    say_details(result.warnings, detail_tables(result))


# ``fingerdesign grip``: lift an object of a weight and friction unknown to the controller.


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

    estimator = estimator_for(design, estimator_file, fidelity)
    with progress(design.design.name, quiet) as show:
        case = Case(design, None, fidelity, go_on=go_on, estimator=estimator)
        result = answer_of(case, out, show, page, cad, fresh)
    _report_grips(result, out, quiet, as_json)
    open_page(out / result.design / PAGE)
    return 0 if result.status == "ok" else 1


def _with_options(design: Design, options: Mapping[str, tuple[str, object]]) -> Design:
    """Set the keys of the options that were given; their faults name the option."""
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


def _report_grips(result: Result, out: Path, quiet: bool, as_json: bool) -> None:
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
        return
    if result.failure:
        click.echo(f"{result.design} failed: {result.failure}", err=True)
    elif not quiet:
        first = result.grips[0]
        title = f"{result.design}: {first.object_mass_g:g} g, {first.controller}"
        headings = ["μ", "ends", "F_n N", "margin", "stick", "pauses"]
        headings += ["stick error", "slip warning"]
        rows = [_row(grip) for grip in result.grips]
        shown = [k for k in range(len(headings)) if any(row[k] not in ("-", "") for row in rows)]
        cells = [[row[k] for k in shown] for row in rows]
        print_table(title, [headings[k] for k in shown], cells, WIDTH)
        say_block(verdict_view(result, str(folder / DESIGN)), folder)
        if details():
            _say_details(result)


def _row(grip: GripResult) -> list[str]:
    ends = (
        "caught"
        if grip.caught
        else "slips"
        if grip.gross_slip
        else "lifted"
        if grip.lifted
        else "not lifted"
    )
    return [
        f"{grip.friction_coefficient:g}",
        ends,
        number(grip.final_normal_force_N),
        number(grip.safety_margin),
        number(grip.minimum_stick_ratio),
        f"{grip.holds}",
        number(grip.stick_error, 3),
        _warned(grip),
    ]


def _warned(grip: GripResult) -> str:
    """Time and part of F_t at which the controller warned of complete slip; its false alarms."""
    words = {"withdrawn": "withdrawn", "none": "none"}.get(grip.slip_warning or "", "-")
    if grip.lead_s is not None:
        words = f"{grip.lead_s:.2f} s before, {number(grip.lead_force_share, 0, 100.0)} % F_t"
    return f"{words}; {grip.false_alarms} of {grip.alarms} false" if grip.alarms else words
