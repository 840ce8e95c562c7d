"""The ``[body]`` table: the elastic body's shape, its edges, what is bonded into it.

A section (a rectangle below an arc or a flat top) drawn straight along z, curved along z too, or
turned about y; or the user's own STEP file. Lengths in mm.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from fingerdesign.arrays import Array
from fingerdesign.design.base import (
    Named,
    Row3,
    Table,
    bounded,
    key,
    key_fields,
    own_keys,
    refuse,
    refuse_key,
)
from fingerdesign.runtime.registry import BODIES

_ARC_RADIUS_MM = 20.0


def _direction(value: tuple[float, float, float]) -> tuple[float, float, float]:
    if not sum(part * part for part in value) > 1e-12:
        raise refuse(list(value), "a direction: not all zero", "name where it points, as [x, y, z]")
    return value


Direction = Annotated[Row3, AfterValidator(_direction)]


class Core(Table):
    """``[body.core]``: a stiff box bonded into the rubber, as a bone, a nail or a backing.

    Centred on x = 0 and z = 0. A core clear of the base is a bone (or, flat and wide, a nail); one
    with ``bottom_mm`` = 0 is a backing that is on the base and is fixed with it.
    """

    width_mm: float = bounded(8.0, 0.2, 500, "along x")
    height_mm: float = bounded(3.0, 0.1, 500, "along y")
    depth_mm: float | None = bounded(None, 0.2, 500, "along z; absent: the full depth", example=6.0)
    bottom_mm: float = bounded(0.0, 0, 500, "its lower face's height; 0: it is on the base")
    material: str = key("abs", "a name known or in [materials]")


class StepFile(Table):
    """``[body.step]``: the user's own solid, and the rules that find its base and contact surface.

    The file's solid is turned so that ``up`` points to +y, then moved so that the base lies in
    y = 0 and (with ``centre``) its extent along x and z is centred. Directions are those after
    turning. The base: flat faces whose outward normal is along ``base_direction`` within
    ``angle_deg`` at the farthest such position. The contact surface: faces whose outward normal at
    their middle is within ``contact_angle_deg`` of +y and that lie above ``contact_above_mm``.
    """

    file: str = Field(
        min_length=1,
        max_length=4096,
        examples=["finger.step"],
        description="STEP file, relative to the design file or absolute",
    )
    up: Literal["x", "y", "z", "-x", "-y", "-z"] = key(
        "y", "the file's axis that points from the base to the contact surface"
    )
    centre: bool = key(True, "centre the extent along x and z on 0")
    base_direction: Direction = key((0.0, -1.0, 0.0), "outward normal of the fixed base")
    contact_direction: Direction = key(
        (0.0, 1.0, 0.0), "outward normal in the contact surface's middle"
    )
    contact_angle_deg: float = bounded(
        60.0, 1, 120, "faces whose middle's normal is within it of contact_direction"
    )
    contact_above_mm: float = bounded(0.0, 0, 500, "faces whose middle is above this height")
    mirrors_in_z: bool = key(False, "true: the solid mirrors in z = 0, half of it is modelled")


class BodyKind:
    """The geometry of a kind of body; arrays as in :mod:`fingerdesign.layout.bodies`.

    closed_form: true if an outline (layout/profile.py) makes it. straight: all sections are alike.
    turned: round about y, without end faces. flat: its top. words: its top, on pages, with
    ``radius`` and ``dome`` in mm; section_words: the meaning of its mid-section.
    """

    closed_form: ClassVar[bool] = True
    straight: ClassVar[bool] = False
    turned: ClassVar[bool] = False
    flat: ClassVar[bool] = False
    words: ClassVar[str] = ""
    section_words: ClassVar[str] = ""

    def top_radius(self, body: Body) -> float:
        """Radius of the arc in the mid-section, mm; infinite for a flat top."""
        return math.inf if self.flat else float(body.arc_radius_mm)

    def axis(self, body: Body) -> float:
        """Height of the line along x about which the outline is revolved, mm; -inf: about none."""
        return -math.inf

    def height(self, body: Body, x: Array, z: Array) -> Array:
        """Height of the top over (x, z), mm; NaN where it has none."""
        raise NotImplementedError

    def plane(self, body: Body, points: Array) -> Array:
        """Points in the plane of the outline, (n, 2)."""
        raise NotImplementedError

    def directions(self, body: Body, points: Array) -> tuple[Array, Array]:
        """Unit vectors along the outline's two axes at points, each of the shape of ``points``."""
        raise NotImplementedError

    def curvatures(self, body: Body) -> tuple[float, float]:
        """Curvatures at the crest along x and along z, 1/mm."""
        raise NotImplementedError

    def lowest(self, body: Body) -> float:
        """Least height of the contact surface, mm."""
        raise NotImplementedError

    def row_radius(self, body: Body, along: str, middle: float) -> float | None:
        """Radius of the surface line ``along`` x or z where it is one arc; infinite: flat;
        None: neither."""
        return None

    def volume(self, body: Body) -> float:
        """Volume of body, plates and core together, mm^3."""
        raise NotImplementedError

    def areas(self, body: Body) -> dict[str, float]:
        """Areas of the outer faces by name, mm^2."""
        raise NotImplementedError

    def solid(self, body: Body, half: bool) -> Any:
        """A CadQuery solid of its own (of the half z >= 0); None: made from the outline."""
        return None


