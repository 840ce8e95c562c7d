"""The section of a finger whose plates sit off their places: its mesh carried along, its readings.

A mesh made anew differs by its own error, which would hide the effect of a few hundredths of a
millimetre. So one mesh is made and its nodes are moved: the plates' rigidly, the rubber's between
them by a Laplace equation that lets small triangles deform least; outside and core stay.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.types import TRIANGLE_EDGES, Mesh

if TYPE_CHECKING:
    from fingerdesign.design.contact_zone import Zone
    from fingerdesign.design.layout import PlateFrame
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design


_LEAST_AREA = 0.2  # of its own, that a moved triangle keeps: below it the move is too far


@dataclass(frozen=True)
class Move:
    """How far each of k plates is from its place: ``x``, ``y`` (k,) mm, ``angle`` (k,) degrees."""

    x: Array
    y: Array
    angle: Array

    def scaled(self, share: float) -> Move:
        """The same move, ``share`` times as far."""
        return Move(share * self.x, share * self.y, share * self.angle)

    def of(self, frames: tuple[PlateFrame, ...]) -> tuple[PlateFrame, ...]:
        """The frames where the move leads."""
        return tuple(
            replace(
                frame,
                place=frame.place + float(self.x[k]),
                y=frame.y + float(self.y[k]),
                angle_deg=frame.angle_deg + float(self.angle[k]),
            )
            for k, frame in enumerate(frames)
        )


def moved_mesh(mesh: Mesh, frames: tuple[PlateFrame, ...], move: Move) -> Mesh:
    """The section's mesh with its plates moved; the same triangles.

    Raises MeshError where a triangle would lose most of its area: the plates were moved too far.
    """
    shift = np.zeros(mesh.points.shape)
    held = np.zeros(len(mesh.points), dtype=bool)
    held[np.unique(np.concatenate([facet.ravel() for facet in mesh.facets.values()]))] = True
    numbers = [frame.index + 1 for frame in frames]
    apart = ~np.isin(mesh.regions, [0, *numbers])  # a core
    held[np.unique(mesh.cells[apart])] = True
    for k, frame in enumerate(frames):
        nodes = np.unique(mesh.cells[mesh.regions == numbers[k]])
        angle = np.radians(move.angle[k])
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        offset = mesh.points[nodes] - frame.centre
        shift[nodes] = offset @ turn.T - offset + [move.x[k], move.y[k]]
        held[nodes] = True
    shift = _spread(mesh, shift, held)
    points = mesh.points + shift
    share = _areas(points, mesh.corners) / _areas(mesh.points, mesh.corners)
    if share.min() < _LEAST_AREA:
        raise MeshError(
            f"moved so far, the plates leave a triangle {share.min():.2g} of its area; plates or "
            "surface are too close for such a tolerance"
        )
    return replace(mesh, points=points)


def readings(
    design: Design,
    mesh: Mesh,
    frames: tuple[PlateFrame, ...],
    zone: Zone,
    scene: Scene,
) -> Array:
    """What the gages of ``frames`` read (rows, frames), microstrain, along a scene's path.

    Raises SolverError where a row has no answer, ZoneExhausted where the candidates do not do.
    """
    from fingerdesign.contact.problem import contact_problem
    from fingerdesign.fem.body import condense_body, reduced_model
    from fingerdesign.fem.model import body_of, candidate_facets
    from fingerdesign.fem.readout import gage_rows
    from fingerdesign.fidelity.readings import readings_of
    from fingerdesign.load_path import follow_path
    from fingerdesign.pipeline import one_thread
    from fingerdesign.scene_contact import object_at_touch

    body = body_of(design, mesh, candidate_facets(mesh, zone.half_width))
    condensed = condense_body(body, [gage_rows(mesh, frames, design.gages)])
    centres = np.vstack([frame.to_space(frame.centre, frame.middle) for frame in frames])
    reduced = reduced_model(
        condensed,
        gage_readout=condensed.readouts[0],
        gage_positions=centres,
        depth=design.body.depth_mm,
    )
    rigid = object_at_touch(scene.object, design.body)
    problem = contact_problem(reduced, rigid, scene.object.friction_coefficient)
    with one_thread():
        return readings_of(follow_path(problem, scene, design), design.gages.face).reading


def _spread(mesh: Mesh, shift: Array, held: NDArray[np.bool_]) -> Array:
    """Shifts (n, 2) of all nodes from those of the held ones: harmonic over the triangles' corners,
    each weighing by one over its area; middles of edges stay in the middle."""
    used = np.unique(mesh.corners)
    stiffness = _laplacian(mesh)
    known, free = used[held[used]], used[~held[used]]
    spread = shift.copy()
    if len(free):
        load = -(stiffness[free][:, known] @ shift[known])
        solve = sp.linalg.splu(stiffness[free][:, free].tocsc())
        spread[free] = solve.solve(load)
    pairs = mesh.corners[:, TRIANGLE_EDGES].reshape(-1, 2)
    middles = mesh.cells[:, 3:].reshape(-1)
    loose = ~held[middles]
    spread[middles[loose]] = spread[pairs[loose]].mean(axis=1)
    return spread


def _laplacian(mesh: Mesh) -> sp.csr_matrix:
    """Stiffness (n, n) of a Laplace equation whose coefficient is one over a triangle's area."""
    nodes = mesh.corners
    corner = mesh.points[nodes]
    area = _areas(mesh.points, nodes)
    edge = corner[:, [2, 0, 1]] - corner[:, [1, 2, 0]]  # opposite to each corner
    local = np.einsum("cia,cja->cij", edge, edge) / (4.0 * area**2)[:, None, None]
    row, column = np.repeat(nodes, 3, axis=1), np.tile(nodes, (1, 3))
    size = (len(mesh.points),) * 2
    entries = (local.ravel(), (row.ravel(), column.ravel()))
    return sp.csr_matrix(entries, shape=size)


def _areas(points: Array, triangles: IntArray) -> Array:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return np.asarray(0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]))
