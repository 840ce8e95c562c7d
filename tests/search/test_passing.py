"""The search from a design for one that passes: the order of its work, and what it reports."""

import re
from dataclasses import replace
from types import SimpleNamespace

import pytest

from fingerdesign.analysis.shortfall import (
    GRIP_FORCE,
    LIFTS,
    grip_shortfalls,
    shortfalls,
    slip_shortfall,
)
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.shipped import shipped_text
from fingerdesign.errors import DesignError
from fingerdesign.records.outcome import Failure, Outcome
from fingerdesign.records.result import GripResult, Measurability, MeasuredState, SlipStudySummary
from fingerdesign.records.result_files import read_result
from fingerdesign.search.optimise.trials import Trials
from fingerdesign.search.passing.found import SearchStopped, castable, conflicts_of, unready
from fingerdesign.search.passing.freedom import Freedom
from fingerdesign.search.passing.front import front_of
from fingerdesign.search.passing.hands import NO_HAND, Hand
from fingerdesign.search.passing.page import passing_page
from fingerdesign.search.passing.passing import (
    Callbacks,
    Candidate,
    Found,
    _Run,
    evaluated_by,
    find_passing,
    most_trials,
    search_passing,
    study_of,
)
from fingerdesign.search.passing.ranges import PASSING
from fingerdesign.search.passing.space import changes_between, space_of
from fingerdesign.search.run.evaluate import Job, failed
from fingerdesign.search.run.run import Store
from fingerdesign.search.study.file import Cost
from tests.support.passing import outcome


def study(rank, step=0.5):
    return SlipStudySummary(0.5, rank, rank, 1.0, 0.01, step)


def grip(ratio=1.5, margin=1.5, lifted=True):
    force = ratio * 2.4516625 / 0.5
    return GripResult(
        "paper",
        0.5,
        500.0,
        lifted,
        not lifted,
        force,
        2.45,
        margin if lifted else None,
        0.5,
        force,
        0.0,
        10,
    )


def test_shortfall_is_zero_with_room_and_grows_with_what_is_missing():
    assert slip_shortfall([study(0.95), study(0.9)]) == 0.0
    assert slip_shortfall([study(0.95), study(0.5)]) == pytest.approx(0.35)
    assert slip_shortfall([study(0.9, step=0.9)]) == pytest.approx(0.15)  # No better than time.
    assert slip_shortfall([study(None)]) == pytest.approx(0.85)
    assert grip_shortfalls([grip(), grip(2.0)]) == {LIFTS: 0.0, GRIP_FORCE: 0.0}
    assert grip_shortfalls([grip(0.5, lifted=False)])[LIFTS] == pytest.approx(1.5)
    crushing = [grip_shortfalls([grip(ratio)])[GRIP_FORCE] for ratio in (2.9, 4.0, 8.0)]
    assert 0.0 < crushing[0] < crushing[1] < crushing[2]
    assert grip_shortfalls([grip(1.1, margin=1.1)])[GRIP_FORCE] > 0.0


def test_trials_after_the_starts_are_near_the_best(tmp_path):
    """The best start is the last: later draws differ from it by less than from the first."""
    space = space_of(load_design("maeno2000"), Freedom())
    study, starts = study_of(space), space.starts
    first, best = ({**starts[0], "plates.pitch_mm": pitch} for pitch in (0.4, 1.2))
    with Trials(study, space.base, tmp_path / "trials.sqlite", (first, best), space.near) as trials:
        trials.draw(2)
        trials.report(1, [0.5], {})
        trials.report(2, [0.1], {})
        trials.draw(8)
        pitches = [each.values["plates.pitch_mm"] for each in trials.drawn(waiting=True)]
    assert sum(pitch > 0.8 for pitch in pitches) >= 7


def test_share_of_the_gage_area_is_chosen_after_the_analysis(tmp_path):
    """Gages are good at a share of 0.6 alone, which each analysis states."""
    space, shares = space_of(load_design("maeno2000"), Freedom()), []

    def evaluated(plan):
        found = []
        for job in plan:
            share = job.design.gages.area_share
            shares.append(share)
            made = outcome(job.design, abs(share - 0.6), best_area_share=0.6)
            found.append(replace(made, name=job.name, values=dict(job.values), digest=job.digest()))
        return found

    with Trials(study_of(space), space.base, tmp_path / "t.sqlite", space.starts) as trials:
        found = find_passing(space, Freedom(), trials, Callbacks(evaluated, lambda design: None), 2)
    assert shares[-1] == 0.6
    assert all(each.design.gages.area_share == 0.6 for each in found.candidates)


