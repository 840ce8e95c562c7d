"""The map itself on a quick subset: no wrong answer, everything solved; verdicts; files."""

import csv
import dataclasses
import json
import time

import numpy as np
import pytest
from fingerdesign_bench.stability import stability
from fingerdesign_bench.stability import stability as stability_map
from fingerdesign_bench.stability.bodies import distorted, hard_bodies
from fingerdesign_bench.stability.cases import BEYOND, FRICTIONS, WITHIN, cases_of
from fingerdesign_bench.stability.run import METHODS, PRODUCTION, TimeIsUp, Verdict, time_limit
from fingerdesign_bench.stability.stability import measure_stability, summary, write_stability

from fingerdesign.mesh.section.section import mesh_section

GOOD = (Verdict.RIGHT, Verdict.OTHER, Verdict.REFUSED)


@pytest.fixture(scope="module")
def quick():
    return measure_stability(quick=True)


def test_production_is_never_wrong_and_solves_all(quick):
    mine = [each for each in quick.outcomes if each.method == PRODUCTION]
    assert len(mine) == quick.cases() >= 50
    assert not [e for e in mine if e.verdict not in GOOD and e.family not in (WITHIN, BEYOND)]
    assert not [e for e in mine if e.verdict == Verdict.WRONG]
    assert sum(each.verdict == Verdict.REFUSED for each in mine) < 0.3 * len(mine)


def test_forces_prescribed(quick):
    mine = [e for e in quick.outcomes if e.family in (WITHIN, BEYOND) and e.method == PRODUCTION]
    assert mine
    assert {e.verdict for e in mine if e.family == BEYOND} == {Verdict.REFUSED}
    assert not [e for e in mine if e.verdict not in GOOD]
    assert all(check.holds for check in quick.checks())


def test_most_answers_are_confirmed_by_a_second_method(quick):
    mine = [e for e in quick.outcomes if e.method == PRODUCTION and e.verdict == Verdict.RIGHT]
    assert sum(each.confirmed for each in mine) > 0.95 * sum(each.increments for each in mine)


def test_zone_exhausted_is_refused_never_clipped(quick):
    mine = [e for e in quick.outcomes if e.family == "zone exhausted" and e.method == PRODUCTION]
    assert mine
    assert {each.verdict for each in mine} == {Verdict.REFUSED}
    assert all("zone" in each.reason for each in mine)


def test_plain_methods_fail_where_the_map_says_so(quick):
    counts = quick.counts()
    assert counts["plain semi-smooth Newton"]["failed"] > 0
    assert counts["penalty"]["failed"] + counts["penalty"]["wrong"] > 0


def test_files(quick, tmp_path):
    paths = write_stability(quick, tmp_path / "new")
    assert [path.name for path in paths] == ["stability.csv", "stability.json", "stability.png"]
    with paths[0].open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == len(quick.outcomes)
    assert rows[0]["method"] == PRODUCTION
    assert json.loads(paths[1].read_text("utf-8")) == summary(quick)
    assert paths[2].read_bytes().startswith(b"\x89PNG")


def test_interrupted_writing_leaves_the_older_files(quick, tmp_path, monkeypatch):
    paths = write_stability(quick, tmp_path)
    before = [path.read_bytes() for path in paths]

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(stability_map, "draw_stability", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_stability(dataclasses.replace(quick, outcomes=quick.outcomes[:3]), tmp_path)
    assert [path.read_bytes() for path in paths] == before
    assert sorted(tmp_path.iterdir()) == sorted(paths)


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


def test_methods_are_distinguished_in_the_counts():
    assert METHODS[0] == PRODUCTION
    assert len(set(METHODS)) == 4
    assert stability.SOLVED_SHARE == 0.99
