"""Gages on plates of any frame: along z, spanned off the middle, bent, in halves, on a core."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fingerdesign.design.schema import Design, Gages
from fingerdesign.errors import SolverError
from fingerdesign.fem.finite.gage_lines import gage_lines
from fingerdesign.fem.model import (
    build_model,
    free_ends,
    gage_positions,
    materials_of,
    places_along_x,
)
from fingerdesign.fem.readout import gage_rows
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section

AXIAL, TEE = (1.0, 0.0), (1.0, 0.33)
GAGES = Gages(length_mm=1.0, width_mm=0.6, z_mm=0.2)
SMALL = {
    "design": {"name": "rubber"},
    "body": {"shape": "block", "width_mm": 8.0, "base_height_mm": 5.0, "depth_mm": 6.0},
    "plates": {"count": 0},
    "mesh": {
        "layers": 3,
        "far_size_mm": 2.0,
        "contact_size_mm": 1.0,
        "section": {"contact_size_mm": 0.4, "plate_end_size_mm": 0.1, "plate_size_mm": 0.3},
    },
}
FLAT = PlateFrame(0, 0.5, 3.0, 30.0, 2.0, 0.1, -0.5, 2.5)
ALONG_Z = PlateFrame(0, 0.7, 3.0, 40.0, 2.0, 0.1, -1.0, 0.6, along="z")
BENT = PlateFrame(0, 0.5, 3.0, 20.0, 2.0, 0.1, -0.5, 2.5, bend_radius=3.0)
LEVEL_Z = PlateFrame(0, 0.0, 3.0, 0.0, 2.0, 0.1, -1.5, 0.6, along="z")
UPRIGHT_Z = PlateFrame(0, 0.0, 3.0, 90.0, 2.0, 0.1, -1.5, 0.6, along="z")


def design_of(**tables):
    return Design.model_validate(
        {k: SMALL.get(k, {}) | tables.get(k, {}) for k in {*SMALL, *tables}}
    )


@pytest.fixture(scope="module")
def whole():
    return extrude(design_of(), Zone(2.0), symmetric=False)


@pytest.fixture(scope="module")
def half():
    return extrude(design_of(), Zone(2.0), symmetric=True)


@pytest.fixture(scope="module")
def section():
    return mesh_section(design_of(), 2.0)


def read(mesh, frame, field, weights=AXIAL):
    return gage_rows(mesh, [frame], GAGES, weights) @ field.ravel()


def directions(frame):
    """Unit vectors along the plate and across it, in space."""
    return frame.direction(frame.axis), frame.to_space(np.zeros(2), 1.0)[0]


@pytest.mark.parametrize("frame", [FLAT, ALONG_Z, LEVEL_Z, UPRIGHT_Z])
def test_constant_strain_in_any_direction(whole, frame):
    """A linear displacement's own strain along the plate's axis in space and, of a tee, across it,
    on both faces."""
    slope = np.random.default_rng(1).normal(size=(3, 3))
    axis, across = directions(frame)
    for a, b in (AXIAL, TEE, (1.02, -0.7)):
        got = read(whole, frame, whole.points @ slope.T, (a, b))
        assert np.allclose(
            got, a * (axis @ slope @ axis) + b * (across @ slope @ across), atol=1e-9
        )


def test_a_tee_reads_the_plates_own_axial_stress(whole):
    """Pulled along by s / E and free to contract, a plate of nu = 0.33 reads s (1 - nu^2) / E;
    what pulls across alone reads nothing. A bent plate's faces are stretched across alike."""
    (axis, across), strain = directions(FLAT), 3e-4
    pulled = strain * (np.outer(axis, axis) - 0.33 * np.outer(across, across))
    stretched = strain * (np.outer(across, across) - 0.33 * np.outer(axis, axis))
    for slope, wanted in ((pulled, strain * (1.0 - 0.33**2)), (stretched, 0.0)):
        assert np.allclose(read(whole, FLAT, whole.points @ slope, TEE), wanted, atol=1e-15)
    field = whole.points @ (strain * np.outer(across, across))
    assert np.allclose(read(whole, BENT, field, (0.0, 1.0)), strain, atol=1e-15)


def test_a_tee_in_plane_strain_is_a_single_gage(section):
    """Bit for bit: nothing is stretched across; the grids' own sensitivity leaves a gain."""
    tee = Gages(grid="tee", transverse_sensitivity=0.01)
    one, two = (gage_rows(section, [FLAT, BENT], GAGES, each) for each in (AXIAL, TEE))
    assert (one != two).nnz == 0
    assert tee.weights(0.33)[0] == pytest.approx((1.0 + 0.33 * 0.01) / (1.0 - 0.285 * 0.01))


@pytest.mark.parametrize(("grid", "across"), [("axial", 0.0), ("tee", 0.33)])
def test_a_grid_that_is_stretched_across_reads_more(grid, across):
    """By its sensitivity, of whichever sign; a tee by that and by its weight."""
    for own in (0.02, -0.02):
        found = Gages(grid=grid, transverse_sensitivity=own).weights(0.33)
        scale = 1.0 - 0.285 * own
        assert found == pytest.approx(((1.0 + across * own) / scale, (across + own) / scale))


