"""Finite strain under high contact pressure: the forecast, its two bounds, and real runs at them.

Runs are in plane strain on coarse meshes. Last rows with an answer were found in 40 rows to half of
the height; bounds were derived from them and from theory (fingerdesign/layout/pressure.py).
"""

import pytest

from fingerdesign import parse_design, parse_scene
from fingerdesign.analysis.case import Case
from fingerdesign.analysis.finite_path import finite_steps, pressure_note
from fingerdesign.analysis.forecast.forecast import impossible
from fingerdesign.analysis.path import PathStopped
from fingerdesign.checks.load import with_values
from fingerdesign.fem.body import condense_body
from fingerdesign.fem.model import body_of, candidate_facets
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.pressure import (
    greatest_approach_at,
    greatest_possible,
    greatest_pressure,
    mean_pressure,
    sound_pressure,
)
from fingerdesign.layout.zone import approach_for
from fingerdesign.mesh.section.section import mesh_section

DESIGN = """
design.name = "pressed"
body = {{depth_mm = 500.0, {body}}}
plates.count = 0
materials.silicone = {{youngs_modulus_MPa = 3.0, poissons_ratio = {nu}}}
mesh.section = {{contact_size_mm = 0.5, far_size_mm = 1.0}}
"""
BLOCK = 'shape = "block", width_mm = {}, base_height_mm = {}, edge_radius_mm = {}'
ARC = 'shape = "arc", width_mm = 20.0, base_height_mm = {}, arc_radius_mm = {}'
# Body, Poisson's ratio, approach over height of the last answer, mean pressure over shear modulus.
TABLE = [
    (BLOCK.format(20, 10, 0.1), 0.3, 0.138, 0.49),
    (BLOCK.format(20, 10, 0.1), 0.49, 0.062, 0.49),
    (BLOCK.format(20, 10, 1), 0.3, 0.263, 1.04),
    (BLOCK.format(20, 10, 1), 0.49, 0.163, 1.41),
    (BLOCK.format(20, 5, 1), 0.3, 0.312, 1.40),
    (BLOCK.format(20, 5, 1), 0.49, 0.100, 1.57),
    (BLOCK.format(10, 10, 1), 0.3, 0.163, 0.58),
    (BLOCK.format(10, 10, 1), 0.49, 0.138, 0.80),
    (BLOCK.format(40, 10, 1), 0.3, 0.287, 1.26),
    (BLOCK.format(40, 10, 1), 0.49, 0.087, 1.34),
    (ARC.format(10, 20), 0.3, 0.412, 1.60),
    (ARC.format(10, 20), 0.49, 0.263, 1.59),
    (ARC.format(5, 20), 0.3, 0.400, 1.49),
    (ARC.format(5, 20), 0.49, 0.213, 1.70),
    (ARC.format(5, 80), 0.3, 0.325, 1.36),
    (ARC.format(5, 80), 0.49, 0.138, 1.47),
    (ARC.format(3, 40), 0.3, 0.375, 1.44),
    (ARC.format(3, 40), 0.49, 0.137, 1.55),
]
PLANE = "[object]\nfriction_coefficient = 0.5\n[path]\nsubsteps = 1\nincrements_mm = {}"
TOUCH = parse_scene(PLANE.format([[0.1, 0.0]])).object


def design_of(body, nu):
    return parse_design(DESIGN.format(body=body, nu=nu))


def pressed(design, approach, rows):
    """Follow a path of equal rows in plane strain, without the check before work."""
    mesh = mesh_section(design, 0.5 * design.body.width_mm)
    contact = candidate_facets(mesh, 0.5 * design.body.width_mm, None)
    at_rest = condense_body(body_of(design, mesh, contact))
    path = [[approach * (k + 1) / rows, 0.0] for k in range(rows)]
    return finite_steps(design, at_rest, parse_scene(PLANE.format(path)))


@pytest.mark.parametrize(("body", "nu", "share", "found"), TABLE)
def test_the_forecast_is_near_and_each_bound_on_its_side(body, nu, share, found):
    design = design_of(body, nu)
    forecast = mean_pressure(design, TOUCH, share * float(crest_height(design.body)))
    assert forecast == pytest.approx(found, rel=0.25)
    assert sound_pressure(design) < min(forecast, found)
    assert greatest_possible(design) > max(forecast, found)


