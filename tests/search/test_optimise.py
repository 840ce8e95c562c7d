"""The search on a formula: it learns, goes on where it was stopped, and is confirmed.

Its journal: another's is refused and left as it is. Dominance and hypervolume, by hand and counted.
What an objective depends on. Proposals: test_propose.py.
"""

import json
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fingerdesign.checks.load import with_values
from fingerdesign.errors import DesignError
from fingerdesign.records.outcome import Failure, Outcome
from fingerdesign.search.compare.recommend import fails_purpose
from fingerdesign.search.optimise import words
from fingerdesign.search.optimise.confirm import (
    Judged,
    Optimised,
    confirm,
    front_of,
    judge,
    promising,
    volumes,
)
from fingerdesign.search.optimise.optimise import (
    ABSENT,
    Search,
    Tried,
    refuse_aimless,
    reported,
    searched,
)
from fingerdesign.search.optimise.page import verdict, write_optimised
from fingerdesign.search.optimise.sensitivity import WEAK, sensitivities
from fingerdesign.search.optimise.trials import Trials
from fingerdesign.search.optimise.volume import beats, hypervolume, most_volume
from fingerdesign.search.run.evaluate import Job
from fingerdesign.search.study.file import parse_study
from fingerdesign.search.study.variants import base_design
from tests.support.evaluators import formula_of

STUDY = """
study = { name = "search", base = "maeno2000", count = 8, seed = 5 }
objectives = [{ metric = "stick_error" }, { metric = "peak_force_N" }]
constraints = { grip_success = { at_least = 0.99 } }
optimise = { trials = 16, confirm = 2 }
[parameters]
"body.arc_radius_mm" = { low = 30.0, high = 90.0, log = true }
"plates.material" = ["phosphor_bronze", "polyimide"]
"plates.count" = { low = 9, high = 15, step = 2 }
"plates.length_mm" = { low = 0.6, high = 1.0 }
"plates.angle_deg" = { low = 30.0, high = 60.0 }
"""
# From the nearest the plates are no longer below the surface: some trials are no finger.
TIGHT = STUDY + '"plates.cover_mm" = { low = 0.3, high = 1.0 }\n'


def search_of(text=STUDY):
    study = parse_study(text)
    return Search(study, base_design(study), {"fundamental": None})


class Evaluator:
    """The formula, in this process; ends with an error before a batch of its life."""

    def __init__(self, ends_at=10_000, outcome=formula_of):
        self.batches, self.ends_at, self.outcome = 0, ends_at, outcome
        self.jobs: list[Job] = []

    def __call__(self, plan):
        self.batches += 1
        if self.batches > self.ends_at:
            raise KeyboardInterrupt
        self.jobs += [each for each in plan if isinstance(each, Job)]
        return [each if isinstance(each, Outcome) else self.outcome(each) for each in plan]


def optimise(search, journal, evaluator, trials=None):
    with Trials(search.study, search.base, journal) as journaled:
        return searched(search, journaled, evaluator, trials)


