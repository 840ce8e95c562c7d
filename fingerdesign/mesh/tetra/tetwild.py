"""Tetrahedra for any finger: CAD surface -> fTetWild -> snapped quadratic mesh.

fTetWild takes triangles and stays within an envelope of ``epsilon`` of them. It is not
deterministic, so its answer must pass the ``Gate`` or is made again, and what passed is cached.
"""

import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fingerdesign.cad.solid_process import finger_triangles
from fingerdesign.checks.meshing import tetwild_faults
from fingerdesign.design.schema import Body, Design
from fingerdesign.errors import DesignError, Fault, MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.surface import surface_of
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cache import load_mesh, mesh_key, store_mesh
from fingerdesign.mesh.counting import expected_elements
from fingerdesign.mesh.make import Mesher, mesher
from fingerdesign.mesh.quality import QualityReport, assess
from fingerdesign.mesh.sizing import MeshSizes, SizeField
from fingerdesign.mesh.tetra.finish import finish
from fingerdesign.mesh.tetra.run import Attempt, MesherFailed, run_tetwild
from fingerdesign.mesh.tetra.ways import PlateWay, plate_ways
from fingerdesign.mesh.types import Mesh
from fingerdesign.runtime.progress import announce

# Edges come out longer than their target where the field is steep: at the contact 1.33 times (0.28
# mm for 0.21, 0.39 for 0.30), at plates 1.0 to 1.08 times.
CONTACT_OVERSHOOT = 1.33
# fTetWild made 0.87 to 0.97 times the expected tetrahedra, 2 times where plates were very thin;
# where its optimisation went astray (a stop energy of 20) 3 to 8 times.
MOST_ELEMENTS_RATIO = 2.5
# Chords far finer than the elements cost fTetWild most of its time, and make elements that no size
# asks for. Bodies in edges of 1 mm at the contact took 33 (pin) and 16 s (domed) of processor time
# with chords of 0.01 mm and take 11 and 7 s with 0.02; seven coarse fingers took 55 s and take 16.
# Elements at round holes come out longer: the volume of a plate is off by 1.3e-4, not by 1e-4.
CHORD_SHARE = 0.02
FEW_ELEMENTS = 40_000  # never too many: holes and bends need elements that no size names
MOST_ELEMENTS = 600_000  # about 2.5 million dofs: no machine this is for factors more


@dataclass(frozen=True)
class Gate:
    """Limits of a tetrahedral mesh (NUMERICS 7; measured on accepted meshes in brackets)."""

    body_volume_error: float = 1e-3  # [2e-5]
    plate_volume_error: float = 1e-2  # [1e-12]
    face_area_error: float = 1e-3  # [1e-5]
    min_dihedral_deg: float = 5.0  # [7 to 10, after improve]
    contact_residual_mm: float = 1e-6  # [1e-13]
    least_jacobian_ratio: float = 0.05  # [0.9]

    def faults(self, report: QualityReport) -> list[str]:
        """The limits that a mesh breaks, in words; empty when it passes."""
        found = []
        for name, bound in vars(self).items():
            worst = name in ("plate_volume_error", "face_area_error")
            value = getattr(report, f"worst_{name}" if worst else name)
            least = name in ("min_dihedral_deg", "least_jacobian_ratio")
            if not (value >= bound if least else value <= bound):
                found.append(f"{name} = {value:.3g} ({'below' if least else 'above'} {bound:g})")
        return found


def tetrahedralise(
    design: Design, zone: Zone, symmetric: bool = True, use_cache: bool = True
) -> Mesh:
    """Mesh a finger (or its half z >= 0) with quadratic tetrahedra, fine in a zone of contact.

    Meshes that passed the gate are cached by content and returned again unless ``use_cache`` is
    False. MeshError when no attempt passes, DesignError for what cannot be meshed so.
    """
    faults = tetwild_faults(design, symmetric)
    if faults:
        raise DesignError(faults, design.design.name)
    sizes = MeshSizes.of(design, zone)
    key = mesh_key(design, sizes, zone, symmetric)
    cached = load_mesh(key) if use_cache else None
    if cached is not None and not Gate().faults(assess(cached, design)):
        return cached
    complaints: list[str] = []
    inputs: list[Path] = []
    tries = _tries(plate_ways(design, symmetric), int(design.mesh.attempts))
    for number, (way, attempt) in enumerate(tries, start=1):
        announce(f"meshing: attempt {number} of at most {len(tries)}")
        try:
            # fTetWild may leave elements without volume: what divides by them has no answer.
            with np.errstate(divide="raise", invalid="raise"):
                mesh = _attempted(design, way, attempt, sizes, zone, symmetric)
        except (MeshError, FloatingPointError) as error:
            complaints.append(f"attempt {number} ({way.name}): {error}")
            inputs += [error.input] if isinstance(error, MesherFailed) else []
            continue
        short = Gate().faults(assess(mesh, design))
        if not short:
            mesh.notes["attempts"] = number
            for folder in inputs:  # of no more use: another attempt has passed
                shutil.rmtree(folder, ignore_errors=True)
            if complaints:
                mesh.notes["failed_attempts"] = "; ".join(complaints)
            if use_cache:
                store_mesh(key, mesh)
            return mesh
        complaints.append(f"attempt {number} ({way.name}): {', '.join(short)}")
    raise MeshError(
        f"no tetrahedral mesh of {design.design.name} passed the gate in {len(tries)} attempts; "
        + "; ".join(complaints)
    )


