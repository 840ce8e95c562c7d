"""The closed-form finger of tests/control, for studies of grips."""

import runpy
from pathlib import Path

import pytest

from fingerdesign.contact.objects import Plane
from fingerdesign.contact.problem import contact_problem

CONTROL = Path(__file__).parents[1] / "control" / "conftest.py"


@pytest.fixture(scope="session")
def half_plane_problem():
    return contact_problem(runpy.run_path(str(CONTROL))["flamant_model"](), Plane(0.0), 0.5)
