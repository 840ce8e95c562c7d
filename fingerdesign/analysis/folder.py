"""The folder of one analysis: its record and arrays, and what is drawn from them on demand."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path

from fingerdesign.analysis.analysis import Analysis, parameters
from fingerdesign.analysis.answers import (
    ARRAYS,
    CAD,
    DESIGN,
    PAGE,
    keep_answer,
    missing,
    read_arrays,
)
from fingerdesign.analysis.case import Case, Clock, fundamental_scene
from fingerdesign.analysis.page.fields import write_fields
from fingerdesign.analysis.page.page import report_html
from fingerdesign.cad.solid_process import finger_cad_beside, write_finger_cad
from fingerdesign.checks.load import dump_design, load_design
from fingerdesign.design.schema import Design
from fingerdesign.records.arrays import write_packed
from fingerdesign.records.base import ResultError
from fingerdesign.records.folder import read_result, write_result_files
from fingerdesign.records.result import Result
from fingerdesign.runtime.files import move_into, whole_folder, write_whole
from fingerdesign.runtime.machine import largest_memory_MB

_NOT_KEPT = ("result", "problem")  # it has a file of its own; made anew by an analysis


@contextmanager
def cad_beside(design: Design, folder: Path, clock: Clock, wanted: bool) -> Iterator[None]:
    """Write the finger's STEP and STL files, where they are wanted, beside the block.

    GeometryError where that fails.
    """
    if not wanted:
        yield
        return
    with finger_cad_beside(design, folder) as wait:
        yield
        with clock.stage("geometry"):
            wait()


def write_analysis(
    analysis: Analysis, design: Design, folder: Path, clock: Clock, page: bool
) -> Result:
    """Write record, tables, fields, arrays, the design and, where wanted, the page into ``folder``.

    Returns the record, which then says what this took.
    """
    timed = replace(analysis.result, timings_s=dict(clock.seconds))
    analysis = replace(analysis, result=timed)
    with clock.stage("report"), ThreadPoolExecutor(1) as beside:  # packing leaves a core to others
        written = (
            beside.submit(write_fields, folder, analysis.mesh, analysis.fields)
            if analysis.mesh is not None
            else None
        )
        names = [each.name for each in fields(Analysis) if each.name not in _NOT_KEPT]
        write_packed(folder / ARRAYS, {name: getattr(analysis, name) for name in names})
        (folder / DESIGN).write_text(dump_design(design), encoding="utf-8")
        if page:
            write_page(analysis, folder)
        if written is not None:
            written.result()
    memory = largest_memory_MB()
    result = replace(timed, timings_s=dict(clock.seconds), peak_memory_MB=memory)
    write_result_files(folder, result, analysis.grip_traces)
    return result


def write_page(analysis: Analysis, folder: Path) -> Path:
    """Write ``report.html`` into an existing folder; returns its path."""
    return write_whole(folder / PAGE, report_html(analysis))


def read_analysis(folder: Path) -> Analysis:
    """The analysis whose folder this is, to be asked and drawn again; without its ``problem``.

    Raises ResultError and DesignError where the files are not there, or not what was written.
    """
    result = read_result(folder)
    try:
        return Analysis(result, **read_arrays(folder))
    except TypeError as error:
        raise ResultError(f"{folder / ARRAYS} is no analysis: {error}; run it again") from error


def complete(folder: Path, page: bool, cad: bool) -> None:
    """Draw the page, write the CAD files, where they are wanted and missing.

    Errors as of :func:`read_analysis`, GeometryError, OSError.
    """
    if page and not (folder / PAGE).exists():
        write_page(read_analysis(folder), folder)
    if cad and not (folder / CAD).exists():
        design = _analysed_design(folder)
        with whole_folder(folder) as aside:  # beside it: a killed one leaves nothing in it
            files = write_finger_cad(design, aside)
            move_into(folder, files.values())


def complete_answer(case: Case, out: Path, page: bool | None, cad: bool | None) -> None:
    """As :func:`complete`, of a case's OUT/NAME; what is drawn is kept with its answer."""
    if any(wanted := missing(case, out, page, cad)):
        folder = out / case.design.design.name
        complete(folder, *wanted)
        keep_answer(case, folder)


def _analysed_design(folder: Path) -> Design:
    """The design that was analysed; ResultError where its file has been changed since."""
    design, known = load_design(folder / DESIGN), read_result(folder).parameters
    now = parameters(design, fundamental_scene())
    changed = [key for key in now if not key.startswith("scene.") and now[key] != known.get(key)]
    if changed:
        why = f"{changed[0]} is {now[changed[0]]} there and was {known.get(changed[0])}"
        raise ResultError(f"{folder / DESIGN} is not the design analysed: {why}; analyse it anew")
    return design
