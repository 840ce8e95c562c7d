"""Packages that bring kinds, as if they were installed."""

import os
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from fingerdesign.runtime.child import ALLOWED, MODULES
from fingerdesign.runtime.isolate import Worker
from fingerdesign.runtime.registry import CONTROLLERS

ROOT = Path(__file__).resolve().parents[2]


@contextmanager
def installed(folder, points):
    """A process in ``folder`` that finds the packages there. points: lines of entry points."""
    about = folder / "plugins-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: plugins\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[fingerdesign.plugins]\n{points}\n")
    paths = [str(folder), str(ROOT), str(ROOT / "cli"), os.environ.get("PYTHONPATH", "")]
    with pytest.MonkeyPatch.context() as patch, Worker(folder=folder) as worker:
        patch.setenv("PYTHONPATH", os.pathsep.join(paths))
        yield worker


@pytest.fixture
def nothing_allowed(monkeypatch):
    """A user who has permitted no code: none that a file names is known or found."""
    monkeypatch.setattr(sys, "path", [each for each in sys.path if each])
    monkeypatch.setattr(CONTROLLERS, "_references", {})
    for name in (ALLOWED, MODULES):
        monkeypatch.setenv(name, "")
