"""Masses as ranges: what a design may say, what it means for defaults, loads, lifts and metrics."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from fingerdesign.analysis import stages
from fingerdesign.analysis.forecast.lift import lifts
from fingerdesign.analysis.measurable import held_loads
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.checks.load import load_design, parse_design, with_values
from fingerdesign.design.grip import weight_per_finger
from fingerdesign.errors import DesignError
from fingerdesign.search.run.measured import grip_metrics
from tests.support.grips import grip

MASS = "grip.object_mass_g"


def ranged(masses, **values):
    return with_values(parse_design('design.name = "a"'), {MASS: masses, **values})


def test_a_number_stays_what_it_was_and_equal_ends_are_one_mass():
    one = ranged(300.0)
    assert (one.grip.masses_g, one.grip.middle_g) == ((300.0,), None)
    assert ranged([300.0, 300.0]).digest() == one.digest()
    both = ranged([50, 500])
    assert (both.grip.lightest_g, both.grip.heaviest_g) == (50.0, 500.0)
    assert both.grip.middle_g == pytest.approx(158.0)
    assert both.digest() != ranged([50, 501]).digest()


@pytest.mark.parametrize(
    ("masses", "faults"),
    [
        ([500, 50], ["write [50, 500]"]),
        ([0.0, 1e6], ["at least 0.001", "at most 100000"]),
        ([50.0], ["grip.object_mass_g"]),
        ("500", ["a number; remove the quotes"]),
        (float("nan"), ["a finite number"]),
    ],
)
def test_masses_that_are_none_are_refused_with_all_faults(masses, faults):
    with pytest.raises(DesignError) as refused:
        ranged(masses)
    for words in faults:
        assert words in str(refused.value)


def test_the_heaviest_sets_the_travel_and_the_lightest_steps_and_forces():
    light, heavy, both = (ranged(each).grip for each in (50.0, 500.0, [50.0, 500.0]))
    for key in ("max_approach_mm", "fundamental_approach_mm"):
        assert getattr(both, key) == getattr(heavy, key)
    for key in ("preload_mm", "approach_step_mm", "force_floor_N", "hold_force_N", "curve_per_N"):
        assert getattr(both, key) == getattr(light, key)
    assert both.max_steps * both.approach_step_mm > both.max_approach_mm


def test_each_end_is_held_and_forecast():
    design = ranged([50.0, 500.0], **{"grip.friction_coefficients": [0.2, 0.8]})
    loads = held_loads(design)
    least = weight_per_finger(50.0) * 1.5 / 0.8
    most = weight_per_finger(500.0) * 1.5 / 0.2
    assert min(force for _, force in loads) == pytest.approx(least)
    assert max(force for _, force in loads) == pytest.approx(most)
    assert {each.object_mass_g for each in lifts(design)} == {50.0, 500.0}


def test_a_tug_must_leave_the_lightest_object_where_it_is():
    tug = [{"step_after_lift": 1, "extra_force_N": -2.0}]
    values = {"grip.plant": "lift", "grip.hold_steps": 9, "grip.tugs": tug}
    ranged([300.0, 500.0], **values)
    with pytest.raises(DesignError, match="lift a heavier object"):
        ranged([100.0, 500.0], **values)


def lifted(monkeypatch, outcomes):
    """Masses that are lifted, where grips of a mass end with a margin of ``outcomes``."""
    tried = []

    def episodes(rig, frictions, mass_g, *more):
        tried.append(mass_g)
        ratio = outcomes.get(mass_g, 1.5)
        found = grip(ratio, object_mass_g=mass_g, safety_margin=ratio)
        return [SimpleNamespace(result=found, trace=None)]

    monkeypatch.setattr(stages, "run_episodes", episodes)
    design = ranged([50.0, 500.0])
    case = SimpleNamespace(
        design=design,
        runs_grips=True,
        estimator=None,
        for_page=True,
        surface=None,
    )
    return [
        g.object_mass_g for g, _ in stages.run_grips(case, SimpleNamespace(problem=None))
    ], tried


def test_the_middle_is_lifted_only_where_it_decides(monkeypatch):
    assert lifted(monkeypatch, {}) == ([50.0, 158.0, 500.0], [50.0, 500.0, 158.0])
    assert lifted(monkeypatch, {50.0: 4.0})[1] == [50.0, 500.0]  # It fails whatever lies between.


def of_masses(result, *pairs):
    """A result whose grips of (mass, times the least force) all lifted."""
    grips = tuple(
        grip(ratio, object_mass_g=mass, safety_margin=ratio, friction_coefficient=0.5)
        for mass, ratio in pairs
    )
    return replace(result, grips=grips, measurability=None)


def test_the_verdict_is_that_of_the_worst_mass(plane_strain):
    view = verdict_view(of_masses(plane_strain.result, (50.0, 4.0), (500.0, 1.5)))
    found = {each.name.split()[0]: each for each in view.verdicts}
    assert found["lifts"].name == "lifts 50–500 g"
    assert (found["lifts"].status, found["lifts"].count) == ("pass", "2 of 2 lifts")
    assert (found["grip"].status, found["grip"].count) == ("fail", "crushes 50 g")
    assert "margin 1.5, peak 4.0 x least" in found["grip"].number
    changes = [fix.change for fix in view.fixes]
    assert "grip.object_mass_g = [73, 500]" in changes  # At this force 50 g x 1.1 x 4 / 3.
    thin = verdict_view(of_masses(plane_strain.result, (50.0, 2.0), (500.0, 1.1)))
    assert [each.count for each in thin.verdicts if each.name == "grip force"] == [
        "thin margin 500 g"
    ]


def test_a_preload_that_crushes_a_light_object_has_a_fix(plane_strain):
    result = of_masses(plane_strain.result, (0.5, 9.0), (500.0, 1.5))
    result = replace(result, parameters={**result.parameters, "grip.preload_mm": 0.03})
    (fix,) = [each for each in verdict_view(result).fixes if "preload" in each.change]
    assert 0.0 < float(fix.change.partition("= ")[2]) < 0.03


def test_metrics_are_those_of_the_worst_mass(plane_strain):
    light, heavy = of_masses(plane_strain.result, (50.0, 4.0), (500.0, 1.5)).grips
    both, alone = grip_metrics([light, heavy]), grip_metrics([light])
    assert both["peak_ratio"] == alone["peak_ratio"] == pytest.approx(4.0)
    assert both["least_margin"] == grip_metrics([heavy])["least_margin"]
    assert both["peak_force_N"] == pytest.approx(heavy.peak_normal_force_N)
    dropped = replace(heavy, lifted=False, safety_margin=None)
    assert grip_metrics([light, dropped])["grip_success"] == 0.0


def test_shipped_designs_state_one_mass():
    assert load_design("film_tees").grip.masses_g == (500.0,)
