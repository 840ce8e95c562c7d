"""Outcomes to compare, read from wherever they are: studies, lists of outcomes, analyses."""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fingerdesign.design.keys import leaves
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.outcome import Outcome, OutcomeError, Validity, refuse_endless
from fingerdesign.records.result import Result
from fingerdesign.records.result_files import RESULT_FILE, read_result
from fingerdesign.runtime.columns import ColumnError
from fingerdesign.runtime.files import whole_text, why_unread
from fingerdesign.search.compare.from_result import SCENE, outcome_of_result, tables_of
from fingerdesign.search.compare.large import COLUMNS_FILE, best_of
from fingerdesign.search.compare.recommend import (
    Bound,
    Objective,
    StudyFacts,
    known_metrics,
    requested,
    usual_objectives,
)
from fingerdesign.search.run.evaluate import Job
from fingerdesign.search.study.file import Cost
from fingerdesign.search.study.values import is_number, split_share, value_in

Work = Callable[[Sequence[Job]], Sequence[Outcome]]
OUTCOMES_FILE, STUDY_FILE = "outcomes.jsonl", "study.json"
_MOST_LINE = 10_000_000  # characters: an outcome with its traces takes a hundredth of that
_FINGER = ("body.", "plates.", "gages.", "materials.")
_NO_VALUES = (".content", ".source")  # of a file, of a material: in words elsewhere
_SHARD = re.compile(r"(.+)\.\d+-of-\d+")  # the folder of a study's shard
DIGITS = 8  # of a digest, where nothing else tells designs apart


@dataclass(frozen=True)
class Comparison:
    """Outcomes, none twice, and the facts of the study or studies that they are of."""

    outcomes: tuple[Outcome, ...]
    facts: StudyFacts


@dataclass(frozen=True)
class _Source:
    place: Path
    outcomes: tuple[Outcome, ...]
    record: dict[str, Any] = field(default_factory=dict)  # study.json
    result: Path | None = None  # the folder of the analysis that it is
    columns: Path | None = None  # the file of the large study that it is

    @property
    def name(self) -> str:
        """The study's, or the folder's or file's."""
        return str(self.record.get("name", self.place.name))

    def lacks(self, metrics: set[str]) -> bool:
        """True for a good analysis without one of the metrics."""
        own = self.outcomes[0]
        return own.status == "ok" and bool(metrics - own.metrics.keys())


def read_comparison(
    paths: Sequence[Path], objectives: Sequence[Objective] = (), work: Work | None = None
) -> Comparison:
    """The outcomes of all ``paths``, in their order; shards of one study in that of their places.

    A path is a study's folder (outcomes.jsonl, study.json), of a large study (outcomes.sqlite) the
    best (see large.py), a file of outcomes (a line each), a
    result of `analyse` (its folder or result.json), or a folder of any of these folders. Given
    ``objectives`` replace those of the studies; a place given twice is read once. Raises
    DesignError with every path that is none of these, for shards of different studies, and for a
    line that is no whole outcome.
    Different outcomes of one name are renamed: by their source, else by scene or fidelity, else by
    digest. With ``work``, which makes outcomes of jobs, results of `analyse` get the metrics that
    they lack and others have or ask for.
    """
    sources: list[_Source] = []
    faults: list[DesignError] = []
    for path in paths:
        try:
            sources += _sources(path)
        except DesignError as error:
            faults.append(error)
    if faults:
        raise DesignError.together(faults)
    sources = _with_best(_arranged(sources), objectives)
    if work is not None:
        sources = _completed(sources, objectives, work)
    every_one = (outcome for source in sources for outcome in source.outcomes)
    outcomes = tuple({(each.digest, each.name): each for each in every_one}.values())
    outcomes = _with_varied(_distinct(outcomes, sources))
    return Comparison(outcomes, _facts(sources, outcomes, objectives))


