"""Programs run by processes that have loaded the libraries already: a killed driver is started in
a twentieth of a second, not in three. Each is a real process, with signals, limits and an end of
its own.
"""

import atexit
import contextlib
import multiprocessing
import os
import resource
import runpy
import signal
import sys

from tests.support import warm

_LIBRARIES = (
    "fingerdesign_cli.studies.search",
    "distributed.cli.dask_scheduler",
    "sklearn",
)
_CONTEXT = multiprocessing.get_context("forkserver")


class Program:
    """``python *command`` from a folder, with an environment; files there take what it writes.

    most_bytes: of any file that it writes, as on a full disk.
    """

    def __init__(self, command, folder, environment, most_bytes=None):
        _CONTEXT.set_forkserver_preload([*_LIBRARIES, "distributed.cli.dask_worker"])
        number = sum(1 for _ in folder.glob("*.stdout"))
        self._written = [folder / f"{number}.{name}" for name in ("stdout", "stderr")]
        given = [str(each) for each in command], folder, environment, self._written, most_bytes
        self._process = _CONTEXT.Process(target=_run, args=given)
        self._process.start()
        self.pid = self._process.pid

    @property
    def returncode(self):
        """Exit code, or the signal's number below zero; None while it runs."""
        return self._process.exitcode

    def poll(self):
        """Exit code; None while it runs."""
        return self._process.exitcode

    def send_signal(self, sign):
        """Send a signal to it."""
        os.kill(self.pid, sign)

    def kill(self):
        """Kill it; what has ended stays as it is."""
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()

    def communicate(self, timeout=None):
        """What it has written to the terminal, once it has ended."""
        self._process.join(timeout)
        assert self.returncode is not None, "it did not end"
        return [path.read_text("utf-8") for path in self._written]


def _run(command, folder, environment, written, most_bytes):
    import dask

    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number, path in enumerate(written, 1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), number)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[:0] = environment["PYTHONPATH"].split(os.pathsep)
    dask.config.refresh()  # it was loaded with another environment
    warm.forked_from_here()
    if most_bytes is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
    try:
        with warm.forks():
            if command[0] == "-m":
                sys.argv = command[1:]
                runpy.run_module(command[1], run_name="__main__", alter_sys=True)
            else:
                sys.argv = command
                runpy.run_path(command[0], run_name="__main__")
    finally:
        atexit._run_exitfuncs()  # multiprocessing's processes end without
