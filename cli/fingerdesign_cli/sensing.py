"""``gages``, ``train``, ``export-c``, ``calibrate``, ``identify``: what gages say,
to whom."""

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.control.bench_table import TABLE
from fingerdesign.control.c_code import c_files
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.trace import read_trace
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.records.base import json_text, plain
from fingerdesign.records.folder import RecordFolder
from fingerdesign.runtime.files import write_whole
from fingerdesign.runtime.machine import usable_cores
from fingerdesign.sensing.identify.bench import simulated_bench
from fingerdesign.sensing.identify.bench_fit import PRIOR
from fingerdesign.sensing.identify.bench_report import (
    CALIBRATION,
    ESTIMATOR_FILE,
    FITTED_FILE,
    MEASURED,
    CalibratedFinger,
    calibrated_finger,
    write_calibration,
    write_measured,
)
from fingerdesign.sensing.identify.simulated_trace import (
    SIMULATED,
    TRACE_FILE,
    TRUTH_FILE,
    simulated_trace,
)
from fingerdesign.sensing.identify.trace_fit import identified
from fingerdesign.sensing.identify.trace_page import write_identification
from fingerdesign.sensing.identify.trace_report import (
    DESIGN_FILE,
    IDENTIFICATION,
    PAGE_FILE,
    IdentificationData,
)
from fingerdesign.sensing.model import gripped_case
from fingerdesign.sensing.train.estimator import TrainingResult
from fingerdesign.validate.gages.record import FOLDER, Observability, write_observability
from fingerdesign.validate.gages.study import observe, refuse
from fingerdesign_cli.inputs import estimator_for, read_case, recorded, refuse_foreign
from fingerdesign_cli.terminal import open_page, print_json, print_table, say

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


# ``fingerdesign train``: an estimator of the stick ratio for a design's gages, for a rig too.


def train(
    design_file: Path,
    out: Path,
    noise: float,
    workers: int | None,
    fidelity: str,
    quiet: bool,
    as_json: bool,
) -> int:
    """Train the estimator that the regulator grips by, on DESIGN's own model."""
    design, _ = read_case(design_file)
    from fingerdesign.sensing.train.result import training_result_for, training_text

    name = design.design.name
    kind = RecordFolder("lesson", "lesson.json", ("lesson.json", "estimator.json"))
    with recorded(kind, out / name, quiet) as (folder, show):
        result = training_result_for(
            design, None, lambda said: show(said, 0.0), workers or usable_cores(), fidelity
        )
        result = replace(result, estimator=result.estimator.at_noise(noise))
        record = {k: v for k, v in json.loads(training_text(result)).items() if k != "estimator"}
        (folder / "estimator.json").write_text(result.estimator.to_json(), encoding="utf-8")
        (folder / "lesson.json").write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
        show("writing", 1.0)
    if as_json:
        print_json({"design": name, **record})
    elif not quiet:
        _show_errors(result, name, out / name)
    return 0


def _show_errors(result: TrainingResult, name: str, folder: Path) -> None:
    rows = [
        [f"{noise:g}", f"{stick:.3f}", f"{used:.3f}"]
        for noise, stick, used in zip(
            result.noises, result.stick_errors, result.used_errors, strict=True
        )
    ]
    columns = ["noise, microstrain", "stick ratio", "friction in use"]
    print_table(f"{name}: errors (RMS) on {_held_out(result)}", columns, rows)
    click.echo(f"{result.samples} samples were taught; {folder / 'estimator.json'} is for a rig")


def _held_out(result: TrainingResult) -> str:
    """What the errors are of: other fingers, or other grips of the one that was taught."""
    grips, fingers = result.judged_grips, result.judged_fingers
    if grips is None or fingers is None:
        return "held-out grips (taught by an earlier version: of which fingers was not recorded)"
    if fingers:
        words = f"{grips} grips of {fingers} other fingers, drawn as those taught were"
        return f"{words}; nothing of them was taught"
    return f"{grips} other grips of the same finger or fingers: on another one it is not judged"


# ``fingerdesign export-c``: the regulator for a hand's computer.


def export_c(**given: Any) -> int:
    """Write the regulator of DESIGN, which grips by ESTIMATOR, as C99."""
    return _exported("regulator in C", lambda e, design: c_files(e, design.grip), **given)


def _exported(
    what: str,
    files_of: Callable[[GripEstimator, Design], Mapping[str, str | bytes]],
    *,
    estimator_file: Path,
    design_file: Path,
    out: Path,
    noise: float | None,
    quiet: bool,
    as_json: bool,
) -> int:
    design, _ = read_case(design_file)
    try:
        estimator = estimator_for(design, estimator_file)
    except DesignError as error:
        faults = [replace(fault, key="ESTIMATOR") for fault in error.faults]
        raise DesignError(faults, error.source) from error
    assert estimator is not None
    estimator = estimator if noise is None else estimator.at_noise(noise)
    name, files = design.design.name, files_of(estimator, design)
    kind = RecordFolder(what, next(iter(files)), tuple(files))
    with recorded(kind, out / name, quiet) as (folder, _):
        for file, content in files.items():
            write_whole(folder / file, content)
    weights = sum(layer.weight.size for layer in estimator.band.layers)
    if as_json:
        about = {"gages": estimator.gages, "noise_microstrain": estimator.noise}
        print_json({"design": name, **about, "weights": weights, "files": list(files)})
    elif not quiet:
        written = " and ".join(files)
        click.echo(f"{out / name}: {written}, {estimator.gages} gages, {weights} weights")
    return 0


