"""What is recorded of a path, by made-up steps: rows, contact, caveats, fields, failures."""

from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
import pytest

from fingerdesign.analysis.analysis import _of_path, failed_analysis, too_deep
from fingerdesign.analysis.case import Case, Clock
from fingerdesign.analysis.path import PathStopped, follow_path, increment_result
from fingerdesign.analysis.stages import zone_of
from fingerdesign.checks.load import load_design, parse_design, with_values
from fingerdesign.contact.laws import OPEN, SLIP, STICK
from fingerdesign.contact.measures import Measures
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.design.io import parse_scene
from fingerdesign.errors import DesignError, Fault
from fingerdesign.shapes.objects import Plane
from tests.support.half_space import half_plane

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
