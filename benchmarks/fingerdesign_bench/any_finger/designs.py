"""Random designs of every body and plate kind, valid by construction, the same for the same seed.

A design is drawn from ``RANGES``, judged, and drawn again from the same generator until it is
sound. Kinds go with the seed, so that of any 200 in a row each is at least a tenth.
"""

from typing import Any

import numpy as np
import tomlkit

from fingerdesign.checks.design import is_sound
from fingerdesign.checks.load import parse_design
from fingerdesign.design.schema import Design
from fingerdesign.design.step import resolved
from fingerdesign.errors import FingerDesignError
from fingerdesign_bench.any_finger.step_samples import SHAPES, sample_step

Data = dict[str, Any]
Generator = np.random.Generator

BODIES = ("arc", "dome", "revolved", "block", "step")
PLATES = (
    *("level", "turned", "bent", "along_z", "finite"),
    *("staggered", "two_rows", "perforated", "sheet", "none"),
)
# Uniform; mm, degrees; "x / y" are shares of another length. Plates on the whole small and few, so
# that a mesh takes seconds.
RANGES: dict[str, tuple[float, float]] = {
    "body.width_mm": (8.0, 20.0),
    "body.depth_mm": (6.0, 14.0),
    "body.base_height_mm": (5.0, 10.0),
    "body.arc_radius_mm / width_mm": (0.6, 2.0),
    "body.dome_radius_mm / depth_mm": (0.9, 2.5),
    "body.edge_radius_mm": (0.4, 2.0),
    "body.core.width_mm / width_mm": (0.3, 0.6),
    "body.core.depth_mm / depth_mm": (0.4, 0.7),
    "body.core.height_mm / base_height_mm": (0.15, 0.35),
    "body.core.bottom_mm": (0.5, 1.5),
    "crown of a STEP body, mm": (0.6, 2.5),
    "plates.count": (1, 7),
    "plates.thickness_mm": (0.1, 0.5),
    "plates.length_mm": (1.0, 3.0),
    "plates.angle_deg": (-90.0, 90.0),
    "plates.pitch_mm": (0.7, 3.0),
    "plates.cover_mm": (0.7, 4.0),
    "plates.offset_mm": (-1.5, 1.5),
    "plates.span_mm / depth_mm": (0.35, 0.8),
    "plates.span_offset_mm": (-1.0, 1.0),
    "plates.stagger_mm": (0.5, 2.0),
    "plates.rows.cover_mm - cover_mm": (0.8, 3.0),
    "plates.hole_diameter_mm": (0.4, 0.9),
    "plates.hole_pitch_mm": (1.5, 2.5),
    "mesh.contact_size_mm / width_mm": (0.05, 0.08),
    "mesh.far_size_mm / width_mm": (0.15, 0.25),
}
MOST_DRAWS = 3000
_DRAWS_OF_A_STEP_BODY = 150  # of its plates: it takes seconds to make


