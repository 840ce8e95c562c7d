"""Grips judged and summed up, their page, docs/how_to/control.md; made-up grips, no model."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fingerdesign_cli.trials import _show
from scipy.stats import binomtest

from fingerdesign.control.metrics import reaction_steps
from fingerdesign.records.statistics import (
    Share,
    beta_binomial_share,
    clustered_share,
    rms_of,
    share_of,
    spread_of,
)
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.trials.findings import _decided, _interval, findings
from fingerdesign.trials.grid import Cell, ControlGrid
from fingerdesign.trials.record import ControlStudy, control_data, grips_csv
from fingerdesign.trials.summary import fault_summary, summarise
from fingerdesign.trials.tables import main_tables, noise_tables, tug_tables, warning_tables
from tests.support.grips import grip, path_of, trial
from tests.support.pages import run_python

GRID = ControlGrid((0.3, 0.6), (100.0, 200.0), (0.0, 0.5), tug=None)
DROPPED = {"lifted": False, "gross_slip": True, "safety_margin": None, "outcome": "complete slip"}


def study(**controllers):
    """Grips of controllers: what is changed in all of a controller's, and in its last one."""
    outcomes = []
    for name, (every, last) in controllers.items():
        cells = [cell for batch in GRID.batches([name]) for cell in batch]
        for k, cell in enumerate(cells):
            changes = {**every, **(last if k == len(cells) - 1 else {})}
            outcomes.append(trial(cell, **changes))
    return recorded(outcomes, controllers, GRID)


def recorded(outcomes, names, grid, rate=100.0):
    facts = {key: {} for key in ("model", "versions")}
    numbers = {"workers": 1, "peak_memory_MB": 0.0, "seconds": {"whole": 1.0, "grips": 1.0}}
    hardware = {"sample_rate_Hz": rate}
    data = control_data(
        outcomes,
        names,
        grid,
        design="made up",
        digest="0",
        hardware=hardware,
        warning_stick_ratio=0.3,
        **facts,
        **numbers,
    )
    return ControlStudy(data, tuple(outcomes))


def kinds(made):
    return [each.verdict.status for each in findings(made.data)]


def test_all_is_well():
    oracle = {"oracle_1.2": ({"peak_ratio": 1.2}, {})}
    made = study(paper=({"peak_ratio": 2.0}, {}), regulator=({"peak_ratio": 1.4}, {}), **oracle)
    assert kinds(made) == ["note", "pass", "warning", "pass", "pass"]  # four grips decide little
    assert findings(made.data)[0].verdict.number == "regulator"  # as often, at less force
    best = findings(made.data)[-1].detail
    assert "paper, success 100.0 %, median peak 2.00 times" in best  # no oracle: it is given
    made = study(paper=({}, DROPPED), **oracle)
    assert findings(made.data)[0].verdict.number == "paper"  # nor is it the best of those


@pytest.mark.parametrize(
    ("paper", "regulator", "expected"),
    [
        # one grip of four dropped: held 75 %, no more often a success than the rival
        (({"peak_ratio": 2.0}, {}), ({}, DROPPED), ["pass", "fail", "pass", "warning"]),
        (
            ({"peak_ratio": 1.3}, {}),
            ({"peak_ratio": 2.0}, {}),
            ["pass", "warning", "pass", "warning"],
        ),
        (
            ({"peak_ratio": 1.3}, {}),
            ({"peak_ratio": 2.0}, DROPPED),
            ["pass", "fail", "pass", "fail"],
        ),
        (({}, {}), ({"safety_margin": 1.6}, {}), ["pass", "warning", "fail", "warning"]),
        (({}, {}), ({"safety_margin": 1.1}, {}), ["pass", "warning", "fail", "warning"]),
        # The paper's rule is judged without noise, and this one was dropped with it.
        (({}, DROPPED), ({}, {}), ["pass", "warning", "pass", "warning"]),
        ((DROPPED, {}), ({}, {}), ["fail", "warning", "pass", "pass"]),
        (({"peak_ratio": 4.0}, {}), ({}, {}), ["warning", "warning", "pass", "pass"]),
    ],
)
def test_what_is_not_well_is_reported(paper, regulator, expected):
    assert kinds(study(paper=paper, regulator=regulator)) == ["note", *expected]