def test_pairs_read_half_their_difference(whole, section):
    """Plates at +30 and -30 degrees under shear; both places hold what the one bridge reads."""
    pairs = Gages(grid="double_axial", length_mm=1.0, width_mm=0.6)
    frames = [replace(FLAT, index=k, angle_deg=30.0 * (-1) ** k) for k in range(4)]
    for mesh in (section, whole):
        slope = np.zeros((mesh.dimension,) * 2)
        slope[0] = [2e-4, 3e-4, *[0.0] * (mesh.dimension - 2)]
        rows = gage_rows(mesh, frames[:2], pairs, AXIAL)
        wanted = 3e-4 * np.sin(np.radians(60.0)) / 2.0
        assert np.allclose(rows @ (mesh.points @ slope.T).ravel(), wanted, atol=1e-15)
        moved_by = (mesh.points @ (1e-4 * slope).T) / 1e-4
        assert np.allclose(
            gage_lines(mesh, frames[:2], pairs, AXIAL).strains(moved_by), wanted, rtol=1e-3
        )
    places = gage_positions([replace(f, place=float(f.index)) for f in frames], pairs)
    assert places[:, 0].tolist() == [0.5, 0.5, 2.5, 2.5]
    with pytest.raises(ValueError, match="whole pairs"):
        gage_rows(whole, frames[1:3], pairs, AXIAL)


def test_gages_lie_about_their_plates_middle(whole):
    """u_x = x z: strain z, whose mean over the gage's width is that of its middle."""
    field = np.zeros_like(whole.points)
    field[:, 0] = whole.points[:, 0] * whole.points[:, 2]
    flat = PlateFrame(0, 0.5, 3.0, 0.0, 2.0, 0.1, -0.5, 2.5)
    assert np.allclose(read(whole, flat, field), 1.0 + 0.2, atol=1e-9)
    assert np.allclose(gage_positions([flat], GAGES), [[0.5, 3.0, 1.2]])
    assert np.allclose(gage_positions([ALONG_Z], GAGES), [[-0.2 + 0.2, 3.0, 0.7]])
    both = [flat, ALONG_Z]
    places = places_along_x(both, gage_positions(both, GAGES))
    assert places[0] == 0.5
    assert np.isnan(places[1])


@pytest.mark.parametrize("frame", [BENT, PlateFrame(0, 0.4, 3.0, 0.0, 2.0, 0.1, -1, 2, "z", 4.0)])
def test_bent_faces_read_the_mean_strain_along_them(whole, frame):
    """Against the mean over the arc of t E t, in closed form point by point; and where a bend
    swells, u = c r about its centre, strain c along every face."""
    slope = np.random.default_rng(2).normal(size=(3, 3))
    got = read(whole, frame, whole.points @ slope.T)
    for value, v in zip(got, (0.05, -0.05), strict=True):
        reach = 0.5 * GAGES.length_mm * frame.bend_radius / (frame.bend_radius + v)
        s = np.linspace(-reach, reach, 4001)
        along = np.array([frame.direction(frame.tangent(x)) for x in s])
        strain = np.einsum("ki,ij,kj->k", along, slope, along)
        mean = np.trapezoid(strain, s) / (2.0 * reach)
        assert value == pytest.approx(mean, abs=1e-6)
    if frame is BENT:
        swollen = np.zeros_like(whole.points)
        swollen[:, :2] = 0.3 * (whole.points[:, :2] - BENT.centre + BENT.bend_radius * BENT.normal)
        assert np.allclose(read(whole, BENT, swollen), 0.3, atol=1e-9)


@pytest.mark.parametrize("frame", [LEVEL_Z, UPRIGHT_Z, PlateFrame(0, 0.5, 3, 30, 2, 0.1, -2, 2)])
def test_halves_read_what_the_whole_reads(whole, half, frame):
    """A displacement that mirrors in z = 0, seen by the half z >= 0 alone."""

    def mirrored(points):
        x, y, z = points.T
        return np.stack([0.3 * x + 0.1 * z**2 + x * y, 0.2 * y + 0.4 * z**2, (1 + x + y) * z], 1)

    for weights in (AXIAL, TEE):
        there = read(whole, frame, mirrored(whole.points), weights)
        assert np.abs(there).max() > 0.1
        assert np.allclose(read(half, frame, mirrored(half.points), weights), there, atol=1e-8)


