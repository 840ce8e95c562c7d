"""GripBench: a fixed, versioned set of perturbed fingers and objects, and a scorecard.

Every version is one design, labels of faults, fingers of each, objects a finger, between ends of
friction and weight. Its public seed is for development; scores are of the held-out seed, of which
the SHA-256 is published here, and the phrase itself with the release.
"""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field
from typing_extensions import TypedDict

from fingerdesign.checks.load import load_design
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import Count, Size, closed, csv_text, json_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.records.statistics import Share, Spread
from fingerdesign.report import style
from fingerdesign.trials.figures import look_of
from fingerdesign.trials.grid import EVERY, NONE, ControlGrid, Perturbed
from fingerdesign.trials.record import ControlStudy
from fingerdesign.trials.summary import Trial, summarise

NAME, VERSION = "gripbench", 2
DESIGN = "sensitive"
_FAULTS = "modulus plates tilt radius drift dying arm patches kinetic"
PERTURBED = Perturbed((NONE, *_FAULTS.split(), EVERY), plants=9, lifts=4)
PUBLIC_SEED = 1
HELD_OUT_SHA256 = "a5b3a4e49720e70aa195fcf7a56fcc95105443ce512d92867f253a58d987ae5d"
RECORD, CSV, PICTURE = "gripbench.json", "gripbench.csv", "gripbench.png"
FOLDER = RecordFolder("GripBench scorecard", RECORD, (RECORD, CSV, PICTURE))


@closed
class Score(TypedDict):
    """One controller on the whole set."""

    controller: str
    grips: Count
    fingers: Count
    success: Annotated[Share, Field(description="its interval is over fingers, as clusters")]
    held: Annotated[Share, Field(description="lifted without complete slip; over fingers")]
    dropped: Count
    crushed: Count
    failed: Count
    margin: Annotated[Spread | None, Field(description="of the least force, at the lift")]
    peak_ratio: Annotated[Spread | None, Field(description="peak over the least normal force")]
    lead_s: Annotated[Spread | None, Field(description="from warning to complete slip")]
    falsely_alarmed: Annotated[Share | None, Field(description="grips; null: it never warns")]
    unsure: Annotated[Share | None, Field(description="of the grips that succeeded")]
    by_fault: Annotated[dict[str, Share], Field(description="success; over fingers")]


@closed
class Scorecard(TypedDict):
    """Scores of controllers on one version of the set."""

    benchmark: Literal["gripbench"]
    version: Count
    set: Literal["public", "held-out"]
    design: str
    design_digest: str
    scores: list[Score]
    seconds: Size
    workers: Count
    versions: dict[str, str]


def benchmark_design() -> Design:
    """The design that the fingers are drawn from."""
    return load_design(DESIGN)


def benchmark_grid(held_out: str | None) -> ControlGrid:
    """The set; held_out: the phrase of the held-out seed, None: the public one.

    DesignError for a phrase that is not the published one.
    """
    if held_out is None:
        return ControlGrid.of_perturbed(PERTURBED, PUBLIC_SEED)
    digest = hashlib.sha256(held_out.encode()).hexdigest()
    if digest != HELD_OUT_SHA256:
        bound = f"the phrase whose SHA-256 begins with {HELD_OUT_SHA256[:8]}"
        remedy = "copy it from the release's notes, or leave it out for the public set"
        raise DesignError([Fault("--held-out", held_out, bound, remedy)])
    # Of another digest than the published one, which gives nothing away.
    seed = int(hashlib.sha256(f"seed:{held_out}".encode()).hexdigest()[:8], 16)
    return ControlGrid.of_perturbed(PERTURBED, seed)


def scorecard(found: ControlStudy, controllers: Sequence[str], held_out: bool) -> Scorecard:
    """Sum up the trials of a run on :func:`benchmark_grid`."""
    data = found.data
    return {
        "benchmark": "gripbench",
        "version": VERSION,
        "set": "held-out" if held_out else "public",
        "design": data["design"],
        "design_digest": benchmark_design().digest(),
        "scores": [_score(found.trials, name) for name in controllers],
        "seconds": data["seconds"]["whole"],
        "workers": data["workers"],
        "versions": data["versions"],
    }


def _score(trials: Sequence[Trial], name: str) -> Score:
    own = [each for each in trials if each.cell.controller == name]
    sums = summarise(own, drawn=True)
    by_fault: dict[str, list[Trial]] = {}
    for each in own:
        by_fault.setdefault(each.cell.fault, []).append(each)
    return {
        "controller": name,
        "grips": sums.grips,
        "fingers": sums.fingers,
        "success": sums.success,
        "held": sums.held,
        "dropped": sums.dropped,
        "crushed": sums.crushed,
        "failed": sums.failed,
        "margin": sums.margin_at_lift,
        "peak_ratio": sums.peak_ratio,
        "lead_s": sums.foreseen.lead_s,
        "falsely_alarmed": sums.foreseen.falsely_alarmed,
        "unsure": sums.unsure,
        "by_fault": {
            label: summarise(lifts, drawn=True).success for label, lifts in by_fault.items()
        },
    }


def write_scorecard(card: Scorecard, folder: Path) -> None:
    """Write JSON, a line of CSV for each controller, and a small picture."""
    (folder / PICTURE).write_bytes(badge_png(card))
    (folder / CSV).write_text(scorecard_csv(card), encoding="utf-8")
    (folder / RECORD).write_text(json_text(card), encoding="utf-8")


def scorecard_csv(card: Scorecard) -> str:
    """One line for each controller."""
    columns = "benchmark,version,set,controller,grips,fingers,success,low,high,held,margin"
    names = f"{columns},peak_ratio,lead_s,falsely_alarmed,unsure,dropped,crushed,failed".split(",")

    def row(score: Score) -> list[object]:
        spreads = (score["margin"], score["peak_ratio"], score["lead_s"])
        shares = (score["falsely_alarmed"], score["unsure"])
        success = score["success"]
        return [
            *(card["benchmark"], card["version"], card["set"], score["controller"]),
            *(score["grips"], score["fingers"], success.rate, success.low, success.high),
            score["held"].rate,
            *(each and each.median for each in spreads),
            *(each and each.rate for each in shares),
            *(score["dropped"], score["crushed"], score["failed"]),
        ]

    return csv_text(names, map(row, card["scores"]))


def badge_png(card: Scorecard) -> bytes:
    """Success of each controller with its interval, small."""
    with style.house_style():
        scores = card["scores"]
        figure = style.canvas(4.0, 0.7 + 0.22 * len(scores))
        axes = figure.subplots()
        for place, score in enumerate(scores):
            share, look = score["success"], look_of(score["controller"])
            low, high = 100 * (share.low or 0.0), 100 * (share.high or 0.0)
            axes.barh(place, 100 * (share.rate or 0.0), color=look[0], height=0.7)
            axes.hlines(place, low, high, color=style.INK, lw=1.2)
        names = [score["controller"].rpartition(":")[2] for score in scores]
        axes.set_yticks(range(len(scores)), names, fontsize=7)
        axes.set_xlim(0.0, 100.0)
        axes.invert_yaxis()
        axes.set_title(f"GripBench {card['version']}, {card['set']}: success in %", fontsize=8)
        return style.to_png(figure)
