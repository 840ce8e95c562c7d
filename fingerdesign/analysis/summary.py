"""What a result says of its model, mesh and inputs, in words and a few numbers."""

from __future__ import annotations

import resource
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.step_file import portable
from fingerdesign.layout.frames import mirrors_in_z
from fingerdesign.mesh.files.imported import import_words
from fingerdesign.mesh.quality import assess
from fingerdesign.records.arrays import SlipStudy
from fingerdesign.records.result import (
    MeshSummary,
    ModelSummary,
    SlipStudySummary,
)
from fingerdesign.report.page import sentences

if TYPE_CHECKING:
    from fingerdesign.analysis.case import Case
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.fem.model import FiniteElementModel
    from fingerdesign.layout.zone import Zone
    from fingerdesign.mesh.types import Mesh


ELEMENT_WORDS = {"P1": "P1", "P2": "P2", "mixed": "P2 displacement, P1 pressure"}
MODEL = Path(__file__).parent / "templates" / "model.txt.j2"


def model_summary(
    model: FiniteElementModel, case: Case, zone: Zone, notes: list[str]
) -> ModelSummary:
    """What was modelled, and a sentence for each choice."""
    mesh, design = model.mesh, case.design
    kind = "triangles" if mesh.dimension == 2 else "tetrahedra"
    mixed = model.element == "mixed" and design.mesh.element == "auto"
    reasons = sentences(MODEL, "reasons", case, mesh, zone, mixed, mirrors_in_z(design))
    return ModelSummary(
        dimension=2 if mesh.dimension == 2 else 3,
        element=f"{ELEMENT_WORDS[model.element]} {kind}, P1 contact tractions",
        dofs=model.dofs,
        contact_nodes=model.reduced.nodes,
        symmetry=mesh.symmetric,
        reasons=(*reasons, *import_words(mesh), *notes),
    )


def mesh_summary(mesh: Mesh, design: Design) -> MeshSummary:
    """The mesh's quality in a few numbers."""
    report = assess(mesh, design)
    has_plates = design.plates.number and design.plates.model == "solid"
    return MeshSummary(
        mesher=mesh.mesher,
        elements=len(mesh.cells),
        min_dihedral_deg=report.min_dihedral_deg,
        body_volume_error=report.body_volume_error,
        worst_plate_volume_error=report.worst_plate_volume_error if has_plates else None,
    )


def study_summary(study: SlipStudy) -> SlipStudySummary:
    """What a result holds of a slip study."""
    touching = np.isfinite(study.stick_ratio)
    responding = np.logical_or.accumulate(study.gage_area_mm > 0.0)
    return SlipStudySummary(
        friction_coefficient=study.friction_coefficient,
        rank_correlation=study.rank_correlation,
        rank_correlation_raw=study.rank_correlation_raw,
        threshold_microstrain_per_N=study.threshold,
        force_floor_N=study.force_floor_N,
        step_correlation=study.step_correlation,
        gage_area_mm=_range(study.gage_area_mm[responding]),
        stick_length_mm=_range(study.stick_length_mm[touching]),
        points=len(study.stick_ratio),
    )


def _range(values: Array) -> tuple[float, float]:
    return (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)


def parameters(design: Design, scene: Scene) -> dict[str, object]:
    """The keys of design and scene (``scene.``) in dotted form, for tables and comparison."""
    flat: dict[str, object] = {}

    def walk(prefix: str, value: object) -> None:
        if isinstance(value, dict):
            for key, inner in value.items():
                walk(f"{prefix}.{key}" if prefix else key, inner)
        else:
            flat[prefix] = value

    walk("", design.model_dump(mode="json", exclude={"assumed"}))
    walk("scene", scene.model_dump(mode="json"))
    return portable(flat)


def peak_memory_MB() -> float:
    """Largest resident memory of this process or of one that it started, so far."""
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    started = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    return max(own, started) / 1024.0
