"""Scenes at finite strain: against small strain as the load goes to zero, mirrors, forces, laws."""

from dataclasses import replace

import numpy as np
import pytest

import fingerdesign.fem.finite.row as row_module
from fingerdesign import parse_design, parse_scene
from fingerdesign.analysis.finite_path import finite_faults, finite_readings
from fingerdesign.analysis.path import object_at_touch, targets
from fingerdesign.checks.load import with_values
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import contact_problem
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.fem.finite.row import _TOLERANCE
from fingerdesign.fem.model import build_model
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section import section
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section

FINGER = """
design.name = "small"
body = {shape = "arc", width_mm = 12.0, base_height_mm = 4.0, arc_radius_mm = 12.0, depth_mm = 6.0}
plates = {placement = [[-0.8, 4.6, 45.0], [0.9, 4.5, 30.0]], thickness_mm = 0.1, length_mm = 1.2}
gages = {length_mm = 0.8}
materials.silicone = {youngs_modulus_MPa = 4.96, poissons_ratio = 0.49}
[mesh]
contact_size_mm = 0.5
far_size_mm = 3.0
plate_size_mm = 0.6
layers = 2
[mesh.section]
contact_size_mm = 0.15
plate_size_mm = 0.3
plate_end_size_mm = 0.1
far_size_mm = 1.5
gradation = 0.4
"""
ZONE = Zone(2.6)
ROWS = [[0.05, 0.0], [0.1, 0.0], [0.1, 0.03], [0.1, 0.08]]


def scene_of(rows, rigid="", friction=0.5, control="mm"):
    name = "increments_mm" if control == "mm" else 'control = "force"\nincrements_N'
    text = f"[object]\nfriction_coefficient = {friction}\n{rigid}\n[path]\n{name} = {rows}\n"
    return parse_scene(text)


@pytest.fixture(scope="module")
def design():
    return parse_design(FINGER)


@pytest.fixture(scope="module")
def rubber(design):
    return with_values(design, {"plates.placement": None, "plates.count": 0})


@pytest.fixture(scope="module")
def mesh(design):
    return mesh_section(design, ZONE.half_width)


@pytest.fixture(scope="module")
def plain(rubber):
    return mesh_section(rubber, ZONE.half_width)


@pytest.fixture(scope="module")
def pressed(design, mesh):
    return finite_readings(design, mesh, ZONE, scene_of(ROWS))


def small_strain(design, mesh, scene):
    model = build_model(design, mesh, ZONE.half_width)
    rigid = object_at_touch(scene.object, design.body)
    problem = contact_problem(model.reduced, rigid, scene.object.friction_coefficient)
    return [step.measures for step in follow(problem, targets(scene.path))]


def test_rows_hold_to_rounding(pressed):
    for row in pressed.rows:
        assert row.residual <= _TOLERANCE
        assert row.balance < 1e-8
        assert row.tangents <= 4
    read = pressed.readings
    assert (read.tangential_force <= 0.5 * read.normal_force * (1 + 1e-9)).all()
    assert read.gages.shape == (4, 2, 2)
    assert pressed.dofs > 1000
    assert read.stick_ratio[1] > 0.8


@pytest.mark.parametrize("rigid", ["", 'shape = "cylinder"\nradius_mm = 6.0'])
def test_as_the_load_goes_to_zero_it_is_the_small_strain_answer(design, mesh, rigid):
    """Motions halved twice: of all that is read, differences fall by about two each time."""
    found = []
    for share in (0.5, 0.125):
        scene = scene_of([[share * a, share * s] for a, s in ROWS], rigid)
        finite = finite_readings(design, mesh, ZONE, scene)
        small = small_strain(design, mesh, scene)
        last = small[-1]
        gages = 1e6 * np.array([each.gages for each in small])
        found.append(
            [
                finite.readings.normal_force[-1] / last.normal_force - 1.0,
                finite.readings.tangential_force[-1] / last.tangential_force - 1.0,
                np.abs(finite.readings.gages - gages)[-1].max() / np.abs(gages[-1]).max(),
            ]
        )
    first, third = np.abs(found)
    assert (first < 0.03).all()
    assert (third < 0.4 * first).all()
    if not rigid:
        ratio = (first / third)[[0, 2]] ** 0.5
        assert ((ratio > 1.6) & (ratio < 2.8)).all()


