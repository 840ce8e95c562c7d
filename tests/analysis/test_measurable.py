"""Whether gages answer enough for their amplifier: the verdict, and what would help."""

from dataclasses import replace

import pytest

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.detection import SEEN, amplifier_noise, measured_states
from fingerdesign.analysis.measurable import _known, _remedies, _search, start_sections
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.grip import HardwareTable
from fingerdesign.design.io import parse_scene
from fingerdesign.design.scene import SceneObject
from fingerdesign.errors import SolverError
from fingerdesign.pipeline import run
from fingerdesign.records.result import MeasuredState
from fingerdesign.search.run.measured import metrics_of
from fingerdesign.search.study.file import Cost


def test_an_amplifiers_noise_in_strain_falls_as_the_gage_factor_rises():
    bare = HardwareTable()
    assert amplifier_noise(bare, 120.0) == pytest.approx(amplifier_noise(bare) / 60.0)
    stated = HardwareTable(gage_noise_microstrain=0.3)  # What a design states stands.
    assert amplifier_noise(stated, 120.0) == pytest.approx(0.3)


def analysed(fidelity="plane-strain", **values):
    """The demo's finger with other values, without grips."""
    design = with_values(load_design("maeno2000"), values)
    return design, run(Case(design, None, fidelity, grips=False, fields=False))


@pytest.fixture(scope="module")
def demo():
    return analysed()


def test_the_demo_s_gages_answer_too_little(demo):
    design, found = demo
    measured = found.result.measurability
    assert (measured.noise_microstrain, measured.noise_stated) == (0.5, False)
    assert all(0.4 < state.response_microstrain_per_N < 2.0 for state in measured.states)
    signal = verdict_view(found.result).verdicts[-1]
    assert (signal.name, signal.status) == ("gage signal", "fail")
    assert metrics_of(design, Cost(), found)["smallest_stick_change"] == pytest.approx(
        measured.smallest_stick_change
    )


@pytest.mark.slow
def test_what_would_help_helps(demo):
    _, found = demo
    softer, thinner = found.result.measurability.remedies
    assert softer.enough
    assert "polyimide" in softer.known
    assert softer.changed < 0.3 * softer.value
    assert not thinner.enough
    assert thinner.gain > 2.0
    changes = [each.change for each in verdict_view(found.result).fixes]
    # The thinnest sheet on sale is not enough, so it is not shown next to a material that is.
    assert changes[0] == 'plates.material = "polyimide"'
    assert not any(each.startswith(thinner.key) for each in changes)
    _, other = analysed(**{softer.key: softer.changed})
    assert other.result.measurability.smallest_stick_change <= 0.1
    assert not other.result.measurability.remedies
    assert verdict_view(other.result).verdicts[-1].status == "pass"


def test_what_is_seen_goes_with_the_stated_noise(demo):
    _, found = demo
    by_state = {"grip.hardware.gage_noise_microstrain": 0.04}
    quiet = analysed(**by_state)[1].result.measurability
    assert quiet.noise_stated
    assert not quiet.remedies
    loud = found.result.measurability
    assert quiet.smallest_stick_change == pytest.approx(0.08 * loud.smallest_stick_change)
    for state in loud.states:
        assert state.smallest_stick_change * state.stick_change_microstrain == pytest.approx(
            SEEN * loud.noise_microstrain
        )
        assert state.smallest_force_change_N * state.response_microstrain_per_N == pytest.approx(
            SEEN * loud.noise_microstrain
        )
        held = state.friction_coefficient * state.normal_force_N / state.tangential_force_N
        assert held == pytest.approx(1.5)  # the margin


def test_a_converter_s_step_counts_as_noise():
    stepped = HardwareTable(gage_noise_microstrain=3.0, quantisation_microstrain=4.0 * 12.0**0.5)
    assert amplifier_noise(stepped) == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("gained", "least", "target", "found"),
    [
        (8.0, 1.0, 4.0, (25.0, 4.0)),  # An eighth gains eight: as 1 / value.
        (8.0, 50.0, 4.0, (50.0, 2.0)),  # The least is the end of it.
        (4.0, 1.0, 4.5, (10.0, 100.0 ** (1.0 / 3.0))),  # 10.48, to two digits
        (0.5, 1.0, 4.0, (12.5, 0.5)),  # It takes away: the trial is all that is known.
    ],
)
def test_a_remedy_goes_as_far_as_its_power_law_says(gained, least, target, found):
    assert _search(100.0, 12.5, gained, least, target) == pytest.approx(found)


def test_loads_out_of_reach_are_left_out(demo):
    _, found = demo
    assert measured_states(found.problem, "both", [(0.5, 1e4)], 0.5) == ()


def remedies(found, loads, smallest=(0.8, 0.2), louder=(1.0, 8.0, 4.0)):
    """Remedies for states of these (friction, F_n), by sections whose gages are so much louder."""
    seen = zip(loads, smallest, strict=True)
    states = [MeasuredState(*load, 0.0, 1.0, 1.0, least, 1.0) for load, least in seen]
    model = found.problem.model
    sections = [
        replace(found.problem, model=replace(model, gage_readout=by * model.gage_readout))
        for by in louder
    ]
    measured = replace(found.result.measurability, states=tuple(states))
    return _remedies(load_design("maeno2000"), measured, sections)


def test_remedies_reach_a_tenth_more_than_the_worst_state_needs(demo):
    """0.8 is eight times what is wanted; a gain of 8 at an eighth: that over 8.8, or the least."""
    reach, beyond = (0.5, 1.0), (0.5, 1e4)
    softer, thinner = remedies(demo[1], [reach, beyond])
    design = demo[0]
    stiff = design.material_of("plates").youngs_modulus_MPa
    assert (softer.value, softer.enough, thinner.enough) == (stiff, True, False)
    assert softer.changed == float(f"{stiff / 8.8:.2g}")
    rubber = design.material_of("body").youngs_modulus_MPa
    assert softer.known == _known(softer.changed, 20.0 * rubber) != ()
    thick = design.plates.thickness_mm
    assert (thinner.value, thinner.changed, thinner.known) == (thick, 0.02, ())
    assert thinner.gain == pytest.approx(4.0)
    for each in remedies(demo[1], [reach, reach], louder=(1, 1, 1)):
        assert (each.enough, each.known, each.gain) == (False, (), pytest.approx(1.0))
    with pytest.raises(SolverError, match="does not reach"):
        remedies(demo[1], [reach, beyond], (0.2, 0.8))


def test_no_sections_are_begun_where_no_remedy_would_be_told():
    design, scene = load_design("maeno2000"), parse_scene("path.increments_mm = [[0.1, 0.0]]")
    law = SceneObject(friction_law="power", friction_exponent=0.3, reference_pressure_MPa=0.1)
    for case in (
        Case(with_values(design, {"plates.count": 0})),
        Case(with_values(design, {"plates.model": "none"})),
        Case(with_values(design, {"plates.rows": [{"along": "z", "count": 3, "cover_mm": 5.0}]})),
        Case(design, surface=law),
        Case(design, scene),
        Case(design, for_page=False),
    ):
        assert start_sections(case) is None
