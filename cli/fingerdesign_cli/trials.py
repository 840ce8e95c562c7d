"""``fingerdesign study``: controllers judged on one design, tuned before it on request."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import click
from click.core import ParameterSource

from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import plain
from fingerdesign.records.statistics import Share
from fingerdesign.records.verdict import SIGNS
from fingerdesign.runtime.machine import usable_cores
from fingerdesign.runtime.registry import code_allowed
from fingerdesign.trials import gripbench, lerobot
from fingerdesign.trials.findings import findings
from fingerdesign.trials.grid import SEALED_SEED, ControlGrid, Perturbed, refuse
from fingerdesign.trials.program import REFERENCE as PROGRAM
from fingerdesign.trials.program import program
from fingerdesign.trials.record import ControlStudy, TuningData
from fingerdesign.trials.recorded import page, sets
from fingerdesign.trials.study import (
    FOLDER,
    StudyOptions,
    journal_beside,
    run_lifts,
    run_study,
    write_study,
)
from fingerdesign.trials.summary import Summary
from fingerdesign.trials.tables import NONE, at_noise
from fingerdesign.trials.tuning import DESIGN_FILE, TuningSetting
from fingerdesign_cli import terminal
from fingerdesign_cli.inputs import all_sound, estimator_for, read_case, recorded, refuse_foreign
from fingerdesign_cli.options import CONTROLLER_NAMES, Options


@dataclass(frozen=True)
class Hands(Options):
    """The controllers to judge, all without a name; tune: each is tuned first; estimator_file: the
    regulator's; program: a command line that is one more."""

    controllers: tuple[str, ...]
    estimator_file: Path | None
    tune: bool
    program: str | None

    @property
    def names(self) -> tuple[str, ...]:
        """Those given; without any all that are shipped."""
        given = (*self.controllers, *([PROGRAM] if self.program is not None else []))
        return given or CONTROLLER_NAMES


@dataclass(frozen=True)
class Axes(Options):
    """The axes of a study; empty: as usual. faults, plants and lifts: of perturbed fingers."""

    frictions: tuple[float, ...]
    masses: tuple[float, ...]
    noises: tuple[float, ...]
    seed: int
    sealed: bool
    quick: bool
    no_tug: bool
    perturbed: bool
    faults: tuple[str, ...]
    plants: int | None
    lifts: int | None

    def grid(self) -> ControlGrid:
        """The grid; DesignError where some options belong to perturbed fingers alone, and for two
        seeds."""
        if self.sealed and self.seed:
            remedy = "leave one of both out"
            raise DesignError([Fault("--seed", self.seed, "given without --sealed", remedy)])
        seed = SEALED_SEED if self.sealed else self.seed
        given = {"frictions": self.frictions, "masses_g": self.masses, "noises": self.noises}
        changes: dict[str, Any] = {key: values for key, values in given.items() if values}
        if self.perturbed:
            usual = Perturbed(plants=4) if self.quick else Perturbed()
            plants, lifts = self.plants or usual.plants, self.lifts or usual.lifts
            own = Perturbed(self.faults, plants, lifts)
            return ControlGrid.of_perturbed(own, seed, **changes)
        self._refuse_perturbed()
        grid = ControlGrid.quick() if self.quick else ControlGrid()
        tug = None if self.no_tug else grid.tug
        return replace(grid, **changes, seed=seed, tug=tug)

    def _refuse_perturbed(self) -> None:
        needs = {"--fault": self.faults, "--plants": self.plants, "--lifts": self.lifts}
        bound, remedy = "given with --perturbed alone", "add --perturbed, or leave it out"
        shown = {k: v if isinstance(v, int) else " ".join(v) for k, v in needs.items() if v}
        if wrong := [Fault(key, value, bound, remedy) for key, value in shown.items()]:
            raise DesignError(wrong)


@dataclass(frozen=True)
class Instead(Options):
    """Work instead of a grid: judge the held-out set or recordings, write a data set."""

    held_out: str | None
    to: tuple[str, Path] | None
    recorded: Path | None


