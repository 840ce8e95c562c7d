"""The comparison page's text and data: complete, escaped, and true to the outcomes.

Front and recommended finger, on outcomes whose answer is known by hand.
"""

import base64
import gzip
import html
import itertools
import json
import re
from dataclasses import replace

import pytest

from fingerdesign.records.outcome import GripOutcome, Outcome, Validity
from fingerdesign.search.compare.page import compare_html, page_data
from fingerdesign.search.compare.read import facts_of
from fingerdesign.search.compare.recommend import (
    Bound,
    Objective,
    StudyFacts,
    recommend,
    uncertainty,
    why_not,
)
from fingerdesign.search.compare.table import design_table, standing
from fingerdesign.search.compare.words import summary
from tests.support.any_outcomes import HOSTILE, any_outcomes

LEAST_ERROR, LEAST_COST = Objective("stick_error", "min"), Objective("cost", "min")
MOST_MARGIN = Objective("safety_margin", "max")
WANTED = (LEAST_ERROR, LEAST_COST)
BOUNDS = (Bound("peak_ratio", at_most=2.5),)


def page_of(outcomes, name="a study", **more):
    return compare_html(outcomes, facts_of(name, outcomes, WANTED, BOUNDS, **more))


def script(page, key):
    found = re.search(rf'<script[^>]*id="{key}"[^>]*>(.*?)</script>', page, re.DOTALL)
    return found[1]


def archive(page, name):
    found = re.search(rf'data-name="{re.escape(name)}">([^<]*)<', page)
    return gzip.decompress(base64.b64decode(found[1])).decode()


@pytest.fixture(scope="module")
def made():
    return any_outcomes(40)


@pytest.fixture(scope="module")
def page(made):
    return page_of(made, record={"digest of the study": "ab" * 32})


def test_every_design_is_there_with_its_numbers_and_every_failure(made, page):
    data = json.loads(script(page, "data"))
    assert [each["digest"] for each in data["designs"]] == [o.digest for o in made]
    assert [each["metrics"] for each in data["designs"]] == [o.metrics for o in made]
    rows = re.findall(r'<tr data-i="(\d+)">', page)
    assert sorted(map(int, rows)) == [i for i, o in enumerate(made) if o.status == "ok"]
    for each in filter(None, (o.failure for o in made)):
        assert html.escape(each.sentence) in page
    assert "ab" * 32 in page
    lines = archive(page, "outcomes.jsonl").splitlines()
    assert tuple(Outcome.from_json(line) for line in lines) == made
    assert len(archive(page, "designs.csv").splitlines()) == len(made) + 1
    found, stated = recommend(made, WANTED, BOUNDS), summary_of(made, bounds=BOUNDS)
    assert stated.recommended == made[found.chosen].name
    tile = next(each for each in stated.verdicts if each.name == "recommended")
    assert tile.number == stated.recommended
    assert f'<span class="number">{stated.recommended}</span>' in page
    assert page.index('id="pareto"') < page.index("recommended</span>") < page.index("<h2")
    assert f"{sum(o.status == 'failed' for o in made)} failed" in stated.counts
    # A sentence of what is given up names a design that is better there, and its price.
    best = made[found.best[0]]
    assert any(best.name in line and "cost" in line for line in stated.given_up)
    for none in ((), any_outcomes(3, failed=1.0)):
        assert "No design was analysed" in page_of(none)


def test_hostile_texts_stay_text():
    made = any_outcomes(30, hostile=True)
    page = page_of(made, name=HOSTILE[0], record={HOSTILE[1]: HOSTILE[4]}, sources=[HOSTILE[2]])
    assert "<img src=x" not in page
    assert "<script>fetch" not in page
    assert not set(page) & {"\u2028", "\u202e", "\x00", "\x07"}
    # data, details, files, Plotly, charts, the page's own
    assert page.count("<script") == page.count("</script>") == 1 + 2 + 4 + 1 + 1 + 6
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)[1]
    assert "script-src 'sha256-" in policy
    assert "unsafe-eval" not in policy
    assert "unsafe-inline" not in policy.split("script-src")[1]


