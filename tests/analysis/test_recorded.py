"""What is recorded of a path, by made-up steps: rows, contact, caveats, fields, failures."""

import re
from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
import pytest

from fingerdesign.analysis import analysis, path
from fingerdesign.analysis.analysis import _of_path, failed_analysis, too_deep
from fingerdesign.analysis.case import Case, Clock, fundamental_scene
from fingerdesign.analysis.fidelity.choice import Choice
from fingerdesign.analysis.path import PathStopped, follow_path, increment_result
from fingerdesign.analysis.stages import recover_fields, zone_of
from fingerdesign.analysis.work import Followed
from fingerdesign.checks.load import load_design, parse_design, with_values
from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.laws import OPEN, SLIP, STICK
from fingerdesign.contact.measures import Measures
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.design.io import parse_scene
from fingerdesign.errors import DesignError, Fault
from fingerdesign.mesh.quality import assess
from fingerdesign.records.result import LadderSummary
from fingerdesign.shapes.objects import Plane
from tests.support.half_space import half_plane
from tests.support.reduced import bump, reduced_model

DESIGN = parse_design('design.name = "a"\nbody.width_mm = 12.0\nplates.count = 5\ngrip.seed = 7')
SCENE = parse_scene("path.increments_mm = [[0.1, 0.0]]")
CREST = 10.0 + 20.0 - np.sqrt(20.0**2 - 6.0**2)
GAGES, POINTS = 1e-6 * np.array([[3.0, 1.0], [-2.0, 6.0]]), 1e-6 * np.arange(6.0)[None]
MEASURES = Measures(5.0, 2.0, 8.0, 2.0, 1.5, 0.4, 0.7, 3, 4, 5, 0.01, GAGES, POINTS, 0.3, 0.9)


def step(status=(), approach=0.1, **changes):
    motion = Motion(approach, 0.2, 0.3, 0.4)
    given = {"status": np.array(status), "iterations": 7, "residual": 1e-12}
    return Step(SimpleNamespace(motion=motion, **given), replace(MEASURES, **changes))


@pytest.mark.parametrize(("face", "readings"), [("lower", [1.0, 6.0]), ("upper", [3.0, -2.0])])
def test_a_row_of_the_record_holds_what_was_measured(face, readings):
    row = asdict(increment_result(step(), face))
    own, other = ([*each.values()] for each in row.pop("gages"))
    assert own == pytest.approx([0, 3.0, 1.0, 2.0, 1.0, readings[0]])
    assert other == pytest.approx([1, -2.0, 6.0, 2.0, -4.0, readings[1]])
    assert [*row.pop("points")[0].values()] == pytest.approx(range(6))
    expected = [0.1, 0.2, 5.0, 2.0, 1.5, 0.25, 3, 4, 5, 0.7, 7, 1e-12, 0.3, 0.4, 0.3, 0.9]
    assert [*row.values()] == expected


def facts(status, dim=2, x=0.0, approach=0.1, case=None):
    points = np.full((len(status[0]), dim), x)
    problem = SimpleNamespace(model=SimpleNamespace(points=points, dimension=dim))
    return _of_path(case or Case(DESIGN, SCENE), problem, [step(row, approach) for row in status])


def test_what_the_contact_is_too_little_or_too_wide_for_is_stated():
    enough, late = [[STICK] * 10], [[OPEN] * 10, [OPEN] * 10, [STICK] * 10, [OPEN] * 10]
    assert facts(enough) == facts([[SLIP] * 40], 3) == facts(late, approach=0.0) == {}
    assert facts([[STICK] * 9 + [OPEN]]) == {"few_nodes": {"most": 9, "table": "mesh.section"}}
    assert facts([[SLIP] * 39], 3) == {"few_nodes": {"most": 39, "table": "mesh"}}
    assert facts(enough, x=-6.0) == {"edge": {}}
    assert facts([[OPEN] * 10], x=6.0) == {"not_felt": {"rows": "1 row", "first": 1}}
    assert facts(late) == {"not_felt": {"rows": "2 rows", "first": 1}}
    assert facts(enough, case=Case(DESIGN)) == {"still_sticks": {"percent": 25.0}}
    for values, name in (({"plates.count": 0}, "no_plates"), ({"plates.along": "z"}, "no_row")):
        assert name in facts(enough, case=Case(with_values(DESIGN, values)))


