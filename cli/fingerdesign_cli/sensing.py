"""``train``, ``identify``, ``export``: the estimator, hidden values, files for other systems."""

import json
from collections import Counter
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.control.bench_table import TABLE
from fingerdesign.control.c_code import c_files
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.fmi import plant, regulator
from fingerdesign.control.fmi.pack import WITHOUT_LIBRARY, systems_of
from fingerdesign.control.trace import read_trace
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import json_text, plain
from fingerdesign.records.folder import RecordFolder
from fingerdesign.runtime.files import write_whole
from fingerdesign.runtime.machine import usable_cores
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.identify import bench_report, trace_report
from fingerdesign.sensing.identify.bench import simulated_bench
from fingerdesign.sensing.identify.latents import PRIOR
from fingerdesign.sensing.identify.simulated_trace import (
    SIMULATED,
    TRACE_FILE,
    TRUTH_FILE,
    simulated_trace,
)
from fingerdesign.sensing.identify.trace_fit import identified
from fingerdesign.sensing.identify.trace_page import value_table, write_identification
from fingerdesign.sensing.model import grip_problem, gripped_case
from fingerdesign.sensing.train.estimator import TrainingResult
from fingerdesign_cli.inputs import (
    GOES_ON,
    all_sound,
    estimator_for,
    interrupted,
    read_case,
    recorded,
    refuse_foreign,
)
from fingerdesign_cli.options import Options
from fingerdesign_cli.terminal import opens, print_table, say, say_done, say_result

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
UNITS = {
    file: RecordFolder("functional mock-up unit", file, (file,))
    for file in (regulator.FILE, plant.FILE)
}
_IN_C = RecordFolder("regulator in C", "regulator.c", ("regulator.c", "regulator.h"))
_DRAWN = ("plates", "modulus", "gains")  # A simulated finger has these faults, if none is given.


def train(design_file: Path, out: Path, noise: float, workers: int | None, fidelity: str) -> int:
    """Train the estimator that the regulator grips by, on DESIGN's own model."""
    design, _ = read_case(design_file)
    from fingerdesign.sensing.train.result import training_result_for, training_text

    name = design.design.name
    kind = RecordFolder("training result", "training.json", ("training.json", "estimator.json"))
    with recorded(kind, out / name) as (folder, show):
        with interrupted(GOES_ON):  # grips of finished fingers are stored
            result = training_result_for(
                design, lambda message: show(message, 0.0), workers or usable_cores(), fidelity
            )
        result = replace(result, estimator=result.estimator.at_noise(noise))
        record = {k: v for k, v in json.loads(training_text(result)).items() if k != "estimator"}
        (folder / "estimator.json").write_text(result.estimator.to_json(), encoding="utf-8")
        (folder / "training.json").write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
        show("writing", 1.0)
    facts = {"design": name, **record}
    return say_result(lambda: facts, lambda: _show_errors(result, name, out / name))


def _show_errors(result: TrainingResult, name: str, folder: Path) -> None:
    errors = (result.stick_errors, result.friction_utilisation_errors)
    levels = zip(result.noises_microstrain, *errors, strict=True)
    rows = [[f"{noise:g}", f"{stick:.3f}", f"{used:.3f}"] for noise, stick, used in levels]
    columns = ["noise, microstrain", "stick ratio", "friction in use"]
    print_table(f"{name}: errors (RMS) on {_held_out(result)}", columns, rows)
    click.echo(f"{result.samples} samples for training; {folder / 'estimator.json'} is for a rig")


def _held_out(result: TrainingResult) -> str:
    """Describe the held-out grips: of other fingers, or other grips of the training finger."""
    grips, fingers = result.judged_grips, result.judged_fingers
    if fingers:
        return f"{grips} grips of {fingers} other fingers, drawn as those for training"
    return f"{grips} other grips of the same finger or fingers: it is not tested on another one"


@dataclass(frozen=True)
class Target(Options):
    """The system to write for. noise: of the regulator's gages; densities: of the finger's
    materials; fidelity: of the plant; flex_mm: size of the rubber's tetrahedra, None where it is
    rigid."""

    to: str
    noise: float | None
    densities: tuple[tuple[str, float], ...]
    fidelity: str | None
    flex_mm: float | None


