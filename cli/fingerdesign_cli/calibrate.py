"""``fingerdesign calibrate``: this very finger's estimator, and what its bench says of it."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from fingerdesign.control.plants.measured import TABLE
from fingerdesign.records.base import plain
from fingerdesign.runtime.machine import usable_cores
from fingerdesign.sensing.bench import simulated_bench
from fingerdesign.sensing.calibrate import (
    CALIBRATION,
    ESTIMATOR_FILE,
    FITTED_FILE,
    MEASURED,
    CalibratedFinger,
    calibrated_finger,
    write_calibration,
    write_measured,
)
from fingerdesign.sensing.latents import PRIOR
from fingerdesign_cli.inputs import estimator_for, read_case, recorded, refuse_foreign
from fingerdesign_cli.terminal import print_json, print_table, say

_WORDS = {
    "x": "plates along x",
    "y": "plates along y",
    "angle": "plates' angles",
    "modulus": "rubber's modulus",
    "poisson": "Poisson's ratio",
    "plate_modulus": "plates' modulus",
    "lean": "lean of the bench",
    "touch": "touch",
    "gain": "gages' gains",
}
_DRAWN = ("plates", "modulus", "gains")  # what a simulated finger is unlike in


def calibrate(
    design_file: Path,
    out: Path,
    measured: Path | None,
    simulate: bool,
    estimator_file: Path | None,
    faults: tuple[str, ...],
    seed: int,
    workers: int | None,
    fidelity: str,
    quiet: bool,
    as_json: bool,
) -> int:
    """Measure, or play the measurement of, the finger cast by DESIGN."""
    if simulate == (measured is not None):
        raise click.UsageError("give either --measured FOLDER or --simulate")
    if simulate and estimator_file is not None:
        raise click.UsageError("--simulate only writes what a bench measures: no --estimator")
    if not simulate and faults:
        raise click.UsageError("--fault is of --simulate alone")
    if simulate:
        return _simulated(design_file, out, faults or _DRAWN, seed, fidelity, quiet, as_json)
    assert measured is not None
    design, _ = read_case(design_file)
    target = out / design.design.name
    refuse_foreign(CALIBRATION, target)
    estimator = estimator_for(design, estimator_file, fidelity)
    with recorded(CALIBRATION, target, quiet) as (folder, show):
        processes = workers or usable_cores()
        found = calibrated_finger(design, measured, estimator, fidelity, processes, show)
        show("writing", 1.0)
        write_calibration(found, folder)
    if as_json:
        print_json(plain(found.data))
    elif not quiet:
        _show(found, target)
    return 0


def _simulated(
    design_file: Path,
    out: Path,
    faults: tuple[str, ...],
    seed: int,
    fidelity: str,
    quiet: bool,
    as_json: bool,
) -> int:
    design, _ = read_case(design_file)
    target = out / design.design.name
    with recorded(MEASURED, target, quiet) as (folder, show):
        show("playing the bench")
        bench = simulated_bench(design, faults, seed, fidelity)
        write_measured(bench, folder)
    names = [phase.name for phase in bench.phases]
    if as_json:
        about = {"faults": list(faults), "seed": seed, "lean_deg": bench.lean_deg}
        print_json({"design": design.design.name, **about, "traces": names})
    elif not quiet:
        click.echo(f"{target}: {TABLE} and {len(names)} traces; drawn.toml is the finger drawn")
    return 0


def _show(found: CalibratedFinger, folder: Path) -> None:
    data, fit = found.data, found.fit
    rows = []
    for kind, before in PRIOR.items():
        values, deviations = fit.of(kind)
        if len(values):
            (unit,) = {each.unit for each in fit.latents if each.kind == kind}
            most = values[int(np.argmax(np.abs(values)))]
            after = float(np.sqrt(np.mean(deviations**2)))
            words = f"{_WORDS[kind]}, {unit}".removesuffix(", ")
            determined = int((deviations < 0.5 * before).sum())
            cells = [f"{most:+.3g}", f"{before:.2g}", f"{after:.2g}"]
            rows.append([words, *cells, f"{determined} of {len(values)}"])
    headings = ["off the design", "most", "± before", "± after", "determined"]
    print_table(f"{data.design}: what its bench says of it ({data.fidelity})", headings, rows)
    before, after = data.fit.before_microstrain, data.fit.after_microstrain
    click.echo(f"readings off the model by {before:.3g} microstrain, fitted by {after:.3g} (RMS)")
    for warning in data.warnings:
        say(f"mind: {warning}")
    written = f"{folder / FITTED_FILE} is this finger"
    if found.estimator is not None:
        written = f"{folder / ESTIMATOR_FILE} is for it; {written}"
    click.echo(f"delay: {data.delay_samples} samples; {written}")
