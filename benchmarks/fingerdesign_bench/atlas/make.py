"""The atlas: each candidate judged in 3-D and its molds made; data/atlas.json takes what passes."""

import subprocess
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.checks.load import with_values
from fingerdesign.design.grip import Grip
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.layout.fitting import gage_fit
from fingerdesign.mesh.make import mesher_name
from fingerdesign.mold.make import make_mold
from fingerdesign.mold.plan.refusals import MoldRefused
from fingerdesign.pipeline import run
from fingerdesign.records.base import json_text
from fingerdesign.records.verdict import Verdict
from fingerdesign.runtime.files import write_whole
from fingerdesign.runtime.progress import Report
from fingerdesign.search.passing.atlas import (
    FILE,
    PROCESSES,
    Atlas,
    Entry,
    MoldOutcome,
    finger_of,
    source_of,
)
from fingerdesign_bench.check import Shown

CANDIDATES = Path(__file__).with_name("candidates.toml")
Candidate = tuple[str, dict[str, Any]]  # A shipped design, and the keys that differ.


def candidates() -> dict[str, Candidate]:
    """The candidates by name."""
    found = tomllib.loads(CANDIDATES.read_text("utf-8"))
    return {name: (each["design"], each.get("values", {})) for name, each in found.items()}


def measure_atlas(report: Report, only: Sequence[str] = ()) -> Shown:
    """Judge candidates, and write the atlas after each; of those not in ``only`` the entries stay.

    DesignError where a name of ``only`` is none. The result fails where a candidate does not pass.
    """
    known = candidates()
    if unknown := [name for name in only if name not in known]:
        from fingerdesign.runtime.registry import unknown_name

        raise DesignError([unknown_name(name, "--only", tuple(known)) for name in unknown])
    old = {each.name: each for each in _written()}
    entries = {name: old[name] for name in known if name in old and only and name not in only}
    molds: dict[str, dict[str, MoldOutcome]] = {}
    commit, notes = _commit(), []
    for name in only or known:
        entry = entry_of(name, *known[name], molds, commit, partial(_named, report, name))
        failing = [each for each in entry.verdicts if each.status != "pass"]
        notes += [f"{name}: {each.name} {each.number}, {each.target}" for each in failing]
        if not failing:
            entries[name] = entry
        ordered = tuple(entries[each] for each in known if each in entries)
        write_whole(FILE, json_text(TypeAdapter(Atlas).dump_python(Atlas(1, ordered), mode="json")))
    rows = [[each.name, each.words, *map(_mold_cell, each.molds.values())] for each in ordered]
    return Shown(
        record={"entries": list(entries), "not_taken": notes},
        tables=[("Atlas", ("finger", "verified for", *PROCESSES), rows)],
        notes=notes,
        after=[str(FILE)],
        fails=bool(notes),
    )


def _named(report: Report, name: str, words: str) -> None:
    report(f"{name}: {words}")


def entry_of(
    name: str,
    design: str,
    values: dict[str, Any],
    molds: dict[str, dict[str, MoldOutcome]],
    commit: str,
    report: Report = lambda message: None,
) -> Entry:
    """Judge one candidate; ``molds``: of earlier ones, since the hand does not change a mold."""
    finger = finger_of(design, values)
    key = finger.model_copy(update={"grip": Grip()}).model_dump_json()
    if key not in molds:
        molds[key] = dict(_molds(finger, report))
    report("analysing in 3-D")
    fit = gage_fit(finger)
    if fit is None or fit.found is None:
        raise DesignError([], f"{name}: no gage fits its plates")
    return Entry(
        name=name,
        design=design,
        values={key: _plain(value) for key, value in values.items()},
        digest=finger.digest(),
        commit=commit,
        mesher=mesher_name(finger),
        gages=source_of(fit.found),
        gage=fit.found.name,
        masses_g=finger.grip.masses_g,
        friction_coefficients=finger.grip.friction_coefficients,
        verdicts=verdicts_of(finger),
        molds=molds[key],  # type: ignore[arg-type]
    )


def verdicts_of(finger: Design) -> tuple[Verdict, ...]:
    """What the analysis in 3-D on the design's own mesh finds."""
    analysis = run(Case(finger, fields=False, remedies=False))
    return verdict_view(analysis.result).verdicts


def _molds(finger: Design, report: Report) -> Iterator[tuple[str, MoldOutcome]]:
    for process in PROCESSES:
        report(f"mold, {process}")
        yield process, mold_of(with_values(finger, {"mold.process": process}))


def mold_of(finger: Design) -> MoldOutcome:
    """The outcome of a finger's mold; its files are thrown away."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            found = make_mold(finger, folder)
    except MoldRefused as refused:
        reasons = tuple(f"{each.key} = {each.value}: {each.bound}" for each in refused.faults)
        return MoldOutcome("refused", reasons=reasons)
    sensor = found["sensor"]
    why = [found["failure"]] if found["failure"] else []
    return MoldOutcome(
        status=found["status"],
        passed=sum(check["ok"] for check in found["checks"]),
        checks=len(found["checks"]),
        reading_error=sensor["reading_error"],
        ready=sensor["ready"] and found["status"] == "ok",
        reasons=(*why, *sensor["reasons"]),
    )


def _written() -> tuple[Entry, ...]:
    if not FILE.is_file():
        return ()
    found: Atlas = TypeAdapter(Atlas).validate_json(FILE.read_text("utf-8"))
    return found.entries


def _plain(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _mold_cell(outcome: MoldOutcome) -> str:
    if outcome.status == "refused":
        return "refused"
    error = "" if outcome.reading_error is None else f", {outcome.reading_error:.0%}"
    return f"{outcome.passed}/{outcome.checks}{error}"


def _commit() -> str:
    """The commit of the tree, with "+" where files differ from it."""

    def git(*words: str) -> str:
        home = Path(__file__).parent
        done = subprocess.run(["git", *words], cwd=home, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    changed = git("status", "--porcelain", "--untracked-files=no")
    others = [line for line in changed.splitlines() if not line.endswith(FILE.name)]
    return git("rev-parse", "--short=12", "HEAD") + "+" * bool(others)
