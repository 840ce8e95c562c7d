"""Faults of a sound design for one mesher or model: element sizes, sheets, the section z = 0."""

from fingerdesign.checks.body import sound_outline
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.layout.layers import not_a_sheet
from fingerdesign.layout.row_keys import plate_rows
from fingerdesign.layout.rows import plate_frames
from fingerdesign.runtime.registry import MESHERS

_SPACE = "take --fidelity 3d"


def mesh_faults(design: Design) -> list[Fault]:
    """Find a mesher that cannot mesh the design, and element sizes that contradict each other."""
    mesh, faults = design.mesh, _sheet_faults(design)
    why = MESHERS.find(mesh.mesher, "mesh.mesher").made.why_not(design)
    if why is not None:
        bound = f"'tetwild' for a finger that cannot be {why}"
        faults.insert(0, Fault("mesh.mesher", mesh.mesher, bound, "set mesh.mesher = 'tetwild'"))
    for prefix, sizes in (("mesh", mesh), ("mesh.section", mesh.section)):
        if sizes.contact_size_mm > sizes.far_size_mm:
            bound = f"at most {prefix}.far_size_mm = {sizes.far_size_mm:g}"
            key = f"{prefix}.contact_size_mm"
            remedy = "lower it: far_size_mm is the largest size anywhere"
            faults.append(Fault(key, sizes.contact_size_mm, bound, remedy))
    return faults


def _sheet_faults(design: Design) -> list[Fault]:
    """Find plates as sheets that are not flat or whole, or whose elements do not bend."""
    if design.plates.model != "sheet" or not design.plates.number:
        return []
    faults = tetwild_faults(design, False) if sound_outline(design.body) else []
    if design.mesh.element == "P1":
        bound = "'auto', 'P2' or 'mixed' for plates as sheets"
        remedy = "linear elements do not bend; leave mesh.element out"
        faults.insert(0, Fault("mesh.element", "P1", bound, remedy))
    return faults


def tetwild_faults(design: Design, symmetric: bool) -> list[Fault]:
    """Find what tetwild cannot mesh of a sound design, or (``symmetric``) of its half z >= 0: a
    sheet in the symmetry plane."""
    if design.plates.model != "sheet":
        return []
    for frame in plate_frames(design):
        if (why := not_a_sheet(frame, half=symmetric)) is not None:
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
        return [Fault("body.shape", "step", bound, _SPACE)]
    faults: dict[str, Fault] = {}
    for row in plate_rows(design):
        if row.table.along == "z":
            bound = "'x' for plane strain: the section z = 0 shows no plate along z"
            faults.setdefault(row.key("along"), Fault(row.key("along"), "z", bound, _SPACE))
            continue
        if missed := [frame.index for frame in row.frames if not frame.low < 0.0 < frame.high]:
            name = "stagger_mm" if row.table.stagger_mm else "span_offset_mm"
            missing = f"(it misses plate {missed[0]})"
            bound = f"such that the section z = 0 cuts every plate, for plane strain {missing}"
            found = Fault(row.key(name), row.value(name), bound, _SPACE)
            faults.setdefault(found.key, found)
    return list(faults.values())
