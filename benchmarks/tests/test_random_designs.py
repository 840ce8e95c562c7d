"""Random designs: sound, repeatable and of every kind."""

from collections import Counter

import pytest
import tomlkit
from fingerdesign_bench.any_finger.designs import BODIES, PLATES, RANGES, kinds, random_design

from fingerdesign.checks.load import parse_design
from fingerdesign.design import step as step_facts

COUNT = 200


@pytest.fixture
def step_in_this_process(monkeypatch, own_cache):
    """STEP files are read without a process of their own: fast, and the outcome is the same."""
    from fingerdesign.runtime.child import resolved

    monkeypatch.setattr(step_facts, "call", lambda name, *given, time_s: resolved(name)(*given))
    step_facts._outcome.cache_clear()


def test_each_kind_is_a_tenth_of_the_designs():
    found = Counter(kind for seed in range(COUNT) for kind in kinds(seed))
    assert set(found) == {*BODIES, *PLATES, "edged", "cored"}
    assert min(found.values()) >= COUNT // 10


@pytest.mark.parametrize("shape", [0, 1, 2, 3])
def test_random_designs_are_sound_and_of_their_kind(shape):
    for seed in (seed for seed in range(shape, COUNT, 15) if kinds(seed)[0] != "step"):
        data = random_design(seed)
        assert data == random_design(seed)
        design = parse_design(tomlkit.dumps(data))
        body, first, plates = design.body, design.plates, kinds(seed)[-1]
        found = {
            body.shape: True,
            "edged": body.edge_radius_mm is not None,
            "cored": body.core is not None,
            first.follow: True,
            "along_z": first.along == "z",
            "two_rows": len(first.rows) == 1,
            "perforated": first.hole_diameter_mm is not None,
            "sheet": first.model == "sheet",
            "staggered": first.stagger_mm != 0.0,
        }
        own = {kind for kind, has in found.items() if has} - {"level"}
        assert own == set(kinds(seed)) - {"level", "finite", "none"}
        assert plates != "none" or first.count == 0 or first.model == "none"
        low, high = RANGES["body.width_mm"]
        assert low <= body.width_mm <= high


@pytest.mark.usefixtures("step_in_this_process")
def test_a_random_design_may_be_a_step_file():
    seed = next(seed for seed in range(COUNT) if kinds(seed)[0] == "step")
    design = parse_design(tomlkit.dumps(random_design(seed)))
    assert design.body.step is not None
    assert design.body.shape == "step"
