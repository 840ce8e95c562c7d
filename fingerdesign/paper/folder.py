"""The folder of the remade figures: each as PNG and SVG with its data, one page, one record."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.analysis.case import fundamental_scene
from fingerdesign.analysis.summary import result_digest, versions
from fingerdesign.paper.lifts import ROUTE_FRICTION, SAMPLE_NOISE, SEEDS
from fingerdesign.paper.page import paper_figures, paper_html
from fingerdesign.records.result import ResultError
from fingerdesign.runtime.files import move_into, whole_folder

if TYPE_CHECKING:
    from fingerdesign.paper.claims import Remade
    from fingerdesign.paper.figures import PaperFigure

PAGE_FILE, RECORD_FILE = "paper.html", "paper.json"


def write_paper(found: Remade, folder: Path) -> list[Path]:
    """All figures, the page and the record in ``folder``; returns the files, the page last.

    They are made aside and moved in one by one, the page at the end: what is there before stays as
    it is until all are made, other files in the folder always. Raises ResultError where they cannot
    be written.
    """
    figures = paper_figures(found, ROUTE_FRICTION, SAMPLE_NOISE)
    folder = folder.absolute()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with whole_folder(folder) as aside:
            made = [path for figure in figures for path in figure.write(aside)]
            record = json.dumps(record_of(found, figures), indent=2, allow_nan=False) + "\n"
            made += [aside / RECORD_FILE, aside / PAGE_FILE]
            made[-2].write_text(record, encoding="utf-8")
            made[-1].write_text(paper_html(found, figures, versions()), encoding="utf-8")
            move_into(folder, made)
    except OSError as error:
        raise ResultError(f"cannot write into {folder}: {error}") from error
    return [folder / path.name for path in made]


def record_of(found: Remade, figures: list[PaperFigure]) -> dict[str, Any]:
    """What paper.json holds."""
    return {
        "design": found.design.design.name,
        "digest": result_digest(found.design, fundamental_scene(), "paper"),
        "fidelity": "plane-strain",
        "dofs": found.dofs,
        "assumed": list(found.design.assumed),
        "claims": [asdict(claim) for claim in found.claims],
        "figures": [
            {
                "key": figure.key,
                "title": figure.shown.title,
                "words": figure.shown.alternative,
                "files": [f"{figure.key}.{kind}" for kind in ("png", "svg", "csv")],
            }
            for figure in figures
        ],
        "seeds": {"grip": found.design.grip.seed, "rig": list(range(SEEDS))},
        "seconds": round(found.seconds, 3),
        "versions": versions(),
    }
