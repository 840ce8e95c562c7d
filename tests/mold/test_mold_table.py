"""The [mold] table: what it says by itself, what a process holds, the starter file's block."""

import tomllib

import pytest

from fingerdesign.checks.load import dump_design, parse_design
from fingerdesign.checks.starter import starter_text
from fingerdesign.errors import DesignError
from fingerdesign.mold.plan.plan import PROFILES, density_of, limits_of

NAME = 'design.name = "a"\n'


def mold(lines):
    return parse_design(NAME + lines).mold


def test_each_process_has_a_profile_of_its_own_numbers():
    for name, profile in PROFILES.items():
        limits = limits_of(mold(f'mold.process = "{name}"'))
        assert limits == profile
        assert limits.name == name
        assert 0 < limits.feature_mm <= limits.wall_mm
        assert 0 < limits.clearance_mm < limits.slot_mm <= limits.hole_mm < limits.pin_mm


def test_limits_given_take_the_profiles_place_alone():
    limits = limits_of(mold('mold.process = "fdm"\nmold.limits.slot_mm = 0.45'))
    assert limits.slot_mm == 0.45
    assert limits.hole_mm == PROFILES["fdm"].hole_mm


def test_shrinkage_follows_the_cure_unless_given():
    assert mold("").shrinkage_used == 0.0
    assert mold('mold.cure = "condensation"').shrinkage_used == 0.02
    assert mold('mold.cure = "condensation"\nmold.shrinkage = 0.005').shrinkage_used == 0.005


def test_density_is_given_or_of_the_material():
    assert density_of(parse_design(NAME)) == 1.1
    assert density_of(parse_design(NAME + 'body.material = "dragon_skin_30"')) == 1.08
    assert density_of(parse_design(NAME + "mold.density_g_cm3 = 1.2")) == 1.2


@pytest.mark.parametrize(
    ("line", "key"),
    [
        ("mold.shrinkage = 0.2", "mold.shrinkage"),
        ("mold.draft_deg = 46", "mold.draft_deg"),
        ('mold.process = "cnc"', "mold.process"),
        ('mold.bolt = "M5"', "mold.bolt"),
        ("mold.limits.slot_mm = 0", "mold.limits.slot_mm"),
        ("mold.comb.shet_mm = 0.2", "mold.comb.shet_mm"),
    ],
)
def test_wrong_values_are_refused_by_key(line, key):
    with pytest.raises(DesignError) as caught:
        parse_design(NAME + line)
    assert [fault.key for fault in caught.value.faults] == [key]


def test_the_starter_file_says_every_key():
    text = starter_text("mine")
    block = text[text.index("[mold]") :]
    for key in ("wall_mm", "plate_fixture", "excess", "[mold.limits]", "[mold.comb]", "sheet_mm"):
        assert key in block
    assert tomllib.loads(text)["mold"]["process"] == "sla"
    assert "limits" not in tomllib.loads(text)["mold"] or not tomllib.loads(text)["mold"]["limits"]


def test_what_is_written_reads_back():
    design = parse_design(NAME + 'mold.process = "machined"\nmold.comb.slot_mm = 0.15')
    assert parse_design(dump_design(design)) == design
