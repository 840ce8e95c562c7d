"""The test coupon: its rows are the profile's, its cell holds the finger's own plates."""

import cadquery as cq
import pytest

from fingerdesign.design.mold import Mold
from fingerdesign.mold.cad.coupon import build_coupon, ladder_bar
from fingerdesign.mold.cad.features import cut_plates
from fingerdesign.mold.plan.limits import limits_of
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.profile import cell_plates, ladders_of, profile_text
from tests.support.molds import shipped


@pytest.mark.parametrize("process", ["sla", "fdm", "machined"])
def test_each_row_has_its_key_in_the_middle_and_is_named_in_the_profile(process):
    limits = limits_of(Mold(process=process))
    rows = ladders_of(limits_of(Mold(process=process)))
    for row in rows:
        assert row.sizes[2] == getattr(limits, row.key)
        assert list(row.sizes) == sorted(set(row.sizes))
    kinds = [row.kind for row in rows]
    assert ("pin" in kinds) == (process != "machined")  # dowels are bought
    text = profile_text(shipped("maeno2000", mold__process=process))
    for row in rows:
        assert f"coupon, {row.kind}s of {row.sizes[0]:g}, " in text


@pytest.mark.parametrize("process", ["sla", "fdm", "machined"])
def test_the_bar_has_what_its_rows_say(process):
    rows = ladders_of(limits_of(Mold(process=process)))
    pin = limits_of(Mold(process=process)).pin_mm
    bar = ladder_bar(rows, pin)
    assert bar.isValid()
    found = [(face.geomType(), face.BoundingBox()) for face in bar.Faces()]
    diameters = sorted(round(b.xlen, 6) for kind, b in found if kind == "CYLINDER")
    expected = [pin + 2.0 * size for row in rows if row.kind == "socket" for size in row.sizes]
    expected += [size for row in rows if row.kind in ("hole", "pin") for size in row.sizes]
    assert diameters == pytest.approx(sorted(expected))
    walls = next(row for row in rows if row.kind == "wall")
    tops = [b for kind, b in found if kind == "PLANE" and b.zmin == pytest.approx(10.0)]
    widths = {round(b.xlen, 4) for b in tops}
    assert {round(size, 4) for size in walls.sizes} <= widths


def test_the_cell_has_the_two_in_the_middle_of_a_row_or_its_only_plate():
    found = cell_plates(plan_mold(shipped("maeno2000")))
    assert [frame.index for frame in found] == [7, 8]  # of 15
    (one,) = cell_plates(plan_mold(shipped("maeno2000", plates__count=1)))
    assert one.index == 0
    assert cell_plates(plan_mold(shipped("maeno2000", plates__count=0))) == ()


@pytest.mark.parametrize("name", ["maeno2000", "both_ways", "pin"])
def test_the_cell_holds_two_plates_of_the_finger_as_the_mold_does(name):
    design = shipped(name)
    plan = plan_mold(design)
    plates = cell_plates(plan)
    assert len(plates) == 2
    assert plates[0].along == plates[1].along
    pieces = {piece.name: piece for piece in build_coupon(plan)}
    solids = dict(zip((frame.index for frame in plan.frames), cut_plates(plan), strict=True))
    for frame in plates:
        for piece in pieces.values():
            if piece.name in ("coupon", "coupon_pin"):
                continue
            assert common(solids[frame.index], piece.solid) < 1e-9
            if piece.made == "sheet":
                off = solids[frame.index].moved(cq.Location(cq.Vector(0.0, 0.5, 0.0)))
                assert common(off, piece.solid) > 1e-3  # it passes in its place alone
    combs = [piece for piece in pieces.values() if piece.made == "sheet"]
    for comb in combs:
        assert common(comb.solid, pieces["coupon_cell"].solid) < 1e-9  # it slides into its groove
    assert len(combs) == sum(1 for side in plan.sides if side.holding == "comb")


def common(one, other):
    return one.intersect(other).Volume()