def test_the_regulator_is_compared_with_the_best_that_knows_no_more():
    every = {"oracle_1.2": ({}, {}), "reactive": (DROPPED, {}), "paper": ({}, DROPPED)}
    made = findings(study(**every, regulator=({}, {})).data)[-1]
    assert made.verdict.target == "paper 75.0 %"


def test_an_interval_says_whether_more_grips_decide():
    words = {(500, 500): "wholly above", (100, 100): "begins", (98, 100): "decide (--plants)"}
    for share, expected in (words | {(50, 100): "wholly below"}).items():
        assert expected in _interval(share_of(*share), "99 %", "--plants")
        status = "warning" if "plants" in _interval(share_of(*share), "", "plants") else "pass"
        assert _decided(share_of(*share)) == ("fail" if expected == "wholly below" else status)


def test_the_table_on_the_terminal_fits_80_columns(capsys):
    made = study(**{name: ({}, DROPPED) for name in CONTROLLERS.names()})
    _show(made, Path("judged"))
    rows = [line for line in capsys.readouterr().out.splitlines() if line[:1] in "┏┃│└"]
    assert len(rows) == 3 + len(CONTROLLERS.names())
    assert max(map(len, rows)) <= 80


WEIGHT = 0.5e-3 * 9.80665 * 200.0


def trace(approach, lift=None):
    """A grip whose normal force is ten times its approach, at mu = 0.5 with 200 g."""
    approach = np.asarray(approach, dtype=float)
    return path_of(10.0 * approach, np.full(len(approach), WEIGHT), approach, 0.5, 200.0, lift)


@pytest.mark.parametrize(
    ("change", "held", "success"),
    [
        ({}, True, True),
        ({"gross_slip": True, "outcome": "complete slip"}, False, False),
        ({"peak_ratio": 3.0}, True, False),
        ({"lifted": False, "outcome": "stage travel"}, False, False),
        ({"outcome": "failed"}, False, False),
    ],
)
def test_success_is_lifted_held_and_not_crushed(change, held, success):
    changed = grip(**change)
    assert (changed.holds_object, changed.success) == (held, success)


def test_reaction_counts_from_the_tug_to_the_first_answer():
    still = [0.1, 0.2] + [0.25] * 10
    made = trace([*still, 0.25, 0.26, 0.27], lift=3)
    # The tug is felt at step 9; steps 10 to 12 do nothing, 13 closes.
    assert reaction_steps(made, 9, 0.005) == 4
    assert reaction_steps(made, 9, 0.015) == 5
    assert reaction_steps(made, 9, 0.05) is None
    assert reaction_steps(made, 99, 0.005) is None
    assert reaction_steps(trace(still), 9, 0.005) is None
    # Felt at the step after the lift, no rate is known before it.
    assert reaction_steps(trace([*still, 0.26, 0.30], lift=11), 12, 0.005) == 1
    # A hand that closes anyway has not answered.
    assert reaction_steps(trace(0.1 + 0.001 * np.arange(40), lift=5), 20, 0.002) is None
    # However tightly it is judged, from two steps on.
    for lift in (5, 18):
        assert reaction_steps(trace(0.1 + 0.001 * np.arange(40), lift=lift), 20, 1e-9) is None
    faster = np.concatenate([0.001 * np.arange(22), 0.021 + 0.003 * np.arange(1, 19)])
    assert reaction_steps(trace(0.1 + faster, lift=5), 20, 0.0035) == 3
    # A hand that was opening and stops has not answered, nor has one that closed before it felt.
    opens = [*(0.3 - 0.001 * np.arange(20)), *[0.281] * 20]
    assert reaction_steps(trace(opens, lift=5), 20, 0.002) is None
    assert reaction_steps(trace([*still, 0.28, 0.28, 0.28], lift=3), 12, 0.005) is None


def test_shares_have_wilsons_interval_and_nothing_has_no_rate():
    for count, of in [(0, 10), (1, 10), (5, 10), (99, 100), (100, 100), (499, 500)]:
        theirs = binomtest(count, of).proportion_ci(0.95, "wilson")
        own = share_of(count, of)
        assert (own.low, own.high) == pytest.approx((theirs.low, theirs.high), abs=1e-7)
    assert share_of(0, 0) == Share(0, 0, None, None, None)
    assert spread_of([None]) is None
    empty = summarise([])
    assert (empty.grips, empty.success.rate, empty.margin_at_lift) == (0, None, None)


