"""The space of a search for a passing finger: its ranges, first trials, and what it gives up."""

from dataclasses import replace

import numpy as np
import pytest
from fingerdesign_bench.any_finger.step_samples import sample_step

from fingerdesign.checks.load import load_design, parse_design, with_values
from fingerdesign.errors import DesignError
from fingerdesign.search.passing.freedom import Freedom
from fingerdesign.search.passing.passing import (
    study_of,
)
from fingerdesign.search.passing.ranges import PASSING
from fingerdesign.search.passing.space import space_of
from fingerdesign.search.study.values import Range
from fingerdesign.search.study.variants import variant_of
from tests.support.passing import outcome


def test_a_bonded_gage_gives_way_to_the_film_that_is_cast():
    foil = with_values(load_design("narrow"), {"gages.kind": "etched_constantan"})
    assert space_of(foil, Freedom()).base.gages.kind is None
    assert space_of(foil, Freedom(keep=("gages.kind",))).base.gages.kind == "etched_constantan"


def test_a_tall_finger_may_become_as_low_as_those_that_pass():
    """The lowest of them over its width; a finger that is lower keeps its own share."""
    passing = [load_design(name).body for name in PASSING]
    lowest = min(each.base_height_mm / each.width_mm for each in passing)
    tall = with_values(load_design("maeno2000"), {"body.base_height_mm": 14.0})
    least = space_of(tall, Freedom()).parameters["body.base_height_mm"].low
    assert least == pytest.approx(lowest * tall.body.width_mm, abs=0.1)
    flat = load_design("film_tees")
    least = space_of(flat, Freedom()).parameters["body.base_height_mm"].low
    assert least == pytest.approx(0.6 * flat.body.base_height_mm, abs=0.1)


@pytest.mark.parametrize(
    "name", ["maeno2000", "narrow", "both_ways", "homogeneous", "domed", "pin"]
)
def test_space_begins_inside_its_ranges(name):
    design = load_design(name)
    space = space_of(design, Freedom())
    assert space.base.gages.grid == "tee"
    assert space.base.plates.material == "polyimide"
    assert not space.base.plates.rows
    assert space.base.plates.count > 0
    for start in space.starts:
        assert start.keys() == space.parameters.keys()
        for key, value in start.items():
            own = space.parameters[key]
            assert own.low <= value <= own.high if isinstance(own, Range) else value in own
    # Plates of shipped fingers in proportion to the width, and as they are; a pin is too round.
    sizes = {start["plates.pitch_mm"] for start in space.starts}
    assert len(sizes) > (1 if name in ("pin", "maeno2000") else 2)
    # The last start is a finger that can exist, at the design's own size.
    made = variant_of(study_of(space), space.base, 1, space.starts[-1])
    assert made.design is not None, made.faults


@pytest.mark.parametrize("name", ["maeno2000", "domed", "block"])
def test_trials_near_a_finger_can_exist_and_differ_in_some_keys(name):
    space = space_of(load_design(name), Freedom())
    start = space.starts[-1]
    drawn = [space.near(start, np.random.default_rng(seed)) for seed in range(12)]
    assert all(map(space.sound, drawn))
    assert all(each != start for each in drawn)
    unchanged = [sum(each[key] == start[key] for key in start) / len(start) for each in drawn]
    assert 0.3 < np.mean(unchanged) < 0.8
    assert drawn[3] == space.near(start, np.random.default_rng(3))


@pytest.mark.parametrize("name", ["pin", "block", "boned"])
def test_search_begins_with_film_plates_that_fit_any_body(name):
    space = space_of(load_design(name), Freedom())
    assert space.starts[-1]["plates.length_mm"] < 1.0
    assert space.base.body.shape == {"pin": "revolved"}.get(name, "arc")
    assert all(map(space.sound, space.starts))


def test_a_kept_body_keeps_its_top_and_own_plates_where_short_ones_do_not_fit():
    block, pin = (space_of(load_design(name), Freedom(keep=("body",))) for name in ("block", "pin"))
    assert block.base.body == load_design("block").body
    assert "body.shape" not in block.replaced
    assert pin.base.body == load_design("pin").body  # Its spherical end is as round as it is wide.
    assert pin.base.plates.count == load_design("pin").plates.count


def similar(name):
    """The base of a search, and its first trial with the proportions of a finger that passes."""
    space = space_of(load_design(name), Freedom())
    design = variant_of(study_of(space), space.base, 1, space.starts[1]).design
    size, known = design.body.width_mm / 22.0, load_design(PASSING[0]).body
    assert design.body.depth_mm == pytest.approx(size * known.depth_mm, abs=0.1)
    assert design.body.arc_radius_mm == pytest.approx(size**2 * known.arc_radius_mm, abs=0.5)
    return space.base, design