def summary_of(outcomes, wanted=WANTED, bounds=()):
    return summary(
        outcomes, facts_of("x", outcomes, wanted, bounds), recommend(outcomes, wanted, bounds)
    )


def test_the_row_says_which_constraint_broke_and_what_was_varied_stands_first(made):
    good = [each for each in made if each.status == "ok"]
    dear = replace(good[0], metrics=good[0].metrics | {"cost": 99.0})
    every = [dear, *good[1:]]
    page = compare_html(every, facts_of("x", every, WANTED, (Bound("cost", at_most=50.0),)))
    reported = "cost 99, required is at most 50 (off by 49)"
    assert f'title="{reported}">' in page
    data = json.loads(script(page, "data"))
    assert data["designs"][0]["missed"] == [reported]
    columns = [each["path"] for each in data["columns"]]
    columns = [path for path in columns if path[0] in ("values", "metrics")]
    varied = len(dear.values)
    assert {path[0] for path in columns[:varied]} == {"values"}
    assert columns[varied : varied + 2] == [["metrics", each.metric] for each in WANTED]


def outcome(name, status="ok", fidelity="plane-strain", **metrics):
    common = {"digest": name, "values": {}, "design": {}, "scene": "s"}
    return Outcome(name=name, **common, fidelity=fidelity, status=status, metrics=metrics)


def errors_and_costs(*pairs):
    return [outcome(str(k), stick_error=x, cost=y) for k, (x, y) in enumerate(pairs)]


KNEE = errors_and_costs((0.0, 10.0), (0.2, 2.0), (1.0, 0.0), (0.3, 2.0), (0.3, 1.9))

NEXT = [KNEE[k] for k in (0, 1, 4, 2)]

TWO = [outcome("low", safety_margin=1.0), outcome("high", safety_margin=2.0)]


# A dear one, one without an objective, a failed one, and one that is left.
RACE = [
    *errors_and_costs((0.1, 50.0), (None, 1.0)),
    outcome("failed", "failed", stick_error=0.0, cost=0.0),
    outcome("good", stick_error=0.5, cost=5.0),
]

FLAT = [outcome(f"p{i}", cost=float(i)) for i in range(5)]

DEEP = [outcome(f"d{i}", fidelity="3d", cost=10.0 + i) for i in range(2)]

TIE = [outcome("a", cost=1.0), outcome("b", cost=1.0)]

WIDE = errors_and_costs((0.2, 1.0), (0.1, 9.0), (0.21, 10.0))  # the third widens costs


@pytest.mark.parametrize(
    ("outcomes", "wanted", "bounds", "expected"),
    [
        (KNEE[:4], WANTED, (), {"front": (0, 1, 2), "chosen": 1, "best": (0, 2)}),
        # The one that is beaten stands first: places on the front are not those of the group.
        (KNEE[3::-1], WANTED, (), {"front": (1, 2, 3), "chosen": 2, "best": (3, 1)}),
        (NEXT, WANTED, (), {"runner_up": 2}),
        # Where one beats all, the nearest of those beaten; of one alone, none.
        (NEXT, [LEAST_COST], (), {"runner_up": 2}),
        (NEXT[:1], [LEAST_COST], (), {"runner_up": None}),
        (TWO, [MOST_MARGIN], (), {"chosen": 1}),
        (TWO, [Objective("safety_margin", "min")], (), {"chosen": 0}),
        ([], [LEAST_COST], (), {"chosen": None}),
        (TWO, [], (), {"chosen": None}),
        (TWO, [LEAST_COST], (), {"chosen": None}),
        (RACE, WANTED, [Bound("cost", at_most=10.0)], {"feasible": (3,), "chosen": 3}),
        # Of 3-D where there is a choice.
        ([*FLAT, *DEEP], [LEAST_COST], (), {"fidelity": "3d", "chosen": 5, "group": (5, 6)}),
        ([*FLAT, DEEP[0]], [LEAST_COST], (), {"chosen": 0}),
        # A tie is reported, and broken by the range of all.
        (TIE, [LEAST_COST], (), {"front": (0, 1), "chosen": 0}),
        (WIDE, WANTED, (), {"front": (0, 1), "chosen": 1, "alike": (0,)}),
    ],
    ids=itertools.count(),
)
def test_one_is_recommended_of_the_front(outcomes, wanted, bounds, expected):
    found = recommend(outcomes, wanted, bounds)
    assert {name: getattr(found, name) for name in expected} == expected


