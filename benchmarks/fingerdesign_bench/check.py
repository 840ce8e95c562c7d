"""What a bench has found: numbers with their targets, and all that is printed and written."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from fingerdesign.records.base import json_text, write_csv
from fingerdesign.runtime.files import write_whole

# A title, headings and rows of cells.
Table = tuple[str, Sequence[str], Sequence[Sequence[str]]]


@dataclass(frozen=True)
class Check:
    """``measured`` must be at most ``target`` (errors, ratios, seconds)."""

    name: str
    target: float
    measured: float
    unit: str = ""

    @property
    def holds(self) -> bool:
        """True where the target is met."""
        return bool(self.measured <= self.target)

    def row(self) -> list[str]:
        """Cells: name, target, measured, verdict."""
        unit = f" {self.unit}" if self.unit else ""
        verdict = "holds" if self.holds else "FALLS SHORT"
        return [self.name, f"{self.target:g}{unit}", f"{plain(self.measured)}{unit}", verdict]

    def as_dict(self) -> dict[str, Any]:
        """Values by name, and whether the target is met."""
        return {**asdict(self), "holds": self.holds}


@dataclass(frozen=True)
class Shown:
    """The result of a subcommand, as it is printed and written.

    machine: as it was when measuring began. record: more of NAME.json than machine and checks;
    rows: of NAME.csv, all with the same keys; paths: files that are written already.
    tables and notes (lines) are printed before the checks, ``after`` (lines) follows the files.
    listed: printed by ``--json`` instead of the checks. fails: for another reason than a check.
    """

    title: str = ""
    checks: Sequence[Check] = ()
    machine: Mapping[str, Any] = field(default_factory=dict)
    record: Mapping[str, Any] = field(default_factory=dict)
    rows: Sequence[Mapping[str, Any]] = ()
    paths: Sequence[Path] = ()
    tables: Sequence[Table] = ()
    notes: Sequence[str] = ()
    after: Sequence[str] = ()
    listed: object = None
    fails: bool = False

    @property
    def code(self) -> int:
        """Exit code: 1 where it fails or a value misses its target."""
        return 0 if not self.fails and all(check.holds for check in self.checks) else 1

    def write(self, folder: Path, name: str) -> list[Path]:
        """Write NAME.json, and NAME.csv where there are rows; return all files of the result."""
        folder.mkdir(parents=True, exist_ok=True)
        checks = {"checks": [check.as_dict() for check in self.checks]} if self.checks else {}
        content = {"machine": dict(self.machine), **checks, **self.record}
        made = [write_whole(folder / f"{name}.json", json_text(content, 1))]
        if self.rows:
            made.insert(0, folder / f"{name}.csv")
            write_csv(made[0], self.rows[0], [row.values() for row in self.rows])
        return [*made, *self.paths]


def plain(value: float) -> str:
    """Three digits, without an exponent from a thousandth up to a million."""
    return f"{float(f'{value:.3g}'):g}"
