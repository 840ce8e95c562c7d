"""What is freed stays with the process for as long as it was asked for."""

import ctypes
import subprocess
import sys

import pytest

# In a process of its own: what others have freed here may hold the block.
SCRIPT = """
from pathlib import Path
import numpy as np
from fingerdesign.fem.memory import memory_kept

def held():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096e-6

def left():
    before = held()
    np.ones(100 * 125_000)
    return held() - before

print(left())
with memory_kept():
    print(left())
    before = held()
print(held() - before, left())
"""


@pytest.mark.skipif(
    sys.platform != "linux" or not hasattr(ctypes.CDLL(None), "mallopt"), reason="of glibc alone"
)
def test_freed_memory_stays_until_the_work_is_done():
    words = [sys.executable, "-c", SCRIPT]
    found = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()
    usual, kept, back, after = map(float, found)  # MB
    assert usual == pytest.approx(0.0, abs=5.0)
    assert kept == pytest.approx(100.0, abs=5.0)
    assert back == pytest.approx(-100.0, abs=5.0)
    assert after == pytest.approx(0.0, abs=5.0)
