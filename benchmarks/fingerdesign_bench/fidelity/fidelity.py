"""``fingerdesign bench fidelity``: are the ladder's estimates right, and at what price?

Thirty seeded pairs of a finger and a scene, each with a tolerance. Every rung of every pair is
solved once; the ladder then climbs on these records, and each single rung is judged as "the one
model for all". Errors are against much finer models in space, shipped with the program.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.analysis.fidelity.estimate import goal_errors, of_most
from fingerdesign.analysis.fidelity.ladder import GROWTH, Ladder, Solve, climb
from fingerdesign.analysis.fidelity.models import Model
from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.arrays import Array
from fingerdesign.errors import FingerDesignError
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Check
from fingerdesign_bench.fidelity.pairs import Pair, pairs
from fingerdesign_bench.fidelity.run import (
    REFERENCES,
    Recorded,
    model_key,
    plain,
    readings_from,
    recorded,
    run,
)
from fingerdesign_bench.files import write_json
from fingerdesign_bench.lines import Record, read_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design


# The ladder against one model for all: its price, what holds, and whether it knows its error.

_MARKS = {0.01: "o", 0.02: "s", 0.05: "^", 0.1: "D"}
_COLOURS = {"plane strain": "#d2560a", "3-D": "#0b6fb0"}


def draw_fidelity(found: FidelityBench, path: Path) -> None:
    """Left: seconds over all pairs against readings that hold; right: stated and true errors."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.5, 4.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    _prices(left, found)
    _estimates(right, found)
    for axes in (left, right):
        axes.grid(alpha=0.25)
    figure.savefig(path, dpi=130)


def _prices(axes: Axes, found: FidelityBench) -> None:
    for dimension in ("plane strain", "3-D"):
        mine = [each for each in found.fixed if each.name.startswith(dimension)]
        axes.plot(
            [each.seconds for each in mine],
            [100 * each.within for each in mine],
            marker="o" if dimension == "3-D" else "s",
            color=_COLOURS[dimension],
            label=f"one model for all, {dimension}",
        )
        for number, each in enumerate(mine):
            flat = dimension != "3-D"
            axes.annotate(
                f"{each.name.split(', ')[1]}: {each.meets}/{each.solved}",
                (each.seconds, 100 * each.within),
                xytext=(0, 12 if flat and number % 2 else -15) if flat else (7, -12),
                textcoords="offset points",
                ha="center" if flat else "left",
                fontsize=7,
            )
    axes.plot(
        found.seconds, 100 * found.within, "*", color="#0a8f6b", markersize=16, label="the ladder"
    )
    axes.axhline(95.0, color="#6c6f73", linewidth=1.0, linestyle=":")
    axes.margins(x=0.13)
    axes.set(
        xscale="log",
        xlabel="seconds over all pairs (labels: sizes, and pairs whose tolerance they meet)",
        ylabel="readings within the tolerance, %",
    )
    axes.legend(fontsize=8, loc="lower right")
    axes.set_title(
        f"The ladder takes 1/{1 / found.seconds_share:.1f} of {found.rival.name}",
        loc="left",
        fontsize=10,
    )


def _estimates(axes: Axes, found: FidelityBench) -> None:
    for tolerance, mark in _MARKS.items():
        for dimension, colour in _COLOURS.items():
            mine = [
                each
                for each in found.outcomes
                if each.pair.tolerance == tolerance
                and each.ladder.chosen.model.dimension == dimension
                and each.ladder.estimate is not None
            ]
            if mine:
                axes.scatter(
                    [100 * each.ladder.estimate.worst for each in mine if each.ladder.estimate],
                    [max(100 * of_most(each.true_errors), 1e-2) for each in mine],
                    marker=mark,
                    color=colour,
                    label=f"{100 * tolerance:g} % tolerance, {dimension}",
                )
    ends = (0.05, 20.0)
    axes.plot(ends, ends, color="#6c6f73", linewidth=1.0, linestyle=":")
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="error that the ladder states, % (worst quantity)",
        ylabel="true error of 95 % of the readings, %",
    )
    axes.legend(fontsize=7, loc="upper left")
    axes.set_title("Estimated and true error", loc="left", fontsize=10)


SHARE_TARGET, SAVING_TARGET = 0.95, 3.0
_PRESCRIBED = ("normal_force", "tangential_force")  # where forces are given


class ReferencesMissing(FingerDesignError):
    """The shipped references are not those of the pairs as they are made now."""


@dataclass(frozen=True)
class PairResult:
    """One pair: what the ladder chose, its estimated error, and what the error is.

    true_errors: of each reading that the scene does not prescribe; section_error: of the finest
    plane strain, of 95 % of its readings, NaN where there is none.
    """

    pair: Pair
    ladder: Ladder
    true_errors: Array
    section_error: float

    @property
    def within(self) -> float:
        """The share of readings whose true error is under the tolerance."""
        return float((self.true_errors <= self.pair.tolerance).mean())

    @property
    def section_used(self) -> bool:
        """Whether plane strain was chosen."""
        return self.ladder.chosen.model.dimension == "plane strain"