def export(files: tuple[Path, ...], out: Path, target: Target) -> int:
    """Write DESIGN for another system: its regulator, or the finger."""
    if len(files) > 2:
        raise click.UsageError("give a design, or an estimator and its design")
    design, _ = read_case(files[-1])
    folder = out / design.design.name
    _refuse_target(target, len(files) == 2)
    if target.to in ("mjcf", "urdf"):
        return _export_finger(design, folder, target)
    if target.to == "fmu-plant":
        return _export_plant(design, folder, target.fidelity or "plane-strain")
    return _export_regulator(design, folder, files[0] if len(files) == 2 else None, target)


def _refuse_target(target: Target, with_estimator: bool) -> None:
    """Raise UsageError for an option that the target does not take."""
    given = {  # option: if it is given, and the targets that take it
        "--fidelity": (target.fidelity is not None, ("fmu-plant",)),
        "--flex": (target.flex_mm is not None, ("mjcf",)),
        "--density": (bool(target.densities), ("mjcf", "urdf")),
        "--noise": (target.noise is not None, ("c", "fmu")),
        "an estimator": (with_estimator, ("c", "fmu")),
    }
    for option, (is_given, takers) in given.items():
        if is_given and target.to not in takers:
            raise click.UsageError(f"{option} is for {' and '.join(takers)} alone")


def _refuse_twice(target: Target) -> None:
    """Raise DesignError for materials that are given several densities."""
    counts = Counter(name for name, _ in target.densities)
    remedy = "leave all but one out"
    twice = [name for name, count in counts.items() if count > 1]
    if twice:
        raise DesignError([Fault("--density", each, "a material once", remedy) for each in twice])


def _export_plant(design: Design, folder: Path, fidelity: str) -> int:
    kind = UNITS[plant.FILE]
    sound = (partial(plant.refuse_sliding, design), partial(gripped_case, design, fidelity))
    all_sound(*sound, partial(refuse_foreign, kind, folder))
    with recorded(kind, folder) as (aside, show):
        model = grip_problem(design, fidelity, report=show)
        content = plant.plant_fmu(model, design)
        write_whole(aside / plant.FILE, content)
    about = {"gages": len(model.model.gage_x), "contact_nodes": model.model.nodes}
    return _show_unit(folder / plant.FILE, content, about)


def _show_unit(path: Path, content: bytes, about: dict[str, Any]) -> int:
    kilobytes = 1e-3 * len(content)
    named = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in about.items())
    systems = systems_of(content)
    built = f"library for {', '.join(systems)}" if systems else WITHOUT_LIBRARY
    words = f"{path}: {named}, {kilobytes:.0f} kB, {built}"
    facts = about | {"files": [path.name], "kilobytes": kilobytes, "systems": systems}
    return say_done({"design": path.parent.name, **facts}, words)


def _export_finger(design: Design, folder: Path, target: Target) -> int:
    from fingerdesign.robots.describe import FOLDERS, describe, mjcf, urdf
    from fingerdesign.robots.rigid import densities

    record = {"mjcf": "xml", "urdf": "urdf"}[target.to]
    kind, write = FOLDERS[record], {"xml": mjcf, "urdf": urdf}[record]
    given = dict(target.densities)
    sound = (partial(_refuse_twice, target), partial(densities, design, given))
    all_sound(*sound, partial(refuse_foreign, kind, folder))
    with recorded(kind, folder) as (aside, show):
        show("drawing the finger")
        finger = describe(design, aside, given, target.flex_mm)
        write_whole(aside / f"finger.{record}", write(finger))
    meshes = sorted(path.name for path in finger.meshes.values())
    grams, sites = 1e3 * finger.mass, len(finger.sites)
    words = f"{folder / f'finger.{record}'}: {grams:.3g} g, gages: {sites}, meshes: {len(meshes)}"
    about = {"design": finger.name, "mass_g": grams, "gages": sites}
    return say_done({**about, "files": [f"finger.{record}", *meshes]}, words)


