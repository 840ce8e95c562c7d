"""STEP bodies are read in this process."""

import pytest

from tests.support.steps import read_here


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch):
    read_here(monkeypatch)
