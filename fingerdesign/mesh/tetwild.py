"""Tetrahedra for any finger, plates as solids: CAD surface -> fTetWild -> snapped quadratic mesh.

fTetWild (https://github.com/wildmeshing/fTetWild) takes triangles that need not be clean, and keeps
them within an envelope of ``epsilon``. It is not deterministic, and wrong input crashes or hangs
it, or yields a wrong mesh without a word: input is validated first, it runs in its own process,
and its answer must pass the gate (``Gate``) or is made again.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.layout import PlateFrame
from fingerdesign.errors import MeshError
from fingerdesign.geometry.surface import ContactSurface
from fingerdesign.mesh.boundary import (
    BoundaryFacets,
    Carriers,
    boundary_facets,
    carriers_of,
    regions_by_centroid,
)
from fingerdesign.mesh.cache import keep_mesh, load_mesh, mesh_key
from fingerdesign.mesh.quality import QualityReport, assess
from fingerdesign.mesh.sizing import MeshSizes, SizeField, background_grid
from fingerdesign.mesh.snap import (
    curve_contact,
    quadratic_facets,
    snap_to_carriers,
    tet_volumes,
)
from fingerdesign.mesh.types import Mesh, quadratic

if TYPE_CHECKING:
    from fingerdesign.design.schema import Body, Design

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Edges come out longer than asked where the field is steep: mean edges at the contact were 1.33
# times the field's value there (0.28 for 0.21, 0.39 for 0.30 mm), at plates 1.0 to 1.08 times.
CONTACT_OVERSHOOT = 1.33


@dataclass(frozen=True)
class Attempt:
    """One setting of fTetWild: envelope in mm, iterations, energy to stop at, size factor."""

    epsilon_mm: float
    iterations: int = 80
    stop_energy: float = 10.0
    size_factor: float = 1.0


@dataclass(frozen=True)
class Gate:
    """What a tetrahedral mesh must fulfil (NUMERICS 7; measured on accepted meshes in brackets)."""

    body_volume_error: float = 1e-3  # [2e-5]
    plate_volume_error: float = 1e-2  # [1e-12]
    face_area_error: float = 1e-3  # [1e-5]
    min_dihedral_deg: float = 3.0  # [5 to 9]
    contact_residual_mm: float = 1e-6  # [1e-13]
    least_jacobian_ratio: float = 0.05  # [0.9]

    def faults(self, report: QualityReport) -> list[str]:
        """What a mesh fails, in words; empty when it passes."""
        found = []
        for name, bound in vars(self).items():
            value = {
                "body_volume_error": report.body_volume_error,
                "plate_volume_error": report.worst_plate_volume_error,
                "face_area_error": report.worst_face_area_error,
                "min_dihedral_deg": report.min_dihedral_deg,
                "contact_residual_mm": report.contact_residual_mm,
                "least_jacobian_ratio": report.least_jacobian_ratio,
            }[name]
            least = name in ("min_dihedral_deg", "least_jacobian_ratio")
            if not (value >= bound if least else value <= bound):
                found.append(f"{name} = {value:.3g} ({'below' if least else 'above'} {bound:g})")
        return found


def tetrahedralise(
    design: Design,
    zone_half_width_mm: float,
    symmetric: bool = True,
    sizes: MeshSizes | None = None,
    use_cache: bool = True,
) -> Mesh:
    """Mesh a finger (or its half z >= 0) with quadratic tetrahedra, fine at |x| <= zone half width.

    sizes: by default the design's ``[mesh]`` table. Meshes that passed the gate are kept by content
    and returned again unless ``use_cache`` is False. MeshError when no attempt passes.
    """
    from fingerdesign.geometry.solid import build_solid, solid_plates
    from fingerdesign.geometry.tessellation import triangulate

    sizes = sizes or MeshSizes.of(design)
    frames = solid_plates(design)
    key = mesh_key(design.body, frames, sizes, zone_half_width_mm, symmetric)
    kept = load_mesh(key) if use_cache else None
    if kept is not None and not Gate().faults(assess(kept, design)):
        return kept
    solid = build_solid(design, half=symmetric)
    epsilon = envelope_mm(design.body, frames)
    vertices, triangles = triangulate((solid.body, *solid.plates), epsilon)
    attempts = _attempts(epsilon, int(design.mesh.attempts))
    complaints = []
    for number, attempt in enumerate(attempts, start=1):
        field = size_field(design, frames, sizes.scaled(attempt.size_factor), zone_half_width_mm)
        try:
            points, tets = run_tetwild(
                vertices, triangles, field, attempt, float(design.mesh.time_limit_s)
            )
            mesh = finish(design, points, tets, frames, symmetric)
        except MeshError as error:
            complaints.append(f"attempt {number}: {error}")
            continue
        faults = Gate().faults(assess(mesh, design))
        if not faults:
            if use_cache:
                keep_mesh(key, mesh)
            return mesh
        complaints.append(f"attempt {number}: {', '.join(faults)}")
    raise MeshError(
        f"no tetrahedral mesh of {design.design.name} passed the gate in {len(attempts)} attempts; "
        + "; ".join(complaints)
    )


def envelope_mm(body: Body, frames: tuple[PlateFrame, ...]) -> float:
    """fTetWild's envelope: a tenth of the thinnest plate, at most 0.01 mm and 5e-4 of the body.

    At a quarter of the thickness plates still survive; at 1.2 times they vanish without a word.
    """
    size = float(np.hypot(np.hypot(body.width_mm, body.base_height_mm), body.depth_mm))
    return min([0.01, 5e-4 * size, *(0.1 * frame.thickness for frame in frames)])


def size_field(
    design: Design, frames: tuple[PlateFrame, ...], sizes: MeshSizes, zone_half_width: float
) -> SizeField:
    """The size field to ask fTetWild for, so that edges at the contact come out as ``sizes``."""
    asked = MeshSizes(sizes.contact / CONTACT_OVERSHOOT, sizes.plate, sizes.far, sizes.gradation)
    return SizeField(ContactSurface.of(design.body), frames, asked, zone_half_width)


def _attempts(epsilon: float, count: int) -> list[Attempt]:
    first = Attempt(epsilon)
    others = (
        Attempt(epsilon),  # not deterministic: the same again may pass
        Attempt(0.6 * epsilon, iterations=120, stop_energy=8.0),
        Attempt(0.6 * epsilon, iterations=120, stop_energy=8.0, size_factor=0.85),
        Attempt(1.5 * epsilon, size_factor=0.9),
    )
    return [first, *others, *(others[i % 4] for i in range(count))][: max(1, count)]


def validate_surface(vertices: Array, triangles: IntArray) -> None:
    """MeshError unless a surface is fit for native code: finite, closed, nothing coincident.

    Faces shared inside (of a plate) make edges of three and four triangles: those are allowed, an
    edge of one is not.
    """
    if len(vertices) < 4 or len(triangles) < 4:
        raise MeshError(f"a surface of {len(triangles)} triangles encloses nothing")
    if not np.all(np.isfinite(vertices)):
        raise MeshError("the surface has vertices that are not finite numbers")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise MeshError("the surface's triangles name vertices that do not exist")
    if len(np.unique(vertices, axis=0)) != len(vertices):
        raise MeshError("the surface has coincident vertices; merge them first")
    if len(np.unique(np.sort(triangles, axis=1), axis=0)) != len(triangles):
        raise MeshError("the surface has coincident triangles")
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    if area.min() <= 1e-14 * np.ptp(vertices, axis=0).max() ** 2:
        raise MeshError("the surface has triangles without area")
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    if uses.min() < 2:
        raise MeshError(f"the surface is open: {int((uses == 1).sum())} edges have one triangle")


def run_tetwild(
    vertices: Array, triangles: IntArray, field: SizeField, attempt: Attempt, time_limit_s: float
) -> tuple[Array, IntArray]:
    """Run fTetWild in a process of its own; returns points (n, 3) and tetrahedra (t, 4) of a box.

    The tetrahedra fill a box around the surface: the caller keeps those inside. MeshError on unfit
    input, crash and time-out; then the input is kept, and the message says where. Memory is bounded
    by the time limit only: an address-space limit makes the threads' allocator fail at random.
    """
    validate_surface(vertices, triangles)
    if not (np.isfinite(attempt.epsilon_mm) and attempt.epsilon_mm > 0.0):
        raise MeshError(f"fTetWild's epsilon = {attempt.epsilon_mm} mm must be above 0: it hangs")
    if not time_limit_s > 0.0:
        raise MeshError(f"mesh.time_limit_s = {time_limit_s} must be above 0")
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    sizes = field.sizes
    # Fine across the layers that the field rises in; the field hardly changes along z.
    spacing = (max(0.5, sizes.contact), max(0.2, 0.5 * sizes.contact), max(0.8, 2 * sizes.contact))
    grid_points, grid_tets, grid_values = background_grid(field, low, high, spacing)
    options = {
        "edge_length_abs": sizes.far,
        "epsilon": attempt.epsilon_mm / float(np.linalg.norm(high - low)),
        "stop_energy": attempt.stop_energy,
        "num_opt_iter": attempt.iterations,
        "disable_filtering": True,  # its inside test is by winding number; ours is exact
    }
    folder = Path(tempfile.mkdtemp(prefix="fingerdesign-tetwild-"))
    source, target = folder / "in.npz", folder / "out.npz"
    np.savez(
        source,
        vertices=vertices,
        triangles=triangles,
        grid_points=grid_points,
        grid_tets=grid_tets,
        grid_values=grid_values,
        options=json.dumps(options),
    )
    try:
        _run_worker(source, target, time_limit_s)
        with np.load(target) as data:
            points, tets = data["points"], data["tets"].astype(np.int64)
    except MeshError:
        raise  # the input stays for whoever looks into it
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    shutil.rmtree(folder, ignore_errors=True)
    return points, tets


def _run_worker(source: Path, target: Path, time_limit_s: float) -> None:
    command = [sys.executable, "-m", "fingerdesign.mesh.tetwild_worker", str(source), str(target)]
    package_root = str(Path(__file__).resolve().parents[2])
    paths = [package_root, os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in paths if p)}
    kept = f"its input is kept as {source}"
    try:
        done = subprocess.run(
            command,
            cwd=source.parent,
            env=environment,
            timeout=time_limit_s,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise MeshError(
            f"fTetWild did not finish in mesh.time_limit_s = {time_limit_s:g} s; coarsen the mesh "
            f"or raise the limit ({kept})"
        ) from error
    if done.returncode < 0:
        name = signal.Signals(-done.returncode).name
        raise MeshError(f"fTetWild's process was ended by {name} ({kept})")
    if done.returncode > 0 or not target.exists():
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise MeshError(f"fTetWild failed with exit code {done.returncode}: {last} ({kept})")


def finish(
    design: Design, points: Array, tets: IntArray, frames: tuple[PlateFrame, ...], symmetric: bool
) -> Mesh:
    """Keep what is inside, tag it, snap it to the CAD faces, make it quadratic, name its facets."""
    points, tets = _inside(design.body, points, tets, symmetric)
    regions = regions_by_centroid(points, tets, frames)
    carriers = carriers_of(design.body, frames, symmetric)
    found = boundary_facets(points, tets, regions, carriers)
    on_carriers = found.on_carriers(len(points), carriers.contact_number + 1)
    points = snap_to_carriers(points, on_carriers, carriers)
    volumes = tet_volumes(points, tets)
    if volumes.min() <= 0.0:
        raise MeshError(
            f"snapping to the CAD faces inverted {int((volumes <= 0).sum())} tetrahedra"
        )
    nodes, cells = quadratic(points, tets)
    facets = _named_facets(found, carriers, cells, len(nodes))
    curved = curve_contact(nodes, cells, on_carriers, carriers, facets["contact"])
    notes: dict[str, float | int | str] = {"straightened_contact_nodes": curved.straightened}
    return Mesh(curved.points, cells, regions, facets, "tetwild", symmetric, notes)


def _inside(body: Body, points: Array, tets: IntArray, symmetric: bool) -> tuple[Array, IntArray]:
    """The tetrahedra whose centroids lie in the body, positively oriented, with their points."""
    x, y, z = points[tets].mean(axis=1).T
    within = (np.abs(x) < 0.5 * body.width_mm) & (y > 0.0) & (z < 0.5 * body.depth_mm)
    within &= z > (0.0 if symmetric else -0.5 * body.depth_mm)
    surface = ContactSurface.of(body)
    within[within] = surface.distance(np.stack([x, y, z], axis=1)[within]) < 0.0
    if not within.any():
        raise MeshError("fTetWild returned no tetrahedron inside the body")
    used, renumbered = np.unique(tets[within], return_inverse=True)
    points, tets = points[used], renumbered.reshape(-1, 4).astype(np.int64)
    negative = tet_volumes(points, tets) < 0.0
    tets[negative] = tets[negative][:, [0, 2, 1, 3]]
    return points, tets


def _named_facets(
    found: BoundaryFacets, carriers: Carriers, cells: IntArray, nodes: int
) -> dict[str, IntArray]:
    outer = quadratic_facets(cells, found.corners[found.outside], nodes)
    names = np.array([carriers.name(int(n)) for n in found.carrier[found.outside]])
    return {str(name): outer[names == name] for name in np.unique(names)}
