"""Measures of an increment: borders between nodes, and what counts at a free end."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.contact.increment import ContactState, solve_increment
from fingerdesign.contact.measures import border_compliances, completely_slips, measure
from fingerdesign.contact.problem import Motion


def test_borders_take_what_a_node_yields_beyond_its_neighbours(strip):
    """In plane strain; the border of stick a fourth more than that of contact, as measured."""
    opened, slipped = border_compliances(strip)
    assert opened == pytest.approx(4.0 * strip.own_compliance)
    assert slipped == pytest.approx(1.25 * opened)


def test_borders_in_space_take_all_that_a_node_yields(patch):
    opened, slipped = border_compliances(patch)
    assert opened == pytest.approx(patch.self_compliance)
    assert slipped == pytest.approx(opened)


def test_pressures_of_a_free_end_are_no_peak(patch):
    """There the corner of two free faces is singular: its value is the mesh's."""
    found = solve_increment(patch, ContactState.untouched(patch), Motion(0.01, 0.0))
    pressure = found.multiplier[:, 0] / patch.model.areas
    order = np.argsort(pressure)
    ends = np.zeros(len(pressure), dtype=bool)
    ends[order[-3:]] = True
    cut = replace(patch, model=replace(patch.model, free_end=ends))
    assert measure(patch, found).peak_pressure == pytest.approx(pressure[order[-1]])
    assert measure(cut, found).peak_pressure == pytest.approx(pressure[order[-4]])
    assert pressure[order[-4]] < pressure[order[-1]]


def test_complete_slip_is_of_a_contact_that_is_pressed_and_pulled(patch):
    """Below a hundredth, in space a twentieth."""
    found = measure(patch, solve_increment(patch, ContactState.untouched(patch), Motion(0.01, 0)))
    names = ("normal_force", "tangential_force", "stick_area", "contact_area")
    slips = {(1.0, 0.1, 0.9, 100.0): (2, 3), (1.0, 0.1, 1.1, 100.0): (3,)}
    sticks = [(1.0, 0.1, 5.1, 100.0), (1.0, 0.0, 0.0, 9.0), (1.0, -0.1, 0.0, 9.0)]
    sticks += [(0.0, 0.1, 0.0, 9.0), (1.0, 0.1, 0.0, 0.0)]
    for values, dims in (slips | dict.fromkeys(sticks, ())).items():
        each = replace(found, **dict(zip(names, values, strict=True)))
        assert tuple(dim for dim in (2, 3) if completely_slips(each, dim)) == dims
