"""Casting notes, warnings and the bill of materials, from the design and its plan."""

import csv
import re
from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.mold.plan.legs import legs_share
from fingerdesign.mold.plan.plan import Bolt, CorePin, Key
from fingerdesign.mold.products.bill import (
    bill_of_materials,
    bolt_length,
    hardware,
    silicone_of,
    write_bill,
)
from fingerdesign.mold.products.flat_pattern import flat_patterns
from fingerdesign.mold.products.notes import (
    casting_notes,
    mixing_of,
    numbers_text,
    warnings_of,
)

SILENT = {"reason": "no gages", "sentences": ["Not known."]}


def notes_of(design, plan, meshes):
    silicone = silicone_of(design, plan, meshes)
    sections = casting_notes(design, plan, meshes.parts, flat_patterns(design, plan), silicone)
    return {section["title"]: " ".join(section["steps"]) for section in sections}


def test_sections_in_the_order_of_the_work(hand_made):
    assert list(notes_of(*hand_made())) == [
        "Make the parts",
        "Clean, cure, test",
        "Plates and gages",
        "Close the mold",
        "Mix and pour",
        "Cure and open",
        "Finish and measure",
    ]


def test_the_masses_weighed_are_what_is_mixed(hand_made):
    design, plan, meshes = hand_made()
    text = notes_of(design, plan, meshes)["Mix and pour"]
    a, b = map(float, re.search(r"Weigh ([\d.]+) g of A and ([\d.]+) g of B", text).groups())
    silicone = silicone_of(design, plan, meshes)
    assert a + b == pytest.approx(silicone.mass_g, abs=0.011)
    assert a == pytest.approx(b, abs=0.011)  # Dragon Skin: 1 : 1
    assert silicone.mixed_cm3 > 1.15 * 2.4  # the block and its excess


def test_an_elastomer_that_is_not_known_is_said_to_be(hand_made):
    sylgard = mixing_of("sylgard_184", "platinum")
    assert sylgard.known
    assert sylgard.shares(22.0) == pytest.approx((20.0, 2.0))
    assert not mixing_of("mine", "condensation").known


def test_parts_come_off_in_their_order(hand_made):
    text = notes_of(*hand_made())["Cure and open"]
    order = ["contact insert", "end wall front", "comb front", "side wall right"]
    assert "Draw contact insert" in text
    places = [text.index(name) for name in order[:1]]
    places += [text.index(f"{name} (") for name in order[1:]]
    assert places == sorted(places)
    assert "base plate (" not in text


def test_resin_prints_with_platinum_silicone_are_warned_of(hand_made):
    for process, cure, warned in (
        ("sla", "platinum", True),
        ("sla", "condensation", False),
        ("machined", "platinum", False),
    ):
        design, plan, meshes = hand_made(process=process, cure=cure)
        reported = warnings_of(design, plan, SILENT)
        assert any("Resin prints" in each for each in reported) is warned
        text = notes_of(design, plan, meshes)["Clean, cure, test"]
        assert ("barrier coat" in text) is warned


def test_resin_is_coated_after_it_is_fitted_and_degreased_and_tested_on_the_coat(hand_made):
    text = notes_of(*hand_made())["Clean, cure, test"]
    order = ["Wash", "Bake", "Dry fit", "wet-sand", "Degrease", "barrier coat", "Polish the coat"]
    places = [text.index(each) for each in (*order, "Inhibition test")]
    assert places == sorted(places)
    assert "on the coated face" in text


@pytest.mark.parametrize("process", ["sla", "fdm", "machined"])
def test_what_stops_a_platinum_cure_at_the_gages_is_reported_for_every_process(hand_made, process):
    design, plan, meshes = hand_made(process=process)
    reported = " ".join(warnings_of(design, plan, SILENT))
    assert "Solder flux" in reported
    assert "amine" in notes_of(design, plan, meshes)["Plates and gages"]
    design, plan, meshes = hand_made(process=process, cure="condensation")
    assert "Solder flux" not in " ".join(warnings_of(design, plan, SILENT))


def test_shrinkage_that_is_assumed_is_said_to_be(hand_made):
    design, plan, meshes = hand_made(cure="condensation")
    assert any("Shrinkage is assumed" in w for w in warnings_of(design, plan, SILENT))
    assert "1.0204 times" in notes_of(design, plan, meshes)["Finish and measure"]


def test_a_fixture_other_than_requested_is_reported(hand_made):
    design, plan, _ = hand_made("slots")
    reported = " ".join(warnings_of(design, plan, SILENT))
    assert "not by mold.plate_fixture = 'comb'" in reported
    assert "shims" in reported


def test_large_effects_are_warned_of(hand_made):
    design, plan, _ = hand_made()
    effect = {"reason": None, "together": {"worst": 0.31}}
    longer = replace(plan, legs=tuple(replace(leg, exit=12.0) for leg in plan.legs))
    reported = " ".join(warnings_of(design, longer, effect))
    assert "by up to 31 %" in reported
    assert f"take {100 * legs_share(design, longer):.2f} %" in reported
    silent = " ".join(warnings_of(design, plan, {**effect, **SILENT}))
    assert "31" not in silent
    assert "Legs of the plates" not in silent