def _export_regulator(design: Design, folder: Path, path: Path | None, target: Target) -> int:
    """Write the regulator; training, which takes minutes, begins where the folder is free."""
    is_unit = target.to == "fmu"
    with recorded(UNITS[regulator.FILE] if is_unit else _IN_C, folder) as (aside, show):
        estimator = _estimator_of(design, path, show, target.fidelity)
        estimator = estimator if target.noise is None else estimator.at_noise(target.noise)
        if estimator.noise > (most := estimator.bands[-1].most_noise):
            click.echo(
                f"warning: the estimator was trained for a noise of up to {most:g} microstrain",
                err=True,
            )
        unit = regulator.fmu(estimator, design.grip) if is_unit else b""
        texts = {} if is_unit else c_files(estimator, design.grip)
        for file, content in ({regulator.FILE: unit} if is_unit else texts).items():
            write_whole(aside / file, content)
    gages = estimator.gages
    if is_unit:
        return _show_unit(folder / regulator.FILE, unit, {"gages": gages})
    weights = sum(layer.weight.size for layer in estimator.band.layers)
    words = f"{folder}: {' and '.join(texts)}, {gages} gages, {weights} weights"
    facts = {"design": design.design.name, "gages": gages, "noise_microstrain": estimator.noise}
    return say_done({**facts, "weights": weights, "files": list(texts)}, words)


def _estimator_of(
    design: Design, path: Path | None, report: Report, fidelity: str | None
) -> GripEstimator:
    """The estimator in a file; without one that shipped with the design, or one that is trained."""
    if path is None:
        from fingerdesign.sensing.train.ready import estimator_of, shipped_estimator

        if (shipped := shipped_estimator(design, fidelity)) is not None:
            return shipped
        report(f"no estimator ships for {design.design.name}: one is trained")
        return estimator_of(design, report, fidelity=fidelity or "plane-strain")
    try:
        estimator = estimator_for(design, path)
    except DesignError as error:
        faults = [replace(fault, key="ESTIMATOR") for fault in error.faults]
        raise DesignError(faults, error.source) from error
    assert estimator is not None
    return estimator


@dataclass(frozen=True)
class Simulated(Options):
    """The finger of a simulated trace or bench; simulate: one is simulated."""

    simulate: bool
    faults: tuple[str, ...]
    seed: int


@dataclass(frozen=True)
class Fitted(Options):
    """Measurements to fit to: a trace, with so many terms of relaxation, or a bench, whose curves
    the estimator is given; measured: the former name of source."""

    source: Path | None
    measured: Path | None
    bench: bool
    estimator_file: Path | None
    terms: int | None

    @property
    def file(self) -> Path | None:
        """The measurements."""
        return self.source or self.measured

    @property
    def is_bench(self) -> bool:
        """True for a bench's folder or table, and where a bench is to be simulated."""
        file = self.file
        return self.bench or (file is not None and (file.is_dir() or file.name == TABLE))


def identify(
    design_file: Path, out: Path, fitted: Fitted, simulated: Simulated, fidelity: str
) -> int:
    """Fit hidden values of the finger cast by DESIGN to a trace or a bench, or simulate either."""
    _refuse_options(fitted, simulated)
    design, _ = read_case(design_file)
    target, source = out / design.design.name, fitted.file
    if source is None and fitted.is_bench:
        return _simulate_bench(design, simulated, fidelity, target)
    if source is None:
        return _simulate_trace(design, simulated.seed, fidelity, target)
    if fitted.is_bench:
        estimator = estimator_for(design, fitted.estimator_file, fidelity)
        return _identify_bench(design, source, estimator, fidelity, target)
    return _identify_trace(design, source, fitted.terms, fidelity, target)


