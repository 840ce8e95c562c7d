"""Grids and bridges: what a bridge gives, what noise it adds, which bridges there are."""

import numpy as np
import pytest

from fingerdesign.analysis.case import gage_array
from fingerdesign.checks.load import judge_design, parse_design
from fingerdesign.control.plants.hardware import ImperfectPlant
from fingerdesign.errors import DesignError

NAME = 'design.name = "a"\n'
TYPE = """
[[mold.gage_types]]
name = "mine"
grid_length_mm = 2.0
grid_width_mm = 1.0
carrier_length_mm = {}
carrier_width_mm = {}
"""
PAIRS = 'gages.grid = "double_axial"\n[plates]\nlength_mm = 1.0\npitch_mm = 1.5\n'


def wheatstone(*arms):
    """Output over excitation of a bridge whose arms' resistances are (at rest, strained)."""
    rest, now = np.array(arms, dtype=float).T

    def output(r):
        return r[0] / (r[0] + r[1]) - r[3] / (r[2] + r[3])

    return output(now) - output(rest)


@pytest.mark.parametrize("weight", [0.33, 0.8])
def test_outputs_are_those_of_the_circuit(weight):
    """The wiring that each bridge stands for, resistor by resistor, at a strain of 1e-7."""
    along, across, other, k = 3e-7, -2e-7, -1e-7, 2.1

    def grid(strain, shunt=np.inf):
        r = 350.0 * np.array([1.0, 1.0 + k * strain])
        return r if shunt == np.inf else r * shunt / (r + shunt)

    full, half_arm = grid(0.0), 350.0 * weight / (1.0 - weight)
    root = np.sqrt(weight)
    series = grid(along) + grid(across, 350.0 * root / (1.0 - root))
    rest = np.full(2, series[0])
    low = grid(across, half_arm)
    tee = along + weight * across
    wired = {
        ("axial", "upper", "quarter"): (along, (grid(along), full, full, full)),
        ("axial", "both", "half"): (along, (grid(along), full, grid(along), full)),
        ("axial", "both", "quarter"): (along, (2 * grid(along), 2 * full, 2 * full, 2 * full)),
        ("tee", "upper", "half"): (tee, (grid(along), full, low, np.full(2, low[0]))),
        ("tee", "upper", "quarter"): (tee, (series, rest, rest, rest)),
        ("tee", "both", "half"): (tee, (series, rest, series, rest)),
        ("double_axial", "upper", "half"): (
            0.5 * (along - other),
            (grid(along), grid(other), full, full),
        ),
        ("double_axial", "both", "full"): (
            0.5 * (along - other),
            (grid(along), grid(other), grid(along), grid(other)),
        ),
    }
    for (grids, face, bridge), (reading, arms) in wired.items():
        text = f'grid = "{grids}"\nface = "{face}"\nbridge = "{bridge}"\ngage_factor = {k}\n'
        text += f"transverse_weight = {weight}\n" if grids == "tee" else ""
        pairs = "plates.count = 4\nplates.alternate = true\nplates.length_mm = 1.0\n"
        design = parse_design(f"{NAME}{pairs}plates.pitch_mm = 1.5\n[gages]\n{text}")
        name, per_microstrain = design.bridge
        assert name == bridge
        assert wheatstone(*arms) == pytest.approx(per_microstrain * reading, rel=1e-5), text


SIZES = ("grid_length", "grid_width", "carrier_length", "carrier_width")


def test_a_difference_fills_the_bridge_of_two_tees_and_a_pair_goes_by_its_first_plate():
    """At a negative weight neighbouring arms subtract: four arms, as for two grids of a tee."""
    design = parse_design(NAME + 'gages.grid = "tee"\ngages.transverse_weight = -1.0')
    assert design.bridge == ("full", 1.0)
    assert design.gage_weights == (1.0, -1.0)
    assert design.gages.lead_count == 6
    assert gage_array(parse_design(NAME + PAIRS + "count = 6\nalternate = true")) == (0, 2, 4)


def test_every_row_that_makes_no_pairs_is_named():
    row = '{ along = "x", count = 3, cover_mm = 3.0, pitch_mm = 1.5 }'
    judged = judge_design(NAME + PAIRS + f"count = 4\ncover_mm = 1.0\nrows = [{row}]")
    bounds = [fault.bound for fault in judged.faults]
    assert any("plates 0 and 1" in bound for bound in bounds)
    assert any("a row of 3 plates (4 to 6)" in bound for bound in bounds)


