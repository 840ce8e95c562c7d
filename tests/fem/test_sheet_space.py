"""Sheets in tetrahedra, along x or z, of any span: uniform strain, rigid motions, gages."""

import numpy as np
import pytest
import scipy.sparse as sp

from fingerdesign.design.schema import Gages
from fingerdesign.errors import SolverError
from fingerdesign.fem.readout import gage_rows, plate_at, plate_strain_rows
from fingerdesign.fem.sheet import sheet_of, sheet_stiffness
from fingerdesign.fem.system import assemble_system
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.measures import oriented
from fingerdesign.mesh.tetra.slots import open_slots
from fingerdesign.mesh.types import Mesh, quadratic, with_mid_nodes
from tests.support.boxes import simplices

E, NU, T = 4.96, 0.49, 0.1
TILTED = PlateFrame(0, 0.4, 0.3, 35.0, 2.0, T, -1.0, 1.0)
FRAMES = {
    "inside": TILTED,
    "flush": PlateFrame(0, 0.4, 0.3, 35.0, 2.0, T, -2.0, 2.0),
    "crosswise": PlateFrame(0, 0.4, 0.3, -20.0, 2.0, T, -1.0, 1.0, "z"),
}
AXIAL = (1.0, 0.0)
GAGES = Gages(length_mm=0.8, width_mm=0.6, z_mm=0.2)


def slotted(frame):
    """A block around one plate, in its axes, with a slot; shaken off the mid-surface."""
    local, tets = simplices(*[np.linspace(-2, 2, 9)] * 3)
    shaken = (np.abs(local) < 1.9).all(axis=1) & (local[:, 1] != 0.0)
    rng = np.random.default_rng(1)
    local[shaken] += rng.uniform(-0.05, 0.05, (shaken.sum(), 3))
    points = frame.to_space(frame.from_local(local[:, 0], local[:, 1]), local[:, 2])
    tets = oriented(points, tets)
    middle = local[tets].mean(axis=1)
    box = (np.abs(middle[:, 0]) < 0.5 * frame.length) & (np.abs(middle[:, 1] - 0.25) < 0.24)
    box &= (middle[:, 2] > frame.low) & (middle[:, 2] < frame.high)
    slots = open_slots(points, tets, box.astype(np.int64), (frame,))
    nodes, cells = quadratic(slots.points, slots.tets)
    facets = {n: with_mid_nodes(cells, f) for n, f in slots.facets.items()}
    return Mesh(nodes, cells, slots.regions, facets, "grid")


@pytest.fixture(scope="module", params=list(FRAMES))
def case(request):
    frame = FRAMES[request.param]
    return frame, slotted(frame)


def axes(frame):
    """Rows: unit vectors along the plate, through it, across."""
    both = frame.direction(np.stack([frame.axis, frame.normal]))
    return np.vstack([both, frame.to_space(np.zeros(2), 1.0)])


def whole(mesh, frame):
    """Stiffness of the rubber and of a sheet of the same material."""
    count = len(mesh.cells)
    free = np.zeros(mesh.points.size, dtype=bool)
    rubber = assemble_system(mesh, np.full(count, E), np.full(count, NU), free).stiffness
    sheet = sheet_stiffness(mesh, [frame], E, NU)
    return tuple(sp.csr_matrix(m + sp.triu(m, k=1).T) for m in (rubber, sheet))


def test_rigid_motions_cost_nothing(case):
    frame, mesh = case
    _, sheet = whole(mesh, frame)
    scale = abs(sheet).max()
    for k in range(3):
        turn = np.cross(np.eye(3)[k], mesh.points)
        for motion in (np.tile(np.eye(3)[k], (len(mesh.points), 1)), turn):
            assert np.abs(sheet @ motion.ravel()).max() < 1e-10 * scale


def test_no_other_motion_is_free(case):
    frame, mesh = case
    dofs = sheet_of(mesh, frame).dofs
    _, sheet = whole(mesh, frame)
    values = np.linalg.eigvalsh(sheet[dofs][:, dofs].toarray())
    assert (np.abs(values) < 1e-9 * values[-1]).sum() == 6


