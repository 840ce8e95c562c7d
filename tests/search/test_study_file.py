"""Study files: what they say, and what a stranger may write into them."""

import math
import time
from pathlib import Path

import pytest

from fingerdesign.errors import DesignError
from fingerdesign.search.study.file import parse_study, read_study
from fingerdesign.search.study.values import Range, key_faults
from fingerdesign.search.study.variants import base_design

HEAD = '[study]\nname = "few"\nbase = "maeno2000"\nsampling = "grid"\n'
ONE = '[parameters]\n"body.depth_mm" = [10.0, 12.0]\n'


def refused(text):
    """Every fault of a study, those of its base too; each is one printable line."""
    with pytest.raises(DesignError) as caught:
        base_design(parse_study(text))
    for fault in caught.value.faults:
        assert str(fault).isprintable()
        assert len(str(fault)) < 1500
    return str(caught.value)


def parameters(lines):
    return f"{HEAD}[parameters]\n{lines}\n"


def test_a_whole_study():
    study = parse_study(
        '[study]\nname = "s"\nbase = "maeno2000"\nsampling = "sobol"\ncount = 3\n'
        '[fixed]\n"gages.length_mm" = 0.4\n[parameters]\n'
        '"plates.count" = { low = 9, high = 17, step = 2 }\n"plates.material" = ["polyimide"]\n'
        '[[objectives]]\nmetric = "stick_error"\n[[objectives]]\nmetric = "plates"\ngoal = "max"\n'
        "[constraints]\ngrip_success = { at_least = 0.9 }\n"
    )
    assert [objective.direction for objective in study.objectives] == ["min", "max"]
    assert study.constraints["grip_success"].excess(0.5) == pytest.approx(0.4)
    assert study.constraints["grip_success"].excess(None) == math.inf
    assert base_design(study).gages.length_mm == 0.4
    assert base_design(study).design.name == "s"


def test_keys_without_quotes_mean_the_same():
    quoted = parse_study(HEAD + '[fixed]\n"plates.length_mm" = 1.5\n' + ONE)
    plain = parse_study(
        HEAD + "[fixed]\nplates.length_mm = 1.5\n[parameters.body]\ndepth_mm=[10.0, 12.0]"
    )
    assert plain.digest() == quoted.digest()
    # A table in [fixed] sets its keys alone, not the whole table.
    assert base_design(plain).plates.count == 15


