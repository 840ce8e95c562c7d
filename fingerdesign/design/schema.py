"""A finger design: a design file, validated key by key (checks/ judges the geometry).

Lengths in mm, moduli in MPa, angles in degrees. Every key but ``design.name`` has a default.
"""

import json
import math
import re
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from fingerdesign.design.base import Many, Table, Whole, holds, key, refuse
from fingerdesign.design.body import Body, Core, StepFile
from fingerdesign.design.digest import content_digest
from fingerdesign.design.former import with_current_keys
from fingerdesign.design.gages import METAL_FACTOR, Gages
from fingerdesign.design.grip import Grip
from fingerdesign.design.mesh import MeshOptions
from fingerdesign.design.mold import Mold
from fingerdesign.design.plates import Plates, Row
from fingerdesign.design.scene import Scene
from fingerdesign.design.stock import GageType, shipped_types
from fingerdesign.materials import EXPANSION, MATERIALS, gent_youngs_modulus
from fingerdesign.runtime.registry import CONTROLLERS, load_plugins

__all__ = ["Body", "Core", "Design", "Gages", "Material", "Meta", "Plates", "Row", "StepFile"]


DATA = Path(__file__).resolve().parent.parent / "data"
_KNOWN = ("youngs_modulus_MPa", "poissons_ratio", "source")  # Keys that the library has.
NAME_PATTERN = r"^[A-Za-z0-9_-]([A-Za-z0-9._-]{0,62}[A-Za-z0-9_-])?$"


# Controllers register their ``[grip.NAME]`` tables. They are on a floor above, import ``[grip]``,
# and are loaded here, before a whole design is defined.
CONTROLLERS.load()

# Names that no file or folder can have on Windows, whatever follows a dot.
_RESERVED = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])(\..*)?", re.IGNORECASE)


def safe_name(value: str) -> str:
    """The name itself where it is safe as a folder's; a fault of its key where it is not."""
    if not re.fullmatch(NAME_PATTERN.strip("^$"), value):
        bound = "1 to 64 letters, digits, '-', '_' or '.', neither starting nor ending with '.'"
    elif _RESERVED.fullmatch(value):
        bound = "none of the names that Windows reserves (con, prn, aux, nul, com1, lpt1, ...)"
    else:
        return value
    raise refuse(value, bound, "it names the result's folder: choose another")


class Meta(Table):
    """The ``[design]`` table."""

    name: Annotated[str, AfterValidator(safe_name)] = Field(
        description="names the result's folder: letters, digits, - _ .",
        json_schema_extra={"pattern": NAME_PATTERN},
    )


class Material(Table):
    """An isotropic linear elastic material."""

    youngs_modulus_MPa: float = Field(ge=1e-4, le=2e6, description="small-strain modulus")
    poissons_ratio: float = Field(ge=0, le=0.4999, description="0 to 0.4999")
    shore_a: float | None = key(None, "hardness, instead of the modulus: by Gent 1958", ge=5, le=95)
    expansion_per_K: float | None = key(
        None, "linear, thermal; not given: a known material's", ge=0, le=1e-2
    )
    source: str = key("the design file", "where both are from", max_length=500)


Part = Literal["body", "plates", "core"]


