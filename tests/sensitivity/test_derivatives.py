"""Derivatives of a coarse plane-strain finger: exact relations, differences, kinks, refusals."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign import load_design, with_values
from fingerdesign.analysis.path import problem_at_touch
from fingerdesign.contact.laws import STICK
from fingerdesign.contact.measures import level_sets, positive_fraction
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.design.scene import Scene
from fingerdesign.errors import DesignError
from fingerdesign.sensitivity import areas
from fingerdesign.sensitivity.areas import fraction_slopes, on_corner
from fingerdesign.sensitivity.derive import sensitivity
from fingerdesign.sensitivity.path import path_rates
from fingerdesign.sensitivity.variant import parameters_of
from fingerdesign.shapes.objects import Plane
from tests.support.any_fingers import Finger, any_finger
from tests.support.derivatives import errors_of, solved
from tests.support.pages import run_python
from tests.support.reduced import bump

# Plates as soft as 50 MPa: of metal ones the condensation rounds to some 1e-10 of the stiffness of
# steel, and differences over a thousandth show no more than six digits.
COARSE = {
    "mesh.section.contact_size_mm": 0.4,
    "mesh.section.plate_size_mm": 0.8,
    "mesh.section.plate_end_size_mm": 0.4,
    "mesh.section.far_size_mm": 4.0,
    "plates.count": 3,
    "plates.pitch_mm": 2.5,
    "plates.thickness_mm": 0.2,
    "materials.phosphor_bronze.youngs_modulus_MPa": 50.0,
}
PATH = [[0.06, 0.0], [0.1, 0.0], [0.1, 0.03], [0.1, 0.06]]
RUBBER, METAL = (f"materials.{name}.youngs_modulus_MPa" for name in ("silicone", "phosphor_bronze"))


def scene_of(rows, **rigid):
    path = {"increments_mm": rows, "substeps": 2}
    return Scene.model_validate({"object": {"friction_coefficient": 0.5, **rigid}, "path": path})


@pytest.fixture(scope="module")
def finger():
    return Finger(with_values(load_design("maeno2000"), COARSE), scene_of(PATH), "plane-strain")


@pytest.fixture(scope="module")
def scaled(finger):
    return solved(finger, [RUBBER, METAL, "body.depth_mm"]).found


def test_twice_the_moduli_are_twice_the_forces(scaled):
    """Euler's theorem: sum of E dF/dE is F; readings and stick ratios do not change."""
    for name in ("normal_force", "tangential_force"):
        total = getattr(scaled, name)[:, :2] @ scaled.values[:2]
        force = getattr(scaled.readings, name)
        assert total == pytest.approx(force, rel=1e-9, abs=1e-9 * np.abs(force).max())
    most = np.abs(scaled.gages[..., :2] * scaled.values[:2]).max()
    assert np.abs(scaled.gages[..., :2] @ scaled.values[:2]).max() < 1e-8 * most
    most = np.abs(scaled.stick_ratio[:, :2] * scaled.values[:2]).max()
    assert np.abs(scaled.stick_ratio[:, :2] @ scaled.values[:2]).max() < 1e-8 * most


def test_twice_the_depth_is_twice_the_force(scaled):
    force = scaled.readings.normal_force
    assert scaled.normal_force[:, 2] * scaled.values[2] == pytest.approx(force, rel=1e-9)
    assert np.abs(scaled.stick_ratio[:, 2]).max() < 1e-10
    assert np.abs(scaled.gages[..., 2]).max() < 1e-9


@pytest.mark.parametrize(
    "names",
    [
        ("object.friction_coefficient", "placement[1].y_mm", "placement[0].angle_deg"),
        (RUBBER, METAL),
        pytest.param(
            ("materials.silicone.poissons_ratio", "placement[2].x_mm"), marks=pytest.mark.slow
        ),
    ],
)
def test_differences_on_the_moved_mesh_agree(finger, names):
    """Along coordinates, at random, and along the gradients; bound: the issue's 1e-6."""
    errors, skipped, found = errors_of(finger, names)
    assert errors
    assert max(error for _, _, error in errors) < 1e-6
    assert np.median([error for _, _, error in errors]) < 1e-8
    assert skipped < 0.5 * (len(names) + 4)
    assert not found.on_kink.any()


