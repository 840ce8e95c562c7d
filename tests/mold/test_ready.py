"""Ready as a sensor: each reason with its fix lines, and none where all holds."""

import re
import tomllib

import numpy as np
import pytest

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.leads import Leads
from fingerdesign.layout.fitting import gage_fit
from fingerdesign.layout.leads import bundle, leads_as_cast, leads_width, thin_bundle
from fingerdesign.mold.leads import MOST, leads_effect
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.ready import MOST_ERROR, not_offered, placement_with_fixes, sensor_of
from tests.support.molds import shipped

PLACED = {"reason": None, "together": {"worst": 0.05}, "row": {"together": {"worst": 0.05}}}
LED = {"reason": None, "words": "6 wires", "reading_error": 0.01, "sentences": [""], "fixes": []}
FAR = {**PLACED, "together": {"worst": 2.0 * MOST_ERROR}, "fixes": []}
FINER = {**FAR, "fixes": [{"lines": ['mold.process = "machined"'], "reading_error": 0.1}]}
STIFF = {**LED, "reading_error": 2.0 * MOST, "fixes": [{"lines": ["mold.wire_mm = 0.1"]}]}
TRACES = ('gages.leads.kind = "traces"', 'gages.leads.course = "leg"')
UNKNOWN = {"reason": "no mesh", "sentences": ["The leads are not known."]}


@pytest.mark.parametrize(
    ("keys", "placement", "leads", "words", "fix"),
    [
        ({}, PLACED, LED, [], []),
        # No line sets what the design has already.
        ({"mold.gage": "auto"}, PLACED, LED, ["no tee"], ["mold.gage = "]),
        (
            {"mold.gage": "auto", "mold.leads": "wires"},
            *(PLACED, LED, ["no tee"], ["mold.gage = ", "mold.leads = "]),
        ),
        ({"mold.leads": "wires"}, PLACED, LED, ["wires cannot"], ['mold.leads = "leg"']),
        ({}, FINER, LED, ["plates off"], ['mold.process = "machined"']),
        ({}, FAR, LED, ["no finer process or comb does"], []),
        # Lines that end one reason of two would not make it ready.
        ({"mold.leads": "wires"}, FAR, LED, ["no finer", "wires cannot"], []),
        ({}, PLACED, STIFF, ["6 wires change"], ["mold.wire_mm = 0.1"]),
        ({}, PLACED, UNKNOWN, ["not known"], []),
        ({"plates.count": 0}, PLACED, LED, ["no plates"], ["plates.count = "]),
        # Leads that the model has and the mold does not make; gages that are not those cast.
        ({"gages.leads.kind": "none"}, PLACED, LED, ["other leads"], [*TRACES]),
        ({"gages.leads.kind": "wire"}, PLACED, LED, ["other leads"], [*TRACES]),
        (
            {"gages.leads.kind": "traces", "gages.leads.course": "leg", "gages.leads.number": 0},
            *(PLACED, LED, ["other leads"], ["gages.leads.number = 6"]),
        ),
        (
            {"gages.leads.kind": "wire", "mold.leads": "wires"},
            *(PLACED, LED, ["wires cannot"], ['mold.leads = "leg"', *TRACES]),
        ),
        (
            {"gages.kind": "printed_film"},
            *(PLACED, LED, ["is cast"], ['gages.kind = "sputtered_film"']),
        ),
    ],
)
def test_each_reason_names_the_lines_that_mend_it(keys, placement, leads, words, fix):
    design = with_values(shipped("film_tees"), keys)
    found = sensor_of(design, gage_fit(design), placement, leads)
    assert found["ready"] is (not words)
    for some, expected in ((found["reasons"], words), (found["fix"], fix)):
        assert len(some) == len(expected)
        assert all(each in got for each, got in zip(expected, some, strict=True))


def test_the_verdict_has_the_worst_numbers_and_takes_those_at_their_bounds():
    """Plates among each other and the whole row count by the root of their squares."""
    design = shipped("film_tees")
    fit, row = gage_fit(design), {"together": {"worst": 0.8 * MOST_ERROR}}
    placed, led = {**PLACED, "together": {"worst": 0.6 * MOST_ERROR}, "row": row}, {**LED}
    led["reading_error"] = MOST
    found = sensor_of(design, fit, placed, led)
    assert found["ready"] is True
    assert (found["reading_error"], found["lead_error"]) == (pytest.approx(MOST_ERROR), MOST)
    assert (found["gage"], found["to_measure"]) == ("sputtered_film", True)
    worse = sensor_of(design, fit, {**placed, "together": {"worst": 0.61 * MOST_ERROR}}, led)
    assert len(worse["reasons"]) == 1
    unknown = sensor_of(design, fit, UNKNOWN, UNKNOWN)
    assert (unknown["reading_error"], unknown["lead_error"]) == (None, None)


