"""Numbers of a mold's record and of the tables of its page, against their definitions."""

import re
from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.checks.load import load_design
from fingerdesign.layout.fitting import gage_fit
from fingerdesign.mold.page import plan_svg
from fingerdesign.mold.part import Check
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.products.casting import casting_of
from fingerdesign.mold.record import Outcome, failure_of, mold_record
from fingerdesign.mold.tables import (
    effects_table,
    fixture_table,
    holes_table,
    hours_table,
    kinds_of,
    parts_table,
    patterns_table,
    plates_table,
)
from tests.support.molds import shipped

FILES = ["comb_front.dxf", "comb_front.stl", "plate_A.dxf", "comb_back.step", "core.step"]


def recorded(design, plan, meshes, *checks):
    casting = casting_of(plan, meshes, gage_fit(design))
    return mold_record(Outcome(plan, casting.fit, checks, casting), FILES, {}, 1.0)


@pytest.fixture(scope="module")
def record(hand_made):
    return recorded(*hand_made())


def test_a_part_is_recorded_and_shown_with_its_own_size_volume_and_files(record):
    """The front comb is a box of 20 x 12 x 0.3 mm, taken off third and along +z."""
    (part,) = (part for part in record["parts"] if part["name"] == "comb_front")
    assert (part["size_mm"], part["volume_mm3"]) == (pytest.approx([20.0, 12.0, 0.3]), 72.0)
    assert part["files"] == FILES[:2]
    shown = {row[1]: row for row in parts_table(record).rows}
    cells = ("4", "comb front", "cut sheet", "+z", "2", "20.0 x 12.0 x 0.3", "0.07")
    assert shown["comb front"] == (*cells, "comb_front.dxf, comb_front.stl")
    assert shown["base plate"][3:5] == ("stays on the finger", "–")


def test_plates_are_recorded_as_cut_and_in_their_places(record):
    (row,) = patterns_table(record).rows
    # A plate of 2 x 10 mm with a leg of a sheet of 0.3 mm and a tab of 3 mm at each end.
    assert row == ("plate A", "3", "2.000", "16.600", "0.1", "–", "phosphor bronze")
    second = ("1", "A", "0.000", "10.000", "0.000", "x", "0.00", "+z, -z")
    assert plates_table(record).rows[1] == second


@pytest.mark.parametrize(
    ("holding", "sheet", "over", "least"), [("comb", 0.3, 0.3, 0.12), ("slots", None, 9.3, 0.5)]
)
def test_a_side_is_recorded_with_what_holds_its_plates(hand_made, holding, sheet, over, least):
    """Combs hold over their sheet, slots over the wall: both ends' walls are as thick."""
    design, plan, meshes = hand_made(holding)
    record = recorded(design, plan, meshes)
    front, *_ = record["fixture"]
    over = plan.wall_z if holding == "slots" else over
    assert (front["slots"], front["pushed"]) == (3, False)
    assert (front["sheet_mm"], front["held_over_mm"]) == (sheet, pytest.approx(over))
    assert front["narrowest_slot_mm"] == pytest.approx(least)
    cells = ("3", f"{least:.3f}", f"{sheet:.2f}" if sheet else "–", f"{over:.2f}", "1")
    assert fixture_table(record).rows[0][2:] == cells
    assert fixture_table(record).rows[2][2:] == ("–",) * 5


def test_a_leg_in_two_combs_is_held_from_the_finger_to_the_outer_one(hand_made):
    plan = plan_mold(design := load_design("maeno2000"))
    record = recorded(design, plan, hand_made()[2])
    assert record["fixture"][0]["held_over_mm"] == pytest.approx(plan.wall_z + 0.3)
    assert fixture_table(record).rows[0][-1] == "2"


def test_shrinkage_and_scale_are_those_of_the_rubber(hand_made):
    design = shipped("maeno2000", mold__shrinkage=0.02)
    record = recorded(design, plan_mold(design), hand_made()[2])
    assert (record["shrinkage"], record["scale"]) == (0.02, pytest.approx(1.0 / 0.98))


