"""fTetWild run safely: its input validated, in a process and folder of its own, with a time limit.

fTetWild (https://github.com/wildmeshing/fTetWild) crashes on empty or coincident input, hangs on
an epsilon of 0, returns wrong meshes for open surfaces without a word, and litters its folder.
"""

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.sizing import SizeField
from fingerdesign.mesh.tetra.background import background_grid
from fingerdesign.runtime import files, isolate

TETRAHEDRALISE = "pytetwild:tetrahedralize"  # only its own process loads it
# Longest edge over the surface's diagonal. With edges of two thirds of the diagonal fTetWild made
# 100 000 tetrahedra of a cube; with a fifth, 2000.
LONGEST_EDGE = 0.12
# fTetWild reads its sizes where the vertices of a first, even mesh lie, and sizes the rest between
# them; then it works until its worst tetrahedron is good. After a first mesh with edges of 2 mm it
# went over the finished mesh 9 to 20 times on eight of the ten shipped fingers, after one of these
# edges (of the surface's diagonal; or with FIRST_SHARE of the final tetrahedra) twice: the ten
# took half the processor time.
FIRST_EDGE, FIRST_SHARE = 0.04, 0.4


class MesherFailed(MeshError):
    """fTetWild crashed, hung or gave no answer; the folder ``input`` holds its input."""

    def __init__(self, message: str, folder: Path) -> None:
        super().__init__(message)
        self.input = folder


@dataclass(frozen=True)
class Attempt:
    """One setting of fTetWild: envelope (mm when it runs; before, a factor on the usual one),
    iterations, energy to stop at, size factor."""

    envelope: float
    iterations: int = 80
    stop_energy: float = 10.0
    size_factor: float = 1.0


def validate_surface(vertices: Array, triangles: IntArray) -> None:
    """MeshError unless a surface is fit for native code: closed, nothing coincident.

    Faces shared inside (of a plate) make edges of three and four triangles: those are allowed, an
    edge of one is not.
    """
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
    vertices: Array,
    triangles: IntArray,
    field: SizeField,
    attempt: Attempt,
    time_limit_s: float,
    elements: float,
) -> tuple[Array, IntArray]:
    """Run fTetWild in a process of its own; returns points (n, 3) and tetrahedra (t, 4) of a box.

    elements: the number that the field leads to.
    The tetrahedra fill a box around the surface: the caller selects those inside. MeshError on
    unfit input, MesherFailed on crash and time-out, whose message names the stored input.
    Memory is bounded by the time limit only: an address-space limit makes the threads' allocator
    fail at random.
    """
    validate_surface(vertices, triangles)
    box = vertices.min(axis=0), vertices.max(axis=0)
    grid_points, grid_tets, grid_values = background_grid(field, *box)
    # Meshed in a space that is squeezed along z: its even tetrahedra come out stretched.
    squeeze = np.array([1.0, 1.0, 1.0 / field.sizes.stretch])
    squeezed = vertices * squeeze
    diagonal = float(np.linalg.norm(np.ptp(squeezed, axis=0)))
    longest = min(field.sizes.far, LONGEST_EDGE * diagonal)
    even = np.ptp(squeezed, axis=0).prod() * 6.0 * np.sqrt(2.0) / (FIRST_SHARE * elements)
    given = {
        "vertices": squeezed,
        "faces": triangles.astype(np.int32),
        "bg_vertices": grid_points * squeeze,
        "bg_tets": grid_tets,
        "bg_values": np.minimum(grid_values, longest),
    }
    options = {
        "edge_length_abs": min(longest, max(FIRST_EDGE * diagonal, float(np.cbrt(even)))),
        "epsilon": attempt.envelope / diagonal,
        "stop_energy": attempt.stop_energy,
        "num_opt_iter": attempt.iterations,
        "disable_filtering": True,  # its inside test is by winding number; ours is exact
        "quiet": True,
    }
    with files.scratch("tetwild") as folder:  # it litters where it runs
        try:
            points, tets = isolate.call(
                TETRAHEDRALISE, time_s=time_limit_s, folder=folder, **given, **options
            )
        except isolate.ProcessError as error:
            content = io.BytesIO()
            named: dict[str, Any] = given | options
            np.savez(content, **named)
            stored = files.keep_request("tetwild", "in.npz", content.getvalue())
            words = f"fTetWild: {error}; its input is stored as {stored}"
            raise MesherFailed(words, stored.parent) from error
    return points / squeeze, np.asarray(tets, dtype=np.int64)