def test_a_summary_counts_each_reason():
    tugged = Cell("regulator", 0.3, 100.0, 0.0, tug=0.3)
    every = [
        trial(),
        trial(safety_margin=1.5),
        trial(gross_slip=True, outcome="complete slip"),
        trial(tugged, peak_ratio=4.0, reaction_steps=6),
        trial(lifted=False, safety_margin=None, outcome="failed"),
        trial(lifted=False, safety_margin=None, outcome="stage travel"),
        trial(tugged),
    ]
    reported = summarise(every)
    assert (reported.grips, reported.success.count, reported.held.count) == (7, 3, 4)
    others = reported.dropped, reported.crushed, reported.not_lifted, reported.failed
    assert others == (1, 1, 1, 1)
    assert (reported.margin_at_lift.count, reported.margin_at_lift.most) == (5, 1.5)
    assert (reported.answered.count, reported.answered.of) == (1, 2)
    assert reported.reaction_steps.median == 6


def test_each_spread_is_of_the_grips_that_it_names():
    """Peaks and steps of lifted ones, slips of held ones, answers of lifted ones, margins of all
    or, by fault, of those that succeed."""
    slipped = {"gross_slip": True, "outcome": "complete slip", "slip_distance_mm": 9.0}
    stays = {"lifted": False, "outcome": "stage travel", "safety_margin": None, "peak_ratio": 7.0}
    tugged = Cell("regulator", 0.3, 100.0, 0.0, tug=0.3)
    every = [
        trial(steps=40, steps_to_lift=25, slip_distance_mm=0.1, minimum_stick_ratio=0.2),
        trial(peak_ratio=3.5, safety_margin=3.2, slip_distance_mm=0.2),
        trial(**slipped, peak_ratio=1.6, safety_margin=2.0),
        trial(tugged, **stays, steps_to_lift=99, slip_distance_mm=5.0),
    ]
    found = summarise(every)
    assert (found.peak_ratio.count, found.peak_ratio.most) == (3, pytest.approx(3.5))
    assert found.peak_normal_force_N.most == pytest.approx(3.5 * 0.05 * 9.80665 / 0.3)
    assert (found.steps.least, found.steps.most, found.steps.count) == (25.0, 30.0, 3)
    assert (found.slip_distance_mm.count, found.slip_distance_mm.most) == (2, 0.2)
    assert (found.minimum_stick_ratio.count, found.minimum_stick_ratio.least) == (4, 0.2)
    assert (found.margin_at_lift.count, found.answered.of) == (3, 0)
    by_fault = fault_summary(every, "tilt")
    assert (by_fault.safety_margin.count, by_fault.safety_margin.most) == (1, 1.3)
    # Fingers are counted by fault and number.
    cells = [Cell("regulator", 0.3, 100.0, 0.0, 0.0, *each) for each in (("a", 0), ("b", 0))]
    assert summarise([trial(each) for each in cells * 2], drawn=True).fingers == 2


def test_the_tables_of_the_page_hold_the_summaries_numbers():
    """Of six grips tugged at 50 Hz, a step is 20 ms."""
    cells = [Cell("paper", 0.3, 100.0, 0.5, tug=0.3) for _ in range(6)]
    outcomes = [trial(each, reaction_steps=k) for k, each in enumerate(cells, 2)]
    slip = {**DROPPED, "slip_warning": "standing", "lead_s": 0.05, "lead_force_share": 0.9}
    outcomes += [trial(Cell("paper", 0.3, 100.0, 0.5), **WARNED, **slip)]
    outcomes += [trial(Cell("paper", 0.3, 100.0, 0.0), peak_ratio=2.5, steps_to_lift=12)]
    grid = ControlGrid((0.3,), (100.0,), (0.0, 0.5), tug_noise=0.5)
    data = recorded(outcomes, ["paper"], grid, rate=50.0).data
    (row,) = tug_tables(data)[0].rows
    # Of 2 to 7 steps the median is 4.5, the upper quartile 5.75, the slowest 7.
    assert row[4:7] == ("90 (40 to 140, of 6)", "115", "140")
    (lifts,), (forces,) = (each.rows for each in main_tables(data, 0.0))
    assert lifts[2:4] == ("1", "100.0 (20.7 to 100.0, of 1)")
    assert forces[3:] == ("2.50 (of 1)", "0.50 (of 1)", "0.000 (of 1)", "12 (of 1)")
    assert main_tables(data, 0.5)[0].rows[0][5] == "1"  # dropped
    (warnings,) = warning_tables(data, 0.5)[0].rows
    assert warnings[2:5] == ("0", "0.05 (of 1)", "90 (of 1)")
    assert [each[1] for each in noise_tables(data)[0].rows] == ["100.0 (20.7 to 100.0, of 1)"]


