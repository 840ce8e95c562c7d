"""Content digests: what does not matter, what does."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fingerdesign.design.io import parse_design, parse_scene

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


def test_digest_is_the_same_in_every_process():
    """A cache on disk outlives the process: pin the value of a scene, whose keys stand firm."""
    scene = parse_scene("path.increments_mm = [[0.1, 0.0]]")
    assert len(scene.digest()) == 64
    assert scene.digest() == parse_scene("[path]\nincrements_mm = [[0.1, 0]]").digest()
    assert scene.digest() != BASE.digest()


@settings(max_examples=40, derandomize=True, deadline=None)
@given(st.floats(15, 25), st.floats(15, 25))
def test_digests_are_equal_where_designs_are(first, second):
    one = parse_design(f'design.name = "a"\nbody.depth_mm = {first!r}')
    two = parse_design(f'design.name = "a"\nbody.depth_mm = {second!r}')
    assert (one.digest() == two.digest()) == (one == two)
