"""``study-control``, ``study-unlike``, ``tune`` and ``replay``: controllers tried on one design."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import click

from fingerdesign.design.schema import Design
from fingerdesign.records.base import plain
from fingerdesign.records.folder import RecordFolder
from fingerdesign.records.statistics import Rms, Share
from fingerdesign.runtime.machine import usable_cores
from fingerdesign.trials.bench import ControlGrid, refuse
from fingerdesign.trials.page import answers
from fingerdesign.trials.record import ControlStudy, Foreseen, Summary
from fingerdesign.trials.tune import RECORD_FILE, TuningRecord
from fingerdesign.trials.unlike import UnlikeSummary
from fingerdesign_cli.inputs import estimator_for, read_case, recorded, refuse_foreign
from fingerdesign_cli.options import CONTROLLER_NAMES
from fingerdesign_cli.terminal import number, open_page, print_json, print_table

NONE = "–"  # in a cell of the study
Found = TypeVar("Found")


@dataclass(frozen=True)
class _Trial:
    """What the commands that try controllers are all given."""

    design_file: Path
    out: Path
    controllers: tuple[str, ...]
    seed: int
    estimator_file: Path | None
    workers: int | None
    fidelity: str
    quiet: bool
    as_json: bool

    @cached_property
    def design(self) -> Design:
        return read_case(self.design_file)[0]

    @property
    def target(self) -> Path:
        return self.out / self.design.design.name

    def run(
        self,
        kind: RecordFolder,
        work: Callable[..., Found],
        write: Callable[[Found, Path], None],
        *given: Any,
        **more: Any,
    ) -> Found:
        """What ``work`` finds, written by ``write``; it goes on where it stopped."""
        from fingerdesign.trials.run import journal_beside

        refuse_foreign(kind, self.target)
        more["estimator"] = estimator_for(self.design, self.estimator_file, self.fidelity)
        more |= {"workers": self.workers or usable_cores(), "fidelity": self.fidelity}
        journal = journal_beside(self.target.absolute())
        with recorded(kind, self.target, self.quiet, journal) as (folder, show):
            names = self.controllers or CONTROLLER_NAMES
            found = work(self.design, names, *given, journal, report=show, **more)
            show("writing", 1.0)
            write(found, folder)
        return found


# ``fingerdesign tune``: every controller tuned alike, on grips that are not those of the study.


def tune(noises: tuple[float, ...], **given: Any) -> int:
    """Tune the controllers of DESIGN, each by the same procedure and the same number of grips."""
    from fingerdesign.trials.tune import DESIGN_FILE, tune_controllers, write_tuning

    trial = _Trial(**given)
    kind = RecordFolder("tuning", RECORD_FILE, (RECORD_FILE, DESIGN_FILE))

    def write(record: TuningRecord, folder: Path) -> None:
        write_tuning(record, trial.design, folder)

    record = trial.run(kind, tune_controllers, write, noises=noises, seed=trial.seed)
    if trial.as_json:
        print_json(record.data())
    elif not trial.quiet:
        headings = ["controller", "success % (before)", "held %", "dropped", "crushed"]
        headings += ["not lifted", "peak (before)", "takes"]
        rows = [_row(name, found) for name, found in record.controllers.items()]
        print_table(f"{record.design}: tuned on {len(record.cells)} grips", headings, rows)
        click.echo("rates on other grips differ: judge the tuned design with study-control")
        click.echo(f"{record.seconds:.0f} s; tuned design: {trial.target / DESIGN_FILE}")
    return 0


def _row(name: str, found: dict[str, Any]) -> list[str]:
    best, default = found["best"], found["default"]
    takes = (f"{key.removeprefix('grip.')} {value:g}" for key, value in best["values"].items())
    return [
        name,
        f"{100 * best['success_rate']:.1f} ({100 * default['success_rate']:.1f})",
        f"{100 * best['held_rate']:.1f}",
        *(f"{best[key]}" for key in ("dropped", "crushed", "not_lifted")),
        f"{number(best['mean_peak_ratio'])} ({number(default['mean_peak_ratio'])})",
        ", ".join(takes),
    ]


def study_control(
    frictions: tuple[float, ...],
    masses: tuple[float, ...],
    noises: tuple[float, ...],
    quick: bool,
    no_tug: bool,
    **given: Any,
) -> int:
    """Judge controllers on DESIGN over friction, weight and gage noise; in plane strain."""
    from fingerdesign.trials.run import FOLDER, study_control, write_study

    trial = _Trial(**given)
    grid = ControlGrid.quick() if quick else ControlGrid()
    axes = {"frictions": frictions, "masses_g": masses, "noises": noises}
    changes: dict[str, Any] = {key: values for key, values in axes.items() if values}
    grid = replace(grid, **changes, seed=trial.seed, tug=None if no_tug else grid.tug)
    refuse(grid, ())
    found = trial.run(FOLDER, study_control, write_study, grid)
    if trial.as_json:
        print_json(plain(found.data))
    elif not trial.quiet:
        _show(found, trial.target)
    open_page(trial.target / "control.html")
    return 0


def study_unlike(faults: tuple[str, ...], plants: int, lifts: int, **given: Any) -> int:
    """Judge controllers on fingers that came out unlike DESIGN's model."""
    from fingerdesign.trials.unlike import FOLDER, chosen_faults, study_unlike, write_unlike

    trial = _Trial(**given)
    chosen = chosen_faults(faults)
    more = {"lifts": lifts, "seed": trial.seed}
    found = trial.run(FOLDER, study_unlike, write_unlike, chosen, plants, **more)
    if trial.as_json:
        print_json(plain(found.data))
    elif not trial.quiet:
        summaries = found.data.summaries
        rows = [[label, *map(_of_unlike, by.values())] for label, by in summaries.items()]
        title = f"{found.data.design}: success in % (95 %), margin; {plants} fingers a row"
        print_table(title, ["fault", *next(iter(summaries.values()))], rows)
        _show_unlike_foreseen(summaries)
        click.echo(f"every lift: {trial.target / 'unlike.csv'}")
    return 0