def test_each_number_stands_below_its_heading():
    """One is dropped, two crushed, three not lifted, four failed; six are tugged."""
    stays = {"lifted": False, "safety_margin": None, "outcome": "stage travel"}
    every = [{}] * 5 + [DROPPED] + [{"peak_ratio": 4.0}] * 2 + [stays] * 3
    every += [stays | {"outcome": "failed"}] * 4
    cell = Cell("oracle_1.2", 0.3, 100.0, 0.5)
    outcomes = [trial(cell, **changes) for changes in every]
    every = [{}] * 3 + [{"reaction_steps": 3}] * 2 + [DROPPED]
    outcomes += [trial(replace(cell, tug=0.3), **changes) for changes in every]
    grid = ControlGrid((0.3,), (100.0,), (0.5,), tug_noise=0.5)
    data = recorded(outcomes, ["oracle_1.2"], grid).data
    for table, expected in (
        (main_tables(data, 0.5)[0], ["oracle 1.2", "μ, m", "15", "33.3", "46.7", *"1234"]),
        (tug_tables(data)[0], ["oracle 1.2", "6", "83.3", "40.0"]),
    ):
        found = [each.split(" (")[0] for each in table.rows[0]]
        assert found[: len(expected)] == expected


def test_a_row_of_grips_csv_is_its_cell_and_what_came_of_it():
    own = {"steps": 70, "steps_to_lift": 40, "outcome": "lifted", "ending": "why", "lead_s": 0.7}
    cell = Cell("reactive", 0.3, 100.0, 0.5, 0.2, "tilt", 6)
    made = replace(trial(cell, **own, unsure=True), seed=11)
    head, row = (line.split(",") for line in grips_csv([made]).splitlines())
    assert row[:12] == ["reactive", "0.3", "100.0", "0.5", "0.2", "tilt", "6", "11", *"1100"]
    found = dict(zip(head, row, strict=True))
    named = {"steps": "40", "ending": "lifted", "reason": "why", "unsure": "1", "lead_s": "0.7"}
    assert named.items() <= found.items()


WARNED = {"alarms": 2, "false_alarms": 0, "samples": 50}


def test_warnings_of_slip_are_summed_up_over_grips():
    error = {"stick_error": 0.1, "stick_error_samples": 40}
    slip = {**DROPPED, "slip_warning": "standing", "lead_s": 0.05, "lead_force_share": 0.9}
    every = [
        trial(**WARNED, **error),
        trial(**WARNED | {"false_alarms": 2}, stick_error=0.2, stick_error_samples=10),
        trial(**WARNED, **slip),
        trial(**WARNED, **slip | {"lead_s": 0.11, "lead_force_share": 0.7}),
        trial(**WARNED, **DROPPED, slip_warning="withdrawn"),
        trial(**WARNED, **DROPPED, slip_warning="none"),
        trial(**DROPPED),  # of a hand that never warns
    ]
    found = summarise(every).foreseen
    assert found.warned == share_of(2, 4)
    assert found.withdrawn == 1
    assert (found.lead_s.count, found.lead_s.median) == (2, pytest.approx(0.08))
    assert found.lead_force_share.median == pytest.approx(0.8)
    assert found.falsely_alarmed == share_of(1, 6)
    assert (found.false_alarms.count, found.false_alarms.of) == (2, 300)
    # Both were of one grip: the interval is wider than of two in 300.
    assert found.false_alarms.high > share_of(2, 300).high
    mean = (40 * 0.1**2 + 10 * 0.2**2) / 50
    assert (found.stick_error.count, found.stick_error.samples) == (2, 50)
    assert found.stick_error.value == pytest.approx(np.sqrt(mean))
    assert found.stick_error.low < found.stick_error.value < found.stick_error.high
    assert found.stick_error_of_grips.most == 0.2
    nothing = vars(summarise([trial(), trial(**DROPPED)]).foreseen)
    assert set(nothing.values()) == {None}