@pytest.mark.parametrize("seed", range(3))
def test_front_is_what_the_definition_says(seed):
    made = any_outcomes(60, seed)
    found = recommend(made, [LEAST_ERROR, LEAST_COST, MOST_MARGIN], [])
    turn = {"stick_error": 1.0, "cost": 1.0, "safety_margin": -1.0}
    losses = {k: [turn[m] * made[k].metrics[m] for m in turn] for k in found.group}
    for number, own in losses.items():
        alone = not any(
            other != own and all(x <= y for x, y in zip(other, own, strict=True))
            for other in losses.values()
        )
        assert alone == (number in found.front)


@pytest.mark.parametrize(
    ("flaw", "words"),
    [
        ({"grip_success": 0.0}, "lifts nothing"),
        ({"smallest_stick_change": 1.08}, "change of the stick ratio from 1.1 on"),
        ({"plates": 0.0}, "no gages"),
    ],
)
def test_nothing_is_recommended_that_fails_its_purpose(flaw, words):
    plain = {"grip_success": 1.0, "smallest_stick_change": 0.05, "plates": 9.0}
    sound = outcome("sound", cost=9.0, **plain)
    cheap = outcome("cheap", cost=1.0, **(plain | flaw))
    found = recommend([cheap, sound], [LEAST_COST], [])
    assert (found.chosen, found.feasible) == (1, (1,))
    assert words in why_not(cheap, [LEAST_COST], [])[0]
    stated = summary_of([cheap, sound], [LEAST_COST])
    assert "1 design fails its purpose" in stated.counts
    assert stated.table.columns == ("objective", "sound", "on its scale")  # it is alone
    assert stated.verdicts[1].count == "no other to compare"
    none = summary_of([cheap], [LEAST_COST])
    assert (none.recommended, none.values) == ("", {})
    assert "(1 of 1 miss it)" in none.why
    # A bound of the study's own on the same number judges in its place.
    (metric,) = flaw
    assert recommend([cheap], [LEAST_COST], [Bound(metric, at_most=2.0)]).chosen == 0


@pytest.mark.parametrize("turned", [False, True])
def test_of_one_in_plane_strain_and_one_in_3d_the_latter_is_recommended(turned):
    plain = {"grip_success": 1.0, "smallest_stick_change": 0.05, "plates": 9.0, "cost": 1.0}
    flat = outcome("flat", **plain)
    made = [flat, replace(flat, name="deep", fidelity="3d")]
    made = made[::-1] if turned else made
    assert made[recommend(made, [LEAST_COST], []).chosen].name == "deep"
    assert "no other is compared with it" in summary_of(made, [LEAST_COST]).why