def test_leads_are_as_stiff_as_their_metal_and_over_a_plate_that_is_pulled_along_z():
    """Six wires of 0.08 mm copper; polyimide of 0.075 mm, 0.53 mm long."""
    wires = {"mold.leads": "wires", "gages.leads.kind": "wire", "gages.leads.diameter_mm": 0.08}
    design = with_values(shipped("film_tees"), wires)
    found = leads_effect(design, None)
    stiffness = 6 * 120e3 * np.pi * 0.08**2 / 4
    assert (found["number"], found["kind"], found["course"]) == (6, "wire", "z")
    assert found["stiffness_N"] == pytest.approx(stiffness)
    modulus = design.material_of("plates").youngs_modulus_MPa
    plate = modulus * design.plates.thickness_mm * design.plates.length_mm
    assert found["over_plate"] == pytest.approx(stiffness / plate)
    assert "no gage fits" in found["reason"]
    assert leads_effect(with_values(design, {"plates.count": 0}), None)["over_plate"] == 0.0


def test_a_type_without_source_price_and_weeks_is_not_offered():
    design = shipped("film_tees")
    own = gage_fit(design).found.model_dump() | {"name": "mine", "price": "", "lead_weeks": 0.0}
    mine = with_values(design, {"mold.gage": "mine", "mold.gage_types": [own]})
    (reason,) = sensor_of(mine, gage_fit(mine), PLACED, LED)["reasons"]
    assert "neither sold nor quoted: no price, no lead_weeks" in reason


def test_bundles_are_as_wide_as_circles_around_their_wires():
    """Around n wires in a ring 1 + 1 / sin(pi / n), which a seventh fills."""
    for count in (2, 3, 4, 5, 6):
        ring = 1.0 + 1.0 / np.sin(np.pi / count)
        assert bundle(count) == pytest.approx(ring, abs=1e-3)
    assert (bundle(1), bundle(7)) == (1.0, 3.0)
    # Six of the thinnest wire of 0.03 mm, 0.0375 mm with enamel: 0.1125 mm, rounded up.
    assert thin_bundle(shipped("film_tees")) == 0.12
    assert leads_width(shipped("film_tees").gages, Leads(diameter_mm=0.1)) == pytest.approx(0.375)


def test_leads_are_those_that_the_mold_wires():
    design = with_values(shipped("film_tees"), {"mold.leads": "wires"})
    wires = leads_as_cast(design, None)
    assert wires.diameter_mm == pytest.approx(0.3 / bundle(6) / 1.25)  # over their enamel
    thin = leads_as_cast(with_values(design, {"mold.wire_mm": thin_bundle(design)}), None)
    assert thin.diameter_mm == pytest.approx(0.03, abs=0.003)
    film = leads_as_cast(shipped("film_tees"), gage_fit(design).found)
    assert (film.kind, film.course, film.thickness_mm) == ("traces", "leg", 0.0002)


@pytest.mark.parametrize(
    "name",
    [
        "maeno2000",
        "narrow",
        "fine_tees",
        "boned",
        pytest.param("both_ways", marks=pytest.mark.slow),
    ],
)
def test_lines_for_a_gage_give_one_that_fits_and_is_sold(name):
    design = shipped(name)
    found = sensor_of(design, gage_fit(design), PLACED, LED)
    values = dict(tomllib.loads(line).popitem() for line in dotted(found["fix"]))
    mended = with_values(design, values)
    assert gage_fit(mended).found is not None
    assert not not_offered(gage_fit(mended).found)


def dotted(lines):
    """Lines of a design whose dotted key is one key of TOML."""
    return [re.sub(r"^([\w.]+)", r'"\1"', line) for line in lines]


@pytest.mark.slow
def test_a_process_that_places_plates_closer_is_a_fix_only_where_it_does():
    """fine_tees: 40 % of the largest reading by prints, 13 % machined; pin: 93 and 58 %."""
    (fix,) = placement_with_fixes(fine := load_design("fine_tees"), plan_mold(fine))["fixes"]
    assert fix["lines"] == ['mold.process = "machined"']
    assert fix["reading_error"] < MOST_ERROR
    assert placement_with_fixes(pin := load_design("pin"), plan_mold(pin))["fixes"] == []


@pytest.mark.slow
def test_wires_price_a_finger_and_traces_do_not():
    """film_tees of five plates: 9.7 % at 0.03 mm, 0.61 % by traces of the film (mesh of 2.8 and 2.0
    alike)."""
    design = with_values(shipped("film_tees"), {"plates.count": 5})
    type_ = gage_fit(design).found
    assert leads_effect(design, type_)["reading_error"] == pytest.approx(0.0061, rel=0.2)
    wired = with_values(design, {"mold.leads": "wires", "mold.wire_mm": 0.11})
    found = leads_effect(wired, type_)
    assert found["reading_error"] > MOST
    assert [each["lines"] for each in found["fixes"]] == [['mold.leads = "leg"']]
    bare = with_values(design, {"plates.count": 0})
    assert "no plates" in leads_effect(bare, type_)["reason"]
