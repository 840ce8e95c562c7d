"""A scene: the object that touches the finger, the path it is moved along, what is read out."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from fingerdesign.design.base import Many, Row2, Row3, Table, not_offered, refuse


def _plane_only(value: Any) -> Any:
    if value in ("cylinder", "sphere"):
        raise not_offered(value, "plane")
    return value


def _motion_only(value: Any) -> Any:
    if value == "force":
        raise not_offered(value, "motion")
    return value


def _pairs_only(rows: Any) -> Any:
    """Refuse the longer rows [approach, shear, shear_z, twist_deg] by name, once for all."""
    if isinstance(rows, (list, tuple)):
        for index, row in enumerate(rows):
            if isinstance(row, (list, tuple)) and len(row) in (3, 4):
                raise not_offered(
                    list(row), "a row of [approach, shear]", f"path.increments_mm[{index}]"
                )
            if isinstance(row, (list, tuple)) and len(row) != 2:
                raise refuse(
                    list(row),
                    "a row of two numbers [approach, shear]",
                    "give both, cumulative, in mm",
                    f"path.increments_mm[{index}]",
                )
    return rows


def _begins_apart_or_touching(rows: tuple[Any, ...]) -> tuple[Any, ...]:
    if rows and rows[0][0] < 0:
        raise refuse(
            rows[0][0],
            "at least 0 in the first row",
            "approach is counted from first touch, closing > 0",
            "path.increments_mm[0][0]",
        )
    return rows


class SceneObject(Table):
    """The rigid object; a plane above the crest, facing -y."""

    shape: Annotated[Literal["plane"], BeforeValidator(_plane_only)] = Field(
        default="plane", description="plane"
    )
    friction_coefficient: float = Field(
        default=0.5, ge=0, le=10, description="Coulomb: tangential <= mu x normal"
    )


class ScenePath(Table):
    """The object's motion, one increment a row."""

    increments_mm: Annotated[
        Many[Row2], AfterValidator(_begins_apart_or_touching), BeforeValidator(_pairs_only)
    ] = Field(
        min_length=1,
        max_length=10_000,
        description="rows of cumulative [approach, shear]; each is exactly one increment",
    )
    control: Annotated[Literal["motion"], BeforeValidator(_motion_only)] = Field(
        default="motion", description="motion: rows are displacements"
    )
    substeps: int = Field(
        default=1, ge=1, le=1000, description="cut each row in so many equal increments"
    )


class Readout(Table):
    """Where the strain tensor is wanted."""

    points_mm: Many[Row3] = Field(
        default=(), max_length=1000, description="[[x, y, z], ...] inside the finger"
    )


class Scene(Table):
    """What is done to a finger: object, path and readout. Frozen; see :meth:`digest`."""

    object: SceneObject = Field(default_factory=SceneObject)
    path: ScenePath
    readout: Readout = Field(default_factory=Readout)

    def digest(self) -> str:
        """SHA-256 of the content, in hexadecimal; formatting and comments do not matter."""
        from fingerdesign.design.digest import content_digest

        return content_digest(self)
