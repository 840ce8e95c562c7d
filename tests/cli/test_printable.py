"""What a file or an argument says is printed, never obeyed by the terminal."""

from dataclasses import replace

import pytest
from fingerdesign_cli.main import main
from fingerdesign_cli.terminal import print_table

from tests.support.closed_form_analysis import make_analysis
from tests.support.result_folders import write_result_folder

BAD = "a\x1b[31m\x9b2J\u202e\x07\x7fb"


@pytest.mark.parametrize(
    "arguments",
    [
        ["check", f"{BAD}.toml"],
        ["sweep", f"{BAD}.toml", "--out", "out"],
        ["compare", BAD, "--out", "page.html"],
        ["compare", "x", "--out", "page.html", "--objective", BAD],
        ["sweep", "x", f"--{BAD}"],
        [BAD],
        ["sweep", "fingers", "--out", "out", "--scheduler", f"tcp://{BAD}:1"],
        ["compare", "\udcff\udc9b", "--out", "page.html"],
    ],
    ids=range(8),
)
def test_arguments(arguments, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert main(arguments) in (1, 2)
    said = capsys.readouterr()
    assert said.err
    assert all(line.isprintable() for line in (said.out + said.err).splitlines())
    assert "\\u202e" in said.err or "\\udcff" in said.err


def test_what_a_file_holds(tmp_path, capsys):
    path = tmp_path / "d.toml"
    path.write_text('[design]\nname = "a\\u001b[31m\\u202e"\n"k\\u001b" = 1\n')
    assert main(["check", str(path)]) == 2
    assert all(line.isprintable() for line in capsys.readouterr().err.splitlines())


def test_what_a_record_holds(tmp_path, capsys):
    made = make_analysis().result
    made = replace(made, design=BAD, scene=BAD, warnings=(f"{BAD}\nreport: /fake",))
    write_result_folder(tmp_path / "a", made)
    assert main(["view", str(tmp_path / "a")]) == 0
    said = capsys.readouterr().out.splitlines()
    assert all(line.isprintable() for line in said)
    assert sum(line.startswith("report: ") for line in said) == 1


def test_a_record_that_cannot_be_shown_is_refused_before_any_is(tmp_path, capsys):
    made = make_analysis().result
    write_result_folder(tmp_path / "a", made)
    write_result_folder(tmp_path / "b", replace(made, parameters={"plates.count": "x"}))
    assert main(["view", str(tmp_path)]) == 2
    said = capsys.readouterr()
    assert not said.out
    assert "RESULT = " in said.err


def test_tables(capsys):
    print_table(BAD, [BAD, "b"], [[BAD, "1"]])
    said = capsys.readouterr().out
    assert all(line.isprintable() for line in said.splitlines())