def _refuse_options(fitted: Fitted, simulated: Simulated) -> None:
    simulate, bench = simulated.simulate, fitted.is_bench
    measured, trace = bench and not simulate, not bench and not simulate
    rules = (
        (
            simulate != (fitted.file is not None),
            "give either SOURCE (a trace, or a bench's folder) or --simulate",
        ),
        (
            measured or fitted.estimator_file is None,
            "--estimator needs the measurements of a bench",
        ),
        ((simulate and bench) or not simulated.faults, "--fault is for --simulate --bench alone"),
        (trace or fitted.terms is None, "--terms is for a recorded trace alone"),
        (trace or not opens(), "--open is for a recorded trace alone: nothing else makes a page"),
    )
    if broken := [words for holds, words in rules if not holds]:
        raise click.UsageError("; ".join(broken))


def _identify_bench(
    design: Design, source: Path, estimator: GripEstimator | None, fidelity: str, target: Path
) -> int:
    with recorded(bench_report.CALIBRATION, target) as (folder, show):
        found = bench_report.calibrated_finger(design, source, estimator, fidelity, show)
        show("writing", 1.0)
        bench_report.write_calibration(found, folder)
    return say_result(lambda: plain(found.data), lambda: _show_fit(found, target))


def _simulate_bench(design: Design, simulated: Simulated, fidelity: str, target: Path) -> int:
    faults, seed = simulated.faults or _DRAWN, simulated.seed
    with recorded(bench_report.MEASURED, target) as (folder, show):
        show("simulating the bench")
        bench = simulated_bench(design, faults, seed, fidelity)
        bench_report.write_measured(bench, folder)
    names = [phase.name for phase in bench.phases]
    about = {"faults": list(faults), "seed": seed, "lean_deg": bench.lean_deg}
    words = f"{target}: {TABLE} and {len(names)} traces; drawn.toml is the finger drawn"
    return say_done({"design": design.design.name, **about, "traces": names}, words)


def _show_fit(found: bench_report.CalibratedFinger, folder: Path) -> None:
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
    print_table(f"{data.design}: values from its bench ({data.fidelity})", headings, rows)
    before, after = data.fit.before_microstrain, data.fit.after_microstrain
    words = f"{before:.3g} microstrain from the design, {after:.3g} when fitted (RMS)"
    click.echo(f"readings off by {words}")
    for warning in data.warnings:
        say(f"warning: {warning}")
    written = f"{folder / bench_report.FITTED_FILE} is this finger"
    if found.estimator is not None:
        written = f"{folder / bench_report.ESTIMATOR_FILE} is for it; {written}"
    click.echo(f"delay: {data.delay_samples} samples; {written}")


def _identify_trace(
    design: Design, source: Path, terms: int | None, fidelity: str, target: Path
) -> int:
    gripped_case(design, fidelity)
    trace = read_trace(source, len(gage_array(design)))
    with recorded(trace_report.IDENTIFICATION, target) as (folder, show):
        found = identified(design, trace, str(source), fidelity, terms, show)
        show("writing", 1.0)
        data = write_identification(found, source.name, folder)
    page = target / trace_report.PAGE_FILE
    return say_result(lambda: plain(data), lambda: _show_values(data, target), page)


def _simulate_trace(design: Design, seed: int, fidelity: str, target: Path) -> int:
    with recorded(SIMULATED, target) as (folder, show):
        show("simulating a trace")
        made = simulated_trace(design, seed, fidelity)
        (folder / TRACE_FILE).write_text(made.trace.to_csv(), encoding="utf-8")
        (folder / TRUTH_FILE).write_text(json_text(made.truth), encoding="utf-8")
    words = f"{target / TRACE_FILE}: {len(made.trace)} rows; truth.json is what was drawn"
    return say_done({"design": design.design.name, "seed": seed, "rows": len(made.trace)}, words)


def _show_values(data: trace_report.IdentificationData, folder: Path) -> None:
    table = value_table(data, gages=False)
    print_table(f"{data.design}: values from {data.trace}", table.columns, table.rows)
    for warning in data.warnings:
        click.echo(f"warning: {warning}")
    if data.next_motion is not None:
        of = data.next_motion.of.replace("_", " ")
        click.echo(f"next: {data.next_motion.words}; it would narrow {of} most")
    page, file = folder / trace_report.PAGE_FILE, folder / trace_report.DESIGN_FILE
    click.echo(f"{page}; the design with these values: {file}")
