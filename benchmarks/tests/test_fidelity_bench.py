"""bench fidelity: pairs that stay the same, records that read back, and a judge that can say no."""

import numpy as np
import pytest
from fingerdesign_bench.fidelity.fidelity import ReferencesMissing, judge, references, rows
from fingerdesign_bench.fidelity.pairs import KINDS, TOLERANCES, pairs
from fingerdesign_bench.fidelity.run import model_key, plain, readings_from, rungs_of

from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.analysis.fidelity.rungs import rung

EVERY = pairs()


def test_the_pairs_are_of_all_kinds():
    assert [pair.number for pair in EVERY] == list(range(30))
    assert {pair.control for pair in EVERY} == {"motion", "force"}
    assert {pair.tolerance for pair in EVERY} == set(TOLERANCES)
    for low, high, plates in KINDS:
        own = [p.design for p in EVERY if low <= p.design.body.depth_mm <= high]
        assert max(design.plates.number for design in own) <= plates


def test_the_pairs_are_always_the_same():
    assert [pair.digest() for pair in pairs(3)] == [pair.digest() for pair in EVERY[:6]]


def readings(pair, error, price=0.0):
    k = len(pair.scene.path.rows)
    force = np.linspace(1.0, 2.0, k) * (1.0 + error + price)
    gages = np.full((k, pair.design.plates.number, 2), 10.0) * (1.0 + error)
    stick = np.linspace(1.0, 0.5, k) + error + price
    return Readings(force, 0.3 * force, force, stick, gages, "both")


def records(pair, error, price, seconds=1.0):
    found = []
    for dimension, scale in rungs_of():
        flat = dimension != "3-D"
        answer = readings(pair, error * scale, price * flat)
        found.append(
            {
                "pair": pair.number,
                "dimension": dimension,
                "scale": scale,
                "key": model_key(rung(pair.design, pair.scene, dimension, scale)),
                "dofs": round((100 if flat else 1000) * scale**-2.5),
                "contact_nodes": 10,
                "seconds": {"mesh": seconds},
                "cost_s": (0.1 if flat else 1.0) * seconds * scale**-3,
                "readings": plain(answer),
            }
        )
    return found


def test_records_read_back():
    pair = EVERY[4]
    reported = readings(pair, 0.01)
    back = readings_from(plain(reported))
    np.testing.assert_allclose(back.gages, reported.gages)
    np.testing.assert_allclose(back.stick_ratio, reported.stick_ratio)
    assert back.face == reported.face


@pytest.fixture(scope="module")
def judged():
    """Four pairs, judged by true references and by wrong ones."""
    every = [each for pair in EVERY[:4] for each in records(pair, 0.002, 0.3)]
    return [
        judge(EVERY[:4], every, {pair.number: readings(pair, error) for pair in EVERY[:4]})
        for error in (0.0, 0.5)
    ]


def test_the_judge_counts_what_holds(judged):
    found, off = judged
    assert (found.within, found.wrong, off.within) == (1.0, 0, 0.0)
    assert len(rows(found)) == 4
    assert all(each.ladder.reached for each in found.outcomes)
    assert not off.checks()[0].holds
    assert off.cheapest is None


def test_the_judge_counts_what_it_costs(judged):
    found = judged[0]
    meeting = [each.seconds for each in found.fixed if each.meets == 4]
    assert found.cheapest.seconds == min(meeting)
    spent = sum(each.ladder.seconds for each in found.outcomes)
    assert found.seconds_share == pytest.approx(spent / found.cheapest.seconds)


def test_plane_strain_that_does_is_expected_to_be_used():
    (pair,) = (p for p in EVERY if p.number == 6)  # to 10 %, 49 mm deep
    alone = [pair if p.number == 6 else p for p in EVERY[:7]]
    truth = {p.number: readings(p, 0.0) for p in alone}
    every = [each for p in alone for each in records(p, 0.001, 0.0)]
    found = judge(alone, every, truth)
    assert found.missed == 0
    assert found.outcomes[6].section_used


def test_references_that_are_missing_or_of_other_pairs_are_refused():
    with pytest.raises(ReferencesMissing, match="--references"):
        references(EVERY[:1], "[]")


def test_a_reference_of_each_pair_is_shipped():
    found = references(EVERY)
    assert sorted(found) == [pair.number for pair in EVERY]
    assert all(np.isfinite(each.normal_force).all() for each in found.values())
