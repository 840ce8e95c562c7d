"""What every run of tests needs: cached work in one folder, one thread, and fixtures shared by all.

Cached meshes and bodies lie in one folder for all workers of a run, never in the user's own. Each
process computes on one thread: MKL's threads wait by spinning, and where workers share the cores
that takes five times as long (a section of 34k dofs: 4.5 s of processor time, 23 s with two).
"""

import contextlib
import gc
import os
import signal
import sys
import tempfile
from itertools import pairwise

import pytest

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy comes; workers inherit it
# Python's own threshold of 700 new objects looks for cycles so often that it takes a tenth of the
# time: each full look goes through all libraries, syntax trees and collected tests.
gc.set_threshold(50_000, 20, 20)

pytest_plugins = [
    *("tests.support.closed_form_analysis", "tests.support.closed_form_plants"),
    *("tests.support.golden", "tests.support.plugins"),
]


def pytest_configure(config):
    if not hasattr(config, "workerinput"):
        config.cache_folder = tempfile.TemporaryDirectory(prefix="fingerdesign-tests-")
        os.environ["FINGERDESIGN_CACHE"] = config.cache_folder.name


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items):
    """Files with slow tests come first in each worker's part: short ones are left for the end."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    parts = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    ends = [len(items) * part // parts for part in range(parts + 1)]
    for begin, end in pairwise(ends):
        items[begin:end] = sorted(items[begin:end], key=lambda item: item.path not in slow)


def pytest_collection_finish():
    gc.freeze()  # what is there now stays to the end


def pytest_unconfigure(config):
    if not hasattr(config, "workerinput"):
        config.cache_folder.cleanup()


@pytest.fixture(autouse=True, scope="session")
def warm_processes():
    """Processes with limits start with all that they need loaded."""
    from tests.support.warm import forks

    with forks():
        yield


@pytest.fixture
def interruptible():
    """Where the tests run in the background, their process ignores interruptions from the start."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def in_tmp_path(tmp_path):
    """Work in the test's own folder."""
    with contextlib.chdir(tmp_path):
        yield


@pytest.fixture
def cache_in(monkeypatch):
    """Use another folder as the cache."""

    def use(folder):
        monkeypatch.setenv("FINGERDESIGN_CACHE", str(folder))

    return use


@pytest.fixture
def own_cache(tmp_path, cache_in):
    """Use the test's own folder as the cache."""
    cache_in(tmp_path)


@pytest.fixture
def full_disk(monkeypatch):
    """Let every durable write fail as on a full disk."""

    def full(number):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)


@pytest.fixture
def not_installed(monkeypatch):
    """``not_installed(library)``: importing it fails as where it is missing."""
    return lambda library: monkeypatch.setitem(sys.modules, library, None)


@pytest.fixture
def children_find(monkeypatch):
    """``children_find(folder)``: processes that are started import modules from it."""

    def find(folder):
        paths = [str(folder), os.environ.get("PYTHONPATH", "")]
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join(paths))

    return find


@pytest.fixture
def importable(monkeypatch, tmp_path):
    """Modules in the test's own folder can be imported."""
    monkeypatch.syspath_prepend(str(tmp_path))


@pytest.fixture
def calls_of(monkeypatch):
    """``calls_of(owner, name)``: the list of (arguments, answer) of all calls from then on."""

    def recorded(owner, name):
        calls, function = [], getattr(owner, name)

        def recording(*given, **named):
            calls.append((given, None))
            found = function(*given, **named)
            calls[-1] = given, found
            return found

        monkeypatch.setattr(owner, name, recording)
        return calls

    return recorded


@pytest.fixture(scope="session")
def one_browser(tmp_path_factory):
    """One Chromium for all pages: its start, and its first WebGL, take seconds."""
    from tests.support.browser import Browser

    folder = tmp_path_factory.mktemp("window")
    blank = folder / "blank.html"
    blank.write_text("<title>blank</title>", encoding="utf-8")
    with Browser(blank, folder) as browser:
        yield browser


@pytest.fixture(scope="module")
def window(one_browser):
    """Its window. A page that draws in space takes an eighth of a core as long as it is open."""
    yield one_browser
    one_browser.goto(one_browser.work / "blank.html")


@contextlib.contextmanager
def never_called(owner, *names):
    """Within the block a call of these fails the test: what they do was done before, or must not
    be begun."""
    with pytest.MonkeyPatch.context() as patch:
        for name in names:
            patch.setattr(owner, name, lambda *_, **__: pytest.fail("work was begun"))
        yield


@pytest.fixture
def terminal(capsys):
    """Run the command line to an exit code; return what it printed, ``out`` and ``err``."""
    from fingerdesign_cli.main import main

    def run(*arguments, code=0):
        assert main([str(each) for each in arguments]) == code
        return capsys.readouterr()

    return run
