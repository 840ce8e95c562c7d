"""Calls in threads: order, errors, what is taken ahead, and BLAS as it was."""

import threading
import time
from contextvars import ContextVar

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from fingerdesign.runtime.threads import in_threads

SIZE = 300


def blas():
    return max(each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas")


@pytest.mark.parametrize("threads", [1, 2])
def test_answers_come_in_order_and_each_call_has_one_thread_of_blas(threads):
    names = set()
    both = threading.Barrier(threads)

    def call(number):
        names.add(threading.current_thread().name)
        both.wait(30.0)  # Two calls run at once, or this ends in an error.
        return number, blas()

    with threadpool_limits(threads, user_api="blas"):
        assert [*in_threads(call, range(6))] == [(number, 1) for number in range(6)]
        assert blas() == threads
    assert len(names) == threads


def test_many_cores_are_no_reason_for_many_threads():
    names = set()

    def call(number):
        time.sleep(0.01)  # So that each thread gets some.
        names.add(threading.current_thread().name)

    with threadpool_limits(16, user_api="blas"):
        assert blas() > 4
        assert len([*in_threads(call, range(40))]) == 40
    assert len(names) == 4


@pytest.mark.parametrize("threads", [1, 2])
def test_an_error_is_raised_in_its_turn_and_few_items_are_taken_ahead(threads):
    taken = []

    def items():
        for number in range(50):
            taken.append(number)
            yield number

    def call(number):
        if number == 3:
            raise ValueError("the fourth")
        return number

    with threadpool_limits(threads, user_api="blas"):
        answers = in_threads(call, items())
        for number in range(3):
            assert next(answers) == number
            assert len(taken) <= number + 1 + threads
        with pytest.raises(ValueError, match="the fourth"):
            next(answers)
        assert blas() == threads


def test_bits_are_those_of_one_thread_and_context_variables_are_seen():
    size = ContextVar("size", default=2)
    size.set(SIZE)

    def call(seed):
        own = np.random.default_rng(seed).random((size.get(), size.get()))
        return own @ own

    found = []
    for threads in (1, 2):
        with threadpool_limits(threads, user_api="blas"):
            found.append(np.array([*in_threads(call, range(5))]))
    assert found[0].shape == (5, SIZE, SIZE)
    assert (found[0] == found[1]).all()
