"""A finger in closed form: an incompressible half-plane with gages (Flamant), numpy only."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.contact.problem import contact_problem
from fingerdesign.shapes.objects import Plane
from tests.support import reduced
from tests.support.reduced import reduced_model

MODULUS, DEPTH = 4.96, 10.0  # MPa, mm
FAR = 12.0  # mm: where the half-plane is held
GAGE_COVER = 1.0  # mm


def flamant_model(nodes=81, half=4.0, radius=20.0, gages=11, reach=5.0):
    """Parabolic crest on a half-plane; plane strain, nu = 1/2, hence normal and shear uncouple.

    A line load f on the surface gives u = 2 (1 - nu^2) / (pi E) f ln(far / distance), spread over
    a node's width on itself, and the radial stress -(2 / pi r) (f . r) / r at a gage; strains are
    taken along 45 degrees.
    """
    x = np.linspace(-half, half, nodes)
    h = x[1] - x[0]
    plane_modulus = MODULUS / 0.75
    distance = np.abs(x[:, None] - x[None])
    ratio = np.log(FAR / np.where(distance > 0, distance, 0.5 * h)) + (distance == 0)
    scalar = 2.0 / (np.pi * plane_modulus * DEPTH) * ratio
    compliance = np.kron(scalar, np.eye(2))
    gage_x = np.linspace(-reach, reach, gages)
    arm = np.stack([gage_x[:, None] - x[None], np.full((gages, nodes), -GAGE_COVER)], axis=-1)
    r = np.linalg.norm(arm, axis=-1)
    along = (arm @ np.array([1.0, 1.0]) / np.sqrt(2.0)) / r
    # eps_theta = -eps_r at nu = 1/2, so eps_45 = eps_r (cos^2 - sin^2).
    strain = -2.0 / (np.pi * plane_modulus * DEPTH) * arm / r[..., None] ** 2
    strain *= (2.0 * along**2 - 1.0)[..., None]
    points = np.column_stack([x, -(x**2) / (2 * radius)])
    areas = np.full(nodes, h * DEPTH)
    areas[[0, -1]] *= 0.5
    rim = np.zeros(nodes, dtype=bool)
    rim[[0, -1]] = True
    return reduced_model(
        points,
        compliance,
        facet_areas=np.full(nodes - 1, h * DEPTH),
        areas=areas,
        gage_readout=np.repeat(strain.reshape(gages, 2 * nodes), 2, axis=0),
        rim=rim,
        depth=DEPTH,
        gage_x=gage_x,
    )


@pytest.fixture(scope="session")
def half_plane():
    return contact_problem(flamant_model(), Plane(0.0), 0.5)


@pytest.fixture(scope="session")
def softer():
    """The same crest, twice as compliant."""
    model = flamant_model()
    return contact_problem(replace(model, compliance=2.0 * model.compliance), Plane(0.0), 0.5)


@pytest.fixture(scope="session")
def bump():
    """In 3-D: 11 x 11 nodes, no gages."""
    return contact_problem(reduced.bump(11), Plane(0.0), 0.5)


@pytest.fixture(scope="session")
def design():
    return parse_design('design.name = "half-plane"\ngrip.defaults = "fixed"')
