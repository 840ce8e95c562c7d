"""Variants: sampled as asked, the same every time, invalid ones with their reasons."""

from itertools import islice

import pytest

from fingerdesign.design.schema import safe_name
from fingerdesign.search.study.file import parse_study, read_study
from fingerdesign.search.study.metrics import METRICS, known_metric
from fingerdesign.search.study.values import set_keys, value_of
from fingerdesign.search.study.variants import (
    base_design,
    number_of_points,
    points,
    variant_of,
    variants,
)


def study(sampling, lines, count=None, fixed="", seed=1, name="few"):
    counted = "" if count is None else f"count = {count}\n"
    return parse_study(
        f'[study]\nname = "{name}"\nbase = "maeno2000"\nsampling = "{sampling}"\nseed = {seed}\n'
        f"{counted}[fixed]\n{fixed}\n[parameters]\n{lines}\n"
    )


TWO = '"body.depth_mm" = [10.0, 12.0]\n"plates.count" = { low = 9, high = 13, step = 2 }'
DEPTH = (
    '"body.depth_mm" = { low = 5.0, high = 50.0, log = true }\n'
    '"plates.count" = { low = 5, high = 9 }'
)


def test_a_grid_is_every_combination_in_order():
    grid = study("grid", TWO)
    found = [tuple(values.values()) for values in points(grid)]
    assert found == [(10.0, 9), (10.0, 11), (10.0, 13), (12.0, 9), (12.0, 11), (12.0, 13)]
    assert number_of_points(grid) == 6


@pytest.mark.parametrize("sampling", ["sobol", "latin_hypercube"])
def test_drawn_points_are_seeded_and_spread(sampling):
    drawn = list(points(study(sampling, DEPTH, 40)))
    assert drawn == list(points(study(sampling, DEPTH, 40)))
    assert drawn != list(points(study(sampling, DEPTH, 40, seed=2)))
    assert {values["plates.count"] for values in drawn} == {5, 6, 7, 8, 9}
    depths = sorted(values["body.depth_mm"] for values in drawn)
    assert depths[0] >= 5.0
    assert depths[-1] <= 50.0
    # Even in the logarithm: half of them below the geometric mean.
    assert abs(sum(depth < 250.0**0.5 for depth in depths) - 20) <= 2


def test_a_longer_sobol_study_keeps_the_shorter_ones_points():
    short, long = (list(points(study("sobol", DEPTH, count))) for count in (20, 100))
    assert long[:20] == short


def test_invalid_variants_are_reported_not_dropped():
    many = study("grid", '"plates.count" = [15, 45]\n"plates.angle_deg" = [45.0, 10.0]')
    found = list(variants(many, base_design(many)))
    assert [variant.number for variant in found] == [1, 2, 3, 4]
    assert [variant.name for variant in found] == [f"few-{n:04d}" for n in (1, 2, 3, 4)]
    assert found[0].design is not None
    assert found[0].design.design.name == "few-0001"
    assert not found[0].faults
    for variant in found[1:]:
        assert variant.design is None
        assert variant.faults
        assert all(fault.remedy for fault in variant.faults)


def test_shares_follow_the_length_that_they_are_of():
    shared = study(
        "grid", '"plates.span_mm / body.depth_mm" = [0.5, 1.0]\n"body.depth_mm" = [10.0, 20.0]'
    )
    spans = [variant.design.plates.span_mm for variant in variants(shared, base_design(shared))]
    assert spans == [5.0, 10.0, 10.0, 20.0]
    of_fixed = study(
        "grid", '"plates.span_mm / body.depth_mm" = [0.5]', fixed='"body.depth_mm" = 30.0'
    )
    (only,) = variants(of_fixed, base_design(of_fixed))
    assert only.design.plates.span_mm == 15.0
    assert only.values == {"plates.span_mm / body.depth_mm": 0.5}


def test_fixed_keys_that_only_fit_with_the_parameters_are_no_fault():
    # A depth of 5 leaves the base's span of 10 outside, but no variant has it.
    narrow = study("grid", '"plates.span_mm" = [4.0, 5.0]', fixed='"body.depth_mm" = 5.0')
    found = list(variants(narrow, base_design(narrow)))
    assert [variant.design.plates.span_mm for variant in found] == [4.0, 5.0]
    domed = study("grid", '"body.dome_radius_mm" = [30.0, 40.0]', fixed='"body.shape" = "dome"')
    assert [bool(variant.values) for variant in variants(domed, base_design(domed))] == [True, True]
    # Where no variant can exist, each says so.
    flat = study(
        "grid",
        '"plates.count" = [15, 17]',
        fixed='"body.base_height_mm" = 0.5\n"plates.cover_mm" = 9.0',
    )
    assert all(variant.faults for variant in variants(flat, base_design(flat)))


def test_names_are_safe_and_distinct_whatever_the_number():
    long = study("grid", TWO, name="n" * 64)
    base = base_design(long)
    names = {variant_of(long, base, number, {}).name for number in (1, 9999, 10000, 99999)}
    assert len(names) == 4
    for name in names:
        assert safe_name(name) == name
    assert variant_of(long, base, 100000, {}).design is not None


def test_values_of_keys_in_rows_and_of_none():
    base = base_design(study("grid", TWO))
    assert value_of(base, "body.depth_mm") == 10.0
    assert value_of(base, "body.nothing") is None
    assert value_of(base, "plates.model_fields") is None
    assert value_of(base, "plates.rows[3].count") is None
    assert set_keys(base, {"a.b / body.depth_mm": 0.25}) == {"a.b": 2.5}


def test_the_shipped_study_of_fingers():
    shipped = read_study("fingers")
    assert shipped.study.count == 200
    assert any(isinstance(each, tuple) for each in shipped.parameters.values())
    sample = list(islice(variants(shipped, base_design(shipped)), 0, 40))
    assert sum(variant.design is not None for variant in sample) >= 36


def test_metrics_have_units_and_meanings():
    for name, metric in METRICS.items():
        assert name == metric.name == known_metric(name)
        assert metric.words
        unit = {"_N": "N", "_MPa": "MPa", "_ml": "ml", "_seconds": "s"}
        for ending, expected in unit.items():
            assert not name.endswith(ending) or metric.unit == expected
