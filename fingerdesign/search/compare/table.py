"""The comparison page's tables: every design, every failure; as text, before any script runs."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from fingerdesign.errors import shown
from fingerdesign.records.outcome import Outcome
from fingerdesign.report.table import value_text
from fingerdesign.search.compare.recommend import Recommendation, StudyFacts
from fingerdesign.search.study.values import is_number

NONE = "–"
DIGITS = 4  # significant, of a column's largest value
MOST_DECIMALS = 6
DIGEST_SHOWN = 12  # characters
FIRST_COLUMNS = 14  # shown at first; the rest is a tick away
STANDINGS = ("recommended", "front", "feasible", "fails verdicts", "not feasible")
_MARKS = [f"{mark} {name}" for name, mark in zip(STANDINGS, "★◆○△×", strict=True)]
_PLAIN = ("N", "mm", "MPa", "ml", "MB", "g", "s")
_UNITS = {"_N_per_mm": "N/mm", "_deg": "°", **{f"_{unit}": unit for unit in _PLAIN}}


@dataclass(frozen=True)
class Column:
    """A column of the table: the place of its value in a design's data, and its heading.

    path: keys into the design's data on the page; help: the heading's explanation; scale: what of
    its values is good, and what poor.
    """

    path: tuple[str, ...]
    title: str
    unit: str = ""
    numeric: bool = True
    goal: Literal["min", "max"] | None = None
    objective: bool = False
    help: str = ""
    scale: str = ""

    @property
    def heading(self) -> str:
        """Title and unit."""
        return f"{self.title} ({self.unit})" if self.unit else self.title


@dataclass(frozen=True)
class DesignTable:
    """Columns; a row (number, standing's place, texts) an analysed outcome, best standing first.

    first: numbers of the columns that are shown at first.
    """

    columns: tuple[Column, ...]
    rows: tuple[tuple[int, int, tuple[str, ...]], ...]

    @property
    def first(self) -> list[int]:
        """The first of them, and every objective."""
        return [k for k, each in enumerate(self.columns) if k < FIRST_COLUMNS or each.objective]

    def places(self, kind: str) -> list[int]:
        """Numbers of the columns that are "values", "metrics" or another part of a design."""
        return [k for k, each in enumerate(self.columns) if each.path[0] == kind]


def design_table(
    outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation
) -> DesignTable:
    """A row a design that was analysed; first what was varied, objectives, other metrics."""
    good = [number for number, outcome in enumerate(outcomes) if outcome.status == "ok"]
    ranks = {number: STANDINGS.index(standing(number, found)) for number in good}
    good.sort(key=lambda number: ranks[number])
    columns = [
        column
        for column in _columns(outcomes, facts)
        if column.path[0] not in ("scene", "fidelity")
        or len({getattr(outcomes[number], column.path[0]) for number in good}) > 1
    ]
    texts = [
        _texts([value_at(outcomes[number], column.path) for number in good], column)
        for column in columns
    ]
    rows = tuple(
        (number, ranks[number], (_MARKS[ranks[number]], *(column[place] for column in texts)))
        for place, number in enumerate(good)
    )
    return DesignTable(tuple(columns), rows)


def standing(number: int, found: Recommendation) -> str:
    if number == found.chosen:
        return "recommended"
    if number in found.front:
        return "front"
    if number in found.failing:
        return "fails verdicts"
    return "feasible" if number in found.feasible else "not feasible"


def value_at(outcome: Outcome, path: tuple[str, ...]) -> Any:
    """The value of a column in an outcome; None where it has none."""
    first, *rest = path
    found = getattr(outcome, first)
    if not rest:
        return found
    return found.get(rest[0]) if isinstance(found, dict) else getattr(found, rest[0])


def name_and_unit(name: str, unit: str = "") -> tuple[str, str]:
    """Words and unit of a metric's name.

    >>> name_and_unit("peak_force_N"), name_and_unit("core_seconds", "s")
    (('peak force', 'N'), ('core seconds', ''))
    """
    for ending, known in _UNITS.items():
        if name.endswith(ending):
            return shown(name.removesuffix(ending).replace("_", " ")), unit or known
    if name.endswith("_seconds"):
        unit = ""  # the title has it already
    return shown(name.replace("_", " ")), unit


def key_words(key: str) -> tuple[str, str]:
    """Words and unit of a design's key; shares of two keys as they are.

    >>> key_words("materials.bronze.youngs_modulus_MPa"), key_words("plates.angle_deg")
    (('bronze youngs modulus', 'MPa'), ('plates angle', '°'))
    """
    if "/" in key:
        return shown(key), ""
    title, unit = name_and_unit(key.rpartition(".")[2])
    table = shown(" ".join(key.split(".")[-2:-1]).replace("_", " "))
    return f"{table} {title}".strip(), unit


def _columns(outcomes: Sequence[Outcome], facts: StudyFacts) -> list[Column]:
    found = [Column((name,), name, numeric=False) for name in ("scene", "fidelity")]
    for key in dict.fromkeys(key for outcome in outcomes for key in outcome.values):
        given = [o.values[key] for o in outcomes if o.values.get(key) is not None]
        numeric = bool(given) and all(map(is_number, given))
        found.append(Column(("values", key), *key_words(key), numeric, help=shown(key)))
    found += _metric_columns(facts)
    named = {metric.name for metric in facts.metrics}
    errors = {"plane_strain_error": "plane-strain error", "mesh_error": "mesh error"}
    for name, title in errors.items():
        if name not in named:
            found.append(Column(("validity", name), title, "share", True, "min"))
    if "core_seconds" not in named:
        found.append(Column(("seconds",), "time", "s"))
    found.append(Column(("digest",), "digest", numeric=False))
    return found


def _metric_columns(facts: StudyFacts) -> Iterator[Column]:
    """A column a metric: objectives in their order, then the others."""
    goals = {each.metric: each.goal for each in facts.objectives}
    place = {name: number for number, name in enumerate(["failed_verdicts", *goals])}
    for metric in sorted(facts.metrics, key=lambda each: place.get(each.name, len(place))):
        title, unit = name_and_unit(metric.name, metric.unit)
        goal = goals.get(metric.name, metric.better)
        objective = metric.name in goals
        path = ("metrics", metric.name)
        scale = metric.scale if goal == metric.better else ""
        yield Column(path, title, unit, True, goal, objective, shown(metric.words), scale)


def _texts(values: Sequence[Any], column: Column) -> list[str]:
    if not column.numeric:
        most = DIGEST_SHOWN if column.path[0] == "digest" else None
        return [NONE if value is None else shown(value_text(value))[:most] for value in values]
    numbers = [value for value in values if is_number(value)]
    decimals = 0
    if any(number != int(number) for number in numbers):
        largest = max(abs(number) for number in numbers)
        decimals = min(MOST_DECIMALS, max(0, DIGITS - 1 - math.floor(math.log10(largest))))
    return [f"{value:.{decimals}f}" if is_number(value) else NONE for value in values]
