"""The atlas: each candidate judged in 3-D and its molds made; data/atlas.json takes what passes."""

import subprocess
import tempfile
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.checks.load import with_values
from fingerdesign.design.grip import Grip
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.fitting import gage_fit
from fingerdesign.mesh.make import mesher_name
from fingerdesign.mold.make import make_mold
from fingerdesign.mold.plan.refusals import MoldRefused
from fingerdesign.pipeline import run
from fingerdesign.records.base import json_text
from fingerdesign.records.verdict import Verdict
from fingerdesign.runtime.files import write_whole
from fingerdesign.runtime.progress import Report
from fingerdesign.runtime.registry import unknown_name
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


def measure_atlas(
    _folder: Path, report: Report, only: Sequence[str] = (), mesher: str = "auto"
) -> Shown:
    """Judge candidates, then make their molds; the atlas is written after each step.

    only: of other candidates the entries stay, and their molds serve fingers of the same shape.
    mesher: in place of the designs' own. DesignError where a name of ``only`` is none. The result
    fails where a candidate does not pass.
    """
    known = candidates()
    if unknown := [name for name in only if name not in known]:
        raise DesignError([unknown_name(name, "--only", tuple(known)) for name in unknown])
    old = {each.name: each for each in _written() if only and each.name in known}
    entries = {name: each for name, each in old.items() if name not in only}
    molds = {(_shape(each), k): mold for each in old.values() for k, mold in each.molds.items()}
    commit, notes = _commit(), []
    for name in only or known:
        report(f"{name}: analysing in 3-D")
        entry = entry_of(name, *known[name], mesher, commit)
        failing = [each for each in entry.verdicts if each.status != "pass"]
        notes += [f"{name}: {each.name} {each.number}, {each.target}" for each in failing]
        if not failing:
            entries[name] = entry
            _write(entries, known)
    for name, entry in entries.items():
        for process in PROCESSES:
            if process in entry.molds:
                continue
            report(f"{name}: mold, {process}")
            key, own = (_shape(entry), process), {"mold.process": process}
            if key not in molds:
                molds[key] = mold_of(with_values(entry.finger(), own))
            entries[name] = entry = replace(entry, molds={**entry.molds, process: molds[key]})
            _write(entries, known)
    rows = [
        [name, each.words, *map(_mold_cell, each.molds.values())] for name, each in entries.items()
    ]
    return Shown(
        record={"entries": list(entries), "not_taken": notes},
        tables=[("Atlas", ("finger", "verified for", *PROCESSES), rows)],
        notes=notes,
        after=[str(FILE)],
        fails=bool(notes),
    )


def entry_of(
    name: str, design: str, values: dict[str, Any], mesher: str = "auto", commit: str = ""
) -> Entry:
    """Judge one candidate; its molds are not made yet."""
    finger = finger_of(design, values)
    judged = finger if mesher == "auto" else with_values(finger, {"mesh.mesher": mesher})
    fit = gage_fit(finger)
    if fit is None or fit.found is None:
        raise DesignError([Fault("gages", name, "gages that fit the plates", "name a mold.gage")])
    return Entry(
        name=name,
        design=design,
        values={key: _plain(value) for key, value in values.items()},
        digest=finger.digest(),
        commit=commit,
        mesher=mesher_name(judged),
        gages=source_of(fit.found),
        gage=fit.found.name,
        masses_g=finger.grip.masses_g,
        friction_coefficients=finger.grip.friction_coefficients,
        verdicts=verdicts_of(judged),
        molds={},
    )


def _shape(entry: Entry) -> str:
    """Everything that decides the mold: the design without its hand."""
    return entry.finger().model_copy(update={"grip": Grip()}).model_dump_json()


def _write(entries: Mapping[str, Entry], order: Iterable[str]) -> None:
    found = Atlas(1, tuple(entries[name] for name in order if name in entries))
    write_whole(FILE, json_text(TypeAdapter(Atlas).dump_python(found, mode="json")))


def verdicts_of(finger: Design) -> tuple[Verdict, ...]:
    """Verdicts of the analysis in 3-D on the design's own mesh."""
    analysis = run(Case(finger, fields=False, for_page=False))
    return verdict_view(analysis.result).verdicts


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
