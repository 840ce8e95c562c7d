"""The record of a study of gages: observability.json, gages.csv, counts.csv, and their chart."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fingerdesign.records.base import csv_text, json_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.report.page import sentences
from fingerdesign.validate.gages.chart import chart_png

RECORD_FILE, GAGES_FILE, COUNTS_FILE = "observability.json", "gages.csv", "counts.csv"
CHART_FILE = "observability.png"
FOLDER = RecordFolder(
    "study of gages", RECORD_FILE, (RECORD_FILE, GAGES_FILE, COUNTS_FILE, CHART_FILE)
)

WORDS = Path(__file__).parent / "templates" / "advice.txt.j2"
TARGET = 0.05  # The target error of the stick ratio, RMS, of a reference finger.
ENOUGH = 0.1  # Fewer gages suffice if they add no more than this fraction to all gages' error.
WORTH = 0.2  # Gages that take less than this fraction off the error without gages hardly help.


@dataclass(frozen=True)
class Gage:
    """One gage. rank: 1 is the last to be removed; cost: the rise of an error when it is dead.

    unnoticed: it reads 0, and the network that was trained with it does not know (tested grips).
    known: the quick learner is trained without it (grips that gages are chosen by). response: the
    largest to F_t where all sticks.
    """

    plate: int
    x_mm: float
    response_microstrain_per_N: float
    rank: int
    unnoticed_stick_cost: float
    unnoticed_friction_utilisation_cost: float
    known_stick_cost: float
    known_friction_utilisation_cost: float


@dataclass(frozen=True)
class Count:
    """Errors with some gages; ``chosen`` are their numbers in the order of the gages.

    quick: of the learner that ranks, on the grips that it ranks by. stick_error,
    friction_utilisation_error: of a network on the tested grips, None where none was trained;
    stick_std: standard error of the first.
    """

    chosen: tuple[int, ...]
    quick_stick_error: float
    quick_friction_utilisation_error: float
    stick_error: float | None
    friction_utilisation_error: float | None
    stick_std: float | None


@dataclass(frozen=True)
class Layout:
    """A layout of few gages, by the quick learner."""

    layout: str
    chosen: tuple[int, ...]
    quick_stick_error: float
    quick_friction_utilisation_error: float


@dataclass(frozen=True)
class NoiseLevel:
    """All gages at a noise, by the quick learner."""

    noise_microstrain: float
    quick_stick_error: float
    quick_friction_utilisation_error: float


@dataclass(frozen=True)
class Dead:
    """The gage (number) whose failure costs most, by networks on the tested grips."""

    gage: int
    stick_error: float
    unnoticed_stick_error: float
    known_stick_error: float


@dataclass(frozen=True)
class Pressing:
    """Half the contact's width under a normal force without shear."""

    normal_force_N: float
    half_width_mm: float


@dataclass(frozen=True)
class Floor:
    """The least error of the stick ratio that any unbiased estimate from the gages can have.

    change: of the readings (length of the vector) per unit of stick ratio at the same forces.
    one_sample, window: from one sample, and from as many as the estimator looks back on.
    """

    normal_force_N: float
    change_microstrain: float
    one_sample_stick_error: float
    window_stick_error: float


