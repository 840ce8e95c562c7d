"""Processor time counts what was started, while it lives and after, and each once."""

import subprocess
import sys
import time

import numpy as np

from fingerdesign.runtime.machine import forget_peak_memory, peak_memory_MB, processor_seconds

BUSY = (
    "import sys, time\n"
    "while time.process_time() < 0.4: pass\n"
    "print('done', flush=True); sys.stdin.read()"
)


def test_a_child_that_lives_counts_and_once():
    before = processor_seconds()
    child = subprocess.Popen(
        [sys.executable, "-c", BUSY], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert child.stdout.readline()
    living = processor_seconds() - before
    assert 0.35 < living < 1.0
    child.communicate()
    assert abs(processor_seconds() - before - living) < 0.2


def test_waiting_costs_nothing():
    before = processor_seconds()
    time.sleep(0.3)
    assert processor_seconds() - before < 0.2


def test_peak_memory_is_that_since_it_was_forgotten():
    low = peak_memory_MB()
    forget_peak_memory()
    much = np.ones(30_000_000)
    high = peak_memory_MB()
    assert high > 200.0
    del much
    forget_peak_memory()
    assert peak_memory_MB() < high - 150.0
    assert low > 10.0
