"""Bars on plates: a stretched finger's energy, no effect in plane strain, digest."""

import numpy as np
import pytest

from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.design.leads import Leads
from fingerdesign.fem.bars import bar_stiffness
from fingerdesign.fem.readout import gage_rows
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from tests.support.fingers import SMALL

GAGES = {"gages.length_mm": 0.5, "gages.width_mm": 1.0}
WIRE = {"gages.leads.kind": "wire", "gages.leads.number": 4, "gages.leads.diameter_mm": 0.1}


@pytest.fixture(scope="module")
def finger():
    design = with_values(parse_design(SMALL), GAGES)
    return design, extrude(design, Zone(2.0, None), True, design.mesh.section)


def energy(stiffness, motion):
    whole = stiffness + stiffness.T
    whole.setdiag(0.5 * whole.diagonal())
    return 0.5 * motion @ whole @ motion


@pytest.mark.parametrize("strain", [(0.0, 0.0, 1e-3), (2e-3, 2e-3, 0.0)])
def test_a_uniform_strain_has_the_bars_energy(finger, strain):
    design, mesh = finger
    design = with_values(design, {**WIRE, "gages.kind": "silicon_bar_05", "gages.face": "upper"})
    motion = (mesh.points * np.array(strain)).ravel()
    found = energy(bar_stiffness(design, mesh, plate_frames(design)), motion)
    copper = 4 * 120e3 * np.pi * 0.05**2  # N, of a plate
    bar = design.gage_type
    leads = 2 * 0.5 * copper * strain[2] ** 2 * (3.0 - 0.5)  # from the gage's edge to the end
    gages = 2 * 0.5 * bar.stiffness * bar.carrier_width_mm * bar.carrier_length_mm * strain[0] ** 2
    assert found == pytest.approx(leads + gages, rel=1e-6)


def test_plane_strain_and_a_finger_without_leads_have_no_bars(finger):
    design, mesh = finger
    frames = plate_frames(design)
    assert bar_stiffness(design, mesh, frames) is None
    wired = with_values(design, WIRE)
    assert bar_stiffness(wired, mesh_section(wired, 2.0, wired.mesh.section), frames) is None
    assert bar_stiffness(with_values(wired, {"gages.leads.kind": "none"}), mesh, frames) is None


def test_leads_count_in_the_digest_and_a_gage_by_what_it_stiffens(finger):
    design, _ = finger
    digests = {
        each.digest()
        for each in (
            design,
            with_values(design, WIRE),
            with_values(design, {"gages.kind": "silicon_bar_05"}),
            with_values(design, {"gages.kind": "silicon_bar_05", "mold.leads": "leg"}),
        )
    }
    assert len(digests) == 3


def test_a_wire_is_as_stiff_as_its_metal():
    assert Leads(diameter_mm=0.2).stiffness == pytest.approx(120e3 * np.pi * 0.01)
    assert Leads(kind="traces", width_mm=0.1, thickness_mm=0.01).stiffness == pytest.approx(120.0)


@pytest.mark.parametrize(("face", "sides"), [("upper", [0]), ("lower", [1]), ("both", [0, 1])])
def test_gages_stiffen_the_faces_that_they_are_on(finger, face, sides):
    design, mesh = finger
    design = with_values(design, {"gages.kind": "silicon_bar_05", "gages.face": face})
    frames, bar = plate_frames(design), design.gage_type
    size = {"length_mm": bar.carrier_length_mm, "width_mm": bar.carrier_width_mm}
    rows = gage_rows(mesh, frames, design.gages.model_copy(update=size), (1.0, 0.0))
    motion = np.random.default_rng(0).normal(size=mesh.points.size)
    strains = (rows @ motion).reshape(-1, 2)[:, sides]
    expected = 0.5 * bar.stiffness * size["length_mm"] * size["width_mm"] * (strains**2).sum()
    assert energy(bar_stiffness(design, mesh, frames), motion) == pytest.approx(expected)


def test_a_way_to_the_end_of_less_than_a_twentieth_of_the_span_has_no_leads(finger):
    design, mesh = finger
    for width, leads in ((5.3, True), (5.5, False)):
        wired = with_values(design, {**WIRE, "gages.width_mm": width})
        assert (bar_stiffness(wired, mesh, plate_frames(design)) is not None) == leads
