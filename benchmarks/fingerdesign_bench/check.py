"""A measured number and its target."""

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Check:
    """``measured`` must be at most ``target`` (errors, ratios, seconds)."""

    name: str
    target: float
    measured: float
    unit: str = ""

    @property
    def holds(self) -> bool:
        return bool(self.measured <= self.target)

    def row(self) -> list[str]:
        unit = f" {self.unit}" if self.unit else ""
        verdict = "holds" if self.holds else "FALLS SHORT"
        return [self.name, f"{self.target:g}{unit}", f"{plain(self.measured)}{unit}", verdict]

    def as_dict(self) -> dict[str, Any]:
        return {**asdict(self), "holds": self.holds}


def plain(value: float) -> str:
    """Three digits, without an exponent from a thousandth up to a million."""
    return f"{float(f'{value:.3g}'):g}"