@dataclass(frozen=True)
class Fixed:
    """One rung for all pairs: its cost, and on how many pairs it meets the tolerance."""

    name: str
    seconds: float
    within: float
    meets: int
    solved: int


@dataclass
class FidelityBench:
    """What ``bench fidelity`` found."""

    outcomes: list[PairResult]
    fixed: list[Fixed]
    machine: dict[str, Any] = field(default_factory=dict)

    @property
    def within(self) -> float:
        """The share of all readings of all pairs under their tolerance."""
        every = [each.true_errors <= each.pair.tolerance for each in self.outcomes]
        return float(np.concatenate(every).mean())

    @property
    def seconds(self) -> float:
        """What the ladder cost over all pairs, failed rungs and judges included."""
        return sum(each.ladder.seconds for each in self.outcomes)

    @property
    def cheapest(self) -> Fixed | None:
        """The cheapest single model that meets the tolerance on every pair; None if none does."""
        enough = [each for each in self.fixed if each.meets == len(self.outcomes)]
        return min(enough, key=lambda each: each.seconds, default=None)

    @property
    def rival(self) -> Fixed:
        """``cheapest``, or where no single model does, the one that does on most pairs."""
        return self.cheapest or max(self.fixed, key=lambda each: (each.meets, -each.seconds))

    @property
    def missed(self) -> int:
        """Pairs where plane strain would do by a margin of a half, and was not used."""
        return sum(
            each.section_error <= 0.5 * each.pair.tolerance and not each.section_used
            for each in self.outcomes
        )

    def checks(self) -> list[Check]:
        """List the numbers and their targets."""
        short = 1.0 - self.within
        return [
            Check("readings over the tolerance", 1.0 - SHARE_TARGET, short),
            Check("1 / saving over one model for all", 1.0 / SAVING_TARGET, self.seconds_share),
            Check("plane strain would do by half the tolerance, and was not used", 0, self.missed),
            Check("plane strain used where it does not do", 0, self.wrong),
        ]

    @property
    def seconds_share(self) -> float:
        """The ladder's seconds over those of the one model for all."""
        return self.seconds / self.rival.seconds

    @property
    def wrong(self) -> int:
        """Pairs where plane strain was chosen and fewer than SHARE_TARGET of the readings hold."""
        return sum(each.section_used and each.within < SHARE_TARGET for each in self.outcomes)


def measure_fidelity(
    folder: Path, report: Report = lambda message: None, workers: int = 1, again: bool = False
) -> FidelityBench:
    """Solve the rungs that ``folder`` does not hold yet (rungs.jsonl), then judge.

    again: by references computed into ``folder``, not by the shipped ones. Raises ReferencesMissing
    where these are of other pairs.
    """
    from fingerdesign_bench.machine import machine

    every = pairs()
    if not again:
        references(every)  # before an hour's work
    path, beyond = folder / "rungs.jsonl", folder / "finest.jsonl"
    run("rungs", [(pair.number, 0) for pair in every], path, workers, report)
    run("finest", _sizes(path), beyond, workers, report)
    made = make_references(folder, report, workers) if again else None
    truth = references(every, made.read_text(encoding="utf-8") if made else None)
    return judge(every, [*read_lines(path), *read_lines(beyond)], truth, machine())


def _sizes(rungs: Path) -> list[tuple[int, int]]:
    """Pairs, and the equations at scale 1 that their finest rung foretells."""
    found = {
        each["pair"]: round(each["dofs"] * each["scale"] ** GROWTH)
        for each in read_lines(rungs)
        if each.get("dimension") == "3-D"
    }
    return sorted(found.items())


def make_references(folder: Path, report: Report, workers: int = 1) -> Path:
    """Compute the references again (an hour), into ``folder``; needs its rungs.jsonl."""
    path = folder / "references.jsonl"
    run("reference", _sizes(folder / "rungs.jsonl"), path, workers, report)
    found = folder / REFERENCES
    found.write_text(json.dumps(read_lines(path), allow_nan=False) + "\n", encoding="utf-8")
    return found


def references(every: list[Pair], text: str | None = None) -> dict[int, Readings]:
    """References by pair, of ``text`` or the shipped ones.

    Raises ReferencesMissing where they are of other pairs.
    """
    if text is None:
        shipped = resources.files("fingerdesign") / "data" / REFERENCES
        if not shipped.is_file():
            raise ReferencesMissing(
                "no references are shipped yet: compute them with --references (hours on two cores)"
            )
        text = shipped.read_text("utf-8")
    found = {each["pair"]: each for each in json.loads(text)}
    for pair in every:
        if found.get(pair.number, {}).get("digest") != pair.digest():
            raise ReferencesMissing(
                f"the shipped reference of {pair.name} is of another pair: make them again with "
                "`fingerdesign bench fidelity --references`"
            )
    return {number: readings_from(record["readings"]) for number, record in found.items()}


