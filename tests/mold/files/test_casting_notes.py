"""Casting notes, warnings and the bill of materials, from the design and its plan."""

import csv
import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.layout.fitting import gage_fit
from fingerdesign.mold.plan.pieces import Bolt
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.products.bill import bill_of_materials, bolt_length, hardware, write_bill
from fingerdesign.mold.products.casting import casting_of, mixing_of, rubber_words, silicone_of
from fingerdesign.mold.products.hours import hours_of, hours_words
from fingerdesign.mold.products.notes import (
    bridged_gap,
    casting_notes,
    warnings_of,
    windows_volume,
)
from tests.support.molds import shipped

SILENT = {"reason": "no gages", "sentences": ["Not known."]}
CLOSE, OPEN = "Close the mold", "Cure and open"
TITLES = (
    *(
        "Before anything is cut",
        "Try machine and cutter first",
        "Make the parts",
        "Clean, cure, test",
        "Plates and gages",
    ),
    *(CLOSE, "Mix and pour", OPEN, "Finish and measure"),
)


def notes_of(design, plan, meshes):
    sections, _ = casting_notes(casting_of(plan, meshes, gage_fit(design)))
    return {section["title"]: " ".join(section["steps"]) for section in sections}


def test_the_masses_weighed_are_what_is_mixed(hand_made):
    design, plan, meshes = hand_made()
    notes = notes_of(design, plan, meshes)
    assert tuple(notes) == TITLES
    text = notes["Mix and pour"]
    a, b = map(float, re.search(r"Weigh ([\d.]+) g of A and ([\d.]+) g of B", text).groups())
    silicone = silicone_of(plan, meshes)
    assert a + b == pytest.approx(silicone["mass_g"], abs=0.011)
    assert a == pytest.approx(b, abs=0.011)  # Dragon Skin: 1 : 1
    assert silicone["mixed_cm3"] > 1.15 * 2.4  # the block and its excess
    # Six slots of a sheet of 0.3 mm around legs of 2 x 0.1 mm, with 0.02 mm of play.
    assert silicone["flash_cm3"] == pytest.approx(1e-3 * 6 * (2.02 * 0.12 - 2.0 * 0.1) * 0.3)
    # The window is cut from 0.5 mm around the slots up to the block's top, through the wall.
    window = (10.0 + 2.02 + 2 * 0.5) * (12.0 - (10.0 - 0.06 - 0.5)) * (plan.wall_z - 0.3)
    assert windows_volume(plan) == pytest.approx(window)
    sylgard = mixing_of("sylgard_184", "platinum")
    assert sylgard.known
    assert sylgard.shares(22.0) == pytest.approx((20.0, 2.0))
    assert not mixing_of("mine", "condensation").known


ORDERS = [
    ("comb", "Clean, cure, test", "Wash", "Bake", "wet-sand", "barrier coat", "Inhibition test"),
    ("comb", CLOSE, "push plates 0-2 into", "comb front", "Set the contact insert on"),
    ("slots", CLOSE, "push plates 0-2 into", "end wall front", "push each leg from outside"),
    ("comb", OPEN, "contact insert", "end wall front (", "comb front (", "side wall right ("),
    ("slots", OPEN, "Pick the clay", "Draw, each straight outward"),
]


@pytest.mark.parametrize("order", ORDERS)
def test_steps_come_in_the_order_of_the_work(hand_made, order):
    holding, section, *words = order
    notes = notes_of(*hand_made(holding))
    places = [notes[section].index(each) for each in words]
    assert places == sorted(places)
    assert ("Pick the clay" in notes[OPEN]) is (holding == "slots")
    assert "base plate (" not in notes[OPEN]  # it stays


# Words with which a step begins that moves, adds or takes off a part.
MOVES = (
    *("Lay", "Put", "Push", "From above", "Thread", "Lower", "Set", "Slide", "Screw", "Rest"),
    *("Stand", "Press", "Draw", "Pry", "Hold", "Bend", "Fill the windows", "Cut the", "Try"),
    *("Pick the clay", "Pull the core", "Tilt the mold", "Tape"),
)