def kinds(seed: int) -> tuple[str, ...]:
    """The kinds of the design ``seed``: its body, "edged", "cored", and its plates.

    "none": no plate, or plates left out of the model.
    """
    body = BODIES[seed % 5]
    plates = PLATES[(seed + seed // 10) % 10]
    edged = ("edged",) if body != "step" and (seed // 5) % 3 == 0 else ()
    cored = ("cored",) if (seed // 5) % 4 == 1 else ()
    return (body, *edged, *cored, plates)


def random_design(seed: int) -> Data:
    """A valid design's TOML data; raises FingerDesignError where none was found (it is tested).

    That of a STEP body names a file that is made on demand, in the cache folder, with CadQuery.
    """
    return drawn(f"any_{seed:03d}", np.random.default_rng([20261120, seed]), kinds(seed))


def parsed_design(seed: int) -> Design:
    """The same as a design."""
    return parse_design(tomlkit.dumps(random_design(seed)))


def drawn(name: str, chance: Generator, chosen: tuple[str, ...]) -> Data:
    """A valid design of the kinds ``chosen``, from what ``chance`` yields."""
    for draw in range(MOST_DRAWS):
        if chosen[0] != "step" or draw % _DRAWS_OF_A_STEP_BODY == 0:
            body, height = _body(chance, chosen)
        data: Data = {"design": {"name": name}, "body": body}
        data["plates"] = _plates(chance, chosen, height)
        width = _width(body)
        data["gages"] = {"length_mm": 0.5, "width_mm": 0.5}
        data["mesh"] = {
            "contact_size_mm": _share(chance, "mesh.contact_size_mm / width_mm", width),
            "plate_size_mm": _share(chance, "mesh.contact_size_mm / width_mm", width),
            "far_size_mm": _share(chance, "mesh.far_size_mm / width_mm", width),
        }
        data["grip"] = {"max_approach_mm": 0.3}
        known, faults = resolved(data)
        if not faults and is_sound(Design.model_validate(known)):
            return data
    raise FingerDesignError(f"no sound design of kinds {chosen} in {MOST_DRAWS} draws")


def _draw(chance: Generator, key: str, digits: int = 2) -> float:
    return round(float(chance.uniform(*RANGES[key])), digits)


def _share(chance: Generator, key: str, of: float) -> float:
    return round(float(chance.uniform(*RANGES[key])) * of, 2)


def _width(body: Data) -> float:
    """The smaller extent of a body, mm."""
    if body["shape"] == "step":
        width, depth = body["step"]["file"].split("-")[-4:-2]
        return min(float(width), float(depth))
    return float(min(body["width_mm"], body.get("depth_mm", body["width_mm"])))


def _body(chance: Generator, chosen: tuple[str, ...]) -> tuple[Data, float]:
    """A [body], and about how high its crest is."""
    shape = chosen[0]
    width, depth = _draw(chance, "body.width_mm", 1), _draw(chance, "body.depth_mm", 1)
    base = _draw(chance, "body.base_height_mm", 1)
    body: Data = {"shape": shape}
    if shape == "step":
        body, base = _step_body(chance, width, depth, base)
    else:
        body |= {"width_mm": width, "base_height_mm": base}
        if shape != "revolved":
            body["depth_mm"] = depth
        if shape != "block":
            body["arc_radius_mm"] = _share(chance, "body.arc_radius_mm / width_mm", width)
        if shape == "dome":
            body["dome_radius_mm"] = _share(chance, "body.dome_radius_mm / depth_mm", depth)
    if "edged" in chosen:
        body["edge_radius_mm"] = _draw(chance, "body.edge_radius_mm")
        body["edge"] = "round" if chance.random() < 0.5 else "chamfer"
    if "cored" in chosen:
        body["core"] = _core(chance, shape, width, depth, base)
    return body, base


def _core(chance: Generator, shape: str, width: float, depth: float, base: float) -> Data:
    """A bone, or a backing on the base; some of the full depth in a straight body."""
    core: Data = {
        "width_mm": _share(chance, "body.core.width_mm / width_mm", width),
        "height_mm": _share(chance, "body.core.height_mm / base_height_mm", base),
        "material": "abs" if chance.random() < 0.5 else "aluminium",
    }
    if shape not in ("arc", "block") or chance.random() < 0.5:
        deep = width if shape == "revolved" else depth
        core["depth_mm"] = _share(chance, "body.core.depth_mm / depth_mm", deep)
    if chance.random() < 0.5:
        core["bottom_mm"] = _draw(chance, "body.core.bottom_mm")
    return core


def _step_body(chance: Generator, width: float, depth: float, base: float) -> tuple[Data, float]:
    """A [body] of a sample STEP file; its sizes are the file's."""
    shape = str(chance.choice(list(SHAPES)))
    crown = _draw(chance, "crown of a STEP body, mm", 1)
    # Sizes in steps, so that a body drawn again is one that was made before.
    x, z, y = (float(2.0 * round(0.5 * size)) for size in (width, depth, base))
    crown = max(round(2.0 * crown) / 2.0, 0.5)
    file = sample_step(shape, x, z, y, crown)
    step: Data = {"file": str(file), "mirrors_in_z": bool(chance.random() < 0.7)}
    return {"shape": "step", "step": step}, y - crown


def _plates(chance: Generator, chosen: tuple[str, ...], height: float) -> Data:
    kind, shape = chosen[-1], chosen[0]
    if kind == "none" and chance.random() < 0.5:
        return {"count": 0}
    low, high = RANGES["plates.count"]
    plates: Data = {
        "count": int(chance.integers(int(low), int(high) + 1)),
        "thickness_mm": _draw(chance, "plates.thickness_mm"),
        "length_mm": _draw(chance, "plates.length_mm"),
        "angle_deg": _draw(chance, "plates.angle_deg", 0),
        "pitch_mm": _draw(chance, "plates.pitch_mm"),
        "cover_mm": min(_draw(chance, "plates.cover_mm"), round(0.7 * height, 2)),
        "offset_mm": _draw(chance, "plates.offset_mm") if chance.random() < 0.3 else 0.0,
    }
    finite = ("finite", "staggered", "along_z", "two_rows", "perforated")
    if kind in finite or shape in ("revolved", "step") or chance.random() < 0.3:
        plates["span_mm"] = max(_share(chance, "plates.span_mm / depth_mm", 10.0), 1.0)
    return plates | _of_kind(chance, kind, plates)


def _of_kind(chance: Generator, kind: str, plates: Data) -> Data:
    """Keys that make plates of a kind out of level ones."""
    if kind == "turned":
        return {"follow": "turned"}
    if kind == "bent":
        return {"follow": "bent", "angle_deg": 0.0}
    if kind == "along_z":
        return {"along": "z"}
    if kind == "finite" and chance.random() < 0.5:
        return {"span_offset_mm": _draw(chance, "plates.span_offset_mm")}
    if kind == "staggered":
        return {"stagger_mm": _draw(chance, "plates.stagger_mm"), "count": max(plates["count"], 2)}
    if kind == "two_rows":
        cover = plates["cover_mm"] + _draw(chance, "plates.rows.cover_mm - cover_mm")
        row: Data = {"cover_mm": round(cover, 2), "count": int(chance.integers(1, 4))}
        row["along"] = "z" if chance.random() < 0.6 else "x"
        return {"count": min(plates["count"], 4), "rows": [row]}
    if kind == "perforated":
        return {
            "hole_diameter_mm": _draw(chance, "plates.hole_diameter_mm"),
            "hole_pitch_mm": _draw(chance, "plates.hole_pitch_mm"),
        }
    if kind == "sheet":
        return {"model": "sheet", "thickness_mm": min(plates["thickness_mm"], 0.25)}
    return {"model": "none"} if kind == "none" else {}