def test_ranges():
    even = Range(low=9, high=17, step=2)
    assert [even.at(share) for share in (0.0, 0.25, 0.5, 0.99)] == [9, 11, 13, 17]
    assert Range(low=0.7, high=1.2, step=0.25).levels == 3
    assert Range(low=1, high=4).levels == 4
    assert Range(low=1.0, high=4.0).levels is None
    assert Range(low=1.0, high=100.0, log=True).at(0.5) == 10.0
    narrow = Range(low=1000000.1, high=1000000.2)
    found = {narrow.at(share / 10) for share in range(10)}
    assert len(found) == 10
    assert all(1000000.1 <= each <= 1000000.2 for each in found)


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        ("", ["study.name = (absent)", "parameters = {}"]),
        ("x = [", ["valid TOML"]),
        ("x = " + "[" * 50_000, ["too deeply nested"]),
        (HEAD, ["parameters = {}: must be a table of at least one key"]),
        (HEAD + "[Parameters]\n", ["did you mean parameters?"]),
        (HEAD + 'scenes = ["a.toml", "b/a.toml"]\n' + ONE, ["scenes = 'b/a.toml'", "different"]),
        (HEAD + ONE + "[limit]\n", ["did you mean limits?"]),
        (HEAD + "count = 5\n" + ONE, ["study.count = 5", "absent where sampling = 'grid'"]),
        (HEAD.replace("grid", "sobol") + ONE, ["study.count = (absent)"]),
        (parameters('"body.depth_mm" = 5.0'), ["a list of choices or a range"]),
        (parameters('"body.depth_mm" = []'), ["at least 1"]),
        (parameters('"body.depth_mm" = [1.0, 1.0]'), ["values that differ; say 1.0 once"]),
        (parameters('"body.depth_mm" = [nan, inf]'), ["[0] = nan", "[1] = inf"]),
        (parameters('"body.depth_mm" = [[1], { a = 1 }]'), ["[0] = [1]", "[1] = a table"]),
        (parameters('"body.depth_mm" = [0x' + "f" * 9000 + "]"), ["a huge number"]),
        (parameters('"body.depth_mm" = { low = 2.0 }'), ['"body.depth_mm".high', "given"]),
        (parameters('"body.depth_mm" = { low = 2.0, high = 1.0 }'), ["more than low = 2.0"]),
        (parameters('"body.depth_mm" = { low = "a", high = 1.0 }'), ["remove the quotes"]),
        (parameters('"body.depth_mm" = { low = 1.0, hihg = 2.0 }'), ["did you mean", "high"]),
        (parameters('"a.b" = { low = 0.0, high = 1.0, log = true }'), ["remove log"]),
        (parameters('"a.b" = { low = 0.0, high = 1.0, step = 1e-300 }'), ["high - low"]),
        (parameters('"a.b" = { low = 0.0, high = 1.0, step = 2.0 }'), ["high - low"]),
        (HEAD + ONE + '[[objectives]]\nmetric = "strick_error"\n', ["did you mean 'stick_error'?"]),
        (HEAD + ONE + '[[objectives]]\nmetric = "normal_force_N"\n', ["add goal"]),
        (HEAD + ONE + 2 * '[[objectives]]\nmetric = "cost"\n', ["no other objective has"]),
        (HEAD + ONE + "[constraints]\ncots = { at_most = 1.0 }\n", ["did you mean 'cost'?"]),
        (HEAD + ONE + "[constraints]\ncost = {}\n", ["at_least or at_most"]),
        (HEAD + ONE + "[constraints]\ncost = { at_least = 2.0, at_most = 1.0 }\n", ["at most"]),
        (HEAD + ONE + "[limits]\ntime_s = 0.0\nmemory_MB = 1.0\n", ["time_s", "memory_MB"]),
        (HEAD + ONE + "[scene]\nfriction_coefficient = 0.5\n", ["bench plane-strain"]),
        (HEAD + ONE + "[cost]\nplate = 1e300\n", ["at most 1"]),
    ],
)
def test_every_fault_is_reported(text, reported):
    found = refused(text)
    for each in reported:
        assert each in found


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        (parameters('"plates.cuont" = [5]'), ["did you mean plates.count?"]),
        (parameters('"plates.count" = { low = 9, high = 9000 }'), ["= 9000: must be at most"]),
        (parameters('"plates.count" = { low = 9.0, high = 11.0 }'), ["a whole number"]),
        (parameters('"plates.count" = { low = 9, high = 11, step = 1.0 }'), ["a whole number"]),
        (
            parameters('"plates.material" = ["bronze", "polyimide"]'),
            ["'bronze'", "a known material"],
        ),
        (parameters('"body.shape" = ["arc", "cube"]'), ["'cube'", "one of"]),
        (parameters('"body.depth_mm.x" = [5]'), ['"body.depth_mm.x"']),
        (HEAD + '[fixed]\n"plates.cuont" = 5\n' + ONE, ['fixed."plates.cuont"', "plates.count?"]),
        (
            HEAD + '[fixed]\n"gages.face" = "left"\n"gages.width_mm" = 1e9\n' + ONE,
            ["face", "width"],
        ),
        (HEAD + '[fixed]\n"gages.width_mm" = 0x' + "f" * 9000 + "\n" + ONE, ["a huge number"]),
        (HEAD + '[fixed]\n"plates.material" = "\\u0000"\n' + ONE, ["control characters"]),
        (HEAD + '[fixed]\n"mold.cure" = 0x' + "f" * 9000 + "\n" + ONE, ["a huge number"]),
        (parameters('"plates.placement[0][0" = [1.0]'), ["a dotted key, such as"]),
        (parameters('"plates..count" = [1]\n"/" = [1]'), ["a dotted key, such as"]),
        (HEAD + '[fixed]\n"gages.width_mm" = 1979-05-27\n' + ONE, ["a number"]),
        (HEAD + "[fixed]\n" + ".".join("a" * 3000) + " = 1\n" + ONE, ["8 tables deep"]),
        (
            HEAD + '[fixed]\n"plates.rows" = [{ ' + ".".join("a" * 3000) + " = 1 }]\n" + ONE,
            ["deep"],
        ),
        (HEAD + '[fixed]\n"body.depth_mm" = 10.0\n' + ONE, ["in [fixed] too"]),
        (HEAD + '[fixed]\n"body.depth_mm" = 10.0\nbody.depth_mm = 11.0\n' + ONE, ["given once"]),
        (parameters('"plates.span_mm / plates.material" = [1.0]'), ["holds a number"]),
        (
            parameters('"plates.span_mm / body.depth" = { low = 0.5, high = 1.0 }'),
            ["holds a number"],
        ),
        (parameters('"plates.span_mm / body.depth_mm" = ["a"]'), ["numbers: shares"]),
        (parameters('"plates.count / body.depth_mm" = [0.5]'), ["a whole number"]),
        (
            parameters(
                "".join(f'"grip.k{each}" = {{ low = 1, high = 1000 }}\n' for each in range(9))
            ),
            ["1000000000000000000000000000 variants"],
        ),
        (
            parameters('"body.depth_mm" = { low = 5.0, high = 9.0 }'),
            ["where study.sampling = 'grid'"],
        ),
        (HEAD.replace("maeno2000", "maeno200") + ONE, ["did you mean maeno2000?"]),
        (HEAD.replace("maeno2000", "/dev/zero") + ONE, ["an ordinary file"]),
        (HEAD.replace("maeno2000", "x" * 500) + ONE, ["study.base", "too long"]),
    ],
)
def test_keys_are_held_against_the_schema_before_work(text, reported):
    found = refused(text)
    for each in reported:
        assert each in found


