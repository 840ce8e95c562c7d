"""What a file or an argument says is printed, never obeyed by the terminal."""

from dataclasses import replace

import pytest

from tests.support.result_folders import write_result_folder

BAD = "a\x1b[31m\x9b2J\u202e\x07\x7fb"


@pytest.fixture
def printed(terminal):
    """``printed(code, *arguments)``: what a command printed, all of it printable."""

    def run(code, *arguments):
        shown = terminal(*arguments, code=code)
        assert all(line.isprintable() for line in (shown.out + shown.err).splitlines())
        return shown

    return run


@pytest.mark.parametrize(
    ("code", "arguments"),
    [
        (2, ["check", f"{BAD}.toml"]),
        (2, ["sweep", f"{BAD}.toml", "--out", "out"]),
        (2, ["compare", BAD, "--out", "page.html"]),
        (2, ["compare", "x", "--out", "page.html", "--objective", BAD]),
        (2, ["sweep", "x", f"--{BAD}"]),
        (2, [BAD]),
        (2, ["compare", "\udcff\udc9b", "--out", "page.html"]),
        (2, ["sweep", "fingers", "--out", "out", "--scheduler", f"tcp://{BAD}:1"]),
    ],
    ids=range(8),
)
def test_arguments(code, arguments, in_tmp_path, printed):
    shown = printed(code, *arguments)
    assert "\\u202e" in shown.err or "\\udcff" in shown.err


def test_what_a_record_holds(tmp_path, printed, plane_strain):
    made = plane_strain.result
    bad = replace(made, design=BAD, scene=BAD, warnings=(f"{BAD}\nreport: /fake",))
    write_result_folder(tmp_path / "a", bad)
    shown = printed(0, "view", tmp_path / "a").out.splitlines()
    assert sum(line.startswith("report: ") for line in shown) == 1
