"""Run the search for the paper's finger (study/paper_finger.py) and write what it found."""

import csv
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from fingerdesign.checks.starter import shipped_text
from fingerdesign.errors import FingerDesignError
from fingerdesign.runtime.pool import Pool
from fingerdesign_bench.studies.paper_finger import (
    FRICTIONS,
    Analysed,
    Candidate,
    analyse_candidate,
    best,
    candidates,
)

Report = Callable[[str, float | None], None]
COUNT, SEED = 384, 2000
_FINALISTS = 10  # analysed again on the mesh that the design is shipped with


@dataclass(frozen=True)
class Search:
    """Every candidate as far as it came, and the finalists on the fine mesh, best first."""

    candidates: tuple[Candidate, ...]
    findings: tuple[Analysed, ...]
    finalists: tuple[Analysed, ...]

    @property
    def winner(self) -> Analysed:
        return self.finalists[0]

    @property
    def refusals(self) -> Counter[str]:
        """Why candidates were left out, and how many."""
        found = {finding.candidate.number for finding in self.findings}
        return Counter(c.refused for c in self.candidates if c.number not in found)


def search(
    count: int = COUNT, seed: int = SEED, workers: int = 2, report: Report | None = None
) -> Search:
    """Sample, analyse, and analyse the best again. Raises FingerDesignError where none is left."""
    report = report if report is not None else _silent
    drawn = candidates(count, seed)
    worth = [candidate for candidate in drawn if not candidate.refused]
    analysed = _all(worth, True, workers, "candidates", report)
    findings = [each for each in analysed if isinstance(each, Analysed)]
    again = [finding.candidate for finding in best(findings, _FINALISTS)]
    fine = _all(again, False, workers, "finalists", report)
    finalists = best([each for each in fine if isinstance(each, Analysed)], _FINALISTS)
    if not finalists:
        raise FingerDesignError(f"none of {count} candidates is a finger for the paper's grips")
    refused = {each.number: each for each in analysed if isinstance(each, Candidate)}
    everyone = tuple(refused.get(candidate.number, candidate) for candidate in drawn)
    return Search(everyone, tuple(findings), tuple(finalists))


def write(found: Search, folder: Path) -> list[Path]:
    """candidates.csv, the winner as maeno2000.toml and fundamental.toml, and paper_finger.png."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / "candidates.csv", folder / "maeno2000.toml", folder / "fundamental.toml"]
    with paths[0].open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerows(_table(found))
    paths[1].write_text(winner_design(found.winner), encoding="utf-8")
    paths[2].write_text(winner_scene(found.winner), encoding="utf-8")
    paths.append(_chart(found, folder / "paper_finger.png"))
    return paths


def winner_design(winner: Analysed) -> str:
    """The shipped design file with the winner's dimensions, comments kept."""
    import tomlkit

    document = tomlkit.parse(shipped_text("maeno2000"))
    for key, value in winner.candidate.values.items():
        table, name = key.split(".")
        document[table][name] = value
    return tomlkit.dumps(document)


def winner_scene(winner: Analysed) -> str:
    """The shipped fundamental scene with the winner's rows, comments kept."""
    import tomlkit

    document = tomlkit.parse(shipped_text("fundamental", "scene"))
    rows = tomlkit.array()
    for row in winner.rows:
        rows.add_line([*row], indent="  ")
    rows.add_line(indent="")
    document["path"]["increments_mm"] = rows
    return tomlkit.dumps(document)


def _all(
    work: list[Candidate], coarse: bool, workers: int, what: str, report: Report
) -> list[Candidate | Analysed]:
    """Every candidate analysed, in order; in this process where ``workers`` is 1."""
    if workers <= 1:
        done = []
        for number, candidate in enumerate(work):
            report(f"{what} of the paper's finger", number / len(work))
            done.append(analyse_candidate(candidate, coarse))
        return done
    results: dict[int, Candidate | Analysed] = {}
    with Pool(workers) as pool:
        found = pool.as_done(
            lambda item: (item[0], pool.call(analyse_candidate, item[1], coarse)), enumerate(work)
        )
        for number, (k, each) in enumerate(found, 1):
            results[k] = each
            report(f"{what} of the paper's finger", number / len(work))
    return [results[k] for k in range(len(work))]


def _silent(message: str, fraction: float | None) -> None:
    del message, fraction


def _table(found: Search) -> list[list[object]]:
    """Rows of the CSV, a heading first; what was not found is left empty."""
    keys = list(found.candidates[0].values)
    measured = ["score", "signal_microstrain_per_N", "threshold_microstrain_per_N"]
    measured += ["normal_force_N", "pitches_at_5_N"]
    kinds = ("refined", "raw", "eight_steps", "growing")
    measured += [f"{kind}_mu_{mu:g}" for kind in kinds for mu in FRICTIONS]
    rows: list[list[object]] = [["number", "mesh", "refused", *keys, "approach_mm", *measured]]
    by_number = {finding.candidate.number: finding for finding in found.findings}
    runs: list[tuple[str, Candidate, Analysed | None]] = [
        ("coarse", candidate, by_number.get(candidate.number)) for candidate in found.candidates
    ]
    runs += [("fine", finding.candidate, finding) for finding in found.finalists]
    for mesh, candidate, finding in runs:
        row: list[object] = [candidate.number, mesh, candidate.refused]
        row += [*candidate.values.values(), candidate.approach]
        if finding is not None:
            numbers = [finding.score, finding.signal, finding.threshold]
            numbers += [finding.normal_force, finding.pitches]
            numbers += [*finding.fine, *finding.fine_raw, *finding.steps, *finding.growing]
            row += [f"{number:.4f}" for number in numbers]
        rows.append(row + [""] * (len(rows[0]) - len(row)))
    return rows


def _chart(found: Search, path: Path) -> Path:
    """Score against signal and against how many plates a small contact spans."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    winner = found.winner.candidate.number
    quantities = {
        "strongest gage at full stick (microstrain/N)": "signal",
        "contact width at 5 N / pitch": "pitches",
    }
    for axes, (label, name) in zip(panels, quantities.items(), strict=True):
        for findings, mark, text in (
            (found.findings, "o", "candidates, coarse mesh"),
            (found.finalists, "D", "finalists, fine mesh"),
        ):
            x = [getattr(finding, name) for finding in findings]
            axes.plot(x, [f.score for f in findings], mark, ms=4, alpha=0.7, label=text)
        best_x = getattr(found.winner, name)
        axes.plot([best_x], [found.winner.score], "*", ms=15, color="k", label=f"no. {winner}")
        axes.axhline(0.8, lw=0.8, ls="--", color="grey")
        axes.set_xlabel(label)
    panels[0].set_ylabel("worst rank correlation")
    panels[0].set_ylim(math.floor(10 * min(f.score for f in found.findings)) / 10, 1.02)
    panels[0].legend(loc="lower left", fontsize=8)
    figure.suptitle("Does the gage area follow the stick area? Worst friction, threshold and path")
    figure.savefig(path, dpi=150)
    return path