def test_what_lies_inside_becomes_shallower_with_the_body():
    """A finger that is as deep for its width as its design follows less well."""
    base, design = similar("boned")
    by = design.body.depth_mm / base.body.depth_mm
    assert by < 0.8
    assert design.body.core.depth_mm == pytest.approx(by * base.body.core.depth_mm)
    by = design.body.base_height_mm / base.body.base_height_mm
    assert design.body.core.height_mm == pytest.approx(by * base.body.core.height_mm)
    base, design = similar("both_ways")
    by = design.body.depth_mm / base.body.depth_mm
    assert design.plates.span_mm == pytest.approx(by * base.plates.span_mm)
    deep = space_of(load_design("boned"), Freedom(keep=("body.depth_mm",)))
    assert not any("body.depth_mm" in key for key in deep.parameters)


def test_kept_keys_stay_and_freed_ones_vary():
    design = load_design("maeno2000")
    space = space_of(design, Freedom(keep=("body", "plates.material"), free=("grip.preload_mm",)))
    assert not any(key.startswith("body") for key in space.parameters)
    assert space.base.plates.material == "phosphor_bronze"
    assert "grip.preload_mm" in space.parameters
    rows = load_design("both_ways")
    assert space_of(rows, Freedom(keep=("plates.rows",))).base.plates.rows == rows.plates.rows


def test_faults_of_kept_and_freed_keys_come_together():
    wrong = ("body.shape", "plates.cont", "plates")
    freedom = Freedom(keep=("plates.pich_mm", "materials"), free=wrong)
    with pytest.raises(DesignError) as found:
        space_of(load_design("maeno2000"), freedom)
    faults = {fault.value: fault.remedy for fault in found.value.faults}
    assert "plates.pitch_mm" in faults["plates.pich_mm"]
    assert "plates.count" in faults["plates.cont"]
    assert faults["body.shape"]
    assert "a table" in faults["plates"]
    assert "materials" not in faults
    everything = Freedom(keep=("body", "plates", "gages"))
    with pytest.raises(DesignError, match="tunes the hand alone"):
        space_of(load_design("maeno2000"), everything)
    both = Freedom(keep=("body",), free=("body.width_mm", "gages.z_mm", "mesh.plate_size_mm"))
    bounds = {fault.value: fault.bound for fault in both.faults(load_design("film_tees"))}
    assert bounds == {
        "body.width_mm": "a key that is not kept",
        "gages.z_mm": "a key that is not 0",
        "mesh.plate_size_mm": "a key of the finger",
    }


def test_a_finger_that_must_stay_without_a_row_along_x_is_refused():
    """Its analysis would judge no gage, so that no verdict would fail."""
    with pytest.raises(DesignError, match="no gage sees slip"):
        space_of(load_design("homogeneous"), Freedom(keep=("plates",)))
    assert space_of(load_design("homogeneous"), Freedom()).parameters


@pytest.mark.slow
def test_trials_of_a_users_own_cad_are_made_on_an_arc_of_its_size():
    file = sample_step("filleted", 16.0, 12.0, 10.0, 1.5)
    body = f'body = {{ shape = "step", step = {{ file = "{file}" }} }}'
    stepped = parse_design(f'design.name = "mine"\nplates.count = 0\n{body}')
    space = space_of(stepped, Freedom())
    arc = space.on_arc(space.base)
    assert arc.body.shape == "arc"
    assert arc.body.step is None
    assert (arc.body.width_mm, arc.body.depth_mm) == (stepped.body.width_mm, stepped.body.depth_mm)
    good = outcome(space.base, 0.0)
    good = replace(good, values={**space.starts[-1], "plates.pitch_mm": 0.77})
    conceded = space.plainer(Freedom(), [good])
    assert conceded.starts[0].items() >= good.values.items()
    assert conceded.given_up == ("body.shape",)
    own = {key for key in {*conceded.parameters} - {*space.parameters} if key.startswith("body")}
    assert own == {"body.arc_radius_mm", "body.base_height_mm", "body.depth_mm"}
    made = variant_of(study_of(conceded), conceded.base, 1, conceded.starts[0])
    assert made.design is not None, made.faults
    assert conceded.base.plates.span_mm == space.base.plates.span_mm
    assert space.plainer(Freedom()).base.plates.span_mm is None
    assert space.plainer(Freedom(keep=("body",))) is None
