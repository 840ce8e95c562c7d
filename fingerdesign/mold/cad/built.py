"""The mold's CAD at work in a process of its own: from a plan to triangles and files.

The kernel is native code that can hang or crash; it runs under a time limit where it can harm
nobody. Importing this module loads no CAD kernel.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import TypeAdapter

from fingerdesign.errors import DesignError, GeometryError
from fingerdesign.mold.part import MoldMeshes
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.records.result import ResultError
from fingerdesign.runtime.files import keep_request
from fingerdesign.runtime.isolate import ProcessError, call

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

TIME_LIMIT_S = 60.0  # the shipped designs take 3 to 6 s


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
    build, name = "fingerdesign.mold.cad.meshed:build_and_write", design.design.name
    try:
        found: MoldMeshes = call(build, design, plan, target, time_s=time_limit_s)
    except DesignError as error:
        raise GeometryError(str(error)) from error
    except ProcessError as error:
        if error.machine:
            raise ResultError(
                f"the mold of {name} was not built: {error}; free disk and memory and try again"
            ) from error
        request = {
            "design": design.model_dump(mode="json"),
            "plan": TypeAdapter(MoldPlan).dump_python(plan, mode="json"),
            "folder": str(target),
        }
        kept = keep_request("mold", "request.json", json.dumps(request))
        raise GeometryError(
            f"the CAD kernel did not build the mold of {name}: {error}; the request is kept as "
            f"{kept}"
        ) from error
    return found
