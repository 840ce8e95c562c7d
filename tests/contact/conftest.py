"""Elastic half-spaces with coupled nodes, numpy alone: stand-ins for fingers."""

import numpy as np
import pytest

from fingerdesign.contact import increment
from fingerdesign.contact.problem import contact_problem
from fingerdesign.contact.solver.tracking import Tracker
from fingerdesign.shapes.friction import FrictionLaw
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import bump, reduced_model

# What a strip or a patch of conftest is pressed by, MPa.
PRESSED = 0.07
SCALED = {
    "capped": FrictionLaw(0.3, 0.1 * PRESSED, cap=0.35 * PRESSED),
    "shear strength": FrictionLaw(0.0, 0.3 * PRESSED),
    "power": FrictionLaw(0.4, exponent=1.0 / 3.0, reference=PRESSED),
}


@pytest.fixture
def numpy_alone(monkeypatch):
    """Increments that no compiled code follows."""
    monkeypatch.setattr(increment, "tracker_of", Tracker)


@pytest.fixture(scope="session")
def strip():
    """Incompressible half-plane under a crest of radius 20 (Flamant, far point 12 mm away)."""
    x = np.linspace(-3.0, 3.0, 121)
    h = x[1] - x[0]
    distance = np.abs(x[:, None] - x[None])
    scalar = 0.1 * (np.log(12.0 / np.where(distance > 0, distance, 0.5 * h)) + (distance == 0))
    rim = np.zeros(len(x), dtype=bool)
    rim[[0, -1]] = True
    points = np.column_stack([x, -(x**2) / 40.0])
    areas = {"facet_areas": np.full(120, 121 * h / 120), "areas": np.full(121, h)}
    model = reduced_model(points, np.kron(scalar, np.eye(2)), rim=rim, **areas)
    return contact_problem(model, Plane(0.0), 0.5)


@pytest.fixture(scope="session")
def patch():
    """A bump of radius 20 on springs coupled by 1/r, equal in x, y and z: a 17 x 17 grid."""
    return contact_problem(bump(17), Plane(0.0), 0.5)