def _arranged(sources: Sequence[_Source]) -> list[_Source]:
    """Each source once, shards of one study together and by place: the order of paths changes
    nothing. DesignError for shards in one folder of different studies."""
    once, shards = dict[Path, _Source](), dict[Path, tuple[str, str]]()
    for each in sources:
        once.setdefault(each.place.resolve(), each)
    faults = list[Fault]()
    order = [str(each.record.get("digest", each.place)) for each in once.values()]
    for place, study in zip(once, order, strict=True):
        if shard := _SHARD.fullmatch(place.name):
            first, other = shards.setdefault(place.with_name(shard[1]), (place.name, study))
            if other != study:
                bound, remedy = f"of the study of {first}", "run it again, or move it elsewhere"
                faults.append(Fault("RESULT", place.name, bound, remedy))
    if faults:
        raise DesignError(faults)
    ranked = zip(map(order.index, order), once.values(), strict=True)
    return [each for _, each in sorted(ranked, key=lambda pair: (pair[0], pair[1].place))]


def _with_best(sources: Sequence[_Source], objectives: Sequence[Objective]) -> list[_Source]:
    """The sources, those in columns with the best outcomes of all of them together."""
    large = {n: each.columns for n, each in enumerate(sources) if each.columns is not None}
    if not large:
        return list(sources)
    try:
        best = best_of(list(large.values()), *_goals(sources, objectives))
    except ColumnError as error:
        fault = Fault("RESULT", sources[next(iter(large))].place, "a study in columns", str(error))
        raise DesignError([fault]) from error
    filled = dict(zip(large, best, strict=True))
    return [replace(s, outcomes=filled.get(n, s.outcomes)) for n, s in enumerate(sources)]


def _completed(
    sources: Sequence[_Source], objectives: Sequence[Objective], work: Work
) -> list[_Source]:
    """The sources, those of analyses with the metrics that they lack, computed as a study
    computes them; what they have is unchanged."""
    every = [outcome for source in sources for outcome in source.outcomes]
    needed = {"stick_error", "cost"} | {each.metric for each in objectives}
    needed = needed.union(*(outcome.metrics for outcome in every))
    known = (source.record["cost"] for source in sources if "cost" in source.record)
    prices: dict[str, Any] = next(known, {})
    jobs = {
        place: _job(source.outcomes[0], read_result(source.result), prices)
        for place, source in enumerate(sources)
        if source.result is not None and source.lacks(needed)
    }
    completed = list(sources)
    for place, made in zip(jobs, work(list(jobs.values())) if jobs else (), strict=True):
        own = sources[place]
        completed[place] = replace(own, outcomes=(_with_missing(own.outcomes[0], made),))
    return completed


def _job(outcome: Outcome, result: Result, prices: dict[str, Any]) -> Job:
    """Return the job that repeats the analysis, as a study would run it.

    Raises DesignError where it cannot be made, as where a file of the design is missing.
    """
    keys = {k: v for k, v in result.parameters.items() if k.startswith(SCENE)}
    alone = not (result.grips or result.slip_studies)  # the scene was given, not the grips
    source = f"{outcome.name}, which is to be completed"
    try:
        design = Design.model_validate(outcome.design)
        scene = Scene.model_validate(tables_of(keys)["scene"]) if alone else None
        cost = Cost.model_validate(prices)
    except (KeyError, ValidationError) as error:
        fault = Fault("RESULT", source, "a whole design", f"{error}; run analyse again"[:400])
        raise DesignError([fault]) from error
    return Job(outcome.name, design, cost, {}, scene, result.scene, result.fidelity)


def _with_missing(own: Outcome, made: Outcome) -> Outcome:
    """An outcome with the metrics and the validity that it lacks from another of its finger."""
    if made.failure is not None:
        return replace(own, warnings=(*own.warnings, f"not completed: {made.failure.sentence}"))
    validity = own.validity if own.validity != Validity() else made.validity
    lacking = made.metrics.keys() - own.metrics.keys()
    names = ", ".join(sorted(key for key in lacking if made.metrics[key] is not None))
    worked = f"{names} were computed with the mesh of a study's analyses"
    warnings = tuple(dict.fromkeys((*own.warnings, worked)))
    metrics = made.metrics | own.metrics
    return replace(own, metrics=metrics, validity=validity, warnings=warnings)


