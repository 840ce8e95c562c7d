"""A case of the suite: what a TOML file of ``cases`` says, and how an answer is judged."""

import tomllib
from dataclasses import asdict, dataclass, field
from math import isfinite
from pathlib import Path
from typing import Any, Literal

from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem

FOLDER = Path(__file__).parent / "cases"
KINDS = ("analytic", "code", "experiment", "regression")
Verdict = Literal["met", "missed", "known miss", "changed"]


@dataclass(frozen=True)
class Case:
    """One number with a known answer.

    name: of its file. kind: of reference, one of KINDS. function, arguments: what computes it,
    MODULE.NAME of this folder; quantity: which of its values. uncertainty: of the reference itself;
    tolerance: the most that the answer may be off it; regression: our own answer when the file was
    written, within regression_tolerance (inf where meshes differ from run to run). Errors are
    relative to the reference, or absolute. at_least: only too little is an error. quick: one of
    ``--quick``. known_miss: why an answer is off by more than the tolerance.
    """

    name: str
    quantity: str
    title: str
    kind: str
    function: str
    source: str
    reference: float
    uncertainty: float
    tolerance: float
    regression: float
    regression_tolerance: float
    arguments: dict[str, Any] = field(default_factory=dict)
    absolute: bool = False
    at_least: bool = False
    quick: bool = False
    known_miss: str = ""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"{self.words}: kind is {self.kind!r}, not one of {', '.join(KINDS)}")
        if not 0.0 <= self.uncertainty <= self.tolerance:
            raise ValueError(f"{self.words}: uncertainty must be 0 to tolerance {self.tolerance:g}")
        if self.reference == 0.0 and not self.absolute:
            raise ValueError(f"{self.words}: no error is relative to a reference of 0")

    @property
    def words(self) -> str:
        """Title and quantity."""
        return f"{self.title}: {self.quantity}"

    @property
    def problem(self) -> str:
        """Function and arguments: cases with the same share one computation."""
        given = ", ".join(f"{key}={value!r}" for key, value in self.arguments.items())
        return f"{self.function}({given})"

    def error(self, value: float) -> float:
        """Off the reference, signed: relative, or absolute."""
        off = value - self.reference
        off = min(0.0, off) if self.at_least else off
        return off if self.absolute else off / abs(self.reference)

    def verdict(self, value: float) -> Verdict:
        """``changed``: within the tolerance, or a known miss, but not what it was."""
        near = abs(self.error(value)) <= self.tolerance
        if not near and not self.known_miss:
            return "missed"
        scale = 1.0 if self.absolute else abs(self.reference)
        if not abs(value - self.regression) <= self.regression_tolerance * scale:
            return "changed"
        return "met" if near else "known miss"


def load_cases(folder: Path = FOLDER) -> list[Case]:
    """Every number of every file, in the order of the files' names.

    A file says what its numbers have in common, and under ``values`` each quantity's own keys.
    Raises TypeError or ValueError for one that lacks a key, has an unknown one or a value that
    cannot be.
    """
    found = []
    for path in sorted(folder.glob("*.toml")):
        shared = tomllib.loads(path.read_text("utf-8"))
        values = shared.pop("values")
        found += [
            Case(name=path.stem, quantity=quantity, **{**shared, **own})
            for quantity, own in values.items()
        ]
    return found


@dataclass(frozen=True)
class Solution:
    """The answer of a function: its quantities, and a problem that others may solve."""

    values: dict[str, float]
    solved: tuple[ContactProblem, tuple[Step, ...]] | None = None


@dataclass(frozen=True)
class Outcome:
    """A case with its answer; value None where the problem failed, and why."""

    case: Case
    value: float | None
    failure: str = ""

    @property
    def verdict(self) -> Verdict:
        return "missed" if self.value is None else self.case.verdict(self.value)

    @property
    def error(self) -> float | None:
        return None if self.value is None else self.case.error(self.value)

    @property
    def fails(self) -> bool:
        return self.verdict in ("missed", "changed")

    def as_dict(self) -> dict[str, Any]:
        found: dict[str, Any] = {"value": self.value, "error": self.error, "verdict": self.verdict}
        tight = self.case.regression_tolerance
        found["regression_tolerance"] = tight if isfinite(tight) else None
        return {**asdict(self.case), **found, "failure": self.failure}
