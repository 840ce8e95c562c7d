"""Plates in a STEP body: judged against its own faces, as those of a like parametric body are."""

import numpy as np
import pytest
from cadquery import Workplane
from fingerdesign_bench.any_finger.step_samples import sample_step

from fingerdesign.checks.load import judge_design
from fingerdesign.design.plates import Plates
from fingerdesign.design.schema import Body
from fingerdesign.layout.clearance import cover_clearances, surface_clearances
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import row_frames
from fingerdesign.layout.summary import summarise
from tests.support.steps import read_here, write

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
    with pytest.MonkeyPatch.context() as patch:
        read_here(patch, tmp_path_factory.mktemp("cache"))
        yield STEP.format(file=sample_step("filleted", 16.0, 12.0, 10.0, 1.5))


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
    assert step.body.kind.curvatures(step.body) == (0.0, 0.0)
    assert summarise(step).body == "step"


@pytest.mark.parametrize("along", ["x", "z"])
def test_turned_plates_follow_a_rounded_edge(filleted, along):
    """6.5 or 4.5 mm along the flat, then around the edge's 1.5 mm."""
    body = judge_design(filleted).value.body
    flat = (8.0 if along == "x" else 6.0) - 1.5
    turn = np.radians(40.0)
    row = {"count": 2, "pitch_mm": 2.0 * (flat + 1.5 * turn), "cover_mm": 0.5, "angle_deg": 10.0}
    frames = row_frames(body, Plates(**row, follow="bent", along=along), 0)
    for frame, side in zip(frames, (-1.0, 1.0), strict=True):
        assert frame.place == pytest.approx(side * (flat + 1.0 * np.sin(turn)), abs=0.01)
        assert frame.y == pytest.approx(8.5 + 1.0 * np.cos(turn), abs=0.01)
        assert frame.angle_deg == pytest.approx(10.0 - side * 40.0, abs=0.5)
        assert frame.bend_radius == pytest.approx(1.0, abs=0.05)
    (middle,) = row_frames(body, Plates(**row | {"count": 1}, follow="bent", along=along), 0)
    assert (middle.place, middle.y, middle.angle_deg) == pytest.approx((0.0, 9.5, 10.0))
    assert middle.bend_radius is None


def test_each_fault_is_blamed_on_its_key(filleted):
    assert keys(filleted) == []
    assert keys(filleted + "span_mm = 11.8") == []
    assert keys(filleted + "span_mm = 11.9") == ["plates.span_mm"]
    assert keys(filleted.replace("cover_mm = 2.8", "cover_mm = 0.3")) == ["plates.cover_mm"]
    assert keys(filleted.replace("pitch_mm = 1.5", "pitch_mm = 7.5")) == ["plates.pitch_mm"]
    assert keys(filleted.replace("count = 3", "count = 3\noffset_mm = 30.0")) == [
        "plates.offset_mm"
    ]


@pytest.mark.parametrize(
    ("core", "key"),
    [
        ("width_mm = 6.0\nheight_mm = 2.0\ndepth_mm = 6.0", None),
        ("width_mm = 16.0\nheight_mm = 2.0", None),  # ends in the sides and end faces
        ("width_mm = 16.0\nheight_mm = 2.0\nbottom_mm = 2.0", "body.core.bottom_mm"),
        ("width_mm = 15.9\nheight_mm = 2.0\ndepth_mm = 6.0", "body.core.width_mm"),
        ("width_mm = 7.0\nheight_mm = 2.0\ndepth_mm = 7.0\nbottom_mm = 1.0", None),
    ],
)
def test_a_core_ends_in_the_walls_or_clear_of_them(filleted, core, key):
    found = keys(filleted.replace("count = 3", "count = 0") + f"[body.core]\n{core}\n")
    assert found == ([] if key is None else [key])


@pytest.mark.slow
@pytest.mark.usefixtures("filleted")
def test_a_core_that_leaves_a_round_body_may_be_narrowed(tmp_path):
    round_body = Workplane("XZ").circle(8.0).extrude(-10.0)  # base in y = 0
    holed = round_body.cut(Workplane("XZ").center(0.0, 3.0).circle(1.0).extrude(-10.0))
    for name, work in (("round", round_body), ("holed", holed)):
        write(work, tmp_path / f"{name}.step")
    core = "[body.core]\nwidth_mm = 14.0\nheight_mm = 2.0\ndepth_mm = {depth}\n"
    bare = STEP.replace("count = 3", "count = 0") + core
    assert keys(bare.format(file=tmp_path / "round.step", depth=4.0)) == []
    (fault,) = judge_design(bare.format(file=tmp_path / "round.step", depth=12.0)).faults
    assert fault.key == "body.core.width_mm"
    assert float(fault.remedy.split()[-1]) == pytest.approx(2.0 * np.sqrt(7.9**2 - 36.0), abs=2e-3)
    assert keys(bare.format(file=tmp_path / "holed.step", depth=3.0)) == []
    assert keys(bare.format(file=tmp_path / "holed.step", depth=8.0)) != []
