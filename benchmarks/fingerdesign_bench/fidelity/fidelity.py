"""``fingerdesign bench fidelity``: are the ladder's estimates right, and at what price?

Thirty seeded pairs of a finger and a scene, each with a tolerance. Every rung of every pair is
solved once; the ladder then climbs on these records, and each single rung is judged as "the one
model for all". Errors are against much finer models in space, shipped with the program.
"""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path

import numpy as np

from fingerdesign.analysis.fidelity.estimate import of_most
from fingerdesign.analysis.fidelity.ladder import GROWTH
from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.errors import FingerDesignError
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.fidelity.chart import draw_fidelity
from fingerdesign_bench.fidelity.judge import FidelityBench, PairResult, judge
from fingerdesign_bench.fidelity.pairs import Pair, pairs
from fingerdesign_bench.fidelity.run import (
    REFERENCES,
    plain,
    readings_from,
    run,
)
from fingerdesign_bench.files import Record, read_lines, write_json

HEADINGS = (
    *("pair", "depth", "plates", "target %", "chosen", "stated %", "true %"),
    *("within %", "plane strain %", "s"),
)


class ReferencesMissing(FingerDesignError):
    """The shipped references are not those of the pairs as they are made now."""


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


def rows(found: FidelityBench) -> list[list[str]]:
    """Cells under HEADINGS: a row a pair."""
    return [_row(each) for each in found.outcomes]


def _row(each: PairResult) -> list[str]:
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
