"""Fixtures that several folders of tests share stand in tests/support.

Kept meshes and bodies lie in one folder for all workers of a run, never in the user's own.
"""

import os
import tempfile

pytest_plugins = ["tests.support.closed_form_analysis", "tests.support.closed_form_plants"]

collect_ignore = ["support"]  # its modules are no tests; those of plug-ins register toys


def pytest_configure(config):
    if not hasattr(config, "workerinput"):  # workers inherit it
        config.kept = tempfile.TemporaryDirectory(prefix="fingerdesign-tests-")
        os.environ["FINGERDESIGN_CACHE"] = config.kept.name


def pytest_unconfigure(config):
    if not hasattr(config, "workerinput"):
        config.kept.cleanup()
