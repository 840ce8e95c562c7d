"""A machine's profile: written as a mold is planned, read back, corrected, refused by its keys."""

import pytest

from fingerdesign.errors import DesignError
from fingerdesign.mold.plan.limits import comb_tolerance, limits_of
from fingerdesign.mold.profile import profile_text, with_profile
from tests.support.molds import shipped


def test_a_profile_reads_back_as_it_was_planned_and_goes_before_the_design(tmp_path):
    file = tmp_path / "mine.toml"
    fine = shipped("maeno2000", mold__process="machined", mold__limits={"slot_mm": 0.31})
    file.write_text(profile_text(fine), encoding="utf-8")
    found = with_profile(shipped("maeno2000", mold__process="fdm"), file)
    assert found.mold.process == "machined"
    assert limits_of(found.mold) == limits_of(fine.mold)
    assert (comb_tolerance(found.mold), found.mold.comb.sheet_mm) == (0.005, 0.3)
    measured = file.read_text("utf-8").replace("tolerance_mm = 0.005", "tolerance_mm = 0.017")
    file.write_text(measured, encoding="utf-8")
    assert comb_tolerance(with_profile(fine, file).mold) == 0.017
    assert found.digest() == fine.digest()  # no analysis depends on it


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("[limits]\nslots_mm = 0.3\n", "limits.slots_mm"),
        ("[comb]\ntolerance_mm = -1.0\n", "comb.tolerance_mm"),
        ("limits = 3\n", "limits"),
        ("[limits\n", "file"),
        ("", "file"),
        ("wire_mm = 3.0\n", "wire_mm"),
        ("[mold.limits]\nhole_mm = 1.0\n", "mold.limits"),
        ('[limits]\n"hole.mm" = 1.0\n', "limits.hole.mm"),
    ],
)
def test_a_wrong_profile_is_refused_by_its_key(tmp_path, text, key):
    file = tmp_path / "mine.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(DesignError) as error:
        with_profile(shipped("maeno2000"), file)
    assert [fault.key for fault in error.value.faults] == [key]
    assert "mine.toml" in str(error.value)
