"""Reports of the newer kinds of finger: in words, in rows, and what pictures are made of."""

import dataclasses

import numpy as np
import pytest

from fingerdesign.analysis.page.gage import plate_rows, strain_figure
from fingerdesign.analysis.page.picture import cast, gage_quads, region_of
from fingerdesign.analysis.page.words import finger_words
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.records.arrays import GageLayout
from fingerdesign.report.style import house_style

GAGES = GageLayout(1.0, 0.6, 0.2, "both")
FLAT = PlateFrame(0, 0.5, 3.0, 30.0, 2.0, 0.1, -0.5, 2.5)
ALONG_Z = PlateFrame(1, 0.7, 3.0, 40.0, 2.0, 0.1, -1.0, 0.6, along="z")
BENT = PlateFrame(2, 0.5, 3.0, 20.0, 2.0, 0.1, -0.5, 2.5, bend_radius=3.0)


@pytest.mark.parametrize("frame", [FLAT, ALONG_Z, BENT])
def test_gages_are_drawn_on_their_plates_faces(frame):
    quads = gage_quads((frame,), GAGES).reshape(-1, 3)
    s, v = frame.local(quads).T
    across = frame.across(quads) - frame.middle
    assert np.allclose(np.abs(v), 0.07)
    assert np.abs(s).max() == pytest.approx(0.5)
    assert (across.min(), across.max()) == pytest.approx((-0.1, 0.5))


@pytest.mark.parametrize("frame", [FLAT, ALONG_Z, BENT])
def test_plates_are_drawn_closed_and_outward(frame):
    """The plate's own volume, to VTK's single precision: no triangle is missing or turned."""
    rings = [tuple(frame.to_space(frame.outline(), end) for end in (frame.low, frame.high))]
    (drawn,) = cast({"rings": rings})
    drawn = drawn.compute_normals(consistent_normals=True, auto_orient_normals=True)
    volume = abs(drawn.volume)
    wanted = frame.length * frame.thickness * frame.span
    assert volume == pytest.approx(wanted, rel=2e-3 if frame.bend_radius else 1e-5)


def test_rows_are_distinguished():
    row = [dataclasses.replace(FLAT, index=k, place=float(k)) for k in range(3)]
    deep = [dataclasses.replace(FLAT, index=3 + k, place=float(k), y=1.0) for k in range(2)]
    across = [dataclasses.replace(ALONG_Z, index=5 + k, place=3.0 + k) for k in range(2)]
    assert plate_rows([*row, *deep, *across]) == ((0, 1, 2), (3, 4), (5, 6))
    assert plate_rows(row[::-1], placed=True) == ((0, 1, 2),)
    assert plate_rows([]) == ()


def test_a_row_along_z_is_drawn_over_z(plane_strain):
    """Two rows, two pairs of panels, each over the direction along which its plates differ."""
    result = plane_strain.result
    plates = list(plane_strain.plates)
    for k in range(10, 15):
        plates[k] = dataclasses.replace(ALONG_Z, index=k, place=float(k - 12))
    with house_style():
        image = strain_figure(result, plates).image
        plain = strain_figure(result, plane_strain.plates).image
    assert "plate centre x (mm)" in image
    assert "plate centre z (mm)" in image
    assert "Row 2." in image
    assert "plate centre z (mm)" not in plain
    assert "Row 1." not in plain


def test_a_core_is_its_own_region(plane_strain):
    mesh = plane_strain.mesh
    regions = np.where(mesh.points[mesh.cells[:, 0], 1] < 2.0, 16, mesh.regions)
    cored = dataclasses.replace(mesh, regions=regions, region_names={16: "core"})
    assert np.array_equal(region_of(cored, "core"), regions == 16)
    assert np.array_equal(region_of(cored, "plates"), (regions > 0) & (regions < 16))
    assert not region_of(mesh, "core").any()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, "20 mm wide, 10 mm deep, with an arc of radius 20 mm"),
        ({"body.edge_radius_mm": 2.0}, "rounded with a radius of 2 mm"),
        ({"body.edge_radius_mm": 1.5, "body.edge": "chamfer"}, "chamfered by 1.5 mm"),
        ({"body.shape": "block"}, "a flat top"),
        ({"body.shape": "revolved"}, "20 mm across, with a round cap of radius 20 mm"),
        ({"body.shape": "dome", "body.dome_radius_mm": 25.0}, "20 mm in x and 25 mm in z"),
        ({"body.shape": "step", "body.width_mm": 20.0}, "own STEP file, 20 mm wide and 10 mm deep"),
        (
            {"body.core.width_mm": 6.0, "body.core.height_mm": 3.0, "body.core.material": "abs"},
            "A core of abs, 6 mm wide, 3 mm high and over the full depth, is bonded inside, "
            "standing on the base.",
        ),
        ({"plates.rows": [{"along": "z", "count": 4}]}, "; 4 plates in a row along z, 2 mm below"),
        ({"plates.placement": [[0.0, 1.0, 2.0]]}, "Inside: 1 plate placed one by one."),
        ({"plates.count": 0}, "It has no plates."),
        ({"plates.follow": "bent", "plates.hole_diameter_mm": 0.6}, "holes 0.6 mm across"),
        ({"plates.model": "sheet"}, "In the model they are sheets"),
    ],
)
def test_the_finger_in_words(plane_strain, changes, said):
    assert said in finger_words(plane_strain.result.parameters | changes)


def test_no_words_without_the_designs_keys(failed):
    assert finger_words(failed.result.parameters) == ""
