"""Sheets against plate theory: patches, a beam's rate, rigid motions, gages, solid plates.

In sections and fingers swept through layers, and in tetrahedra along x or z, of any span.
"""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from fingerdesign import parse_design, with_values
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.design.schema import Gages
from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.fem.model import build_model
from fingerdesign.fem.readout import gage_rows, plate_at, plate_strain_rows
from fingerdesign.fem.sheet import SheetFacets, sheet_of, sheet_stiffness
from fingerdesign.fem.stiffness import lame_parameters
from fingerdesign.fem.system import Body, assemble_system
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cells import quadratic, with_mid_nodes
from fingerdesign.mesh.measures import oriented
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.tetra.slots import open_slots
from fingerdesign.mesh.tetra.tetwild import tetrahedralise
from fingerdesign.mesh.types import Mesh
from fingerdesign.shapes.objects import Plane
from tests.support.boxes import simplices

E, NU, T, LENGTH = 1.35e5, 0.33, 0.1, 2.0
DESIGN = parse_design(
    """
    design.name = "one-sheet"
    body.depth_mm = 2.0
    plates.placement = [[0.3, 10.5, 30.0]]
    plates.model = "sheet"
    mesh.layers = 3
    mesh.contact_size_mm = 1.0
    mesh.plate_size_mm = 0.4
    mesh.section.contact_size_mm = 0.5
    mesh.section.plate_size_mm = 0.3
    mesh.section.plate_end_size_mm = 0.3
    """
)
FRAME = plate_frames(DESIGN)[0]
BLOCKS = {
    "inside": PlateFrame(0, 0.4, 0.3, 35.0, LENGTH, T, -1.0, 1.0),
    "flush": PlateFrame(0, 0.4, 0.3, 35.0, LENGTH, T, -2.0, 2.0),
    "crosswise": PlateFrame(0, 0.4, 0.3, -20.0, LENGTH, T, -1.0, 1.0, "z"),
}
GAGES, AXIAL = Gages(length_mm=0.8, width_mm=0.6, z_mm=0.2), (1.0, 0.0)


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


@pytest.fixture(scope="module", params=["section", "half", "whole", *BLOCKS])
def case(request):
    """A plate, and a mesh with its slot."""
    if request.param in BLOCKS:
        return BLOCKS[request.param], slotted(BLOCKS[request.param])
    if request.param == "section":
        return FRAME, mesh_section(DESIGN, 1.0)
    return FRAME, extrude(DESIGN, Zone(1.0), request.param == "half")


def stiffness(frame, mesh, young=E, nu=NU):
    upper = sheet_stiffness(mesh, [frame], young, nu)
    return sp.csr_matrix(upper + sp.triu(upper, k=1).T)


def coordinates(frame, mesh):
    """Places of all nodes along the plate, through it, and across its section."""
    along, through = frame.local(mesh.points).T
    return along, through, frame.across(mesh.points) if mesh.dimension == 3 else 0.0 * along


def axes(frame, mesh):
    """Rows: unit vectors along the plate, through it and, in space, across."""
    if mesh.dimension == 2:
        return np.stack([frame.axis, frame.normal])
    both = frame.direction(np.stack([frame.axis, frame.normal]))
    return np.vstack([both, frame.to_space(np.zeros(2), 1.0)])


def field(frame, mesh, along, through, across=0.0):
    """Displacements (n dim,) with the given components."""
    parts = np.broadcast_arrays(along, through, across)[: mesh.dimension]
    return (np.column_stack(parts) @ axes(frame, mesh)).ravel()


def area(frame, mesh):
    """Of the modelled part of a plate, mm^2; of a section's per mm."""
    if mesh.dimension == 2:
        return LENGTH
    return LENGTH * (frame.high - max(frame.low, float(frame.across(mesh.points).min())))


def test_rigid_motions_cost_nothing_and_no_others_are_free(case):
    frame, mesh = case
    matrix, dim, points = stiffness(frame, mesh), mesh.dimension, mesh.points
    motions = [np.tile(row, (len(points), 1)) for row in np.eye(dim)]
    for a, b in zip(*np.triu_indices(dim, 1), strict=True):
        turn = np.zeros_like(points)
        turn[:, a], turn[:, b] = -points[:, b], points[:, a]
        motions.append(turn)
    scale = abs(matrix).sum(axis=1).max()
    for motion in motions:
        assert np.abs(matrix @ motion.ravel()).max() < 1e-11 * scale
    if frame is FRAME and dim == 3:
        return  # too many for their eigenvalues
    dofs = sheet_of(mesh, frame).dofs
    values = np.linalg.eigvalsh(matrix[dofs][:, dofs].toarray())
    assert values[0] > -1e-12 * values[-1]
    assert (values < 1e-9 * values[-1]).sum() == len(motions)


