"""Sheets against plate theory: patches, a beam's rate, rigid motions, gages, solid plates."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from fingerdesign import parse_design, with_values
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.fem.model import build_model
from fingerdesign.fem.readout import gage_rows, plate_strain_rows
from fingerdesign.fem.sheet import SheetFacets, sheet_of, sheet_stiffness
from fingerdesign.layout.frames import crest_height, plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.tetra.tetwild import tetrahedralise
from fingerdesign.shapes.objects import Plane

E, NU, T, LENGTH = 1.35e5, 0.33, 0.1, 2.0
DESIGN = parse_design(
    """
    design.name = "one-sheet"
    body.depth_mm = 2.0
    plates.placement = [[0.3, 10.5, 30.0]]
    plates.model = "sheet"
    gages.width_mm = 0.6
    gages.z_mm = 0.2
    mesh.layers = 3
    mesh.contact_size_mm = 1.0
    mesh.plate_size_mm = 0.4
    mesh.section.contact_size_mm = 0.5
    mesh.section.plate_size_mm = 0.3
    mesh.section.plate_end_size_mm = 0.3
    """
)
FRAME = plate_frames(DESIGN)[0]


@pytest.fixture(scope="module", params=["section", "half", "whole"])
def mesh(request):
    if request.param == "section":
        return mesh_section(DESIGN, 1.0)
    return extrude(DESIGN, Zone(1.0), request.param == "half")


def stiffness(mesh, nu=NU):
    upper = sheet_stiffness(mesh, [FRAME], E, nu)
    return sp.csr_matrix(upper + sp.triu(upper, k=1).T)


def coordinates(mesh):
    """Places of all nodes along the plate, across it, and in z."""
    along, across = FRAME.local(mesh.points).T
    return along, across, mesh.points[:, 2] if mesh.dimension == 3 else 0.0 * along


def field(mesh, along, across, z=None):
    """Displacements (n dim,) with the given components along the plate, across it and in z."""
    flat = along[:, None] * FRAME.axis + across[:, None] * FRAME.normal
    if mesh.dimension == 3:
        flat = np.column_stack([flat, np.zeros(len(flat)) if z is None else z])
    return np.asarray(flat.reshape(-1))


def width(mesh):
    return 1.0 if mesh.dimension == 2 else (1.0 if mesh.symmetric else 2.0)


def test_rigid_motions_cost_nothing(mesh):
    matrix, (s, n, z) = stiffness(mesh), coordinates(mesh)
    one = np.ones_like(s)
    motions = [field(mesh, one, 0 * s), field(mesh, 0 * s, one), field(mesh, -n, s)]
    if mesh.dimension == 3 and not mesh.symmetric:
        motions += [
            field(mesh, z, 0 * s, -s),
            field(mesh, 0 * s, -z, n),
            field(mesh, 0 * s, 0 * s, one),
        ]
    scale = abs(matrix).sum(axis=1).max()
    for motion in motions:
        assert np.abs(matrix @ motion).max() < 1e-12 * scale


def test_never_negative_and_no_more_free_motions():
    mesh = mesh_section(DESIGN, 1.0)
    sheet = sheet_of(mesh, FRAME)
    values = np.linalg.eigvalsh(stiffness(mesh)[sheet.dofs][:, sheet.dofs].toarray())
    assert values[0] > -1e-12 * values[-1]
    assert (values < 1e-10 * values[-1]).sum() == 3


def test_stretching_patch(mesh):
    """Pulled along, free across: the energy of plane stress, and forces at the ends only."""
    matrix, (s, n, z) = stiffness(mesh), coordinates(mesh)
    stretch = 1e-3
    thinning = -NU / (1 - NU) * stretch
    u = field(mesh, stretch * s, thinning * n)
    energy = 0.5 * u @ matrix @ u
    wanted = 0.5 * E / (1 - NU**2) * stretch**2 * T * LENGTH * width(mesh)
    assert energy == pytest.approx(wanted, rel=1e-10)
    force = (matrix @ u).reshape(mesh.points.shape)
    inside = np.abs(s) < 0.5 * LENGTH - 1e-9
    if mesh.dimension == 3:
        inside &= np.abs(z - z.min()) > 1e-9  # where z is held, or ends, it bears on what holds it
        inside &= np.abs(z - z.max()) > 1e-9
    assert np.abs(force[inside]).max() < 1e-9 * np.abs(force).max()


def test_bending_patch(mesh):
    """w quadratic along and in z, the faces turning with it: the plate's energy exactly."""
    matrix, (s, n, z) = stiffness(mesh), coordinates(mesh)
    a, b = 0.02, 0.013 if mesh.dimension == 3 else 0.0
    c = 0.007 if mesh.dimension == 3 and not mesh.symmetric else 0.0
    w = 0.5 * a * s**2 + 0.5 * b * z**2 + c * s * z
    u = field(mesh, -n * (a * s + c * z), w, -n * (b * z + c * s))
    rigidity = E * T**3 / (12 * (1 - NU**2))
    density = 0.5 * rigidity * (a**2 + b**2 + 2 * NU * a * b + 2 * (1 - NU) * c**2)
    assert 0.5 * u @ matrix @ u == pytest.approx(density * LENGTH * width(mesh), rel=1e-9)