def values_of(tried):
    return [(each.number, each.outcomes[0].values) for each in tried]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The trials of a search that nothing stops, and the bytes of its journal."""
    journal = tmp_path_factory.mktemp("whole") / "trials.sqlite"
    tried = optimise(search_of(), journal, Evaluator())
    return values_of(tried), journal.read_bytes()


@pytest.fixture(scope="module")
def longer(tmp_path_factory, undisturbed):
    """More trials, that go on from those that are done."""
    journal = tmp_path_factory.mktemp("longer") / "trials.sqlite"
    journal.write_bytes(undisturbed[1])
    return optimise(search_of(), journal, Evaluator(), trials=28)


@pytest.mark.slow
@pytest.mark.parametrize(("batches", "drawn"), [(1, 0), (2, 3), (4, 0)])
def test_a_search_that_is_stopped_anywhere_goes_on(tmp_path, undisturbed, batches, drawn):
    """It is stopped at a batch; ``drawn``: trials of the next that were drawn before it ended."""
    search, journal = search_of(), tmp_path / "trials.sqlite"
    with pytest.raises(KeyboardInterrupt):
        optimise(search, journal, Evaluator(ends_at=batches - 1))
    with Trials(search.study, search.base, journal) as trials:
        for trial in trials.drawn(waiting=True):
            trials.report(trial.number, *reported(search.study, plan_of(search, trial)))
        trials.draw(drawn)
    assert values_of(optimise(search, journal, Evaluator())) == undisturbed[0]


def plan_of(search, trial):
    return Evaluator()(search.plan(trial))


def breaks_where_long(job):
    found = formula_of(job)
    if job.design.plates.length_mm < 0.85:
        return found
    return replace(found, status="failed", failure=Failure("crashed", "it crashed"), metrics={})


@pytest.mark.slow
def test_it_learns_what_breaks_and_draws_nothing_that_is_no_finger(tmp_path):
    """Of random values four of ten are no finger, and of those that are four of ten crash. The best
    lie at the border of what crashes."""
    search, evaluator = search_of(TIGHT), Evaluator(outcome=breaks_where_long)
    tried = optimise(search, tmp_path / "j", evaluator, trials=32)
    assert len(evaluator.jobs) == 32
    crashed = [each for each in tried if each.outcomes[0].status == "failed"]
    values, broken = reported(search.study, crashed[0].outcomes)
    assert values == [ABSENT, ABSENT]
    assert broken["failed"] > 0
    every = [judge(search.study, each.outcomes) for each in tried]
    corner = np.array([1.5, 15.0])
    first, both = (
        hypervolume(np.array([own.losses for own in some if own.feasible]), corner)
        for some in (every[:12], every)
    )
    assert both > 1.05 * first
    # The formula's own front under these bounds: length 0.85, angles of more than 35 degrees.
    radius = np.linspace(0.7, 1.4, 50)
    front = np.column_stack([(radius - 1.4) ** 2 + 0.575, 10.0 * (radius - 0.7) ** 2 + 5.75])
    assert both > 0.94 * hypervolume(front, corner)  # 32 random trials: 0.87 to 0.91


def test_where_no_values_are_a_finger_a_trial_costs_nothing(tmp_path):
    text = STUDY + '"plates.cover_mm" = { low = 0.01, high = 0.02 }\n'
    evaluator = Evaluator()
    tried = optimise(search_of(text), tmp_path / "j", evaluator, trials=2)
    assert len(tried) == 2
    assert evaluator.jobs == []
    assert {each.outcomes[0].failure.kind for each in tried} == {"invalid"}


@pytest.mark.slow
def test_the_best_are_confirmed_against_the_reference_of_the_same_model(longer, undisturbed):
    def flattering(job):
        """The reference is good in 3-D, where it was not in plane strain."""
        found = formula_of(job)
        if job.fidelity == "3d" and job.name.startswith("reference"):
            return replace(found, metrics=found.metrics | {"stick_error": 0.0})
        return found

    assert len(longer) == 28
    every = [values for _, values in values_of(longer)]
    assert {values["plates.count"] for values in every} <= {9, 11, 13, 15}
    assert all(30.0 <= values["body.arc_radius_mm"] <= 90.0 for values in every)
    assert values_of(longer)[:16] == undisturbed[0]
    search = search_of()
    honest = confirm(search, longer, Evaluator())
    assert honest.dominating
    assert set(honest.dominating) <= {each.number for each in longer}
    assert len(honest.confirmed) == len(honest.standing) == 2
    assert {each.number for each in honest.confirmed} <= set(honest.front)
    assert {each.fidelity for each in honest.again} == {"plane-strain", "3d"}
    assert honest.volumes[-1] == pytest.approx(1.0)
    assert np.all(np.diff(honest.volumes) >= 0.0)
    stated = verdict(honest)
    name = honest.standing[0].thorough.name
    assert stated[0].startswith(f"{name} dominates the reference, reference-maeno2000-3d, in 3-D")
    assert any("depends most on" in each for each in stated)
    flattered = confirm(search, longer, Evaluator(outcome=flattering))
    assert flattered.standing == ()
    assert "None of the 2 fingers analysed again in 3-D" in verdict(flattered)[0]


def test_a_small_space_is_searched_whole_and_no_further(tmp_path):
    text = """
