"""Starter files of designs and scenes: every key, its default and meaning; or a shipped one."""

import re
import textwrap
from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from importlib import resources
from typing import Any

from pydantic import BaseModel

from fingerdesign.design.base import OwnTable, described
from fingerdesign.design.faults import tables_in
from fingerdesign.design.io import judge_keys, parse_scene, parse_toml
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import shipped_text

SCHEMA_FILE = "design.schema.json"
_HEAD = f"""\
#:schema ./{SCHEMA_FILE}
# A finger design. Lengths in mm, moduli in MPa, angles in degrees. Keys left out take the values
# given here. `fingerdesign check FILE` names every fault at once.
# Axes: x tangential, y normal (base at y = 0, crest toward +y), z along the plates, middle z = 0.
"""
SCENE_SCHEMA_FILE = "scene.schema.json"
_SCENE_HEAD = f"""\
#:schema ./{SCENE_SCHEMA_FILE}
# A scene: the rigid object that touches the finger, the path it takes, where strain is read out.
# Lengths in mm, forces in N, angles in degrees. Keys left out take the values given here, but
# a path needs its rows. `fingerdesign check DESIGN --scene FILE` names every fault at once.
# Axes: x tangential, y normal (base at y = 0, crest toward +y), z along the plates, middle z = 0.
"""
_NONE: Mapping[str, Any] = {}
_SCENE_ROWS = ((0.05, 0.0), (0.1, 0.0), (0.1, 0.03), (0.1, 0.06), (0.1, 0.09))
_SCENE_EXAMPLES = {"radius_mm": 10.0, "increments_N": [[2.5, 0.0], [5.0, 0.0], [5.0, 1.0]]}
STUDY_FILE = "starter_study.toml"  # In data/, next to the schemas.
SHORT = {  # the keys of a first finger
    "body": ("width_mm", "base_height_mm", "arc_radius_mm", "depth_mm", "material"),
    "plates": (
        *("count", "pitch_mm", "thickness_mm", "length_mm"),
        *("angle_deg", "cover_mm", "material"),
    ),
    "grip": ("object_mass_g",),
}
_SHORT_HEAD = f"""\
#:schema ./{SCHEMA_FILE}
# A first finger in fifteen keys: an arc of rubber with plates that carry gages. Lengths in mm,
# moduli in MPa, angles in degrees. `fingerdesign view FILE` draws it, `fingerdesign check FILE`
# judges it; other keys take their defaults (`fingerdesign new --all
# other.toml` explains them).
"""


def starter_scene_text(source: str | None = None) -> str:
    """Return a commented scene file: a plane pressed and drawn, or a copy of a shipped scene.

    Without ``source`` it holds every key that a scene has, with its default and meaning. Raises
    :class:`DesignError` where ``source`` is unknown.
    """
    if source is not None:
        text = _with_schema(shipped_text(source, "scene"), SCENE_SCHEMA_FILE)
    else:
        scene = Scene.model_validate({"path": {"increments_mm": _SCENE_ROWS}})
        names = Scene.model_fields
        tables = [_table(name, getattr(scene, name), examples=_SCENE_EXAMPLES) for name in names]
        text = "\n".join([_SCENE_HEAD, *tables])
    parse_scene(text)
    return text


def starter_study_text(name: str, source: str | None = None) -> str:
    """Return a commented study file called ``name``; with ``source`` a copy of a shipped study.
    DesignError where ``source`` is unknown."""
    starter = resources.files("fingerdesign") / "data" / STUDY_FILE
    text = starter.read_text("utf-8") if source is None else shipped_text(source, "study")
    return _renamed(text, name)


def starter_short_text(name: str) -> str:
    """Return a design file called ``name`` with the fifteen keys of a first finger."""
    design = Design.model_validate({"design": {"name": name}})
    found = [_SHORT_HEAD, "[design]", f"name = {_toml(name)}", ""]
    for title, keys in SHORT.items():
        table = getattr(design, title)
        meanings = type(table).model_fields
        lines = [_line(key, getattr(table, key), described(meanings[key])) for key in keys]
        found += [f"[{title}]", *lines, ""]
    rubber = design.materials[design.body.material]
    meaning = described(type(rubber).model_fields["youngs_modulus_MPa"])
    line = _line("youngs_modulus_MPa", rubber.youngs_modulus_MPa, meaning)
    text = "\n".join([*found, f"[materials.{design.body.material}]", line, ""])
    judge_keys(Design, parse_toml(text)).sound("")
    return text