def test_uniform_strain_crosses_the_slot(case):
    """A sheet of rubber in a block of rubber stores what a full block does, and bears on it as a
    full block would, but where the rim lumps what square ends spread over their height."""
    frame, mesh = case
    rubber, sheet = whole(mesh, frame)
    local = np.array([[2.0, 0.0, 0.7], [0.0, -1.2, 0.0], [0.7, 0.0, 0.9]]) * 1e-3
    turn = axes(frame)
    strain = turn.T @ local @ turn
    u = (mesh.points @ strain).ravel()
    first, shear = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
    density = 0.5 * first * np.trace(local) ** 2 + shear * np.sum(local**2)
    energy = 0.5 * u @ (rubber @ u + sheet @ u)
    assert energy == pytest.approx(density * 64.0, rel=1e-9)
    force = ((rubber + sheet) @ u).reshape(-1, 3)
    s, v = frame.local(mesh.points).T
    w = frame.across(mesh.points)
    inside = (np.abs(np.stack([s, v, w])) < 2.0 - 1e-9).all(axis=0)
    rim = np.abs(np.abs(s) - 1.0) < 1e-9
    rim |= np.abs(np.abs(w - frame.middle) - 0.5 * frame.span) < 1e-9
    rim &= np.abs(v) < 0.5 * T + 1e-9
    scale = np.abs(rubber @ u).max()
    assert np.abs(force[inside & ~rim]).max() < 1e-9 * scale


def test_gages_read_stretch_and_bending(case):
    frame, mesh = case
    s, v = frame.local(mesh.points).T
    w = frame.across(mesh.points)
    stretch, curvature = 3e-4, 0.02
    along = stretch * s - v * curvature * s + 1e-4 * w
    u = np.column_stack([along, 0.5 * curvature * s**2, 2e-4 * s + 5e-5 * w]) @ axes(frame)
    half = 0.5 * T * curvature
    got = gage_rows(mesh, [frame], GAGES, AXIAL) @ u.ravel()
    np.testing.assert_allclose(got, [stretch - half, stretch + half], rtol=1e-9)
    tee = gage_rows(mesh, [frame], GAGES, (1.0, 0.4)) @ u.ravel()
    np.testing.assert_allclose(tee - got, 2e-5, rtol=1e-9)
    wide = Gages(length_mm=0.8, width_mm=3.0, z_mm=1.5)
    with pytest.raises(SolverError, match="off the plate"):
        gage_rows(mesh, [frame], wide, AXIAL)


def test_strain_inside_a_sheet(case):
    frame, mesh = case
    squeeze = -NU / (1 - NU) * (2e-3 + 9e-4)
    local = np.array([[2e-3, 0.0, 7e-4], [0.0, squeeze, 0.0], [7e-4, 0.0, 9e-4]])
    turn = axes(frame)
    strain = turn.T @ local @ turn
    point = frame.to_space(frame.from_local(0.31, 0.02), 0.4)[0]
    assert plate_at([frame], point) is frame
    assert plate_at([frame], point + 0.1 * turn[1]) is None
    assert plate_at([frame], point + 3.0 * turn[2]) is None
    got = plate_strain_rows(mesh, frame, NU, point) @ (mesh.points @ strain).ravel()
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = strain
    np.testing.assert_allclose(got, [xx, yy, zz, 2 * xy, 2 * xz, 2 * yz], atol=1e-12)


def test_gages_of_a_half_are_those_of_the_whole():
    """On a plate along z that the symmetry plane cuts, places at z < 0 are mirrored."""
    frame = PlateFrame(0, 0.0, 0.0, 0.0, 2.0, T, -1.0, 1.0, "z")
    mesh = slotted(frame)
    kept = Mesh(mesh.points, mesh.cells, mesh.regions, mesh.facets, "grid", symmetric=True)
    z = mesh.points[:, 2]
    u = np.zeros_like(mesh.points)
    u[:, 2] = 1e-3 * z + 2e-4 * z**3 * mesh.points[:, 1]
    rows = [gage_rows(m, [frame], GAGES, AXIAL) @ u.ravel() for m in (mesh, kept)]
    np.testing.assert_allclose(rows[0], rows[1], rtol=1e-9)
