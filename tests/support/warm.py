"""Processes of ``runtime.isolate`` that have loaded what they need: they are forked from one that
has. The CAD kernel takes 2 s to load, a half-second's work is done with it, and so with others.

That a process is a fresh one is tested in tests/runtime.
"""

import atexit
import contextlib
import os
import pickle
import select
import signal
import subprocess
import sys
from io import FileIO
from multiprocessing import forkserver

import psutil

from fingerdesign.runtime.child import PARENT, serve

_SERVER = forkserver.ForkServer()
_SERVER.set_forkserver_preload(["tests.support.loaded"])


def popen(command, **named):
    """As ``subprocess.Popen`` of a process that serves: a fork, but for tests of processes."""
    if os.environ.get("PYTEST_CURRENT_TEST", "").startswith("tests/runtime"):
        return subprocess.Popen(command, **named)
    return _Forked(command[4:], named["cwd"], named["env"], named["stderr"])


def running():
    """The forks that run now."""
    pid = _SERVER._forkserver_pid
    return set() if pid is None else set(psutil.Process(pid).children())


class _Forked:
    """What ``runtime.isolate`` needs of a Popen."""

    def __init__(self, words, folder, environment, errors):
        calls, write = os.pipe()
        read, answers = os.pipe()
        given = [calls, answers, errors.fileno()]
        self._status, start = _SERVER.connect_to_new_process(given)
        with open(start, "wb") as stream:
            pickle.dump({}, stream)
            pickle.dump(_Serving(words, str(folder), dict(environment)), stream)
        os.close(calls), os.close(answers)
        self.stdin, self.stdout = FileIO(write, "w"), FileIO(read)
        self.pid = forkserver.read_signed(self._status)
        self.returncode = None

    def poll(self):
        """Exit code, or the signal's number below zero; None while it runs."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.wait(0.0)
        return self.returncode

    def wait(self, timeout=None):
        """The exit code, once it has ended. TimeoutExpired if it does not."""
        if self.returncode is None:
            if not select.select([self._status], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired("serve", timeout)
            self.returncode = forkserver.read_signed(self._status)
            os.close(self._status)
        return self.returncode


class _Serving:
    """What runs in the fork."""

    def __init__(self, words, folder, environment):
        self.words, self.folder, self.environment = words, folder, environment

    def _bootstrap(self, parent_sentinel):
        os.setsid()
        signal.signal(signal.SIGINT, signal.default_int_handler)
        for number, own in enumerate(forkserver.get_inherited_fds()):
            os.dup2(own, number)
        os.chdir(self.folder)
        os.environ.clear()
        os.environ.update(self.environment)
        os.environ[PARENT] = str(os.getppid())
        sys.path[:0] = self.environment["PYTHONPATH"].split(os.pathsep)
        sys.argv = ["-c", *self.words]
        try:
            serve()
        finally:
            atexit._run_exitfuncs()
        return 0
