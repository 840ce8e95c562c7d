"""Programs that answer lines of JSON: answers, and every way in which none comes."""

import sys
import time

import psutil
import pytest

from fingerdesign.runtime.lines import LineProgram, ProgramError

ECHO = "import sys\nfor line in sys.stdin: print(line.strip(), flush=True)"


def started(text, tmp_path, **more):
    return LineProgram([sys.executable, "-c", text], tmp_path, **more)


def test_a_program_answers_again_and_again(tmp_path):
    program = started(ECHO, tmp_path)
    for number in range(50):
        assert program.ask({"x": [number, 0.1]}) == {"x": [number, 0.1]}
    program.end()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("import time; time.sleep(60)", "no answer in 0.5 s"),
        ("input(); print('hello')", "no line of JSON"),
        ("input()", "it ended"),
        ("import sys; input(); sys.stdout.write('1')", "it ended"),
    ],
)
def test_a_program_that_does_not_answer_is_ended(text, words, tmp_path):
    program = started(text, tmp_path, time_s=0.5 if "sleep" in text else 20.0)
    began = time.monotonic()
    with pytest.raises(ProgramError, match=words):
        program.ask(1)
    assert time.monotonic() - began < 20.0
    with pytest.raises(ProgramError):
        program.ask(1)


def test_a_program_that_is_not_there_is_named(tmp_path):
    with pytest.raises(ProgramError, match="no_such_program"):
        LineProgram(["no_such_program"], tmp_path)


def test_what_a_program_starts_ends_with_it(tmp_path):
    """A shell's child would hold standard error open, and its caller would wait for it."""
    text = "import subprocess, sys; input()\n"
    text += "child = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)'])\n"
    text += "print(child.pid, flush=True); child.wait()"
    program = started(text, tmp_path)
    child = psutil.Process(program.ask({}))
    program.end()
    child.wait(timeout=5.0)  # raises where it lives on
