"""A scene: the object that touches the finger, the path it is moved along, what is read out."""

from collections.abc import Iterator
from math import inf
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from fingerdesign.arrays import Array
from fingerdesign.design.base import (
    Many,
    Named,
    Row3,
    Table,
    Whole,
    bounded,
    holds,
    key,
    key_fields,
    own_keys,
    positive,
    refuse,
    refuse_key,
)
from fingerdesign.design.digest import content_digest
from fingerdesign.runtime.registry import SCENE_OBJECTS
from fingerdesign.shapes.friction import FrictionLaw
from fingerdesign.shapes.objects import RigidObject, SceneShape

_BOTH_FORCES = (
    "a row of two numbers [normal, tangential]",
    "give both forces in N; shear_z and twist are held at 0",
)
LEAST_FORCE_N = 1e-6  # below it rounding of the model outweighs the force
# Keys of [object] that a law of friction needs, and those that it takes besides.
_LAWS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "coulomb": ((), ()),
    "capped": ((), ("shear_strength_MPa", "shear_limit_MPa")),
    "shear_strength": (("shear_strength_MPa",), ()),
    "power": (("friction_exponent", "reference_pressure_MPa"), ()),
}
_LAW_KEYS = tuple(dict.fromkeys(key for law in _LAWS.values() for keys in law for key in keys))
_COLUMNS = "[approach, shear], [approach, shear, shear_z] or [approach, shear, shear_z, twist_deg]"


def _of_length(bound: str, remedy: str, key: str, *lengths: int) -> BeforeValidator:
    """Refuse rows of another length, each by its number."""

    def checked(rows: Any) -> Any:
        for index, row in enumerate(rows if isinstance(rows, (list, tuple)) else ()):
            if isinstance(row, (list, tuple)) and len(row) not in lengths:
                raise refuse(list(row), bound, remedy, f"path.{key}[{index}]")
        return rows

    return BeforeValidator(checked)


_Motions = Annotated[
    Many[Many[float]],
    _of_length(
        "a row of two to four numbers", f"give {_COLUMNS}, cumulative", "increments_mm", 2, 3, 4
    ),
]
_Pulls = Annotated[Many[Many[float]], _of_length(*_BOTH_FORCES, "increments_N", 2)]