class Bench:
    """Stands in for workers: gages are good from a cover of at most 0.45 mm on."""

    def __init__(self, hand=0.0):
        self.hand, self.parts, self.own_mesh = hand, [], False

    def __call__(self, plan):
        found = []
        for job in plan:
            if isinstance(job, Outcome):
                found.append(job)
                continue
            assert isinstance(job, Job)
            self.parts.append(job.part)
            self.own_mesh |= "mesh.mesher" in job.study_keys
            short = max(0.0, job.design.plates.cover_mm - 0.45)
            made = outcome(job.design, self.hand if job.part == "hand" else short)
            found.append(replace(made, name=job.name, values=dict(job.values), digest=job.digest()))
        return found


def judged(result, ratio):
    """The result of an analysis in which all passes but, above a ratio of 3, the grip force."""
    state = MeasuredState(0.5, 5.0, 2.0, 1.0, 1.5, 0.05, 1.0)
    seen = Measurability(0.5, False, 0.1, (state,))
    return replace(
        result, slip_studies=(study(0.95),), grips=(grip(ratio),), measurability=seen, ladder=None
    )


def searched(tmp_path, confirm, hand=0.0, most=8, **calls):
    design = load_design("maeno2000")
    space, bench = space_of(design, Freedom()), Bench(hand)
    with Trials(study_of(space), space.base, tmp_path / "t.sqlite", space.starts) as trials:
        found = find_passing(space, Freedom(), trials, Callbacks(bench, confirm, **calls), most)
        values = [each.values for each in trials.drawn()]
    assert values[: len(space.starts)] == list(space.starts)
    return found, bench


def passing(space, evaluated, tmp_path, plane_strain):
    """What a search finds of which every whole analysis passes, and the designs of those."""
    confirmed = []

    def confirm(design):
        confirmed.append(design)
        return judged(plane_strain.result, 2.0)

    with Trials(study_of(space), space.base, tmp_path / "t.sqlite", space.starts) as trials:
        found = find_passing(space, Freedom(), trials, Callbacks(evaluated, confirm), 8)
    assert found.passes
    return found, confirmed


def test_search_ends_with_the_first_finger_that_passes(tmp_path, plane_strain):
    confirmed, improved = [], []

    def confirm(design):
        confirmed.append(design)
        return judged(plane_strain.result, 2.0)

    found, bench = searched(tmp_path, confirm, improved=improved.append)
    assert found.passes
    assert not found.conflict
    first, last = improved  # by its gages, then with its hand and as a whole
    assert (first.result, last) == (None, found.best)
    assert first.design.plates == last.design.plates != found.space.base.plates
    assert len(found.tried) == 4
    assert len(confirmed) == 1  # The second trial is the shipped finger.
    assert confirmed[0].plates.cover_mm == load_design(PASSING[0]).plates.cover_mm
    assert set(bench.parts) == {"sensing", "hand"}
    changed = changes_between(load_design("maeno2000"), found.best.design)
    assert changed["plates.material"] == ("phosphor_bronze", "polyimide")
    again, bench = searched(tmp_path, confirm)  # Goes on from its journal: the same finger.
    assert again.best.design == found.best.design


def test_of_fingers_with_good_gages_the_best_correlation_comes_first(tmp_path, plane_strain):
    space, bench, good, confirmed = space_of(load_design("tees"), Freedom()), Bench(), {}, []

    def evaluated(plan):
        found = bench(plan)
        for k, job in enumerate(plan):
            if job.part == "sensing":
                place = good.setdefault(job.design.plates.pitch_mm, len(good))
                metrics = {"shortfall": 0.0, "area_correlation": 0.86 + 0.03 * (place % 3)}
                found[k] = replace(found[k], metrics=found[k].metrics | metrics)
        return found

    def confirm(design):
        confirmed.append(design.plates.pitch_mm)
        return judged(plane_strain.result, 2.0)

    with Trials(study_of(space), space.base, tmp_path / "t.sqlite", space.starts) as trials:
        assert find_passing(space, Freedom(), trials, Callbacks(evaluated, confirm), 4).passes
    assert [good[pitch] for pitch in confirmed] == [2]


