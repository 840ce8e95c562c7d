"""``fingerdesign generate``: the variants of a study as files."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from fingerdesign.runtime.machine import usable_cores
from fingerdesign.runtime.progress import Progress
from fingerdesign.search.study import variants
from fingerdesign.search.study.file import Study, read_study
from fingerdesign.search.study.generate import Made, reasons, refuse_foreign
from fingerdesign.search.study.generate import generate as write_variants
from fingerdesign.search.study.variants import Variant
from fingerdesign_cli.inputs import GOES_ON, interrupted, naming_out
from fingerdesign_cli.studies.progress import line
from fingerdesign_cli.terminal import as_json, print_table, progress, quiet

_SHOWN = 20  # invalid variants, and kinds of reasons, that are shown one by one


def _chosen(study: Study, base: Any, only: tuple[int, ...]) -> tuple[int, Iterator[Variant]]:
    """Return the number of the variants of some numbers, or of all, and these variants."""
    every = variants.number_of_points(study)
    absent = [number for number in only if number > every]
    if absent:
        raise click.UsageError(f"--only = {absent[0]}: must be at most {every}")
    digits, requested = max(4, len(str(every))), set(only) or range(1, every + 1)
    return len(requested), (
        variants.variant_of(study, base, number, values, digits)
        for number, values in enumerate(variants.points(study), start=1)
        if number in requested
    )


@interrupted(GOES_ON)
def generate(
    study_file: Path, out: Path, only: tuple[int, ...], cad: bool, workers: int | None
) -> int:
    """Write the variants of STUDY, a TOML file or a shipped study: a folder each in OUT/NAME."""
    study = read_study(study_file)
    base = variants.base_design(study, study_file)
    target = out / study.name
    with naming_out(target, f"variants of {study.name}"):
        refuse_foreign(study, target)
    of, chosen = _chosen(study, base, only)
    workers = workers or usable_cores()
    with progress(study.name, not as_json()) as show:
        report = _Reported(show, of).report
        found = write_variants(
            study, chosen, target, cad=cad, whole=not only, workers=workers, report=report
        )
    if as_json():
        line(_data(found, target))
    else:
        _show(found, target)
    valid = [made for made in found if made.variant.design is not None]
    if not valid:
        where = target / "invalid.csv"
        reported = f"no variant can exist: all {len(found)} have faults, reported in {where}"
        click.echo(f"{reported}; change [parameters], [fixed] or the base", err=True)
    elif quiet() and len(valid) < len(found):
        reported = f"{len(found) - len(valid)} of {len(found)} cannot exist"
        click.echo(f"{reported}: faults in {target / 'invalid.csv'}", err=True)
    return 0 if valid and not any(made.failed for made in found) else 1


@dataclass
class _Reported:
    """Shows the variants as they are made, and counts those without a design or CAD."""

    show: Progress
    of: int
    invalid: int = 0
    failed: int = 0

    def report(self, made: Made, done: int) -> None:
        """Show one variant more."""
        self.invalid += made.variant.design is None
        self.failed += made.failed
        if as_json():
            line({"done": done, "of": self.of, **_variant_data(made)})
        if done == self.of or done % max(1, self.of // 20) == 0:
            failed = f"; CAD failed of {self.failed}" if self.failed else ""
            self.show(f"{done} of {self.of}, {self.invalid} invalid{failed}", done / self.of)


def _show(found: Sequence[Made], target: Path) -> None:
    invalid = [made.variant for made in found if made.variant.design is None]
    for made in found:
        if made.failed:
            click.echo(f"{made.variant.name}: no CAD: {made.cad}", err=True)
    if quiet():
        return
    _show_invalid(invalid, target)
    existed, failed = sum(m.existed for m in found), sum(m.failed for m in found)
    there = f", {existed} of them there already" if existed else ""
    count = len(found) - len(invalid)
    click.echo(f"{count} variant{'' if count == 1 else 's'}{there}: {target}")
    if invalid:
        click.echo(f"{len(invalid)} cannot exist: {target / 'invalid.csv'}")
    if failed:
        click.echo(f"{failed} without CAD, which failed; run again to try again")


def _show_invalid(invalid: Sequence[Variant], target: Path) -> None:
    for variant in invalid[:_SHOWN]:
        for fault in variant.faults:
            click.echo(f"{variant.name}: {fault}")
    if len(invalid) > _SHOWN:
        click.echo(f"... and {len(invalid) - _SHOWN} more in {target / 'invalid.csv'}")
    if len(invalid) > 1:
        rows = [[key, str(count), name] for key, count, _, name in reasons(invalid)[:_SHOWN]]
        print_table("why variants cannot exist", ["key", "variants", "the first"], rows)


def _variant_data(made: Made) -> dict[str, object]:
    variant = made.variant
    return {
        **{key: getattr(variant, key) for key in ("number", "name", "values")},
        "valid": variant.design is not None,
        "faults": [str(fault) for fault in variant.faults],
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