class SceneObject(Table):
    """The rigid object above the crest: let down along y it first touches at approach 0."""

    shape: Annotated[str, Named(SCENE_OBJECTS)] = key(
        "plane", " | ".join(SCENE_OBJECTS.shipped_names())
    )
    radius_mm: float | None = bounded(None, 0.05, 1e5, "of a cylinder or sphere")
    axis: Literal["x", "z"] = key("z", "a cylinder's direction before tilt and turn")
    tilt_deg: float = bounded(0.0, -45, 45, "turned about z, anticlockwise seen from +z")
    turn_deg: float = bounded(
        0.0, -180, 180, "turned about y after the tilt: an edge, or a slope, of any direction"
    )
    friction_coefficient: float = bounded(
        0.5, 0, 10, "Coulomb: tangential <= mu x normal; mu of the other laws"
    )
    friction_law: Literal["coulomb", "capped", "shear_strength", "power"] = key(
        "coulomb",
        "largest shear traction at a pressure p: coulomb: mu p | capped: shear_strength"
        " + mu p, up to shear_limit | shear_strength: that alone, wherever there is contact | "
        "power: mu p (p / reference_pressure)^-friction_exponent; but coulomb all at most 10 p",
    )
    shear_strength_MPa: float | None = positive(
        None, 1e3, "shear_strength, and capped: shear traction that needs no pressure"
    )
    shear_limit_MPa: float | None = positive(None, 1e3, "capped: no pressure carries more")
    friction_exponent: float | None = bounded(
        None,
        0,
        0.9,
        "power: n; friction falls with load^-n under a flat end, load^(-n/3) of a sphere",
    )
    reference_pressure_MPa: float | None = positive(
        None, 1e3, "power: the pressure at which the friction coefficient is mu"
    )

    @property
    def law(self) -> FrictionLaw:
        """The friction of the object's surface."""
        if self.friction_law == "coulomb":
            return FrictionLaw(self.friction_coefficient)
        strength = self.shear_strength_MPa or 0.0
        if self.friction_law == "shear_strength":
            return FrictionLaw(0.0, strength)
        if self.friction_law == "capped":
            limit = inf if self.shear_limit_MPa is None else self.shear_limit_MPa
            return FrictionLaw(self.friction_coefficient, strength, limit)
        exponent, reference = self.friction_exponent or 0.0, self.reference_pressure_MPa or 1.0
        return FrictionLaw(self.friction_coefficient, exponent=exponent, reference=reference)

    def _misfits(self) -> Iterator[PydanticCustomError]:
        """Keys that the shape or the law lacks or has no use for."""
        yield from self._law_misfits()
        shape, own = self._shape, own_keys(SCENE_OBJECTS, self.shape)
        for name, info in type(self).model_fields.items():
            if info.default is not None or name in own or name in _LAW_KEYS:
                continue
            value = getattr(self, name)
            if name in shape.needs and value is None:
                bound, remedy = f"given for a {self.shape}", f"add {name} to [object]"
                yield refuse(None, bound, remedy, f"object.{name}")
            if name not in shape.needs and value is not None:
                bound, remedy = f"left out for a {self.shape}", "remove it, or set object.shape"
                yield refuse(value, bound, remedy, f"object.{name}")
        for name, without in shape.idle(self):
            if getattr(self, name) != without:
                bound = f"{without} for this {self.shape}: it would change nothing"
                yield refuse_key(self, f"object.{name}", bound, "remove it")

    def _law_misfits(self) -> Iterator[PydanticCustomError]:
        """Keys of friction that the law lacks or has no use for."""
        law, (needs, takes) = self.friction_law, _LAWS[self.friction_law]
        for name in _LAW_KEYS:
            value = getattr(self, name)
            if name in needs and value is None:
                bound, remedy = f"given for friction_law '{law}'", f"add {name} to [object]"
                yield refuse("(absent)", bound, remedy, f"object.{name}")
            if name not in (*needs, *takes) and value is not None:
                bound, remedy = f"left out for friction_law '{law}'", "remove it, or set the law"
                yield refuse(value, bound, remedy, f"object.{name}")
        if law == "shear_strength" and "friction_coefficient" in self.model_fields_set:
            bound = "left out for friction_law 'shear_strength': it would change nothing"
            yield refuse_key(self, "object.friction_coefficient", bound, "remove it")
        if law == "capped":
            yield from self._cap_misfits()

    def _cap_misfits(self) -> Iterator[PydanticCustomError]:
        """A capped law without a bound, or with a limit that the strength alone reaches."""
        strength, limit = self.shear_strength_MPa, self.shear_limit_MPa
        if strength is None and limit is None:
            bound = "given, or shear_strength_MPa, for friction_law 'capped'"
            remedy = "add one of them, or set friction_law = 'coulomb'"
            yield refuse("(absent)", bound, remedy, "object.shear_limit_MPa")
        elif limit is not None and limit <= (strength or 0.0):
            remedy = "raise it, or remove it and set friction_law = 'shear_strength'"
            yield refuse(limit, "over shear_strength_MPa", remedy, "object.shear_limit_MPa")

    @property
    def _shape(self) -> SceneShape:
        shape: SceneShape = SCENE_OBJECTS.find(self.shape, "object.shape").made
        return shape

    def made(self) -> RigidObject:
        """The rigid object, its reference point at height 0."""
        return self._shape.make(self)

    def curvature(self) -> Array:
        """Curvature (2, 2) of the object's lower face over (x, z), 1/mm; tilt left out."""
        return self._shape.curvature(self)

    @property
    def flat(self) -> bool:
        """Tell whether the lower face is a plane, level or tilted."""
        return self._shape.flat

    @property
    def plane_in_z(self) -> bool:
        """Tell whether every section of constant z is the same (then plane strain can hold it)."""
        return self._shape.plane_in_z(self)

    @property
    def mirrors_in_z(self) -> bool:
        """Tell whether the object is its own mirror image in z = 0."""
        return self._shape.mirrors_in_z(self)


