"""What a record's folder may take the place of."""

import pytest

from fingerdesign.records.base import ResultError
from fingerdesign.records.folder import RecordFolder

FILES = ("a.json", "*.csv")


@pytest.mark.parametrize("filled", [False, True])
def test_only_a_folder_that_is_filled_in_place_may_lack_its_record(tmp_path, filled):
    """One that is written as a whole has its record last, and so always."""
    kind = RecordFolder("toy", "a.json", FILES, filled=filled)
    kind.refuse_foreign(tmp_path / "none")
    (tmp_path / "rows.csv").touch()
    if filled:
        kind.refuse_foreign(tmp_path)
    else:
        with pytest.raises(ResultError, match=r"rows\.csv but no a\.json"):
            kind.refuse_foreign(tmp_path)
    (tmp_path / "a.json").touch()
    kind.refuse_foreign(tmp_path)
    (tmp_path / "mine.txt").touch()
    with pytest.raises(ResultError, match=r"mine\.txt, which is no toy"):
        kind.refuse_foreign(tmp_path)