def test_a_deep_press_is_stated_with_what_to_do_and_followed_at_finite_strain():
    enough, deep = [[STICK] * 40], 0.1001 * CREST
    assert facts(enough, approach=0.0999 * CREST) == {}
    known = {"deepest": deep, "share": pytest.approx(0.1001), "remedy": "take --fidelity finite"}
    assert facts(enough, approach=deep) == {"large_strain": known}
    assert facts(enough, approach=deep, case=Case(DESIGN, SCENE, "finite")) == {}
    read = parse_scene("path.increments_mm = [[0.1, 0.0]]\nreadout.points_mm = [[0.0, 5.0, 0.0]]")
    cases = [(SCENE, "3d", deep), (SCENE, "3d", 0.5), (SCENE, "plane-strain", deep)]
    found = [
        too_deep(Case(DESIGN, scene, fidelity), scene, [step(approach=0.0), step(approach=most)])
        for scene, fidelity, most in [*cases, (read, "3d", deep)]
    ]
    assert found == [True, False, False, False]


def test_rows_before_one_that_fails_are_recorded_with_what_was_asked_for():
    problem = contact_problem(half_plane(3.0, 61, 20.0), Plane(0.0), 0.5)
    scene = parse_scene('path = {control = "force", increments_N = [[0.2, 0.01], [0.2, 0.12]]}')
    with pytest.raises(PathStopped, match=r"^row 2 of 2 \(path.increments_N\[1\]\)") as stopped:
        follow_path(problem, scene, DESIGN)
    (row,) = stopped.value.increments
    assert (row.normal_force_N, row.tangential_force_N) == pytest.approx((0.2, 0.01))
    (clock := Clock({"mesh": 1.0})).add({"mesh": 0.5})
    case = Case(DESIGN, scene, "auto")
    failed = failed_analysis(case, stopped.value, clock).result
    assert (failed.increments, failed.fidelity, failed.scene) == ((row,), "3d", "scene")
    assert (failed.seeds, failed.timings_s["mesh"]) == ({"grip": 7}, 1.5)
    assert "coarsen the mesh" in failed_analysis(case, MemoryError(), clock).result.failure
    with pytest.raises(DesignError):
        failed_analysis(case, DesignError([Fault("a", 1, "2", "b")]), clock)


def test_the_zone_is_the_wider_of_path_and_grips():
    case = Case(with_values(load_design("maeno2000"), {"grip.max_approach_mm": 0.6}))
    alone, both = (zone_of(replace(case, grips=own), case.path_scene) for own in (False, True))
    assert both.half_width > alone.half_width == alone.inner == both.inner


@pytest.mark.parametrize("model", [half_plane(1.0, 21, 20.0), bump(7)], ids=["2-D", "3-D"])
def test_tractions_are_forces_over_areas(model):
    """Of the deformed body at finite strain; in 2-D a node's area is of a line."""
    model, flat = replace(model, depth=4.0, symmetry_factor=2), model.dimension == 2
    problem = contact_problem(model, Plane(0.0), 0.5)
    first, last = follow(problem, [Motion(0.01, 0.001), Motion(0.01, 0.004)])
    found = path.contact_history(problem, [first, replace(last, areas=2.0 * model.areas)])
    assert found.areas == pytest.approx(model.areas / 4.0 if flat else model.areas)
    assert found.symmetric
    for k, increment in enumerate((first.increment, last.increment)):
        areas = (k + 1.0) * model.areas
        assert found.normal_traction[k] * areas == pytest.approx(increment.multiplier[:, 0])
        sideways = increment.force[:, [0] if flat else [0, 2]]
        assert found.tangential_traction[k] * areas[:, None] == pytest.approx(sideways)
        assert (found.status[k] == increment.status).all()
        assert (found.slip[k] == increment.state.slip).all()


def test_fields_are_those_of_the_most_stick_and_of_the_last_load():
    model = SimpleNamespace(displacement_fields=lambda forces: 10.0 * forces)
    steps = [step(stick_area=area, normal_force=5.0) for area in (1.0, 3.0, 2.0)]
    steps.append(step(stick_area=0.0, normal_force=0.0))
    for k, each in enumerate(steps):
        each.increment.force = np.full((2, 2), float(k))
    found = recover_fields(model, steps)
    assert (found.increments, found.displacement[:, 0, 0].tolist()) == ((1, 2), [10.0, 20.0])
    moved = [replace(each, displacement=each.increment.force) for each in steps]
    assert recover_fields(model, moved).displacement[:, 0, 0].tolist() == [1.0, 2.0]
    assert recover_fields(model, steps[3:] * 2).increments == (0, 1)


