"""Random designs of every body and plate kind, valid by construction, the same for the same seed.

A design is drawn from ``RANGES``, judged, and drawn again from the same generator until it is
sound. Kinds go with the seed, so that of any 200 in a row each is at least a tenth.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from pydantic import BaseModel

from fingerdesign.design.body import Body, Core
from fingerdesign.design.faults import set_value
from fingerdesign.design.grip import Grip
from fingerdesign.design.mesh import MeshOptions, SectionMesh
from fingerdesign.design.plates import Plates, Row
from fingerdesign.design.schema import Gages, Material
from fingerdesign.errors import FingerDesignError

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


def drawn(name: str, chance: Generator, wanted: tuple[str, ...]) -> Data:
    """A valid design of the kinds ``wanted``, from what ``chance`` yields."""
    for draw in range(MOST_DRAWS):
        if wanted[0] != "step" or draw % _DRAWS_OF_A_STEP_BODY == 0:
            body, height = _body(chance, wanted)
        data: Data = {"design": {"name": name}, "body": body}
        data["plates"] = _plates(chance, wanted, height)
        width = _width(body)
        data["gages"] = {"length_mm": 0.5, "width_mm": 0.5}
        data["mesh"] = {
            "contact_size_mm": round(_share(chance, "mesh.contact_size_mm / width_mm", width), 2),
            "plate_size_mm": round(_share(chance, "mesh.contact_size_mm / width_mm", width), 2),
            "far_size_mm": round(_share(chance, "mesh.far_size_mm / width_mm", width), 2),
        }
        data["grip"] = {"max_approach_mm": 0.3}
        if _sound(data):
            return data
    raise FingerDesignError(f"no sound design of kinds {wanted} in {MOST_DRAWS} draws")


def _sound(data: Data) -> bool:
    from fingerdesign.checks.design import is_sound
    from fingerdesign.design.schema import Design
    from fingerdesign.design.step import resolved

    known, faults = resolved(data)
    return not faults and is_sound(Design.model_validate(known))


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


def _body(chance: Generator, wanted: tuple[str, ...]) -> tuple[Data, float]:
    """A [body], and about how high its crest is."""
    shape = wanted[0]
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
    if "edged" in wanted:
        body["edge_radius_mm"] = _draw(chance, "body.edge_radius_mm")
        body["edge"] = "round" if chance.random() < 0.5 else "chamfer"
    if "cored" in wanted:
        body["core"] = _core(chance, shape, width, depth, base)
    return body, base


def _core(chance: Generator, shape: str, width: float, depth: float, base: float) -> Data:
    """A bone, or a backing that stands on the base; some of the full depth in a straight body."""
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
    from fingerdesign_bench.any_finger.step_samples import SHAPES, sample_step

    shape = str(chance.choice(list(SHAPES)))
    crown = _draw(chance, "crown of a STEP body, mm", 1)
    # Sizes in steps, so that a body drawn again is one that was made before.
    x, z, y = (float(2.0 * round(0.5 * size)) for size in (width, depth, base))
    crown = max(round(2.0 * crown) / 2.0, 0.5)
    file = sample_step(shape, x, z, y, crown)
    step: Data = {"file": str(file), "mirrors_in_z": bool(chance.random() < 0.7)}
    return {"shape": "step", "step": step}, y - crown


def _plates(chance: Generator, wanted: tuple[str, ...], height: float) -> Data:
    kind, shape = wanted[-1], wanted[0]
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
    plates |= _of_kind(chance, kind, plates)
    return plates


def _of_kind(chance: Generator, kind: str, plates: Data) -> Data:
    """What makes plates of a kind out of level ones."""
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


# Valid random designs with one fault put in, and the key that must be named for it.
#
# ``FAULTS`` holds each kind of fault: which design it needs, and what it does to it. Values, types,
# words and unknown keys go over every table; geometry over every check.

Spoil = Callable[[Generator, Data], str]
TABLES: dict[str, type[BaseModel]] = {
    "body": Body,
    "body.core": Core,
    "plates": Plates,
    "plates.rows[0]": Row,
    "gages": Gages,
    "materials.silicone": Material,
    "mesh": MeshOptions,
    "mesh.section": SectionMesh,
    "grip": Grip,
}
LEVEL, ROWS = ("arc", "level"), ("arc", "two_rows")


def invalid_design(seed: int) -> tuple[Data, str]:
    """A design's TOML data with one fault, and the dotted key that must be named for it."""
    chance = np.random.default_rng([20261121, seed])
    wanted, spoil = FAULTS[seed % len(FAULTS)]
    data = drawn(f"invalid_{seed:03d}", chance, wanted)
    return data, spoil(chance, data)