def beam(mesh):
    """Worst error, over the largest deflection, of a simply supported strip under even load."""
    sheet: SheetFacets = sheet_of(mesh, FRAME)
    matrix, (s, _, _) = stiffness(mesh, 0.0), coordinates(mesh)
    dimension = mesh.dimension
    where, weights = quadrature(dimension - 1, 4)
    shape = tabulate(dimension - 1, where).value @ (weights / weights.sum())
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


def test_a_strip_bends_like_a_beam_in_space():
    coarse, fine = (
        beam(extrude(DESIGN, Zone(1.0), sizes=DESIGN.mesh.section.model_copy(update=sizes)))
        for sizes in (
            {"plate_size_mm": 0.5, "plate_end_size_mm": 0.5},
            {"plate_size_mm": 0.25, "plate_end_size_mm": 0.25},
        )
    )
    assert fine < 3e-3
    assert fine < 0.2 * coarse


def test_gages_read_stretch_and_bending(mesh):
    rows = gage_rows(mesh, [FRAME], DESIGN.gages, DESIGN.gage_weights)
    s, n, z = coordinates(mesh)
    stretch, curvature = 3e-4, 0.02
    u = field(mesh, stretch * s - n * curvature * s, 0.5 * curvature * s**2 + 0 * z)
    bending = 0.5 * T * curvature
    np.testing.assert_allclose(rows @ u, [stretch - bending, stretch + bending], rtol=1e-9)


def test_strain_inside_a_sheet(mesh):
    """At its centre the plate's own strain, turned into the global axes."""
    s, n, z = coordinates(mesh)
    u = field(mesh, 1e-3 * s + 4e-4 * z, 0.0 * n, 2e-4 * s)
    point = np.array([FRAME.x, FRAME.y, 0.3])[: mesh.dimension]
    got = plate_strain_rows(mesh, FRAME, NU, point) @ u
    shear = 6e-4 if mesh.dimension == 3 else 0.0
    across = -NU / (1 - NU) * 1e-3
    cos, sin = FRAME.axis
    wanted = [
        1e-3 * cos**2 + across * sin**2,
        1e-3 * sin**2 + across * cos**2,
        0.0,
        2 * (1e-3 - across) * sin * cos,
        shear * cos,
        shear * sin,
    ]
    np.testing.assert_allclose(got, wanted, atol=1e-12)


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
    sheet = loaded(THREE)
    solid = loaded(
        with_values(
            THREE,
            {
                "plates.model": "solid",
                "mesh.section.plate_size_mm": 0.05,
                "mesh.section.plate_end_size_mm": 0.01,
            },
        )
    )
    assert sheet[0] == pytest.approx(solid[0], rel=2e-3)
    assert sheet[1] == pytest.approx(solid[1], rel=2e-3)
    membrane, reference = sheet[2].mean(axis=1), solid[2].mean(axis=1)
    assert np.abs(membrane - reference).max() < 0.03 * np.abs(reference).max()
    assert np.abs(sheet[2] - solid[2]).max() < 0.03 * np.abs(solid[2]).max()


def test_sheets_of_rubber_are_rubber():
    """Plates of the body's own material: the finger without plates, to the model's own error."""
    keys: dict[str, object] = {
        "materials.phosphor_bronze.youngs_modulus_MPa": 4.96,
        "materials.phosphor_bronze.poissons_ratio": 0.49,
    }
    sheet = loaded(with_values(THREE, keys))
    solid = loaded(with_values(THREE, keys | {"plates.model": "solid"}))
    assert sheet[0] == pytest.approx(solid[0], rel=5e-3)
    assert np.abs(sheet[2] - solid[2]).max() < 0.03 * np.abs(solid[2]).max()


SHORT = parse_design(
    """
    design.name = "two-short-plates"
    body.width_mm = 10.0
    body.base_height_mm = 5.0
    body.arc_radius_mm = 12.0
    body.depth_mm = 8.0
    plates.count = 2
    plates.thickness_mm = 0.2
    plates.length_mm = 2.0
    plates.pitch_mm = 2.5
    plates.cover_mm = 1.5
    plates.span_mm = 4.0
    plates.angle_deg = 30.0
    gages.length_mm = 0.8
    mesh.contact_size_mm = 0.5
    mesh.plate_size_mm = 0.25
    """
)


@pytest.mark.slow
@pytest.mark.parametrize("along", ["x", "z"])
def test_short_sheets_against_solid_plates_in_tetrahedra(along):
    """fTetWild's meshes differ from run to run, and bending with them, of sheets and solid plates
    alike. Along x, on elements of 0.25 mm at the plates (8 corners under a gage), faces scatter by
    0.5 % (standard deviation); worst of all pairs of 13 and 13 meshes: faces 2.0 %, membrane 0.3 %,
    F_t 1.9 %. On 0.5 mm (3 corners) faces scatter by 1.0 and 1.2 %, and 1 pair in 6 differs by more
    than 3 %; halving the edges within 0.6 mm of the plates of four such meshes brought readings 4 %
    apart to within 1.7 %, halving those at the contact did not help."""
    design, found = with_values(SHORT, {"plates.along": along}), []
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