def judge(
    every: list[Pair],
    records: list[Record],
    truth: dict[int, Readings],
    machine: dict[str, Any] | None = None,
) -> FidelityBench:
    """Climb each pair's ladder on its records; compare with the references and with fixed rungs."""
    solved: dict[int, list[tuple[Record, Recorded]]] = {pair.number: [] for pair in every}
    for record in records:
        if record["pair"] in solved and "failure" not in record:
            pair = every[record["pair"]]
            solved[pair.number].append((record, recorded(pair, record)))
    outcomes = []
    for pair in every:
        by_key = {record["key"]: answer for record, answer in solved[pair.number]}
        scales = [
            float(record["scale"])
            for record, _ in solved[pair.number]
            if record["dimension"] == "3-D" and not record.get("beyond")
        ]
        ladder = climb(
            pair.design,
            pair.scene,
            pair.tolerance,
            _from(by_key),
            most_dofs=np.inf,
            scales=scales,
        )
        flat = [answer for record, answer in solved[pair.number] if record["dimension"] != "3-D"]
        section = of_most(true_errors(pair, flat[-1].readings, truth)) if flat else float("nan")
        found = true_errors(pair, ladder.chosen.readings, truth)
        outcomes.append(PairResult(pair, ladder, found, section))
    return FidelityBench(outcomes, fixed_models(every, solved, truth), machine or {})


def _from(records: dict[str, Recorded]) -> Solve:
    """A solver that looks its answers up."""

    def solver(design: Design, scene: Scene, model: Model) -> Recorded:
        return records[model_key(model)]

    return solver


def fixed_models(
    every: list[Pair],
    solved: dict[int, list[tuple[Record, Recorded]]],
    truth: dict[int, Readings],
) -> list[Fixed]:
    """Each rung as the one model for all pairs; where a pair's ladder ends before it, its last."""
    names = dict.fromkeys(
        (record["dimension"], record["scale"]) for rungs in solved.values() for record, _ in rungs
    )
    found = []
    for dimension, scale in names:
        seconds, right, readings, meets, count = 0.0, 0, 0, 0, 0
        for pair in every:
            own = [
                answer
                for record, answer in solved[pair.number]
                if record["dimension"] == dimension and record["scale"] >= scale
            ]
            if not own:
                continue
            off = true_errors(pair, own[-1].readings, truth) <= pair.tolerance
            seconds += own[-1].total
            right, readings, count = right + int(off.sum()), readings + off.size, count + 1
            meets += bool(off.mean() >= SHARE_TARGET)
        found.append(
            Fixed(f"{dimension}, x {scale:g}", seconds, right / max(readings, 1), meets, count)
        )
    return found


def true_errors(pair: Pair, found: Readings, truth: dict[int, Readings]) -> Array:
    """Errors of all readings that the scene does not prescribe, in one row."""
    off = goal_errors(found, truth[pair.number])
    given = _PRESCRIBED if pair.control == "force" else ()
    return np.concatenate([each for name, each in off.items() if name not in given])


def rows(found: FidelityBench) -> list[list[str]]:
    """A table's rows: one a pair."""
    table = []
    for each in found.outcomes:
        ladder, pair = each.ladder, each.pair
        estimate = ladder.estimate.worst if ladder.estimate else float("nan")
        table.append(
            [
                pair.name,
                f"{pair.design.body.depth_mm:.0f}",
                f"{pair.design.plates.number}",
                f"{100 * pair.tolerance:g}",
                ladder.chosen.model.name,
                f"{100 * estimate:.2g}",
                f"{100 * of_most(each.true_errors):.2g}",
                f"{100 * each.within:.0f}",
                f"{100 * each.section_error:.2g}",
                f"{ladder.seconds:.1f}",
            ]
        )
    return table


def write_fidelity(found: FidelityBench, folder: Path) -> list[Path]:
    """fidelity.json and fidelity.png."""
    record = {
        "machine": found.machine,
        "checks": [check.as_dict() for check in found.checks()],
        "within": found.within,
        "seconds": found.seconds,
        "rival": vars(found.rival),
        "fixed": [vars(each) for each in found.fixed],
        "pairs": [_pair_record(each) for each in found.outcomes],
    }
    path, picture = write_json(folder / "fidelity.json", record), folder / "fidelity.png"
    draw_fidelity(found, picture)
    return [path, picture]


def _pair_record(each: PairResult) -> Record:
    ladder = each.ladder
    return {
        "pair": each.pair.number,
        "finger": each.pair.finger,
        "control": each.pair.control,
        "tolerance": each.pair.tolerance,
        "reached": ladder.reached,
        "chosen": ladder.chosen.model.name,
        "dimension": ladder.chosen.model.dimension,
        "estimate": ladder.estimate.by_quantity if ladder.estimate else None,
        "true_error": of_most(each.true_errors),
        "within": each.within,
        "section_error": None if np.isnan(each.section_error) else each.section_error,
        "seconds": ladder.seconds,
        "tried": [
            {"name": one.name, "seconds": one.seconds, "why": one.why} for one in ladder.tried
        ],
        "readings": plain(ladder.chosen.readings),
    }