def test_stretching_patch(case):
    """Pulled along, free across: the energy of plane stress, and forces at the ends only."""
    frame, mesh = case
    matrix, (s, n, w) = stiffness(frame, mesh), coordinates(frame, mesh)
    stretch = 1e-3
    u = field(frame, mesh, stretch * s, -NU / (1 - NU) * stretch * n)
    wanted = 0.5 * E / (1 - NU**2) * stretch**2 * T * area(frame, mesh)
    assert 0.5 * u @ matrix @ u == pytest.approx(wanted, rel=1e-9)
    force = (matrix @ u).reshape(mesh.points.shape)
    inside = np.abs(s) < 0.5 * LENGTH - 1e-9
    for end in (max(frame.low, w.min()), min(frame.high, w.max())):
        # where z is held, or ends, it bears on what holds it
        inside &= (np.abs(w - end) > 1e-9) | (mesh.dimension == 2)
    assert np.abs(force[inside]).max() < 1e-9 * np.abs(force).max()


def test_bending_patch(case):
    """w quadratic along and in z, the faces turning with it: the plate's energy exactly."""
    frame, mesh = case
    matrix, (s, n, z) = stiffness(frame, mesh), coordinates(frame, mesh)
    a, b, c = (0.02, 0.013, 0.007) if mesh.dimension == 3 else (0.02, 0.0, 0.0)
    w = 0.5 * a * s**2 + 0.5 * b * z**2 + c * s * z
    u = field(frame, mesh, -n * (a * s + c * z), w, -n * (b * z + c * s))
    rigidity = E * T**3 / (12 * (1 - NU**2))
    density = 0.5 * rigidity * (a**2 + b**2 + 2 * NU * a * b + 2 * (1 - NU) * c**2)
    assert 0.5 * u @ matrix @ u == pytest.approx(density * area(frame, mesh), rel=1e-8)


def beam(mesh):
    """Worst error, over the largest deflection, of a simply supported strip under even load."""
    sheet: SheetFacets = sheet_of(mesh, FRAME)
    matrix, (s, _, _) = stiffness(FRAME, mesh, nu=0.0), coordinates(FRAME, mesh)
    dimension = mesh.dimension
    where, weights = quadrature(sheet.kind, 4)
    shape = tabulate(sheet.kind, where).value @ (weights / weights.sum())
    load = np.zeros(mesh.points.shape)
    for nodes in (sheet.nodes, sheet.nodes_below):
        part = 0.5 * sheet.measure[:, None, None] * shape[None, :, None] * sheet.normal
        np.add.at(load, sheet.own[nodes], part)
    upper, lower = sheet.own[sheet.upper], sheet.own[sheet.lower]
    ends = np.concatenate([upper, lower])
    ends = ends[np.abs(np.abs(s[ends]) - 0.5 * LENGTH) < 1e-9]
    # Held in the plate's axes: turn each node's components into them.
    local = np.eye(dimension)
    local[:2, :2] = [FRAME.axis, FRAME.normal]
    turn = sp.kron(sp.identity(len(mesh.points)), local, format="csr")
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[ends, 1] = True
    held[upper[0], 0] = True
    if dimension == 3:
        held[:, 2] = True  # cylindrical bending
    chosen = np.zeros(mesh.points.shape, dtype=bool)
    chosen[sheet.own] = True
    free = np.flatnonzero((chosen & ~held).reshape(-1))
    turned = (turn @ matrix @ turn.T).tocsr()
    solution = np.zeros(mesh.points.size)
    solution[free] = spsolve(turned[free][:, free].tocsc(), (turn @ load.reshape(-1))[free])
    w = solution.reshape(mesh.points.shape)[:, 1]
    mean = 0.5 * (w[upper] + w[lower])
    x = s[upper] + 0.5 * LENGTH
    rigidity = E * T**3 / 12.0
    exact = x * (LENGTH**3 - 2 * LENGTH * x**2 + x**3) / (24 * rigidity)
    exact += x * (LENGTH - x) / (2 * 5 / 6 * E / 2 * T)  # by shear
    return float(np.abs(mean - exact).max() / exact.max())


