"""Solids of STEP bodies: plates and core fused in, halves."""

import cadquery as cq
import pytest

from fingerdesign.cad.export import write_cad
from fingerdesign.cad.kernel import volume_of
from fingerdesign.cad.solid import build_solid
from fingerdesign.design.schema import Design
from fingerdesign.errors import GeometryError
from fingerdesign.layout.volume import face_areas


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """A block of 20 x 12 x 10 mm whose upper edges are rounded; drawn upright along z."""
    path = tmp_path_factory.mktemp("step") / "block.step"
    block = cq.Workplane("XY").rect(20, 10).extrude(12).faces(">Z").edges().fillet(3.0)
    cq.exporters.export(block, str(path))
    return path


def design_of(file, mirrors=True):
    step = {"file": str(file), "up": "z", "mirrors_in_z": mirrors}
    sizes = {"width_mm": 20.0, "depth_mm": 10.0, "base_height_mm": 9.0}
    core = {"width_mm": 20.0, "height_mm": 2.0, "depth_mm": 6.0}
    return Design.model_validate(
        {
            "design": {"name": "t"},
            "body": {"shape": "step", "step": step, "core": core, **sizes},
            "plates": {"placement": [[-3.0, 6.0, 20.0], [3.0, 6.0, 20.0]]},
        }
    )


def test_a_step_body_is_fused(file, tmp_path):
    design = design_of(file)
    whole, half = (build_solid(design, half) for half in (False, True))
    assert whole.outline.Area() == pytest.approx(sum(face_areas(design.body).values()), rel=1e-6)
    # The core ends in the base and in the sides.
    on_base = [sum(f.BoundingBox().ymax < 1e-5 for f in part.Faces()) for part in whole.parts]
    assert on_base == [2, 0, 0, 1]
    assert volume_of(half.body) == pytest.approx(0.5 * volume_of(whole.body), rel=1e-6)
    assert "core.stl" in write_cad(whole, tmp_path)


def test_a_half_is_refused_where_the_user_does_not_vouch_for_it(file):
    with pytest.raises(GeometryError, match="mirrors_in_z is false"):
        build_solid(design_of(file, mirrors=False), half=True)
