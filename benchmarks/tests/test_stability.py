"""bench stability: the judge on closed forms and on each law broken; the map of a few cases."""

import csv
import json
import time
from dataclasses import replace

import numpy as np
import pytest
from fingerdesign_bench.stability import stability
from fingerdesign_bench.stability.bodies import distorted, hard_bodies
from fingerdesign_bench.stability.cases import BEYOND, FRICTIONS, WITHIN, cases_of
from fingerdesign_bench.stability.judge import SHARP, Judge, Past, same_total
from fingerdesign_bench.stability.laws import sampled
from fingerdesign_bench.stability.run import PRODUCTION, TimeIsUp, Verdict, time_limit
from fingerdesign_bench.stability.stability import counts_of, measure_stability, run_bodies, summary

from fingerdesign.contact.problem import Motion
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.shapes.friction import FrictionLaw
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import reduced_model

pytestmark = pytest.mark.slow
# Nodes 1 to 3 are pressed by 0.5, 0.2 and 0.05 mm, node 0 not at all; sheared by 0.1 mm with
# mu = 0.4 the first needs 0.2 N of its 0.4 N and sticks, the others slide at 0.16 and 0.04 N.
HEIGHTS = [-1.0, 0.0, -0.3, -0.45]
MOTION = Motion(0.5, 0.1)
RIGHT = np.array([[0.0, 0.0], [0.2, -1.0], [0.16, -0.4], [0.04, -0.1]])


def springs(heights, stiffness=2.0, dim=2):
    """Uncoupled nodes on springs of ``stiffness`` N/mm in each direction, at given heights."""
    m = len(heights)
    points = np.zeros((m, dim))
    points[:, 0], points[:, 1] = np.arange(m), heights
    return reduced_model(points, np.eye(m * dim) / stiffness, rim=np.arange(m) == 0)


@pytest.fixture
def judge():
    return Judge(springs(HEIGHTS), Plane(0.0), FrictionLaw(0.4))


def broken(node, force):
    wrong = RIGHT.copy()
    wrong[node] = force
    return wrong


def test_the_right_answer_is_right_and_errors_are_told_from_rounding(judge):
    assert judge.violation(RIGHT, judge.untouched(), MOTION) < 1e-12
    assert not judge.at_rim(RIGHT)
    for size in (1e-3, 1e-5, 1e-7):
        found = judge.violation(RIGHT + size, judge.untouched(), MOTION)
        assert 0.1 * size < found < 10 * size


@pytest.mark.parametrize(
    ("law", "node", "force"),
    [
        ("tension", 0, [0.0, 0.1]),
        ("force across a gap", 0, [0.0, -0.1]),
        ("drag without pressure", 0, [0.1, 0.0]),
        ("penetration", 1, [0.2, -0.9]),
        ("lifted by its own force", 1, [0.2, -1.1]),
        ("sticks outside the disc", 2, [0.2, -0.4]),
        ("slides below the bound", 2, [0.1, -0.4]),
        ("creeps while it sticks", 1, [0.15, -1.0]),
        ("slides against its force", 3, [-0.04, -0.1]),
        ("not a number", 2, [np.nan, -0.4]),
    ],
)
def test_each_law_broken_is_found(judge, law, node, force):
    assert judge.violation(broken(node, force), judge.untouched(), MOTION) > 1e-2


def test_slip_is_counted_from_the_past(judge):
    """Sheared back by 0.05 mm, what slid before now sticks: the history decides."""
    back = Motion(0.5, 0.05)
    past = Past(RIGHT, MOTION)
    answer = RIGHT.copy()
    answer[1:, 0] += 2.0 * (0.05 - 0.1)
    answer[3, 0] = -0.04  # -0.06 were needed to stick
    assert judge.violation(answer, past, back) < 1e-12
    assert judge.violation(answer, judge.untouched(), back) > 1e-2


def test_direction_of_slip_in_space():
    """In 3-D the force must oppose the slip: turned by a degree it is wrong."""
    judge = Judge(springs([0.0, 0.0, 0.0], dim=3), Plane(0.0), FrictionLaw(0.1))
    motion = Motion(0.5, 0.3, 0.4)
    force = np.tile([0.06, -1.0, 0.08], (3, 1))
    assert judge.violation(force, judge.untouched(), motion) < 1e-12
    turned = np.tile([0.08, -1.0, 0.06], (3, 1))
    assert judge.violation(turned, judge.untouched(), motion) > 1e-2


def test_no_contact(judge):
    nothing = np.zeros((4, 2))
    assert judge.violation(nothing, judge.untouched(), Motion(-0.1, 0.3)) == 0.0
    assert judge.violation(nothing, judge.untouched(), Motion(0.1, 0.0)) > 1e-2


def test_lost_force_is_found(judge):
    """A model whose base does not carry what the contact gives."""
    leaky = replace(judge.model, reaction_readout=0.9 * judge.model.reaction_readout)
    lost = replace(judge, model=leaky)
    assert lost.violation(RIGHT, judge.untouched(), MOTION) > 1e-2


