"""What options mean together, and what progress and rows show, without any work."""

import time
from contextlib import suppress

import click
import pytest
from fingerdesign_cli import analyse, check, options, sensing, terminal, trials
from fingerdesign_cli.commands import finger
from fingerdesign_cli.studies import compare
from fingerdesign_cli.terminal import _Pace, part_of

from fingerdesign import load_design
from fingerdesign.errors import DesignError
from fingerdesign.layout.summary import summarise
from fingerdesign.search.compare.read import Comparison, facts_of
from fingerdesign.search.compare.recommend import recommend
from fingerdesign.trials.grid import SEALED_SEED, ControlGrid, Perturbed
from tests.support.any_outcomes import any_outcomes
from tests.support.grips import grip


def test_a_bar_goes_on_between_reports_and_waits_for_what_is_late():
    now, shown = time.monotonic(), []
    for since, expected in ((5.0, (0.6, 5.0)), (100.0, (0.96, 1.0))):
        pace = _Pace(0.2, 10.0, begun=now - 50.0, reported=now - since)
        assert pace.now() == pytest.approx(expected, abs=0.01)
        pace.report(0.3, 10.0)
        assert pace.now()[0] == pytest.approx(expected[0], abs=0.01)  # not set back
    by_pace = _Pace(0.25, None, begun=now - 30.0, reported=now - 10.0)
    assert by_pace.now() == pytest.approx((0.25, 50.0), abs=0.1)
    assert _Pace(0.04, None, begun=now - 30.0).now() == (0.04, None)  # too early to tell
    for done, count in ((1, 4), (0, 1)):
        part_of(lambda *told: shown.append(told), done, count)("solving", 0.5, 9.0)
    assert shown == [("solving", 0.375, None), ("solving", 0.5, 9.0)]


def test_limits_stand_behind_a_command_too_and_not_behind_two_dashes(calls_of, terminal):
    limited = calls_of(options, "limited")
    terminal("list", "--time-limit", "70", "--debug", "designs", "--memory-limit=99999", "gages")
    assert [given for given, _ in limited] == [(70.0,), ()]
    terminal("list", "--", "--debug", code=2)


def test_an_accuracy_takes_the_model_that_reaches_it():
    given = [([], None, "3d"), ([], 0.05, "auto"), (["--fidelity=auto"], 0.05, "auto")]
    for words, accuracy, found in (*given, (["--fidelity=3d"], 0.05, None)):
        with finger.analyse.make_context("analyse", ["maeno2000", *words]) as context:
            run = analyse.Run(None, context.params["fidelity"], accuracy, "sweep", True)
            if found is None:
                with pytest.raises(click.UsageError, match="--accuracy"):
                    run.model()
                continue
            case = run.case(load_design("maeno2000"), None)
        assert (case.fidelity, case.tolerance) == (found, accuracy or analyse.TOLERANCE)
        assert (case.go_on, case.design.mesh.mesher, case.mesh_error) == (True, "sweep", True)


def test_a_row_of_grips_says_how_it_ended_and_what_was_warned_of():
    cases = {"lifted": {}, "slips": {"gross_slip": True}, "not lifted": {"lifted": False}}
    cases["caught"] = {"caught": True, "gross_slip": True}
    assert [analyse._row(grip(**each))[2] for each in cases.values()] == [*cases]
    numbers = {"holds": 4, "stick_error": 0.1234, "lead_s": 0.15, "lead_force_share": 0.9}
    row = analyse._row(grip(**numbers, alarms=3, false_alarms=1))
    shown = "0.15 s before, 90 % F_t; 1 of 3 false"
    assert row == ["100", "0.3", "lifted", "2.00", "1.30", "0.50", "4", "0.123", shown]


def axes(**given):
    none = dict.fromkeys(("sealed", "quick", "no_tug", "perturbed"), False)
    none |= dict.fromkeys(("frictions", "masses", "noises", "faults"), ())
    return trials.Axes(**none | {"seed": 0, "plants": None, "lifts": None} | given)


def test_the_axes_of_a_study_are_the_options_else_as_usual():
    own = axes(frictions=(0.3, 0.4), masses=(100.0,), noises=(1.0,), seed=7).grid()
    assert (own.frictions, own.masses_g, own.noises, own.seed) == ((0.3, 0.4), (100.0,), (1.0,), 7)
    assert (own.tug, axes(no_tug=True).grid().tug) == (ControlGrid().tug, None)
    assert axes(quick=True).grid() == ControlGrid.quick()
    assert {axes(sealed=True, perturbed=k).grid().seed for k in (0, 1)} == {SEALED_SEED}
    drawn = axes(perturbed=True, faults=("tilt",), lifts=3, seed=5, quick=True).grid()
    assert (drawn.perturbed, drawn.seed) == (Perturbed(("tilt",), plants=4, lifts=3), 5)
    for each in ({"faults": ("tilt",)}, {"plants": 2}, {"lifts": 3}, {"sealed": True, "seed": 1}):
        with pytest.raises(DesignError):
            axes(**each).grid()


def test_targets_take_their_own_options_alone():
    cases = [({"fidelity": "3d"}, {"fmu-plant"}), ({"flex_mm": 1.0}, {"mjcf"})]
    cases += [({"densities": (("x", 1.0),)}, {"mjcf", "urdf"}), ({"noise": 0.5}, {"c", "fmu"})]
    for option, takers in (*cases, ({}, {"c", "fmu"})):  # the last: an estimator
        none, taken = {"noise": None, "densities": (), "fidelity": None, "flex_mm": None}, set()
        for to in ("c", "fmu", "fmu-plant", "mjcf", "urdf"):
            with suppress(click.UsageError):
                sensing._refuse_target(sensing.Target(to=to, **none | option), not option)
                taken.add(to)
        assert taken == takers


def test_columns_of_distances_are_under_their_headings(calls_of):
    shown = calls_of(terminal, "print_table")
    found = summarise(load_design("maeno2000"))
    check._show([found], "")
    ((_, headings, (row,)), _), *_ = shown
    by_heading = dict(zip(headings, row, strict=True))
    assert float(by_heading["side"]) == pytest.approx(found.least_side_mm, abs=6e-3)
    assert float(by_heading["base"]) == pytest.approx(found.least_base_mm, abs=6e-3)


def test_columns_of_compared_designs_are_under_their_headings(calls_of):
    made = any_outcomes(12)
    facts = facts_of("made", made)
    best = recommend(made, facts.objectives, facts.constraints)
    shown = calls_of(terminal, "print_table")
    compare._show_designs(Comparison(made, facts), best)
    ((_, headings, rows, *_), _), *_ = shown
    for name, standing, *cells in rows:
        (own,) = (each for each in made if each.name == name)
        assert standing not in cells
        error = dict(zip(headings[2:], cells, strict=True))["stick error"]
        assert float(error.split()[0]) == pytest.approx(own.metrics["stick_error"], rel=1e-2)
