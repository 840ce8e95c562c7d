"""The study file of the plane-strain question: designs, scene and meshes that it asks for.

[study] name, base, sampling      [fixed] keys of the design      [parameters] key = [values]
[scene] friction, approaches, shear      [mesh] element sizes      [[also]] one-off changes
"""

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, Field, ValidationError

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.base import Many, Table
from fingerdesign.design.faults import fault_of
from fingerdesign.design.io import parse_toml, read_text
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import shipped_path
from fingerdesign.errors import DesignError, Fault
from fingerdesign.search.study.values import is_number, set_keys, split_share, value_of

SHIPPED = "plane_strain.toml"
_SPAN = "plates.span_mm"
MOST_MODELS = 2000  # of one study: at a third of a minute each, half a day
_Length = Annotated[float, Field(ge=1e-3, le=100)]


_Table = TypeVar("_Table", bound=BaseModel)


class StudyMeta(Table):
    """``[study]``: its name, the design that it starts from, how parameters are combined."""

    name: str = Field(min_length=1, max_length=64)
    base: str = Field(min_length=1)
    sampling: Literal["grid"] = "grid"


class StudyScene(Table):
    """``[scene]``: each approach is pressed from touch, then sheared by a share of it."""

    friction_coefficient: float = Field(default=0.5, gt=0, le=10)
    approach_mm: Many[_Length] = Field(min_length=1, max_length=50)
    shear_per_approach: float = Field(default=0.4, gt=0, le=10)


class StudyMesh(Table):
    """``[mesh]``: edges in the section of both models, and the layer at a free end, mm."""

    contact_size_mm: _Length = 0.4
    plate_size_mm: _Length = 0.7
    plate_end_size_mm: _Length = 0.15
    far_size_mm: _Length = 3.0
    gradation: float = Field(default=0.5, ge=0.02, le=2)
    end_layer_mm: _Length = 0.5


class StudyFile(Table):
    """A whole study file."""

    study: StudyMeta
    fixed: dict[str, Any] = Field(default_factory=dict)
    parameters: dict[str, Annotated[Many[float], Field(min_length=1)]] = Field(min_length=1)
    scene: StudyScene
    mesh: StudyMesh = Field(default_factory=StudyMesh)
    also: Many[dict[str, Any]] = ()


@dataclass(frozen=True)
class Point:
    """One model of the study. ``values``: its parameters, as the file names them; ``name``: of a
    one-off change, empty on the grid."""

    design: Design
    scene: StudyScene
    mesh: StudyMesh
    values: dict[str, float]
    name: str = ""

    @property
    def layers(self) -> int:
        """Layers in half the depth whose last is ``mesh.end_layer_mm`` tall, at least 3."""
        growth, half = 1.15, 0.5 * self.design.body.depth_mm
        count = math.log1p((growth - 1.0) * half / self.mesh.end_layer_mm) / math.log(growth)
        return max(3, round(count))


def shipped_study() -> Path:
    """The study file that comes with the program."""
    return shipped_path("maeno2000").parent / "studies" / SHIPPED


def read_study(path: Path) -> StudyFile:
    """Read a study file. Raises DesignError with every fault of its keys."""
    return parse_study(read_text(path), str(path))


def parse_study(text: str, source: str = "") -> StudyFile:
    """The study that TOML ``text`` describes. Raises DesignError with every fault of its keys."""
    return _validated(StudyFile, parse_toml(text, source), source)


def points_of(study: StudyFile, quick: bool = False) -> Iterator[Point]:
    """The grid's models, then the one-off ones. ``quick``: the first two of each list alone.

    Raises DesignError where there are more than MOST_MODELS, or a combination is no sound design.
    """
    lists = {key: values[:2] if quick else values for key, values in study.parameters.items()}
    models = math.prod(len(values) for values in lists.values())
    if models > MOST_MODELS:
        remedy = "give fewer values, or divide it into several studies"
        raise DesignError([Fault("parameters", models, f"at most {MOST_MODELS} models", remedy)])
    for key, given in lists.items():
        if len(set(given)) < len(given):  # A repeated value leaves no grid to look errors up in.
            remedy = "give each value once"
            raise DesignError([Fault(f"parameters.{key}", given, "values that differ", remedy)])
    base = _base(study)
    for combination in itertools.product(*lists.values()):
        values = dict(zip(lists, combination, strict=True))
        yield Point(_changed(base, values), study.scene, study.mesh, values)
    for row in () if quick else study.also:
        yield _one_off(study, base, row)


def _base(study: StudyFile) -> Design:
    name = {"design.name": study.study.name, "mesh.element": "mixed", "mesh.mesher": "sweep"}
    return with_values(load_design(study.study.base), name | study.fixed)


def _one_off(study: StudyFile, base: Design, row: Mapping[str, Any]) -> Point:
    """The one-off model of a row: keys of the study's scene and mesh, all others the design's."""
    if not isinstance(row.get("name"), str):
        raise DesignError([Fault("also.name", "(absent)", "text", 'add one: name = "..."')])

    def changed(name: str, table: _Table) -> _Table:
        own = {k.partition(".")[2]: value for k, value in row.items() if k.startswith(f"{name}.")}
        return _validated(type(table), table.model_dump() | own, "also")

    scene, mesh = changed("scene", study.scene), changed("mesh", study.mesh)
    own = {k: v for k, v in row.items() if k != "name" and not k.startswith(("scene.", "mesh."))}
    numbers = {key: value for key, value in own.items() if isinstance(value, float)}
    return Point(_changed(base, own), scene, mesh, numbers, row["name"])


def _validated(kind: type[_Table], data: Mapping[str, Any], source: str) -> _Table:
    try:
        return kind.model_validate(data)
    except ValidationError as error:
        raise DesignError([fault_of(each, kind) for each in error.errors()], source) from None


def _changed(base: Design, values: Mapping[str, Any]) -> Design:
    """The design with keys set; "x / y" is a share of y; plates of no span are left out."""
    shares = {key: split_share(key) for key in values if "/" in key}
    for _, whole in shares.values():
        if whole not in values and not is_number(value_of(base, whole)):
            bound = "a key of the design that holds a number, to take a share of"
            raise DesignError([Fault("parameters", f'"... / {whole}"', bound, "correct the key")])
    bare = {k: 1.0 for k, (part, _) in shares.items() if part == _SPAN and values[k] == 0.0}
    plain = set_keys(base, {**values, **bare})
    return with_values(base, plain | {"plates.model": "none"} if bare else plain)
