"""What a user gets from the built wheel, in an empty folder, with no checkout in sight."""

import math
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from fingerdesign.design.starter import starter_text
from fingerdesign.records.result_files import read_result
from tests.support.coarser import write_coarser

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The wheel's content, unpacked: what pip would put into site-packages."""
    folder = tmp_path_factory.mktemp("wheel")
    built = subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    (wheel,) = folder.glob("*.whl")
    site = folder / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    return site


def run(installed, cwd, *commands):
    """Commands from the wheel's files until one fails; a checkout on the path would be a false
    pass."""
    code = (
        "import sys, fingerdesign, fingerdesign_cli.main as m;"
        f"assert fingerdesign.__file__.startswith({str(installed)!r}), fingerdesign.__file__;"
        "sys.exit(next(filter(None, (m.main(each.split()) for each in sys.argv[1:])), 0))"
    )
    return subprocess.run(
        [sys.executable, "-c", code, *commands],
        cwd=cwd,
        env=os.environ | {"PYTHONPATH": str(installed)},
        capture_output=True,
        text=True,
        check=False,
    )


def test_types_ship(installed):
    assert (installed / "fingerdesign" / "py.typed").is_file()


@pytest.mark.slow
def test_new_check_analyse(installed, tmp_path):
    (tmp_path / "mine.toml").write_text(starter_text("mine"), "utf-8")
    write_coarser(tmp_path / "mine.toml")
    shipped = [f"new {name}.toml --from {name}" for name in ("maeno2000", "domed")]
    analyse = "analyse mine.toml --out out --fidelity plane-strain --page --cad"
    commands = ["new new.toml", *shipped, "check new.toml maeno2000.toml domed.toml", analyse]
    done = run(installed, tmp_path, *commands)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "out" / "mine"
    wanted = {"result.json", "history.csv", "report.html", "finger.step", "finger.stl"}
    assert wanted <= {path.name for path in folder.iterdir()}
    assert list(folder.glob("fields_*.vtu"))
    assert (folder / "report.html").stat().st_size > 100_000
    result = read_result(folder)
    assert (result.status, len(result.grips)) == ("ok", 1)
    assert all(map(math.isfinite, result.timings_s.values()))
    assert result.timings_s["geometry"] > 0
