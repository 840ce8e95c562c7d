"""Outcomes to compare, read from wherever they are: studies, lists of outcomes, analyses."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fingerdesign.errors import DesignError, Fault
from fingerdesign.result_folder import RESULT_FILE
from fingerdesign.sweep.compare_result import outcome_of_result
from fingerdesign.sweep.outcome import Outcome, OutcomeError, refuse_endless
from fingerdesign.sweep.study_facts import (
    Bound,
    StudyFacts,
    Wanted,
    known_metrics,
    read_constraints,
    read_objectives,
    usual_objectives,
)

OUTCOMES_FILE, STUDY_FILE = "outcomes.jsonl", "study.json"
DIGITS = 8  # of a digest, where nothing else tells designs apart
LEAST_ALIKE = 2


@dataclass(frozen=True)
class Comparison:
    """Outcomes, none twice, and the facts of the study or studies that they are of."""

    outcomes: tuple[Outcome, ...]
    facts: StudyFacts


@dataclass(frozen=True)
class _Source:
    place: Path
    outcomes: tuple[Outcome, ...]
    record: dict[str, Any] | None = None  # study.json

    @property
    def name(self) -> str:
        """The study's, or the folder's or file's."""
        return str((self.record or {}).get("name", self.place.name))


def read_comparison(
    paths: Sequence[Path],
    objectives: Sequence[Wanted] = (),
    name: str = "",
) -> Comparison:
    """The outcomes of all ``paths``, in their order.

    A path is a study's folder (outcomes.jsonl, study.json), a file of outcomes (a line each), a
    result of `analyse` (its folder or result.json), or a folder of any of these folders. Given
    ``objectives`` replace those of the studies. Raises DesignError with every path that is none of
    these, and for a line that is no whole outcome. Different outcomes of one name are renamed: by
    their source, else by scene or fidelity, else by digest.
    """
    sources: list[_Source] = []
    faults: list[DesignError] = []
    for path in paths:
        try:
            sources += _sources(path)
        except DesignError as error:
            faults.append(error)
    if faults:
        every = DesignError([fault for each in faults for fault in each.faults])
        every.args = ("\n".join(str(each) for each in faults),)
        raise every
    every_one = (outcome for source in sources for outcome in source.outcomes)
    outcomes = tuple({(each.digest, each.name): each for each in every_one}.values())
    outcomes = _told_apart(outcomes, sources)
    return Comparison(outcomes, _facts(sources, outcomes, objectives, name))


def read_outcomes(paths: Sequence[Path]) -> tuple[Outcome, ...]:
    """As :func:`read_comparison`, the outcomes alone."""
    return read_comparison(paths).outcomes


def facts_of(
    name: str,
    outcomes: Sequence[Outcome],
    objectives: Sequence[Wanted] = (),
    constraints: Sequence[Bound] = (),
    record: dict[str, str] | None = None,
    sources: Sequence[str] = (),
) -> StudyFacts:
    """Facts of outcomes; without ``objectives`` the usual ones, and the page says so."""
    metrics = known_metrics(outcomes)
    wanted = tuple(objectives) or tuple(usual_objectives(metrics, outcomes))
    return StudyFacts(
        name,
        wanted,
        tuple(constraints),
        metrics,
        not objectives,
        record or {},
        tuple(sources),
    )


def _told_apart(outcomes: Sequence[Outcome], sources: Sequence[_Source]) -> tuple[Outcome, ...]:
    """The outcomes; where a name stands for several, each with what tells it from the others."""
    place = {
        (each.digest, each.name): source.name for source in sources for each in source.outcomes
    }
    alike: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        alike.setdefault(outcome.name, []).append(outcome)
    names: dict[tuple[str, str], str] = {}
    for name, many in alike.items():
        if len(many) < LEAST_ALIKE:
            continue
        ways = (
            [place[each.digest, each.name] for each in many],
            [each.scene for each in many],
            [each.fidelity for each in many],
            [each.digest[:DIGITS] for each in many],
        )
        marks = next((way for way in ways if len(set(way)) == len(many)), ways[-1])
        for each, mark in zip(many, marks, strict=True):
            names[each.digest, name] = f"{name} ({mark})"
    return tuple(
        replace(each, name=names.get((each.digest, each.name), each.name)) for each in outcomes
    )


