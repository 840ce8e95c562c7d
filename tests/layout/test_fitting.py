"""Which gages that are sold fit a design's plates, and sheet of which thickness is sold."""

import pytest

from fingerdesign.checks.foil import gage_keys
from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.design.schema import Design
from fingerdesign.design.stock import shipped_types
from fingerdesign.errors import DesignError
from fingerdesign.layout.fitting import (
    gage_fit,
    gage_stiffness,
    gage_words,
    sheet_words,
    stiffness_words,
)
from fingerdesign.layout.summary import summarise

BASE = """
design.name = "gages"
[plates]
count = 3
length_mm = 0.9
pitch_mm = 4.0
cover_mm = 3.0
span_mm = 9.0
[gages]
length_mm = 0.5
width_mm = 1.0
"""
LARGE = {"plates.length_mm": 3.0, "plates.angle_deg": 20.0}


@pytest.fixture(scope="module")
def small():
    return parse_design(BASE)


def test_plates_shorter_than_any_carrier_take_no_gage(small):
    fit = gage_fit(small)
    assert fit.found is None
    assert fit.length == min(each.carrier_length_mm for each in shipped_types() if _foil(each))
    assert "plates.length_mm = 3" in gage_words(small, fit)


def _foil(each):
    return each.kind == "foil"


def test_the_nearest_plate_takes_the_gage(small):
    """What the words ask for mends it; they say beforehand how stiff the gage makes the plate."""
    thin = with_values(small, {"plates.material": "polyimide", "plates.thickness_mm": 0.125})
    fit = gage_fit(thin)
    grown = with_values(thin, LARGE | {"plates.length_mm": fit.length})
    assert gage_fit(grown).found.name == fit.nearest.name
    stiffened = f"stiffens it by up to {gage_stiffness(grown, gage_fit(grown)):.0%}"
    assert stiffened in gage_words(thin, fit)
    assert "stiffens" not in gage_words(small, gage_fit(small))  # Bronze.


def test_a_grid_unlike_the_designs_is_named(small):
    grown = with_values(small, LARGE)
    assert gage_fit(grown).differs_from(grown)
    assert "gages.width_mm = 2" in gage_words(grown, gage_fit(grown))
    alike = with_values(grown, {"gages.length_mm": 0.3, "gages.width_mm": 2.0})
    assert gage_words(alike, gage_fit(alike)) is None


def test_film_is_made_to_measure(small):
    film = with_values(small, {"mold.gage": "sputtered_film"})
    assert gage_fit(film).found.name == "sputtered_film"
    assert gage_words(film, gage_fit(film)) is None
    assert "sputtered_film" in gage_fit(small).films


def test_ones_own_gage_comes_first(small):
    mine = parse_design(
        BASE + '[[mold.gage_types]]\nname = "mine"\ngrid_length_mm = 0.5\ngrid_width_mm = 1.0\n'
        "carrier_length_mm = 0.9\ncarrier_width_mm = 3.0\n"
    )
    assert gage_fit(mine).found.name == "mine"
    assert gage_words(mine, gage_fit(mine)) is None


def test_tees_take_the_place_of_tees(small):
    tees = with_values(small, {"gages.grid": "tee"})
    assert gage_fit(tees).nearest.kind == "tee"
    assert gage_fit(tees).width == gage_fit(tees).room[1]


def test_a_gage_off_the_middle_and_holes_take_room(small):
    off = with_values(small, {"gages.z_mm": 3.0})
    assert gage_fit(off).room[1] == pytest.approx(gage_fit(small).room[1] - 6.0)


@pytest.mark.parametrize("own", [{"plates.cover_mm": 1}, {"plates.span_mm": 3, "gages.z_mm": -0.5}])
def test_the_keys_that_take_a_gage_are_tried(small, own):
    design = with_values(small, own)
    fit = gage_fit(design)
    keys = gage_keys(design, fit)
    found = gage_fit(with_values(design, keys)).found
    assert found == fit.nearest
    assert keys["gages.length_mm"] == found.grid_length_mm
    assert keys["gages.width_mm"] == found.grid_width_mm
    assert keys.get("plates.span_mm", 9.0) >= found.carrier_width_mm + 2.0 * abs(design.gages.z_mm)


def test_unknown_gages_are_refused():
    with pytest.raises(DesignError, match=r"mold\.gage"):
        parse_design(BASE + '[mold]\ngage = "foil_17"\n')