def _set(key: str, value: object, blamed: str = "", **others: object) -> Spoil:
    """Set ``key``, and plates' keys ``others`` that make it a fault; ``blamed``: if another."""

    def spoil(chance: Generator, data: Data) -> str:
        for name, other in others.items():
            set_value(data, f"plates.{name}", other)
        set_value(data, key, value)
        return blamed or key

    return spoil


def _numbers(model: type[BaseModel]) -> Iterator[tuple[str, float | None, float | None]]:
    """The numeric keys of a table that have a bound, each with its least and greatest value."""
    for name, info in model.model_fields.items():
        low = high = None
        for rule in info.metadata:
            low = getattr(rule, "ge", getattr(rule, "gt", low))
            high = getattr(rule, "le", getattr(rule, "lt", high))
        if low is not None or high is not None:
            yield name, low, high


def _beyond(chance: Generator, data: Data) -> str:
    """A number below its least or above its greatest value, in any table."""
    table = str(chance.choice(list(TABLES)))
    name, low, high = list(_numbers(TABLES[table]))[
        int(chance.integers(len(list(_numbers(TABLES[table])))))
    ]
    if high is None or (low is not None and chance.random() < 0.5):
        value: float = (low or 0.0) - 1.0
    else:
        value = 2.0 * high + 1.0
    whole = name in ("count", "layers", "attempts", "max_steps", "seed")
    key = f"{table}.{name}"
    set_value(data, key, int(value) if whole else value)
    return key


def _wrong_type(chance: Generator, data: Data) -> str:
    """Text, a truth value, an array or a table where a number belongs."""
    table = str(chance.choice(list(TABLES)))
    names = [name for name, *_ in _numbers(TABLES[table])]
    key = f"{table}.{chance.choice(names)}"
    value: list[Any] = ["2.0", True, [1.0], {"a": 1}]
    set_value(data, key, value[int(chance.integers(len(value)))])
    return key


def _not_finite(chance: Generator, data: Data) -> str:
    key = str(chance.choice(["body.width_mm", "plates.pitch_mm", "gages.z_mm", "grip.preload_mm"]))
    set_value(data, key, float("nan") if chance.random() < 0.5 else float("inf"))
    return key


def _misspelt(chance: Generator, data: Data) -> str:
    """A key of any table with two letters changed round."""
    table = str(chance.choice(list(TABLES)))
    names = [name for name in TABLES[table].model_fields if len(name) > 4]
    name = str(chance.choice(names))
    place = int(chance.integers(len(name) - 1))
    swapped = name[:place] + name[place + 1] + name[place] + name[place + 2 :]
    if swapped == name:
        swapped = f"{name}s"
    key = f"{table}.{swapped}"
    set_value(data, key, 1.0)
    return key


def _misplaced(chance: Generator, data: Data) -> str:
    key = str(chance.choice(["body.pitch_mm", "plates.width_mm", "gages.cover_mm", "grip.layers"]))
    set_value(data, key, 1.0)
    return key


def _word(chance: Generator, data: Data) -> str:
    """A word that is none of a key's choices."""
    choices = ["body.shape", "body.edge", "plates.along", "plates.follow", "plates.model"]
    choices += ["gages.face", "mesh.mesher", "mesh.element", "grip.controller"]
    key = str(chance.choice(choices))
    set_value(data, key, "slanted")
    return key


def _material(chance: Generator, data: Data) -> str:
    key = str(chance.choice(["body.material", "plates.material", "body.core.material"]))
    set_value(data, key, "unobtainium")
    return key


def _overlapping(chance: Generator, data: Data) -> str:
    """Upright plates closer than their own thickness."""
    plates = data["plates"] | {"count": 3, "angle_deg": 90.0, "offset_mm": 0.0}
    data["plates"] = plates | {"pitch_mm": round(0.9 * plates["thickness_mm"], 4)}
    return "plates.pitch_mm"


def _twice(chance: Generator, data: Data) -> str:
    """Two plates at one place."""
    place = [0.0, round(0.5 * data["body"]["base_height_mm"], 2), 0.0]
    data["plates"] = {"thickness_mm": 0.2, "length_mm": 1.0, "placement": [place, place]}
    return "plates.placement[1]"


