"""The parts of ``fingerdesign bench`` that hold numbers against what was asked."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
from fingerdesign_cli.options import fidelity_option, folder_option, output_options
from fingerdesign_cli.terminal import print_json, print_table, progress

from fingerdesign_bench.cli.charts import name_files, show_checks

if TYPE_CHECKING:
    from fingerdesign_bench.check import Check


@click.command("reference", short_help="Against two other finite-element codes (half a minute).")
@click.option("--tetwild/--no-tetwild", default=True, show_default=True, help="Also by pytetwild.")
@click.option("--quick", is_flag=True, help="Plane strain alone: seconds.")
@folder_option("reference")
@output_options
def reference(tetwild: bool, quick: bool, folder: Path, quiet: bool, as_json: bool) -> int:
    """The cases whose answers two other finite-element codes agree on.

    About 30 s from a cold cache of meshes, 11 s with --no-tetwild.
    """
    from fingerdesign_bench.accuracy.reference import (
        one_plate_checks,
        plane_strain_checks,
        three_d_checks,
    )

    with progress("bench reference", quiet or as_json) as report:
        report("plane strain")
        checks = [*plane_strain_checks(), *one_plate_checks()]
        meshers = () if quick else ("extrude", "tetwild") if tetwild else ("extrude",)
        for mesher in meshers:
            report(f"3-D, {mesher}")
            checks += three_d_checks(mesher)
    return _show("reference", "Against two other codes", checks, folder, quiet, as_json)


@click.command("condensation", short_help="Condensed against full, and its cost (2 min).")
@folder_option("condensation")
@output_options
def condensation(folder: Path, quiet: bool, as_json: bool) -> int:
    """Condensed against full, and what condensing costs."""
    from fingerdesign_bench.speed.condensation import condensation_checks

    with progress("bench condensation", quiet or as_json) as report:
        report("condensing")
        checks = condensation_checks()
    return _show("condensation", "Condensation", checks, folder, quiet, as_json)


@click.command("assembly", short_help="Our assembly against scikit-fem's own (1 min).")
@folder_option("assembly")
@output_options
def assembly(folder: Path, quiet: bool, as_json: bool) -> int:
    """Stiffness of 100,000 dofs by scikit-fem's own assembly and by ours."""
    from fingerdesign_bench.speed.assembly import assembly_checks

    with progress("bench assembly", quiet or as_json) as report:
        report("assembling")
        checks = assembly_checks()
    return _show("assembly", "Assembly", checks, folder, quiet, as_json)


@click.command("steps", short_help="Steps of a grip followed, and solved anew (2 min).")
@folder_option("steps")
@output_options
def steps(folder: Path, quiet: bool, as_json: bool) -> int:
    """A grip's increments, each from the one before and each solved anew; a hundred lifts."""
    from fingerdesign_bench.speed.steps import step_checks

    with progress("bench steps", quiet or as_json) as report:
        report("gripping")
        checks = step_checks()
    return _show("steps", "Steps of a grip", checks, folder, quiet, as_json)


@click.command("environment", short_help="Steps a second of the Gymnasium environment (1 min).")
@folder_option("environment")
@output_options
def environment(folder: Path, quiet: bool, as_json: bool) -> int:
    """Steps a second of the Gymnasium environment in 3-D on one core, in processor time.

    By a random hand, which slips at once, and by a scripted one; with the resets that press to the
    preload, and without. Needs the extra `gym`.
    """
    from fingerdesign_bench.speed.environment import environment_checks

    with progress("bench environment", quiet or as_json) as report:
        report("gripping")
        checks = environment_checks()
    return _show("environment", "Gymnasium environment", checks, folder, quiet, as_json)


@click.command("latents", short_help="Hidden values of ten fingers from their benches (15 min).")
@click.option("--fingers", type=click.IntRange(1, 1000), default=10, show_default=True)
@folder_option("latents")
@output_options
def latents(fingers: int, folder: Path, quiet: bool, as_json: bool) -> int:
    """What `fingerdesign identify` fits of drawn fingers beside what was drawn, in plane strain.

    Plates, modulus and gains of `sensitive`, 0.5 microstrain of noise: RMS errors, and how often
    the deviations that the fit states cover them.
    """
    from fingerdesign_bench.studies.latents import latent_checks

    with progress("bench latents", quiet or as_json) as report:
        checks = latent_checks(fingers, report=report)
    return _show("latents", "Hidden values of drawn fingers", checks, folder, quiet, as_json)


