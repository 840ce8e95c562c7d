"""Streams of random numbers: one for each purpose."""

import numpy as np

from fingerdesign.runtime.streams import seed_for, stream


def test_a_stream_is_its_seed_purpose_and_indices():
    def first(*key):
        return float(stream(*key).random())

    assert first(3, "a", 1, "b") == first(np.int64(3), "a", np.int64(1), "b")
    others = [(3, "a"), (3, "a", 0), (3, "a", 0, 0), (0, "a"), (3, "b"), (3, "a", "0"), (3, "a0")]
    assert len({first(*key) for key in others}) == len(others)


def test_seeds_are_exact_in_json_and_no_two_of_many_are_alike():
    found = {seed_for(seed, "finger", k) for seed in range(20) for k in range(1000)}
    assert len(found) == 20_000
    assert all(0 <= each < 2**53 for each in found)
    assert {int(float(each)) for each in found} == found
