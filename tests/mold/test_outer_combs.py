"""Second combs: where their slots push the legs, what that takes off the tolerance, and the bow."""

import numpy as np
import pytest

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.mold.placement import row_tolerances, tolerances
from fingerdesign.mold.plan.fixture.outer import bow, push_of
from fingerdesign.mold.plan.pieces import Slot, direction, slot_corners
from fingerdesign.mold.plan.plan import spacer_height
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.plan.slots import turned_bar, ways, webs


def slot(angle):
    return Slot(0, "+z", 0.0, 5.0, angle, 1.0, 0.12)


@pytest.mark.parametrize(
    ("angles", "least"),
    [((45.0, 45.0), 0.7), ((45.0, -45.0), 0.7), ((30.0, 80.0), 0.3), ((90.0,), 0.7)],
)
def test_one_slide_pushes_every_leg_onto_a_face_and_an_end(angles, least):
    slots = [slot(angle) for angle in angles]
    push = np.array(push_of(slots))
    assert np.hypot(*push) == pytest.approx(1.0)
    across, along = ways(slots)
    assert min((across @ push).min(), (along @ push).min()) >= least
    assert (np.column_stack([across[:, 1], along[:, 1]]) >= -1e-9).all()  # toward the surface


def test_no_slide_pushes_legs_that_stand_across_each_other_in_every_way():
    assert push_of([slot(angle) for angle in (5.0, 60.0, 120.0, 175.0)]) is None


def test_outer_combs_reach_around_slots_and_bolts_which_clamp_them_too():
    """Its bolts of 3.4 mm pass them with 0.15 mm of room and a millimetre of strip."""
    plan = plan_mold(load_design("maeno2000"))
    bolt, outer = plan.bolts[0], plan.by_side["+z"].outer
    assert outer.half == pytest.approx(abs(bolt.first) + 1.7 + 0.15 + 1.0)
    assert outer.low == pytest.approx(bolt.second - 1.7 - 0.15 - 1.0)
    assert outer.high == pytest.approx(slot_corners(outer.slots)[..., 1].max() + 1.0)
    assert (bolt.low, bolt.high) == pytest.approx((-plan.reach_z - 0.3, plan.reach_z + 0.3))
    assert spacer_height(plan) == pytest.approx(0.3 + 3.0)  # the outer sheet, and the tabs


@pytest.mark.parametrize("name", ["maeno2000", "domed", "tees"])
def test_legs_stand_between_a_face_of_each_comb(name):
    plan = plan_mold(load_design(name))
    frames = {frame.index: frame for frame in plan.frames}
    pushed = [side for side in plan.sides if side.outer]
    assert [side.side for side in pushed] == ["+z", "-z"]
    for side in pushed:
        legs = [leg for leg in plan.legs if leg.side == side.side]
        inner, outer = ways(side.slots), ways(side.outer.slots)
        for k, leg in enumerate(legs):
            bar = turned_bar(frames[leg.plate], leg.width, leg.offset)
            sizes = (bar.thickness, bar.length)
            for slots, found, sign in ((side.slots, inner, 1), (side.outer.slots, outer, -1)):
                each, centre = slots[k], np.array([slots[k].place, slots[k].y])
                for way, size, wide in zip(
                    (found[0][k], found[1][k]), sizes, (each.width, each.length), strict=True
                ):
                    behind = (bar.centre - centre) @ way + sign * 0.5 * size
                    assert behind == pytest.approx(sign * 0.5 * wide, abs=1e-9)
            longest = max(plan.reach_z + side.sheet + 3.0, plan.tips[side.side])  # with traces
            assert leg.tip == pytest.approx(longest)
            # Over sixty times its thickness, outside the finger.
            assert plan.reach(side.side) + side.sheet - leg.exit > 60 * bar.thickness
        assert webs(side.outer.slots)[2].min() >= 0.2 - 1e-9
        assert direction(side.side)[2] != 0.0


def test_the_clearance_of_pushed_legs_counts_no_more_and_the_width_of_a_leg_does():
    def off(**mold):
        design = with_values(load_design("maeno2000"), {f"mold.{k}": v for k, v in mold.items()})
        plan = plan_mold(design)
        return (*tolerances(plan, 7), *row_tolerances(plan))

    wide, narrow = off(), off(leg_mm=0.45)
    place, angle, along, height = wide
    assert 0.01 < place < 0.02
    assert np.tan(np.radians(angle)) == pytest.approx(0.01 / 0.9)
    assert np.tan(np.radians(narrow[1])) == pytest.approx(0.01 / 0.45)
    assert off(**{"comb.clearance_mm": 0.04})[:2] == pytest.approx(wide[:2])
    assert (along, height) == pytest.approx((0.01, 0.06))
    assert off(process="machined")[2:] == pytest.approx((0.005, 0.015))
    assert off(pour="closed")[2:] == pytest.approx((0.2, 0.2))  # by pins alone
    assert off(pour="closed")[1] > 2.5 * angle


def test_the_bow_is_that_of_an_elastic_bar():
    design = load_design("maeno2000")
    plan = plan_mold(design)
    side = plan.by_side["+z"]
    long, beyond, pushed = 10.0, 6.0, 0.02
    # Two elements of a bar's half: its middle (no slope), the inner comb (held), the outer one.
    stiffness = np.zeros((6, 6))
    for first, h in ((0, 0.5 * long), (2, beyond)):
        own = np.array(
            [
                [12.0, 6 * h, -12.0, 6 * h],
                [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                [-12.0, -6 * h, 12.0, -6 * h],
                [6 * h, 2 * h * h, -6 * h, 4 * h * h],
            ]
        )
        stiffness[first : first + 4, first : first + 4] += own / h**3
    free, given = [0, 3, 5], [1, 2, 4]
    known = np.array([0.0, 0.0, pushed])
    found = np.linalg.solve(stiffness[np.ix_(free, free)], -stiffness[np.ix_(free, given)] @ known)
    assert bow(plan, side) == pytest.approx(abs(found[0]), rel=1e-9)
