"""CAD solids: every kind's volumes and areas against closed forms, shared faces, halves."""

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

from fingerdesign.cad.export import write_cad
from fingerdesign.cad.kernel import volume_of
from fingerdesign.cad.solid import build_solid
from fingerdesign.design.schema import Design
from fingerdesign.errors import GeometryError
from fingerdesign.layout.rows import mirrors_in_z, plate_frames
from fingerdesign.layout.volume import (
    check_volume,
    core_volume,
    face_areas,
    outline_volume,
    plate_volume,
)
from tests.support.steps import write


def assert_true_to_the_design(solid, design):
    """Volumes of all parts and areas of the outer faces are those of the closed forms."""
    half, body = solid.half, design.body
    tolerance = 1e-6 if body.shape == "dome" else 1e-9
    metal = [plate_volume(frame, half) for frame in plate_frames(design)]
    whole, core = outline_volume(body, half), core_volume(design, half)
    assert volume_of(solid.outline) == pytest.approx(whole, rel=tolerance)
    assert volume_of(solid.body) == pytest.approx(whole - sum(metal) - core, rel=1e-8 + tolerance)
    assert [volume_of(plate) for plate in solid.plates] == pytest.approx(metal, rel=1e-8)
    assert volume_of(solid.core) == pytest.approx(core, rel=1e-9) if core else solid.core is None
    assert solid.outline.Area() == pytest.approx(sum(face_areas(body, half).values()), rel=1e-6)


@pytest.mark.parametrize("half", [False, True])
def test_every_body(body, half, design_of, solid_of):
    assert_true_to_the_design(solid_of(body, half=half), design_of(body))


@pytest.mark.parametrize("within", ["arc", "dome", "revolved"])
def test_every_kind_of_plates(within, plates, design_of, solid_of):
    design = design_of(within, plates)
    if within == "revolved" and plates in ("full span", "bent", "one by one"):
        with pytest.raises(GeometryError, match="leaves the body"):
            build_solid(design)
        return
    whole = solid_of(within, plates)
    assert_true_to_the_design(whole, design)
    if not mirrors_in_z(design):
        with pytest.raises(GeometryError, match="does not mirror in z = 0"):
            build_solid(design, half=True)
        return
    half = solid_of(within, plates, half=True)
    assert_true_to_the_design(half, design)
    for a, b in zip((whole.body, *whole.plates), (half.body, *half.plates), strict=True):
        centre, middle = a.Center(), b.Center()
        assert (middle.x, middle.y) == pytest.approx((centre.x, centre.y), abs=1e-6)
        assert b.BoundingBox(1e-7).zmin == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("half", [False, True])
def test_every_kind_of_core(core, half, design_of):
    design = design_of("block", "full span", core)
    assert_true_to_the_design(build_solid(design, half), design)


def on_base(face):
    return face.BoundingBox(1e-7).ymax < 1e-5


def test_parts_share_their_faces_and_the_base(solid_of):
    """6 faces of the outline and 3 boxes of 6 faces, each face once. Where plate ends lie in the
    body's end faces, 4 walls each are shared, 2 ends are the plate's own."""
    for plates, of_body in (("ends inside", 6 + 3 * 6), ("full span", 6 + 3 * 4)):
        solid = solid_of("arc", plates)
        assert len(solid.body.Faces()) == of_body
        assert len({face for part in solid.parts for face in part.Faces()}) == 6 + 3 * 6
    for core, counts in (("standing on the base", [1, 1]), ("a backing", [0, 1])):
        parts = solid_of("arc", "", core).parts
        assert [sum(on_base(face) for face in part.Faces()) for part in parts] == counts


