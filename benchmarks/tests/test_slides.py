"""Hands whose object grows heavier, by the bench that shows it; on a coarse section."""

from fingerdesign_bench.studies.slides import measure_slides

from fingerdesign.checks.load import with_values
from fingerdesign.checks.starter import find_design

COARSE = {
    "mesh.section.contact_size_mm": 0.2,
    "mesh.section.plate_size_mm": 0.8,
    "mesh.section.plate_end_size_mm": 0.5,
}


def test_what_answers_catches_and_what_holds_a_margin_holds():
    design = with_values(find_design("sensitive"), COARSE)
    rows = measure_slides(design, ["reactive"], [0.6], [0.2, 0.6])
    held, caught = rows
    assert (held.outcome, held.slid_mm, held.catch_s) == ("held", 0.0, None)
    assert (caught.outcome, held.share, caught.share) == ("caught", 0.2, 0.6)
    assert 0.0 < caught.slid_mm < 5.0
    assert 0.0 < caught.catch_s < 0.3
    assert 30.0 < caught.swing_Hz < 100.0