def test_the_base_is_drawn_to_scale_with_z_up_and_its_holes_labelled(record):
    base = record["base"]
    assert (base["half_x_mm"], base["half_z_mm"]) == (12.0, pytest.approx(7.3))
    svg = plan_svg(base)
    high = float(re.search(r'viewBox="0 0 640 (\d+)"', svg)[1])
    scale = (640 - 2 * 46) / 24.0
    circles = re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)" r="([\d.]+)"', svg)
    drawn = (np.array(circles, dtype=float) - [320.0, 0.5 * high, 0.0]) / [scale, -scale, scale]
    holes = [(h["x_mm"], h["z_mm"], 0.5 * h["outer_diameter_mm"]) for h in base["holes"]]
    assert drawn == pytest.approx(np.array(holes), abs=0.03)
    sizes = re.findall(r'<rect x="[\d.]+" y="[\d.]+" width="([\d.]+)" height="([\d.]+)"', svg)
    plate, finger, _ = np.array(sizes, dtype=float) / scale
    assert (*plate, *finger) == pytest.approx((24.0, 14.6, 20.0, 10.0), abs=0.01)
    shown = {row[0]: row[2:] for row in holes_table(base["holes"]).rows}
    assert shown["V2"] == ("-9.25", "-4.38", "1.00", "1.00")
    assert shown["L1"][2:] == ("2.00", "2.60")


def test_hours_add_up_in_their_columns(record):
    assert hours_table(record).rows[-1] == ("all", "–", "5.8", "5.7")


def test_effects_are_shown_in_percent_and_both_kinds_together_by_their_squares():
    def change(rms, worst, plate=2):
        return {"rms": rms, "worst": worst, "worst_plate": plate}

    effect = {
        "changes": [{"name": "turned", "largest": 0.4567, "unit": "degrees", **change(0.01, 0.04)}],
        "together": change(0.03, 0.12, 1),
        "row": {
            "changes": [{"name": "in_height", "largest": 0.2, "unit": "mm", **change(0.02, 0.03)}],
            "together": change(0.04, 0.05, 0),
        },
    }
    assert effects_table(effect).rows == (
        ("against its neighbours turned", "0.457 degrees", "1.00", "4.00", "2"),
        ("against its neighbours, together", "–", "3.00", "12.00", "1"),
        ("the whole row in height", "0.2 mm", "2.00", "3.00", "2"),
        ("all together", "–", "5.00", "13.00", "–"),
    )


def test_of_each_kind_of_check_the_one_nearest_its_bound_is_shown_and_a_failed_one_first():
    def check(name, ok, measured, bound=1.0):
        return {"name": name, "ok": ok, "measured": measured, "bound": bound}

    far, near = check("wall", True, 2.0), check("wall", True, 1.1)
    large = check("wall", True, 103.0, 100.0)  # the share counts, not the distance
    wrong, worse = check("web", False, 0.5), check("web", False, 0.9)
    found = kinds_of([far, large, near, check("web", True, 1.0), wrong, worse])
    assert [(each["checked"], each["failed"]) for each in found] == [(3, 0), (3, 2)]
    assert [each["nearest"] for each in found] == [large, worse]


def test_checks_that_failed_are_counted_and_measures_that_are_not_finite_are_null(hand_made):
    checks = [Check("wall", f"part_{k}", k < 2, 0.5, 1.0, "mm", "") for k in range(10)]
    words = failure_of(tuple(checks))
    assert words.startswith("8 of 10 checks failed: wall (part_2), ")
    assert words.endswith(", wall (part_7) and 2 more")
    found = recorded(*hand_made(), replace(checks[0], measured=np.inf), checks[1])["checks"]
    assert [(each["measured"], each["bound"]) for each in found] == [(None, 1.0), (0.5, 1.0)]