def gages(
    design_file: Path,
    out: Path,
    noise: float,
    grips: int,
    workers: int | None,
    fidelity: str,
    quiet: bool,
    as_json: bool,
) -> int:
    """Tell how well DESIGN's gages determine the stick ratio, how few suffice and where."""
    design, _ = read_case(design_file)
    refuse(design, noise, grips)
    name = design.design.name
    with recorded(FOLDER, out / name, quiet) as (folder, show):
        found = observe(
            design, noise, grips, lambda message: show(message), workers or usable_cores(), fidelity
        )
        show("writing", 1.0)
        write_observability(found, folder)
    if as_json:
        print_json(found.data())
    elif not quiet:
        _show(found, out / name)
    open_page(out / name / "observability.png")
    return 0


def _show(found: Observability, folder: Path) -> None:
    rows = [
        [
            str(len(each.kept)) if each.kept else "0 (forces and moves)",
            f"{each.stick_error:.3f} ± {each.stick_spread:.3f}",
            f"{each.used_error:.3f}",
            ", ".join(f"{x:g}" for x in found.places(each)) or "–",
        ]
        for each in found.confirmed
    ]
    what = "errors (RMS) on other grips of the same finger"
    title = f"{found.design} at {found.noise:g} microstrain: {what}"
    print_table(title, ["gages", "stick ratio", "friction in use", "at x, mm"], rows)
    rows = [
        [
            f"{each.x_mm:g}",
            f"{each.response_microstrain_per_N:.3g}",
            str(each.rank),
            f"{each.untold_stick_cost:+.3f}",
            f"{each.told_stick_cost:+.3f}",
        ]
        for each in sorted(found.gages, key=lambda gage: gage.x_mm)
    ]
    columns = ["gage at x, mm", "microstrain/N", "rank", "dead, untold", "dead, told"]
    print_table("each gage: 1 is missed most; what its silence adds to the error", columns, rows)
    for sentence in (*found.limits, *found.sentences):
        click.echo(sentence)
    click.echo(f"{found.seconds:.0f} s; chart: {folder / 'observability.png'}")


# ``fingerdesign calibrate``: this very finger's estimator, and what its bench says of it.


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
        _show_fit(found, target)
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


def _show_fit(found: CalibratedFinger, folder: Path) -> None:
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


# ``fingerdesign identify``: rubber, friction and gages from one trace.


def identify(
    design_file: Path,
    trace_file: Path | None,
    out: Path,
    simulate: bool,
    seed: int,
    terms: int | None,
    fidelity: str,
    quiet: bool,
    as_json: bool,
) -> int:
    """Fit, or play, a trace of the finger cast by DESIGN."""
    if simulate == (trace_file is not None):
        raise click.UsageError("give either TRACE or --simulate")
    design, _ = read_case(design_file)
    target = out / design.design.name
    if trace_file is None:
        return _simulated_trace(design, target, seed, fidelity, quiet, as_json)
    gripped_case(design, fidelity)
    trace = read_trace(trace_file, len(gage_array(design)))
    with recorded(IDENTIFICATION, target, quiet) as (folder, show):
        found = identified(design, trace, str(trace_file), fidelity, terms, show)
        show("writing", 1.0)
        data = write_identification(found, trace_file.name, folder)
    if as_json:
        print_json(plain(data))
    elif not quiet:
        _show_values(data, target)
    open_page(target / PAGE_FILE)
    return 0


def _simulated_trace(
    design: Design, target: Path, seed: int, fidelity: str, quiet: bool, as_json: bool
) -> int:
    with recorded(SIMULATED, target, quiet) as (folder, show):
        show("playing a trace")
        made = simulated_trace(design, seed, fidelity)
        (folder / TRACE_FILE).write_text(made.trace.to_csv(), encoding="utf-8")
        (folder / TRUTH_FILE).write_text(json_text(made.truth), encoding="utf-8")
    if as_json:
        print_json({"design": design.design.name, "seed": seed, "rows": len(made.trace)})
    elif not quiet:
        click.echo(f"{target / TRACE_FILE}: {len(made.trace)} rows; truth.json is what was drawn")
    return 0


def _show_values(data: IdentificationData, folder: Path) -> None:
    own = [each for each in data.values if not each.name.startswith("gage_")]
    gains = [each for each in data.values if each.kind == "gain"]
    rows = [
        [
            each.name.replace("_", " ").replace(".", ", "),
            *each.shown(),
            each.unit,
            "yes" if each.told else "not enough",
        ]
        for each in (*own, *gains)
    ]
    columns = ["value", "found", "95 % interval", "unit", "told"]
    print_table(f"{data.design}: what {data.trace} tells", columns, rows)
    for warning in data.warnings:
        click.echo(f"warning: {warning}")
    if data.next_motion is not None:
        of = data.next_motion.of.replace("_", " ")
        click.echo(f"next: {data.next_motion.words}; it would tell most of {of}")
    click.echo(f"{folder / PAGE_FILE}; the design with these values: {folder / DESIGN_FILE}")