def facts_of(
    name: str,
    outcomes: Sequence[Outcome],
    objectives: Sequence[Objective] = (),
    constraints: Sequence[Bound] = (),
    record: dict[str, str] | None = None,
    sources: Sequence[str] = (),
) -> StudyFacts:
    """Facts of outcomes; without ``objectives`` the usual ones, and the page says so."""
    return StudyFacts(
        name,
        tuple(objectives) or tuple(usual_objectives(outcomes)),
        tuple(constraints),
        known_metrics(outcomes),
        not objectives,
        record or {},
        tuple(sources),
    )


def _distinct(outcomes: Sequence[Outcome], sources: Sequence[_Source]) -> tuple[Outcome, ...]:
    """The outcomes; where several have one name, each name with a mark that distinguishes it."""
    place = {(each.digest, each.name): source for source in sources for each in source.outcomes}
    alike: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        alike.setdefault(outcome.name, []).append(outcome)
    names: dict[tuple[str, str], str] = {}
    for name, many in alike.items():
        marks = _marks(many, [place[each.digest, name] for each in many])
        for each, mark in zip(many, marks, strict=True):
            names[each.digest, name] = f"{name} ({mark})" if len(many) > 1 else name
    return tuple(replace(each, name=names[each.digest, each.name]) for each in outcomes)


def _marks(many: Sequence[Outcome], sources: Sequence[_Source]) -> list[str]:
    """Marks that distinguish outcomes of one name: source, scene, fidelity, else the digest."""
    ways = (
        [each.name for each in sources],
        [str(each.place) for each in sources],
        [each.scene for each in many],
        [each.fidelity for each in many],
        [each.digest[:DIGITS] for each in many],
    )
    return next((way for way in ways if len(set(way)) == len(many)), ways[-1])


def _with_varied(outcomes: Sequence[Outcome]) -> tuple[Outcome, ...]:
    """The outcomes; where some are of no study, all with the values of every key that a study
    varies or in which their fingers differ, from the designs themselves. Where the fingers are
    alike, of every other key too: of the controller, the mesh."""
    if all(outcome.values or not outcome.design for outcome in outcomes):
        return tuple(outcomes)
    keys = dict.fromkeys(chain.from_iterable(outcome.values for outcome in outcomes))
    keys |= _varied([outcome.design for outcome in outcomes if outcome.design])

    def completed(outcome: Outcome) -> Outcome:
        found = {key: _value_at(outcome.design, key) for key in keys}
        return replace(outcome, values=found | outcome.values)

    return tuple(completed(each) if each.design else each for each in outcomes)


def _varied(designs: Sequence[dict[str, Any]]) -> dict[str, None]:
    """Keys of the finger in which designs differ; of any other where the fingers are alike."""
    flat = [_leaves(each) for each in designs]
    every = dict.fromkeys(chain.from_iterable(flat))
    varied = [key for key in every if len({each.get(key) for each in flat}) > 1]
    return dict.fromkeys([key for key in varied if key.startswith(_FINGER)] or varied)


def _leaves(design: dict[str, Any]) -> dict[str, bool | float | str]:
    """A design's dotted keys with one value each; files by their names, without their places."""
    return {
        key: Path(str(value)).name if key.endswith(".file") else value
        for key, value in leaves(design)
        if isinstance(value, bool | int | float | str)
        and not key.startswith("design.")
        and not key.endswith(_NO_VALUES)
    }


def _value_at(design: dict[str, Any], key: str) -> Any:
    """The value of a dotted key, of "a / b" the share of two keys; None where there is none."""
    part, whole = split_share(key)
    above = value_in(design, part)
    if not whole:
        return above if isinstance(above, bool | int | float | str) else None
    below = value_in(design, whole)
    return above / below if is_number(above) and is_number(below) and below else None


def _sources(path: Path) -> list[_Source]:
    if path.is_file() and path.name != RESULT_FILE and path.suffix != ".toml":
        return [_Source(path, _lines(path))]
    found, damaged = _folder(path), list[DesignError]()
    for place in () if found else sorted(path.glob("[!.]*/")):
        try:
            found += _folder(place)
        except DesignError as error:
            damaged.append(error)
    if damaged:
        raise DesignError.together(damaged)
    if not found:
        bound = f"a folder with {OUTCOMES_FILE} or {RESULT_FILE}, or a file of outcomes"
        fault = Fault("RESULT", path, bound, "give what sweep, optimise or analyse got as --out")
        raise DesignError([fault])
    return found