@pytest.mark.parametrize("given", [("comb", "sla"), ("slots", "machined"), None])
def test_each_step_that_moves_a_part_has_a_picture(hand_made, given):
    if given is None:  # an open mold, its front legs with traces
        plan, meshes = plan_mold(design := load_design("film_tees")), hand_made()[2]
    else:
        design, plan, meshes = hand_made(given[0], process=given[1])
    sections, views = casting_notes(casting_of(plan, meshes, gage_fit(design)))
    drawn = {(view.section, view.step) for view in views}
    moving = [
        (section["title"], k)
        for section in sections[TITLES.index(CLOSE) :]
        for k, step in enumerate(section["steps"], start=1)
        if step.startswith(MOVES) and not step.startswith("Hold both")
    ]
    assert len(moving) > 10
    assert set(moving) <= drawn


def test_large_effects_and_another_fixture_are_warned_of(hand_made):
    design, plan, _ = hand_made()
    effect = {"reason": None, "together": {"worst": 0.31}}
    longer = replace(plan, legs=tuple(replace(leg, exit=12.0) for leg in plan.legs))
    reported = " ".join(warnings_of(longer, effect))
    assert "31 %" in reported
    assert f"{100 * longer.legs_share:.2f} %" in reported
    silent = " ".join(warnings_of(plan, {**effect, **SILENT}))
    assert "31" not in silent
    assert "Legs of the plates" not in silent
    slotted = replace(hand_made("slots")[1], design=design)
    other = " ".join(warnings_of(slotted, SILENT))
    assert "mold.plate_fixture = 'comb'" in other


def test_a_gap_that_rubber_bridges_asks_for_a_vacuum(hand_made):
    design = shipped("maeno2000")
    plan = plan_mold(design)
    gap, wetting, buoyancy, apart, pitch = bridged_gap(plan)
    assert gap.distance < apart == pytest.approx(0.1 * np.sqrt(0.5) + 0.9 * np.sqrt(0.5))
    wider = with_values(design, {"plates.pitch_mm": pitch})
    assert bridged_gap(plan_mold(wider)) is None
    narrow = with_values(design, {"body.width_mm": 18.0})  # a gap for which no pitch fits
    assert gap.distance == pytest.approx(0.378, abs=1e-3)
    assert wetting == pytest.approx(0.042 / (1e-3 * gap.distance))
    assert buoyancy == pytest.approx(1.1 * 9.80665 * (0.9 + 0.1) * np.sqrt(0.5))
    warned = warnings_of(plan_mold(narrow), SILENT)
    assert "no pitch fits 15" in " ".join(warned)
    assert "under vacuum" in " ".join(warnings_of(plan, SILENT))
    _, apart, _ = hand_made()  # level plates next to each other are no channel
    assert bridged_gap(apart) is None


def test_bolts_reach_through_washers_and_nut_or_are_rods(hand_made):
    for grip, size, length in ((30.0, "M3", 35), (22.0, "M3", 30), (10.0, "M2", 16)):
        assert bolt_length(Bolt("z", 0.0, 0.0, 0.0, grip, size, 3.4)) == length
    long = replace(hand_made()[1], bolts=(Bolt("z", 0.0, 0.0, -100.0, 100.0, "M4", 4.5),))
    counts = {item["item"]: item["count"] for item in hardware(long)}
    assert (counts["threaded rod"], counts["nut"], "bolt" in counts) == (1, 2, False)


