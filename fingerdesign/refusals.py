"""What design, scene and fidelity cannot do together: refused before anything is built."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fingerdesign.case import FIDELITIES, Case
from fingerdesign.design.checks import plane_strain_faults, tetwild_faults
from fingerdesign.design.scene_checks import scene_faults
from fingerdesign.errors import DesignError, Fault, MeshError
from fingerdesign.fidelity.rungs import can_extrude
from fingerdesign.scene_contact import steps_sideways

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design


def refuse(case: Case, scene: Scene) -> None:
    """Raise DesignError with every fault that design, scene and fidelity have together.

    What is sound but too large for this machine's memory is refused too, unless ``case.go_on``.
    """
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
        from fingerdesign.fidelity.ladder import tolerance_faults

        faults += tolerance_faults(case.tolerance)
        if case.design.mesh.mesher == "file":
            bound = "'tetwild' or 'extrude' for --fidelity auto, which makes meshes of its own"
            faults.append(Fault("mesh.mesher", "file", bound, "take --fidelity 3d"))
        faults += [] if can_extrude(case.design) else _space_faults(case, scene)
    elif not faults and not case.go_on:
        from fingerdesign.resources.limits import memory_faults

        faults += memory_faults(case)
    if faults:
        raise DesignError(faults)


def _section_faults(design: Design) -> list[Fault]:
    """What one section cannot show, and a mesh's file that would not be read."""
    faults = plane_strain_faults(design) or sheet_room_faults(design)
    if design.mesh.mesher == "file":
        bound = "'tetwild' or 'extrude' for --fidelity plane-strain, which reads no mesh.file"
        faults = [*faults, Fault("mesh.mesher", "file", bound, "take --fidelity 3d")]
    return faults


def _space_faults(case: Case, scene: Scene) -> list[Fault]:
    """What the design's mesher cannot do."""
    mesher = case.design.mesh.mesher
    if mesher == "tetwild":
        return tetwild_faults(case.design, case.design.mirrors_in_z and scene.mirrors_in_z)
    if mesher == "extrude" and not case.design.layered:
        return [
            Fault(
                "mesh.mesher",
                mesher,
                "'tetwild' for a finger that cannot be swept through layers",
                "set mesh.mesher = 'tetwild'",
            )
        ]
    return sheet_room_faults(case.design) if mesher == "extrude" else []


def sheet_room_faults(design: Design) -> list[Fault]:
    """Plates too close to each other or to a face to be opened as sheets in a section."""
    from fingerdesign.mesh.section_plates import section_frames
    from fingerdesign.mesh.sheets import room_around

    if design.plates.model != "sheet":
        return []
    frames = section_frames(design)
    for frame in frames:
        try:
            room_around(frame, frames, design.body)
        except MeshError as error:
            bound = f"'solid' where plates lie as close as here ({str(error).partition(';')[0]})"
            return [Fault("plates.model", "sheet", bound, "set plates.model = 'solid'")]
    return []
