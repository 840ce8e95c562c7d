"""The atlas: each candidate judged in 3-D and its molds made; data/atlas.json takes what passes."""

import subprocess
import tempfile
import tomllib
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


def measure_atlas(_folder: Path, report: Report) -> Shown:
    """Judge the candidates and make their molds; the atlas is written after each of them.

    Fingers of the same shape share their molds. Fails where a candidate does not pass.
    """
    entries: dict[str, Entry] = {}
    molds: dict[tuple[str, str], MoldOutcome] = {}
    commit, notes = _commit(), []
    for name, candidate in candidates().items():
        report(f"{name}: analysing in 3-D")
        entry = entry_of(name, *candidate, commit)
        failing = [each for each in entry.verdicts if each.status != "pass"]
        notes += [f"{name}: {each.name} {each.number}, {each.target}" for each in failing]
        if failing:
            continue
        for process in PROCESSES:
            report(f"{name}: mold, {process}")
            key, own = (_shape(entry), process), {"mold.process": process}
            if key not in molds:
                molds[key] = mold_of(with_values(entry.finger(), own))
            entry.molds[process] = molds[key]
        entries[name] = entry
        found = Atlas(1, tuple(entries.values()))
        write_whole(FILE, json_text(TypeAdapter(Atlas).dump_python(found, mode="json")))
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


def entry_of(name: str, design: str, values: dict[str, Any], commit: str) -> Entry:
    """Judge one candidate; its molds are not made yet."""
    finger = finger_of(design, values)
    fit = gage_fit(finger)
    if fit is None or fit.found is None:
        raise DesignError([Fault("gages", name, "gages that fit the plates", "name a mold.gage")])
    judged = run(Case(finger, fields=False, for_page=False))  # in 3-D, on the design's own mesh
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
        verdicts=verdict_view(judged.result).verdicts,
        molds={},
    )


def _shape(entry: Entry) -> str:
    """Everything that decides the mold: the design without its hand."""
    return entry.finger().model_copy(update={"grip": Grip()}).model_dump_json()


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