def test_frames_of_others_can_be_built(design_of):
    design = design_of("arc", "ends inside")
    thick = tuple(replace(frame, thickness=0.3) for frame in plate_frames(design)[:2])
    solid = build_solid(design, frames=thick)
    assert [volume_of(plate) for plate in solid.plates] == pytest.approx([0.3 * 2.0 * 6.0] * 2)
    bare = design.model_copy(update={"plates": design.plates.model_copy(update={"model": "none"})})
    assert build_solid(bare).plates == ()


PLATED, CORED = ("arc", "full span"), ("arc", "full span", "standing on the base")


@pytest.mark.parametrize(
    ("kinds", "changes", "message"),
    [
        (PLATED, {"pitch_mm": 0.1}, "plate 0 and plate 1 overlap"),
        (PLATED, {"cover_mm": 0.5}, "plate 0 leaves the body"),
        (PLATED, {"cover_mm": 12.9}, "plate 0 leaves the body"),
        (PLATED, {"span_mm": 11.0}, "plate 0 leaves the body"),
        (PLATED, {"span_mm": 6.0, "span_offset_mm": 50.0}, "plate 0 leaves the body"),
        (PLATED, {"pitch_mm": 40.0, "follow": "turned"}, "plate 0 lies beyond the contact surface"),
        (CORED, {"height_mm": 11.0}, "plate 0 and core overlap"),
        (CORED, {"height_mm": 30.0}, "overlap|leaves the body"),
        (("block", "", "a backing"), {"bottom_mm": 3.0}, "cut the body into 2 pieces"),
    ],
)
def test_what_cannot_be_is_named(kinds, changes, message, design_of):
    data = design_of(*kinds).model_dump(exclude_none=True)
    (data["plates"] if kinds == PLATED else data["body"]["core"]).update(changes)
    with pytest.raises(GeometryError, match=message):
        build_solid(Design.model_validate(data))


def test_a_wrong_volume_is_an_error():
    check_volume("body", 1.0 + 5e-10, 1.0, 1e-9)
    for wrong in (1.001, float("nan")):
        with pytest.raises(GeometryError, match="differs from 1 mm"):
            check_volume("body", wrong, 1.0, 1e-9)


def test_plates_lie_where_their_frames_say(plates, design_of, solid_of):
    """Points just inside and outside of each frame, tried in the CAD solid."""
    design, solid = design_of("arc", plates), solid_of("arc", plates)
    rng = np.random.default_rng(4)
    for frame, plate in zip(plate_frames(design), solid.plates, strict=True):
        s = rng.uniform(-0.7, 0.7, 60) * frame.length
        v = rng.uniform(-0.7, 0.7, 60) * frame.thickness
        w = frame.middle + rng.uniform(-0.6, 0.6, 60) * frame.span
        points = frame.to_space(frame.from_local(s, v), w)
        found = [plate.isInside(tuple(point), 1e-9) for point in points.tolist()]
        assert found == frame.holds(points).tolist()
        assert 5 < sum(found) < 55


# Solids of STEP bodies.


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """A block of 20 x 12 x 10 mm whose upper edges are rounded; drawn upright along z."""
    path = tmp_path_factory.mktemp("step") / "block.step"
    block = cq.Workplane("XY").rect(20, 10).extrude(12).faces(">Z").edges().fillet(3.0)
    return write(block, path)


def step_design(file, mirrors=True):
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
    design = step_design(file)
    whole, half = (build_solid(design, half) for half in (False, True))
    assert whole.outline.Area() == pytest.approx(sum(face_areas(design.body).values()), rel=1e-6)
    # The core ends in the base and in the sides.
    assert [sum(on_base(face) for face in part.Faces()) for part in whole.parts] == [2, 0, 0, 1]
    assert volume_of(half.body) == pytest.approx(0.5 * volume_of(whole.body), rel=1e-6)
    assert "core.stl" in write_cad(whole, tmp_path)


def test_a_half_is_refused_where_the_user_does_not_vouch_for_it(file):
    with pytest.raises(GeometryError, match="mirrors_in_z is false"):
        build_solid(step_design(file, mirrors=False), half=True)
