"""Verdicts and fixes of a result, and the block of the terminal that shows them."""

from dataclasses import replace

import pytest
from fingerdesign_cli.terminal import LINES, WIDTH, say_block

from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.records.result import GageRemedy, Measurability, MeasuredState


def seeing(change, *remedies):
    """Gages that show this change of the stick ratio, with a target of 0.1."""
    state = MeasuredState(0.5, 5.0, 2.0, 1.0, 1.5, change, 1.0)
    return Measurability(0.5, False, 0.1, (state,), remedies)


@pytest.fixture
def result(plane_strain):
    return replace(plane_strain.result, warnings=())


def test_a_lift_with_little_margin_warns_and_one_that_slips_fails(result):
    grip = replace(result.grips[0], lifted=True, gross_slip=False, safety_margin=1.1)
    slipped = replace(grip, friction_coefficient=0.2, gross_slip=True)
    view = verdict_view(replace(result, grips=(grip, slipped), measurability=None))
    found = {each.name.split()[0]: each for each in view.verdicts}
    assert (found["lifts"].status, found["lifts"].count) == ("fail", "1 of 2 μ")
    assert found["grip"].status in ("warning", "fail")
    assert view.summary.endswith("fail")


def test_a_lift_that_needs_more_steps_gets_them_and_no_other_controller(result):
    halfway = replace(result.grips[0], outcome="steps", lifted=False, safety_margin=None)
    halfway = replace(halfway, steps=200, object_mass_g=200.0, final_tangential_force_N=0.4903)
    view = verdict_view(replace(result, grips=(halfway,), measurability=None))
    changes = [each.change for each in view.fixes]
    assert "grip.max_steps = 481" in changes  # twice as many, and a fifth more
    assert not [each for each in changes if "fixed_force" in each]
    still = replace(halfway, final_tangential_force_N=0.0)
    view = verdict_view(replace(result, grips=(still,), measurability=None))
    assert [each for each in view.fixes if "fixed_force" in each.change]


def test_one_force_for_a_wide_range_of_friction_is_offered_with_its_price(result):
    fails = replace(result.grips[0], lifted=False, safety_margin=None, outcome="complete slip")
    for high, price in ((0.3, ""), (0.8, ", crushes at μ 0.8")):
        grips = [replace(fails, friction_coefficient=each) for each in (0.2, high)]
        fixes = verdict_view(replace(result, grips=tuple(grips), measurability=None)).fixes
        brings = next(each.brings for each in fixes if "fixed_force" in each.change)
        assert brings == f"lifts at μ 0.2{price}"
        assert any("object_mass_g" in each.change for each in fixes) == (not price)


def test_a_fix_names_a_material_that_exists_and_reaches_the_target(result):
    remedy = GageRemedy("materials.phosphor_bronze.youngs_modulus_MPa", 135e3, 12e3, 11.0, True)
    view = verdict_view(replace(result, grips=(), measurability=seeing(1.0, remedy)))
    (fix,) = [each for each in view.fixes if "gage signal" in each.brings]
    assert fix.change == 'plates.material = "polyimide"'
    assert fix.effect == "gage signal ✓ (section model)"
    enough = verdict_view(replace(result, measurability=seeing(0.05)))
    assert enough.verdicts[-1].status == "pass"
    assert not [each for each in enough.fixes if "gage" in each.brings]


def test_a_fix_names_a_thickness_that_is_sold(result):
    thinner = GageRemedy("plates.thickness_mm", 0.1, 0.02, 5.0, False)
    metal = {**result.parameters, "plates.material": "phosphor_bronze"}
    found = replace(result, grips=(), parameters=metal, measurability=seeing(1.0, thinner))
    (fix, *_) = [each for each in verdict_view(found).fixes if "thickness" in each.change]
    assert fix.change == "plates.thickness_mm = 0.05"
    assert fix.brings == "signal x 2; x 10 needed"


def test_the_block_fits_its_lines_and_width(result, tmp_path, capsys):
    grips = tuple(replace(each, lifted=False, safety_margin=None) for each in result.grips)
    thinner = GageRemedy("plates.thickness_mm", 0.1, 0.02, 4.0, False)
    long = tuple(f"warning {number} " + "of many words " * 12 for number in range(9))
    found = replace(result, grips=grips, measurability=seeing(5.0, thinner), warnings=long)
    for each in (found, replace(found, status="failed", failure="why " * 300)):
        say_block(verdict_view(each), tmp_path)
        lines = capsys.readouterr().out.splitlines()
        assert len(lines) <= LINES
        assert all(len(line) <= WIDTH for line in lines[:-1])
        assert lines[-1].startswith("report: ")
