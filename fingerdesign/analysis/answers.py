"""Answers of earlier runs: in a result's folder, and in the cache of this machine.

An answer is the whole folder of a result. It is cached under the digest of all that decides its
numbers: design, scene, fidelity, the program's own code and the versions of what it computes with.
Light to import.
"""

import hashlib
import json
from pathlib import Path
from typing import Any

from fingerdesign.analysis.case import Case, result_digest
from fingerdesign.design.schema import Gages
from fingerdesign.layout.frames import Hole, PlateFrame
from fingerdesign.mesh.types import Mesh
from fingerdesign.records.arrays import (
    ContactHistory,
    FieldHistory,
    GripTrace,
    SlipStudy,
    read_packed,
)
from fingerdesign.records.result import Result
from fingerdesign.records.result_files import RESULTS, read_result
from fingerdesign.runtime.cache import Cache, code_digest
from fingerdesign.runtime.registry import has_plugins
from fingerdesign.version import versions

PAGE, ARRAYS, DESIGN, CAD = "report.html", "arrays.npz", "design.toml", "finger.step"
_CAD = (".step", ".stl")
_KINDS = (ContactHistory, FieldHistory, GripTrace, SlipStudy, Mesh, Gages, Hole, PlateFrame)
_HOME = Path(__file__).resolve().parents[1]
_MOST = 30  # answers; one in 3-D takes 10 to 20 MB


def read_arrays(folder: Path) -> dict[str, Any]:
    """The arrays of an analysis by the names of ``Analysis``, from its folder; {} where it holds
    none. ResultError where they are not what was written."""
    path = folder / ARRAYS
    return dict(read_packed(path, *_KINDS)) if path.is_file() else {}


def requested_products(case: Case, page: bool | None, cad: bool | None) -> tuple[bool, bool]:
    """Decide whether page and CAD files are written; by default (None) except in plane strain,
    where they take longer than the work."""
    page, cad = (case.fidelity != "plane-strain" if each is None else each for each in (page, cad))
    return page, cad


def missing(case: Case, out: Path, page: bool | None, cad: bool | None) -> tuple[bool, bool]:
    """Decide whether page and CAD files are to be written, and not in OUT/NAME."""
    folder = out / case.design.design.name
    page, cad = requested_products(case, page, cad)
    return page and not (folder / PAGE).exists(), cad and not (folder / CAD).exists()


def is_cached(case: Case) -> bool:
    """True if the case's answer is cached."""
    key = _key(case)
    return key is not None and _answers().path(key).is_file()


def cache_answer(case: Case, folder: Path, result: Result) -> None:
    """Store the files of a result's folder, unless it failed. A cache that cannot be written is
    no fault."""
    key = _key(case)
    if key is not None and result.status == "ok":
        _answers().put_files(key, sorted(folder.iterdir()), packed=False)


def cached_answer(
    case: Case, out: Path, page: bool | None = None, cad: bool | None = None
) -> Result | None:
    """Write the cached answer as OUT/NAME, without page and CAD files that are not requested;
    None where there is none. ResultError where OUT will not do."""
    key = _key(case)
    if key is None or (contents := _answers().files(key)) is None:
        return None
    with_page, with_cad = requested_products(case, page, cad)
    with RESULTS.written(out / case.design.design.name) as folder:
        for name, content in contents.items():
            if with_cad if name.endswith(_CAD) else with_page or name != PAGE:
                (folder / name).write_bytes(content)
        return read_result(folder)


def _key(case: Case) -> str | None:
    """The name of the case's answer; None where it is not cached: what decides it is not all known.

    That is so with an estimator from a file, and with kinds from outside the package.
    """
    if case.estimator is not None or has_plugins():
        return None
    digest = result_digest(case.design, case.path_scene, case.requested)
    wanted = (case.grips, case.fields, case.studied, case.for_page, case.mesh_error)
    path = (case.scene_name, case.scene is None, *wanted)
    parts = (digest, case.design.model_dump_json(), path, versions(), code_digest(_HOME))
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest() + ".zip"


def _answers() -> Cache:
    return Cache("answers", most=_MOST)
