"""bench fidelity: pairs that stay the same, records that read back, and a judge that can say no."""

import numpy as np
import pytest
from fingerdesign_bench.fidelity.fidelity import ReferencesMissing, references, row
from fingerdesign_bench.fidelity.judge import judge
from fingerdesign_bench.fidelity.pairs import pairs
from fingerdesign_bench.fidelity.run import model_key, plain, readings_from, rungs_of

from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.analysis.fidelity.rungs import rung

EVERY = pairs()


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
        key = model_key(rung(pair.design, pair.scene, dimension, scale))
        dofs = round((100 if flat else 1000) * scale**-2.5)
        cost = (0.1 if flat else 1.0) * seconds * scale**-3
        own = {"pair": pair.number, "dimension": dimension, "scale": scale, "key": key}
        own |= {"dofs": dofs, "contact_nodes": 10, "seconds": {"mesh": seconds}, "cost_s": cost}
        found.append(own | {"readings": plain(answer)})
    return found


def test_records_read_back():
    reported = readings(EVERY[4], 0.01)
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


def test_the_judge_counts_what_holds_and_what_it_costs(judged):
    found, off = judged
    assert (found.within, found.wrong, off.within) == (1.0, 0, 0.0)
    assert all(each.ladder.reached and row(each) for each in found.outcomes)
    assert not off.checks()[0].holds
    assert off.cheapest is None
    meeting = [each.seconds for each in found.fixed if each.meets == 4]
    assert found.cheapest.seconds == min(meeting)
    spent = sum(each.ladder.seconds for each in found.outcomes)
    assert found.seconds_share == pytest.approx(spent / found.cheapest.seconds)


def test_plane_strain_that_does_is_expected_to_be_used():
    seven = EVERY[:7]  # the last to 10 %, 49 mm deep
    truth = {pair.number: readings(pair, 0.0) for pair in seven}
    found = judge(seven, [each for pair in seven for each in records(pair, 0.001, 0.0)], truth)
    assert found.missed == 0
    assert found.outcomes[6].section_used


def test_a_reference_of_each_pair_is_shipped_and_others_are_refused():
    found = references(EVERY)
    assert sorted(found) == [pair.number for pair in EVERY] == list(range(30))
    assert all(np.isfinite(each.normal_force).all() for each in found.values())
    with pytest.raises(ReferencesMissing, match="--references"):
        references(EVERY[:1], "[]")