study = { name = "small", base = "maeno2000", count = 2 }
objectives = [{ metric = "stick_error" }]
optimise = { trials = 9, confirm = 0 }
parameters = { "plates.material" = ["phosphor_bronze", "polyimide"] }
"""
    search = search_of(text)
    tried = optimise(search, tmp_path / "j", Evaluator())
    found = confirm(search, tried, Evaluator())
    assert found.judged[0].losses[0] == found.reference.losses[0]
    assert found.counts()["trials"] == 2
    assert any("all combinations" in each for each in found.sentences())
    names = [each.name for each in found.outcomes]  # one trial is the reference's finger
    assert names == ["reference-maeno2000", "small-0001", "small-0002"]
    again = optimise(search, tmp_path / "j", Evaluator())
    assert values_of(again) == values_of(tried)
    (folder := tmp_path / "folder").mkdir()
    write_optimised(folder, found, text)
    record = json.loads((folder / "study.json").read_text())["optimise"]
    assert record["confirm_fidelity"] == ""
    assert not (folder / "front.png").exists()  # one objective has no plane
    page = (folder / "report.html").read_text()
    assert page.index("better than the reference") < page.index(">recommended<")
    stated = verdict(found)
    assert "No more thorough model confirmed this." in stated
    assert any("2 trials have it, 12 are needed" in each for each in stated)
    study = search.study.model_copy(
        update={"study": search.study.study.model_copy(update={"fidelity": "3d"})}
    )
    found = replace(found, dominating=(1,))
    deep = replace(found, search=replace(search, study=study))
    assert not any("confirmed" in each for each in (*verdict(deep), *deep.sentences()))
    assert (words.tile(found).status, words.tile(deep).status) == ("warning", "pass")
    failing = replace(deep, judged=tuple(replace(each, fails=2) for each in deep.judged))
    assert words.tile(failing).target == "in 3-D, but all fail verdicts"
    assert "But it fails 2 verdicts." in verdict(failing)[0]


def test_the_worst_scene_counts():
    study = search_of().study
    common = {"digest": "d", "name": "n", "values": {}, "design": {}, "fidelity": "plane-strain"}
    scenes = [
        Outcome(**common, scene=scene, status="ok", metrics=metrics)
        for scene, metrics in (
            ("a", {"stick_error": 0.1, "peak_force_N": 9.0, "grip_success": 1.0}),
            ("b", {"stick_error": 0.3, "peak_force_N": 5.0, "grip_success": 0.5}),
        )
    ]
    values, broken = reported(study, scenes)
    assert values == [0.3, 9.0]
    assert broken == {"failed": 0.0, "purpose": 0.0, "grip_success": pytest.approx(0.49)}


def unseen_where_round(job):
    """Gages of fingers of a small radius, which the formula finds good, show nothing."""
    found = formula_of(job)
    unseen = 0.5 if job.design.body.arc_radius_mm < 60.0 else 0.05
    return replace(found, metrics=found.metrics | {"smallest_stick_change": unseen})


@pytest.mark.slow
def test_a_finger_that_fails_its_purpose_is_not_feasible_whatever_else_is_good(tmp_path):
    search, evaluator = search_of(), Evaluator(outcome=unseen_where_round)
    tried = optimise(search, tmp_path / "j", evaluator, trials=32)
    found = confirm(search, tried, evaluator)
    unseen = [own for own in found.judged if own.lacks]
    assert unseen
    assert not any(own.feasible for own in unseen)
    assert not {own.name for own in unseen} & set(found.data()["front_names"])
    for each in tried:  # the rule has one owner
        _, broken = reported(search.study, each.outcomes)
        own = fails_purpose(each.outcomes[0], search.study.constraints)
        assert broken["purpose"] == len(own)
    stated = " ".join(found.sentences())
    assert f"{len(unseen)} trials fail the purpose" in stated
    assert f"gages that can be measured ({len(unseen)})" in stated
    assert found.data()["fail_purpose"] == len(unseen)


def test_dominance_and_what_adds_no_volume():
    own, corner = np.array([1.0, 2.0]), np.array([2.0, 3.0, 4.0])
    assert not beats(own, own)
    assert not beats(own, np.array([0.5, 3.0]))
    worse = np.array([[1.0, 1.0, 1.0], [1.5, 1.0, 1.0], [1.0, 1.0, 1.0], [0.0, 0.0, 4.0]])
    for points, volume in ((worse[:1], 6.0), (worse, 6.0), (np.empty((0, 3)), 0.0)):
        assert hypervolume(points, corner) == pytest.approx(volume)
    front = np.array([[0.0, 0.9], [0.4, 0.4], [0.42, 0.38], [0.9, 0.0]])
    assert most_volume(front, np.ones(2), 1) in ((1,), (2,))
    assert {0, 3} < set(most_volume(front, np.ones(2), 3))  # it spreads
    assert most_volume(np.array([[0.5, 0.5], [2.0, 2.0]]), np.ones(2), 2) == (0,)  # and stops


def judged(name, *losses, feasible=True):
    return Judged(name, np.array(losses), {}, feasible)


A, B, C = judged("a", 1.0, 3.0), judged("b", 2.0, 2.0), judged("c", 3.0, 1.0)
BEHIND, BARRED = judged("d", 3.0, 3.0), judged("e", 0.0, 0.0, feasible=False)


@pytest.mark.parametrize(
    ("reference", "volume"),
    [
        # Squares up to 3.2, a tenth of the front's range beyond its worst end.
        ((2.5, 2.5), (0.04, 0.44, 1.64, 1.84, 1.84)),
        # Squares up to the reference, which is farther.
        ((9.0, 9.0), (36.0, 48.0, 55.0, 61.0, 61.0)),
    ],
)
def test_volumes_grow_trial_by_trial_and_end_where_the_reference_does(reference, volume):
    every = (BEHIND, A, B, C, BARRED)
    found = volumes(every, judged("r", *reference))
    assert found == pytest.approx([each / volume[-1] for each in volume])
    assert volumes((BARRED, BARRED), judged("r", *reference)) == (0.0, 0.0)


def test_the_front_is_of_feasible_fingers_and_the_most_promising_come_first():
    every, reference = (BEHIND, A, B, C, BARRED), judged("r", 2.5, 2.5)
    assert front_of(every) == (1, 2, 3)
    assert [each.dominates(reference) for each in every] == [False, False, True, False, False]
    assert not B.better_in_all(judged("r", 2.0, 2.5))
    assert B.dominates(judged("r", 2.0, 2.5))
    assert B.better_in_all(reference)
    assert not B.dominates(replace(reference, failure="no mesh"))
    # Only b adds volume below the reference; of the others the nearer to the best ends is next.
    assert promising((A, B, judged("f", 4.0, 1.5)), (0, 1, 2), reference, 2) == (1, 0)
    assert promising(every, (1, 2, 3), judged("r", 0.0, 0.0), 1) == (2,)
    assert promising(every, (1, 2, 3), reference, 0) == ()


def test_a_trial_is_judged_by_its_worst_scene_and_its_failures_are_counted():
    study = parse_study(STUDY.replace('metric = "peak_force_N"', 'metric = "least_margin"'))
    common = {"digest": "d", "values": {}, "design": {}, "scene": "a", "fidelity": "plane-strain"}

    def scene(name, error, margin, **more):
        metrics = {"stick_error": error, "least_margin": margin, "grip_success": 1.0}
        return Outcome(**common, name=name, **({"status": "ok", "metrics": metrics} | more))

    def broken(kind):
        return scene("x", 0.1, 1.0, status="failed", failure=Failure(kind, f"it {kind}"))

    found = judge(study, [scene("n", 0.1, 1.2), scene("n", 0.3, 1.4)])
    assert found.losses.tolist() == [0.3, -1.2]
    assert (found.metrics["stick_error"], found.metrics["least_margin"]) == (0.3, 1.2)
    assert (found.feasible, found.failure) == (True, "")
    (key,) = study.constraints  # of constraints, too
    for values in ((1.0, 0.5), (0.5, 1.0)):
        two = [scene("n", 0.1, 1.2, metrics=found.metrics | {key: value}) for value in values]
        assert judge(study, two).metrics[key] == 0.5
    lost = judge(study, [scene("n", 0.1, 1.2), broken("crashed")])
    assert (lost.feasible, lost.failure) == (False, "it crashed")
    assert lost.losses.tolist() == [ABSENT, ABSENT]
    assert set(lost.metrics.values()) == {None}
    assert judge(study, [scene("n", 0.1, None)]).failure == "misses an objective"
    tried = tuple(
        Tried(k, (each,))
        for k, each in enumerate(
            [scene("n", 0.1, 1.0), broken("invalid"), broken("crashed"), broken("timeout")], 1
        )
    )
    own = tuple(judge(study, each.outcomes) for each in tried)
    counts = Optimised(search_of(), tried, own, own[0], (1,), (), (1.0,) * 4).counts()
    assert (counts["trials"], counts["invalid"], counts["failed"]) == (4, 1, 2)
    assert (counts["front"], counts["dominate_reference"], counts["confirmed"]) == (1, 0, 0)


@pytest.mark.parametrize("objectives", [2, 3, 4])
def test_volume_is_the_share_of_points_dominated(objectives):
    rng = np.random.default_rng(objectives)
    points = rng.uniform(size=(12, objectives))
    probes = rng.uniform(size=(40_000, objectives))
    hit = (points[None] <= probes[:, None]).all(axis=2).any(axis=1).mean()
    # Three standard deviations of a count.
    assert hypervolume(points, np.ones(objectives)) == pytest.approx(hit, abs=0.0075)


SMALL = parse_study(
    """
