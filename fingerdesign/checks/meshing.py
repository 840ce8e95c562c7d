"""Faults of a sound design for one mesher or model: element sizes, sheets, the section z = 0."""

from fingerdesign.checks.body import sound_outline
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.layout.layers import not_a_sheet
from fingerdesign.layout.row_keys import plate_rows
from fingerdesign.layout.rows import plate_frames
from fingerdesign.runtime.registry import MESHERS


def mesh_faults(design: Design) -> list[Fault]:
    """Find a mesher that cannot mesh the design, and element sizes that contradict each other."""
    faults = []
    mesh = design.mesh
    why = MESHERS.find(mesh.mesher, "mesh.mesher").made.why_not(design)
    if why is not None:
        bound = f"'tetwild' for a finger that cannot be {why}"
        remedy = "set mesh.mesher = 'tetwild'"
        faults.append(Fault("mesh.mesher", mesh.mesher, bound, remedy))
    faults += _sheet_faults(design)
    for prefix, sizes in (("mesh", mesh), ("mesh.section", mesh.section)):
        if sizes.contact_size_mm > sizes.far_size_mm:
            bound = f"at most {prefix}.far_size_mm = {sizes.far_size_mm:g}"
            remedy = "lower it: far_size_mm is the largest size anywhere"
            key = f"{prefix}.contact_size_mm"
            faults.append(Fault(key, sizes.contact_size_mm, bound, remedy))
    return faults


def _sheet_faults(design: Design) -> list[Fault]:
    """Find plates as sheets that are not flat or whole, or whose elements do not bend."""
    plates = design.plates
    if plates.model != "sheet" or not plates.number:
        return []
    faults = []
    if design.mesh.element == "P1":
        bound = "'auto', 'P2' or 'mixed' for plates as sheets"
        remedy = "linear elements do not bend; leave mesh.element out"
        faults.append(Fault("mesh.element", "P1", bound, remedy))
    return faults + (tetwild_faults(design, False) if sound_outline(design.body) else [])


def tetwild_faults(design: Design, symmetric: bool) -> list[Fault]:
    """Find what tetwild cannot mesh of a sound design, or (``symmetric``) of its half z >= 0: a
    sheet in the symmetry plane."""
    if design.plates.model != "sheet":
        return []
    for frame in plate_frames(design):
        why = not_a_sheet(frame, half=symmetric)
        if why is not None:
            bound = f"'solid' or 'none' for plate {frame.index}: {why}"
            return [Fault("plates.model", "sheet", bound, "set plates.model = 'solid'")]
    return []


def plane_strain_faults(design: Design) -> list[Fault]:
    """Find what one section cannot show of a sound design: a step body, plates that it does not
    cut.

    A core that is not of full depth, domes, pins and plates of finite span are taken as they are
    in the section z = 0, and drawn straight.
    """
    if design.body.shape == "step":
        bound = "a parametric shape for plane strain: a STEP body's section is not taken"
        return [Fault("body.shape", "step", bound, "take --fidelity 3d")]
    faults: dict[str, Fault] = {}
    for row in plate_rows(design):
        if row.table.along == "z":
            bound = "'x' for plane strain: the section z = 0 shows no plate along z"
            key = row.key("along")
            faults.setdefault(key, Fault(key, "z", bound, "take --fidelity 3d"))
            continue
        missed = [frame.index for frame in row.frames if not frame.low < 0.0 < frame.high]
        if missed:
            name = "stagger_mm" if row.table.stagger_mm else "span_offset_mm"
            key, value = row.key(name), row.value(name)
            bound = "such that the section z = 0 cuts every plate, for plane strain"
            reported = f"{bound} (it misses plate {missed[0]})"
            faults.setdefault(key, Fault(key, value, reported, "take --fidelity 3d"))
    return list(faults.values())