def _attempted(
    design: Design, way: PlateWay, attempt: Attempt, sizes: MeshSizes, zone: Zone, symmetric: bool
) -> Mesh:
    """One try: CAD, fTetWild, and what follows. MeshError names what failed."""
    scaled = sizes.scaled(attempt.size_factor)
    field = size_field(design, way.sized, scaled, zone)
    expected = expected_elements(field, *field.box(design.body, symmetric))
    if expected > MOST_ELEMENTS:
        raise MeshError(
            f"the [mesh] sizes of {design.design.name} lead to about {expected:.2g} tetrahedra, "
            f"more than {MOST_ELEMENTS}; raise mesh.contact_size_mm, plate_size_mm or far_size_mm"
        )
    most = max(int(MOST_ELEMENTS_RATIO * expected), FEW_ELEMENTS)
    chord = chord_mm(design.body, scaled.contact, any(each.holes for each in way.meshed))
    parts, outside = finger_triangles(design, chord, symmetric, way.meshed)
    epsilon = attempt.envelope * envelope_mm(design, way.meshed, chord)
    limit = float(design.mesh.time_limit_s)
    settings = replace(attempt, envelope=epsilon)
    points, tets = run_tetwild(*parts, field, settings, limit, expected)
    mesh = finish(design, way, points, tets, outside, symmetric, replace(field, sizes=scaled), most)
    if len(mesh.cells) > most:
        raise MeshError(f"{len(mesh.cells)} tetrahedra, and at most {most} were to be expected")
    return mesh


def envelope_mm(design: Design, frames: tuple[PlateFrame, ...], chord: float) -> float:
    """fTetWild's envelope: a tenth of the thinnest part, at most the chord tolerance. At a quarter
    of the thickness plates still survive; at 1.2 times they vanish without a word."""
    thin = [frame.thickness for frame in frames]
    if design.body.core is not None:
        thin.append(design.body.core.height_mm)
    return min([chord, *(0.1 * each for each in thin)])


def chord_mm(body: Body, contact: float, holes: bool = False) -> float:
    """Chord tolerance of the triangles to mesh, mm: 0.01 for a finger of 25 mm, or CHORD_SHARE of
    an edge at the contact (mm) where that is more and no plate has holes.

    Snapping takes the chords out again. At 0.002 fTetWild ran for minutes on a finger of 25 mm, at
    0.01 for a minute on one of 65 mm.
    """
    size = float(np.hypot(np.hypot(body.width_mm, body.base_height_mm), body.depth_mm))
    return 4e-4 * size if holes else max(4e-4 * size, CHORD_SHARE * contact)


def size_field(
    design: Design, frames: tuple[PlateFrame, ...], sizes: MeshSizes, zone: Zone
) -> SizeField:
    """The size field for fTetWild, such that edges at the contact come out as ``sizes``."""
    requested = replace(sizes, contact=sizes.contact / CONTACT_OVERSHOOT)
    return SizeField(surface_of(design.body), frames, requested, zone)


def _tries(ways: tuple[PlateWay, ...], count: int) -> list[tuple[PlateWay, Attempt]]:
    """Ways and settings to try in turn; fTetWild is not deterministic: the same again may pass.

    So the first way, whose gages read best (finish.py), is tried twice before the next: of 20
    meshes of shipped fingers one failed in it, and none twice.
    A fifth of the thickness as envelope is faster where plates are very thin (0.02 mm: 60 s, not
    over 120), but where they are not, snapping may invert tetrahedra. A stop energy above 10 is no
    remedy: it yields many times the elements.
    """
    settings = (
        Attempt(1.0),
        Attempt(2.0),
        Attempt(1.0, size_factor=0.8),
        Attempt(0.6, iterations=120, stop_energy=8.0),
        Attempt(0.6, size_factor=0.85),
    )
    order = [(way, setting) for setting in settings for way in ways]
    order = [order[0], *order]
    return [order[i % len(order)] for i in range(max(1, count))]


@mesher("tetwild", place=1)
class TetWild(Mesher):
    """fTetWild: any finger."""

    elements_from = "fTetWild's size field integrated over the body"

    def make(self, design: Design, own: None, zone: Zone, symmetric: bool) -> Mesh:
        return tetrahedralise(design, zone, symmetric)

    def refusals(self, design: Design, symmetric: bool) -> list[Fault]:
        return tetwild_faults(design, symmetric)