@pytest.mark.parametrize("key", ["youngs_modulus_MPa", "poissons_ratio"])
def test_rubber_around_attached_sheets_agrees(finger, key):
    """The sheets' stiffness is no cell's: as the whole grows with the rubber, it softens."""
    sheets = finger.with_design({"plates.model": "sheet"})
    errors, _, _ = errors_of(sheets, (f"materials.silicone.{key}",))
    assert errors
    assert max(error for _, _, error in errors) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "step"),
    [
        *(("body.base_height_mm", 5e-4), ("body.width_mm", 5e-4), ("body.arc_radius_mm", 5e-4)),
        *(("plates.length_mm", 5e-4), ("plates.thickness_mm", 5e-4), ("gages.length_mm", 5e-3)),
    ],
)
def test_differences_of_lengths_agree(finger, name, step):
    """The same bounds, each with the step that shows it. The share of a facet that sticks has kinks
    in its second derivative: a difference of it is off by the step's first power (1.8e-5 to 6e-7 of
    the width's from 0.03 to 0.0005). Rounding grows as the step shrinks: a gage's length, which
    moves no node, has nothing else (1.2e-6 at 0.0005, 9e-8 at 0.005)."""
    largest, _, found = errors_of(finger, (name,), step=step)
    usual, skipped, _ = errors_of(finger, (name,), step=3e-2)
    assert max(error for _, _, error in largest) < 1e-6
    assert np.median([error for _, _, error in usual]) < 1e-8
    assert skipped < 3
    assert not found.on_kink.any()


def test_a_path_that_stands_still_is_on_a_kink(finger):
    """Nodes on their friction limit that do not move: a little more would slip, less would not."""
    still = Finger(finger.design, scene_of([*PATH, PATH[-1]]), "plane-strain")
    found = solved(still, ["object.friction_coefficient"]).found
    assert found.on_kink[-2] == 0.0
    assert 0.02 < found.on_kink[-1] <= 1.0


def test_a_node_that_nothing_pulls_at_the_border_of_stick_is_a_corner(finger):
    case = solved(finger, ["object.friction_coefficient"])
    problem = problem_at_touch(case.model.reduced, case.scene.object, case.design.body)
    step = case.steps[-1]
    stick, status = level_sets(problem, step.increment)[1], step.increment.status
    ends = problem.model.facets[(stick > 0.0)[problem.model.facets].sum(axis=1) == 1]
    node = next(each for each in ends.ravel() if status[each] == STICK)
    multiplier = step.increment.multiplier.copy()
    assert not on_corner(problem, case.steps).any()
    multiplier[node, 1:] = 0.0
    pulled = replace(step, increment=replace(step.increment, multiplier=multiplier))
    share = multiplier[node, 0] / multiplier[:, 0].sum()
    assert on_corner(problem, [step, pulled]).tolist() == pytest.approx([0.0, share])


def test_rates_in_space_are_differences_of_the_path():
    problem = contact_problem(bump(9), Plane(0.0), 0.5)
    path = [Motion(0.008, 0.0), Motion(0.012, 0.002, 0.001), Motion(0.012, 0.002, 0.004)]
    tilt, nodes = 0.3 + problem.model.points[:, 0], np.arange(problem.shape[0])

    def outputs(friction, tilted, softer):
        there = replace(problem.with_friction(0.5 + friction), gap0=problem.gap0 + tilted * tilt)
        there = replace(there, compliance=(1.0 + softer) * problem.compliance)
        steps = list(follow(there, path, 2))
        found = [[s.measures.contact_area, s.measures.stick_area] for s in steps]
        return steps, np.hstack([[s.increment.force.sum(axis=0) for s in steps], found])

    steps, friction = outputs(0.0, 0.0, 0.0)[0], np.array([1.0, 0.0, 0.0])
    increments = [each for step in steps for each in step.row]
    explicit, none = np.zeros((6, len(nodes), 3, 3)), np.zeros((len(problem.model.facets), 3))
    explicit[:, :, 0, 1] = tilt
    for k, each in enumerate(increments):
        explicit[k, ..., 2] = (problem.compliance @ each.multiplier.ravel()).reshape(-1, 3)
    rates = path_rates(problem, increments, nodes, explicit, friction)
    pairs = areas.border_pairs(problem, steps, nodes)
    softer = problem.self_compliance[pairs[0]][:, None] * [0.0, 0.0, 1.0]
    own = areas.OwnRates(pairs, softer, none[nodes], none, friction)
    forces = np.einsum("nab,knap->kbp", problem.frames, rates.multiplier[1::2])
    found = np.concatenate([forces, areas.area_rates(problem, steps, rates, own)], axis=1)
    for k, step in enumerate(np.diag([1e-5, 1e-8, 1e-6])):
        expected = (outputs(*step)[1] - outputs(*-step)[1]) / (2.0 * step.sum())
        off = np.abs(found[..., k] - expected).max(axis=0)
        assert (off <= 1e-4 * np.abs(expected).max(axis=0) + 1e-6).all()


