"""The folder of a study of gages, and what is written into it."""

from __future__ import annotations

from pathlib import Path

from fingerdesign.record_folder import RecordFolder
from fingerdesign.study.observability_record import (
    CHART_FILE,
    COUNTS_FILE,
    GAGES_FILE,
    RECORD_FILE,
    Observability,
)

FOLDER = RecordFolder(
    "study of gages", RECORD_FILE, (RECORD_FILE, GAGES_FILE, COUNTS_FILE, CHART_FILE)
)


def write_observability(found: Observability, folder: Path) -> None:
    """The record, its tables and its chart into an existing folder."""
    from fingerdesign.report.figures_observability import chart_png

    (folder / CHART_FILE).write_bytes(chart_png(found.data()))
    for name, text in found.texts().items():
        (folder / name).write_text(text, encoding="utf-8")