def study(
    design_file: Path | None,
    out: Path,
    hands: Hands,
    workers: int | None,
    fidelity: Any,
    axes: Axes,
    instead: Instead,
) -> int:
    """Judge controllers on DESIGN over friction, weight and noise, on perturbed fingers, or our
    detectors on recordings."""
    held_out, to = instead.held_out, instead.to
    if (folder := instead.recorded) is not None:
        why = "--recorded takes no other options"
        _refuse_axes(why, axes, hands, fidelity, ["workers"] * (workers is not None))
        if {design_file, held_out, to} != {None}:
            raise click.UsageError("--recorded judges no design: leave out DESIGN and other work")
        return _recorded(folder, out / sets.NAME)
    if design_file is None:
        raise click.UsageError("Missing argument 'DESIGN'.")
    cores = workers or usable_cores()
    with ExitStack() as stack:
        if hands.program is not None:
            stack.enter_context(program(hands.program))
            stack.enter_context(code_allowed(PROGRAM))
        if str(design_file) == gripbench.NAME:
            _refuse_axes("gripbench is a fixed set", axes, hands, fidelity)
            if to is not None:
                raise click.UsageError("gripbench only judges: --to needs a design")
            return _gripbench(out / gripbench.NAME, hands, cores, held_out)
        if held_out is not None:
            raise click.UsageError("--held-out is for `fingerdesign study gripbench` alone")
        if to is not None:
            return _lifts(design_file, to[1], hands, cores, fidelity, axes)
        return _study(design_file, out, hands, cores, fidelity, axes)


def _refuse_axes(
    why: str, axes: Axes, hands: Hands, fidelity: str, more: Sequence[str] | None = None
) -> None:
    """UsageError for an option that would change the set; more: where no hand is judged, others."""
    given = [key for key, value in vars(axes).items() if value]
    if more is not None:
        chosen = (hands.controllers, hands.program, hands.estimator_file)
        names = ("controller", "program", "estimator")
        given += [*(key for key, value in zip(names, chosen, strict=True) if value), *more]
    given += ["tune"] * hands.tune + ["fidelity"] * (fidelity != "plane-strain")
    if given:
        raise click.UsageError(f"{why}: leave out {', '.join(given)}")


def _recorded(folder: Path, target: Path) -> int:
    began = perf_counter()
    with recorded(sets.FOLDER, target) as (place, show):
        show("reading and judging recordings", 0.0)
        data = sets.judge_recorded(folder)
        page.write_recorded(data, place, perf_counter() - began)
    report = target / sets.PAGE
    return terminal.say_result(lambda: plain(data), lambda: _show_recorded(data, report), report)


def _show_recorded(data: sets.RecordedData, report: Path) -> None:
    for each in page.tables(data):
        terminal.print_table(each.caption, each.columns, each.rows, terminal.WIDTH)
    for found in page.verdicts(data):
        terminal.say_marked(
            found.sign, f"{found.name}: {found.number}, {found.target}, {found.count}"
        )
    for words in page.unread(data):
        terminal.say_marked(SIGNS["warning"], f"not read: {words}")
    click.echo(f"report: {report}")


def _journal(target: Path, hands: Hands) -> Path:
    """The journal of the grips for a folder; begun again where a program is judged, whose file may
    have changed."""
    journal = journal_beside(target.absolute())
    if hands.program is not None:
        journal.unlink(missing_ok=True)
    return journal


def _gripbench(target: Path, hands: Hands, workers: int, held_out: str | None) -> int:
    grid, design = gripbench.benchmark_grid(held_out), gripbench.benchmark_design()
    journal = _journal(target, hands)
    options = StudyOptions(estimator_for(design, hands.estimator_file, "plane-strain"), workers)
    with recorded(gripbench.FOLDER, target, journal) as (folder, show):
        found = run_study(design, hands.names, grid, journal, replace(options, report=show))
        card = gripbench.scorecard(found, hands.names, held_out is not None)
        gripbench.write_scorecard(card, folder)
    return terminal.say_result(lambda: plain(card), lambda: _show_card(card, target))


def _show_card(card: gripbench.Scorecard, folder: Path) -> None:
    rows = []
    for each in card["scores"]:
        success, margin = each["success"], each["margin"]
        median = NONE if margin is None else f"{margin.median:.2f}"
        cells = [_rate(success), _interval(success), median, f"{each['dropped']}"]
        rows.append([_named(each["controller"]), *cells])
    grips = card["scores"][0]["grips"]
    title = f"GripBench {card['version']}, {card['set']}: grips each: {grips}; success in %"
    terminal.print_table(title, ["controller", "success", "95 %", "margin", "dropped"], rows)
    click.echo(f"{card['seconds']:.0f} s; scorecard: {folder / gripbench.RECORD}")


