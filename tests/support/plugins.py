"""Packages that bring kinds, as if they were installed."""

import os
from contextlib import contextmanager
from pathlib import Path

import pytest

from fingerdesign.runtime.isolate import Worker

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
