"""What a study of gages writes: observability.json, gages.csv, counts.csv, and their chart."""

from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.records.base import csv_text, json_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.report.page import sentences
from fingerdesign.report.style import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    OPEN_COLOUR,
    PAPER,
    VERMILION,
    Axes,
    canvas,
    house_style,
    to_png,
    whole_numbers,
)

RECORD_FILE, GAGES_FILE, COUNTS_FILE = "observability.json", "gages.csv", "counts.csv"
CHART_FILE = "observability.png"

WORDS = Path(__file__).parent / "templates" / "advice.txt.j2"
TARGET = 0.05  # stick ratio, RMS: what a reference finger is asked for
ENOUGH = 0.1  # of all gages' error: fewer that cost no more than this suffice
WORTH = 0.2  # what takes less than this off an error hardly helps: gages that do are too quiet


@dataclass(frozen=True)
class Gage:
    """One gage. rank: 1 is the last to be taken away; costs: what it adds to an error, dead.

    untold: it reads 0 and the network, taught with it, is not given that (network, judged grips).
    told: the learner is taught without it (quick learner, grips chosen by). response: the most that
    it answers to F_t where all sticks.
    """

    plate: int
    x_mm: float
    response_microstrain_per_N: float
    rank: int
    untold_stick_cost: float
    untold_used_cost: float
    told_stick_cost: float
    told_used_cost: float


@dataclass(frozen=True)
class Count:
    """Errors with some gages; ``kept`` numbers them in the order of the gages.

    quick: of the learner that ranks, on the grips that it ranks by. stick_error, used_error: of a
    network on grips that nothing was taught on or chosen by, None where none was taught;
    stick_spread: standard error of the first.
    """

    kept: tuple[int, ...]
    quick_stick_error: float
    quick_used_error: float
    stick_error: float | None
    used_error: float | None
    stick_spread: float | None


@dataclass(frozen=True)
class Layout:
    """A way of placing few gages, by the quick learner."""

    layout: str
    kept: tuple[int, ...]
    quick_stick_error: float
    quick_used_error: float


@dataclass(frozen=True)
class NoiseLevel:
    """All gages at a noise, by the quick learner."""

    noise_microstrain: float
    quick_stick_error: float
    quick_used_error: float


@dataclass(frozen=True)
class Dead:
    """The gage (number) whose silence costs most, by networks on the judged grips."""

    gage: int
    stick_error: float
    untold_stick_error: float
    told_stick_error: float


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
        return {len(each.kept): each for each in self.counts}[number]

    @property
    def confirmed(self) -> tuple[Count, ...]:
        """Rows that a network was taught for, most gages first."""
        return tuple(each for each in self.counts if each.stick_error is not None)

    @property
    def stick_error(self) -> float:
        """Of the network with all gages."""
        return self.confirmed[0].stick_error or 0.0

    @property
    def stick_error_without_gages(self) -> float:
        """Of the network that has forces and moves alone."""
        return self.confirmed[-1].stick_error or 0.0

    @property
    def worth(self) -> float:
        """The share that the gages take off the error without gages."""
        return 1.0 - self.stick_error / max(self.stick_error_without_gages, 1e-12)

    @property
    def too_quiet(self) -> bool:
        """Whether the gages hardly tell more than forces and moves alone."""
        return self.worth < WORTH

    @property
    def enough(self) -> Count:
        """The fewest gages that cost no more than :data:`ENOUGH` of all gages' error."""
        most = (1.0 + ENOUGH) * self.stick_error
        return [each for each in self.confirmed if (each.stick_error or 0.0) <= most][-1]

    @property
    def loudest(self) -> float:
        """Response of the strongest gage, microstrain/N."""
        return max(each.response_microstrain_per_N for each in self.gages)

    def places(self, count: Count) -> tuple[float, ...]:
        """x (mm) of the gages kept, rising."""
        return tuple(sorted(self.gages[k].x_mm for k in count.kept))

    @property
    def unsure(self) -> bool:
        """Whether the standard error is as large as what would part few gages from all."""
        spread = max(self.confirmed[0].stick_spread or 0.0, self.enough.stick_spread or 0.0)
        return spread >= ENOUGH * self.stick_error

    @property
    def noise_share(self) -> float:
        """How much lower all gages' error is without noise, of itself; by the quick learner."""
        here = next(
            each.quick_stick_error for each in self.noises if each.noise_microstrain == self.noise
        )
        return 1.0 - self.noises[0].quick_stick_error / max(here, 1e-12)

    @property
    def noise_of_worth(self) -> float | None:
        """The greatest smaller noise, microstrain, at which the gages tell more; None: at none."""
        most = (1.0 - WORTH) * self.count(0).quick_stick_error
        quieter = [each for each in self.noises if each.noise_microstrain < self.noise]
        worth = (each.noise_microstrain for each in quieter if each.quick_stick_error < most)
        return max(worth, default=None)

    @property
    def sentences(self) -> tuple[str, ...]:
        """What a designer should do, a sentence each."""
        return sentences(WORDS, "advice", self, TARGET, WORTH)

    @property
    def advice(self) -> str:
        """:attr:`sentences`, one after the other."""
        return " ".join(self.sentences)

    @property
    def limits(self) -> tuple[str, ...]:
        """What no estimate from the gages can be better than, a sentence for each force."""
        return sentences(WORDS, "floors", self)

    def data(self) -> dict[str, Any]:
        """As in the file."""
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
            "used_error": self.confirmed[0].used_error,
            "stick_error_without_gages": self.stick_error_without_gages,
            "worth_of_gages": self.worth,
            "noise_share": self.noise_share,
            "too_quiet": self.too_quiet,
            "gages_that_suffice": len(self.enough.kept),
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
        """A row with plates and places instead of numbers in the order of the gages."""
        values = asdict(row)
        kept = values.pop("kept")
        return {
            "count": len(kept),
            "plates": [self.gages[k].plate for k in kept],
            "x_mm": [self.gages[k].x_mm for k in kept],
            **values,
        }

    def texts(self) -> dict[str, str]:
        """File name -> content of the record's text files."""
        names = [each.name for each in fields(Gage)]
        gages = ([getattr(each, name) for name in names] for each in self.gages)
        rows = [self._named(each) for each in self.counts]
        counts = ([_cell(value) for value in row.values()] for row in rows)
        return {
            RECORD_FILE: json_text(self.data()),
            GAGES_FILE: csv_text(names, gages),
            COUNTS_FILE: csv_text(rows[0], counts),
        }


