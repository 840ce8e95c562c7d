"""What design, scene and fidelity cannot do together: refused before anything is built."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fingerdesign.analysis.case import FIDELITIES, Case
from fingerdesign.analysis.fidelity.ladder import tolerance_faults
from fingerdesign.analysis.fidelity.rungs import can_extrude
from fingerdesign.analysis.path import steps_sideways
from fingerdesign.checks.design import plane_strain_faults
from fingerdesign.checks.scene import scene_faults
from fingerdesign.errors import Fault
from fingerdesign.layout.frames import mirrors_in_z
from fingerdesign.mesh.make import mesher_of
from fingerdesign.mesh.section.section import sheet_room_faults

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design


def impossible(case: Case, scene: Scene) -> list[Fault]:
    """Every fault that design, scene and fidelity have together; none: they go together."""
    faults = list(scene_faults(scene, case.design))
    if case.fidelity not in FIDELITIES:
        faults.append(
            Fault("--fidelity", case.fidelity, f"one of {', '.join(FIDELITIES)}", "choose one")
        )
    if case.fidelity == "3d":
        faults += _space_faults(case, scene)
    if case.fidelity == "plane-strain":
        faults += _section_faults(case.design)
        if steps_sideways(scene):
            faults.append(
                Fault(
                    "--fidelity",
                    case.fidelity,
                    "'3d' for a scene that is not the same in every section",
                    "take 3d: a sphere, a turned object or one along x, shear_z and twist need it",
                )
            )
    if case.fidelity == "auto":
        faults += tolerance_faults(case.tolerance)
        if case.design.mesh.mesher == "file":
            bound = "'tetwild' or 'extrude' for --fidelity auto, which makes meshes of its own"
            faults.append(Fault("mesh.mesher", "file", bound, "take --fidelity 3d"))
        faults += [] if can_extrude(case.design) else _space_faults(case, scene)
    return faults


def _section_faults(design: Design) -> list[Fault]:
    """What one section cannot show, and a mesh's file that would not be read."""
    faults = plane_strain_faults(design) or sheet_room_faults(design)
    if design.mesh.mesher == "file":
        bound = "'tetwild' or 'extrude' for --fidelity plane-strain, which reads no mesh.file"
        faults = [*faults, Fault("mesh.mesher", "file", bound, "take --fidelity 3d")]
    return faults


def _space_faults(case: Case, scene: Scene) -> list[Fault]:
    """What the design's mesher cannot do."""
    half = mirrors_in_z(case.design) and scene.mirrors_in_z
    return mesher_of(case.design).refusals(case.design, half)