def _folder(path: Path) -> list[_Source]:
    if (path / OUTCOMES_FILE).is_file():
        return [_Source(path, _lines(path / OUTCOMES_FILE), _record(path / STUDY_FILE))]
    if (path / COLUMNS_FILE).is_file():
        return [_Source(path, (), _record(path / STUDY_FILE), columns=path / COLUMNS_FILE)]
    folder = path.parent if path.name == RESULT_FILE else path
    if (folder / RESULT_FILE).is_file():
        return [_Source(path, (outcome_of_result(folder),), result=folder)]
    return []


def _lines(path: Path) -> tuple[Outcome, ...]:
    found, line, where = [], "", ""
    try:
        with path.open(encoding="utf-8", newline="\n") as stream:
            for number, line in enumerate(iter(partial(stream.readline, _MOST_LINE), ""), 1):
                where = f"{path}, line {number}"
                if len(line) >= _MOST_LINE:
                    raise ValueError(f"a line of more than {_MOST_LINE // 10**6} MB")
                if line.strip():
                    found.append(Outcome.from_json(line))
                    found[-1].to_json()  # what is infinite cannot be written again
    except (OSError, UnicodeDecodeError) as error:
        fault = Fault("RESULT", path, "a file of outcomes", why_unread(error))
        raise DesignError([fault]) from error
    except (OutcomeError, ValueError) as error:
        fault = Fault("outcome", line[:60], "an outcome as JSON", f"{error}; run the study again")
        raise DesignError([fault], where) from error
    return tuple(found)


def _record(path: Path) -> dict[str, Any]:
    """The record study.json; empty where there is none."""
    if not path.is_file():
        return {}
    why = ""
    try:
        found = json.loads(whole_text(path))
        refuse_endless(found)
        if isinstance(found, dict):
            return found
    except (OSError, ValueError, OutcomeError, RecursionError) as error:
        why = f"{error}; "
    fault = Fault("study", path.name, "the record of a study", f"{why}run it again")
    raise DesignError([fault], str(path))


def _facts(
    sources: Sequence[_Source], outcomes: Sequence[Outcome], objectives: Sequence[Objective]
) -> StudyFacts:
    """The facts of the studies together."""
    record, many = dict[str, str](), len(sources) > 1
    for source in sources:
        prefix = f"{source.name}: " if many else ""
        record |= {f"{prefix}{key}": text for key, text in _texts(source.record)}
    several = f"{len(sources)} sources" if many else "".join(each.name for each in sources)
    places = [str(source.place) for source in sources]
    facts = facts_of(several, outcomes, *_goals(sources, objectives), record, places)
    best_of = sum(_counted(each.record) for each in sources if each.columns is not None)
    missing = tuple(filter(None, map(_missing, sources)))
    return replace(facts, best_of=best_of, missing=missing)


def _goals(
    sources: Sequence[_Source], objectives: Sequence[Objective]
) -> tuple[Sequence[Objective], list[Bound]]:
    """The objectives, by default those of the first study that has any; constraints of all."""
    bounds = dict[str, Bound]()
    for source in sources:
        own, found = requested(source.record, str(source.place / STUDY_FILE))
        objectives = objectives or own
        bounds |= {each.metric: each for each in found}
    return objectives, list(bounds.values())


def _counted(record: Mapping[str, Any]) -> int:
    """Outcomes that the record of a study counts; 0 where it does not."""
    counts = record.get("outcomes")
    every = counts.get("all", 0) if isinstance(counts, dict) else 0
    return every if isinstance(every, int) else 0


def _missing(source: _Source) -> str:
    """A sentence where a file of outcomes has not as many as the record beside it counts."""
    alone = source.place.name == OUTCOMES_FILE
    record = _record(source.place.with_name(STUDY_FILE)) if alone else source.record
    every, read = _counted(record), len(source.outcomes)
    if source.columns is not None or every in (0, read):
        return ""
    return f"{source.place} holds {read} of the {every} outcomes of its study: run it again"


def _texts(record: dict[str, Any]) -> list[tuple[str, str]]:
    """A record's facts as text, a table's one by one; without what is elsewhere on the page."""
    skip = ("name", "objectives", "constraints", "versions", "schema_version", "optimise")
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
