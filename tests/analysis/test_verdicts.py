"""Verdicts and fixes of a result, and the block of the terminal that shows them."""

from dataclasses import replace

import pytest
from fingerdesign_cli.terminal import LINES, WIDTH, print_table, say_block, shortened

from fingerdesign.analysis.verdicts import best_area_share, verdict_view
from fingerdesign.records.result import (
    GageRemedy,
    Measurability,
    MeasuredState,
    SlipStudySummary,
)


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


def test_a_margin_just_below_the_target_is_not_rounded_to_it(result):
    grip = replace(result.grips[0], lifted=True, gross_slip=False)
    grip = replace(grip, peak_normal_force_N=1.3 / grip.peak_ratio * grip.peak_normal_force_N)
    for margin, words in (
        (1.165, "margin 1.16, peak"),
        (1.199, "margin 1.19, peak"),
        (1.24, "margin 1.2, peak"),
    ):
        own = replace(result, grips=(replace(grip, safety_margin=margin),), measurability=None)
        found = {each.name: each.number for each in verdict_view(own).verdicts}
        assert found["grip force"].startswith(words)


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


def failing(result, *frictions, lifted=(), **facts):
    """The result with grips at these friction coefficients that slip, and lifts at others."""
    fails = replace(result.grips[0], lifted=False, safety_margin=None, outcome="complete slip")
    grips = [replace(fails, friction_coefficient=each, **facts) for each in frictions]
    holds = {"lifted": True, "gross_slip": False, "safety_margin": 1.5}
    grips += [replace(fails, friction_coefficient=each, **holds) for each in lifted]
    return replace(result, grips=tuple(grips), measurability=None)


def test_one_force_for_a_wide_range_of_friction_is_offered_with_its_price(result):
    for high, price in ((0.3, ""), (0.8, ", but grip force ✗ at μ 0.8")):
        fixes = verdict_view(failing(result, 0.2, high)).fixes
        brings = next(each.brings for each in fixes if "fixed_force" in each.change)
        assert brings == f"lifts ✓{price}"
        first = fixes[0].change.startswith("fingerdesign optimise")
        assert first is bool(price)  # A fix that costs another verdict comes after the search.


def test_one_force_holds_what_pulls_most_and_less_mass_is_no_fix_of_what_comes_later(result):
    first = failing(result, 0.5, object_mass_g=150.0, slip_ratio=None)
    later = failing(result, 0.5, object_mass_g=150.0, slip_ratio=None, most_pull_N=4.413)

    def force(found):
        (change,) = (
            each.change
            for each in verdict_view(found).fixes
            if each.change.startswith("grip.fixed_force.force_N")
        )
        return float(change.rpartition("=")[2])

    assert force(later) == pytest.approx(3.0 * force(first), rel=5e-3)  # 450 g after 150
    assert force(later) == pytest.approx(1.5 * 0.5 * 4.413 / 0.5, rel=5e-3)
    assert not [each for each in verdict_view(later).fixes if "object_mass_g" in each.change]


def test_one_force_holds_what_passes_too_and_bears_the_gentlest_where_it_can(result):
    for fails, lifts in ((0.6, 0.3), (0.3, 0.6)):  # a ratio of 2: 1.5 of one is 3 of the other
        found = failing(result, fails, lifted=[lifts])
        fixes = verdict_view(found).fixes
        force = next(each.change for each in fixes if "force_N" in each.change)
        force = float(force.rpartition("=")[2])
        ratios = [force / each.least_force_N for each in found.grips]
        assert 1.2 < min(ratios) < 1.5
        assert max(ratios) < 3.0
        assert next(each.brings for each in fixes if "controller" in each.change) == "lifts ✓"


def lighter(result, grips, seen, hand="fixed_force"):
    """What is brought by each lighter object that is proposed; the gages see so much of 200 g."""
    grips = tuple(replace(each, controller=hand) for each in grips)
    state = replace(seeing(seen).states[0], tangential_force_N=0.981)
    found = replace(seeing(seen), states=(state,))
    fixes = verdict_view(replace(result, grips=grips, measurability=found)).fixes
    return [each.brings for each in fixes if "object_mass_g" in each.change]


