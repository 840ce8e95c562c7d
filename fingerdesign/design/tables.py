"""The small tables of a design file: its name, the gages, the materials.

Lengths in mm, moduli in MPa, angles in degrees. The body is in body_table.py, the plates in
plate_table.py.
"""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from fingerdesign.design.base import Table, refuse

NAME_PATTERN = r"^[A-Za-z0-9_-]([A-Za-z0-9._-]{0,62}[A-Za-z0-9_-])?$"


# Names that no file or folder can have on Windows, whatever follows a dot.
_RESERVED = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])(\..*)?", re.IGNORECASE)


def safe_name(value: str) -> str:
    """The name itself where it is safe as a folder's; a fault of its key where it is not."""
    if not re.fullmatch(NAME_PATTERN.strip("^$"), value):
        raise refuse(
            value,
            "1 to 64 letters, digits, '-', '_' or '.', neither starting nor ending with '.'",
            "it names the result's folder: choose another",
        )
    if _RESERVED.fullmatch(value):
        raise refuse(
            value,
            "none of the names that Windows reserves (con, prn, aux, nul, com1, lpt1, ...)",
            "it names the result's folder: choose another",
        )
    return value


class Meta(Table):
    """The ``[design]`` table."""

    name: Annotated[str, AfterValidator(safe_name)] = Field(
        description="names the result's folder: letters, digits, - _ .",
        json_schema_extra={"pattern": NAME_PATTERN},
    )


class Gages(Table):
    """The strain gage that each plate carries on one face or on both."""

    length_mm: float = Field(
        default=1.0, ge=0.01, le=200, description="averaged along the plate, centred on it"
    )
    width_mm: float = Field(
        default=1.0,
        ge=0.01,
        le=500,
        description="averaged across the plate (along z), centred on z_mm",
    )
    z_mm: float = Field(
        default=0.0, ge=-250, le=250, description="the gage's middle, from its plate's middle"
    )
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
