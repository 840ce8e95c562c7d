"""What a result says of its model, mesh and inputs, in words and a few numbers."""

from __future__ import annotations

import hashlib
import platform
import resource
from functools import cache
from importlib import metadata
from typing import TYPE_CHECKING

from fingerdesign.design.step_file import portable
from fingerdesign.layout.frames import mirrors_in_z
from fingerdesign.mesh.files.imported import import_words
from fingerdesign.mesh.quality import assess
from fingerdesign.records.result import (
    LadderSummary,
    MeshSummary,
    ModelSummary,
)
from fingerdesign.version import __version__

if TYPE_CHECKING:
    from fingerdesign.analysis.case import Case
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.fem.model import FiniteElementModel
    from fingerdesign.layout.zone import Zone
    from fingerdesign.mesh.types import Mesh


# What decides the numbers of a result, as a digest and as versions.

_PACKAGES = ("numpy", "scipy", "scikit-fem", "pypardiso", "cadquery", "pytetwild", "netgen-mesher")


@cache
def _versions() -> tuple[tuple[str, str], ...]:
    found = [("fingerdesign", __version__), ("python", platform.python_version())]
    for name in _PACKAGES:
        try:
            found.append((name, metadata.version(name)))
        except metadata.PackageNotFoundError:
            found.append((name, "absent"))
    return tuple(found)


def versions() -> dict[str, str]:
    """Versions of this package and of those that decide its numbers."""
    return dict(_versions())


def result_digest(design: Design, scene: Scene, fidelity: str) -> str:
    """SHA-256 over design, scene, fidelity and this package's version, in hexadecimal."""
    parts = (design.digest(), scene.digest(), fidelity, __version__)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


ELEMENT_WORDS = {"P1": "P1", "P2": "P2", "mixed": "P2 displacement, P1 pressure"}
PLATE_WORDS = {
    "sheet": "plates are sheets: structural elements in slots of the rubber's mesh",
    "none": "plates are left out: gages read the rubber's strain where the plates would be",
}


def model_summary(
    model: FiniteElementModel, case: Case, zone: Zone, notes: list[str]
) -> ModelSummary:
    """What was modelled, and a sentence for each choice."""
    mesh, design = model.mesh, case.design
    kind = "triangles" if mesh.dimension == 2 else "tetrahedra"
    reasons = [f"contact candidates: {zone}, from the scene's greatest approach"]
    if mesh.dimension == 2:
        reasons.append("plane strain: one section, forces times the depth")
        reasons += _section_reasons(design)
    elif mesh.symmetric:
        reasons.append("half of the finger: body, plates, object and path mirror in z = 0")
    else:
        reasons.append(f"the whole finger: {_why_whole(case)}")
    if model.element == "mixed" and design.mesh.element == "auto":
        nu = design.material_of("body").poissons_ratio
        reasons.append(f"mixed element: at a Poisson's ratio of {nu:g} it is the most accurate")
    if design.plates.number and design.plates.model != "solid":
        reasons.append(PLATE_WORDS[design.plates.model])
    chosen = case.gage_array
    if case.scene is None and 0 < len(chosen) < design.plates.number:
        reasons.append(
            f"slip study and grips read plates {chosen[0]} to {chosen[-1]}: one row along x"
        )
    return ModelSummary(
        dimension=2 if mesh.dimension == 2 else 3,
        element=f"{ELEMENT_WORDS[model.element]} {kind}, P1 contact tractions",
        dofs=model.dofs,
        contact_nodes=model.reduced.nodes,
        symmetry=mesh.symmetric,
        reasons=(*reasons, *import_words(mesh), *notes),
    )


def _why_whole(case: Case) -> str:
    """Why no half of the finger could stand for all of it."""
    design = case.design
    if design.body.step is not None and not design.body.step.mirrors_in_z:
        return "body.step.mirrors_in_z is false"
    if not mirrors_in_z(design):
        return "the plates do not mirror in z = 0"
    if not case.path_scene.mirrors_in_z:
        return "object or path does not mirror in z = 0"
    return "so the mesh in mesh.file is"


def _section_reasons(design: Design) -> list[str]:
    """What the section z = 0 stands for where the finger is not drawn straight from it."""
    if design.extruded:
        return []
    what = design.body.kind.section_words or "a finger whose inside changes along z"
    return [f"the section z = 0 of {what}, drawn straight along the depth: a sketch of it"]


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


def not_reached(ladder: LadderSummary | None) -> tuple[str, ...]:
    """The warning of a ladder that ended before its tolerance."""
    if ladder is None or ladder.reached:
        return ()
    name, worst = max(ladder.error_estimates.items(), key=lambda item: item[1])
    return (
        f"--tolerance {ladder.tolerance:g} was not reached: the last model, {ladder.chosen}, is "
        f"estimated to be off by {100 * worst:.2g} % ({name.replace('_', ' ')}), and "
        f"{ladder.why_ended}",
    )