def test_a_beam_bends_at_fourth_order():
    sizes, errors = (0.4, 0.2, 0.1, 0.05), []
    for size in sizes:
        keys = {"mesh.section.plate_size_mm": size, "mesh.section.plate_end_size_mm": size}
        errors.append(beam(mesh_section(with_values(DESIGN, keys), 1.0)))
    rate = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert rate > 3.5
    assert errors[-1] < 1e-6
    coarse, fine = (  # strips in space
        beam(extrude(DESIGN, Zone(1.0), sizes=DESIGN.mesh.section.model_copy(update=each)))
        for each in ({"plate_size_mm": s, "plate_end_size_mm": s} for s in (0.5, 0.25))
    )
    assert fine < 3e-3
    assert fine < 0.2 * coarse


def test_gages_read_stretch_and_bending(case):
    frame, mesh = case
    s, n, w = coordinates(frame, mesh)
    odd = 0.0 if mesh.symmetric else 1.0  # motions that a mirror in z = 0 forbids
    stretch, curvature = 3e-4, 0.02
    along = stretch * s - n * curvature * s + odd * 1e-4 * w
    across = odd * 2e-4 * s + 5e-5 * w
    u = field(frame, mesh, along, 0.5 * curvature * s**2, across)
    bending = 0.5 * T * curvature
    got = gage_rows(mesh, [frame], GAGES, AXIAL) @ u
    np.testing.assert_allclose(got, [stretch - bending, stretch + bending], rtol=1e-8)
    tee = gage_rows(mesh, [frame], GAGES, (1.0, 0.4)) @ u
    np.testing.assert_allclose(tee - got, 2e-5 * (mesh.dimension - 2), rtol=1e-8)
    with pytest.raises(SolverError, match="off the plate"):
        gage_rows(mesh, [frame], Gages(length_mm=3.0), AXIAL)


def test_strain_inside_a_sheet(case):
    """At a place in it the plate's own strain, turned into the global axes."""
    frame, mesh = case
    dim = mesh.dimension
    local = np.array([[2e-3, 0.0, 7e-4], [0.0, 0.0, 0.0], [7e-4, 0.0, 9e-4]])[:dim, :dim]
    local[1, 1] = -NU / (1 - NU) * np.trace(local)
    turn, strain = axes(frame, mesh), np.zeros((3, 3))
    strain[:dim, :dim] = turn.T @ local @ turn
    point = frame.to_space(frame.from_local(0.31, 0.02), 0.4)[0][:dim]
    assert plate_at([frame], point) is frame
    assert plate_at([frame], point + 0.1 * turn[1]) is None
    assert plate_at([frame], point + 3.0 * turn[-1]) is None
    u = mesh.points @ strain[:dim, :dim]
    got = plate_strain_rows(mesh, frame, NU, point) @ u.ravel()
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = strain
    np.testing.assert_allclose(got, [xx, yy, zz, 2 * xy, 2 * xz, 2 * yz], atol=1e-11)


@pytest.mark.parametrize("name", BLOCKS)
def test_uniform_strain_crosses_the_slot(name):
    """A sheet of rubber in a block of rubber stores what a full block does, and bears on it as a
    full block would, but where the rim lumps what square ends spread over their height."""
    frame, young, poisson = BLOCKS[name], 4.96, 0.49
    mesh = slotted(frame)
    moduli = (np.full(len(mesh.cells), each) for each in (young, poisson))
    free = np.zeros(mesh.points.size, dtype=bool)
    upper = assemble_system(Body(mesh, *moduli, free, mesh.cells[:0, :6])).stiffness
    rubber = sp.csr_matrix(upper + sp.triu(upper, k=1).T)
    both = rubber + stiffness(frame, mesh, young, poisson)
    local = np.array([[2.0, 0.0, 0.7], [0.0, -1.2, 0.0], [0.7, 0.0, 0.9]]) * 1e-3
    u = (mesh.points @ axes(frame, mesh).T @ local @ axes(frame, mesh)).ravel()
    first, shear = lame_parameters(np.array(young), np.array(poisson))
    density = 0.5 * first * np.trace(local) ** 2 + shear * np.sum(local**2)
    assert 0.5 * u @ (both @ u) == pytest.approx(density * 64.0, rel=1e-9)
    force = (both @ u).reshape(-1, 3)
    s, v, w = coordinates(frame, mesh)
    inside = (np.abs(np.stack([s, v, w])) < 2.0 - 1e-9).all(axis=0)
    rim = np.abs(np.abs(s) - 1.0) < 1e-9
    rim |= np.abs(np.abs(w - frame.middle) - 0.5 * frame.span) < 1e-9
    rim &= np.abs(v) < 0.5 * T + 1e-9
    assert np.abs(force[inside & ~rim]).max() < 1e-9 * np.abs(rubber @ u).max()


