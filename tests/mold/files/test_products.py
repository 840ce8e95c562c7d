"""What is cut and printed: patterns of plates, outlines of sheets, DXF and 3MF, read back."""

import itertools
import locale
import zipfile
from dataclasses import replace

import ezdxf
import numpy as np
import pytest
from manifold3d import Manifold

from fingerdesign.errors import GeometryError
from fingerdesign.layout.fitting import gage_fit
from fingerdesign.layout.volume import enclosed_volume as volume
from fingerdesign.layout.volume import outline_volume
from fingerdesign.mold.plan.patterns import flat_patterns
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.products.casting import casting_of
from fingerdesign.mold.products.drawing import (
    Sheet,
    comb_sheet,
    polygon_area,
    write_drawings,
    write_dxf,
)
from fingerdesign.mold.products.three_mf import flat_faces, laid_out, write_3mf
from tests.support.molds import BOX, CORNERS, box, meshed, read_3mf, shipped

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def patterns_of(design):
    plan = plan_mold(design)
    return plan, flat_patterns(plan)


def test_like_plates_are_cut_alike_with_their_gages():
    design = shipped("maeno2000", gages__z_mm=0.5, gages__face="upper")
    plan, (only,) = patterns_of(design)
    assert (only.name, only.count, only.plates) == ("plate_A", 15, tuple(range(15)))
    assert (only.bend_radius, only.seen) == (None, "lower")
    assert np.ptp(only.outline, axis=0) == pytest.approx([0.9, 10.0 + 2 * 3.3])
    assert polygon_area(only.outline) == pytest.approx(0.9 * (10.0 + 2 * 3.3))
    assert plan.legs_volume == 0.0
    assert only.faces == ("upper",)
    assert only.gage.mean(axis=0) == pytest.approx([0.0, 0.5])
    assert np.ptp(only.gage, axis=0) == pytest.approx([0.5, 1.0])


def test_plates_that_differ_in_a_leg_or_their_thickness_are_cut_apart():
    plan = plan_mold(shipped("maeno2000"))
    leg, *legs = plan.legs
    longer = replace(plan, legs=(replace(leg, tip=leg.tip + 0.5), *legs))
    frame, *frames = plan.frames
    thicker = replace(plan, frames=(replace(frame, thickness=0.2), *frames))
    for changed in (longer, thicker):
        found = flat_patterns(changed)
        assert [each.plates for each in found] == [(0,), tuple(range(1, 15))]
        assert [each.name for each in found] == ["plate_A", "plate_B"]
    one, other = (np.ptp(each.outline, axis=0)[1] for each in flat_patterns(longer))
    assert one - other == pytest.approx(0.5)


def test_bent_perforated_plates_keep_their_holes_and_their_bend():
    plan, found = patterns_of(shipped("boned"))
    assert sorted(plate for each in found for plate in each.plates) == [0, 1, 2, 3, 4]
    for pattern in found:
        frame = plan.frames[pattern.plates[0]]
        assert pattern.bend_radius == frame.bend_radius
        assert pattern.material == "spring_steel"
        assert [w for _, w, _ in pattern.holes] == pytest.approx([-1.0, 1.0])
        legs = plan.legs_by_plate.get(frame.index, ())
        area = frame.length * 6.0 + sum(leg.width * (leg.tip - leg.start) for leg in legs)
        x, y = pattern.outline.T
        assert 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)) == pytest.approx(area)
        assert pattern.faces == ("upper", "lower")


def test_plates_along_z_are_another_kind_and_legs_displace_little_rubber():
    _, found = patterns_of(shipped("both_ways"))
    assert {pattern.seen for pattern in found} == {"lower", "upper"}
    assert len({pattern.name for pattern in found}) == len(found)
    design = shipped("domed")
    plan = plan_mold(design)
    assert plan.legs_volume == pytest.approx(26 * 1.0 * 0.1 * 3.0)
    assert 1e-4 < plan.legs_share < 1e-2
    shrunk = plan_mold(shipped("domed", mold__shrinkage=0.1))  # the outline is larger, metal not
    outline = outline_volume(design.body) / 0.9**3
    assert shrunk.legs_share == pytest.approx(shrunk.legs_volume / outline)


