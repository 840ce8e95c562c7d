"""A library of an extra that is not there: one line with the remedy, before any work."""

import pytest
from fingerdesign_cli.main import main

from fingerdesign.runtime.extras import MissingExtra, needs


def test_what_is_there_needs_nothing():
    needs("search", "json")


def test_all_that_lacks_is_named_with_one_remedy():
    wanted = r'missing: no_such_a and no_such_b\): pip install "fingerdesign\[some\]"'
    with pytest.raises(MissingExtra, match=wanted) as found:
        needs("some", "no_such_a", "json", "no_such_b")
    assert isinstance(found.value, ImportError)


@pytest.mark.parametrize(
    ("command", "library", "extra"),
    [
        (["sweep", "fingers"], "distributed", "search"),
        (["optimise", "maeno2000"], "distributed", "search"),
        (["studio", "homogeneous", "--no-open"], "trame", "studio"),
    ],
)
def test_a_command_ends_with_the_remedy_at_once(
    command, library, extra, not_installed, capsys, tmp_path, in_tmp_path
):
    not_installed(library)
    assert main(command) == 1
    printed = capsys.readouterr().err.strip()
    assert printed.startswith(f"failed: this needs the extra {extra} (missing: {library}): ")
    assert printed.endswith(f'pip install --editable ".[{extra}]"')
    assert list(tmp_path.iterdir()) == []
