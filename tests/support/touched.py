"""Which tests run which lines: a plugin of pytest, so that a mutant meets those alone.

    python -m pytest -p tests.support.touched --touched FILE tests/contact ...

FILE: {"lines": {"path:line": [test, ...]}, "seconds": {test: s}}, of the package's own lines. What
a fixture of several tests runs counts for each of them; what a cache spares a later test does not.
"""

import json
import sys
import threading
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = f"{ROOT / 'fingerdesign'}/"


def pytest_addoption(parser):
    """The file to be written."""
    parser.addoption("--touched", type=Path, required=True)


def pytest_configure(config):
    """Watch this run."""
    config.pluginmanager.register(_Watch(config.getoption("--touched")))


class _Watch:
    """Lines by what runs them: the uppermost of a test and its shared fixtures."""

    def __init__(self, file):
        self.file = file
        self.stack = [set()]
        self.tests, self.fixtures = {}, defaultdict(set)
        self.uses, self.seconds = {}, defaultdict(float)

    def _call(self, frame, _event, _value):
        name = frame.f_code.co_filename
        return self._line if name.startswith(PACKAGE) else None

    def _line(self, frame, event, _value):
        if event == "line":
            self.stack[-1].add((frame.f_code.co_filename, frame.f_lineno))
        return self._line

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        """One test, with all that it sets up."""
        self.stack.append(set())
        self.uses[item.nodeid] = getattr(item, "fixturenames", ())
        threading.settrace(self._call)
        sys.settrace(self._call)
        try:
            return (yield)
        finally:
            sys.settrace(None)
            threading.settrace(None)
            self.tests[item.nodeid] = self.stack.pop()

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef):
        """One fixture; those of a single test are the test's."""
        if fixturedef.scope == "function":
            return (yield)
        self.stack.append(set())
        try:
            return (yield)
        finally:
            lines = self.stack.pop()
            self.fixtures[fixturedef.argname] |= lines
            self.stack[-1] |= lines

    def pytest_runtest_logreport(self, report):
        """Seconds of a test, its fixtures' too."""
        self.seconds[report.nodeid] += report.duration

    def pytest_sessionfinish(self):
        """Write what was seen."""
        lines = defaultdict(list)
        for test, own in self.tests.items():
            for path, line in own.union(*(self.fixtures[name] for name in self.uses[test])):
                lines[f"{Path(path).relative_to(ROOT)}:{line}"].append(test)
        self.file.write_text(json.dumps({"lines": lines, "seconds": self.seconds}), "utf-8")