study = { name = "s", base = "maeno2000", count = 8, seed = 5 }
objectives = [{ metric = "cost" }]
parameters = { "plates.count" = [9, 11, 13] }
"""
)
BASE = base_design(SMALL)
HELD = {"failed": 0.0, "purpose": 0.0}  # of a feasible trial


def test_a_refused_study_adds_nothing_to_the_journal(tmp_path):
    journal = tmp_path / "trials.sqlite"
    with pytest.raises(DesignError, match="at least one objective"):
        refuse_aimless(SMALL.model_copy(update={"objectives": ()}), Path("s.toml"))
    with Trials(SMALL, BASE, journal) as trials:
        trials.draw(3)
        trials.report(1, [2.0], HELD)
    whole = journal.read_bytes()
    others = SMALL.model_copy(update={"study": SMALL.study.model_copy(update={"seed": 6})})
    more = SMALL.objectives[0].model_copy(update={"metric": "plates"})
    second = SMALL.model_copy(update={"objectives": (*SMALL.objectives, more)})
    edited = with_values(BASE, {"grip.object_mass_g": 321.0})
    for other, base in ((others, BASE), (second, BASE), (SMALL, edited)):
        with pytest.raises(DesignError, match="setting and version"), Trials(other, base, journal):
            pass
        assert journal.read_bytes() == whole
    with Trials(SMALL, BASE, journal) as trials:
        assert [each.number for each in trials.drawn()] == [1, 2, 3]
        assert [each.number for each in trials.drawn(waiting=True)] == [2, 3]
    assert journal.read_bytes() == whole


def test_what_is_no_journal_is_refused_and_left_alone(tmp_path):
    journal = tmp_path / "trials.sqlite"
    journal.write_text("no journal\n")
    for path in (journal, tmp_path):
        with pytest.raises(DesignError, match="journal of trials"), Trials(SMALL, BASE, path):
            pass
    assert journal.read_text() == "no journal\n"


@pytest.mark.parametrize(
    ("key", "record"),
    [
        ("1", []),
        ("1", {}),
        ("1", {"valuEs": {"plates.count": 9}}),
        ("1", {"values": {"plates.number": 9}}),
        ("1", {"values": {"plates.count": 10}}),
        ("1", {"values": {"plates.count": "9"}}),
        ("1", {"values": {"plates.count": 9}, "objectives": [1.0]}),
        ("1", {"values": {"plates.count": 9}, "objectives": [], "broken": HELD}),
        ("1", {"values": {"plates.count": 9}, "objectives": [1e300], "broken": HELD}),
        ("1", {"values": {"plates.count": 9}, "objectives": [1.0], "broken": {"failed": 0.0}}),
        ("0", {"values": {"plates.count": 9}}),
        ("3", {"values": {"plates.count": 11}}),
        ("one", {"values": {"plates.count": 11}}),
    ],
)
def test_a_journal_with_a_record_of_another_kind_is_refused(tmp_path, key, record):
    """The database is sound; the record is not of this study, or a trial is missing before it."""
    path = tmp_path / "trials.sqlite"
    with Trials(SMALL, BASE, path) as trials:
        trials.draw(1)
        trials.report(1, [2.0], HELD)
    with closing(sqlite3.connect(path)) as base, base:
        base.execute("insert or replace into records values (?, ?)", (key, json.dumps(record)))
    with pytest.raises(DesignError, match="journal of trials"), Trials(SMALL, BASE, path):
        pass


def test_what_failed_and_is_analysed_again_is_learnt(tmp_path):
    def failing(job):
        return replace(formula_of(job), status="failed", failure=Failure("timeout", "too long"))

    search, journal = search_of(), tmp_path / "trials.sqlite"
    optimise(search, journal, Evaluator(outcome=failing), trials=4)
    retried = optimise(search, journal, Evaluator(), trials=8)
    assert values_of(retried) == values_of(
        optimise(search, tmp_path / "new", Evaluator(), trials=8)
    )


DECIDED = parse_study(
    """