def _show_unlike_foreseen(summaries: Mapping[str, Mapping[str, UnlikeSummary]]) -> None:
    """What was said of slip before it came, a column each for those that say anything."""
    names = [
        name
        for name in next(iter(summaries.values()))
        if any(by[name].foreseen.false_alarms is not None for by in summaries.values())
    ]
    if names:
        rows = [
            [label, *("; ".join(_foreseen(by[name].foreseen)) for name in names)]
            for label, by in summaries.items()
        ]
        title = "complete slips warned of (95 %); lead, s; lifts with a false alarm, %; error, RMS"
        print_table(title, ["fault", *names], rows)


def _of_unlike(summary: UnlikeSummary) -> str:
    share, margin = summary.success, summary.safety_margin
    low, high = share.low or 0.0, share.high or 1.0
    words = f"{number(share.rate, 0, 100.0)} ({100 * low:.0f}–{100 * high:.0f})"
    return words if margin is None else f"{words}, {margin.median:.2f}"


def _show(found: ControlStudy, folder: Path) -> None:
    noise, data = found.trace_noise, found.data
    conditions, names = data["conditions"], [each["controller"] for each in data["controllers"]]
    summaries = {name: found.summary(name, noise) for name in names}
    grips = len(conditions["friction_coefficients"]) * len(conditions["object_masses_g"])
    print_table(
        f"{data['design']} at {noise:g} microstrain: grips: {grips}; success and held in %",
        ["controller", "success", "95 %", "held", "dropped", "crushed", "unlifted"],
        [_shares(name, reported) for name, reported in summaries.items()],
    )
    print_table(
        "medians; margin and peak: force over the least that holds",
        ["controller", "lifted", "margin", "peak", "least stick", "slip, mm", "steps"],
        [_medians(name, reported) for name, reported in summaries.items()],
    )
    _show_foreseen(found, noise)
    if conditions["tug"] is not None:
        rate = data["hardware"]["sample_rate_Hz"]
        assert isinstance(rate, float)
        print_table(
            f"tugged with {100 * conditions['tug']['share']:g} % of the weight: reactions in ms",
            ["controller", "held %", "answered", "median", "slowest"],
            [_answers(name, found.summary(name, tugged=True), rate) for name in names],
        )
    for each in answers(data):
        click.echo(f"{each.question} {each.answer}: {each.detail}")
    for warning in data["warnings"]:
        click.echo(f"mind: {warning}")
    click.echo(f"{data['seconds']['whole']:.0f} s; report: {folder / 'control.html'}")


def _shares(name: str, reported: Summary) -> list[str]:
    low, high = reported.success.low or 0.0, reported.success.high or 1.0
    return [
        name,
        number(reported.success.rate, 1, 100.0, NONE),
        f"{100 * low:.1f}–{100 * high:.1f}",
        number(reported.held.rate, 1, 100.0, NONE),
        f"{reported.dropped}" + (f", {reported.caught} caught" if reported.caught else ""),
        *(str(count) for count in (reported.crushed, reported.not_lifted)),
    ]


def _medians(name: str, reported: Summary) -> list[str]:
    spreads = (
        (reported.margin_at_lift, 2),
        (reported.peak_ratio, 2),
        (reported.minimum_stick_ratio, 2),
        (reported.slip_distance_mm, 3),
        (reported.steps, 0),
    )
    return [
        name,
        str(reported.grips - reported.not_lifted),
        *(number(None if s is None else s.median, digits, none=NONE) for s, digits in spreads),
    ]


def _show_foreseen(found: ControlStudy, noise: float) -> None:
    """What was said of slip before it came, by those that say anything."""
    rows = []
    for each in found.data["controllers"]:
        saw = found.summary(each["controller"], noise).foreseen
        if saw.false_alarms is not None or saw.stick_error is not None:
            rows.append([each["controller"], *_foreseen(saw)])
    if rows:
        title = "slip seen before it came (95 %); error of the stick ratio"
        headings = ["controller", "slips warned of", "lead, s", "falsely, %", "error, RMS"]
        print_table(title, headings, rows)


def _foreseen(saw: Foreseen) -> list[str]:
    warned, false, error = saw.warned, saw.falsely_alarmed, saw.stick_error
    return [
        NONE if warned is None else f"{warned.count} of {warned.of}{_brackets(warned, 100.0, 0)}",
        number(None if saw.lead_s is None else saw.lead_s.median, 2, none=NONE),
        NONE if false is None else f"{number(false.rate, 0, 100.0)}{_brackets(false, 100.0, 0)}",
        NONE if error is None else f"{error.value:.3f}{_brackets(error)}",
    ]


def _brackets(found: Share | Rms, factor: float = 1.0, digits: int = 2) -> str:
    """The interval."""
    if found.low is None or found.high is None:
        return ""
    return f" ({factor * found.low:.{digits}f}–{factor * found.high:.{digits}f})"


def _answers(name: str, reported: Summary, rate_hz: float) -> list[str]:
    reaction = reported.reaction_steps
    times = (None, None) if reaction is None else (reaction.median, reaction.most)
    return [
        name,
        number(reported.held.rate, 1, 100.0, NONE),
        f"{reported.answered.count} of {reported.answered.of}",
        *(number(each, 0, 1000.0 / rate_hz, NONE) for each in times),
    ]