@pytest.mark.parametrize(
    "name", ["../x", "a/b", "..", "", "<b>x</b>", "a\\nb", "a\\u0000", "x" * 65]
)
def test_names_that_could_leave_the_folder_or_inject_are_refused(name):
    assert "study.name" in refused(HEAD.replace('"few"', f'"{name}"') + ONE)


def test_a_parameter_cannot_name_the_variants():
    for key in ("design.name", "design[0].name", "design"):
        assert "the study names its variants" in refused(parameters(f'"{key}" = ["a", "b"]'))
        assert "the study names its variants" in refused(HEAD + f'[fixed]\n"{key}" = "a"\n' + ONE)


@pytest.mark.parametrize(
    "text",
    [
        HEAD.replace("maeno2000", "x\\u001b[31m") + ONE,
        parameters('"body.\\u001b[31m\\u007f\\u202edepth" = [1]'),
        HEAD + '"\\u001b[2J\\u007f" = 1\n' + ONE,
        parameters('"body.shape" = ["arc\\u202e"]'),
        HEAD + 'scenes = ["a\\u0000b"]\n' + ONE,
        HEAD.replace("maeno2000", "x" * 1_000_000) + ONE,
        parameters('"' + "x" * 1_000_000 + '" = [1]'),
        parameters('"body.shape" = ["' + "x" * 1_000_000 + '"]'),
        HEAD + '"' + "x" * 1_000_000 + '" = 1\n' + ONE,
        parameters('"body.shape" = [' + "[1]," * 150 + "]\n" + '"body.x" = [' + "[1]," * 150 + "]"),
    ],
    ids=range(10),
)
def test_hostile_text_is_refused_in_short_printable_lines(text):
    start = time.perf_counter()
    assert len(refused(text)) < 50_000
    assert time.perf_counter() - start < 5.0


