"""The certificate alone: zero where the laws hold, and each of its parts sees its own violation."""

import numpy as np
import pytest

from fingerdesign.contact.laws import Certificate, certify

FRICTION, COMPLIANCE = 0.5, 0.01
# A node that sticks, one that slips against its force, one that is open.
FORCES = np.array([[2.0, 0.4, 0.0], [4.0, -2.0, 0.0], [0.0, 0.0, 0.0]])  # N
MOTION = np.array([[0.0, 0.0, 0.0], [0.0, 0.03, 0.0], [0.02, 0.1, 0.0]])  # mm


def of(node, part, force=None, motion=None):
    """The certificate with one entry of the forces or of the motion changed."""
    forces, moved = FORCES.copy(), MOTION.copy()
    if force is not None:
        forces[node, part] = force
    if motion is not None:
        moved[node, part] = motion
    total = np.array([1.0, -6.0, 0.0])
    return certify(forces, moved, COMPLIANCE, FRICTION, -total, total)


def test_the_laws_hold():
    assert of(0, 0, force=2.0).laws < 1e-12


@pytest.mark.parametrize(
    ("changed", "law", "violation"),
    [
        ({"node": 2, "part": 0, "force": -0.4}, "complementarity", 0.4 / 4.0),
        ({"node": 2, "part": 0, "motion": -0.01}, "complementarity", 0.01 / (4.0 * COMPLIANCE)),
        ({"node": 0, "part": 0, "motion": 0.01}, "complementarity", 0.01 / (4.0 * COMPLIANCE)),
        ({"node": 0, "part": 1, "force": 1.8}, "coulomb", 0.8 / 4.0),
        ({"node": 0, "part": 2, "motion": 0.08}, "dissipation", 1.0 / 4.0),  # slips below its bound
        ({"node": 1, "part": 1, "motion": -0.08}, "dissipation", 2 * 2.0 / 4.0),  # along its force
    ],
)
def test_each_part_sees_its_violation(changed, law, violation):
    found = of(**changed)
    assert getattr(found, law) == pytest.approx(violation)
    assert found.laws >= violation * (1.0 - 1e-12)


def test_forces_that_do_not_balance_are_seen():
    found = certify(FORCES, MOTION, COMPLIANCE, FRICTION, np.zeros(3), np.array([0.0, -0.6, 0.0]))
    assert found.balance == pytest.approx(0.1)


def test_no_number_is_no_certificate():
    forces = FORCES.copy()
    forces[0, 0] = np.nan
    total = np.zeros(3)
    found = certify(forces, MOTION, COMPLIANCE, FRICTION, total, total)
    assert found == Certificate(*4 * [np.inf])