def test_a_kind_that_does_not_fit_names_the_nearest_that_does(small):
    long = with_values(small, {"gages.kind": "silicon_bar_15"})
    fit = gage_fit(long)
    assert fit.found is None
    assert "silicon_bar_15 does not fit" in gage_words(long, fit)
    assert "gages.kind = 'silicon_bar_05'" in gage_words(long, fit)
    short = with_values(
        small, {"gages.kind": "silicon_bar_05", "gages.length_mm": 0.25, "gages.width_mm": 0.15}
    )
    assert gage_words(short, gage_fit(short)) is None
    tee = with_values(short, {"gages.grid": "tee", "plates.span_mm": 0.5})
    assert gage_fit(tee).found is None  # Two bars lie side by side: 0.65 mm.


def test_holes_stand_apart_for_a_gage_or_go(small):
    """A tee of 4.5 mm between holes of 0.3; a pitch that is named makes a sound design."""
    own = {"plates.hole_diameter_mm": 0.3, "gages.grid": "tee"}
    for span, named in ((8.0, "plates.hole_pitch_mm = 4.8"), (5.0, "no holes")):
        holed = with_values(small, own | {"plates.span_mm": span})
        words = gage_words(holed, gage_fit(holed))
        assert named in words
        assert "plates.span_mm" not in words
    with_values(small, own | {"plates.span_mm": 8.0, "plates.hole_pitch_mm": 4.8})


def test_gages_stiffen_their_plates(small):
    """Silicon of 0.015 mm on both faces of bronze of 0.1 mm; foil hardly counts there."""
    bars = with_values(small, {"gages.kind": "silicon_bar_05", "gages.face": "both"})
    assert gage_stiffness(bars, gage_fit(bars)) == pytest.approx(2 * 170e3 * 0.015 / 13.5e3)
    one = with_values(bars, {"gages.face": "upper"})
    assert gage_stiffness(one, gage_fit(one)) == pytest.approx(170e3 * 0.015 / 13.5e3)
    words = stiffness_words(bars, gage_fit(bars))
    assert "silicon_bar_05 makes a plate up to 38% stiffer" in words
    assert "too high; 3-D has it" in words
    own = with_values(small, {"mold.gage": "silicon_bar_05", "gages.face": "both"})
    assert "3-D with gages.kind = 'silicon_bar_05' has it" in stiffness_words(own, gage_fit(bars))
    film = with_values(small, {"mold.gage": "sputtered_film"})
    assert stiffness_words(film, gage_fit(film)) is None
    both = with_values(film, {"gages.kind": "silicon_bar_05"})
    assert "'sputtered_film' is cast" in stiffness_words(both, gage_fit(both))


def test_unknown_kinds_are_refused():
    with pytest.raises(DesignError, match=r"gages\.kind"):
        parse_design(BASE.replace("[gages]", '[gages]\nkind = "foil_17"'))


def test_sheet_that_is_not_sold_is_named_with_the_nearest(small):
    assert not sheet_words(small)
    odd = with_values(small, {"plates.thickness_mm": 0.12, "mold.comb.sheet_mm": 0.27})
    words = sheet_words(odd)
    assert len(words) == 2
    assert "0.1 mm" in words[0]
    assert "0.25 mm" in words[1]
    film = with_values(odd, {"mold.sheets_mm": [0.12, 0.27]})
    assert not sheet_words(film)


def test_a_finger_without_plates_needs_no_gages(small):
    bare = with_values(small, {"plates.count": 0})
    assert gage_fit(bare) is None
    assert gage_words(bare, None) is None
    assert not sheet_words(bare)


def test_a_summary_has_the_least_distances_of_the_plates_own_points():
    """Three plates of 2 x 10 x 0.1 mm, 5 mm apart, in a block of 20 x 12 x 10 mm."""
    body = {"shape": "block", "width_mm": 20.0, "base_height_mm": 12.0, "depth_mm": 10.0}
    plates = {"count": 3, "angle_deg": 0.0, "pitch_mm": 5.0, "cover_mm": 2.0}
    found = summarise(
        Design.model_validate({"design": {"name": "b"}, "body": body, "plates": plates})
    )
    assert (found.plates, found.rows, found.approach_mm) == (3, ("3 along x",), 0.1)
    assert found.least_surface_mm == pytest.approx(2.0 - 0.05)
    assert found.least_gap_mm == pytest.approx(5.0 - 2.0)
    assert found.least_side_mm == pytest.approx(10.0 - 6.0)
    assert found.least_base_mm == pytest.approx(12.0 - 2.0 - 0.05)
    assert found.volume_mm3 == pytest.approx(2400.0)
    assert found.plates_volume_mm3 == pytest.approx(3 * 2.0 * 0.1 * 10.0)
    assert (found.contact_half_width_mm, found.extruded) == (10.0, True)
    more = plates | {"stagger_mm": 1.0, "span_mm": 6.0}
    again = summarise(Design(design={"name": "b"}, body=body | {"core": {}}, plates=more))
    assert (again.body, *again.rows) == ("block, core", "3 along x, staggered, finite")
