"""The 3-D study of grids, coarse: tees are read where single gages are."""

import pytest
from fingerdesign_bench.studies.grids import FRICTIONS, fingers, measure_grids

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


def test_a_finger_without_gages_is_refused_in_words(said):
    shown = said("bench", "grids", "maeno2000", "homogeneous", code=2).err
    assert shown.startswith("homogeneous: plates.count = 0: must be at least 1; add plates")