def mirrored(mesh):
    order = [1, 0, 2, 3, 5, 4]
    points = mesh.points * [-1.0, 1.0]
    facets = {name: each.copy() for name, each in mesh.facets.items()}
    return replace(mesh, points=points, cells=mesh.cells[:, order], facets=facets)


def test_the_mirrored_scene_mirrors(design, mesh, pressed):
    places = [[-x, y, 180.0 - angle] for x, y, angle in design.plates.placement]
    other = with_values(design, {"plates.placement": places})
    rows = [[a, -s] for a, s in ROWS]
    found = finite_readings(other, mirrored(mesh), ZONE, scene_of(rows)).readings
    wanted = pressed.readings
    assert np.allclose(found.normal_force, wanted.normal_force, rtol=1e-7)
    assert np.allclose(found.tangential_force, -wanted.tangential_force, rtol=0, atol=1e-7)
    assert np.allclose(found.stick_ratio, wanted.stick_ratio, atol=1e-6)
    # an axis turned to 180 - angle has its upper side where the mirror puts the lower one
    assert np.allclose(found.gages[..., ::-1], wanted.gages, rtol=0, atol=1e-3)


def test_forces_given_lead_to_the_motion_that_gives_them(design, mesh, pressed):
    scene = scene_of([[2.0, 0.0], [2.0, 0.4]], control="force")
    by_force = finite_readings(design, mesh, ZONE, scene)
    assert np.allclose(by_force.readings.normal_force, 2.0, rtol=1e-8)
    assert np.allclose(by_force.readings.tangential_force, [0.0, 0.4], atol=1e-8)
    rows = [[row.motion.approach, row.motion.shear] for row in by_force.rows]
    again = finite_readings(design, mesh, ZONE, scene_of(rows))
    assert np.allclose(again.readings.normal_force, 2.0, rtol=1e-6)
    assert np.allclose(again.readings.gages, by_force.readings.gages, rtol=0, atol=1e-3)


def test_a_row_too_long_is_cut_and_its_answer_is_no_other(design, mesh, calls_of, monkeypatch):
    """Without friction one row to far is what many rows lead to; the zone is the whole top."""
    zone, steps = Zone(6.0), calls_of(row_module, "_on_the_way")
    monkeypatch.setattr(row_module, "_ITERATIONS", 4)
    scene = scene_of([[0.9, 0.0]], friction=0.0)
    at_once = finite_readings(design, mesh, zone, scene).readings
    assert min(share for (_, _, share, _), _ in steps) < 1.0
    rows = [[0.15 * k, 0.0] for k in range(1, 7)]
    in_steps = finite_readings(design, mesh, zone, scene_of(rows, friction=0.0)).readings
    assert at_once.normal_force[-1] == pytest.approx(in_steps.normal_force[-1], rel=1e-8)
    assert np.allclose(at_once.gages[-1], in_steps.gages[-1], rtol=0, atol=1e-3)


def test_nearly_a_flat_plane_is_one_and_let_go_nothing_is_left(rubber, plain):
    rows = [*ROWS, [0.0, 0.0]]
    flat, found = (
        finite_readings(rubber, plain, ZONE, scene_of(rows, rigid)).readings
        for rigid in ("", 'shape = "cylinder"\nradius_mm = 1e5')
    )
    assert np.allclose(found.normal_force, flat.normal_force, rtol=1e-3, atol=1e-8)
    assert np.allclose(found.tangential_force, flat.tangential_force, atol=2e-3)
    assert flat.normal_force[-2] > 1.0
    assert abs(flat.normal_force[-1]) < 1e-8


@pytest.mark.slow
def test_half_a_finger_in_space_is_the_whole(rubber):
    rows = scene_of([[0.1, 0.0], [0.1, 0.05]])
    half, whole = (
        finite_readings(rubber, extrude(rubber, Zone(1.6), cut), Zone(1.6), rows)
        for cut in (True, False)
    )
    for name in ("normal_force", "tangential_force"):
        one, two = (getattr(each.readings, name) for each in (half, whole))
        assert np.allclose(one, two, rtol=1e-3)
    assert half.dofs < 0.6 * whole.dofs


@pytest.mark.parametrize(
    ("values", "rows", "key"),
    [
        ({"plates.model": "sheet"}, ROWS, "plates.model"),
        ({"mesh.element": "P1"}, ROWS, "mesh.element"),
        ({}, [[0.1, 0.0, 0.0, 1.0]], "path.increments_mm"),
    ],
)
def test_what_it_does_not_know_is_refused(design, mesh, values, rows, key):
    with pytest.raises(DesignError, match=key.replace(".", r"\.")):
        finite_readings(with_values(design, values), mesh, ZONE, scene_of(rows))


