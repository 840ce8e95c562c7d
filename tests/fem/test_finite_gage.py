"""Gages at finite strain: elongation of their own line, whatever the plate's motion."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fingerdesign.errors import SolverError
from fingerdesign.fem.finite.row import gage_lines
from fingerdesign.fem.readout import gage_rows
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section

_spec = importlib.util.spec_from_file_location(
    "fem_finite_frames", Path(__file__).with_name("test_gage_frames.py")
)
frames = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(frames)

ALL = [frames.FLAT, frames.ALONG_Z, frames.LEVEL_Z, frames.UPRIGHT_Z, frames.BENT]


@pytest.fixture(scope="module")
def whole():
    return extrude(frames.design_of(), 2.0, symmetric=False)


@pytest.fixture(scope="module")
def half():
    return extrude(frames.design_of(), 2.0, symmetric=True)


@pytest.fixture(scope="module")
def section():
    return mesh_section(frames.design_of(), 2.0)


def moved(mesh, gradient):
    return mesh.points @ (gradient - np.eye(mesh.dimension)).T


def turn(dim, angle):
    c, s = np.cos(angle), np.sin(angle)
    found = np.eye(dim)
    found[:2, :2] = [[c, -s], [s, c]]
    return found


@pytest.mark.parametrize("frame", ALL)
def test_a_turn_reads_nothing_in_space(whole, frame):
    gradient = turn(3, 0.8) @ turn(3, 0.3).T[[2, 0, 1]][:, [2, 0, 1]]
    strains = gage_lines(whole, [frame], frames.GAGES).strains(moved(whole, gradient) + 0.4)
    assert np.abs(strains).max() < 1e-13


@pytest.mark.parametrize("frame", [frames.FLAT, frames.BENT])
def test_a_turn_reads_nothing_in_the_section(section, frame):
    strains = gage_lines(section, [frame], frames.GAGES).strains(moved(section, turn(2, 1.2)))
    assert np.abs(strains).max() < 1e-13


@pytest.mark.parametrize("frame", [frames.FLAT, frames.ALONG_Z, frames.UPRIGHT_Z])
def test_a_large_homogeneous_strain_is_the_axis_own_stretch(whole, frame):
    gradient = np.eye(3) + 0.3 * np.random.default_rng(4).normal(size=(3, 3))
    strains = gage_lines(whole, [frame], frames.GAGES).strains(moved(whole, gradient))
    stretch = np.linalg.norm(gradient @ frame.direction(frame.axis))
    assert np.allclose(strains, stretch - 1.0, atol=1e-13)


@pytest.mark.parametrize("frame", ALL)
@pytest.mark.parametrize("which", ["whole", "half"])
def test_small_motions_read_what_the_small_strain_rows_do(request, which, frame):
    """Of a bent plate to what chords leave of arcs; in a half also where gages cross z = 0."""
    mesh = request.getfixturevalue(which)
    x, y, z = mesh.points.T
    field = np.stack(
        [x * y + 0.3 * z * z, np.sin(x) + 0.2 * y * y, z * (0.5 + 0.1 * x * y)], axis=1
    )
    wanted = (gage_rows(mesh, [frame], frames.GAGES) @ field.ravel()).reshape(-1, 2)
    small = 1e-7
    found = gage_lines(mesh, [frame], frames.GAGES).strains(small * field) / small
    scale = np.abs(wanted).max()
    assert np.abs(found - wanted).max() < (2e-3 if frame.bend_radius else 2e-6) * scale


def test_sheets_are_refused(section):
    slot = {"plate_0_upper": np.zeros((0, 3), dtype=int)}
    with pytest.raises(SolverError, match=r"plates\.model"):
        gage_lines(replace(section, facets=section.facets | slot), [frames.FLAT], frames.GAGES)


def test_no_plates_no_strains(section):
    assert gage_lines(section, [], frames.GAGES).strains(section.points).shape == (0, 2)
