"""Study files: what they say, and what a stranger may write into them.

Variants: sampled as requested, the same every time, invalid ones with their reasons.
"""

import itertools
import math
import time
from collections import Counter
from pathlib import Path

import pytest

from fingerdesign.design.schema import safe_name
from fingerdesign.design.shipped import shipped_text
from fingerdesign.errors import DesignError
from fingerdesign.search.study.file import parse_study, read_study
from fingerdesign.search.study.values import Range, set_keys, value_of
from fingerdesign.search.study.variants import (
    base_design,
    number_of_points,
    points,
    variant_of,
    variants,
)

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


def fixed(lines):
    return f"{HEAD}[fixed]\n{lines}\n{ONE}"


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
    # Keys without quotes mean the same; a table in [fixed] sets its keys alone.
    quoted = parse_study(HEAD + '[fixed]\n"plates.length_mm" = 1.5\n' + ONE)
    plain = parse_study(
        HEAD + "[fixed]\nplates.length_mm = 1.5\n[parameters.body]\ndepth_mm=[10.0, 12.0]"
    )
    assert plain.digest() == quoted.digest()
    assert base_design(plain).plates.count == 15


def test_ranges():
    even = Range(low=9, high=17, step=2)
    assert [even.at(share) for share in (0.0, 0.25, 0.5, 0.99)] == [9, 11, 13, 17]
    for each in (even, Range(low=1, high=4), Range(low=0.7, high=1.2, step=0.25)):
        counts = Counter(each.at((k + 0.5) / 120) for k in range(120))
        assert set(counts.values()) == {120 // each.levels}  # the ends as often as the middle
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
        (HEAD + "[Parameters]\n", ["did you mean parameters?"]),
        (HEAD + 'scenes = ["a.toml", "b/a.toml"]\n' + ONE, ["scenes = 'b/a.toml'", "different"]),
        (HEAD + "count = 5\n" + ONE, ["study.count = 5", "absent where sampling = 'grid'"]),
        (HEAD.replace("grid", "sobol") + ONE, ["study.count = (absent)"]),
        (parameters('"body.depth_mm" = 5.0'), ["a list of choices or a range"]),
        (parameters('"body.depth_mm" = [1.0, 1.0]'), ["values that differ; give 1.0 once"]),
        (parameters('"body.depth_mm" = [nan, inf]'), ["[0] = nan", "[1] = inf"]),
        (parameters('"body.depth_mm" = [0x' + "f" * 9000 + "]"), ["a huge number"]),
        (parameters('"body.depth_mm" = { low = 2.0 }'), ['"body.depth_mm".high', "given"]),
        (parameters('"body.depth_mm" = { low = 2.0, high = 1.0 }'), ["more than low = 2.0"]),
        (parameters('"a.b" = { low = 0.0, high = 1.0, log = true }'), ["remove log"]),
        (parameters('"a.b" = { low = 0.0, high = 1.0, step = 1e-300 }'), ["high - low"]),
        (HEAD + ONE + '[[objectives]]\nmetric = "strick_error"\n', ["did you mean 'stick_error'?"]),
        (HEAD + ONE + '[[objectives]]\nmetric = "normal_force_N"\n', ["add goal"]),
        (HEAD + ONE + 2 * '[[objectives]]\nmetric = "cost"\n', ["no other objective has"]),
        (HEAD + ONE + "[constraints]\ncots = { at_most = 1.0 }\n", ["did you mean 'cost'?"]),
        (HEAD + ONE + "[constraints]\ncost = { at_least = 2.0, at_most = 1.0 }\n", ["at most"]),
        (HEAD + ONE + "[limits]\ntime_s = 0.0\nmemory_MB = 1.0\n", ["time_s", "memory_MB"]),
        (HEAD + ONE + "[scene]\nfriction_coefficient = 0.5\n", ["bench plane-strain"]),
        # Keys are held against the schema of designs before work.
        (parameters('"plates.cuont" = [5]'), ["did you mean plates.count?"]),
        (parameters('"plates.count" = { low = 9, high = 9000 }'), ["= 9000: must be at most"]),
        (parameters('"plates.material" = ["bronze"]'), ["'bronze'", "a known material"]),
        (parameters('"gages.kind" = ["foil_03", "bronze"]'), ["'bronze'", "one of foil_03"]),
        (parameters('"mold.gage" = ["auto", "bronze"]'), ["'bronze'", "auto or one of foil_03"]),
        (
            HEAD + 'scenes = ["pull"]\n' + ONE + '[[objectives]]\nmetric = "peak_ratio"\n',
            ["'peak_ratio'", "it has no grips", "leave out study.scenes"],
        ),
        (parameters('"body.depth_mm.x" = [5]'), ['"body.depth_mm.x"']),
        (fixed('"plates.cuont" = 5'), ['fixed."plates.cuont"', "plates.count?"]),
        (fixed('"plates.material" = "\\u0000"'), ["control characters"]),
        (parameters('"plates.placement[0][0" = [1.0]'), ["a dotted key, such as"]),
        (fixed('"gages.width_mm" = 1979-05-27'), ["a number"]),
        (fixed(".".join("a" * 3000) + " = 1"), ["20 tables or arrays deep"]),
        (fixed('"body.depth_mm" = 10.0'), ["in [fixed] too"]),
        (fixed('"body.depth_mm" = 10.0\nbody.depth_mm = 11.0'), ["given once"]),
        (parameters('"plates.span_mm / plates.material" = [1.0]'), ["holds a number"]),
        (parameters('"plates.span_mm / body.depth_mm" = ["a"]'), ["numbers: shares"]),
        (parameters('"plates.count / body.depth_mm" = [0.5]'), ["a whole number"]),
        (parameters('"a.b" = [1.0]\n"a.b / c.d" = [0.5]'), ["no other parameter"]),
        (parameters('"a.b / c.d" = [0.5]\n"c.d / e.f" = [0.5]'), ["no share itself"]),
        (
            parameters("".join(f'"grip.k{k}" = {{ low = 1, high = 1000 }}\n' for k in range(9))),
            ["1000000000000000000000000000 variants"],
        ),
        (parameters('"body.depth_mm" = { low = 5.0, high = 9.0 }'), ["sampling = 'grid'"]),
        (HEAD.replace("maeno2000", "maeno200") + ONE, ["did you mean maeno2000?"]),
        (HEAD.replace("maeno2000", "/dev/zero") + ONE, ["no ordinary file"]),
        (HEAD.replace("maeno2000", "x" * 500) + ONE, ["study.base", "too long"]),
        (parameters('"body.a b" = [1, 2]'), ["body.a b"]),
        *(
            (HEAD.replace('"few"', f'"{name}"') + ONE, ["study.name"])
            for name in ("../x", "a/b", "..", "", "<b>x</b>", "a\\nb", "a\\u0000", "x" * 65)
        ),
        *(
            (table(f'"{key}" = {value}'), ["the study names its variants"])
            for table, value in ((parameters, '["a", "b"]'), (fixed, '"a"'))
            for key in ("design.name", "design[0].name", "design")
        ),
    ],
    ids=itertools.count(),
)
def test_every_fault_is_reported(text, reported):
    found = refused(text)
    for each in reported:
        assert each in found


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
    big, latin = tmp_path / "big.toml", tmp_path / "latin.toml"
    big.write_text(HEAD + ONE + "# " + "x" * 10_000_000, "utf-8")
    latin.write_bytes(b'[study]\nname = "\xe9"')
    stated = {big: "larger than 2 MB", tmp_path: "readable TOML file", latin: "UTF-8"}
    for path, words in stated.items():
        with pytest.raises(DesignError, match=words):
            read_study(path)