@pytest.mark.slow
def test_a_dome_takes_the_share_that_suits_the_dome_not_its_arc(tmp_path, plane_strain):
    """Arcs of it are good with a share of 0.5, the dome itself nearly, with 0.4 alone."""
    space, arcs = space_of(load_design("domed"), Freedom()), Bench()

    def evaluated(plan):
        found = arcs(plan)
        for k, job in enumerate(plan):
            if job.part == "sensing" and job.design.body.shape == "dome":
                short = {"shortfall": 0.03 + (job.design.gages.area_share != 0.4)}
                metrics = found[k].metrics | short | {"best_area_share": 0.4}
                found[k] = replace(found[k], metrics=metrics)
        return found

    found, confirmed = passing(space, evaluated, tmp_path, plane_strain)
    assert confirmed[0].gages.area_share == found.best.design.gages.area_share == 0.4


@pytest.mark.slow
def test_a_dome_that_falls_short_everywhere_is_judged_by_its_nearest(tmp_path, plane_strain):
    """The search gives up after so many domes, then searches a hand for the best one."""
    space, arcs = space_of(load_design("domed"), Freedom()), Bench()
    short, confirmed = set(), []

    def evaluated(plan):
        found = arcs(plan)
        for k, job in enumerate(plan):
            if isinstance(job, Job) and job.part == "sensing" and job.design.body.shape == "dome":
                short.add(job.design.plates.cover_mm)
                made = found[k].metrics | {"shortfall": job.design.plates.cover_mm}
                found[k] = replace(found[k], metrics=made)
        return found

    def confirm(design):
        confirmed.append(design)
        return judged(plane_strain.result, 3.5 if len(confirmed) == 1 else 2.0)

    with Trials(study_of(space), space.base, tmp_path / "t.sqlite", space.starts) as trials:
        found = find_passing(space, Freedom(), trials, Callbacks(evaluated, confirm), 48)
    assert len(short) > 1
    assert confirmed[0].plates.cover_mm == min(short)
    assert found.passes  # With the hand that was searched again on its own mesh.


@pytest.mark.slow
@pytest.mark.parametrize("keep", [(), ("body.shape",)])
def test_an_arc_replaces_a_body_of_which_none_passes(tmp_path, plane_strain, keep):
    """Arcs pass and pins do not: the user learns it, unless he keeps the shape."""
    design, arcs, pins, reports = load_design("pin"), Bench(), [], []

    def evaluated(plan):
        found = arcs(plan)
        for k, job in enumerate(plan):
            if isinstance(job, Job) and job.design.body.shape == "revolved":
                pins.append(job.design)
                found[k] = replace(found[k], metrics=found[k].metrics | {"shortfall": 0.7})
        return found

    found = search_passing(
        design,
        Freedom(keep=keep),
        tmp_path / "t.sqlite",
        Callbacks(evaluated, lambda design: judged(plane_strain.result, 2.0), reports.append),
    )
    if keep:
        assert len(pins) > 6
        assert (found.space.given_up, found.given_up) == ((), "")
        return
    assert len(pins) <= 6
    assert found.passes
    assert found.best.design.body.shape == "arc"
    assert "no finger passes with your body.shape" in reports
    assert "with your body.shape, so this was given up" in found.given_up
    assert "--keep body.shape" in passing_page(design, found)


def test_a_damaged_second_journal_is_found_before_the_first_trial(tmp_path):
    (tmp_path / "t.plainer.sqlite").write_text("no journal")
    never = pytest.fail
    with pytest.raises(DesignError, match="a journal of trials"):
        search_passing(
            load_design("pin"), Freedom(), tmp_path / "t.sqlite", Callbacks(never, never)
        )


@pytest.mark.slow
def test_a_finger_that_is_no_sensor_as_cast_is_reported_with_the_remedy(tmp_path, plane_strain):
    narrow = load_design("narrow")
    words = unready(narrow)
    assert "no gage that is sold fits" in words
    assert 'Remedy: add mold.gage = "sputtered_film", mold.leads = "leg".' in words
    assert unready(with_values(narrow, {"mold.gage": "sputtered_film", "mold.leads": "leg"})) == ""
    good = judged(plane_strain.result, 2.0)
    calls = Callbacks(Bench(), lambda design: good, unready=lambda design: words)
    assert words in search_passing(narrow, Freedom(), tmp_path / "t.sqlite", calls).note


