"""Fifty seeded inputs of the fuzzer; two hundred with the slow tests."""

import os

import pytest

from fingerdesign.runtime.cache import Cache
from fingerdesign.runtime.files import whole_text
from tests.fuzz.fuzz import fuzzing, judge

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes and timers of POSIX")


@pytest.mark.parametrize(
    "numbers", [range(50), pytest.param(range(50, 200), marks=pytest.mark.slow)], ids=str
)
def test_hostile_files_are_refused_with_a_sentence_or_read(numbers, tmp_path):
    with fuzzing(tmp_path / "fuzz"):
        wrong = {each.number: each.wrong for each in map(judge, numbers) if each.wrong}
    assert wrong == {}


def test_a_text_that_never_ends_or_is_too_long_is_an_error(tmp_path):
    pipe, long = tmp_path / "pipe", tmp_path / "long"
    os.mkfifo(pipe)
    long.write_text("x" * 11)
    with pytest.raises(OSError, match="never end"):
        whole_text(pipe)
    with pytest.raises(OSError, match="larger"):
        whole_text(long, most=10)
    long.write_bytes(b"a\r\nb\rc")
    assert whole_text(long) == "a\nb\nc"


def test_a_cache_holds_no_pipe(own_cache):
    cache = Cache("texts", most=3)
    path = cache.path("a")
    path.parent.mkdir(parents=True, exist_ok=True)
    os.mkfifo(path)
    assert cache.text("a") is None
    assert cache.arrays("a") is None
    cache.put_text("a", "whole")
    assert cache.text("a") == "whole"