def _sources(path: Path) -> list[_Source]:
    if path.is_file():
        if path.name == RESULT_FILE:
            return [_Source(path, (outcome_of_result(path.parent),))]
        return [_Source(path, _lines(path))]
    found = _folder(path)
    if not found:
        inside = sorted(p for p in path.glob("*/") if not p.name.startswith("."))
        found = [source for place in inside for source in _folder(place)]
    if not found:
        bound = f"a folder with {OUTCOMES_FILE} or {RESULT_FILE}, or a file of outcomes"
        fault = Fault("RESULT", path, bound, "give what sweep, optimise or analyse got as --out")
        raise DesignError([fault])
    return found


def _folder(path: Path) -> list[_Source]:
    if (path / OUTCOMES_FILE).is_file():
        return [_Source(path, _lines(path / OUTCOMES_FILE), _record(path / STUDY_FILE))]
    if (path / RESULT_FILE).is_file():
        return [_Source(path, (outcome_of_result(path),))]
    return []


def _lines(path: Path) -> tuple[Outcome, ...]:
    found = []
    try:
        with path.open(encoding="utf-8", newline="\n") as stream:
            for number, line in enumerate(stream, 1):
                if line.strip():
                    found.append(_outcome(line, f"{path}, line {number}"))
    except (OSError, UnicodeDecodeError) as error:
        raise DesignError([Fault("RESULT", path, "a file of outcomes", str(error))]) from error
    return tuple(found)


def _outcome(line: str, source: str) -> Outcome:
    try:
        found = Outcome.from_json(line)
        found.to_json()  # what is infinite cannot be written again
        return found
    except (OutcomeError, ValueError) as error:
        bound, remedy = "an outcome as JSON", f"{error}; run the study again"
        raise DesignError([Fault("outcome", line[:60], bound, remedy)], source) from error


def _record(path: Path) -> dict[str, Any] | None:
    if not path.is_file():
        return None
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        refuse_endless(found)
    except (OSError, ValueError, OutcomeError, RecursionError) as error:
        fault = Fault("study", path.name, "the record of a study", f"{error}; run it again")
        raise DesignError([fault], str(path)) from error
    if not isinstance(found, dict):
        fault = Fault("study", path.name, "the record of a study", "run it again")
        raise DesignError([fault], str(path))
    return found


def _facts(
    sources: Sequence[_Source],
    outcomes: Sequence[Outcome],
    objectives: Sequence[Wanted],
    name: str,
) -> StudyFacts:
    """Those of the studies: objectives of the first that has any, constraints of all."""
    wanted, bounds = tuple(objectives), dict[str, Bound]()
    record: dict[str, str] = {}
    names = []
    for source in sources:
        told = source.record or {}
        names.append(source.name)
        where = str(source.place / STUDY_FILE)
        if not wanted and told.get("objectives"):
            wanted = read_objectives(told["objectives"], where)
        if told.get("constraints"):
            bounds |= {each.metric: each for each in read_constraints(told["constraints"], where)}
        prefix = f"{names[-1]}: " if len(sources) > 1 else ""
        record |= {f"{prefix}{key}": text for key, text in _texts(told)}
    several = f"{len(names)} sources" if len(names) > 1 else "".join(names)
    places = [str(source.place) for source in sources]
    heading = name or several
    return facts_of(heading, outcomes, wanted, tuple(bounds.values()), record, places)


def _texts(record: dict[str, Any]) -> list[tuple[str, str]]:
    """A record's facts as text, a table's one by one; without what stands elsewhere on the page."""
    skip = ("name", "objectives", "constraints", "versions", "schema_version")
    found = []
    for key, value in record.items():
        if key in skip or value is None or value in ({}, []):
            continue
        inner = value.items() if isinstance(value, dict) else [("", value)]
        found += [
            (f"{key}: {name}" if name else key, each if isinstance(each, str) else json.dumps(each))
            for name, each in inner
        ]
    return found
