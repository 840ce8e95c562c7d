"""Ctrl-C, also where an extension that loads makes another error of it."""

import importlib
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from fingerdesign_cli import main as cli_main

from fingerdesign.errors import FingerDesignError
from tests.support.fingers import COARSE

pytestmark = [
    pytest.mark.usefixtures("interruptible"),
    pytest.mark.skipif(sys.platform == "win32", reason="no process is requested to end there"),
]


@pytest.fixture
def run(as_check, monkeypatch):
    """``run(work)``: the exit code of the program whose command does ``work``."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.getsignal(number) for number in numbers}
    monkeypatch.setattr("sys.argv", ["fingerdesign", "check"])

    def entered(work):
        as_check(work)
        with pytest.raises(SystemExit) as end:
            cli_main.entry_point()
        return end.value.code

    yield entered
    for number, handler in before.items():
        signal.signal(number, handler)
    for noted in (cli_main._end_requested, cli_main._ending):
        noted.clear()


@pytest.mark.parametrize("error", [ImportError("initialization failed"), FingerDesignError("no")])
def test_an_interruption_that_an_import_hides_is_130(error, run, capsys):
    def load():
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise error from None

    assert run(load) == 130
    assert capsys.readouterr().err == "interrupted\n"


def test_an_interruption_while_the_commands_load_is_one_line():
    code = (
        "import signal, sys; from fingerdesign_cli import start\n"
        "class Early:\n"
        "    def find_spec(name, *_): name == 'click' and signal.raise_signal(signal.SIGINT)\n"
        "sys.meta_path.insert(0, Early); start.entry_point()"
    )
    given = [sys.executable, "-c", code, "list"]
    found = subprocess.run(given, capture_output=True, text=True, timeout=60, check=False)
    assert (found.returncode, found.stdout, found.stderr) == (130, "", "interrupted\n")


def test_an_echo_of_the_interruption_disturbs_nothing(run):
    finished = []

    def work():
        try:
            signal.raise_signal(signal.SIGINT)
        finally:
            signal.raise_signal(signal.SIGTERM)  # as `timeout` and shells send it on
            finished.append("whole")

    assert run(work) == 130
    assert finished == ["whole"]


def test_a_later_request_ends_at_once(run, monkeypatch):
    ended = []
    monkeypatch.setattr(cli_main.os, "_exit", ended.append)

    def work():
        try:
            signal.raise_signal(signal.SIGINT)
        finally:
            cli_main._ending[0] -= cli_main._PATIENCE_S  # as if the first came so long ago
            signal.raise_signal(signal.SIGINT)

    run(work)
    assert ended[0] == 130


def test_an_import_ends_before_the_interruption(run, importable, tmp_path, capsys):
    (tmp_path / "loads.py").write_text(
        "import signal\nsignal.raise_signal(signal.SIGINT)\ndone = 1"
    )

    def load():
        print("loaded", importlib.import_module("loads").done)
        for _ in range(500):  # a long sleep is not cut short
            time.sleep(0.01)

    assert run(load) == 130
    assert capsys.readouterr().out == "loaded 1\n"


def test_signals_that_are_ignored_stay_so(run):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as under nohup
    assert run(lambda: signal.raise_signal(signal.SIGHUP)) == 0


def test_an_interruption_waits_while_a_sobol_sequence_is_made():
    """SciPy's compiled code would swallow it, and draw one point again and again."""
    from scipy.stats import qmc

    waits = []

    def entered(frame, event, _):
        if event == "call" and frame.f_code.co_name == "__init__":
            waits.append(cli_main._delays(frame))

    sys.setprofile(entered)
    try:
        qmc.Sobol(2, scramble=True, rng=np.random.default_rng(0))
    finally:
        sys.setprofile(None)
    assert waits
    assert all(waits)
    assert not cli_main._delays(sys._getframe())


@pytest.mark.slow
def test_an_interruption_counts_the_results_that_are_stored(importable, tmp_path, terminal):
    (tmp_path / "halts.py").write_text(
        'class Hand:\n    name = "halts"\n'
        "    def __init__(self, *given): ...\n"
        "    def start(self, *given): raise KeyboardInterrupt\n"
        "    def command(self, *given): ...\n"
    )
    files = [tmp_path / "coarse.toml", tmp_path / "second.toml"]
    files[0].write_text(COARSE + 'controller = "paper"\nfriction_coefficients = [0.5]\n')
    second = COARSE.replace('"coarse"', '"second"')
    files[1].write_text(second + 'controller = "halts:Hand"\n')
    given = ["--fidelity", "plane-strain", "--allow-code", "--out", tmp_path / "out"]
    found = terminal("analyse", *files, *given, code=130)
    assert found.err.endswith("interrupted; 1 of 2 results are stored\n")
    assert [each.name for each in (tmp_path / "out").iterdir()] == ["coarse"]
