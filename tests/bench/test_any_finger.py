"""bench any-finger: it goes on where it stopped, its checks can fall short, and designs mesh."""

import json

import pytest
from fingerdesign_bench.any_finger import any_finger
from fingerdesign_bench.any_finger.any_finger import (
    ASKED,
    LINES,
    AnyFinger,
    extrude_straight,
    measure_any_finger,
)
from fingerdesign_bench.any_finger.designs import BODIES, PLATES, kinds
from fingerdesign_bench.any_finger.worker import mesh_one

# Twelve that are of every kind together.
DOZEN = (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 45)


def record(seed, **changed):
    sound = dict.fromkeys(ASKED, 0.0) | {"min_dihedral_deg": 9.0, "seconds": 1.0, "elements": 5}
    return {"seed": seed, "kinds": ["arc"], "status": "meshed"} | sound | changed


@pytest.fixture
def quick(monkeypatch):
    """Nothing is meshed: which seeds are asked for is remembered."""
    asked = []

    def run(seed):
        asked.append(seed)
        return record(seed, version=any_finger._version())

    monkeypatch.setattr(any_finger, "_run", run)
    monkeypatch.setattr(any_finger, "refuse_faults", lambda number: [])
    monkeypatch.setattr(any_finger, "extrude_straight", lambda number: [])
    return asked


def test_an_interrupted_run_goes_on_where_it_stopped(quick, tmp_path):
    measure_any_finger(tmp_path, count=4)
    lines = (tmp_path / LINES).read_text("utf-8").splitlines()
    assert len(lines) == 4
    first, second, third, _ = (json.loads(line) for line in lines)
    second["version"] = "another"
    third["status"] = "crashed"
    kept = [json.dumps(first), json.dumps(second), json.dumps(third), lines[3][:20]]
    (tmp_path / LINES).write_text("\n".join(kept), encoding="utf-8")
    again = sorted({second["seed"], third["seed"], json.loads(lines[3])["seed"]})
    quick.clear()
    found = measure_any_finger(tmp_path, count=4)
    assert sorted(quick) == again  # of another version, crashed, cut short
    assert [each["seed"] for each in found.records] == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("invalid", "falls"),
    [
        ({"status": "refused", "reason": "no"}, "designs not meshed"),
        ({"min_dihedral_deg": 4.9}, "5 degrees less the least dihedral angle"),
        ({"body_volume_error": 2e-3}, "body volume error"),
        ({"contact_residual_mm": 2e-6}, "contact residual"),
        ({"status": "crashed", "reason": "no"}, "crashes and hangs"),
    ],
)
def test_each_check_can_fall_short(invalid, falls):
    good = AnyFinger([record(k) for k in range(10)], [{"named": True}])
    assert all(check.holds for check in good.checks())
    bad = AnyFinger([record(0, **invalid), *good.records[1:]], good.refusals)
    assert falls in {check.name for check in bad.checks() if not check.holds}
    flat = AnyFinger(good.records, good.refusals, [{"min_dihedral_deg": 0.9}])
    assert [c.name for c in flat.checks() if not c.holds] == [
        "1 degree less the least dihedral angle, extruded"
    ]
    unnamed = AnyFinger(good.records, [{"named": False}])
    assert not all(check.holds for check in unnamed.checks())


def test_straight_designs_extrude_with_angles_over_a_degree():
    found = extrude_straight(60)
    assert len(found) >= 6
    assert min(each["min_dihedral_deg"] for each in found) > 1.0
    assert max(each["body_volume_error"] for each in found) < 1e-3


def test_the_dozen_is_of_every_kind():
    assert {kind for seed in DOZEN for kind in kinds(seed)} == {*BODIES, *PLATES, "edged", "cored"}


@pytest.mark.slow
@pytest.mark.parametrize("seed", DOZEN)
def test_a_random_design_meshes(seed, monkeypatch, tmp_path):
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path))
    found = mesh_one(seed)
    assert found["status"] == "meshed", found.get("reason")
    assert all(found[name] <= most for name, most in ASKED.items())
    assert found["min_dihedral_deg"] > 5.0
