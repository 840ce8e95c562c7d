"""The ``[mesh]`` table: element sizes and the mesher's limits."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from fingerdesign.design.base import Table


class SectionMesh(Table):
    """``[mesh.section]``: element edges of the plane-strain mesh, mm."""

    contact_size_mm: float = Field(default=0.05, ge=1e-3, le=50, description="at the crest")
    plate_size_mm: float = Field(default=0.05, ge=1e-3, le=50, description="along the plates")
    plate_end_size_mm: float = Field(
        default=0.02, ge=1e-3, le=50, description="at the plates' square, singular ends"
    )
    far_size_mm: float = Field(default=0.5, ge=1e-2, le=100, description="largest anywhere")
    gradation: float = Field(
        default=0.2, ge=0.02, le=2, description="growth of the size per distance"
    )


class MeshOptions(Table):
    """How the 3-D finger is meshed; ``section`` is for plane strain."""

    mesher: Literal["tetwild", "extrude"] = Field(
        default="tetwild", description="tetwild (any finger) | extrude (constant section only)"
    )
    contact_size_mm: float = Field(default=0.4, ge=1e-2, le=50, description="at the crest")
    plate_size_mm: float = Field(default=0.4, ge=1e-2, le=50, description="along the plates")
    far_size_mm: float = Field(default=2.0, ge=1e-2, le=100, description="largest anywhere")
    gradation: float = Field(
        default=0.5, ge=0.02, le=2, description="growth of the size per distance"
    )
    element: Literal["auto", "P1", "P2", "mixed"] = Field(
        default="auto",
        description="auto (by the body's Poisson's ratio) | P2 | mixed (with a pressure) | P1",
    )
    layers: int = Field(default=8, ge=1, le=200, description="extruded layers in half the depth")
    time_limit_s: float = Field(
        default=120.0, ge=1, le=36_000, description="for one attempt of the mesher"
    )
    attempts: int = Field(default=3, ge=1, le=20, description="before the mesher gives up")
    section: SectionMesh = Field(default_factory=SectionMesh)
