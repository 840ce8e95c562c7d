"""Limits on time and memory of a whole command: it ends with the reason, and what is done stays."""

import subprocess
import sys
import threading
import time

import pytest

from fingerdesign.runtime.limits import forget, limited, reached

DESIGN = '[design]\nname = "small"\n[body]\ndepth_mm = 4.0\n[plates]\ncount = 2\n'


@pytest.mark.parametrize(
    ("limits", "words"),
    [({"time_s": 0.2}, "--time-limit = 0.2 s"), ({"memory_MB": 1.0}, "--memory-limit = 1 MB")],
)
def test_what_exceeds_its_limit_is_ended_and_says_why(limits, words):
    ended = threading.Event()
    with limited(**limits, end=ended.set):
        assert ended.wait(10.0)
    assert words in reached()


def test_what_keeps_its_limits_is_left_alone():
    forget()
    with limited(time_s=60.0, memory_MB=1e6, end=pytest.fail):
        time.sleep(0.3)
    assert reached() == ""


def test_the_main_thread_is_interrupted(interruptible):
    with pytest.raises(KeyboardInterrupt), limited(time_s=0.2):
        time.sleep(30.0)


@pytest.mark.slow
def test_a_command_that_is_stopped_leaves_nothing_half_written(tmp_path):
    file, out = tmp_path / "small.toml", tmp_path / "out"
    file.write_text(DESIGN)
    found = command("validate", file, "--out", out, "--time-limit", "3")
    assert found.returncode == 1
    assert "stopped: --time-limit = 3 s is over\n" in found.stderr
    assert not out.exists() or not list(out.iterdir())
    assert command("validate", file, "--out", out, "--memory-limit", "nan").returncode == 2
    found = command("validate", file, "--out", out, "--memory-limit", "1")
    assert (found.returncode, "more than --memory-limit = 1 MB; raise it" in found.stderr) == (
        1,
        True,
    )


def command(*arguments):
    words = [sys.executable, "-m", "fingerdesign_cli.main", *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)