def test_a_search_that_stops_in_the_last_step_has_its_finger(tmp_path, plane_strain):
    def interrupted(design):
        raise KeyboardInterrupt

    good = judged(plane_strain.result, 2.0)
    calls = Callbacks(Bench(), lambda design: good, unready=interrupted)
    with pytest.raises(SearchStopped) as stopped:
        search_passing(load_design("maeno2000"), Freedom(), tmp_path / "t.sqlite", calls)
    found = stopped.value.found
    assert found.passes
    assert not found.conflict


@pytest.mark.slow
@pytest.mark.parametrize("in_arcs", [False, True])
def test_an_interrupted_search_reports_what_it_has(tmp_path, in_arcs):
    """Ctrl-C in the second batch of pins, or before the first trial of the arc that replaces it."""
    design, jobs, bench, arcs = load_design("pin"), [], Bench(), []

    def evaluated(plan):
        jobs.extend(plan)
        if arcs if in_arcs else len(jobs) > 4:
            raise KeyboardInterrupt
        found = bench(plan)
        poor = {"shortfall": 0.7, "area_correlation": 0.1}
        return [replace(each, metrics=each.metrics | poor) for each in found]

    def report(words):
        if "no finger passes" in words:
            arcs.append(words)

    calls = Callbacks(evaluated, pytest.fail, report)
    with pytest.raises(SearchStopped) as stopped:
        search_passing(design, Freedom(), tmp_path / "t.sqlite", calls)
    found = stopped.value.found
    assert not found.passes
    assert len(found.tried) == (20 if in_arcs else 4)
    assert found.conflict.startswith(f"Stopped after {len(found.tried)} trials. Slip sensing fails")
    page = passing_page(design, found)
    assert "Why none passes" in page
    assert "Changed keys" in page


def test_a_search_that_stops_among_its_trials_has_the_best_of_them(tmp_path):
    bench, improved = Bench(), []

    def evaluated(plan):
        if improved:
            raise KeyboardInterrupt
        poor = {"shortfall": 0.7, "area_correlation": 0.1}
        return [replace(each, metrics=each.metrics | poor) for each in bench(plan)]

    calls = Callbacks(evaluated, pytest.fail, improved=improved.append)
    with pytest.raises(SearchStopped) as stopped:
        search_passing(load_design("maeno2000"), Freedom(), tmp_path / "t.sqlite", calls)
    assert [stopped.value.found.best] == improved
    assert "Changed keys" in passing_page(load_design("maeno2000"), stopped.value.found)


def test_a_search_that_stops_in_a_whole_analysis_does_not_blame_the_hand(tmp_path):
    with pytest.raises(SearchStopped) as stopped:
        searched(tmp_path, lambda design: (_ for _ in ()).throw(KeyboardInterrupt))
    found = stopped.value.found
    assert "not yet analysed as a whole: 1" in found.conflict
    assert "No hand" not in found.conflict
    (each,) = found.candidates
    for short, waits in ((0.03, True), (0.05, False)):  # 0.04 are analysed as a whole
        near = replace(found, candidates=(replace(each, hand=replace(each.hand, shortfall=short)),))
        assert ("not yet analysed" in " ".join(conflicts_of(near))) is waits
    # Where no load is reached at which gages respond, their signal is not judged.
    unjudged = [
        replace(each, outcomes=(replace(o, metrics=o.metrics | {"smallest_stick_change": None}),))
        for each in found.tried
        for o in each.outcomes
    ]
    stated = " ".join(conflicts_of(replace(found, tried=tuple(unjudged))))
    assert "No trial could be analysed" not in stated


