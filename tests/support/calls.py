"""Functions that tests have called in other processes: quick, and bad in every way."""

import contextlib
import io
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from fingerdesign.errors import DesignError, Fault, GeometryError


def command(arguments):
    """Exit code of a command of fingerdesign, and what it wrote to the terminal."""
    from fingerdesign_cli.main import main

    written = io.StringIO()
    with contextlib.redirect_stdout(written), contextlib.redirect_stderr(written):
        code = main(arguments)
    return code, written.getvalue()


def increments(design, scene):
    """Of an analysis in plane strain, of the path alone."""
    from fingerdesign import load_design, load_scene
    from fingerdesign.analysis.case import Case
    from fingerdesign.pipeline import run

    found = load_design(design), load_scene(scene), "plane-strain"
    return run(Case(*found, fields=False, grips=False, studied=False)).result.increments


def grips(design):
    """Of an analysis in plane strain, without fields and slip studies."""
    from fingerdesign import load_design
    from fingerdesign.analysis.case import Case
    from fingerdesign.pipeline import run

    case = Case(load_design(design), None, "plane-strain", fields=False, studied=False)
    return run(case).result.grips


def hand_of(design):
    """The name of the design's controller, and the design's digest."""
    from fingerdesign.control.roster import make_controller

    return make_controller(design.grip.controller, design.grip).name, design.digest()


def forces(changes, mkl):
    """Of the fundamental case of a changed finger, and its gages, in plane strain and in 3-D; MKL
    may be hidden."""
    if not mkl:
        sys.modules["pypardiso"] = None
    from fingerdesign import with_values
    from fingerdesign.analysis.case import Case
    from fingerdesign.checks.load import load_design
    from fingerdesign.pipeline import run

    design = with_values(load_design("maeno2000"), changes)
    both = []
    for fidelity in ("plane-strain", "3d"):
        case = Case(design, None, fidelity, fields=False, grips=False, studied=False)
        rows = run(case).result.increments
        numbers = [(row.normal_force_N, row.tangential_force_N, row.stick_ratio) for row in rows]
        both.append(np.concatenate([*numbers, [gage.reading for gage in rows[-1].gages]]))
    return both


def digest(table):
    """Of a design or a scene."""
    return table.digest()


def digests(*files):
    """Of a design and a scene, here and in a process that they are sent to."""
    from fingerdesign import load_design, load_scene
    from fingerdesign.runtime.isolate import Worker

    tables = [load(file) for load, file in zip((load_design, load_scene), files, strict=True)]
    there = []
    for table in tables:
        with Worker() as worker:
            there.append(worker.call("tests.support.calls:digest", table, time_s=60.0))
    return [table.digest() for table in tables], there


def who(*given):
    """The number of the process, and its threads' setting; it prints, too."""
    print("this is no answer", flush=True)
    os.write(1, b"nor this\n")
    return os.getpid(), os.environ.get("MKL_NUM_THREADS")


def double(array):
    """Twice an array."""
    return 2 * array


def load():
    """What is loaded once a process."""
    globals()["loaded"] = os.getpid()


def load_slowly():
    """In a second."""
    time.sleep(1.0)


def loaded_in():
    """The process in which :func:`load` ran."""
    return globals().get("loaded")


def vtk_modules():
    """Numbers of VTK's modules with CadQuery loaded, and once a name of `vtk` is used."""
    import cadquery  # noqa: F401
    import vtk

    def loaded():
        return sum(name.startswith("vtkmodules.") for name in sys.modules)

    before = loaded()
    assert vtk.vtkSTLReader is not None
    assert not hasattr(vtk, "nothing")
    return before, loaded()


def added(*numbers):
    """Their sum."""
    return sum(numbers)


def hang(path):
    """Starts a process, leaves both numbers in a file, and hangs."""
    started = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(1e6)"])
    Path(path).write_text(f"{os.getpid()} {started.pid}", encoding="utf-8")
    time.sleep(1e6)


def sleep(seconds):
    """Slowly."""
    time.sleep(seconds)
    return seconds


def refuse(kind):
    """An error of this package, or another."""
    if kind == "design":
        raise DesignError([Fault("a.key", 1.0, "at most 0.5", "lower it")], "x.toml")
    if kind == "geometry":
        raise GeometryError("face 7 is an undercut")
    raise {"value": ValueError, "disk": OSError, "memory": MemoryError}[kind]("a reason")


def read_killed(*given):
    """A reader of STEP files whose process is ended."""
    os.kill(os.getpid(), 9)


def read_on_a_full_disk(*given):
    """A reader of STEP files that finds no space."""
    raise OSError(28, "no space")


def write_results(target):
    """Write a result's folder fifteen times."""
    from fingerdesign.records.result_files import RESULTS

    for number in range(15):
        with RESULTS.written(target) as folder:
            (folder / "result.json").write_text(f'"{number}"', encoding="utf-8")


def end(how):
    """A signal's number, or an exit code below zero."""
    print("on the way", file=sys.stderr, flush=True)
    if how > 0:
        os.kill(os.getpid(), how)
    os._exit(-how)


def unsent():
    """What no pickle holds."""
    return lambda: None


def eat():
    """Ever more memory."""
    taken = []
    while True:
        taken.append(np.ones(2_000_000))
        time.sleep(0.02)


def endless():
    """Writes on the answers' pipe, without an end."""
    pipes = [n for n in map(int, os.listdir("/proc/self/fd")) if n > 2 and "pipe:" in _target(n)]
    while True:
        for each in pipes:
            try:
                os.write(each, b"x" * 10_000)
            except OSError:  # the one that calls come on
                continue
        time.sleep(0.0002)


def _target(number):
    try:
        return os.readlink(f"/proc/self/fd/{number}")
    except OSError:
        return ""
