"""The folder that a user opens: result, histories, fields, CAD, report; whole or not at all."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.page.fields import write_fields
from fingerdesign.analysis.page.page import write_report
from fingerdesign.analysis.summary import (
    peak_memory_MB,
)
from fingerdesign.cad.solid_process import write_finger_cad
from fingerdesign.records.folder import write_result_files

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


def write_solid(design: Design, folder: Path) -> None:
    """finger.step, finger.stl and the parts' STL files."""
    write_finger_cad(design, folder)


def write_outputs(analysis: Analysis, folder: Path) -> Analysis:
    """Fields, report.html, result.json and tables into ``folder``."""
    start = time.perf_counter()
    if analysis.mesh is not None:
        write_fields(folder, analysis.mesh, analysis.fields)
    # Drawing the pictures is most of the report's time, so it is known before the page is written.
    write_report(analysis, folder)
    analysis = with_report_time(analysis, time.perf_counter() - start)
    write_result_files(folder, analysis.result, analysis.grip_traces)
    return analysis


def with_report_time(analysis: Analysis, seconds: float) -> Analysis:
    """The analysis with the time of its own report added."""
    timings = dict(analysis.result.timings_s)
    timings["report"] = timings.get("report", 0.0) + seconds
    result = replace(analysis.result, timings_s=timings, peak_memory_MB=peak_memory_MB())
    return replace(analysis, result=result)