def test_the_core_has_its_own_material():
    """Stiffness by region; a stiffer core makes a stiffer finger."""
    core = {"width_mm": 4.0, "height_mm": 2.0, "bottom_mm": 1.0}
    body = SMALL["body"] | {"core": core}
    given = design_of(body=body, plates={"count": 1, "cover_mm": 1.0, "length_mm": 1.2})
    mesh = mesh_section(given, 2.0)
    young, poisson = materials_of(given, mesh)
    for region, part in ((0, "body"), (1, "plates"), (given.core_region, "core")):
        chosen = mesh.regions == region
        assert chosen.any()
        assert set(young[chosen]) == {given.material_of(part).youngs_modulus_MPa}
        assert set(poisson[chosen]) == {given.material_of(part).poissons_ratio}
    bare = design_of(plates={"count": 1, "cover_mm": 1.0, "length_mm": 1.2})
    soft = build_model(bare, mesh_section(bare, 2.0), 2.0).reduced
    stiff = build_model(given, mesh, 2.0).reduced
    push = np.array([0.0, -1.0])
    sunk = [model.displacement(model.areas[:, None] * push)[:, 1] for model in (soft, stiff)]
    assert np.abs(sunk[1]).max() < 0.8 * np.abs(sunk[0]).max()


def test_free_ends_are_where_flat_ends_meet_the_contact(whole, section):
    assert free_ends(design_of().body, whole) == (-2.5, 2.5)
    turned = {"shape": "revolved", "width_mm": 8.0, "arc_radius_mm": 5.0}
    assert free_ends(design_of(body={**turned, "depth_mm": 8.0}).body, whole) is None
    step = {"shape": "step", "step": {"file": "a.step"}, "depth_mm": 6.0}
    assert free_ends(design_of(body=step).body, whole) == pytest.approx((-2.5, 2.5))
    assert free_ends(design_of().body, section) is None


def test_some_gages_of_a_model():
    given = design_of(plates={"count": 3, "cover_mm": 1.0, "length_mm": 1.2, "pitch_mm": 2.0})
    model = build_model(given, mesh_section(given, 2.0), 2.0).reduced
    some, force = model.with_gages([2, 0]), model.areas[:, None] * np.array([0.3, -1.0])
    assert np.allclose(some.gage_strain(force), model.gage_strain(force)[[2, 0]], rtol=1e-9)
    along_z = replace(some, gage_x=np.full(2, np.nan))
    places = [plate_frames(given)[k].x for k in (2, 0)]
    assert some.gage_x.tolist() == along_z.gage_centres_x.tolist() == places


# Gages at finite strain: elongation of their own line, whatever the plate's motion.

ALL = [FLAT, ALONG_Z, LEVEL_Z, UPRIGHT_Z, BENT]


def moved(mesh, gradient):
    return mesh.points @ (gradient - np.eye(mesh.dimension)).T


def test_a_turn_reads_nothing(whole, section):
    """In space and in the section, of a body that is moved besides."""
    gradient = Rotation.from_euler("zyx", [0.8, 0.3, -0.2]).as_matrix()
    flat = Rotation.from_euler("z", 1.2).as_matrix()[:2, :2]
    for mesh, motion, frames in ((whole, gradient, ALL), (section, flat, [FLAT, BENT])):
        strains = gage_lines(mesh, frames, GAGES, TEE).strains(moved(mesh, motion) + 0.4)
        assert np.abs(strains).max() < 1e-13


@pytest.mark.parametrize("frame", [FLAT, ALONG_Z, UPRIGHT_Z])
def test_a_large_homogeneous_strain_is_the_axis_own_stretch(whole, frame):
    gradient = np.eye(3) + 0.3 * np.random.default_rng(4).normal(size=(3, 3))
    strains = gage_lines(whole, [frame], GAGES, TEE).strains(moved(whole, gradient))
    along, across = (np.linalg.norm(gradient @ each) - 1.0 for each in directions(frame))
    assert np.allclose(strains, along + 0.33 * across, atol=1e-13)


@pytest.mark.parametrize("frame", ALL)
@pytest.mark.parametrize("which", ["whole", "half"])
def test_small_motions_read_what_the_small_strain_rows_do(request, which, frame):
    """Of a bent plate to what chords leave of arcs; in a half also where gages cross z = 0."""
    mesh = request.getfixturevalue(which)
    x, y, z = mesh.points.T
    field = np.stack(
        [x * y + 0.3 * z * z, np.sin(x) + 0.2 * y * y, z * (0.5 + 0.1 * x * y)], axis=1
    )
    wanted = (gage_rows(mesh, [frame], GAGES, TEE) @ field.ravel()).reshape(-1, 2)
    small = 1e-7
    found = gage_lines(mesh, [frame], GAGES, TEE).strains(small * field) / small
    scale = np.abs(wanted).max()
    assert np.abs(found - wanted).max() < (2e-3 if frame.bend_radius else 2e-6) * scale


def test_sheets_are_refused_and_no_plates_have_no_strains(section):
    slot = {"plate_0_upper": np.zeros((0, 3), dtype=int)}
    with pytest.raises(SolverError, match=r"plates\.model"):
        gage_lines(replace(section, facets=section.facets | slot), [FLAT], GAGES, AXIAL)
    assert gage_lines(section, [], GAGES, AXIAL).strains(section.points).shape == (0, 2)