def test_shipped_studies_are_found_by_name_and_distinguished(in_tmp_path):
    assert read_study("fingers").name == "fingers"
    for name, words in (("plane_strain", "bench plane-strain"), ("finger", "did you mean fingers")):
        with pytest.raises(DesignError, match=words):
            read_study(name)
    Path("fingers").write_text(HEAD + ONE, "utf-8")  # a file comes first
    assert read_study("fingers").name == "few"


def test_files_lie_next_to_the_study(tmp_path, in_tmp_path):
    (home := tmp_path / "home").mkdir()
    (home / "own.toml").write_text(shipped_text("narrow"), "utf-8")
    text = HEAD.replace("maeno2000", "own.toml")
    text += '[parameters]\n"mesh.file" = ["a.msh", "/b.msh"]\n'
    (home / "study.toml").write_text(text, "utf-8")
    study = read_study("home/study.toml")
    assert study.parameters["mesh.file"] == (str(home / "a.msh"), "/b.msh")
    assert base_design(study, home / "s.toml").body.width_mm == 10.0
    assert parse_study(text, "home/study.toml").digest() == study.digest()
    with pytest.raises(DesignError, match=r"own\.toml"):
        base_design(study, Path("elsewhere/s.toml"))


def test_many_wrong_choices_are_judged_quickly_and_reported_in_part():
    def reported(keys, values):
        lines = "".join(f'"{key}" = {list(values)}\n' for key in keys)
        start = time.perf_counter()
        found = refused(parameters(lines).replace('"grid"', '"sobol"\ncount = 4'))
        assert time.perf_counter() - start < 10.0
        return found.splitlines()

    two = '"body.nokey" = [1, 2]\n"plates.count" = [9000]'
    assert len(refused(parameters(two)).splitlines()) == 2
    for key in ("body.nokey{}", "grip.k{}.x"):
        assert len(reported(map(key.format, range(100)), range(200))) <= 100
    keys = ("body.depth_mm", "body.arc_radius_mm", "plates.length_mm", "gages.length_mm")
    found = reported(keys, range(-199, 0))
    assert len(found) == 201
    assert "more than 200 faults" in found[-1]