@pytest.mark.slow
def test_an_interval_over_fingers_covers_what_one_over_lifts_does_not():
    """25 fingers of four lifts: rates of fingers are from a beta distribution with mean 0.85."""
    rng, of, held = np.random.default_rng(0), [4] * 25, np.zeros(2)
    for _ in range(200):
        counts = rng.binomial(4, rng.beta(0.85, 0.15, 25)).tolist()
        for k, each in enumerate((beta_binomial_share(counts, of), share_of(sum(counts), 100))):
            held[k] += each.low <= 0.85 <= each.high
    # Of 200 intervals with a probability of 95 % 182 or more hold but for once in a hundred times.
    assert held[0] >= 182 > 170 > held[1]


def test_an_interval_over_fingers_of_one_lift_each_is_that_of_lifts_and_ends_are_ends():
    single = beta_binomial_share([1] * 92 + [0] * 8, [1] * 100)
    assert (single.low, single.high) == pytest.approx((0.850, 0.959), abs=2e-3)  # Wilson's
    every = beta_binomial_share([4] * 25, [4] * 25)
    assert (every.rate, every.high) == (1.0, 1.0)
    assert 0.88 < every.low < share_of(100, 100).low
    assert beta_binomial_share([0, 0], [4, 4]).low == 0.0
    assert beta_binomial_share([], []) == beta_binomial_share([0], [0]) == share_of(0, 0)


def test_intervals_cover_what_they_say():
    """Of medians and root mean squares drawn anew 400 times; of shares in grips that are alike."""
    rng = np.random.default_rng(5)
    inside = {"median": 0, "rms": 0, "share": 0}
    for _ in range(400):
        spread = spread_of(rng.exponential(1.0, 15).tolist())
        inside["median"] += spread.median_low <= np.log(2.0) <= spread.median_high
        sizes = rng.uniform(0.5, 1.5, 20)  # grips differ
        own = [np.sqrt((size**2 * rng.standard_normal(30) ** 2).mean()) for size in sizes]
        found = rms_of(own, [30] * 20)
        inside["rms"] += found.low <= np.sqrt(13.0 / 12.0) <= found.high
        rates = rng.beta(1.0, 9.0, 30)
        share = clustered_share(rng.binomial(40, rates).tolist(), [40] * 30)
        inside["share"] += share.low <= 0.1 <= share.high
    assert all(0.92 <= count / 400 <= 0.99 for count in inside.values()), inside
    few = spread_of([1.0, 2.0, 3.0, 4.0, 5.0])
    assert (few.median_low, few.median_high) == (None, None)
    six = spread_of([3.0, 1.0, 2.0, 6.0, 5.0, 4.0])
    assert (six.median_low, six.median_high) == (1.0, 6.0)
    assert rms_of([], []) is None
    assert (rms_of([0.1], [5]).low, rms_of([0.0, 0.0], [5, 5]).high) == (None, 0.0)
    none = clustered_share([0] * 16, [60] * 16)
    assert (none.rate, none.high) == (0.0, pytest.approx(share_of(0, 16).high / 60))
    assert clustered_share([0, 3], [0, 9]) == share_of(3, 9, 1.0)
    # Clusters of one trial each: the sample variance, p (1 - p) / (k - 1).
    assert clustered_share([1, 0, 0, 1, 0], [1] * 5).high == pytest.approx(share_of(2, 5, 4.0).high)


def test_its_python_runs(capsys):
    run_python("how_to/control.md")
    reported = capsys.readouterr().out.split()
    assert float(reported[0]) == 1.0
    assert 1.15 < float(reported[-1]) < 1.3