def test_rows_are_targets_by_their_control_and_step_sideways_or_not():
    ball = 'path.increments_mm = [[0.1, 0.0]]\nobject = {shape = "sphere", radius_mm = 9.0}'
    for text, sideways, first in (
        ("path.increments_mm = [[0.1, 0.2]]", False, Motion(0.1, 0.2)),
        ("path.increments_mm = [[0.1, 0.2, 0.02, 1.0]]", True, Motion(0.1, 0.2, 0.02, 1.0)),
        ('path = {control = "force", increments_N = [[3.0, 0.5]]}', False, Forces(3.0, 0.5)),
        (ball, True, Motion(0.1, 0.0)),
    ):
        scene = parse_scene(text)
        assert (path.steps_sideways(scene), path.targets(scene.path)) == (sideways, [first])


def test_a_summary_of_a_study_holds_what_was_studied(plane_strain):
    study = replace(
        plane_strain.slip_studies[0],
        **{"rank_correlation": 0.7, "rank_correlation_raw": 0.6, "step_correlation": 0.5},
        gage_area_mm=np.array([1.0, 3.0, *[4.0] * 8, 0.0]),
        stick_length_mm=np.array([9.0, 5.0, *[3.0] * 8, 1.0]),
        stick_ratio=np.array([np.nan, *[0.5] * 10]),
        rank_by_share=((0.3, 0.4),),
    )
    assert [*asdict(analysis.study_summary(study)).values()] == [
        *(study.friction_coefficient, 0.7, 0.6, study.threshold, 0.05, 0.5),
        *((0.0, 4.0), (1.0, 5.0), 11, ((0.3, 0.4),)),
    ]
    later = replace(study, gage_area_mm=np.array([0.0, *[2.0] * 10]))
    assert analysis.study_summary(later).gage_area_mm == (2.0, 2.0)


def test_a_summary_of_a_mesh_is_of_its_quality(plane_strain):
    mesh, design = plane_strain.mesh, load_design("maeno2000")
    found = asdict(analysis.mesh_summary(mesh, design))
    assert (found.pop("elements"), found.pop("mesher")) == (len(mesh.cells), "synthetic")
    assert found == {key: getattr(assess(mesh, design), key) for key in found}
    bare = with_values(design, {"plates.model": "none"})
    assert analysis.mesh_summary(mesh, bare).worst_plate_volume_error is None


def stated(friction=0.5, summary=None):
    """The caveats of a small path, and its steps."""
    problem = contact_problem(half_plane(1.0, 41, 20.0), Plane(0.0), friction)
    steps = list(follow(problem, [Motion(0.02, 0.0), Motion(0.02, 0.002)]))
    choice = Choice(Case(DESIGN, SCENE), None, None, [], summary)
    return analysis.caveats(choice, SCENE, problem, steps), problem, steps


def test_a_ladder_that_falls_short_states_its_worst_quantity():
    estimates = {"gage": 0.1, "normal_force": 0.25, "tangential_force": 0.03}
    ladder = LadderSummary(0.02, False, "a", estimates, "b", ())
    reached = stated(summary=replace(ladder, reached=True))[0]
    (found,) = {*stated(summary=ladder)[0]} - {*reached}
    assert re.search(r"normal force.*25|25.*normal force", found)


def test_other_answers_are_searched_for_from_where_the_last_row_began(calls_of):
    searched = calls_of(analysis, "other_solutions")
    stated(1.0)
    assert not searched
    _, problem, (_, last) = stated(1.1)
    ((given, _),) = searched
    expected = (problem, last.before, last.increment.motion, last.increment)
    assert all(one is other for one, other in zip(given, expected, strict=True))


def test_the_array_has_the_gages_of_its_row_alone():
    rows = [{"count": 4, "cover_mm": 4.5}]
    case = Case(with_values(DESIGN, {"plates.count": 3, "plates.rows": rows}), SCENE)
    points = np.zeros((2, 2))
    model = reduced_model(points, np.eye(4), gage_readout=np.arange(56.0).reshape(14, 4))
    model = replace(model, gage_x=np.arange(7.0), gage_positions=np.zeros((7, 3)))
    problem = contact_problem(model, Plane(0.0), 0.5)
    found = Followed(Choice(case, None, None, []), problem, []).array
    np.testing.assert_array_equal(found.model.gage_readout, model.gage_readout[6:])
    assert found.model.gage_x.tolist() == [3.0, 4.0, 5.0, 6.0]
    assert found.gap0 is problem.gap0


def test_the_fundamental_path_is_as_deep_as_the_design_says_its_shears_in_proportion():
    own = np.array(fundamental_scene().path.rows)
    design = with_values(DESIGN, {"grip.fundamental_approach_mm": 0.07})
    scaled = np.array(fundamental_scene(design).path.rows)
    assert scaled[:, 0].max() == pytest.approx(0.07)
    assert scaled == pytest.approx(own * 0.07 / own[:, 0].max())
