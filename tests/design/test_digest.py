"""Content digests: what does not matter, what does."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.checks.starter import find_design

BASE = parse_design('design.name = "a"')


@pytest.mark.parametrize(
    "text",
    [
        '# a comment\n\n[design]\nname="a"   # another\n',
        'design.name = "a"\nbody.width_mm = 20',
        'design.name = "a"\nbody.width_mm = 2.0e1\nbody.depth_mm = 10.0',
        '[plates]\ncount = 15\n[body]\nshape = "arc"\n[design]\nname = "a"',
        'design.name = "a"\ngages.z_mm = -0.0',
        'design.name = "a"\nmaterials.silicone.youngs_modulus_MPa = 4.96',
    ],
)
def test_formatting_order_and_written_defaults_do_not_matter(text):
    assert parse_design(text).digest() == BASE.digest()


@pytest.mark.parametrize(
    "line",
    [
        "body.width_mm = 20.0000001",
        "plates.count = 14",
        'gages.face = "upper"',
        "plates.span_mm = 8.0",
        "materials.silicone.poissons_ratio = 0.48",
        "mesh.layers = 9",
        "grip.seed = 1",
        "grip.friction_coefficients = [0.5, 0.3, 0.8]",
    ],
)
def test_any_value_matters(line):
    assert parse_design('design.name = "a"\n' + line).digest() != BASE.digest()


@settings(max_examples=40, derandomize=True, deadline=None)
@given(st.floats(15, 25), st.floats(15, 25))
def test_digests_are_equal_where_designs_are(first, second):
    one = parse_design(f'design.name = "a"\nbody.depth_mm = {first!r}')
    two = parse_design(f'design.name = "a"\nbody.depth_mm = {second!r}')
    assert (one.digest() == two.digest()) == (one == two)


BEFORE_MOLDS = {
    "block": "6e00692b0c40bf3075dfd5199e4a38b11ff7a10a7772866e58b94d524d42f5f5",
    "boned": "0573ddb3dd1abba09b0566fbb78881f17a7c2b251791b4fb1beeec9fd7bf7150",
    "both_ways": "650e27e256ba1652f95f24d034e36a0a98b74372d332c5d1057fcfbbd8a14257",
    "domed": "6318d8c728f86ba62a94cd6cd98fe42750de57112b8b73c135f1657dc4f75886",
    "homogeneous": "0629a3b6ceb7eef98fbae1c7ba2600e5d720eb0961669969cd38788f323104be",
    "maeno2000": "d40bc2396db4911db94e839c078c509ed7adfe4f82e7726ba33670707b191c06",
    "narrow": "7930f53863a336d3b58bb70d6fe15ca75f38611953160d3b95d43f1731d28f83",
    "pin": "7dfa87dd22e91c9c3be5ed606c844952783e147d58bfbb4a04337693f0821a30",
    "sensitive": "3734969731bc0ca37c0f5545c0597d44088a02adbdcd20f69419ad417fd274ab",
    "wide": "6616d4436316cf6ea31798577e5437cc5b20ba908166f07b7ad546fb336621d0",
}


@pytest.mark.parametrize(("name", "digest"), BEFORE_MOLDS.items())
def test_how_a_finger_is_cast_is_not_in_the_digest(name, digest):
    """A design's results outlive its ``[mold]``: digests are what they were before there was one.

    A shipped design or a default that is changed on purpose moves its digest: then pin it anew.
    """
    design = find_design(name)
    assert with_values(design, {"mold": {}}).digest() == digest
    assert with_values(design, {"mold.process": "fdm", "mold.wall_mm": 9.0}).digest() == digest