def test_a_lighter_object_that_fails_another_verdict_is_not_proposed(result):
    slips = failing(result, 0.2).grips[0]
    slips = replace(slips, peak_normal_force_N=1.2 * slips.least_force_N)  # holds 160 g with 1.5
    other = failing(result, lifted=[0.3]).grips[0]
    found = {}
    for ratio, seen in ((2.0, 0.05), (2.5, 0.05), (2.0, 0.09)):
        squeezed = replace(other, peak_normal_force_N=ratio * other.least_force_N)
        found[ratio, seen] = lighter(result, (slips, squeezed), seen)
    assert list(found.values()) == [["lifts at μ 0.2"], [], []]
    assert lighter(result, (slips,), 0.05, "paper") == []  # It presses a lighter object less.
    for ratio, brings in ((2.0, ["grip force ✓"]), (2.9, [])):
        thin = replace(other, safety_margin=1.1, peak_normal_force_N=ratio * other.least_force_N)
        assert lighter(result, (thin,), 0.05) == brings


def test_a_range_of_masses_begins_where_the_lightest_bears_the_force(result):
    """Six times the least of 50 g is three times, less a tenth, that of 110 g."""
    other = failing(result, lifted=[0.3]).grips[0]
    grips = [replace(other, object_mass_g=mass) for mass in (50.0, 500.0)]
    grips = [
        replace(each, peak_normal_force_N=ratio * each.least_force_N, safety_margin=1.4)
        for each, ratio in zip(grips, (6.0, 1.6), strict=True)
    ]
    fixes = verdict_view(replace(result, grips=tuple(grips), measurability=None)).fixes
    changes = [each.change for each in fixes if "object_mass_g" in each.change]
    assert changes == ["grip.object_mass_g = [110, 500]"]
    follows = result.parameters | {"grip.defaults": "follow"}
    following = replace(result, grips=tuple(grips), measurability=None, parameters=follows)
    assert not any("mass" in each.change for each in verdict_view(following).fixes)


def test_more_steps_name_the_force_that_still_rises(result):
    slow = {"outcome": "steps", "steps": 200, "object_mass_g": 200.0}
    slow["final_tangential_force_N"] = 0.4903  # half of the pull that lifts
    for ratio, price in ((1.4, ""), (1.6, ", but grip force ✗")):
        least = failing(result, 0.5, **slow).grips[0].least_force_N
        found = failing(result, 0.5, peak_normal_force_N=ratio * least, **slow)
        fix = next(each for each in verdict_view(found).fixes if "max_steps" in each.change)
        assert fix.brings == f"lifts at μ 0.5{price}"


def test_a_change_that_is_not_enough_is_left_out_next_to_one_that_is(result):
    material = GageRemedy("materials.phosphor_bronze.youngs_modulus_MPa", 135e3, 12e3, 11.0, True)
    thinner = GageRemedy("plates.thickness_mm", 0.1, 0.02, 5.0, False)
    metal = {**result.parameters, "plates.material": "phosphor_bronze"}
    found = replace(result, grips=(), parameters=metal)
    view = verdict_view(replace(found, measurability=seeing(1.0, material, thinner)))
    changes = [each.change for each in view.fixes]
    assert changes[0] == 'plates.material = "polyimide"'
    assert not [each for each in changes if "thickness" in each]


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


def test_no_word_is_cut_in_lines_and_tables(capsys):
    for length in range(60, 90):
        line = "a " * (length // 2) + "gripping hand"
        shown = shortened(line)
        assert len(shown) <= WIDTH
        assert (
            shown.removesuffix(" ...").split()
            == line.split()[: len(shown.split()) - ("..." in shown)]
        )
    assert len(shortened("/" * 200)) == WIDTH
    print_table("", ["hand", "of"], [["gripping hands " * 8, "x"]], 60)
    shown = capsys.readouterr().out
    assert "…" not in shown
    assert shown.count("gripping") == 8


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


def test_the_area_share_is_chosen_at_the_worst_friction():
    """0.8 is needed, and 0.85 where the step index alone has 0.75."""
    easy = SlipStudySummary(0.2, 0.9, None, 1.0, 0.1, rank_by_share=((0.4, 0.99), (0.6, 0.95)))
    hard = SlipStudySummary(0.8, 0.7, None, 1.0, 0.1, 0.75, rank_by_share=((0.4, None), (0.6, 0.8)))
    assert best_area_share((easy, hard)) == pytest.approx((0.6, 0.05))
    assert best_area_share((easy,)) == pytest.approx((0.4, -0.19))
    assert best_area_share(()) is None


def test_commands_permit_a_controller_of_ones_own(result):
    own = result.parameters | {"grip.controller": "steady:Steady"}
    for parameters, end in ((result.parameters, ".toml"), (own, ".toml --allow-code")):
        failed = replace(failing(result, 0.2), parameters=parameters)
        *_, last = verdict_view(failed, "mine.toml").fixes
        assert last.change.endswith(end)