def test_files_beyond_every_size_are_refused(tmp_path):
    big = tmp_path / "big.toml"
    big.write_text(HEAD + ONE + "# " + "x" * 10_000_000, "utf-8")
    with pytest.raises(DesignError, match="at most 4000000 bytes"):
        read_study(big)
    with pytest.raises(DesignError, match="readable TOML file"):
        read_study(tmp_path)
    (tmp_path / "latin.toml").write_bytes(b'[study]\nname = "\xe9"')
    with pytest.raises(DesignError, match="UTF-8"):
        read_study(tmp_path / "latin.toml")


def test_shipped_studies_are_found_by_name_and_distinguished(tmp_path, monkeypatch):
    assert read_study("fingers").name == "fingers"
    with pytest.raises(DesignError, match="bench plane-strain"):
        read_study("plane_strain")
    with pytest.raises(DesignError, match="did you mean fingers"):
        read_study("finger")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fingers").write_text(HEAD + ONE, "utf-8")  # a file comes first
    assert read_study("fingers").name == "few"


def test_files_lie_beside_the_study(tmp_path, monkeypatch):
    from fingerdesign.checks.starter import shipped_text

    home = tmp_path / "home"
    home.mkdir()
    (home / "own.toml").write_text(shipped_text("narrow"), "utf-8")
    (home / "study.toml").write_text(
        HEAD.replace("maeno2000", "own.toml") + '[parameters]\n"mesh.file" = ["a.msh", "/b.msh"]\n',
        "utf-8",
    )
    monkeypatch.chdir(tmp_path)
    study = read_study("home/study.toml")
    assert study.parameters["mesh.file"] == (str(home / "a.msh"), "/b.msh")
    assert (
        base_design(study, home).body.width_mm != base_design(read_study("fingers")).body.width_mm
    )
    again = parse_study((home / "study.toml").read_text("utf-8"), "home/study.toml")
    assert again.digest() == study.digest()
    with pytest.raises(DesignError, match=r"own\.toml"):
        base_design(study, Path("elsewhere"))


def test_two_parameters_of_one_key_and_shares_of_shares():
    assert not key_faults({}, ["a.b / c.d", "c.d"])
    assert "no other parameter" in str(key_faults({}, ["a.b", "a.b / c.d"])[0])
    assert "no share itself" in str(key_faults({}, ["a.b / c.d", "c.d / e.f"])[0])


def test_unknown_keys_are_reported_at_once_whatever_they_need_around_them():
    for key in ("body.a b", "no.such", "plates.count.x"):
        assert key in refused(parameters(f'"{key}" = [1, 2]'))
    assert 'fixed."body.a b"' in refused(HEAD + '[fixed]\n"body.a b" = 1\n' + ONE)
    reported = refused(
        parameters('"body.nokey" = [1, 2, 3]\n"plates.count" = [9, 9000]')
    ).splitlines()
    assert len(reported) == 2


def test_many_wrong_choices_are_judged_quickly_and_reported_in_part():
    numbers = ", ".join(str(each) for each in range(200))
    for key, most in (("body.nokey{}", 100), ("grip.k{}.x", 100)):
        lines = "".join(f'"{key.format(each)}" = [{numbers}]\n' for each in range(100))
        text = HEAD.replace("grid", "sobol") + "count = 4\n[parameters]\n" + lines
        start = time.perf_counter()
        assert len(refused(text).splitlines()) <= most
        assert time.perf_counter() - start < 10.0
    low = ", ".join(str(-each) for each in range(1, 200))
    keys = ("body.depth_mm", "body.arc_radius_mm", "plates.length_mm", "gages.length_mm")
    lines = "".join(f'"{key}" = [{low}]\n' for key in keys)
    reported = refused(HEAD.replace("grid", "sobol") + "count = 4\n[parameters]\n" + lines)
    assert len(reported.splitlines()) == 201
    assert "more than 200 faults" in reported