def sampled(sampling, lines, count=None, held="", seed=1, name="few"):
    counted = "" if count is None else f"count = {count}\n"
    return parse_study(
        f'[study]\nname = "{name}"\nbase = "maeno2000"\nsampling = "{sampling}"\nseed = {seed}\n'
        f"{counted}[fixed]\n{held}\n[parameters]\n{lines}\n"
    )


TWO = '"body.depth_mm" = [10.0, 12.0]\n"plates.count" = { low = 9, high = 13, step = 2 }'
DEPTH = (
    '"body.depth_mm" = { low = 5.0, high = 50.0, log = true }\n'
    '"plates.count" = { low = 5, high = 9 }'
)


@pytest.mark.parametrize("sampling", ["sobol", "latin_hypercube"])
def test_drawn_points_are_seeded_and_spread(sampling):
    drawn = list(points(sampled(sampling, DEPTH, 40)))
    assert drawn == list(points(sampled(sampling, DEPTH, 40)))
    assert drawn != list(points(sampled(sampling, DEPTH, 40, seed=2)))
    assert {values["plates.count"] for values in drawn} == {5, 6, 7, 8, 9}
    depths = sorted(values["body.depth_mm"] for values in drawn)
    assert depths[0] >= 5.0
    assert depths[-1] <= 50.0
    # Even in the logarithm: half of them below the geometric mean.
    assert abs(sum(depth < 250.0**0.5 for depth in depths) - 20) <= 2


def test_a_longer_sobol_study_keeps_the_shorter_ones_points_and_a_grid_is_in_order():
    short, long = (list(points(sampled("sobol", DEPTH, count))) for count in (20, 100))
    assert long[:20] == short
    grid = sampled("grid", TWO)
    found = [tuple(values.values()) for values in points(grid)]
    assert found == [(10.0, 9), (10.0, 11), (10.0, 13), (12.0, 9), (12.0, 11), (12.0, 13)]
    assert number_of_points(grid) == 6


def test_invalid_variants_are_reported_not_dropped():
    many = sampled("grid", '"plates.count" = [15, 45]\n"plates.angle_deg" = [45.0, 10.0]')
    good, *found = variants(many, base_design(many))
    assert [variant.number for variant in (good, *found)] == [1, 2, 3, 4]
    assert good.name == good.design.design.name == "few-0001"
    assert not good.faults
    for variant in found:
        assert variant.design is None
        assert variant.faults
        assert all(fault.remedy for fault in variant.faults)


def test_shares_follow_the_length_that_they_are_of():
    share = '"plates.span_mm / body.depth_mm" = '
    shared = sampled("grid", share + '[0.5, 1.0]\n"body.depth_mm" = [10.0, 20.0]')
    spans = [variant.design.plates.span_mm for variant in variants(shared, base_design(shared))]
    assert spans == [5.0, 10.0, 10.0, 20.0]
    of_fixed = sampled("grid", share + "[0.5]", held='"body.depth_mm" = 30.0')
    (only,) = variants(of_fixed, base_design(of_fixed))
    assert only.design.plates.span_mm == 15.0
    assert only.values == {"plates.span_mm / body.depth_mm": 0.5}


@pytest.mark.parametrize(
    ("lines", "held", "sound"),
    [
        # A depth of 5 leaves the base's span of 10 outside, but no variant has it.
        ('"plates.span_mm" = [4.0, 5.0]', '"body.depth_mm" = 5.0', True),
        ('"body.dome_radius_mm" = [30.0, 40.0]', '"body.shape" = "dome"', False),
        # Where no variant can exist, each says so.
        ('"plates.count" = [15, 17]', '"plates.cover_mm" = 30.0', False),
    ],
)
def test_fixed_keys_that_only_fit_with_the_parameters_are_no_fault(lines, held, sound):
    study = sampled("grid", lines, held=held)
    found = list(variants(study, base_design(study)))
    assert [not variant.faults for variant in found] == [sound] * 2


def test_names_are_safe_and_distinct_whatever_the_number():
    long = sampled("grid", TWO, name="n" * 64)
    base = base_design(long)
    names = {variant_of(long, base, number, {}).name for number in (1, 9999, 10000, 99999)}
    assert len(names) == 4
    assert all(safe_name(name) == name for name in names)
    assert variant_of(long, base, 100000, {}).design is not None
    assert value_of(base, "body.depth_mm") == 10.0
    for key in ("body.nothing", "plates.model_fields", "plates.rows[3].count"):
        assert value_of(base, key) is None
    assert set_keys(base, {"a.b / body.depth_mm": 0.25}) == {"a.b": 2.5}
