"""A worker beside the caller's work: its answer, its failures as sentences, its end."""

import subprocess
import sys
import time

import pytest

from fingerdesign.runtime.process import ProcessError, WorkerJob


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Write a module that workers can import; returns its name."""

    def write(name, text):
        (tmp_path / f"{name}.py").write_text(text)
        monkeypatch.setenv("PYTHONPATH", str(tmp_path))
        return name

    return write


def test_it_answers_in_its_folder(module):
    name = module(
        "echoing",
        "import pathlib, sys\nf = pathlib.Path(sys.argv[1])\n"
        "(f / 'out.txt').write_text((f / 'in.txt').read_text() * 2)\n",
    )
    with WorkerJob(name, lambda folder: (folder / "in.txt").write_text("ab"), 60.0) as job:
        folder = job.finished()
        assert (folder / "out.txt").read_text() == "abab"
    assert not folder.exists()


def test_its_failures_are_sentences(module):
    name = module("failing", "raise ValueError('a reason')\n")
    with (
        WorkerJob(name, lambda folder: None, 60.0) as job,
        pytest.raises(ProcessError, match="exit code 1: ValueError: a reason") as failed,
    ):
        job.finished()
    assert failed.value.code == 1


def test_one_that_is_killed_is_told(module):
    name = module("killed", "import os, signal\nos.kill(os.getpid(), signal.SIGKILL)\n")
    with (
        WorkerJob(name, lambda folder: None, 60.0) as job,
        pytest.raises(ProcessError, match="SIGKILL"),
    ):
        job.finished()


def test_one_that_takes_too_long_ends_with_the_block(module):
    name = module("slow", "import time\ntime.sleep(60)\n")
    start = time.monotonic()
    with (
        WorkerJob(name, lambda folder: None, 0.2) as job,
        pytest.raises(ProcessError, match=r"did not finish in 0\.2 s"),
    ):
        job.finished()
    assert time.monotonic() - start < 20.0
    assert job._process.returncode is not None


def test_importing_it_is_light():
    code = "import sys, fingerdesign.runtime.process; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
