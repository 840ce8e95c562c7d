"""The folder of one analysis: its record and arrays, and what is drawn from them on demand."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from fingerdesign.analysis.analysis import Analysis, parameters
from fingerdesign.analysis.answers import (
    ARRAYS,
    CAD,
    DESIGN,
    PAGE,
    cache_answer,
    missing,
    read_arrays,
)
from fingerdesign.analysis.case import Case, Clock, fundamental_scene
from fingerdesign.analysis.page.page import report_html
from fingerdesign.arrays import Array
from fingerdesign.cad.solid_process import finger_cad_concurrently, write_finger_cad
from fingerdesign.checks.load import load_design
from fingerdesign.design.io import dump_design
from fingerdesign.design.schema import Design
from fingerdesign.fem.elements import centre, tabulate
from fingerdesign.mesh.types import Mesh
from fingerdesign.records.arrays import OPEN, STICK, FieldHistory, write_packed
from fingerdesign.records.base import ResultError
from fingerdesign.records.result import Result
from fingerdesign.records.result_files import read_result, write_result_files
from fingerdesign.report.style import load_matplotlib_ahead
from fingerdesign.runtime.files import move_into, whole_folder, write_whole
from fingerdesign.runtime.machine import largest_memory_MB

STRAINS = ("xx", "yy", "zz", "xy", "xz", "yz")
_NOT_WRITTEN = ("result", "problem")  # The first has its own file, an analysis makes the other.


def write_fields(folder: Path, mesh: Mesh | None, fields: FieldHistory | None) -> list[Path]:
    """Write fields_NN.vtu (NN: increment, from 1) into an existing folder; returns the files.

    Point data: displacement_mm (three components). Cell data: region (0 elastomer, k + 1 plate k,
    a core's after the last plate's) and strain_xx_microstrain and so on, at the centroid, for xx,
    yy, zz, xy, xz, yz (engineering shear). Without fields one file, fields_mesh.vtu, holds the
    mesh and its regions. Quadratic cells; a half model is written as the half z >= 0 that it is
    (ParaView: Reflect). Without a mesh nothing is written.
    """
    if mesh is None:
        return []
    if fields is None:
        return [_write(folder / "fields_mesh.vtu", mesh, None)]
    n = len(mesh.points)
    if fields.displacement.shape[1:] != (n, mesh.dimension):
        raise ValueError(
            f"displacement of shape {fields.displacement.shape} is not of the mesh's {n} nodes"
        )
    digits = max(2, len(str(max(fields.increments, default=0) + 1)))
    return [
        _write(folder / f"fields_{number + 1:0{digits}d}.vtu", mesh, displacement)
        for number, displacement in zip(fields.increments, fields.displacement, strict=True)
    ]


def centroid_strain(mesh: Mesh, displacement: Array) -> Array:
    """Strain at each cell's centroid, microstrain, (c, 6): xx, yy, zz, xy, xz, yz.

    displacement (n, dim), mm. xy, xz, yz: engineering shear; zz = xz = yz = 0 in 2-D.
    The geometry is isoparametric: du/dx = (du/dxi) (dx/dxi)^-1 with the quadratic shape functions.
    """
    slopes = tabulate(mesh.kind, centre(mesh.kind)[:, None]).gradient[..., 0]
    jacobian = np.einsum("cai,ak->cik", mesh.points[mesh.cells], slopes)
    local = np.einsum("cai,ak->cik", displacement[mesh.cells], slopes)
    gradient = local @ np.linalg.inv(jacobian)
    strain = np.zeros((len(mesh.cells), 6))
    strain[:, : mesh.dimension] = np.einsum("cii->ci", gradient)
    i, j = np.triu_indices(mesh.dimension, 1)
    strain[:, 3 : 3 + len(i)] = gradient[:, i, j] + gradient[:, j, i]
    return 1e6 * strain


def _write(path: Path, mesh: Mesh, displacement: Array | None) -> Path:
    import meshio

    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.dimension] = mesh.points
    point_data, cell_data = {}, {"region": [mesh.regions.astype(np.int32)]}
    if displacement is not None:
        moved = np.zeros((len(points), 3), dtype=np.float32)
        moved[:, : mesh.dimension] = displacement
        point_data["displacement_mm"] = moved
        strain = centroid_strain(mesh, displacement).astype(np.float32)
        for part, values in zip(STRAINS, strain.T, strict=True):
            cell_data[f"strain_{part}_microstrain"] = [np.ascontiguousarray(values)]
    grid = meshio.Mesh(
        points, [(mesh.kind.quadratic, mesh.cells)], point_data=point_data, cell_data=cell_data
    )
    grid.write(path, file_format="vtu", binary=True)
    return path


@contextmanager
def products_begun(
    design: Design, folder: Path, clock: Clock, page: bool, cad: bool
) -> Iterator[None]:
    """Concurrently with the block load what draws the page, and write STEP and STL files.

    Each where it is needed. GeometryError where the files fail.
    """
    if page:
        load_matplotlib_ahead()
    if not cad:
        yield
        return
    with finger_cad_concurrently(design, folder) as wait:
        yield
        with clock.stage("geometry"):
            wait()


def write_analysis(
    analysis: Analysis, design: Design, folder: Path, clock: Clock, page: bool
) -> Result:
    """Write record, tables, fields, arrays, design and, where requested, the page into ``folder``.

    Returns the record with the time that this took.
    """
    timed = replace(analysis.result, timings_s=dict(clock.seconds))
    analysis = replace(analysis, result=timed)
    with clock.stage("report"), ThreadPoolExecutor(1) as thread:  # packing leaves a core idle
        written = thread.submit(write_fields, folder, analysis.mesh, analysis.fields)
        names = [each.name for each in fields(Analysis) if each.name not in _NOT_WRITTEN]
        write_packed(folder / ARRAYS, {name: getattr(analysis, name) for name in names})
        (folder / DESIGN).write_text(dump_design(design), encoding="utf-8")
        if page:
            write_page(analysis, folder)
        written.result()
    memory = largest_memory_MB()
    result = replace(timed, timings_s=dict(clock.seconds), peak_memory_MB=memory)
    write_result_files(folder, result, analysis.grip_traces)
    return result


def write_page(analysis: Analysis, folder: Path) -> Path:
    """Write ``report.html`` into an existing folder; returns its path."""
    return write_whole(folder / PAGE, report_html(analysis))


def read_analysis(folder: Path) -> Analysis:
    """The analysis whose folder this is, to be drawn again; without its ``problem``.

    Raises ResultError and DesignError where the files are not there, or not what was written.
    """
    result = read_result(folder)
    try:
        found = Analysis(result, **read_arrays(folder))
    except TypeError as error:
        raise ResultError(f"{folder / ARRAYS} is no analysis: {error}; run it again") from error
    if found.contact is not None:
        status = found.contact.status
        closed = [(row.open_nodes, row.stick_nodes) for row in result.increments]
        if [((row == OPEN).sum(), (row == STICK).sum()) for row in status] != closed:
            raise ResultError(f"{folder / ARRAYS} is of another analysis than its result.json")
    return found


def complete(folder: Path, page: bool, cad: bool) -> None:
    """Draw the page, write the CAD files, where they are requested and missing.

    Errors as of :func:`read_analysis`, GeometryError, OSError.
    """
    if page and not (folder / PAGE).exists():
        write_page(read_analysis(folder), folder)
    if cad and not (folder / CAD).exists():
        design = _analysed_design(folder)
        with whole_folder(folder) as aside:  # A killed process leaves nothing in the folder.
            files = write_finger_cad(design, aside)
            move_into(folder, files.values())


def complete_answer(case: Case, out: Path, page: bool | None, cad: bool | None) -> None:
    """Do :func:`complete` for a case's OUT/NAME; the cached answer gets the new files too."""
    if any(absent := missing(case, out, page, cad)):
        folder = out / case.design.design.name
        complete(folder, *absent)
        cache_answer(case, folder, read_result(folder))


def _analysed_design(folder: Path) -> Design:
    """The design that was analysed; ResultError where its file has been changed since."""
    design, known = load_design(folder / DESIGN), read_result(folder).parameters
    now = parameters(design, fundamental_scene(design))
    changed = [key for key in now if not key.startswith("scene.") and now[key] != known.get(key)]
    if changed:
        why = f"{changed[0]} is {now[changed[0]]} there and was {known.get(changed[0])}"
        raise ResultError(f"{folder / DESIGN} is not the design analysed: {why}; analyse it again")
    return design