def _wide_row(chance: Generator, data: Data) -> str:
    """A further row that is wider than the body."""
    data["plates"]["rows"][0] |= {"count": 3, "pitch_mm": 100.0}
    return "plates.rows[0].pitch_mm"


def _outside(chance: Generator, data: Data) -> str:
    """A plate placed above, below or beside the body."""
    height = 0.5 * data["body"]["base_height_mm"]
    places = [[0.0, 60.0, 10.0], [0.0, 0.01, 10.0], [data["body"]["width_mm"], height, 10.0]]
    place = places[int(chance.integers(3))]
    data["plates"] = {"thickness_mm": 0.2, "length_mm": 1.0, "placement": [place]}
    return "plates.placement[0]"


def _too_wide(chance: Generator, data: Data) -> str:
    """A gage wider than its plate."""
    data["gages"]["width_mm"] = float(data["body"].get("depth_mm", 0.0)) + 1.0
    return "gages.width_mm"


def _in_the_core(chance: Generator, data: Data) -> str:
    """A core that reaches up into the plates."""
    body, plates = data["body"], data["plates"]
    plates |= {"count": 1, "angle_deg": 0.0, "offset_mm": 0.0, "cover_mm": 1.0}
    radius, half = body["arc_radius_mm"], 0.5 * body["width_mm"]
    crest = body["base_height_mm"] + radius - float(np.sqrt(radius**2 - half**2))
    body["core"] = {"width_mm": 1.0, "height_mm": round(crest - 1.0, 2), "material": "abs"}
    return "plates.cover_mm"


def _small_arc(chance: Generator, data: Data) -> str:
    data["body"]["arc_radius_mm"] = round(0.45 * data["body"]["width_mm"], 2)
    return "body.arc_radius_mm"


def _deep_dome(chance: Generator, data: Data) -> str:
    data["body"]["dome_radius_mm"] = round(0.4 * data["body"]["depth_mm"], 2)
    return "body.dome_radius_mm"


def _step_key(key: str, value: object) -> Spoil:
    def spoil(chance: Generator, data: Data) -> str:
        from fingerdesign_bench.any_finger.step_samples import sample_step

        file = str(sample_step("filleted", 16.0, 12.0, 10.0, 1.5))
        data["body"] = {"shape": "step", "step": {"file": file}}
        set_value(data, key, value)
        return key

    return spoil


