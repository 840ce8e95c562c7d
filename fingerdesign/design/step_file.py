"""``[body.step]`` when a design is read: where the file lies, and the sizes of its solid."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fingerdesign.design.body import StepFile
from fingerdesign.design.mesh import mesh_file_digest
from fingerdesign.design.step import content_of, step_facts
from fingerdesign.errors import DesignError, Fault

LEAST_BASE_HEIGHT_MM = 0.5  # that of every body; a contact surface may run down to the base


SAME_MM = 1e-6  # a size given beside the file is its solid's: a design written out and read again


@dataclass(frozen=True)
class Resolved:
    """A design's table with the file's whereabouts and sizes filled in.

    ``faults`` say why the file will not do, or which sizes stand in the design too.
    """

    data: dict[str, Any]
    faults: tuple[Fault, ...] = ()


def resolved(data: Mapping[str, Any], folder: Path | str | None = None) -> Resolved:
    """Resolve ``[body.step]`` of a design's raw table; ``folder``: the design file's, else here.

    The file is read only where every key of [body.step] is sound.
    """
    out = deepcopy(dict(data))
    body = out.get("body")
    if not isinstance(body, dict) or body.get("shape") != "step":
        return Resolved(out)
    table = body.get("step")
    if not isinstance(table, dict) or not isinstance(table.get("file"), str) or not table["file"]:
        return Resolved(out)
    home = Path.cwd() if folder is None else Path(folder)
    table["file"] = str((home / table["file"]).absolute())
    try:
        sizes = step_sizes(StepFile.model_validate(table))
    except ValidationError:  # its keys are judged with all others
        return Resolved(out)
    except DesignError as error:
        return Resolved(out, error.faults)
    faults = []
    for key, value in sizes.items():
        given = body.get(key)
        same = isinstance(given, (int, float)) and abs(given - value) <= SAME_MM
        if given is not None and not same:
            bound = f"absent where body.shape = 'step' (the file's solid has {value:.6g})"
            faults.append(Fault(f"body.{key}", given, bound, "remove it: the file says it"))
        body[key] = value
    return Resolved(out, tuple(faults))


def step_sizes(step: Any) -> dict[str, float]:
    """The sizes of a [body] that a STEP solid decides, mm: extents along x and z, the least height
    of its contact surface. DesignError where the file or its rules will not do."""
    facts = step_facts(step)
    return {
        "width_mm": round(facts.high[0] - facts.low[0], 9),
        "depth_mm": round(facts.high[2] - facts.low[2], 9),
        "base_height_mm": round(max(facts.lowest, LEAST_BASE_HEIGHT_MM), 9),
    }


def without_sizes(data: Mapping[str, Any]) -> dict[str, Any]:
    """A design's table without the sizes that its STEP file decides: for changing the file."""
    out = deepcopy(dict(data))
    body = out.get("body")
    if isinstance(body, dict) and body.get("shape") == "step":
        for key in ("width_mm", "depth_mm", "base_height_mm"):
            body.pop(key, None)
    return out


def portable(parameters: Mapping[str, object]) -> dict[str, object]:
    """Dotted parameters of a design for records: files by their name and content, not by their
    place on this machine."""
    out = dict(parameters)
    for key, digest in (("body.step", content_of), ("mesh", mesh_file_digest)):
        file = out.get(f"{key}.file")
        if isinstance(file, str):
            out[f"{key}.file"] = Path(file).name
            try:
                out[f"{key}.content"] = digest(file)
            except DesignError:
                out[f"{key}.content"] = "absent"
    return out