def comb(axis="z", exact=72.0 * 0.3, hole=None):
    """A sheet 10 x 8 with one opening 4 x 2, or another, from z = 5 to 5.3."""
    slot = Manifold.cube((4.0, 2.0, 1.0)).translate((3.0, 3.0, -0.5))
    cut = Manifold.cube((10.0, 8.0, 0.3)) - (slot if hole is None else hole)
    solid = cut.translate((0.0, 0.0, 5.0)).to_mesh64()
    points, triangles = np.array(solid.vert_properties), np.array(solid.tri_verts, dtype=np.int64)
    if axis == "x":
        points, triangles = points[:, [2, 1, 0]], triangles[:, ::-1]
    return meshed("comb_front", points, triangles, (0, 0, 1), 1, "sheet", exact)


@pytest.mark.parametrize(("axis", "side"), [("z", "+z"), ("z", "-z"), ("x", "+x"), ("x", "-x")])
def test_outline_and_opening_of_a_sheet(axis, side):
    found = comb_sheet(comb(axis), side)
    assert len(found.outline) == 4
    assert polygon_area(found.outline) == pytest.approx(80.0)
    assert [polygon_area(each) for each in found.openings] == pytest.approx([8.0])
    assert found.circles == ()


def test_a_tapered_hole_is_drawn_as_it_is_in_the_outer_face():
    cone = Manifold.cylinder(0.3, 1.0, 1.02, 48).translate((5.0, 4.0, 0.0))
    sheet = comb(exact=80.0 * 0.3 - cone.volume(), hole=cone)
    for side, radius in (("+z", 1.02), ("-z", 1.0)):
        assert comb_sheet(replace(sheet, chord=0.02), side).circles == ((5.0, 4.0, radius),)


def test_outlines_that_are_not_the_solid_or_of_no_solid_are_refused():
    with pytest.raises(GeometryError, match="comb_front: its outline times its thickness"):
        comb_sheet(comb(exact=20.0), "+z")
    with pytest.raises(GeometryError, match="comb_front has no flat face"):
        comb_sheet(replace(comb(), triangles=comb().triangles[1:]), "+z")


SHEETS = (
    Sheet(
        "plate_A",
        SQUARE * [2.0, 10.0],
        circles=((1.0, 2.0, 0.3),),
        gage=SQUARE + np.array([0.5, 4.5]),
        bends=(np.array([[0.0, 5.0], [2.0, 5.0]]),),
        text=("plate_A: 15 of 0.1 mm phosphor bronze",),
    ),
    Sheet("comb_front", SQUARE * 8.0, openings=(SQUARE + np.array([2.0, 2.0]),)),
)


def test_drawn_in_millimetres_on_its_layers_pieces_apart(tmp_path):
    path = tmp_path / "plates.dxf"
    write_dxf(SHEETS, path)
    document = ezdxf.filemanagement.readfile(path)
    assert document.header["$INSUNITS"] == 4
    kinds = sorted((each.dxf.layer, each.dxftype()) for each in document.modelspace())
    assert kinds == [
        *(("BEND", "LINE"), ("CUT", "LWPOLYLINE"), ("CUT", "LWPOLYLINE"), ("GAGES", "LWPOLYLINE")),
        *(("HOLES", "CIRCLE"), ("HOLES", "LWPOLYLINE"), ("TEXT", "TEXT")),
    ]
    lines = document.modelspace().query('LWPOLYLINE[layer=="CUT"]')
    assert not document.audit().has_errors
    assert all(line.closed for line in document.modelspace().query("LWPOLYLINE"))
    assert [polygon_area(np.array(each.get_points("xy"))) for each in lines] == [20.0, 64.0]
    spans = [[y for _, y in line.get_points("xy")] for line in lines]
    assert min(spans[1]) - max(spans[0]) > 4.99  # in the next row