@pytest.mark.slow
@pytest.mark.parametrize("cast", [True, False])
def test_fingers_that_can_be_cast_come_first(tmp_path, plane_strain, cast):
    """Plates in proportion to a narrow finger follow best, but no mold has webs for them."""
    space, bench = space_of(load_design("narrow"), Freedom()), Bench()

    def evaluated(plan):
        found = bench(plan)
        for k, job in enumerate(plan):
            cover = job.design.plates.cover_mm
            metrics = found[k].metrics | {"area_correlation": 1.2 - cover}
            if not cast and cover > 0.3:
                metrics["shortfall"] = 0.5
            found[k] = replace(found[k], metrics=metrics)
        return found

    found, confirmed = passing(space, evaluated, tmp_path, plane_strain)
    assert castable(confirmed[0]) == found.castable == cast
    assert confirmed[0].plates.cover_mm == (0.4 if cast else 0.25)
    assert ("No mold" in passing_page(load_design("narrow"), found)) != cast
    # A block had no arc, whatever the default of the key is.
    row = re.compile(r"<tr>(?:(?!<tr>).)*arc_radius_mm.*?</tr>", re.S)
    pages = [passing_page(load_design(name), found) for name in ("block", "maeno2000")]
    arcs = [re.findall(r">([^<>]+)<", row.search(page)[0])[1] for page in pages]
    assert arcs == ["–", "50"]


@pytest.mark.slow
def test_a_core_is_given_up_where_no_gages_are_good_with_it(tmp_path, plane_strain):
    design, bench, trials = load_design("boned"), Bench(), []

    def evaluated(plan):
        found = bench(plan)
        for k, job in enumerate(plan):
            if isinstance(job, Job) and job.design.body.core is not None:
                trials.append(job.name)
                found[k] = replace(found[k], metrics=found[k].metrics | {"shortfall": 0.3})
        return found

    def confirm(design):
        return judged(plane_strain.result, 2.0)

    found = search_passing(design, Freedom(), tmp_path / "t.sqlite", Callbacks(evaluated, confirm))
    assert len({*trials}) == 20
    assert found.passes
    assert found.best.design.body.core is None
    assert found.space.given_up == ("body.core",)
    good = outcome(design, 0.0)
    assert space_of(design, Freedom()).plainer(Freedom(), [good]).given_up == ("body.core",)
    shape = {"body.shape": "dome", "body.dome_radius_mm": 30.0}
    dome = space_of(with_values(design, shape), Freedom())
    assert dome.plainer(Freedom()).given_up == ("body.shape", "body.core")
    cored = dome.plainer(Freedom(), [replace(good, values=dome.starts[0])])
    assert cored.given_up == ("body.shape",)
    assert cored.base.body.core is not None
    assert space_of(load_design("maeno2000"), Freedom()).plainer(Freedom()) is None


def test_hand_that_fails_on_the_own_mesh_is_searched_there(tmp_path, plane_strain):
    results = iter([judged(plane_strain.result, 3.5), judged(plane_strain.result, 2.0)])
    found, bench = searched(tmp_path, lambda design: next(results))
    assert found.passes
    assert bench.own_mesh  # Its jobs keep the design's own sizes.


def test_nearest_hand_is_judged_as_a_whole_where_none_has_room_to_spare(tmp_path, plane_strain):
    """Hands are short of the room by a little; the verdict itself passes."""
    found, _ = searched(tmp_path, lambda design: judged(plane_strain.result, 2.0), hand=0.05)
    assert found.passes
    assert found.best.hand.shortfall == 0.05


@pytest.mark.slow
def test_conflicts_are_reported_where_none_passes(tmp_path, plane_strain):
    found, _ = searched(tmp_path, lambda design: judged(plane_strain.result, 4.0), hand=1.0)
    assert not found.passes
    assert "grip force" in found.conflict
    assert "noise" not in found.conflict
    noisy = with_values(found.space.base, {"grip.hardware.gage_noise_microstrain": 0.5})
    noisy_space = replace(found.space, base=noisy)
    assert "noise in grip.hardware" in " ".join(conflicts_of(replace(found, space=noisy_space)))
    pairs = [(0.9, 0.3), (0.6, 0.05), (0.5, None)]
    tried = tuple(
        replace(each, outcomes=(seen(*pair),))
        for each, pair in zip(found.tried, pairs, strict=False)
    )
    page = passing_page(load_design("maeno2000"), replace(found, tried=tried))
    for words in (
        *("Why none passes", "plates.material", "exclude each other"),
        *("front: slip sensing against gage signal", "shortfall of the hand"),
        *("with steps ±5", "(MPa)", "lack one of the two, 1 of 3."),
    ):
        assert words in page


@pytest.fixture(scope="module")
def space():
    return space_of(load_design("film_tees"), Freedom())


def of_finger(space, short=0.0, result=None):
    """A candidate with a hand of that shortfall; None: it has no hand."""
    hand = NO_HAND if short is None else Hand({}, short, 0.0)
    return Candidate(space.base, outcome(space.base, 0.0), hand, result)


