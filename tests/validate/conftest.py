"""Models in space half as fine as those of the command: what they tell is of signs and sizes."""

import pytest

from fingerdesign.validate import solves


@pytest.fixture(scope="module", autouse=True)
def _coarse():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(solves, "SPACE", (4.0, 6.0))
        yield