body = BODIES.kind  # registers a BodyKind under the name that ``body.shape`` takes


class Body(Table):
    """The elastic body: a rectangle below an arc or flat, straight along z, domed or revolved."""

    shape: Annotated[str, Named(BODIES)] = key(
        "arc",
        "arc | dome (arc in x and in z) | revolved (about y: a sphere-ended pin) | "
        "block (flat top) | step (your own CAD)",
    )
    width_mm: float = bounded(20.0, 1, 500, "|x| <= width/2; revolved: the diameter")
    base_height_mm: float = bounded(10.0, 0.5, 500, "height of the straight sides; y = 0 is fixed")
    arc_radius_mm: float = bounded(
        _ARC_RADIUS_MM,
        0.5,
        1e4,
        "crest = base_height + R - sqrt(R^2 - (width/2)^2); not of a block",
    )
    depth_mm: float = bounded(10.0, 0.5, 500, "|z| <= depth/2; revolved: the width")
    dome_radius_mm: float | None = bounded(
        None,
        0.5,
        1e4,
        "dome only: radius of the crest's arc in z; the section is revolved about "
        "the line along x at y = crest - dome_radius",
        example=25.0,
    )
    edge_radius_mm: float | None = bounded(
        None,
        0.05,
        250,
        "rounds or chamfers the edge between contact surface and sides; absent: sharp",
        example=2.0,
    )
    edge: Literal["round", "chamfer"] = key(
        "round", "round (radius) | chamfer (its length along x and y)"
    )
    core: Core | None = key(None, "a stiff insert bonded inside")
    step: StepFile | None = key(None, "step only: the file and its rules")
    material: str = key("silicone", "a name known or in [materials]")

    @model_validator(mode="before")
    @classmethod
    def _revolved_is_round(cls, data: Any) -> Any:
        """A revolved body is as deep as wide: the depth need not be given."""
        if not isinstance(data, Mapping) or data.get("shape") != "revolved":
            return data
        return {"depth_mm": data.get("width_mm", 20.0), **data}

    def _misfits(self) -> Iterator[PydanticCustomError]:
        """Refuse keys that the shape lacks or has no use for."""
        yield from self._shape_misfits()
        yield from self._step_misfits()
        if self.edge_radius_mm is None and self.edge != "round":
            bound = "absent where body.edge_radius_mm is not given"
            yield refuse_key(self, "body.edge", bound, "remove it or give body.edge_radius_mm")

    def _shape_misfits(self) -> Iterator[PydanticCustomError]:
        idle = f"absent where body.shape = '{self.shape}'"
        for name in own_keys(BODIES) - own_keys(BODIES, self.shape):
            if getattr(self, name, None) is not None:
                yield refuse_key(self, f"body.{name}", idle, "remove it")
        key = "body.dome_radius_mm"
        if self.shape == "dome" and self.dome_radius_mm is None:
            remedy = "add it: the radius of the crest's arc in z"
            yield refuse_key(self, key, "given where body.shape = 'dome'", remedy)
        if self.shape != "dome" and self.dome_radius_mm is not None:
            yield refuse_key(self, key, idle, "remove it or set body.shape = 'dome'")
        if self.shape == "revolved" and self.depth_mm != self.width_mm:
            bound = f"body.width_mm = {self.width_mm:g} where body.shape = 'revolved'"
            remedy = "remove it: a revolved body is as deep as wide"
            yield refuse_key(self, "body.depth_mm", bound, remedy)
        if self.shape in ("block", "step") and self.arc_radius_mm != _ARC_RADIUS_MM:
            remedy = "remove it: there is no arc, or set body.shape = 'arc'"
            yield refuse_key(self, "body.arc_radius_mm", idle, remedy)

    def _step_misfits(self) -> Iterator[PydanticCustomError]:
        key, idle = "body.step.file", f"absent where body.shape = '{self.shape}'"
        if self.shape == "step" and self.step is None:
            remedy = "add a table [body.step] with file = 'finger.step'"
            yield refuse("(absent)", "given where body.shape = 'step'", remedy, key)
        if self.shape != "step" and self.step is not None:
            yield refuse(self.step.file, idle, "remove [body.step] or set body.shape = 'step'", key)
        if self.shape == "step" and self.edge_radius_mm is not None:
            yield refuse_key(self, "body.edge_radius_mm", idle, "round the edges in your CAD")

    @property
    def core_depth_mm(self) -> float:
        """Extent of the core along z, mm: that of the body where the core's is not given."""
        given = None if self.core is None else self.core.depth_mm
        return self.depth_mm if given is None else given

    @property
    def straight(self) -> bool:
        """Tell whether the body's section is the same all along z (its core may not be)."""
        return self.kind.straight

    @property
    def kind(self) -> BodyKind:
        """Return the kind that knows its geometry."""
        kind: BodyKind = BODIES.find(self.shape, "body.shape").made
        return kind


key_fields(Body, BODIES)
