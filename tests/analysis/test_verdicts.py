"""Verdicts and fixes follow the numbers of a result."""

from dataclasses import replace

import pytest

from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.records.result import GageRemedy, Measurability, MeasuredState

SOUND = [{"safety_margin": 1.3, "gross_slip": False}] * 3
FELL = {"lifted": False, "safety_margin": None, "gross_slip": True, "peak_normal_force_N": 2.4515}


def changed(result, name, changes):
    """The result with the studies, grips or increments of a name changed, each by its own keys."""
    parts = zip(getattr(result, name), changes, strict=False)
    return replace(result, **{name: tuple(replace(part, **keys) for part, keys in parts)})


def correlated(*values, **more):
    return "slip_studies", [{"rank_correlation": value, **more} for value in values]


@pytest.mark.parametrize(
    ("changes", "name", "status"),
    [
        (correlated(0.95, 0.8, 0.9), "slip sensing", "pass"),
        (correlated(0.95, 0.79, None), "slip sensing", "fail"),
        (correlated(0.95, 0.9, None), "slip sensing", "pass"),
        (correlated(0.95, 0.9, -0.1), "slip sensing", "fail"),
        (correlated(None, None, None), "slip sensing", "note"),
        # 0.9 where the step index alone has 0.85 is no merit of the gages.
        (correlated(*[0.9] * 3, step_correlation=0.85), "slip sensing", "fail"),
        (correlated(*[0.9] * 3, step_correlation=0.79), "slip sensing", "pass"),
        (("grips", SOUND), "lifts 200 g", "pass"),
        (("grips", [FELL, *SOUND[1:]]), "lifts 200 g", "fail"),
        (("grips", [{"gross_slip": True}]), "lifts 200 g", "fail"),
        # m g / 2 mu = 1.96 N would hold 200 g at 0.5; five times that crushes.
        (("grips", [{}, {"peak_normal_force_N": 9.807}]), "grip force", "fail"),
        (("grips", [{"safety_margin": 1.1}]), "grip force", "warning"),
    ],
)
def test_a_verdict_follows_the_numbers(plane_strain, changes, name, status):
    found = {
        each.name: each for each in verdict_view(changed(plane_strain.result, *changes)).verdicts
    }
    assert found[name].status == status


def test_nothing_is_judged_where_plates_are_left_out(plane_strain):
    keys = plane_strain.result.parameters | {"plates.model": "none"}
    view = verdict_view(replace(plane_strain.result, parameters=keys))
    assert {each.status for each in view.verdicts} == {"note"}


def test_a_grip_that_fails_has_fixes_of_force_and_approach(plane_strain):
    result = changed(plane_strain.result, "grips", [FELL, *SOUND[1:]])
    keys = result.parameters | {"grip.max_approach_mm": 0.2}
    fixes = [each.change for each in verdict_view(replace(result, parameters=keys)).fixes]
    # m g / 2 mu times 1.5; the model presses by 0.05 mm/N.
    assert "grip.fixed_force.force_N = 4.9" in fixes
    assert "grip.max_approach_mm = 0.29" in fixes
    assert "grip.object_mass_g = 100" in fixes


def test_a_small_gage_signal_has_fixes(plane_strain):
    state = MeasuredState(0.8, 4.6, 2.45, 0.8, 1.4, 1.0, 1.8)
    remedy = GageRemedy("plates.thickness_mm", 0.1, 0.02, 4.3, enough=False)
    found = Measurability(0.5, False, 0.1, (state,), (remedy,))
    view = verdict_view(replace(plane_strain.result, measurability=found))
    signal = view.verdicts[-1]
    assert (signal.name, signal.status, signal.count) == ("gage signal", "fail", "10 x short")
    fixes = [each.change for each in view.fixes]
    assert "plates.thickness_mm = 0.02" in fixes
    assert "grip.hardware.gage_noise_microstrain = 0.05" in fixes


def test_a_scene_has_the_contact_alone(plane_strain, failed):
    bare = replace(plane_strain.result, slip_studies=(), grips=(), measurability=None)
    (contact,) = verdict_view(bare).verdicts
    assert (contact.name, contact.status) == ("contact", "note")
    view = verdict_view(failed.result)
    assert (view.verdicts, view.summary) == ((), "failed")
    assert "plate 4: 62 % missing" in view.failure
