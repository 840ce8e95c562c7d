"""A study of many outcomes: columns, the best on its page, shards joined by `compare`."""

from dataclasses import replace
from types import SimpleNamespace

import click
import numpy as np
import pytest
from fingerdesign_cli.studies.search import shard_of

from fingerdesign.errors import DesignError
from fingerdesign.records.columns import FACTS, metrics_at, outcomes_at, row_of
from fingerdesign.records.outcome import Failure, Traces
from fingerdesign.runtime.columns import ColumnWriter
from fingerdesign.search.compare import large
from fingerdesign.search.compare.folder import FOLDER, write_large_study
from fingerdesign.search.compare.read import read_comparison
from fingerdesign.search.run import run
from fingerdesign.search.study.file import parse_study
from fingerdesign.search.study.variants import base_design, variants
from tests.support.any_outcomes import any_outcomes

TEXT = """
[study]
name = "many"
base = "maeno2000"
sampling = "sobol"
count = 10
[parameters]
"plates.pitch_mm" = { low = 0.9, high = 1.1 }
[[objectives]]
metric = "stick_error"
goal = "min"
[[objectives]]
metric = "cost"
goal = "min"
[constraints]
cost = { at_most = 80.0 }
"""
STUDY = parse_study(TEXT)
(OWN, *_) = any_outcomes(1)


def outcome(number, error, cost, **more):
    metrics = OWN.metrics | {"stick_error": error, "cost": cost}
    facts = {"digest": f"{number:064x}", "name": f"many-{number:04d}", "metrics": metrics}
    return replace(OWN, **facts, values={"plates.pitch_mm": 0.9 + 0.001 * number}, **more)


def many(count, seed=1):
    """Outcomes at random, one that no other beats, one beyond the bound, one that failed."""
    chance = np.random.default_rng(seed).random((count, 2))
    found = [
        outcome(k, 0.1 + own[0], 40.0 + 50.0 * own[1]) for k, own in enumerate(chance.tolist())
    ]
    failure = {"status": "failed", "failure": Failure("timeout", "x" * 5000)}
    worst = [replace(outcome(count, 9.0, 9.0, **failure), metrics={})]
    return [*found, *worst, outcome(count + 1, 0.05, 30.0), outcome(count + 2, 0.0, 99.0)]


def written(folder, outcomes):
    with FOLDER.written(folder) as aside:
        return write_large_study(aside, STUDY, iter(outcomes), TEXT)


def test_a_row_is_what_it_was_and_small(tmp_path):
    path, outcomes = tmp_path / "outcomes.sqlite", many(500)
    with ColumnWriter(path, FACTS) as columns:
        for each in outcomes:
            columns.add(row_of(replace(each, values=each.values | {"grip.controller": "maeno"})))
    assert columns.count == 503
    assert path.stat().st_size < 2000 * len(outcomes)
    table, good = metrics_at(path, ["cost", "no_such"])
    assert (table.shape, int(good.sum())) == ((503, 2), 502)
    assert np.isnan(table[:, 1]).all()
    assert table[7, 0] == outcomes[7].metrics["cost"]
    for number in (7, 500):
        (own,), given = outcomes_at(path, [number]), outcomes[number]
        assert (own.digest, own.metrics, own.status) == (given.digest, given.metrics, given.status)
        assert own.values == given.values | {"grip.controller": "maeno"}
        assert own.design == {}
    assert len(own.failure.sentence) == 400


@pytest.mark.slow
def test_the_best_are_compared_and_shards_are_joined(tmp_path, monkeypatch):
    monkeypatch.setattr(large, "MOST_SHOWN", 40)
    outcomes = many(400)
    compared, kinds = written(tmp_path / "out" / "whole", outcomes)
    assert kinds == {"ok": 402, "timeout": 1}
    names = {each.name for each in compared.outcomes}
    assert len(names) == 40
    assert compared.outcomes[0].name == "many-0401"  # it beats all that meet the bound
    assert "many-0402" not in names
    page = (tmp_path / "out" / "whole" / "report.html").read_text("utf-8")
    assert "the best of 403" in page
    for part in (0, 1):
        written(tmp_path / "parts" / f"many.{part + 1}-of-2", outcomes[part::2])
    joined = read_comparison([tmp_path / "parts"])
    assert {each.name for each in joined.outcomes} == names
    assert joined.facts.best_of == 403


def test_columns_that_are_none_are_refused(tmp_path):
    written(tmp_path / "many", many(5))
    (tmp_path / "many" / "outcomes.sqlite").write_bytes(b"nothing")
    with pytest.raises(DesignError, match="columns"):
        read_comparison([tmp_path / "many"])


def test_the_front_is_what_nothing_beats():
    rows = np.random.default_rng(2).integers(0, 9, (200, 2)).astype(float)
    beaten = [any((o <= r).all() and (o < r).any() for o in rows) for r in rows]
    assert large.on_front(rows).tolist() == np.logical_not(beaten).tolist()


def test_shards_share_the_variants_out():
    base = base_design(STUDY)
    every = [each.name for each in variants(STUDY, base)]
    parts = [[each.name for each in variants(STUDY, base, (k, 3))] for k in (1, 2, 3)]
    assert [len(part) for part in parts] == [4, 3, 3]
    assert sorted(name for part in parts for name in part) == every
    for wrong in ("0/3", "4/3", "1", "a/b", "1/0"):
        with pytest.raises(click.UsageError, match="shard"):
            shard_of(wrong)


def test_jobs_are_held_a_part_at_a_time(tmp_path, monkeypatch):
    """No more than a part is drawn ahead; what comes is bare; progress counts them all."""
    monkeypatch.setattr(run, "PART", 10)
    drawn, seen = [], []

    def plan():
        for each in many(22):
            drawn.append(each)
            yield each

    cluster = SimpleNamespace(threads=1, outcomes=lambda *given: ())
    found = run.run_in_parts(
        plan(), 25, run.Store(tmp_path), cluster, STUDY.limits, lambda now: seen.append(now)
    )
    first = next(found)
    assert (len(drawn), first.traces, first.design) == (10, Traces(), {})
    assert [first.name, *(each.name for each in found)] == [each.name for each in drawn]
    assert (seen[-1].number, seen[-1].of, seen[-1].failures) == (25, 25, 1)


def test_a_shard_beyond_the_last_variant_fails_nothing(tmp_path, terminal):
    study = tmp_path / "few.toml"
    head = '[study]\nname = "few"\nbase = "narrow"\ncount = 2\n'
    study.write_text(f'{head}[parameters]\n"plates.cover_mm" = [1.8, 2.0]\n')
    printed = terminal("sweep", study, "--out", tmp_path / "out", "--shard", "3/3", "--quiet")
    assert printed.out == ""
    assert (tmp_path / "out/few.3-of-3/study.json").is_file()