def run_of(space, *candidates, last=True, confirm=pytest.fail, evaluated=pytest.fail, keep=()):
    calls = Callbacks(evaluated, confirm)
    return _Run(space, Freedom(keep=keep), None, calls, last, candidates=list(candidates))


def test_the_best_finger_is_one_analysed_as_a_whole_of_which_least_fails(space, plane_strain):
    crushes, good = (judged(plane_strain.result, ratio) for ratio in (4.0, 2.0))
    every = [of_finger(space, *each) for each in ((0.0, crushes), (0.03, good), (0.0, None))]
    assert run_of(space, *every)._ended().best is every[1]
    assert run_of(space, every[0], every[2])._ended().best is every[0]
    near, far = of_finger(space, 0.1), of_finger(space, 0.3)
    run = run_of(space, far, near, far, confirm=lambda design: good)
    run._judge_nearest()
    found = [(each.hand.shortfall, each.result is good) for each in run.candidates]
    assert found == [(0.3, False), (0.3, False), (0.1, True)]


def test_a_search_gives_up_after_four_whole_analyses_or_eight_hands(space, plane_strain):
    whole, hand = of_finger(space, 0.0, plane_strain.result), of_finger(space, 1.0)
    short = of_finger(space, None)
    for few in ([whole] * 3, [hand] * 7, [hand] * 6 + [short] * 3):
        assert not run_of(space, *few)._given_up()
        assert run_of(space, *few, few[-1])._given_up()
    assert [run_of(space, *[short] * 4, last=last)._given_up() for last in (True, False)] == [0, 1]


def test_a_finger_is_analysed_as_a_whole_where_its_hand_has_half_the_room(space, plane_strain):
    poor = replace(judged(plane_strain.result, 2.0), slip_studies=(study(0.1),))
    for bench, whole in ((Bench(0.03), True), (Bench(0.05), False)):
        run = run_of(space, evaluated=bench, confirm=lambda design: poor, keep=("grip",))
        found = run._gripped(space.base, outcome(space.base, 0.0), whole=False)
        assert (found.result is poor, found.hand.shortfall) == (whole, bench.hand)
        assert not bench.own_mesh  # Its gages fail: no other hand mends that.


def test_another_share_is_tried_where_gages_are_short_and_taken_where_it_is_better(space):
    shorts, asked = {0.5: (0.0, 0.0), 0.6: (0.5, 0.2), 0.7: (0.5, 0.6)}, []

    def evaluated(jobs):
        found = []
        for job in jobs:
            again = job.design.gages.area_share == 0.7
            asked.extend([job.values["cover"]] * again)
            made = outcome(job.design, shorts[job.values["cover"]][again], best_area_share=0.7)
            found.append(replace(made, values=job.values))
        return found

    plan = [Job("a", space.base, Cost(), {"cover": cover}) for cover in shorts]
    for keep, expected in ((), [0.0, 0.2, 0.5]), (("gages.area_share",), [0.0, 0.5, 0.5]):
        found = run_of(space, evaluated=evaluated, keep=keep)._with_best_share(plan)
        assert [each.metrics["shortfall"] for each in found] == expected
        assert ("gages.area_share" in found[1].values) is not bool(keep)
    assert asked == [0.6, 0.7]


def test_jobs_of_a_search_have_its_limit_and_those_that_failed_come_again(space, own_cache):
    asked, job = [], Job("a", space.base, Cost(), {})
    Store().put(ended := failed(job, Failure("timeout", "late")))

    def outcomes(jobs, limits, look):
        asked.append((len(jobs), limits.time_s))
        return [(ended.digest, ended)] * len(jobs)

    for retry in (False, True):
        evaluated_by(SimpleNamespace(threads=1, outcomes=outcomes), retry)([job])
    assert asked == [(0, 900.0), (1, study_of(space).limits.time_s)]


def test_what_fails_of_a_finger_is_named_and_an_unsteady_hand_noted(space, plane_strain):
    good = judged(plane_strain.result, 2.0)
    none = good.parameters | {"plates.model": "none"}
    for result, failing in (
        (good, ()),
        (replace(good, status="failed", failure="no mesh"), ("the analysis failed",)),
        (replace(good, parameters=none, measurability=None), ("nothing was judged",)),
        (judged(plane_strain.result, 4.0), (GRIP_FORCE,)),
        (None, ()),
    ):
        found = of_finger(space, 0.0, result)
        assert (found.failing, found.passes) == (failing, result is good)
        shaky = replace(found, hand=Hand({}, 0.0, 0.2))
        notes = [Found(space, (), (each,), each).note for each in (found, shaky)]
        assert notes[0] == ""
        assert ("sensitive" in notes[1]) is found.passes


