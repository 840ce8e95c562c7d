"""Content digests: the same for two files that mean the same."""

import hashlib
import json
from typing import Any

from pydantic import BaseModel

from fingerdesign.design.former import FIRST_NAMES
from fingerdesign.design.mesh import MeshOptions, mesh_file_digest
from fingerdesign.design.step import content_of
from fingerdesign.runtime.registry import CONTROLLERS, is_reference

# What no analysis depends on: how it is cast; where the grip's values, which count, come from.
UNSEEN: Any = {"mold": True, "grip": {"defaults"}}
# Keys that came after digests were first written down; their defaults leave digests as they were.
_LATER_ZERO = (
    *("transverse_sensitivity", "gage_noise_microvolt_per_V", "gage_cross_talk", "warming_K"),
    *("warming_microstrain", "force_gain_spread", "force_cross_talk", "relaxation_per_minute"),
    *("actuator_lag_s", "off_centre_mm"),
)
LATER: dict[str, Any] = {
    **dict.fromkeys(_LATER_ZERO, 0.0),
    **dict.fromkeys(("alternate", "inertia"), False),
    **dict.fromkeys(("expansion_per_K", "torque_noise_Nmm")),
    "dying_gages": [],
    "rubber_memory": [],
    "grid": "axial",
    "excitation_V": 2.5,
    "area_share": 0.5,
    "taught_fingers": 120,
    "probe_force_N": 1.5,
    "layer_growth": 1.15,
    "dying_after_s": 0.1,
    "warming_time_s": 3.0,
    "warning_stick_ratio": 0.3,
    "kinetic_share": 1.0,
    "warming_s": 60.0,
    "drop_mm": 10.0,
}
# The default of this key changed. Its digest is that of the former default, and the other way
# round: a design without the key has the digest that it always had.
_CHANGED, _DIGEST_OF = "taught_grips", {7200: 12_000, 12_000: 7200}


def content_digest(model: BaseModel) -> str:
    """SHA-256, in hexadecimal, of a validated model's values.

    Comments, formatting, key order, defaults left out or written, and whole numbers written as
    integers or floats make no difference; any value that differs does. The class's name is part
    of it, so a design and a scene never share a digest. Files count by their content, wherever they
    lie. How a finger is cast is left out: no analysis depends on it. DesignError where a STEP file
    cannot be read.
    """
    values = _plain(model.model_dump(mode="json", exclude=UNSEEN))
    if isinstance(model, MeshOptions):  # by itself, as keys of cached work take it
        values = _by_content({"mesh": values})["mesh"]
    content = {"kind": type(model).__name__, "values": _by_content(values)}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _by_content(values: dict[str, Any]) -> dict[str, Any]:
    """Put the digest of a file's content in the place of its path, wherever a table names one, and
    behind the name of a controller's class."""
    out = {key: _by_content(v) if isinstance(v, dict) else v for key, v in values.items()}
    step, mesh = out.get("step"), out.get("mesh")
    if isinstance(step, dict) and "file" in step:
        step["file"] = content_of(step["file"])
    if isinstance(mesh, dict) and "file" in mesh:
        mesh["file"] = mesh_file_digest(mesh["file"])
    hand: Any = out.get("controller")
    if is_reference(hand):
        out["controller"] = [hand, CONTROLLERS.content_of(hand)]
    return out


def _plain(value: Any) -> Any:
    """Drop absent keys and later ones at their defaults; make -0.0 the 0.0 that it equals."""
    if isinstance(value, dict):
        given = {FIRST_NAMES.get(k, k): item for k, item in value.items() if item is not None}
        if _CHANGED in given:
            given[_CHANGED] = _DIGEST_OF.get(given[_CHANGED], given[_CHANGED])
        return {k: _plain(v) for k, v in given.items() if k not in LATER or v != LATER[k]}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value + 0.0
    return value
