"""The 3-D study of grids, coarse: tees are read where single gages are; what is shipped follows."""

import numpy as np
import pytest
from fingerdesign_bench.studies.grids import FLAT, FRICTIONS, fingers, measure_grids, sizes_of
from fingerdesign_bench.studies.grids_chart import draw_grids

from fingerdesign.checks.load import with_values

COARSE = {"mesh.section.plate_size_mm": 0.8, "mesh.section.plate_end_size_mm": 0.5}


@pytest.mark.slow
def test_a_tees_area_follows_where_a_single_gages_does_not():
    """On a mesh of seconds, up to a friction of 0.7; beyond it a single facet's slip counts."""
    design = with_values(fingers([])["cover 0.6, plates 0.7 mm"], COARSE)
    rows = measure_grids({"finger": design}, "extrude", 0.6, 2)
    assert [row.grid for row in rows] == ["axial", "tee"]
    single, tee = (row.correlations for row in rows)
    assert len(single) == len(FRICTIONS)
    assert max(single) < 0.5
    assert min(tee[:4]) > 0.75


@pytest.mark.slow
def test_the_shipped_fingers_area_follows_in_order_and_in_size():
    """What its file says, on fewer layers than its docs' numbers."""
    single, tee = measure_grids(fingers(["fine_tees"]), "extrude", 0.4, 4)
    assert max(single.correlations) < 0.0
    assert min(tee.correlations) >= 0.95
    assert min(tee.full_stick_mm) > 5.0
    assert max(tee.slipping_mm) < 1.5
    assert max(tee.giving_way_mm) < 3.0


def test_in_plane_strain_a_tee_reads_what_a_single_gage_does(tmp_path):
    coarse = {
        "mesh.section.contact_size_mm": 0.2,
        "mesh.section.plate_size_mm": 0.3,
        "mesh.section.plate_end_size_mm": 0.1,
    }
    design = with_values(fingers(["maeno2000"])["maeno2000"], coarse)
    single, tee = measure_grids({"finger": design}, FLAT, 0.4, 1, pieces=1)
    assert tee.gage_area_mm == single.gage_area_mm
    assert all(len(areas) <= 8 for areas in tee.gage_area_mm)
    assert draw_grids([single, tee], tmp_path / "grids.png").stat().st_size > 10_000


def test_sizes_are_those_of_the_last_spot_and_of_what_slides():
    area = np.array([5.0, 4.0, 2.0, 0.5, 1.0])
    assert sizes_of(np.array([0.9, 0.4, 0.04, 0.0, 0.0]), area, 0.05) == (2.0, 1.0)
    assert sizes_of(np.array([0.9, 0.4, 0.3, 0.2, 0.01]), area, 0.05) == (1.0, None)
    assert sizes_of(np.array([0.9, 0.4, 0.3, 0.2, 0.1]), area, 0.05) == (None, None)


def test_a_finger_without_gages_is_refused_in_words(said):
    shown = said("bench", "grids", "maeno2000", "homogeneous", code=2).err
    assert shown.startswith("homogeneous: plates.count = 0: must be at least 1; add plates")