def test_the_rim_and_the_forces_requested(judge):
    assert judge.at_rim(broken(0, [0.0, -0.1]))
    assert all(judge.carries(RIGHT, 1.5, shear) for shear in (0.4, None))
    assert not any(judge.carries(RIGHT, *more) for more in ((1.5, 0.41), (1.6, None)))


def test_same_answers(judge):
    assert judge.same(RIGHT, RIGHT * (1 + 1e-6), MOTION)
    assert not judge.same(RIGHT, RIGHT * 1.01, MOTION)
    assert judge.same(np.zeros((4, 2)), np.full((4, 2), 1e-16), MOTION)
    assert same_total(RIGHT, RIGHT * 1.005, 0.01)
    assert not same_total(RIGHT, RIGHT * 1.02, 0.01)


@pytest.mark.parametrize("dim", [2, 3])
def test_second_answer_is_found_and_right(dim):
    judge = Judge(springs(HEIGHTS, dim=dim), Plane(0.0), FrictionLaw(0.4))
    answer = judge.second_answer(judge.untouched(), MOTION)
    assert np.allclose(answer[:, :2], RIGHT, atol=1e-9)
    assert judge.violation(answer, judge.untouched(), MOTION) < SHARP


@pytest.fixture(scope="module")
def quick():
    """Half of what the command's --quick runs."""
    half = {name: 2 * every for name, every in stability._QUICK.items()}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stability, "_QUICK", half)
        return run_bodies(lambda message: None, quick=True)


@pytest.fixture(scope="module")
def mine(quick):
    return [each for each in quick if each.method == PRODUCTION]


def test_production_is_never_wrong_and_solves_all_but_forces_beyond_friction(quick, mine):
    assert len(mine) >= 25
    assert max(each.verdict.rank for each in mine) <= Verdict.REFUSED.rank
    assert sum(each.verdict == Verdict.REFUSED for each in mine) < 0.3 * len(mine)
    assert {each.verdict for each in mine if each.family == BEYOND} == {Verdict.REFUSED}
    assert WITHIN in {each.family for each in mine}


def test_most_answers_are_confirmed_by_a_second_method(mine):
    right = [each for each in mine if each.verdict == Verdict.RIGHT]
    assert sum(each.confirmed for each in right) > 0.95 * sum(each.increments for each in right)


def test_production_is_right_under_laws_of_pressure_too():
    found = list(sampled(every=301))
    assert len(found) >= 10
    assert {law for law, _ in found} == {"capped", "shear strength", "power"}
    assert max(each.verdict.rank for _, each in found) <= Verdict.REFUSED.rank
    assert max(each.violation for _, each in found) <= SHARP


def test_zone_exhausted_is_refused_never_clipped(mine):
    exhausted = [each for each in mine if each.family == "zone exhausted"]
    assert {each.verdict for each in exhausted} == {Verdict.REFUSED}
    assert all("zone" in each.reason for each in exhausted)


def test_plain_methods_fail_where_the_map_says_so(quick):
    counts = counts_of(quick)
    assert counts["plain semi-smooth Newton"]["failed"] > 0
    assert counts["penalty"]["failed"] + counts["penalty"]["wrong"] > 0


def test_files(quick, tmp_path, monkeypatch):
    monkeypatch.setattr(stability, "run_bodies", lambda *given: quick)
    found = measure_stability(tmp_path, lambda message: None, quick=True)
    paths = found.write(tmp_path, "stability")
    assert [path.name for path in paths] == ["stability.csv", "stability.json", "stability.png"]
    rows = list(csv.DictReader(paths[0].read_text("utf-8").splitlines()))
    assert len(rows) == len(quick)
    assert rows[0]["method"] == PRODUCTION
    record = json.loads(paths[1].read_text("utf-8"))
    assert record | summary(quick) == record
    assert paths[2].read_bytes().startswith(b"\x89PNG")


def test_there_are_enough_cases_of_all_kinds():
    """Every body has every friction coefficient; a cheap count, as bodies differ in rims only."""
    bodies = hard_bodies()
    assert len({body.name for body in bodies}) == len(bodies) >= 15
    assert {0.0, 0.3, 0.49, 0.4999} <= {body.poissons_ratio for body in bodies}
    body = next(each for each in bodies if each.name == "coarse, nu 0.3")
    cases = list(cases_of(body, *body.build()))
    assert {case.friction for case in cases} == set(FRICTIONS)
    assert len(cases) >= 63
    assert len(bodies) * len(cases) >= 500


def test_distortion_keeps_outline_and_area():
    body = next(each for each in hard_bodies() if each.distortion)
    design = body.parsed()
    mesh = mesh_section(design, body.zone)
    moved = distorted(mesh, body.distortion, body.seed)
    outline = np.unique(np.concatenate(list(mesh.facets.values())))
    assert np.array_equal(moved.points[outline], mesh.points[outline])
    shift = np.linalg.norm(moved.points - mesh.points, axis=1)
    assert shift.max() > 0.02
    corners = moved.points[moved.corners]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    assert (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).min() > 0.0
    assert np.array_equal(distorted(mesh, body.distortion, body.seed).points, moved.points)


def test_what_hangs_is_ended():
    def hang():
        until = time.process_time() + 10.0
        while time.process_time() < until:
            pass

    with pytest.raises(TimeIsUp), time_limit(0.05):
        hang()
