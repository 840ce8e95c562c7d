"""The tables of a design file that describe the finger: body, plates, gages, materials.

Lengths in mm, moduli in MPa, angles in degrees.
"""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from fingerdesign.design.base import Many, Row3, Table, not_offered, refuse

NAME_PATTERN = r"^[A-Za-z0-9_-]([A-Za-z0-9._-]{0,62}[A-Za-z0-9_-])?$"
MAX_PLATES = 500  # far beyond what can be cast; keeps every check and CAD step bounded


def _named(value: str) -> str:
    if not re.fullmatch(NAME_PATTERN.strip("^$"), value):
        raise refuse(
            value,
            "1 to 64 letters, digits, '-', '_' or '.', neither starting nor ending with '.'",
            "it names the result's folder: choose another",
        )
    return value


def _offered(**later: str) -> BeforeValidator:
    """Refuse values that the format names but this version cannot do, given value = instead."""

    def check(value: Any) -> Any:
        if isinstance(value, str) and value in later:
            raise not_offered(value, later[value])
        return value

    return BeforeValidator(check)


class Meta(Table):
    """The ``[design]`` table."""

    name: Annotated[str, AfterValidator(_named)] = Field(
        description="names the result's folder: letters, digits, - _ .",
        json_schema_extra={"pattern": NAME_PATTERN},
    )


class Body(Table):
    """The elastic body: a rectangle below an arc, straight along z or revolved into a dome."""

    shape: Annotated[
        Literal["arc", "dome"],
        _offered(revolved="one of arc, dome", step="one of arc, dome"),
    ] = Field(default="arc", description="arc | dome (arc in x and in z)")
    width_mm: float = Field(default=20.0, ge=1, le=500, description="|x| <= width/2")
    base_height_mm: float = Field(
        default=10.0, ge=0.5, le=500, description="height of the straight sides; y = 0 is fixed"
    )
    arc_radius_mm: float = Field(
        default=20.0,
        ge=0.5,
        le=1e4,
        description="crest = base_height + R - sqrt(R^2 - (width/2)^2)",
    )
    depth_mm: float = Field(default=10.0, ge=0.5, le=500, description="|z| <= depth/2")
    dome_radius_mm: float | None = Field(
        default=None,
        ge=0.5,
        le=1e4,
        examples=[25.0],
        description="dome only: radius of the crest's arc in z; the section is revolved about "
        "the line along x at y = crest - dome_radius",
    )
    material: str = Field(default="silicone", description="a name known or in [materials]")

    @model_validator(mode="after")
    def _dome_has_its_radius(self) -> Self:
        if self.shape == "dome" and self.dome_radius_mm is None:
            raise refuse(
                "(absent)",
                "given where body.shape = 'dome'",
                "add it: the radius of the crest's arc in z",
                "body.dome_radius_mm",
            )
        if self.shape != "dome" and self.dome_radius_mm is not None:
            raise refuse(
                self.dome_radius_mm,
                f"absent where body.shape = '{self.shape}'",
                "remove it or set body.shape = 'dome'",
                "body.dome_radius_mm",
            )
        return self


class Plates(Table):
    """The plates that carry the gages: boxes in the section, ``span_mm`` long in z.

    ``model`` says how the finite elements see them; what is built and cast stays the same.
    """

    count: int = Field(default=15, ge=0, le=MAX_PLATES, description="0 allowed")
    thickness_mm: float = Field(default=0.1, ge=0.005, le=10, description="in the section")
    length_mm: float = Field(default=2.0, ge=0.05, le=200, description="in the section")
    angle_deg: float = Field(default=45.0, ge=-180, le=180, description="anticlockwise from +x")
    pitch_mm: float = Field(
        default=1.0, ge=0.01, le=200, description="between plate centres, along x"
    )
    cover_mm: float = Field(
        default=2.0, ge=0.01, le=500, description="plate centre below the surface, along y"
    )
    span_mm: float | None = Field(
        default=None,
        ge=0.1,
        le=500,
        examples=[8.0],
        description="along z, centred; absent: the full depth",
    )
    material: str = Field(default="phosphor_bronze", description="a name known or in [materials]")
    placement: Many[Row3] | None = Field(
        default=None,
        max_length=MAX_PLATES,
        examples=[[[-1.0, 10.5, 45.0], [1.0, 10.5, 45.0]]],
        description="[[x, y, angle_deg], ...]: centres one by one instead of count, pitch, cover",
    )
    model: Literal["solid", "sheet", "none"] = Field(
        default="solid",
        description="solid | sheet (membrane and bending at the mid-surface; straight bodies and "
        "full spans) | none (gages stay, plates are left out of the model)",
    )

    @property
    def number(self) -> int:
        """How many plates there are, whether placed by pitch or one by one."""
        return self.count if self.placement is None else len(self.placement)


class Gages(Table):
    """The strain gage that each plate carries on one face or on both."""

    length_mm: float = Field(
        default=1.0, ge=0.01, le=200, description="averaged along the plate, centred on it"
    )
    width_mm: float = Field(
        default=1.0, ge=0.01, le=500, description="averaged along z, centred on z_mm"
    )
    z_mm: float = Field(default=0.0, ge=-250, le=250, description="the gage's middle in z")
    face: Literal["upper", "lower", "both"] = Field(
        default="both",
        description="upper (90 degrees anticlockwise from the plate's axis) | lower | both "
        "(their mean: membrane)",
    )


class Material(Table):
    """An isotropic linear elastic material."""

    youngs_modulus_MPa: float = Field(ge=1e-4, le=2e6, description="small-strain modulus")
    poissons_ratio: float = Field(ge=0, le=0.4999, description="0 to 0.4999")
    source: str = Field(
        default="the design file", max_length=500, description="where both are from"
    )