def _renamed(text: str, name: str) -> str:
    return re.sub(r'(?m)^name = ".*?"', f"name = {_toml(name)}", text, count=1)


def _with_schema(text: str, file: str) -> str:
    return re.sub(r"(?m)^#:schema .*$", f"#:schema ./{file}", text)


def starter_text(name: str, source: str | None = None) -> str:
    """Return a commented design file called ``name``.

    With ``source``, the shipped design of that name with its comments; without, every key that a
    design has, with its default and meaning. Raises :class:`DesignError` where ``name`` cannot
    name a result's folder or ``source`` is unknown.
    """
    if source is None:
        text = _all_keys(name)
    else:
        text = _with_schema(shipped_text(source), SCHEMA_FILE)
        first = f"# A copy of {source}. The comments are of that finger, as it stands.\n"
        text = first + _renamed(text, name)
    judge_keys(Design, parse_toml(text)).sound("")
    return text


def _all_keys(name: str) -> str:
    design = Design.model_validate({"design": {"name": name}})
    tops, tables = [], []
    for key, info in Design.model_fields.items():
        value = getattr(design, key)
        if key == "materials":
            # Without `source`: it would stay behind when the user changes the values.
            tables += [
                _table(f"materials.{known}", item, {"source"}) for known, item in value.items()
            ]
        elif hasattr(value, "model_fields_set"):
            tables.append(_table(key, value))
        else:
            tops.append(_line(key, value, info.description or ""))
    return "\n".join([_HEAD, *tops, "", *tables])


def _table(
    title: str,
    table: BaseModel,
    without: AbstractSet[str] = frozenset(),
    examples: Mapping[str, Any] = _NONE,
) -> str:
    """A table with every key; those that are absent stand as comments, by their examples."""
    lines, inner = [f"[{title}]"], []
    for key, info in type(table).model_fields.items():
        value, meaning = getattr(table, key), described(info)
        if key in without:
            continue
        if key in getattr(table, "FOLLOWING", ()):
            value = "auto"
        optional = next(iter(tables_in(info.annotation)), None)
        if hasattr(value, "model_fields_set"):
            inner.append(_table(f"{title}.{key}", value))
        elif optional is not None and value is None:
            inner.append(_example(f"{title}.{key}", optional, meaning))
        elif key in examples or value is None or (value == () and info.examples):
            shown = examples.get(key, info.examples[0] if info.examples else 0.0)
            lines.append(_line(key, shown, meaning, off="# "))
        else:
            lines.append(_line(key, value, meaning))
    return "\n".join([*lines, "", *inner])


def _example(title: str, table: type[BaseModel], meaning: str) -> str:
    """A table that is absent, every key commented out."""
    absent = "these values" if issubclass(table, OwnTable) else "none"
    lines = [f"# [{title}]   # {meaning}; absent: {absent}"]
    for key, info in table.model_fields.items():
        value = info.default
        if info.is_required() or value is None:
            value = info.examples[0] if info.examples else ""
        lines.append(_line(key, value, info.description or "", off="# "))
    return "\n".join([*lines, ""])


def _line(key: str, value: Any, meaning: str, off: str = "") -> str:
    pair = f"{off}{key} = {_toml(value)}"
    inline = f"{pair:<36} # {meaning}"
    if len(inline) <= 110:
        return inline
    above = textwrap.wrap(meaning, 98, break_on_hyphens=False)
    return "\n".join([*(f"# {line}" for line in above), pair])


def _toml(value: Any) -> str:
    import tomlkit

    if isinstance(value, (tuple, list)):
        value = [list(row) if isinstance(row, tuple) else row for row in value]
    if isinstance(value, list) and value and isinstance(value[0], dict):
        rows = [", ".join(f"{key} = {_toml(inner)}" for key, inner in row.items()) for row in value]
        return f"[{', '.join(f'{{ {row} }}' for row in rows)}]"
    text: str = tomlkit.item(value).as_string()
    return text
