"""``fingerdesign generate``: the variants of a study as files."""

from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import click

from fingerdesign.runtime.machine import usable_cores
from fingerdesign.search.study.file import Study, read_study
from fingerdesign.search.study.generate import Made, reasons, refuse_foreign
from fingerdesign.search.study.generate import generate as write_variants
from fingerdesign.search.study.variants import base_design, number_of_points, points, variant_of
from fingerdesign_cli.inputs import naming_out
from fingerdesign_cli.search import line
from fingerdesign_cli.terminal import print_table, progress

_SHOWN = 20  # invalid variants, and kinds of reasons, that are shown one by one


def generate(
    study_file: Path,
    out: Path,
    count: int | None,
    only: tuple[int, ...],
    cad: bool,
    workers: int | None,
    quiet: bool,
    as_json: bool,
) -> int:
    """Write the variants of STUDY, a TOML file or a shipped study: a folder each in OUT/NAME."""
    study = read_study(study_file)
    base = base_design(study, study_file.parent)
    target = out / study.name
    with naming_out(target, f"variants of {study.name}"):
        refuse_foreign(study, target)
    of, chosen = _chosen(study, base, count, only)
    invalid = failed = 0
    with progress(study.name, quiet or as_json) as show:

        def report(made: Made, done: int) -> None:
            nonlocal invalid, failed
            invalid += made.variant.design is None
            failed += made.failed
            if as_json:
                line({"done": done, "of": of, **_variant_data(made)})
            if done == of or done % max(1, of // 20) == 0:
                reported = f"; CAD failed of {failed}" if failed else ""
                show(f"{done} of {of}, {invalid} invalid{reported}", done / of)

        found = write_variants(
            study,
            chosen,
            target,
            cad=cad,
            whole=count is None and not only,
            workers=workers or usable_cores(),
            report=report,
        )
    if as_json:
        line(_data(found, target))
    else:
        _show(found, target, quiet)
    valid = [made for made in found if made.variant.design is not None]
    if not valid:
        where = target / "invalid.csv"
        reported = f"no variant can exist: all {len(found)} have faults, reported in {where}"
        click.echo(f"{reported}; change [parameters], [fixed] or the base", err=True)
    elif quiet and len(valid) < len(found):
        reported = f"{len(found) - len(valid)} of {len(found)} cannot exist"
        click.echo(f"{reported}: faults in {target / 'invalid.csv'}", err=True)
    return 0 if valid and not any(made.failed for made in found) else 1


def _chosen(study: Study, base: Any, count: int | None, only: tuple[int, ...]) -> tuple[int, Any]:
    """Return the number of requested variants, and the variants."""
    all_of_them = number_of_points(study)
    absent = [number for number in only if number > all_of_them]
    if absent:
        raise click.UsageError(f"--only = {absent[0]}: must be at most {all_of_them}")
    digits = max(4, len(str(all_of_them)))
    requested = set(only)
    rows = (
        (number, values)
        for number, values in enumerate(points(study), start=1)
        if not requested or number in requested
    )
    of = len(requested) or all_of_them
    of = of if count is None else min(count, of)
    return of, (
        variant_of(study, base, number, values, digits) for number, values in islice(rows, of)
    )


def _show(found: Sequence[Made], target: Path, quiet: bool) -> None:
    invalid = [made.variant for made in found if made.variant.design is None]
    for made in found:
        if made.failed:
            click.echo(f"{made.variant.name}: no CAD: {made.cad}", err=True)
    if quiet:
        return
    for variant in invalid[:_SHOWN]:
        for fault in variant.faults:
            click.echo(f"{variant.name}: {fault}")
    if len(invalid) > _SHOWN:
        click.echo(f"... and {len(invalid) - _SHOWN} more in {target / 'invalid.csv'}")
    reported = reasons(invalid)[:_SHOWN]
    if len(invalid) > 1:
        rows = [[key, str(count), name] for key, count, _, name in reported]
        print_table("why variants cannot exist", ["key", "variants", "the first"], rows)
    existed, failed = (
        sum(each) for each in zip(*((m.existed, m.failed) for m in found), strict=True)
    )
    click.echo(f"{len(found) - len(invalid)} variants, {existed} of them there already: {target}")
    if invalid:
        click.echo(f"{len(invalid)} cannot exist: {target / 'invalid.csv'}")
    if failed:
        click.echo(f"{failed} without CAD, which failed; run again to try again")


def _variant_data(made: Made) -> dict[str, object]:
    return {
        "number": made.variant.number,
        "name": made.variant.name,
        "values": made.variant.values,
        "valid": made.variant.design is not None,
        "faults": [str(fault) for fault in made.variant.faults],
        "cad": made.cad or None,
        "kept": made.existed,
    }


def _data(found: Sequence[Made], target: Path) -> dict[str, object]:
    return {
        "folder": str(target),
        "variants": len(found),
        "valid": sum(made.variant.design is not None for made in found),
        "invalid": sum(made.variant.design is None for made in found),
        "cad_failed": sum(made.failed for made in found),
    }