def test_core_pins_are_pulled_and_their_tunnels_filled(hand_made):
    design, plan, meshes = hand_made()
    plan = replace(plan, core_pins=(CorePin("+z", 0.0, 6.0, 2.0, 3.0, 1.0),) * 2)
    notes = notes_of(design, plan, meshes)
    assert "2 core pins (2 mm" in notes["Close the mold"]
    assert "Pull the core pins" in notes["Cure and open"]
    assert "2 tunnels" in notes["Finish and measure"]
    (pin,) = [item for item in hardware(plan) if item.item == "core pin"]
    assert pin.count == 2
    assert "12 mm or longer" in pin.size  # from the block's face at 15 to the tip at 3


@pytest.mark.parametrize(
    ("grip", "size", "length"), [(30.0, "M3", 35), (22.0, "M3", 30), (10.0, "M2", 16)]
)
def test_bolts_reach_through_washers_and_nut(grip, size, length):
    assert bolt_length(Bolt("z", 0.0, 0.0, 0.0, grip, size, 3.4)) == length


def test_a_bolt_longer_than_any_is_a_rod(hand_made):
    _, plan, _ = hand_made()
    long = replace(plan, bolts=(Bolt("z", 0.0, 0.0, -100.0, 100.0, "M4", 4.5),))
    items = {item.item: item for item in hardware(long)}
    assert items["threaded rod"].count == 1
    assert items["nut"].count == 2
    assert "bolt" not in items


def test_the_bill_names_everything_once(hand_made, tmp_path):
    design, plan, meshes = hand_made()
    patterns = flat_patterns(design, plan)
    items = bill_of_materials(design, plan, meshes, patterns, silicone_of(design, plan, meshes))
    write_bill(items, tmp_path / "bill.csv")
    with (tmp_path / "bill.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    counts = {}
    for row in rows:
        counts[row["item"]] = counts.get(row["item"], 0) + int(row["count"])
    assert {part.name for part in meshes.parts} <= set(counts)
    assert counts["plate_A"] == 3
    assert counts["strain gage"] == 6  # both faces of three plates
    assert counts["bolt"] == counts["nut"] == 6
    assert counts["washer"] == 12
    mixed = next(row for row in rows if row["item"] == "elastomer, mixed")
    assert float(mixed["mass_g"]) > 0.0
    assert "shim" not in counts


def test_slots_need_shims_and_dowels_are_bought(hand_made):
    _, plan, _ = hand_made("slots", process="machined")
    items = {item.item: item for item in hardware(plan)}
    assert items["shim"].count == 6
    assert items["shim"].size.startswith("0.2 mm thick")
    assert items["dowel pin"].count == 1


@pytest.mark.parametrize(
    ("holding", "holder", "words"),
    [
        ("comb", "comb front", "legs and wires into its window"),
        ("jig", "jig front inner and jig front outer", "that clamps the plates"),
        ("slots", "end wall front", "Measure the gap beside each leg"),
    ],
)
def test_plates_are_threaded_into_what_holds_them(hand_made, holding, holder, words):
    text = notes_of(*hand_made(holding))["Close the mold"]
    assert holder in text
    assert "push plates 0-2 into" in text
    assert words in text
    # The front's holder, where the wires leave, comes after the plates stand in the back.
    assert text.index("push plates 0-2") < text.index("over the plates' other ends")
    assert text.index("bundle of wires first") < text.index("over the plates' other ends")


def test_walls_are_put_together_upright_and_set_onto_the_keys(hand_made):
    design, plan, meshes = hand_made()
    key = Key((12.0, 0.0, 6.0), (14.0, 2.0, 9.0), 2.0, 0.1, "end_wall_front")
    text = notes_of(design, replace(plan, keys=(key,)), meshes)["Close the mold"]
    order = ["Lay end wall back", "side wall right and left on it", "Set end wall front", "keys up"]
    places = [text.index(each) for each in (*order, "Set the contact insert on")]
    assert places == sorted(places)
    assert "along their keys" not in text


def test_wires_are_freed_and_shims_pulled_before_walls_are_drawn(hand_made):
    text = notes_of(*hand_made("slots"))["Cure and open"]
    drawn = text.index("Draw, each straight outward")
    assert text.index("no connector yet") < drawn
    assert text.index("Pull every shim") < drawn
    assert "shim" not in notes_of(*hand_made())["Cure and open"]


def test_locks_are_reported_to_fill(hand_made):
    notes = notes_of(*hand_made())
    assert "rises in the 1 lock, too" in notes["Mix and pour"]
    assert "vents and locks flush" in notes["Finish and measure"]


def test_a_finger_without_plates_has_notes_without_them(hand_made):
    design, plan, meshes = hand_made()
    bare = design.model_copy(update={"plates": design.plates.model_copy(update={"count": 0})})
    sides = tuple(replace(s, holding="wall", slots=(), window=None) for s in plan.sides)
    plan = replace(plan, frames=(), legs=(), sides=sides)
    notes = notes_of(bare, plan, meshes)
    assert "Plates and gages" not in notes
    assert "legs" not in notes["Finish and measure"]


def test_plates_by_their_numbers():
    assert numbers_text(np.arange(15).tolist()) == "0-14"
    assert numbers_text([4, 0, 1]) == "0-1, 4"
