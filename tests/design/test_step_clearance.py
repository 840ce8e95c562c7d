"""Plates in a STEP body: judged against its own faces, as those of a like parametric body are."""

from pathlib import Path

import numpy as np
import pytest

from fingerdesign.design import step_facts
from fingerdesign.design.clearance import cover_clearances, surface_clearances
from fingerdesign.design.forecast import crest_curvatures, summarise
from fingerdesign.design.io import judge_design, with_values
from fingerdesign.design.layout import PlateFrame
from fingerdesign.design.schema import Body

STEP = """
design.name = "a"
body.shape = "step"
body.step.file = "{file}"
gages.length_mm = 0.5
gages.width_mm = 0.5
[plates]
count = 3
length_mm = 1.4
pitch_mm = 1.5
cover_mm = 2.8
"""


@pytest.fixture(scope="module")
def filleted(tmp_path_factory):
    """A box of 16 x 10 x 12 mm whose upper edges are rounded by 1.5 mm: its design's text."""
    from fingerdesign.geometry.step_samples import sample_step
    from fingerdesign.geometry.step_worker import answer

    patch = pytest.MonkeyPatch()
    patch.setenv("FINGERDESIGN_CACHE", str(tmp_path_factory.mktemp("cache")))
    patch.setattr(step_facts, "run_module", lambda _m, a, _f, _t: answer(Path(a[0])))
    step_facts._outcome.cache_clear()
    yield STEP.format(file=sample_step("filleted", 16.0, 12.0, 10.0, 1.5))
    patch.undo()


def keys(text):
    return [fault.key for fault in judge_design(text).faults]


def test_depths_are_those_of_the_like_rounded_block(filleted):
    step = judge_design(filleted).value
    like = Body(
        shape="block", width_mm=16.0, base_height_mm=10.0, depth_mm=12.0, edge_radius_mm=1.5
    )
    rng = np.random.default_rng(1)
    points = rng.uniform((-7.9, 0.5, -3.0), (7.9, 11.0, 3.0), (200, 3))
    ours, theirs = (surface_clearances(body, points) for body in (step.body, like))
    inside = theirs > 0.0
    assert 30 < inside.sum() < 200
    assert np.array_equal(ours > 0.0, inside)
    near = np.abs(theirs) < 1.5  # deeper, the edges at the step body's ends are as near
    np.testing.assert_allclose(ours[near], theirs[near], atol=1e-6)
    frame = PlateFrame(0, 1.0, 8.0, 30.0, 2.0, 0.2, -3.0, 3.0)
    found = [cover_clearances(body, (frame,))[0] for body in (step.body, like)]
    assert found[0] == pytest.approx(found[1], abs=1e-6)
    assert crest_curvatures(step.body) == (0.0, 0.0)
    assert summarise(step).body == "step"


def test_each_fault_is_blamed_on_its_key(filleted):
    assert keys(filleted) == []
    assert keys(filleted + "span_mm = 11.8") == []
    assert keys(filleted + "span_mm = 11.9") == ["plates.span_mm"]
    assert keys(filleted.replace("cover_mm = 2.8", "cover_mm = 0.3")) == ["plates.cover_mm"]
    assert keys(filleted.replace("pitch_mm = 1.5", "pitch_mm = 7.5")) == ["plates.pitch_mm"]
    assert keys(filleted.replace("count = 3", "count = 3\noffset_mm = 30.0")) == [
        "plates.offset_mm"
    ]


def test_a_step_designs_keys_can_be_changed(filleted):
    design = judge_design(filleted).value
    assert with_values(design, {"plates.count": 1}).plates.number == 1