def test_slopes_of_a_share_are_its_differences():
    values = np.random.default_rng(3).standard_normal((50, 3))
    for width in (2, 3):
        own, step = values[:, :width], 1e-6
        for k in range(width):
            way = step * np.eye(width)[k]
            both = positive_fraction(own + way) - positive_fraction(own - way)
            assert fraction_slopes(own)[:, k] == pytest.approx(both / (2 * step), abs=1e-6)


@pytest.mark.parametrize(
    "name", ["body.material", "placement[99].x_mm", "object.axis", "mesh.layers", "body.widht_mm"]
)
def test_what_is_no_parameter_is_refused(finger, name):
    with pytest.raises(DesignError, match="parameters"):
        parameters_of(finger.design, finger.scene, (name,))


def test_what_has_no_known_derivative_is_refused(finger):
    sheets = with_values(finger.design, {"plates.model": "sheet"})
    with pytest.raises(DesignError, match=r"plates\.model"):
        sensitivity(sheets, finger.scene, ["plates.cover_mm"], "plane-strain")
    pulled = finger.scene.model_dump(exclude_unset=True)
    pulled["path"] = {"control": "force", "increments_N": [[2.0, 0.0]]}
    strong = {"friction_law": "capped", "shear_strength_MPa": 0.1}
    with pytest.raises(DesignError, match=r"object\.friction_law"):
        sensitivity(finger.design, scene_of(PATH, **strong), [RUBBER], "plane-strain")
    with pytest.raises(DesignError, match=r"path\.control"):
        sensitivity(finger.design, Scene.model_validate(pulled), [RUBBER], "plane-strain")
    with pytest.raises(DesignError, match="motions that touch the finger"):
        sensitivity(finger.design, scene_of([[0.0, 0.01]]), [RUBBER], "plane-strain")


def test_every_fault_is_named_before_any_work(finger):
    """In one error: what fidelity, scene and parameters have; also of numbers that are no index."""
    strong = {"friction_law": "capped", "shear_strength_MPa": 0.1}
    pulled = scene_of(PATH, **strong).model_dump(exclude_unset=True)
    pulled["path"] = {"control": "force", "increments_N": [[2.0, 0.0]]}
    names = ["nope.x", f"placement[{'9' * 5000}].y_mm", 3]
    with pytest.raises(DesignError) as found:
        sensitivity(finger.design, Scene.model_validate(pulled), names, "2d")
    keys = [fault.key for fault in found.value.faults]
    assert keys == ["fidelity", "object.friction_law", "path.control", *["parameters"] * 3]
    sphere = {"shape": "sphere", "radius_mm": 8.0}
    with pytest.raises(DesignError, match="one or more") as found:
        sensitivity(finger.design, scene_of(PATH, **sphere), [], "plane-strain")
    assert "--fidelity" in [fault.key for fault in found.value.faults]
    rounded = with_values(finger.design, {"body.edge_radius_mm": 1.0})
    with pytest.raises(DesignError) as found:
        sensitivity(rounded, finger.scene, ["body.width_mm", "body.arc_radius_mm"], "plane-strain")
    assert len(found.value.faults) == 2


@pytest.mark.slow
def test_half_of_a_swept_finger_agrees():
    """In space, on the half z >= 0, whose nodes on the mirror plane do not move along z."""
    coarse = {"layers": 1, "section.plate_size_mm": 1.2, "section.gradation": 0.7}
    finger = any_finger(17, "3d").with_design({f"mesh.{key}": n for key, n in coarse.items()})
    errors, _, _ = errors_of(finger, ["object.friction_coefficient", RUBBER, METAL])
    assert errors
    assert max(error for _, _, error in errors) < 1e-6


@pytest.mark.slow
def test_the_pages_python_runs(capsys):
    run_python("explanation/sensitivity.md")
    assert len(capsys.readouterr().out.strip("[] \n").split()) == 3