def test_other_laws_than_coulombs_are_refused(design):
    rough = scene_of(ROWS).object.model_copy(
        update={"friction_law": "shear_strength", "shear_strength_MPa": 0.1}
    )
    scene = scene_of(ROWS).model_copy(update={"object": rough})
    assert [fault.key for fault in finite_faults(design, scene)] == ["object.friction_law"]


def test_what_cannot_be_held_is_refused(rubber, plain):
    scene = scene_of([[2.0, 0.0], [2.0, 3.0]], control="force")
    with pytest.raises(SolverError, match=r"row 2 of 2.*complete slip"):
        finite_readings(rubber, plain, ZONE, scene)


# The same meshes solved by GetFEM 5.4.2: the law written as an energy, contact as an augmented
# Lagrangian on linear multipliers, a full Newton method. Its numbers (per mm) are kept here.

CODE_BODY = """
design.name = "second_code"
body = {shape = "arc", width_mm = 20.0, base_height_mm = 10.0, arc_radius_mm = 20.0, depth_mm = 1.0}
materials.silicone = {youngs_modulus_MPa = 4.96, poissons_ratio = 0.3}
"""
CODE_RUBBER = """
plates = {count = 0}
mesh.section = {contact_size_mm = 0.1, far_size_mm = 1.0, gradation = 0.3}
"""
CODE_PLATES = """
plates = {placement = [[0.5, 10.9, 45.0], [-1.5, 10.8, 30.0]], thickness_mm = 0.1, length_mm = 2.0}
gages = {length_mm = 1.0, width_mm = 0.5}
mesh.section = {contact_size_mm = 0.1, plate_size_mm = 0.15, plate_end_size_mm = 0.05, \
far_size_mm = 1.0, gradation = 0.3}
"""
SHEARED = {  # friction 0.5: [approach, shear]: F_n, F_t
    (0.4, 0.0): (1.47444, 0.00013),
    (0.8, 0.0): (3.60641, 0.00039),
    (1.2, 0.0): (6.24886, 0.00080),
    (1.6, 0.0): (9.38088, 0.00144),
    (2.0, 0.0): (13.00820, 0.00241),
    (2.0, 0.3): (13.00934, 0.58074),
    (2.0, 0.6): (13.01475, 1.15792),
}
PRESSED = {  # no friction: approach: F_n, gages in microstrain: upper, lower of each plate
    0.2: (0.63009, (-65.752, 64.253, 12.453, -22.218)),
    0.4: (1.47444, (-103.136, 94.569, -14.079, 0.107)),
    0.6: (2.47190, (-128.964, 112.674, -52.880, 38.088)),
}


@pytest.fixture
def as_then(monkeypatch):
    """Sections meshed whole, plates in their own order: the meshes that the second code had."""
    monkeypatch.setattr(section, "to_draw", lambda frames: (frames, 1.0))
    monkeypatch.setattr(section, "partners", lambda frames: None)


def second_code(plates, rows, friction):
    design = parse_design(CODE_BODY + plates)
    scene = parse_scene(
        f"object.friction_coefficient = {friction}\npath.increments_mm = {[list(r) for r in rows]}"
    )
    return finite_readings(design, mesh_section(design, 8.0), Zone(9.9), scene)


@pytest.mark.slow
@pytest.mark.usefixtures("as_then")
def test_pressed_far_and_sheared_with_friction():
    """Two discretisations of contact differ by 1e-4 where the contact is smallest, 2e-5 later."""
    found = second_code(CODE_RUBBER, SHEARED, 0.5)
    wanted = np.array(list(SHEARED.values()))
    assert np.allclose(found.readings.normal_force, wanted[:, 0], rtol=2e-4)
    assert np.allclose(found.readings.tangential_force, wanted[:, 1], rtol=0, atol=1e-4)


@pytest.mark.usefixtures("as_then")
def test_gages_of_plates_that_turn():
    """Within 0.03 of 129 microstrain, where small strain is off by up to 14."""
    found = second_code(CODE_PLATES, [(a, 0.0) for a in PRESSED], 0.0)
    for k, (force, gages) in enumerate(PRESSED.values()):
        assert found.readings.normal_force[k] == pytest.approx(force, rel=1e-4)
        assert np.abs(found.readings.gages[k].ravel() - gages).max() < 0.03