study = { name = "s", base = "maeno2000", count = 8, seed = 4 }
objectives = [{ metric = "cost" }, { metric = "stick_error" }, { metric = "plates" }]
[parameters]
"body.arc_radius_mm" = { low = 20.0, high = 60.0 }
"plates.length_mm" = { low = 0.6, high = 1.2 }
"plates.material" = ["phosphor_bronze", "polyimide"]
"""
)


def outcomes_of(count, cost=None):
    """Trials whose cost is of the radius and the material, or a function of radius and length."""
    rng = np.random.default_rng(0)
    common = {"digest": "d", "design": {}, "scene": "s", "fidelity": "plane-strain", "status": "ok"}
    found = []
    for number in range(count):
        radius, length = rng.uniform(20.0, 60.0), rng.uniform(0.6, 1.2)
        material = ("phosphor_bronze", "polyimide")[rng.integers(2)]
        own = cost(radius, length) if cost else -radius + 8.0 * (material == "polyimide")
        metrics = {"cost": own, "stick_error": float(rng.uniform()), "plates": 15.0}
        values = dict(zip(DECIDED.parameters, (radius, length, material), strict=True))
        found.append(Outcome(name=str(number), values=values, **common, metrics=metrics))
    return found


@pytest.mark.slow
def test_what_decides_comes_first_and_which_way():
    cost, noise, same = sensitivities(DECIDED, outcomes_of(100))
    first, second, third = cost.effects
    names = [effect.parameter for effect in cost.effects]
    assert names == ["body.arc_radius_mm", "plates.material", "plates.length_mm"]
    assert first.direction == pytest.approx(-1.0, abs=0.1)
    assert second.direction is None  # materials have no order
    assert 1.05 > first.share > 0.7 > second.share > third.share
    assert abs(third.share) < 0.05
    assert cost.explained > 0.9
    assert noise.explained < WEAK
    assert "hints" in noise.words
    assert (same.explained, same.effects) == (None, ())


COST = DECIDED.model_copy(update={"objectives": DECIDED.objectives[:1]})


@pytest.mark.parametrize(("weight", "shares"), [(0.0, (1.0, 0.0, 0.0)), (-0.5, (0.8, 0.2, 0.0))])
def test_shares_of_a_sum_are_those_of_its_variance(weight, shares):
    made = outcomes_of(400, lambda radius, length: radius / 40.0 + weight * length / 0.6)
    (cost,) = sensitivities(COST, made)
    by_key = {effect.parameter: effect.share for effect in cost.effects}
    assert [by_key[key] for key in COST.parameters] == pytest.approx(shares, abs=0.08)