def seen(area, change):
    """The outcome of a trial with these two numbers."""
    found = outcome(load_design("feeler"), 0.0)
    return replace(
        found, metrics={"area_correlation": area, "smallest_stick_change": change, "shortfall": 1.0}
    )


def test_the_front_is_of_trials_that_none_is_better_than():
    pairs = [(0.9, 0.3), (0.85, 0.3), (0.82, 0.2), (0.6, 0.05), (0.5, 0.06), (None, 0.01)]
    front = front_of(seen(*pair) for pair in pairs)
    assert front.best == ((0.9, 0.3), (0.82, 0.2), (0.6, 0.05))
    assert front.excludes
    said = front.sentence()
    for words in ("Slip sensing and gage signal exclude each other", "0.82", "0.2", "0.05", "0.60"):
        assert words in said
    both = front_of([seen(0.9, 0.05), seen(0.95, 0.3)])
    assert not both.excludes
    assert "1 of 2 trials reach both" in both.sentence()
    assert not front_of([]).excludes


def test_trials_are_fewer_where_they_need_tetrahedra():
    kept = space_of(load_design("domed"), Freedom(keep=("body.dome_radius_mm",)))
    assert kept.base.body.dome_radius_mm == load_design("domed").body.dome_radius_mm
    flat = space_of(load_design("domed"), Freedom())
    assert flat.base.body.dome_radius_mm == 10.0 * flat.base.body.depth_mm
    assert flat.on_arc(flat.base).body.shape == "arc"
    assert most_trials(kept) < most_trials(flat)
    round_pin = space_of(load_design("pin"), Freedom())
    assert round_pin.base.body.shape == "revolved"
    arc, plates = round_pin.on_arc(round_pin.base), round_pin.base.plates
    assert (arc.body.shape, arc.body.depth_mm) == ("arc", plates.span_mm)
    assert most_trials(round_pin) == most_trials(flat)
    core = {"width_mm": 4.0, "height_mm": 2.0, "depth_mm": plates.span_mm + 0.5}
    cored = with_values(round_pin.base, {f"body.core.{key}": size for key, size in core.items()})
    assert round_pin.on_arc(cored).body.depth_mm == cored.body.depth_mm


# The swept mesh, coarse, and one friction: what the search finds is tested above.


COARSE = """[mesh]
mesher = "sweep"
layers = 1
section = { contact_size_mm = 0.1, plate_size_mm = 0.2, plate_end_size_mm = 0.05 }
"""


@pytest.mark.slow
def test_a_finger_is_searched_from_a_file_and_its_comments_stay(tmp_path, terminal):
    text = shipped_text("film_tees").replace('"polyimide"', '"phosphor_bronze"', 1)
    text = text[: text.index("[mesh]")].replace("[0.2, 0.3, 0.8]", "[0.3]", 1) + COARSE
    path = tmp_path / "mine.toml"
    (tmp_path / "design.schema.json").touch()
    text = text.replace("#:schema ../fingerdesign/data", "#:schema .", 1)
    path.write_text(text.replace('name = "film_tees"', 'name = "mine"', 1), encoding="utf-8")
    few = ("--trials", 1, "--workers", 1)
    printed = terminal("optimise", path, "--out", tmp_path / "out", *few).out
    assert "all 4 pass" in printed
    assert "next: fingerdesign mold" in printed
    assert "analysed before" not in printed
    written = (tmp_path / "out" / "mine-optimised.toml").read_text("utf-8")
    assert "fingerdesign optimise" in written.splitlines()[0]
    assert written.splitlines()[1] == text.splitlines()[0]
    assert "#:schema ../design.schema.json" in written
    assert "polyimide" in written
    result = read_result(tmp_path / "out" / "mine-optimised")
    assert verdict_view(result).summary == "all 4 pass"
    assert shortfalls(result)["slip sensing"] < 0.05
    assert (tmp_path / "out" / "mine-optimised.html").is_file()
