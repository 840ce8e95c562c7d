"""The mold's CAD at work in a process of its own: from a plan to triangles and files.

The kernel is native code that can hang or crash; it runs under a time limit where it can harm
nobody. Importing this module loads no CAD kernel.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import TypeAdapter

from fingerdesign.errors import GeometryError
from fingerdesign.mold.part import MoldMeshes, PartMesh
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.records.result import ResultError
from fingerdesign.runtime.process import ProcessError, machine_failed, run_module

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

WORKER = "fingerdesign.mold.cad.worker"
TIME_LIMIT_S = 60.0  # the shipped designs take 3 to 6 s
_ARRAYS = ("vertices", "triangles", "blank_vertices", "blank_triangles")


def mold_meshes(
    design: Design, plan: MoldPlan, folder: Path | str, time_limit_s: float = TIME_LIMIT_S
) -> MoldMeshes:
    """Build a planned mold in a process of its own, and write its CAD files into ``folder``.

    Files, in mold coordinates: NAME.stl and NAME.step of every part and of every different plate,
    and assembly.step. GeometryError where a part could not be drawn off or built, or where the
    kernel crashes or exceeds the time limit; then the request is kept, and the message says where.
    ResultError where the disk or the memory is full, or somebody ended the process.
    """
    target = Path(folder).resolve()
    target.mkdir(parents=True, exist_ok=True)
    home = Path(tempfile.mkdtemp(prefix="fingerdesign-mold-"))
    request = {
        "design": design.model_dump(mode="json"),
        "plan": TypeAdapter(MoldPlan).dump_python(plan, mode="json"),
        "folder": str(target),
    }
    try:
        (home / "request.json").write_text(json.dumps(request), "utf-8")
        run_module(WORKER, [str(home)], home, time_limit_s)
        refused = home / "error.txt"
        if refused.exists():
            raise GeometryError(refused.read_text("utf-8"))
        meshes = load_meshes(home)
    except ProcessError as error:
        if machine_failed(error):
            shutil.rmtree(home, ignore_errors=True)
            raise ResultError(
                f"the mold of {design.design.name} was not built: {error}; free disk and memory "
                "and try again"
            ) from error
        # the request stays for whoever looks into it
        raise GeometryError(
            f"the CAD kernel did not build the mold of {design.design.name}: {error}; the request "
            f"is kept as {home / 'request.json'}"
        ) from error
    except BaseException:
        shutil.rmtree(home, ignore_errors=True)
        raise
    shutil.rmtree(home, ignore_errors=True)
    return meshes


def plan_from(data: Any) -> MoldPlan:
    """A plan from its fields, as a request holds them."""
    return TypeAdapter(MoldPlan).validate_python(data)


def save_meshes(meshes: MoldMeshes, folder: Path) -> None:
    """Write meshes.npz (the arrays) and meshes.json (all else) into a folder."""
    arrays: dict[str, Any] = {}

    def rest(mesh: PartMesh, key: str) -> dict[str, Any]:
        arrays.update({f"{key}_{name}": getattr(mesh, name) for name in _ARRAYS})
        others = (each.name for each in fields(PartMesh) if each.name not in _ARRAYS)
        return {"key": key, **{name: getattr(mesh, name) for name in others}}

    told = {
        "parts": [rest(mesh, f"part{k}") for k, mesh in enumerate(meshes.parts)],
        "plates": [rest(mesh, f"plate{k}") for k, mesh in enumerate(meshes.plates)],
        "rubber": rest(meshes.rubber, "rubber"),
        "outline": rest(meshes.outline, "outline"),
        "low": meshes.low,
        "high": meshes.high,
    }
    np.savez(folder / "meshes.npz", **arrays)
    (folder / "meshes.json").write_text(json.dumps(told), "utf-8")


def load_meshes(folder: Path) -> MoldMeshes:
    """What ``save_meshes`` wrote."""
    told = json.loads((folder / "meshes.json").read_text("utf-8"))
    with np.load(folder / "meshes.npz") as arrays:

        def mesh(told: dict[str, Any]) -> PartMesh:
            key, draw = told.pop("key"), told.pop("draw")
            found = {name: arrays[f"{key}_{name}"] for name in _ARRAYS}
            return PartMesh(draw=None if draw is None else tuple(draw), **told, **found)

        return MoldMeshes(
            tuple(mesh(each) for each in told["parts"]),
            tuple(mesh(each) for each in told["plates"]),
            mesh(told["rubber"]),
            mesh(told["outline"]),
            tuple(told["low"]),
            tuple(told["high"]),
        )