_BODY: list[tuple[tuple[str, ...], Spoil]] = [
    (("arc", "level"), _small_arc),
    (("revolved", "none"), _small_arc),
    (("dome", "finite"), _deep_dome),
    (("dome", "none"), _set("body.dome_radius_mm", None)),
    (("arc", "none"), _set("body.dome_radius_mm", 20.0)),
    (("block", "none"), _set("body.arc_radius_mm", 30.0)),
    (("revolved", "none"), _set("body.depth_mm", 3.0)),
    (("block", "none"), _set("body.edge_radius_mm", 60.0)),
    (("arc", "none"), _set("body.edge_radius_mm", 60.0)),
    (("arc", "none"), _set("body.edge", "chamfer")),
    (("arc", "none"), _set("body.core.width_mm", 60.0)),
    (("dome", "none"), _set("body.core.depth_mm", 60.0)),
    (("block", "none"), _set("body.core.height_mm", 60.0)),
    (("arc", "none"), _set("body.core.bottom_mm", 0.05)),
    (("arc", "level"), _in_the_core),
    (("arc", "none"), _set("body.step.file", "mine.step")),
    (("arc", "none"), _step_key("body.step.file", "no_such.step")),
    (("arc", "none"), _step_key("body.step.contact_above_mm", 100.0)),
    (("arc", "none"), _step_key("body.step.base_direction", [0.0, 1.0, 1.0])),
    (("arc", "none"), _step_key("body.width_mm", 3.0)),
    (("arc", "none"), _step_key("body.edge_radius_mm", 1.0)),
]
_PLATES: list[tuple[tuple[str, ...], Spoil]] = [
    (LEVEL, _set("plates.cover_mm", 0.05, angle_deg=80.0, offset_mm=0.0, count=1)),
    (("block", "level"), _set("plates.cover_mm", 50.0)),
    (("revolved", "finite"), _set("plates.cover_mm", 0.01, angle_deg=60.0)),
    (LEVEL, _set("plates.pitch_mm", 30.0, count=3)),
    (LEVEL, _overlapping),
    (("block", "turned"), _overlapping),
    (LEVEL, _set("plates.offset_mm", 30.0)),
    (LEVEL, _set("plates.length_mm", 0.3, thickness_mm=0.2)),
    (("arc", "finite"), _set("plates.span_mm", 100.0)),
    (("revolved", "finite"), _set("plates.span_mm", 100.0)),
    (("arc", "finite"), _set("plates.span_offset_mm", 40.0, span_mm=2.0)),
    (("arc", "staggered"), _set("plates.stagger_mm", 60.0, span_mm=2.0, span_offset_mm=0.0)),
    (("arc", "along_z"), _set("plates.pitch_mm", 30.0, count=3)),
    (("arc", "along_z"), _set("plates.span_mm", 100.0)),
    (("arc", "bent"), _set("plates.angle_deg", 30.0)),
    (("arc", "bent"), _set("plates.cover_mm", 400.0)),
    (("arc", "perforated"), _set("plates.hole_diameter_mm", 20.0)),
    (("arc", "perforated"), _set("plates.hole_pitch_mm", 0.2)),
    (LEVEL, _set("plates.hole_pitch_mm", 3.0)),
    (ROWS, _set("plates.rows[0].cover_mm", 300.0)),
    (ROWS, _set("plates.rows[0].cover_mm", None)),
    (ROWS, _set("plates.rows[0].length_mm", 0.1, thickness_mm=0.1)),
    (ROWS, _wide_row),
    (ROWS, _set("plates.rows[0].colour", "red")),
    (LEVEL, _twice),
    (("dome", "none"), _outside),
    (LEVEL, _set("plates.placement", [[0.0, 5.0]], "plates.placement[0]")),
    (LEVEL, _set("plates.placement", [[0.0, 5.0, 0.0]], "plates.follow", follow="turned")),
    (ROWS, _set("plates.placement", [[0.0, 5.0, 0.0]], "plates.rows")),
]
_OTHERS: list[tuple[tuple[str, ...], Spoil]] = [
    (LEVEL, _set("gages.length_mm", 150.0)),
    (("arc", "level"), _too_wide),
    (LEVEL, _set("gages.z_mm", 100.0)),
    (("dome", "finite"), _set("mesh.mesher", "extrude")),
    (("arc", "none"), _set("mesh.contact_size_mm", 20.0)),
    (("arc", "none"), _set("mesh.section.contact_size_mm", 20.0)),
    (("arc", "none"), _set("mesh.mesher", "file", "mesh.file")),
    (("arc", "none"), _set("mesh.file", "finger.msh")),
    (("arc", "sheet"), _set("mesh.element", "P1")),
    (("arc", "sheet"), _set("plates.hole_diameter_mm", 0.3, "plates.model", span_mm=3.0)),
    (("block", "none"), _set("grip.preload_mm", 0.5)),
    (("block", "none"), _set("grip.max_approach_mm", 20.0)),
    (("arc", "none"), _set("assumed", ["body.wdith_mm"], "assumed[0]")),
    (("arc", "none"), _set("design.name", "a/b")),
    (("arc", "none"), _set("mold.wall_mm", 0.2)),
    (("arc", "none"), _set("plate", {"count": 3})),
    (("arc", "none"), _set("body", 3)),
    (
        ("arc", "none"),
        _set("materials.mine", {"poissons_ratio": 0.3}, "materials.mine.youngs_modulus_MPa"),
    ),
]
# Kinds of keys and values, each over all tables and so with more seeds than one.
_ANY: list[tuple[tuple[str, ...], Spoil]] = [
    (("arc", "two_rows"), _beyond),
    (("dome", "two_rows"), _beyond),
    (("block", "two_rows"), _beyond),
    (("arc", "two_rows"), _wrong_type),
    (("block", "two_rows"), _wrong_type),
    (("arc", "two_rows"), _misspelt),
    (("dome", "two_rows"), _misspelt),
    (("block", "two_rows"), _misplaced),
    (("arc", "level"), _not_finite),
    (("block", "level"), _word),
    (("arc", "level"), _material),
]
FAULTS: tuple[tuple[tuple[str, ...], Spoil], ...] = (*_BODY, *_ANY, *_PLATES, *_ANY, *_OTHERS)
