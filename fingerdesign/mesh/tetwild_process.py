"""fTetWild run safely: its input validated, in a process and folder of its own, with a time limit.

fTetWild (https://github.com/wildmeshing/fTetWild) crashes on empty or coincident input, hangs on an
epsilon of 0, returns wrong meshes for open surfaces without a word, and litters its folder.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.sizing import SizeField, background_grid
from fingerdesign.mesh.worker import run_module

WORKER = "fingerdesign.mesh.tetwild_worker"
# Of the surface's diagonal. Asked for edges of two thirds of it, fTetWild made 100 000 tetrahedra
# of a cube; of a fifth, 2000.
LONGEST_EDGE = 0.12


class MesherFailed(MeshError):
    """fTetWild crashed, hung or gave no answer; its input is ``kept`` (a folder) for a report."""

    def __init__(self, message: str, kept: Path) -> None:
        super().__init__(message)
        self.kept = kept


@dataclass(frozen=True)
class Attempt:
    """One setting of fTetWild: envelope (mm when it runs; before, a factor on the usual one),
    iterations, energy to stop at, size factor."""

    envelope: float
    iterations: int = 80
    stop_energy: float = 10.0
    size_factor: float = 1.0


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
    input, MesherFailed on crash and time-out; then the input is kept, and the message says where.
    Memory is bounded by the time limit only: an address-space limit makes the threads' allocator
    fail at random.
    """
    validate_surface(vertices, triangles)
    if not (np.isfinite(attempt.envelope) and attempt.envelope > 0.0):
        raise MeshError(f"fTetWild's epsilon = {attempt.envelope} mm must be above 0: it hangs")
    if not time_limit_s > 0.0:
        raise MeshError(f"mesh.time_limit_s = {time_limit_s} must be above 0")
    grid_points, grid_tets, grid_values = background_grid(
        field, vertices.min(axis=0), vertices.max(axis=0)
    )
    # Meshed in a space that is squeezed along z: its even tetrahedra come out stretched.
    squeeze = np.array([1.0, 1.0, 1.0 / field.sizes.stretch])
    squeezed = vertices * squeeze
    diagonal = float(np.linalg.norm(np.ptp(squeezed, axis=0)))
    longest = min(field.sizes.far, LONGEST_EDGE * diagonal)
    options = {
        "edge_length_abs": longest,
        "epsilon": attempt.envelope / diagonal,
        "stop_energy": attempt.stop_energy,
        "num_opt_iter": attempt.iterations,
        "disable_filtering": True,  # its inside test is by winding number; ours is exact
    }
    folder = Path(tempfile.mkdtemp(prefix="fingerdesign-tetwild-"))
    source, target = folder / "in.npz", folder / "out.npz"
    np.savez(
        source,
        vertices=squeezed,
        triangles=triangles,
        grid_points=grid_points * squeeze,
        grid_tets=grid_tets,
        grid_values=np.minimum(grid_values, longest),
        options=json.dumps(options),
    )
    try:
        run_module(WORKER, [source.name, target.name], folder, time_limit_s)
        if not target.exists():
            raise MeshError("it wrote no answer")
        with np.load(target) as data:
            points, tets = data["points"] / squeeze, data["tets"].astype(np.int64)
    except MeshError as error:  # the input stays for whoever looks into it
        raise MesherFailed(f"fTetWild: {error}; its input is kept as {source}", folder) from error
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    shutil.rmtree(folder, ignore_errors=True)
    return points, tets
