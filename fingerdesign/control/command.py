"""Commands of a controller, and the protocol of every controller."""

from dataclasses import dataclass
from typing import Protocol

from fingerdesign.control.signals import Calibration, Sample


@dataclass(frozen=True)
class Command:
    """The next move of the object, mm: ``dx`` toward +x, ``dy`` closing.

    hold: the rule has set dx to zero. area: the gage area (mm) behind it, None where none is known.
    unsure: the controller knows too little to trust what it does; None where it cannot judge that.
    stick_ratio: stick area over contact area, 0 to 1, as it believes it to be at the sample that
    this answers; None where it estimates none. warns: of a controller that reports no stick ratio,
    that slip is near; None where it never warns.
    """

    dx: float
    dy: float
    hold: bool
    area: float | None = None
    unsure: bool | None = None
    stick_ratio: float | None = None
    warns: bool | None = None


class Controller(Protocol):
    """Turns samples into commands; the same samples always give the same commands."""

    name: str

    def start(self, calibration: Calibration, sample: Sample) -> None:
        """Begin a grip at its preload, measured as ``sample``; forgets any grip before."""

    def command(self, sample: Sample) -> Command:
        """The next move, given what is measured now."""