def _cell(value: Any) -> Any:
    return " ".join(f"{each:g}" for each in value) if isinstance(value, list) else value


FOLDER = RecordFolder(
    "study of gages", RECORD_FILE, (RECORD_FILE, GAGES_FILE, COUNTS_FILE, CHART_FILE)
)


def write_observability(found: Observability, folder: Path) -> None:
    """The record, its tables and its chart into an existing folder."""
    (folder / CHART_FILE).write_bytes(chart_png(found.data()))
    for name, text in found.texts().items():
        (folder / name).write_text(text, encoding="utf-8")


def chart_png(data: dict[str, Any]) -> bytes:
    """Error by number of gages, and what each gage's silence costs, of observability.json."""
    with house_style():
        figure = canvas(9.6, 4.9)
        by_count, along = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
        _by_count(by_count, data)
        _along(along, data)
        figure.suptitle(f"{data['design']}, gage noise {data['noise_microstrain']:g} microstrain")
        return to_png(figure)


def _by_count(axes: Axes, data: dict[str, Any]) -> None:
    rows = data["counts"]
    counts = [row["count"] for row in rows]
    quick = [row["quick_stick_error"] for row in rows]
    axes.plot(
        counts, quick, color=MUTED, ls=(0, (2, 2)), lw=1.2, label="stick ratio, quick learner"
    )
    taught = [row for row in rows if row["stick_error"] is not None]
    counts = [row["count"] for row in taught]
    stick = np.array([row["stick_error"] for row in taught])
    spread = np.array([row["stick_spread"] for row in taught])
    axes.vlines(counts, stick - spread, stick + spread, color=BLUE, lw=1.0)
    axes.plot(counts, stick, color=BLUE, marker="o", label="stick ratio, network")
    used = [row["used_error"] for row in taught]
    axes.plot(
        counts, used, color=GREEN, ls=(0, (6, 2)), marker="^", label="friction in use, network"
    )
    target = data["target_stick_error"]
    axes.axhline(target, color=VERMILION, zorder=1, ls=(0, (4, 3)), lw=1.0)
    look = {"color": VERMILION, "fontsize": 8.5}
    _note(axes, f"goal: {target:g}", (0.99, target), (0, -11), ("axes fraction", "data"), **look)
    axes.xaxis.set_major_locator(whole_numbers())
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("gages (0: forces and moves alone)")
    axes.set_ylabel("error (RMS)")
    axes.set_title("Fewer gages")
    _legend_below(axes)


def _along(axes: Axes, data: dict[str, Any]) -> None:
    gages = sorted(data["gages"], key=lambda gage: gage["x_mm"])
    x = np.array([gage["x_mm"] for gage in gages])
    look = {"va": "top", "fontsize": 7.5, "color": MUTED}
    for pressing in data["pressings"]:
        half = pressing["half_width_mm"]
        axes.axvspan(-half, half, color=OPEN_COLOUR, alpha=0.55, lw=0, zorder=0)
        force = f"{pressing['normal_force_N']:.3g} N"
        _note(axes, force, (half, 0.995), (-2, -2), ("data", "axes fraction"), **look)
    width = 0.35 * float(np.diff(x).min(initial=1.0))
    untold = [gage["untold_stick_cost"] for gage in gages]
    axes.bar(
        x, untold, width, color=VERMILION, hatch="///", edgecolor=PAPER, label="reads 0, untold"
    )
    axes.set_xlabel("x of the gage (mm); shaded: contact under a normal force")
    axes.set_ylabel("cost of a dead gage, stick ratio (RMS)")
    axes.set_title("Which gages")
    reported = [max(gage["told_stick_cost"], 0.0) for gage in gages]
    top = 1.12 * max([*untold, *reported, 1e-3])  # room for the forces
    least = data["gages_that_suffice"]
    kept = next(row["plates"] for row in data["counts"] if row["count"] == least)
    chosen = [gage["x_mm"] for gage in gages if gage["plate"] in kept]
    if least:
        under = np.full(len(chosen), -0.04 * top)  # the bars, clear of the dots at 0
        axes.plot(chosen, under, "^", color=INK, ms=7, label=f"the {least} that suffice")
    axes.plot(x, reported, "o", color=BLUE, ms=4, zorder=4, label="taught without it")
    axes.axhline(0.0, color=MUTED, lw=0.8, zorder=1)
    axes.set_ylim(-0.08 * top, top)
    _legend_below(axes)


def _note(axes: Axes, text: str, place: Any, shift: Any, of: tuple[str, str], **look: Any) -> None:
    axes.annotate(text, place, shift, xycoords=of, textcoords="offset points", ha="right", **look)


def _legend_below(axes: Axes) -> None:
    """Under the axis' label, where it hides nothing."""
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.17), borderaxespad=0.0)