class Design(Whole):
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
    mold: Mold = Field(default_factory=Mold)
    assumed: Many[str] = key((), "dotted keys whose values the source did not give")

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        load_controller(obj)
        return super().model_validate(obj, **options)

    @model_validator(mode="before")
    @classmethod
    def _rename_former_keys(cls, data: Any) -> Any:
        return with_current_keys(data) if isinstance(data, Mapping) else data

    @model_validator(mode="before")
    @classmethod
    def _complete_materials(cls, data: Any) -> Any:
        """Fill in the known values of the materials that the file names or uses."""
        if not isinstance(data, Mapping):
            return data
        given = data.get("materials", {})
        if not isinstance(given, Mapping):
            return data
        named = [str(name) for name in given]
        body = _part(data, "body")
        parts = [(body, "silicone"), (_part(data, "plates"), "phosphor_bronze")]
        if _part(body, "core") is not None:
            parts.append((_part(body, "core"), "abs"))
        for part, default in parts:
            name = _part(part, "material") or default
            if isinstance(name, str) and name in MATERIALS and name not in named:
                named.append(name)
        return {**data, "materials": {name: _completed(name, given.get(name)) for name in named}}

    def _misfits(self) -> Iterator[PydanticCustomError]:
        yield from unknown_names(self)

    @property
    def extruded(self) -> bool:
        """Tell whether one section describes the finger: all that is in it has the full depth."""
        core = self.body.core is None or self.body.core.depth_mm in (None, self.body.depth_mm)
        return self.body.straight and core and self.plates.full(self.body.depth_mm)

    @property
    def core_region(self) -> int:
        """Number of the core's region in meshes: 0 is the elastomer, k + 1 plate k, then it."""
        return self.plates.number + 1

    def material_of(self, part: Part) -> Material:
        """Return the material of the ``"body"``, the ``"plates"`` or the ``"core"``."""
        if part == "core":
            if self.body.core is None:
                raise KeyError(f"{self.design.name} has no core")
            return self.materials[self.body.core.material]
        return self.materials[getattr(self, part).material]

    def expansion_of(self, part: Part) -> float | None:
        """Thermal expansion of a part's material, 1/K; None where neither the design nor the
        library of materials gives one."""
        core = self.body.core
        name = getattr(self, part).material if part != "core" else core and core.material
        given = self.material_of(part).expansion_per_K
        return EXPANSION.get(str(name), (None, ""))[0] if given is None else given

    @property
    def gage_weights(self) -> tuple[float, float]:
        """a and b of a gage's reading a e_axial + b e_transverse, on plates of this material."""
        return self.gages.weights(self.material_of("plates").poissons_ratio)

    @property
    def bridge(self) -> tuple[str, float]:
        """The bridge's name, and its output in microvolt per volt of a reading of 1 microstrain."""
        found = self.gages.bridges(self.material_of("plates").poissons_ratio)
        name: str = self.gages.bridge or list(found)[-1]
        return name, 0.25 * self.gage_factor * found[name]

    @property
    def gage_types(self) -> tuple[GageType, ...]:
        """Every type that the design knows: its own, then the catalogue's of other names."""
        own = self.mold.gage_types
        names = {each.name for each in own}
        return (*own, *(each for each in shipped_types() if each.name not in names))

    @property
    def gage_type(self) -> GageType | None:
        """The type of ``gages.kind``; None where the design names none."""
        kind = self.gages.kind
        return next((each for each in self.gage_types if each.name == kind), None)

    @property
    def gage_factor(self) -> float:
        """The gages' own factor, that of their kind, or that of metal foil."""
        type_ = self.gage_type
        kind = METAL_FACTOR if type_ is None else type_.gage_factor
        return kind if self.gages.gage_factor is None else self.gages.gage_factor

    @property
    def rig(self) -> Grip:
        """``[grip]`` with the amplifier's noise as microstrain of the bridge, added in squares."""
        hardware = self.grip.hardware
        if hardware.gage_noise_microvolt_per_V == 0.0:
            return self.grip
        amplifier = hardware.gage_noise_microvolt_per_V / self.bridge[1]
        noise = math.hypot(hardware.gage_noise_microstrain, amplifier)
        own = {"gage_noise_microstrain": noise, "gage_noise_microvolt_per_V": 0.0}
        return self.grip.model_copy(update={"hardware": hardware.model_copy(update=own)})

    def __hash__(self) -> int:
        return hash(self.digest())

    def digest(self) -> str:
        """SHA-256 of what analyses see, in hexadecimal; not of formatting, comments or ``mold``. A
        gage counts by its factor and by what it stiffens its plate, whatever name it has."""
        stiff, type_ = None, self.gage_type
        if type_ is not None and type_.stiffness:
            size = type_.carrier(self.gages.length_mm, self.gages.width_mm)
            stiff = f"{type_.stiffness:.6g} N/mm, {size[0]:.6g} x {size[1]:.6g} mm"
        factor = None if self.gage_factor == METAL_FACTOR else self.gage_factor
        gages = self.gages.model_copy(update={"kind": stiff, "gage_factor": factor})
        return content_digest(self.model_copy(update={"gages": gages}))


holds(Design, Body, Grip, MeshOptions)


def load_controller(design: Any) -> None:
    """Import the controller that a raw design names by its class: its table is read as well."""
    CONTROLLERS.knows(_part(_part(design, "grip"), "controller"))


def _completed(name: str, given: Any) -> Any:
    """Return a material's table with the keys that it lacks taken from the known material."""
    known = MATERIALS.get(name)
    if isinstance(given, Mapping):
        given = _by_hardness(given)
    if known is None or not isinstance(given, Mapping | None):
        return given
    values = {key: getattr(known, key) for key in _KNOWN}
    merged = {**values, **(given or {})}
    changed = any(merged[key] != values[key] for key in values)
    if changed and "source" not in (given or {}):
        del merged["source"]  # no longer that source's values
    return merged