@click.command("identify", short_help="Values of 200 fingers from one trace each (half an hour).")
@click.option("--rigs", type=click.IntRange(1, 10_000), default=200, show_default=True)
@folder_option("identify")
@output_options
def identify(rigs: int, folder: Path, quiet: bool, as_json: bool) -> int:
    """What `fingerdesign identify` finds in traces of drawn fingers beside what was drawn.

    `sensitive` in plane strain, its modulus off by up to half, rubber with none to two terms of
    relaxation, noise, drift and two kelvin of warming: how often 95 % intervals hold the truth.
    """
    from fingerdesign_bench.studies.identified import identify_checks

    with progress("bench identify", quiet or as_json) as report:
        checks = identify_checks(folder, rigs, report=report)
    return _show("identify", "Values from one trace", checks, folder, quiet, as_json)


@click.command("smoothness", short_help="Ripple of the pressure on the meshes used (2 min).")
@folder_option("smoothness")
@output_options
def smoothness(folder: Path, quiet: bool, as_json: bool) -> int:
    """The reference finger's pressure at z = 0 against that on facets of 0.1 mm."""
    from fingerdesign_bench.accuracy.smoothness import smoothness_checks

    with progress("bench smoothness", quiet or as_json) as report:
        report("pressing")
        checks = smoothness_checks()
    return _show("smoothness", "Smoothness of the pressure", checks, folder, quiet, as_json)


@click.command("suite", short_help="Cases with known answers (4 min; --quick seconds).")
@click.option("--quick", is_flag=True, help="The few that cost seconds.")
@click.option(
    "--problems", is_flag=True, help="Also write the contact problems, for other solvers."
)
@folder_option("suite")
@output_options
def suite(quick: bool, problems: bool, folder: Path, quiet: bool, as_json: bool) -> int:
    """Analytic solutions, other codes' answers and our own, each with its source and tolerances.

    Hertz, Cattaneo-Mindlin, Spence, Lubkin, Carter, layers, patch tests, published cases, and rates
    in the size and in the increment: a page with pictures. Exit code 1 where one is missed, or is
    no longer what it was; misses that are known and explained are none.
    """
    from fingerdesign_bench.known.case import load_cases
    from fingerdesign_bench.known.run import HEADINGS, row, run_cases, write_suite

    cases = [case for case in load_cases() if case.quick or not quick]
    with progress("bench suite", quiet or as_json) as report:
        found = run_cases(cases, report)
    paths = write_suite(found, folder, problems)
    if as_json:
        print_json([each.as_dict() for each in found.outcomes])
    elif not quiet:
        print_table("Cases with known answers", HEADINGS, [row(each) for each in found.outcomes])
        name_files(paths)
    return 1 if found.fails else 0


@click.command("agreement", short_help="One finger meshed in several ways, one answer (4 min).")
@folder_option("agreement")
@output_options
def agreement(folder: Path, quiet: bool, as_json: bool) -> int:
    """One finger meshed in several ways gives one answer: what differs, what each mesh costs.

    The reference finger extruded and by fTetWild, its plates as solids and as sheets, and fTetWild
    once more.
    """
    from fingerdesign_bench.accuracy.agreement import agreement_checks

    with progress("bench agreement", quiet or as_json) as report:
        checks = agreement_checks(report)
    return _show("agreement", "One finger, several meshes", checks, folder, quiet, as_json)


@click.command("whole", short_help="A whole `analyse` from cold caches (1.5 min).")
@fidelity_option(None, unset="both")
@folder_option("whole")
@output_options
def whole(fidelity: str | None, folder: Path, quiet: bool, as_json: bool) -> int:
    """Seconds, memory and dofs of `analyse`, from cold caches."""
    from fingerdesign_bench.speed.whole import whole_checks

    checks = []
    with progress("bench whole", quiet or as_json) as report:
        for each in (fidelity,) if fidelity else ("plane-strain", "3d"):
            report(each)
            found, stages = whole_checks(each)
            checks += found
            report(f"{each}: " + ", ".join(f"{name} {s:.1f} s" for name, s in stages.items() if s))
    title = "A whole analysis, in a process of its own"
    return _show("whole", title, checks, folder, quiet, as_json)


def _show(
    name: str,
    title: str,
    checks: Sequence[Check],
    folder: Path,
    quiet: bool,
    as_json: bool,
) -> int:
    """Print the checks and write them with the machine to NAME.json."""
    from fingerdesign_bench.machine import machine

    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.json"
    record = {"machine": machine(), "checks": [check.as_dict() for check in checks]}
    path.write_text(json.dumps(record, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return show_checks(title, checks, [path], quiet, as_json)


COMMANDS = (
    reference,
    smoothness,
    condensation,
    assembly,
    steps,
    environment,
    latents,
    identify,
    suite,
    agreement,
    whole,
)