def _lifts(
    design_file: Path, target: Path, hands: Hands, workers: int, fidelity: Any, axes: Axes
) -> int:
    if hands.tune:
        raise click.UsageError("--to lerobot takes the controllers as they are: leave out --tune")
    if click.get_current_context().get_parameter_source("out") is not ParameterSource.DEFAULT:
        raise click.UsageError("--to lerobot DIR writes into DIR alone: leave out --out")
    design, _ = read_case(design_file)
    estimator = estimator_for(design, hands.estimator_file, fidelity, hands.names)
    options = StudyOptions(estimator, workers, fidelity)
    grid, journal = axes.grid(), _journal(target, hands)
    with recorded(lerobot.FOLDER, target, journal, "--to") as (folder, show):
        options = replace(options, report=show)
        info = run_lifts(design, hands.names, grid, folder, journal, options)
    about = {name: info[f"total_{name}"] for name in ("episodes", "frames")}
    about["left_out"] = info["left_out"]
    words = f"{target}: {about['episodes']} lifts, {about['frames']} frames"
    words += f"; {info['left_out']} lifts failed and are left out" if info["left_out"] else ""
    return terminal.say_done({"design": design.design.name, **about}, words)


def _study(
    design_file: Path, out: Path, hands: Hands, workers: int, fidelity: Any, axes: Axes
) -> int:
    design, _ = read_case(design_file)
    target = out / design.design.name
    grid = axes.grid()
    all_sound(partial(refuse, grid, hands.names), partial(refuse_foreign, FOLDER, target))
    setting = TuningSetting(axes.noises) if axes.noises else TuningSetting()
    estimator = estimator_for(design, hands.estimator_file, fidelity, hands.names)
    options = StudyOptions(estimator, workers, fidelity, tuning=setting if hands.tune else None)
    journal = _journal(target, hands)
    with recorded(FOLDER, target, journal) as (folder, show):
        found = run_study(design, hands.names, grid, journal, replace(options, report=show))
        show("writing", 1.0)
        write_study(found, folder)
    page = target / "control.html"
    return terminal.say_result(lambda: plain(found.data), lambda: _show(found, target), page)


def _show(found: ControlStudy, folder: Path) -> None:
    """One table, the findings, and where the page with all other tables is."""
    noise, data = found.trace_noise, found.data
    rows = [(_named(each["controller"]), at_noise(each, noise)) for each in data["controllers"]]
    terminal.print_table(
        f"{data['design']} at {noise:g} microstrain: grips each: {rows[0][1].grips}; "
        "success and held in %",
        ["controller", "success", "95 %", "held", "dropped", "crushed", "not lifted"],
        [_shares(name, own) for name, own in rows],
    )
    if data["conditions"]["perturbed"] is not None:
        _show_faults(found)
    if data["tuning"] is not None:
        _show_tuning(data["tuning"], folder)
    for item in findings(data):
        terminal.say_marked(item.verdict.sign, f"{item.question} {item.detail}")
    for warning in data["warnings"]:
        terminal.say_marked(SIGNS["warning"], warning)
    click.echo(f"{data['seconds']['whole']:.0f} s; report: {folder / 'control.html'}")


def _show_tuning(tuning: TuningData, folder: Path) -> None:
    rows = []
    for name, found in tuning["controllers"].items():
        best, default = found["best"], found["default"]
        rates = (f"{100 * each['success_rate']:.1f}" for each in (default, best))
        rows.append([name, *rates, str(best["dropped"]), str(best["crushed"])])
    title = f"tuned on {len(tuning['cells'])} other grips; values: {folder / DESIGN_FILE}"
    terminal.print_table(title, ["controller", "before %", "tuned %", "dropped", "crushed"], rows)


def _show_faults(found: ControlStudy) -> None:
    perturbed = found.data["conditions"]["perturbed"]
    assert perturbed is not None
    every = found.data["controllers"]
    rows = []
    for number_, label in enumerate(perturbed["faults"]):
        cells = []
        for each in every:
            own = each["by_fault"][number_]
            words = f"{terminal.number(own.success.rate, 0, 100.0)} ({_interval(own.success, 0)})"
            margin = own.safety_margin
            cells.append(words if margin is None else f"{words}, {margin.median:.2f}")
        rows.append([label, *cells])
    title = f"success in % (95 % over fingers), margin; fingers a row: {perturbed['plants']}"
    terminal.print_table(title, ["fault", *(_named(each["controller"]) for each in every)], rows)


def _named(controller: str) -> str:
    """A controller's name; of the one that ``--program`` runs: "program"."""
    return "program" if controller == PROGRAM else controller


def _rate(share: Share) -> str:
    return terminal.number(share.rate, 1, 100.0, NONE)


def _interval(share: Share, digits: int = 1) -> str:
    """The 95 % interval of a share, in %."""
    ends = (share.low or 0.0, share.high or 1.0)
    return "–".join(f"{100 * each:.{digits}f}" for each in ends)


def _shares(name: str, own: Summary) -> list[str]:
    shares = [_rate(own.success), _interval(own.success), _rate(own.held)]
    dropped = f"{own.dropped}" + (f", {own.caught} caught" if own.caught else "")
    return [name, *shares, dropped, f"{own.crushed}", f"{own.not_lifted}"]
