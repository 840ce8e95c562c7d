"""The folder that a user opens: result, histories, fields, CAD, report; whole or not at all."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

from fingerdesign.errors import DesignError, FingerDesignError, SolverError
from fingerdesign.pipeline import (
    Case,
    Clock,
    failed_result,
    fundamental_scene,
    refuse,
    run,
    with_report_time,
)
from fingerdesign.resources.forecast import forecast_case
from fingerdesign.result_folder import result_folder, write_result_files
from fingerdesign.results import Analysis, Result
from fingerdesign.runtime.progress import Tell

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


def analyse_into(case: Case, out: Path, tell: Tell = lambda message: None) -> Result:
    """Run a case and write OUT/NAME; a failure of the work is written as a failed result.

    Raises DesignError for wrong input (nothing is written) and ResultError where the folder cannot
    be written. ``result.status`` says how the work ended.
    """
    refuse(case, case.scene or fundamental_scene())
    if case.fidelity != "auto":  # which models that will take is not known yet
        tell(f"forecast: {forecast_case(case)}")
    target = out / case.design.design.name
    clock = Clock()
    with result_folder(target) as folder:
        try:
            tell("building the solid")
            with clock.stage("geometry"):
                write_solid(case.design, folder)
            analysis = run(case, tell, clock)
        except DesignError:
            raise
        except FingerDesignError as error:
            analysis = Analysis(failed_result(case, error, clock))
        except MemoryError:
            short = SolverError("not enough memory for this model; coarsen the mesh")
            analysis = Analysis(failed_result(case, short, clock))
        tell("writing the report")
        analysis = write_outputs(analysis, folder)
    return analysis.result


def write_solid(design: Design, folder: Path) -> None:
    """finger.step, finger.stl and the parts' STL files."""
    from fingerdesign.geometry.solid_process import write_finger_cad

    write_finger_cad(design, folder)


def write_outputs(analysis: Analysis, folder: Path) -> Analysis:
    """Fields, report.html, result.json and tables into ``folder``."""
    from fingerdesign.report.fields import write_fields
    from fingerdesign.report.html import write_report

    start = time.perf_counter()
    if analysis.mesh is not None:
        write_fields(folder, analysis.mesh, analysis.fields)
    # Drawing the pictures is most of the report's time, so it is known before the page is written.
    write_report(analysis, folder)
    analysis = with_report_time(analysis, time.perf_counter() - start)
    write_result_files(folder, analysis.result, analysis.grip_traces)
    return analysis
