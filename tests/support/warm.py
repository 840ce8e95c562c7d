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
import socket
import subprocess
import sys
import threading
import weakref
from io import FileIO
from multiprocessing import connection, forkserver
from types import SimpleNamespace

import psutil

from fingerdesign.runtime import isolate
from fingerdesign.runtime.child import PARENT, serve

_SERVER = forkserver.ForkServer()
_SERVER.set_forkserver_preload(["tests.support.loaded"])


@contextlib.contextmanager
def forks():
    """Within the block, processes with limits are forks, but in tests of processes."""
    usual = isolate.subprocess
    isolate.subprocess = SimpleNamespace(**vars(subprocess) | {"Popen": _popen})
    try:
        yield
    finally:
        isolate.subprocess = usual


def _popen(command, **named):
    if os.environ.get("PYTEST_CURRENT_TEST", "").startswith("tests/runtime"):
        return subprocess.Popen(command, **named)
    return _Forked(command[4:], named["cwd"], named["env"], named["stderr"])


def forked_from_here():
    """Let processes with limits be forks of what this one has loaded. It has one thread as yet."""
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(connection.arbitrary_address("AF_UNIX"))
        listener.listen()
        ends, alive = os.pipe()
        pid = os.fork()
        if not pid:
            os.close(alive)
            try:
                forkserver.main(listener.fileno(), ends, [])
            finally:
                os._exit(0)
        os.close(ends)
        _SERVER._forkserver_address = listener.getsockname()
    _SERVER._forkserver_alive_fd, _SERVER._forkserver_pid = alive, pid


def running():
    """The forks that run now."""
    pid = _SERVER._forkserver_pid
    return set() if pid is None else set(psutil.Process(pid).children())


class _Forked:
    """What ``runtime.isolate`` needs of a Popen."""

    def __init__(self, words, folder, environment, errors):
        calls, write = os.pipe()
        read, answers = os.pipe()
        leads, ready = os.pipe()
        given = [calls, answers, errors.fileno(), ready]
        self._status, start = _SERVER.connect_to_new_process(given)
        weakref.finalize(self, os.close, self._status)
        self._lock = threading.Lock()
        with open(start, "wb") as stream:
            pickle.dump({}, stream)
            pickle.dump(_Serving(words, str(folder), dict(environment)), stream)
        for own in (calls, answers, ready):
            os.close(own)
        with FileIO(leads) as stream:
            stream.read(1)  # from now on its group can be ended
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
            with self._lock:
                if self.returncode is None:
                    self.returncode = forkserver.read_signed(self._status)
        return self.returncode


class _Serving:
    """What runs in the fork."""

    def __init__(self, words, folder, environment):
        self.words, self.folder, self.environment = words, folder, environment

    def _bootstrap(self, parent_sentinel):
        os.setsid()
        # The server, and so this process, ends with the one that started them.
        os.close(forkserver._forkserver._forkserver_alive_fd)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        *streams, ready = forkserver.get_inherited_fds()
        os.close(ready)
        for number, own in enumerate(streams):
            os.dup2(own, number)
        os.chdir(self.folder)
        os.environ.clear()
        os.environ.update(self.environment)
        os.environ["ASKED_BY"] = self.environment[PARENT]
        os.environ[PARENT] = str(os.getppid())
        sys.path[:0] = self.environment["PYTHONPATH"].split(os.pathsep)
        sys.argv = ["-c", *self.words]
        try:
            serve()
        finally:
            atexit._run_exitfuncs()
        return 0
