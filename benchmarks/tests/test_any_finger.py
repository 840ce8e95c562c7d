"""bench any-finger: random designs are sound and of every kind, invalid ones refused by the key."""

from collections import Counter

import pytest
import tomlkit
from fingerdesign_bench.any_finger import any_finger
from fingerdesign_bench.any_finger.any_finger import (
    ASKED,
    LINES,
    AnyFinger,
    extrude_straight,
    measure_any_finger,
    refuse_faults,
)
from fingerdesign_bench.any_finger.designs import (
    BODIES,
    FAULTS,
    PLATES,
    RANGES,
    invalid_design,
    kinds,
    random_design,
)
from fingerdesign_bench.any_finger.worker import mesh_one
from fingerdesign_bench.lines import read_lines

from fingerdesign.checks.load import parse_design
from fingerdesign.design import step as step_facts

# Ten that are of every kind together.
FIVE = (1, 2, 4, 5, 8)  # `bench any-finger` meshes two hundred


def record(seed, **changed):
    sound = dict.fromkeys(ASKED, 0.0) | {"min_dihedral_deg": 9.0, "seconds": 1.0, "elements": 5}
    return {"seed": seed, "kinds": ["arc"], "status": "meshed"} | sound | changed


def test_a_run_has_a_record_of_each_design(monkeypatch, tmp_path):
    monkeypatch.setattr(any_finger, "_run", record)
    monkeypatch.setattr(any_finger, "refuse_faults", lambda number: [])
    monkeypatch.setattr(any_finger, "extrude_straight", lambda number: [])
    found = measure_any_finger(tmp_path, count=4)
    assert [each["seed"] for each in found.records] == [0, 1, 2, 3]
    assert len(read_lines(tmp_path / LINES)) == 4


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


@pytest.mark.slow
def test_straight_designs_extrude_with_angles_over_a_degree():
    found = extrude_straight(30)
    assert len(found) >= 3
    assert min(each["min_dihedral_deg"] for each in found) > 1.0
    assert max(each["body_volume_error"] for each in found) < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("seed", FIVE)
def test_a_random_design_meshes(seed, monkeypatch, tmp_path):
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path))
    found = mesh_one(seed)
    assert found["status"] == "meshed", found.get("reason")
    assert all(found[name] <= most for name, most in ASKED.items())
    assert found["min_dihedral_deg"] > 5.0


COUNT = 200


@pytest.fixture
def step_in_this_process(monkeypatch, tmp_path):
    """STEP files are read without a process of their own: fast, and what is said is the same."""
    from fingerdesign.runtime.child import resolved

    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path))
    monkeypatch.setattr(step_facts, "call", lambda name, *given, time_s: resolved(name)(*given))
    step_facts._outcome.cache_clear()


def test_each_kind_is_a_tenth_of_the_designs():
    found = Counter(kind for seed in range(COUNT) for kind in kinds(seed))
    assert set(found) == {*BODIES, *PLATES, "edged", "cored"}
    assert min(found.values()) >= COUNT // 10


@pytest.mark.parametrize("shape", [0, 1, 2, 3])
def test_random_designs_are_sound_and_of_their_kind(shape):
    for seed in range(shape, COUNT, 15):
        if kinds(seed)[0] == "step":
            continue
        data = random_design(seed)
        assert data == random_design(seed)
        design = parse_design(tomlkit.dumps(data))
        body, *_, plates = kinds(seed)
        assert design.body.shape == body
        assert (design.body.edge_radius_mm is not None) == ("edged" in kinds(seed))
        assert (design.body.core is not None) == ("cored" in kinds(seed))
        first = design.plates
        assert plates != "none" or first.count == 0 or first.model == "none"
        assert (first.follow if plates in ("turned", "bent") else "level") == first.follow
        assert (first.along == "z") == (plates == "along_z")
        assert (len(first.rows) == 1) == (plates == "two_rows")
        assert (first.hole_diameter_mm is not None) == (plates == "perforated")
        assert (first.model == "sheet") == (plates == "sheet")
        assert (first.stagger_mm != 0.0) == (plates == "staggered")
        low, high = RANGES["body.width_mm"]
        assert low <= design.body.width_mm <= high


@pytest.mark.usefixtures("step_in_this_process")
def test_a_random_design_may_be_a_step_file():
    seed = next(seed for seed in range(COUNT) if kinds(seed)[0] == "step")
    design = parse_design(tomlkit.dumps(random_design(seed)))
    assert design.body.step is not None
    assert design.body.shape == "step"


@pytest.mark.usefixtures("step_in_this_process")
def test_every_invalid_design_is_refused_by_the_key_to_blame():
    assert len(FAULTS) <= COUNT
    found = refuse_faults(COUNT)
    assert [each for each in found if not each["named"]] == []
    assert len({each["key"] for each in found}) > 60
    assert invalid_design(0) == invalid_design(0) != invalid_design(len(FAULTS))