def printed(name, size, draw=(0.0, 1.0, 0.0)):
    return box(name, (3.0, 4.0, 5.0), np.add(size, [3.0, 4.0, 5.0]), draw, 0)


@pytest.mark.parametrize("draw", [None, (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)])
def test_the_largest_face_lies_on_the_bed(draw):
    """Of two alike, the one away from the finger."""
    size = (2.0, 7.0, 5.0)
    (posed,) = laid_out((printed("wall", size, draw),))
    assert posed.flat_area == pytest.approx(35.0)
    assert posed.size == pytest.approx((7.0, 5.0, 2.0))
    assert posed.vertices.min(axis=0) == pytest.approx(0.0)
    assert draw is None or posed.down == pytest.approx(draw)


def test_turning_keeps_the_part_from_being_mirrored():
    wedge = CORNERS * [2.0, 7.0, 5.0]
    wedge[6] += [0.0, 3.0, 1.0]
    for draw in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, -1.0), None):
        (posed,) = laid_out((meshed("wedge", wedge, BOX, draw),))
        assert volume(posed.vertices, BOX) == pytest.approx(volume(wedge, BOX), rel=1e-12)


def test_a_face_that_something_stands_out_of_is_none_to_lie_on():
    bumped = CORNERS * [10.0, 10.0, 1.0]
    bumped[6, 2] = 2.0  # the face z = 1 is no longer flat
    normals = [tuple(np.round(n, 3)) for _, n in flat_faces(meshed("b", bumped, BOX))]
    assert (0.0, 0.0, -1.0) in normals
    assert (0.0, 0.0, 1.0) not in normals


PARTS = (printed("base_plate", (30.0, 4.0, 20.0)), printed("contact_insert", (30, 9, 20)))


def test_written_and_read_back_in_millimetres(tmp_path):
    before, posed, path = locale.setlocale(locale.LC_ALL), laid_out(PARTS), tmp_path / "mold.3mf"
    write_3mf(posed, path, "a finger's mold")
    held = read_3mf(path)
    assert list(held) == [each.name for each in posed]
    assert held["base_plate"] == (8, 12, pytest.approx(2400.0, rel=1e-5))
    assert held["contact_insert"] == (8, 12, pytest.approx(5400.0, rel=1e-5))
    with zipfile.ZipFile(path) as archive:
        text = archive.read("3D/3dmodel.model").decode()
    assert 'unit="millimeter"' in text
    assert "a finger's mold" in text or "a finger&apos;s mold" in text
    assert locale.setlocale(locale.LC_ALL) == before  # the library sets it to C


def test_a_file_that_was_cut_short_is_refused(tmp_path, monkeypatch):
    class Cut(zipfile.ZipFile):
        def __init__(self, path):
            path.write_bytes(path.read_bytes()[:-30])
            super().__init__(path)

    monkeypatch.setattr(zipfile, "ZipFile", Cut)
    with pytest.raises(GeometryError, match="is the disk full"):
        write_3mf(laid_out(PARTS), tmp_path / "mold.3mf", "x")


def test_a_nested_drawing_has_each_plate_as_often_as_it_is_cut_and_none_on_another(
    hand_made, tmp_path
):
    design, plan, meshes = hand_made()
    write_drawings(casting_of(plan, meshes, gage_fit(design)), tmp_path)
    drawn = ezdxf.filemanagement.readfile(tmp_path / "nested_phosphor_bronze_0.1mm.dxf")
    outlines = drawn.modelspace().query('LWPOLYLINE[layer=="CUT"]')
    boxes = [np.array(each.get_points("xy")) for each in outlines]
    assert len(boxes) == 3 + 2  # two more for the coupon's cell
    for one, other in itertools.combinations(boxes, 2):
        apart = np.maximum(one.min(axis=0) - other.max(axis=0), other.min(axis=0) - one.max(axis=0))
        assert apart.max() >= 5.0
    combs = ezdxf.filemanagement.readfile(tmp_path / "nested_combs_0.3mm.dxf")
    names = {each.dxf.text for each in combs.modelspace().query("TEXT")}
    assert names == {"comb_front", "comb_back"}