def test_the_forecast_is_near_in_three_dimensions_too():
    """A block 10 mm deep, half of it in two layers of prisms: the row after 0.18 had no answer."""
    design = with_values(design_of(BLOCK.format(20, 10, 1), 0.49), {"body.depth_mm": 10.0})
    for share, found in ((0.03, 0.13), (0.09, 0.405), (0.18, 0.85)):
        assert mean_pressure(design, TOUCH, 10.0 * share) == pytest.approx(found, rel=0.25)
    assert sound_pressure(design) < 0.85 < greatest_possible(design)


def test_a_block_buckles_over_its_thinner_side():
    """Both bounds are of a strut, and the same with width and depth exchanged."""
    sides = ({"body.width_mm": w, "body.depth_mm": d} for w, d in ((4.0, 12.0), (12.0, 4.0)))
    tall = 'design.name = "tall"\nplates.count = 0\n[body]\nshape = "block"\nbase_height_mm = 12.0'
    thin, deep = (with_values(parse_design(tall), each) for each in sides)
    cube = with_values(thin, {"body.width_mm": 12.0})
    for bound in (sound_pressure, greatest_possible):
        assert bound(thin) == pytest.approx(bound(deep))
        assert bound(thin) < 0.5 * bound(cube)


@pytest.mark.slow
@pytest.mark.parametrize("case", [TABLE[k] for k in (1, 3, 4, 7, 11, 15, 17)], ids=str)
def test_runs_below_the_lower_bound_have_answers_and_those_beyond_the_upper_fail(case):
    design = design_of(*case[:2])
    low, high = (
        greatest_approach_at(design, TOUCH, bound(design))
        for bound in (sound_pressure, greatest_possible)
    )
    assert pressed(design, low, 4)[-1].measures.normal_force > 0.0
    with pytest.raises(PathStopped, match="no answer"):
        pressed(design, 1.02 * high, 8)


def test_a_small_load_on_a_crest_is_hertz_by_motion_and_by_force():
    """Mean pressure of a line contact: sqrt(pi E* P / (16 R)) of its force P per mm."""
    design = design_of(ARC.format(40, 20), 0.49)
    scene = parse_scene('[path]\ncontrol = "force"\nincrements_N = [[100.0, 0.0]]')
    shear, modulus = 3.0 / 2.98, 3.0 / (1.0 - 0.49**2)
    known = (3.14159 * modulus * 0.2 / (16.0 * 20.0)) ** 0.5 / shear
    approach = approach_for(design, TOUCH, 100.0)
    # The forecast of the width is up to a quarter wide (contact_half_width).
    assert mean_pressure(design, TOUCH, approach) == pytest.approx(known, rel=0.25)
    assert greatest_pressure(design, scene) == pytest.approx(known, rel=0.25)


@pytest.mark.parametrize(("nu", "approach"), [(0.0, 0.1), (0.49, 1e-300)])
def test_the_forecast_is_finite_without_poissons_effect_and_without_a_depth(nu, approach):
    for body in (BLOCK.format(20, 10, 1), ARC.format(10, 40)):
        pressure = mean_pressure(design_of(body, nu), TOUCH, approach)
        assert 0.0 <= pressure < 0.1


@pytest.mark.parametrize("control", ["mm", "N"])
def test_what_is_beyond_is_refused_before_work_and_what_is_near_is_noted(control):
    design = design_of(BLOCK.format(20, 10, 1), 0.49)
    shear = 3.0 / 2.0 / 1.49
    rows = {"mm": (0.1, 1.0, 3.0), "N": (0.2, 1.0, 2.5)}[control]
    for row, sign in zip(rows, ("sound", "near", "beyond"), strict=True):
        value = row if control == "mm" else row * shear * 20.0 * 500.0
        head = "[path]\n" + 'control = "force"\n' * (control == "N")
        scene = parse_scene(f"{head}increments_{control} = [[{value}, 0.0]]")
        found = [
            fault
            for fault in impossible(Case(design, scene, "finite"), scene)
            if "contact pressure" in fault.bound
        ]
        assert bool(found) == (sign == "beyond")
        assert not any(
            "contact pressure" in fault.bound
            for fault in impossible(Case(design, scene, "3d"), scene)
        )
        assert bool(pressure_note(design, scene)) == (sign != "sound")
        for fault in found:
            assert fault.key == f"path.increments_{control}[0][0]"
            assert "--fidelity 3d" in fault.remedy
