"""``fingerdesign bench fidelity``: are the ladder's estimates right, and at what price?"""

import json
from dataclasses import asdict
from importlib import resources
from pathlib import Path

import numpy as np

import fingerdesign.analysis.fidelity
from fingerdesign.analysis.fidelity.estimate import of_most
from fingerdesign.analysis.fidelity.ladder import GROWTH
from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.errors import FingerDesignError
from fingerdesign.records.base import json_text
from fingerdesign.runtime.files import write_whole
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Shown
from fingerdesign_bench.fidelity.chart import draw_fidelity
from fingerdesign_bench.fidelity.judge import PairResult, judge
from fingerdesign_bench.fidelity.pairs import Pair, pairs
from fingerdesign_bench.fidelity.run import plain, readings_from
from fingerdesign_bench.files import Record, apart, code_version, resumed
from fingerdesign_bench.machine import machine

REFERENCES = "fidelity_references.json"
HEADINGS = (
    *("pair", "depth", "plates", "target %", "chosen", "stated %", "true %"),
    *("within %", "plane strain %", "s"),
)


class ReferencesMissing(FingerDesignError):
    """The shipped references are not those of the pairs as they are made now."""


def measure_fidelity(folder: Path, report: Report, workers: int | None, again: bool) -> Shown:
    """Solve what ``folder`` does not hold yet, then judge.

    again: by references computed into ``folder`` (hours), not by the shipped ones. Raises
    ReferencesMissing where these are of other pairs.
    """
    begun, every, workers = machine(), pairs(), workers or 1
    truth = {} if again else references(every)  # before an hour's work
    rungs = solve_all("rungs", {pair.number: 0 for pair in every}, folder, report, workers)
    # Pairs, and the equations at scale 1 that their finest rung foretells.
    sizes = {
        each["pair"]: round(each["dofs"] * each["scale"] ** GROWTH)
        for each in rungs
        if each.get("dimension") == "3-D"
    }
    rungs += solve_all("finest", sizes, folder, report, workers)
    if again:
        text = json_text(solve_all("reference", sizes, folder, report, workers), 0)
        write_whole(folder / REFERENCES, text)
        truth = references(every, text)
    found = judge(every, rungs, truth)
    picture = draw_fidelity(found, folder / "fidelity.png")
    models = [
        [each.name, f"{each.seconds:.0f}", f"{100 * each.within:.1f}", f"{each.meets}"]
        for each in found.fixed
    ]
    return Shown(
        "Fidelity",
        found.checks(),
        begun,
        {
            "within": found.within,
            "seconds": found.seconds,
            "rival": asdict(found.rival),
            "fixed": [asdict(each) for each in found.fixed],
            "pairs": [_pair_record(each) for each in found.outcomes],
        },
        paths=[picture],
        tables=[
            ("The ladder, pair by pair", HEADINGS, [row(each) for each in found.outcomes]),
            ("One model for all", ["model", "s", "readings within %", "pairs"], models),
        ],
    )


def solve_all(
    kind: str, sizes: dict[int, int], folder: Path, report: Report, workers: int
) -> list[Record]:
    """Records of one kind of work on pairs by number; each pair in a process of its own."""
    version = code_version(fingerdesign.analysis.fidelity)
    tasks = {str(number): (kind, number, dofs) for number, dofs in sorted(sizes.items())}
    work = apart("fingerdesign_bench.fidelity.run:work")
    path = folder / f"{kind}.sqlite"
    found = resumed(path, version, tasks, work, report, lambda name, _: f"{kind}, {name}", workers)
    return [each for record in found.values() for each in record.get("records", ())]


def references(every: list[Pair], text: str | None = None) -> dict[int, Readings]:
    """References by pair, of ``text`` or the shipped ones.

    Raises ReferencesMissing where they are of other pairs.
    """
    if text is None:
        text = (resources.files("fingerdesign") / "data" / REFERENCES).read_text("utf-8")
    found = {each["pair"]: each for each in json.loads(text)}
    for pair in every:
        if found.get(pair.number, {}).get("digest") != pair.digest():
            raise ReferencesMissing(
                f"the shipped reference of {pair.name} is of another pair: make them again with "
                "`fingerdesign bench fidelity --references`"
            )
    return {number: readings_from(record["readings"]) for number, record in found.items()}


def row(each: PairResult) -> list[str]:
    """Cells under HEADINGS."""
    ladder, pair = each.ladder, each.pair
    estimate = ladder.estimate.worst if ladder.estimate else float("nan")
    return [
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