def test_a_finger_that_fails_verdicts_is_not_recommended_next_to_one_that_passes():
    cheap = outcome("cheap", cost=1.0, failed_verdicts=2.0)
    sound = outcome("sound", cost=9.0, failed_verdicts=0.0)
    found = recommend([cheap, sound], [LEAST_COST], [])
    assert [standing(k, found) for k in (0, 1)] == ["fails verdicts", "recommended"]
    tile = summary_of([cheap, sound], [LEAST_COST]).verdicts[1]
    assert (tile.status, tile.target) == ("note", "1 fails verdicts")
    facts = StudyFacts("s", (LEAST_COST,))
    light = page_data([cheap, sound], facts, found)["designs"]
    assert [(each["kind"], each["competes"]) for each in light] == [
        ("failing", False),
        ("star", True),
    ]
    assert (found.chosen, found.group, found.feasible) == (1, (1,), (0, 1))
    stated = summary_of([cheap, sound], [LEAST_COST])
    assert "only designs that pass all are recommended" in stated.counts
    assert "the only one that passes all verdicts" in stated.why
    worse = outcome("worse", cost=9.0, failed_verdicts=1.0)
    stated = summary_of([cheap, worse], [LEAST_COST])
    assert stated.recommended == "cheap"
    assert stated.verdicts[0].status == "fail"
    assert "fails 2 verdicts" in stated.why


def test_headings_are_short_and_have_units():
    made = replace(
        outcome("a", failed_verdicts=0.0), values={"materials.rtv.youngs_modulus_MPa": 1.0}
    )
    facts = facts_of("study", [made])
    columns = design_table([made], facts, recommend([made], [], [])).columns
    assert [(each.title, each.unit) for each in columns[:2]] == [
        ("rtv youngs modulus", "MPa"),
        ("failed verdicts", ""),
    ]
    assert columns[0].help == "materials.rtv.youngs_modulus_MPa"


def noisy(name, lifted, **metrics):
    """Of three grips, with noisy gages."""
    grip = GripOutcome("paper", 0.5, 500.0, True, False, 1.5, 5.0, 0.4)
    design = {"grip": {"hardware": {"gage_noise_microstrain": 0.5, "sample_rate_Hz": 100.0}}}
    made = outcome(name, grip_success=lifted / 3, **metrics)
    return replace(made, design=design, grips=(grip, grip, grip))


def test_better_is_stated_only_beyond_what_chance_changes():
    near = [outcome("a", stick_error=0.150, cost=1.0), outcome("b", stick_error=0.155, cost=1.0)]
    found = recommend(near, WANTED, [])
    assert (found.front, found.same) == ((0, 1), (1,))
    stated = summary_of(near)
    assert "No difference is shown" in stated.why
    assert stated.given_up == ()
    assert stated.table.rows[0][3] == "no difference shown"
    assert "±" in stated.table.rows[0][1]
    far = [near[0], outcome("c", stick_error=0.18, cost=1.0)]
    found = recommend(far, WANTED, [])
    assert (found.front, found.same) == ((0,), ())


def test_what_is_lost_to_chance_follows_noise_grips_and_mesh():
    quiet = outcome("quiet", grip_success=1.0, peak_ratio=2.0, cost=3.0)
    assert uncertainty(quiet, "grip_success") == uncertainty(quiet, "cost") == 0.0
    assert uncertainty(quiet, "peak_ratio") == pytest.approx(0.06)
    rough = replace(quiet, validity=Validity(mesh_error=0.04))
    assert uncertainty(rough, "peak_ratio") == pytest.approx(0.1)
    assert uncertainty(rough, "cost") == 0.0
    loud = noisy("loud", 2, peak_ratio=2.0)
    assert uncertainty(loud, "peak_ratio") == pytest.approx(0.38)
    many = replace(loud, grips=4 * loud.grips)  # four times as many tell twice as much
    assert uncertainty(many, "peak_ratio") == pytest.approx(0.19)
    # Beta after two of three: sqrt(3 * 2 / 25 / 6).
    assert uncertainty(loud, "grip_success") == pytest.approx(0.2)
    wanted = [Objective("grip_success", "max")]
    found = recommend([loud, noisy("one more", 3)], wanted, [])
    assert (found.chosen, found.same) == (1, (0,))
    steady = [outcome("a", grip_success=2 / 3), outcome("b", grip_success=1.0)]
    assert recommend(steady, wanted, []).same == ()