@dataclass(frozen=True)
class Observability:
    """The record of one ``fingerdesign validate --gages``; noise in microstrain, errors RMS."""

    noise: float
    grips: int
    samples: int
    seed: int
    gages: tuple[Gage, ...]
    counts: tuple[Count, ...]
    layouts: tuple[Layout, ...]
    noises: tuple[NoiseLevel, ...]
    pressings: tuple[Pressing, ...]
    floors: tuple[Floor, ...]
    dead: Dead
    seconds: float
    design: str = ""
    digest: str = ""

    def count(self, number: int) -> Count:
        """The row for ``number`` gages. Raises KeyError where there is none."""
        return {len(each.chosen): each for each in self.counts}[number]

    @property
    def confirmed(self) -> tuple[Count, ...]:
        """Rows that a network confirmed, most gages first."""
        return tuple(each for each in self.counts if each.stick_error is not None)

    @property
    def stick_error(self) -> float:
        """Error of the network with all gages."""
        return self.confirmed[0].stick_error or 0.0

    @property
    def stick_error_without_gages(self) -> float:
        """Error of the network that has forces and moves alone."""
        return self.confirmed[-1].stick_error or 0.0

    @property
    def worth(self) -> float:
        """The fraction that the gages take off the error without gages."""
        return 1.0 - self.stick_error / max(self.stick_error_without_gages, 1e-12)

    @property
    def too_quiet(self) -> bool:
        """True if the gages add hardly more than forces and moves give alone."""
        return self.worth < WORTH

    @property
    def enough(self) -> Count:
        """The fewest gages that cost no more than :data:`ENOUGH` of all gages' error."""
        most = (1.0 + ENOUGH) * self.stick_error
        return [each for each in self.confirmed if (each.stick_error or 0.0) <= most][-1]

    @property
    def largest_response(self) -> float:
        """Response of the strongest gage, microstrain/N."""
        return max(each.response_microstrain_per_N for each in self.gages)

    def places(self, count: Count) -> tuple[float, ...]:
        """x (mm) of the chosen gages, rising."""
        return tuple(sorted(self.gages[k].x_mm for k in count.chosen))

    def layout(self, count: Count) -> str:
        """The layout of the chosen gages where ranks did not choose them; else ""."""
        named = {each.chosen: each.layout for each in reversed(self.layouts)}
        return named.get(count.chosen, "searched").replace("searched", "")

    @property
    def uncertain(self) -> bool:
        """True if the standard error is as large as the accepted loss of few gages against all."""
        std = max(self.confirmed[0].stick_std or 0.0, self.enough.stick_std or 0.0)
        return std >= ENOUGH * self.stick_error

    @property
    def noise_share(self) -> float:
        """The fraction of all gages' error that noise causes; by the quick learner."""
        here = next(
            each.quick_stick_error for each in self.noises if each.noise_microstrain == self.noise
        )
        return 1.0 - self.noises[0].quick_stick_error / max(here, 1e-12)

    @property
    def noise_of_worth(self) -> float | None:
        """The largest smaller noise, microstrain, at which the gages help more; None: at none."""
        most = (1.0 - WORTH) * self.count(0).quick_stick_error
        quieter = [each for each in self.noises if each.noise_microstrain < self.noise]
        worth = (each.noise_microstrain for each in quieter if each.quick_stick_error < most)
        return max(worth, default=None)

    @property
    def sentences(self) -> tuple[str, ...]:
        """The advice to the designer, sentence by sentence."""
        return sentences(WORDS, "advice", self, TARGET, WORTH)

    @property
    def advice(self) -> str:
        return " ".join(self.sentences)

    @property
    def limits(self) -> tuple[str, ...]:
        """The least error of any estimate from the gages, a sentence for each force."""
        return sentences(WORDS, "floors", self)

    def data(self) -> dict[str, Any]:
        silent = asdict(self.dead)
        dead = self.gages[silent.pop("gage")]
        return {
            "schema_version": 1,
            "design": self.design,
            "digest": self.digest,
            "status": "ok",
            "noise_microstrain": self.noise,
            "grips": self.grips,
            "samples": self.samples,
            "seed": self.seed,
            "target_stick_error": TARGET,
            "stick_error": self.stick_error,
            "friction_utilisation_error": self.confirmed[0].friction_utilisation_error,
            "stick_error_without_gages": self.stick_error_without_gages,
            "worth_of_gages": self.worth,
            "noise_share": self.noise_share,
            "too_quiet": self.too_quiet,
            "gages_that_suffice": len(self.enough.chosen),
            "advice": self.advice,
            "gages": [asdict(each) for each in self.gages],
            "counts": [self._named(each) for each in self.counts],
            "layouts": [self._named(each) for each in self.layouts],
            "noises": [asdict(each) for each in self.noises],
            "dead_gage": {"plate": dead.plate, "x_mm": dead.x_mm, **silent},
            "floors": [asdict(each) for each in self.floors],
            "pressings": [asdict(each) for each in self.pressings],
            "seconds": self.seconds,
        }

    def _named(self, row: Count | Layout) -> dict[str, Any]:
        """A row with plates and places instead of the numbers of gages."""
        values = asdict(row)
        chosen = values.pop("chosen")
        return {
            "count": len(chosen),
            "plates": [self.gages[k].plate for k in chosen],
            "x_mm": [self.gages[k].x_mm for k in chosen],
            **values,
        }

    def texts(self) -> dict[str, str]:
        """File name -> content of the record's text files."""

        def cell(value: Any) -> Any:
            return " ".join(f"{each:g}" for each in value) if isinstance(value, list) else value

        data = self.data()
        gages, counts = ([row.values() for row in data[name]] for name in ("gages", "counts"))
        return {
            RECORD_FILE: json_text(data),
            GAGES_FILE: csv_text(data["gages"][0], gages),
            COUNTS_FILE: csv_text(data["counts"][0], (map(cell, row) for row in counts)),
        }


def write_observability(found: Observability, folder: Path) -> None:
    """The record, its tables and its chart into an existing folder."""
    (folder / CHART_FILE).write_bytes(chart_png(found.data()))
    for name, text in found.texts().items():
        (folder / name).write_text(text, encoding="utf-8")
