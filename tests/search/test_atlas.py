"""The atlas: its entries are what they say, the nearest is found, and what it lacks is reported."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from fingerdesign_bench.atlas.make import candidates

from fingerdesign.checks.load import load_design
from fingerdesign.layout.fitting import gage_fit
from fingerdesign.search.passing import atlas as module
from fingerdesign.search.passing.atlas import (
    PROCESSES,
    Request,
    atlas,
    distance,
    nearest,
    source_of,
    unmet,
)
from fingerdesign.search.passing.ranges import PASSING

NAMES = [each.name for each in atlas().entries]


@pytest.fixture(params=NAMES)
def entry(request):
    return next(each for each in atlas().entries if each.name == request.param)


def test_an_entry_is_of_the_design_that_it_names(entry):
    finger = entry.finger()
    assert entry.digest == finger.digest()
    assert entry.masses_g == finger.grip.masses_g
    assert entry.friction_coefficients == finger.grip.friction_coefficients
    assert entry.gages == source_of(gage_fit(finger).found)
    design, values = candidates()[entry.name]
    assert (entry.design, set(entry.values)) == (design, set(values))


def test_an_entry_passes_all_verdicts_in_3d(entry):
    """As they were judged; .ci/run judges the first one again: it is the finger of `make demo`."""
    assert entry.mesher in ("tetwild", "sweep")
    assert len(entry.verdicts) == 4
    assert {each.status for each in entry.verdicts} == {"pass"}
    assert set(entry.molds) <= set(PROCESSES)
    assert not entry.commit.endswith("+")  # Judged by a state that can be had again.


def test_the_shipped_fingers_that_pass_are_in_it():
    whole = [each.design for each in atlas().entries if not each.values]
    assert whole[0] == "film_tees"
    assert {*PASSING} <= set(whole)


def test_an_entry_meets_its_own_request(entry):
    request = Request(entry.masses_g, entry.gages)
    assert distance(entry, request) == 0.0
    assert list(unmet(entry, request)) == []
    found = nearest(request)
    assert (found.gages, distance(found, request)) == (entry.gages, 0.0)


def test_what_is_not_met_is_said():
    first = atlas().entries[0]
    low, high = 0.25 * first.masses_g[0], 2.0 * first.masses_g[-1]
    other = "bought" if first.gages == "film" else "film"
    request = Request((low, high), other)
    assert distance(first, request) > distance(first, Request((low, high)))
    assert distance(first, Request((low, high))) == pytest.approx(3.0)  # Doublings.
    out = " ".join(unmet(first, request))
    for part in (f"{low:g} g", f"{high:g} g", f"{other} gages"):
        assert part in out


def test_a_mold_that_is_refused_counts_and_is_said():
    first = atlas().entries[0]
    refused = module.MoldOutcome("refused", reasons=("mold.limits.pin_mm = 2: must be less",))
    without = replace(first, molds={**first.molds, "fdm": refused})
    request = Request(process="fdm")
    assert distance(without, request) > distance(without, Request())
    assert list(unmet(without, request)) == ["fdm: no mold: mold.limits.pin_mm = 2: must be less"]


@pytest.mark.parametrize("gages", [None, "film", "bought"])
def test_new_writes_the_finger_that_was_verified(gages, tmp_path, terminal):
    path = tmp_path / "mine.toml"
    given = ["--gages", gages] if gages else []
    meets = gages != "bought"  # No finger with gages that are bought is verified.
    code = 0 if meets else 1
    out = terminal("new", path, "--lift", "500g", "--process", "machined", *given, code=code).out
    found = nearest(Request((500.0,), gages, "machined"))
    assert found.name in out
    written = load_design(path)
    named = {"design": written.design.model_copy(update={"name": found.finger().design.name})}
    assert written.model_copy(update=named).digest() == found.digest
    assert written.mold.process == "machined"
    assert path.read_text("utf-8").startswith(f"# From the atlas: {found.name}")


def test_new_with_what_no_entry_meets_says_so_and_writes_the_nearest(tmp_path, terminal):
    path = tmp_path / "mine.toml"
    out = terminal("new", path, "--lift", "1..90000g", "--json", code=1).out
    found = json.loads(out)
    assert len(found["unmet"]) == 2
    assert path.is_file()
    for more in ([], ["--quiet"]):  # what was not met is a failure, and no quiet one
        ran = terminal("new", path, "--lift", "1g", "--force", *more, code=1)
        assert "not met: 1 g" in ran.err


def test_new_refuses_nonsense_with_all_faults(in_tmp_path, terminal):
    out = terminal("new", "a.toml", "--lift", "9..2", "--gages", "x", "--process", "y", code=2).err
    assert [line.split(" ")[0] for line in out.splitlines()] == ["--gages", "--process", "--lift"]
    for wrong in ("light", "0", "1..2..3", "nan", "-5..1e9"):
        assert "--lift" in terminal("new", "a.toml", "--lift", wrong, code=2).err
    terminal("new", "a.toml", "--lift", "5", "--scene", code=2)
    assert not list(Path().iterdir())