@pytest.mark.parametrize("holding", ["comb", "slots"])
def test_the_bill_names_everything_once(hand_made, tmp_path, holding):
    design, plan, meshes = hand_made(holding, process="machined" if holding == "slots" else "sla")
    casting = casting_of(plan, meshes, gage_fit(design))
    items = bill_of_materials(casting)
    write_bill(items, tmp_path / "bill.csv")
    with (tmp_path / "bill.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    counts = Counter()
    for row in rows:
        counts[row["item"]] += int(row["count"])
    assert {part.name for part in meshes.parts} <= set(counts)
    assert counts["plate_A"] == 3
    assert counts["plate_A, for the coupon"] == 2
    assert counts["strain gage"] == 8  # both faces of three plates and one to spare
    assert counts["plate_A, to spare"] == 1
    assert counts["bolt"] == counts["nut"] == len(plan.bolts)
    assert counts["washer"] == 2 * len(plan.bolts)
    assert counts["dowel pin"] == (len(plan.pins) if holding == "slots" else 0)
    by_item = {row["item"]: row for row in rows}
    assert float(by_item["elastomer, mixed"]["mass_g"]) > 0.0
    parts = [float(by_item[f"elastomer, part {each}"]["mass_g"]) for each in "AB"]
    assert sum(parts) == pytest.approx(float(by_item["elastomer, mixed"]["mass_g"]), abs=0.11)
    assert "none that is sold" in by_item["strain gage"]["size"]  # on plates of 2 mm
    assert by_item["gage wire"]["size"].startswith("3 m, ")  # four leads of 200 mm a plate
    tees = with_values(design, {"gages.grid": "tee", "mold.wire_mm": 0.3})
    found = bill_of_materials(casting_of(replace(plan, design=tees), meshes, gage_fit(tees)))
    wire = next(item for item in found if item["item"] == "gage wire")
    assert wire["size"].startswith("4 m, 0.1 mm")  # six, three across the bundle


@pytest.mark.parametrize(
    ("holding", "process", "bare", "wired"),
    [
        # 7 prints of 12 min, 2 sheets of 5 and 20 once; two coats of 15 beyond 40; 3 plates of 2;
        # 6 slots of 1 and 6 bolts of 2 beyond 20; 6 legs of a half beyond 30.
        ("comb", "sla", (45, 114, 70, 6, 0, 0, 0, 38, 40, 33, 0), (0, 0, 40)),
        # 7 parts of 5 min without a sheet, and nothing to coat.
        ("slots", "machined", (45, 55, 40, 6, 0, 0, 0, 38, 40, 33, 0), (0, 0, 10)),
    ],
)
def test_hours_are_the_counts_times_the_minutes_of_each(hand_made, holding, process, bare, wired):
    design, plan, meshes = hand_made(holding, process=process)
    hours = hours_of(casting_of(plan, meshes, gage_fit(design)))
    # 2 min a plate; 6 gages of 6, 12 thin joints of 5, 3 bundles of 3; half as long again to close
    # over leads; a minute a leg beyond 30, an hour to calibrate.
    wired = (*wired, 6, 36, 60, 9, 57, 40, 36, 60)
    assert [60.0 * each["bare_h"] for each in hours] == pytest.approx(bare, abs=0.31)
    assert [60.0 * each["wired_h"] for each in hours] == pytest.approx(wired, abs=0.31)
    # Of a wired step its hours beyond the bare finger count: twelve joints take an hour.
    longest = "make and clean the parts, 7 parts" if holding == "comb" else "solder and seal leads"
    assert f"longest: {longest}, " in hours_words(hours)


def test_hours_of_thick_wire_of_film_and_of_outer_combs(hand_made):
    """Thick joints take 3 min; film has no joints, but legs of 4 min; a leg is threaded twice."""
    design, plan, meshes = hand_made(wire_mm=0.6)
    steps = {each["step"]: each for each in hours_of(casting_of(plan, meshes, gage_fit(design)))}
    assert steps["solder and seal leads"]["wired_h"] == pytest.approx(12 * 3 / 60)
    plan = plan_mold(design := load_design("film_tees"))
    steps = {each["step"]: each for each in hours_of(casting_of(plan, meshes, gage_fit(design)))}
    plates = len(plan.frames)
    assert steps["check films, connect legs"]["wired_h"] == pytest.approx(4 * plates / 60, abs=0.01)
    assert "bond gages" not in steps
    assert steps["thread plates, close the mold"]["counts"] == f"{4 * plates} slots, 2 bolts"


def test_a_rubber_is_named_of_a_modulus_within_a_quarter():
    """Dragon Skin 20 and 30 have 0.732 and 1.142 MPa, Sylgard 184 has 1.8."""
    for modulus, like in ((0.9, "dragon skin 20)"), (1.43, "or so"), (2.2, "sylgard 184)")):
        design = shipped("homogeneous", materials__silicone__youngs_modulus_MPa=modulus)
        assert rubber_words(design).endswith(like)


def test_what_is_ordered_is_said_with_its_sizes_and_numbers(hand_made):
    _, plan, meshes = hand_made()
    rows = {row["item"]: row for row in bill_of_materials(casting_of(plan, meshes, None))}
    assert "plate_A: 7 of 0.1 mm" in rows["plate_A"]["words"]  # twice 3, and one to spare
    assert rows["plate_A"]["size"] == "2.00 x 16.60 mm, 0.1 mm thick"
    assert (rows["plate_A, for the bare finger"]["count"], rows["base_plate"]["count"]) == (3, 2)
    assert rows["comb_front"]["size"] == "20.0 x 12.0 mm, 0.3 mm thick"
    assert rows["side_wall_left"]["size"].endswith("x 12.0 x 10.0 mm, 1.19 cm³")
    assert rows["solder and flux"]["size"] == "12 joints"
    order = ["order today", "make", "buy", "have"]
    assert list(dict.fromkeys(row["when"] for row in rows.values())) == order
    machined = hand_made("slots", process="machined")
    rows = {row["item"]: row for row in bill_of_materials(casting_of(*machined[1:], None))}
    assert rows["contact_insert"]["when"] == "order today"
    assert "barrier coat" not in rows


def test_gages_are_ordered_by_whole_packs_and_films_by_their_drawing(hand_made):
    design = load_design("film_tees")
    own = gage_fit(with_values(load_design("wide"), {"gages.kind": "silicon_bar_15"})).found
    own = own.model_dump() | {"name": "mine", "least_order": 10}
    bars = {"mold.gage_types": [own], "gages.kind": "mine"}
    # Eleven plates and three to spare, on both faces; 21 plates and five to spare.
    film = "on 2 faces: grid 0.32 x 1 mm, 350 ohm, 28 gages; some 8 weeks"
    bar = "60 of mine (grid 1.2 x 2 mm, 500 ohm), at least 10 a pack"
    for each, words in ((design, film), (with_values(load_design("wide"), bars), bar)):
        found = bill_of_materials(casting_of(plan_mold(each), hand_made()[2], gage_fit(each)))
        assert next(row for row in found if row["item"] == "strain gage")["words"].endswith(words)


def test_hardware_is_as_long_as_what_it_holds():
    """Core pins reach from the wall's outside into the core."""
    plan = plan_mold(shipped("boned"))
    sizes = {item["item"]: item["size"] for item in hardware(plan)}
    assert sizes["core pin"] == f"2 mm, {plan.half_depth + plan.wall_z - 1.8:.2f} mm or longer"
    screwed = plan_mold(shipped("boned", body__core__bottom_mm=0.0))
    (screw,) = (item for item in hardware(screwed) if item["item"] == "core screw")
    assert (screw["count"], screw["size"]) == (2, "for a 2.4 mm hole, 4 mm plate")


def test_hours_without_plates_are_of_a_bare_casting_alone(hand_made):
    """No gage, lead or plate is counted, nor a wired finger; the words leave its hours out."""
    design = with_values(hand_made()[0], {"plates.count": 0})
    plan, meshes = plan_mold(design), replace(hand_made()[2], plates=())
    hours = hours_of(casting_of(plan, meshes, None))
    assert sum(each["wired_h"] for each in hours) == 0.0 < sum(each["bare_h"] for each in hours)
    steps = [each["step"] for each in hours]
    assert steps[0] == "coupon"
    assert not {"cut and deburr plates", "bond gages", "calibrate"} & set(steps)
    assert not any("plate" in each["step"] for each in hours)
    assert "wired" not in hours_words(hours)