key_fields(SceneObject, SCENE_OBJECTS)


class ScenePath(Table):
    """The object's motion, or the forces it presses and pulls with, one increment a row."""

    increments_mm: _Motions = key(
        (),
        "rows of cumulative [approach, shear] in mm, or [approach, shear, shear_z], or "
        "[approach, shear, shear_z, twist_deg]: the object moves along -y, +x, +z and turns about "
        "+y; each is cut into increments as substeps says",
        max_length=10_000,
    )
    increments_N: _Pulls = key(
        (),
        'with control = "force": rows of [normal, tangential] in N on the whole '
        "finger, along -y and +x, also where the object slopes",
        max_length=10_000,
    )
    control: Literal["motion", "force"] = key(
        "motion", "motion: rows are displacements | force: rows are forces, the motion is found"
    )
    substeps: int | None = bounded(
        None,
        1,
        1000,
        "cut each row in so many equal increments; absent: in so many that forces, stick ratio and "
        "gages hardly depend on it",
        example=4,
    )

    @property
    def rows(self) -> tuple[tuple[float, ...], ...]:
        """The rows given, mm (and degrees) or N as ``control`` says."""
        return self.increments_N or self.increments_mm

    @property
    def key(self) -> str:
        """The key that holds the rows."""
        return "path.increments_N" if self.increments_N else "path.increments_mm"

    @property
    def mirrors_in_z(self) -> bool:
        """Tell whether the path moves nothing out of the mirror plane z = 0."""
        return not any(value for row in self.rows for value in row[2:])

    def _misfits(self) -> Iterator[PydanticCustomError]:
        """Rows that do not fit the control."""
        force = self.control == "force"
        if self.increments_N and (self.increments_mm or not force):
            bound, remedy = "left out", "keep increments_mm or increments_N"
            if not self.increments_mm:
                bound = 'given with control = "force" only'
                remedy = 'set path.control = "force", or give increments_mm'
            yield refuse([list(self.increments_N[0])], bound, remedy, "path.increments_N")
        elif not self.rows:
            name = "increments_N" if force else "increments_mm"
            yield refuse([], "at least one row", f"add rows to path.{name}", f"path.{name}")
        elif not force and self.rows[0][0] < 0:
            remedy = "approach is counted from first touch, closing > 0"
            bound, key = "at least 0 in the first row", "path.increments_mm[0][0]"
            yield refuse(self.rows[0][0], bound, remedy, key)
        yield from self._row_misfits() if force else ()

    def _row_misfits(self) -> Iterator[PydanticCustomError]:
        """Rows that are no two forces, or that pull off."""
        for index, row in enumerate(self.rows):
            if len(row) != 2:
                yield refuse(list(row), *_BOTH_FORCES, f"{self.key}[{index}]")
            elif row[0] < LEAST_FORCE_N:
                bound = f"a normal force of at least {LEAST_FORCE_N:g} N"
                remedy = "a contact can only press; for a release, prescribe the motion"
                yield refuse(row[0], bound, remedy, f"{self.key}[{index}][0]")


class Readout(Table):
    """Points at which the strain tensor is reported."""

    points_mm: Many[Row3] = key((), "[[x, y, z], ...] inside the finger", max_length=1000)


class Scene(Whole):
    """Load case of a finger: object, path and readout. Frozen; see :meth:`digest`."""

    object: SceneObject = Field(default_factory=SceneObject)
    path: ScenePath
    readout: Readout = Field(default_factory=Readout)

    @model_validator(mode="before")
    @classmethod
    def _path_of_its_own(cls, data: Any) -> Any:
        """Let an absent path be faulted for the rows that it lacks."""
        return {"path": {}, **data} if isinstance(data, dict) else data

    @property
    def mirrors_in_z(self) -> bool:
        """Tell whether object and path mirror in z = 0: half of a finger is enough then."""
        return self.object.mirrors_in_z and self.path.mirrors_in_z

    def digest(self) -> str:
        """SHA-256 of the content, in hexadecimal; formatting and comments do not matter."""
        return content_digest(self)


holds(Scene, SceneObject)