def test_the_amplifiers_noise_is_the_bridges():
    """A quarter bridge with gage factor 2 gives 0.5 microvolt per volt a microstrain."""
    text = NAME + 'gages.face = "upper"\n[grip.hardware]\ngage_noise_microvolt_per_V = 0.2\n'
    quarter = parse_design(text).rig.hardware
    assert quarter.gage_noise_microstrain == pytest.approx(0.4)
    assert quarter.gage_noise_microvolt_per_V == 0.0
    both = parse_design(text + "gage_noise_microstrain = 0.3").rig.hardware
    assert both.gage_noise_microstrain == pytest.approx(0.5)
    with pytest.raises(ValueError, match=r"design\.rig\.hardware"):
        ImperfectPlant(None, parse_design(text).grip.hardware, np.random.default_rng(0))


@pytest.mark.parametrize(
    ("lines", "key", "words"),
    [
        ('gages.grid = "tee"\ngages.bridge = "full"', "gages.bridge", "'quarter' or 'half'"),
        ('gages.bridge = "half"\ngages.face = "upper"', "gages.bridge", "on one face"),
        (
            'plates.length_mm = 0.9\ngages.leads = {kind = "traces", width_mm = 0.5}',
            *("gages.leads.width_mm", "leads of a plate, 1.5 mm next to each other"),
        ),
        ("gages.transverse_weight = 0.3", "gages.transverse_weight", "without a tee"),
        (PAIRS + "count = 5", "gages.grid", "row of 5 plates"),
        (PAIRS + "count = 4", "gages.grid", "plates 0 and 1 at 45 and 45 degrees"),
        (PAIRS + "count = 4\nalternate = true\nangle_deg = 2", "gages.grid", "2 and -2 degrees"),
        (
            PAIRS + "count = 6\nalternate = true\n[grip.hardware]\ndead_gages = [3]",
            "grip.hardware.dead_gages",
            "even",
        ),
    ],
)
def test_what_no_bridge_can_be_is_refused(lines, key, words):
    with pytest.raises(DesignError) as caught:
        parse_design(NAME + lines)
    fault = next(fault for fault in caught.value.faults if fault.key == key)
    assert words in str(fault)


@pytest.mark.parametrize(
    ("lines", "key", "words"),
    [
        ("wire_mm = 1e-5", "mold.wire_mm", "0, or at least 0.0375"),
        ("wire_mm = 0.03", "mold.wire_mm", "0, or at least 0.0375"),
        (TYPE.format(1.0, 3.0), "mold.gage_types.carrier_length_mm", "at least grid_length_mm"),
        (TYPE.format(3.0, 0.5), "mold.gage_types.carrier_width_mm", "at least grid_width_mm"),
        (2 * TYPE.format(3.0, 3.0), "mold.gage_types", "types of different names"),
        (TYPE.format(3.0, 3.0).replace('"mine"', '"auto"'), "mold.gage_types", "another name"),
    ],
)
def test_gages_and_wires_that_cannot_be_are_refused(lines, key, words):
    with pytest.raises(DesignError) as caught:
        parse_design(NAME + "[mold]\n" + lines)
    (fault,) = caught.value.faults
    assert fault.key == key
    assert words in fault.bound


@pytest.mark.parametrize("wire", [0, 0.0375, 0.1])
def test_no_wire_and_one_that_can_be_handled_are_sound(wire):
    assert parse_design(NAME + f"mold.wire_mm = {wire}").mold.wire_mm == wire


def test_a_kind_gives_its_factor_and_counts_by_it_alone():
    text = 'design.name = "kinds"\n[gages]\n'
    plain, bar = parse_design(text), parse_design(text + 'kind = "silicon_bar_05"\n')
    assert (plain.gage_factor, bar.gage_factor) == (2.0, 120.0)
    assert bar.bridge[1] == pytest.approx(60.0 * plain.bridge[1])
    soft = 'gages.kind = "soft"\n[[mold.gage_types]]\nname = "soft"\ngage_factor = 120.0\n'
    soft += "".join(f"{grid}_mm = 0.2\n" for grid in SIZES)
    own = parse_design('design.name = "kinds"\n' + soft)
    assert parse_design(text + "gage_factor = 120.0\n").digest() == own.digest()
    assert own.digest() != bar.digest()  # which is stiff
    assert parse_design(text + "gage_factor = 2.0\n").digest() == plain.digest() != bar.digest()
    assert parse_design(text + 'kind = "foil_1"\n').digest() != plain.digest()  # stiff, too
    measured = parse_design(text + 'kind = "silicon_bar_05"\ngage_factor = 131.0\n')
    assert measured.gage_factor == 131.0