def test_gages_of_a_half_are_those_of_the_whole():
    """On a plate along z that the symmetry plane cuts, places at z < 0 are mirrored."""
    frame = PlateFrame(0, 0.0, 0.0, 0.0, LENGTH, T, -1.0, 1.0, "z")
    mesh = slotted(frame)
    z = mesh.points[:, 2]
    u = np.zeros_like(mesh.points)
    u[:, 2] = 1e-3 * z + 2e-4 * z**3 * mesh.points[:, 1]
    both = (mesh, replace(mesh, symmetric=True))
    rows = [gage_rows(m, [frame], GAGES, AXIAL) @ u.ravel() for m in both]
    np.testing.assert_allclose(rows[0], rows[1], rtol=1e-9)


def test_a_mesh_without_slots_is_refused():
    solid = mesh_section(with_values(DESIGN, {"plates.model": "solid"}), 1.0)
    with pytest.raises(SolverError, match=r"no slot for plate 0.*plates\.model = 'sheet'"):
        sheet_stiffness(solid, [FRAME], E, NU)


PUSHED = (Motion(0.3, 0.0), Motion(0.3, 0.2))


def loaded(design, mesh=None, zone=3.0, motions=PUSHED):
    """F_n, F_t and the gages (plates, 2) after the motions; by default of the section."""
    mesh = mesh_section(design, zone) if mesh is None else mesh
    model = build_model(design, mesh, zone).reduced
    problem = contact_problem(model, Plane(crest_height(design.body)), 0.5)
    measures = list(follow(problem, motions))[-1].measures
    return measures.normal_force, measures.tangential_force, np.asarray(measures.gages)


THREE = with_values(
    DESIGN,
    {
        "plates.placement": [[-1.0, 10.5, 45.0], [0.0, 10.5, 45.0], [1.0, 10.5, 45.0]],
        "gages.z_mm": 0.0,
        "mesh.section.contact_size_mm": 0.1,
        "mesh.section.plate_size_mm": 0.1,
        "mesh.section.plate_end_size_mm": 0.05,
    },
)


def test_sheets_against_solid_plates():
    fine = {"mesh.section.plate_size_mm": 0.05, "mesh.section.plate_end_size_mm": 0.01}
    sheet, solid = loaded(THREE), loaded(with_values(THREE, {"plates.model": "solid", **fine}))
    assert sheet[:2] == pytest.approx(solid[:2], rel=2e-3)
    membrane, reference = sheet[2].mean(axis=1), solid[2].mean(axis=1)
    assert np.abs(membrane - reference).max() < 0.03 * np.abs(reference).max()
    assert np.abs(sheet[2] - solid[2]).max() < 0.03 * np.abs(solid[2]).max()


SHORT = parse_design(
    """
    design.name = "short-plate"
    body.width_mm = 8.0
    body.base_height_mm = 4.0
    body.arc_radius_mm = 10.0
    body.depth_mm = 6.0
    plates.count = 1
    plates.thickness_mm = 0.2
    plates.length_mm = 2.0
    plates.cover_mm = 1.5
    plates.span_mm = 3.0
    plates.angle_deg = 30.0
    gages.length_mm = 0.8
    mesh.contact_size_mm = 0.5
    mesh.plate_size_mm = 0.25
    """
)


@pytest.mark.slow
def test_short_sheets_along_z_against_solid_plates_in_tetrahedra():
    """Along x both models agree in plane strain, above.

    fTetWild's meshes differ from run to run, and bending with them: on elements of 0.25 mm at
    the plates faces scatter by 0.5 % (standard deviation); worst of all pairs of 13 and 13 meshes:
    faces 2.0 %, membrane 0.3 %, F_t 1.9 %.
    """
    design, found = with_values(SHORT, {"plates.along": "z"}), []
    for model in ("sheet", "solid"):
        given = with_values(design, {"plates.model": model})
        mesh = tetrahedralise(given, Zone(2.8), symmetric=False, use_cache=False)
        motions = [Motion(0.1, 0.0), Motion(0.2, 0.0), Motion(0.2, 0.05, 0.05)]
        found.append(loaded(given, mesh, 2.8, motions))
    sheet, solid = found
    assert sheet[0] == pytest.approx(solid[0], rel=5e-3)
    assert sheet[1] == pytest.approx(solid[1], rel=2e-2)  # contact facets of 0.5 mm
    largest = np.abs(solid[2]).max()
    assert np.abs(sheet[2] - solid[2]).max() < 0.03 * largest
    membrane = np.abs(sheet[2].mean(axis=1) - solid[2].mean(axis=1)).max()
    assert membrane < 0.01 * largest