def _by_hardness(given: Mapping[str, Any]) -> Mapping[str, Any]:
    """The table with the modulus of its Shore A hardness; one that gives both keeps its modulus."""
    hardness = given.get("shore_a")
    if "youngs_modulus_MPa" in given or not isinstance(hardness, int | float):
        return given
    if not 5.0 <= hardness <= 95.0:
        return given
    modulus = round(gent_youngs_modulus(float(hardness)), 4)
    return {"poissons_ratio": 0.49, **given, "youngs_modulus_MPa": modulus}


def unknown_names(design: Any) -> Iterator[PydanticCustomError]:
    """A refusal for each part whose material is neither known nor in [materials], and for unknown
    gages. design: a :class:`Design`, or a file's raw table whatever is in it."""
    given = _part(design, "materials")
    known = {*MATERIALS, *(given if isinstance(given, Mapping) else ())}
    body = _part(design, "body")
    parts = {"body": body, "plates": _part(design, "plates"), "body.core": _part(body, "core")}
    for table, part in parts.items():
        name = _part(part, "material")
        if isinstance(name, str) and name not in known:
            close = get_close_matches(name, sorted(known), 1)
            nearest = f'take "{close[0]}", ' if close else "correct it, "
            yield refuse(
                name,
                "a known material",
                f"{nearest}or add a table [materials.{name}]; "
                "`fingerdesign list materials` names all",
                f"{table}.material",
            )
    yield from _unknown_gages(_part(design, "gages"), _part(design, "mold"))


def _unknown_gages(gages: Any, mold: Any) -> Iterator[PydanticCustomError]:
    own = _part(mold, "gage_types")
    types = [*(own if isinstance(own, list | tuple) else ()), *shipped_types()]
    names = [name for each in types if isinstance(name := _part(each, "name"), str)]
    words = f"one of {', '.join(dict.fromkeys(names))}"
    remedy = "correct it, or add a table [[mold.gage_types]] of that name"
    kind, gage = _part(gages, "kind"), _part(mold, "gage")
    if isinstance(kind, str) and kind not in names:
        yield refuse(kind, words, remedy, "gages.kind")
    if isinstance(gage, str) and gage not in ("auto", *names):
        yield refuse(gage, f"auto or {words}", remedy, "mold.gage")


def _part(table: Any, key: str) -> Any:
    """A key of a table that may be a mapping, a validated table or absent."""
    return table.get(key) if isinstance(table, Mapping) else getattr(table, key, None)


def json_schema(file: str) -> dict[str, Any]:
    """The JSON schema of a "design" or a "scene" file, with what plug-ins add to it; editors
    complete and explain keys by it."""
    model: type[Whole] = Design if file == "design" else Scene
    title = "A finger design" if file == "design" else "A scene that a finger is put through"
    load_plugins()
    schema = model.model_json_schema(mode="validation")
    # Known materials fill in what a file leaves out; which names are known, the schema can't say.
    schema.get("$defs", {}).get("Material", {}).pop("required", None)
    dialect = "https://json-schema.org/draft/2020-12/schema"
    simplified: dict[str, Any] = _without_null(schema)
    return {"$schema": dialect, **simplified, "title": f"{title} (fingerdesign)"}


def schema_text(file: str) -> str:
    """The schema of a file the way it is shipped."""
    return json.dumps(json_schema(file), indent=2) + "\n"


def _without_null(node: Any) -> Any:
    """Drop the null that pydantic allows for absent keys: TOML cannot write it."""
    if isinstance(node, list):
        return [_without_null(item) for item in node]
    if not isinstance(node, dict):
        return node
    node = {key: _without_null(item) for key, item in node.items()}
    choices = node.get("anyOf")
    if isinstance(choices, list) and {"type": "null"} in choices:
        rest = [choice for choice in choices if choice != {"type": "null"}]
        del node["anyOf"]
        if node.get("default", 0) is None:
            del node["default"]
        return {**node, **rest[0]} if len(rest) == 1 else {**node, "anyOf": rest}
    return node


if __name__ == "__main__":
    for name in ("design", "scene"):
        (DATA / f"{name}.schema.json").write_text(schema_text(name), "utf-8")
