"""A finger design: what a design file says, validated key by key (see checks.py for the geometry).

Lengths in mm, moduli in MPa, angles in degrees. Every key but ``design.name`` has a default.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from fingerdesign.design.base import Many, Table, refuse
from fingerdesign.design.grip import Grip
from fingerdesign.design.meshing import MeshOptions
from fingerdesign.design.tables import Body, Gages, Material, Meta, Plates
from fingerdesign.materials import MATERIALS

__all__ = ["Body", "Design", "Gages", "Material", "Meta", "Plates"]


class Design(Table):
    """A finger: everything that its model, CAD and molds need. Frozen; see :meth:`digest`."""

    design: Meta
    body: Body = Field(default_factory=Body)
    plates: Plates = Field(default_factory=Plates)
    gages: Gages = Field(default_factory=Gages)
    materials: dict[str, Material] = Field(
        default_factory=dict, description="by name; keys not given are the known material's"
    )
    mesh: MeshOptions = Field(default_factory=MeshOptions)
    grip: Grip = Field(default_factory=Grip)
    assumed: Many[str] = Field(
        default=(), description="dotted keys whose values the source did not give"
    )

    @model_validator(mode="before")
    @classmethod
    def _complete_materials(cls, data: Any) -> Any:
        """Fill in the known values of the materials that the file names or uses."""
        if not isinstance(data, Mapping):
            return data
        given = data.get("materials", {})
        if not isinstance(given, Mapping):
            return data
        wanted = [str(name) for name in given]
        for table, default in (("body", "silicone"), ("plates", "phosphor_bronze")):
            part = data.get(table, {})
            name = (
                part.get("material", default)
                if isinstance(part, Mapping)
                else (getattr(part, "material", default))
            )
            if isinstance(name, str) and name in MATERIALS and name not in wanted:
                wanted.append(name)
        return {**data, "materials": {name: _completed(name, given.get(name)) for name in wanted}}

    @model_validator(mode="after")
    def _names_exist(self) -> Self:
        for table in ("body", "plates"):
            name = getattr(self, table).material
            if name not in self.materials:
                raise refuse(
                    name,
                    f"a known material ({', '.join(sorted({*MATERIALS, *self.materials}))})",
                    f"correct it or add a table [materials.{name}]",
                    f"{table}.material",
                )
        return self

    @property
    def extruded(self) -> bool:
        """Whether one section tells all: a straight body and plates over its full depth."""
        span = self.plates.span_mm
        full = self.plates.number == 0 or span is None or span == self.body.depth_mm
        return self.body.shape == "arc" and full

    @property
    def mirrors_in_z(self) -> bool:
        """Whether the finger is its own mirror image in z = 0: every shape offered is."""
        return True

    def material_of(self, part: Literal["body", "plates"]) -> Material:
        """Return the material of the ``"body"`` or of the ``"plates"``."""
        return self.materials[getattr(self, part).material]

    def __hash__(self) -> int:
        return hash(self.digest())

    def digest(self) -> str:
        """SHA-256 of the content, in hexadecimal; formatting and comments do not matter."""
        from fingerdesign.design.digest import content_digest

        return content_digest(self)


def _completed(name: str, given: Any) -> Any:
    """Return a material's table with the keys that it lacks taken from the known material."""
    known = MATERIALS.get(name)
    if known is None or not (given is None or isinstance(given, Mapping)):
        return given
    values = asdict(known)
    merged = {**values, **(given or {})}
    changed = any(merged[key] != values[key] for key in values)
    if changed and "source" not in (given or {}):
        del merged["source"]  # no longer that source's values
    return merged
