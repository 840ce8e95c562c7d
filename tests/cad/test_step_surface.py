"""STEP bodies read back: heights, distances, normals, volumes and areas against closed forms."""

from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert

from fingerdesign.cad.bodies import step_outline
from fingerdesign.design import step as facts_module
from fingerdesign.design.body import Body, StepFile
from fingerdesign.design.step import content_of, step_facts, step_sizes
from fingerdesign.layout.surface import ContactSurface, step_carriers, surface_of
from fingerdesign.layout.volume import outline_volume
from fingerdesign.shapes.faces import nearest
from tests.support.session import never_called
from tests.support.steps import read_here, write

BODIES = {
    "arc": Body(),
    "pin": Body(shape="revolved", width_mm=10.0, base_height_mm=8.0, arc_radius_mm=5.0),
    "pin of splines": Body(shape="revolved", width_mm=10.0, base_height_mm=8.0, arc_radius_mm=5.0),
    "dome, a torus": Body(shape="dome", dome_radius_mm=25.0),
    "dome, a spindle": Body(shape="dome", dome_radius_mm=12.0),
}


def section(width=20.0, depth=10.0):
    corner = cq.Workplane("XY", origin=(0, 0, -depth / 2)).moveTo(-width / 2, 0)
    return corner.lineTo(width / 2, 0)


def arc_finger():
    top = 10 + 20 - np.sqrt(300)
    return section().lineTo(10, 10).threePointArc((0, top), (-10, 10)).close().extrude(10)


def pin():
    side = cq.Workplane("XY").lineTo(5, 0).lineTo(5, 8)
    top = side.threePointArc((5 * np.sqrt(0.5), 8 + 5 * np.sqrt(0.5)), (0, 13)).close()
    return top.revolve(360, (0, 0, 0), (0, 1, 0))


def pin_of_splines():
    """Every face a NURBS surface, the base too; the crest is a pole of the parameters."""
    return cq.Workplane(cq.Shape.cast(BRepBuilderAPI_NurbsConvert(pin().val().wrapped).Shape()))


def dome(radius):
    crest = 10 + 20 - np.sqrt(300)
    block = section().lineTo(10, crest + 1).lineTo(-10, crest + 1).close().extrude(10)
    above = cq.Workplane("XY").moveTo(-11, 10).lineTo(-10, 10)
    above = above.threePointArc((0, crest), (10, 10)).lineTo(11, 10)
    above = above.lineTo(11, crest + 10).lineTo(-11, crest + 10).close()
    axis = ((0, crest - radius, 0), (1, crest - radius, 0))
    return block.cut(above.revolve(100, *axis).rotate(*axis, -50))


def spline_finger():
    over = [(5, 12), (0, 13), (-5, 11.5), (-10, 8)]
    return section().lineTo(10, 8).spline(over, includeCurrent=True).close().extrude(10)


def tapered():
    """A loft between ellipses, its walls one closed NURBS face."""
    return cq.Workplane("XZ").ellipse(8, 5).workplane(offset=-10).ellipse(6, 4).loft()


def rounded():
    """20 x 12 x 10 with vertical edges of 2 mm and upper edges of 1.5 mm radius."""
    block = cq.Workplane("XY").box(20, 12, 10).translate((0, 6, 0)).edges("|Y").fillet(2)
    return block.faces(">Y").edges().fillet(1.5)


MAKES = {
    "arc": arc_finger,
    "pin": pin,
    "pin of splines": pin_of_splines,
    "dome, a torus": lambda: dome(25.0),
    "dome, a spindle": lambda: dome(12.0),
    "spline": spline_finger,
    "loft": tapered,
    "rounded": rounded,
}


@pytest.fixture(scope="module")
def steps(tmp_path_factory):
    """Each body as [body.step], read by the worker's code in this process."""
    folder = tmp_path_factory.mktemp("steps")
    with pytest.MonkeyPatch.context() as patch:
        read_here(patch, folder / "cache")
        files = {name: str(write(make(), folder / f"{name}.step")) for name, make in MAKES.items()}
        yield {name: StepFile(file=f, mirrors_in_z="pin" not in name) for name, f in files.items()}


def near(body, count=400):
    rng = np.random.default_rng(4)
    x = rng.uniform(-0.49, 0.49, count) * body.width_mm
    z = rng.uniform(-0.49, 0.49, count) * body.depth_mm
    if body.shape == "revolved":
        inside = np.hypot(x, z) < 0.49 * body.width_mm
        x, z = x[inside], z[inside]
    y = ContactSurface.of(body).height(x, z)
    return np.column_stack([x, y + rng.uniform(-1, 1, len(x)), z]), y


def solid_of(step: StepFile) -> Body:
    return Body(shape="step", step=step, **step_sizes(step))


@pytest.mark.parametrize("name", BODIES)
def test_a_body_read_back_is_the_closed_form(steps, name):
    known, found = ContactSurface.of(BODIES[name]), surface_of(solid_of(steps[name]))
    points, y = near(BODIES[name])
    np.testing.assert_allclose(found.height(points[:, 0], points[:, 2]), y, atol=1e-9)
    np.testing.assert_allclose(found.distance(points), known.distance(points), atol=1e-9)
    np.testing.assert_allclose(found.normal(points), known.normal(points), atol=1e-9)
    np.testing.assert_allclose(found.project(points), known.project(points), atol=1e-9)
    np.testing.assert_allclose(found.curvatures, known.curvatures, rtol=5e-3)  # fitted
    drops = known.crest - known.height(np.array([1e-3, 0.0]), np.array([0.0, 1e-3]))
    np.testing.assert_allclose(2e6 * drops, known.curvatures, rtol=1e-5)
    assert found.crest == pytest.approx(known.crest, abs=1e-9)
    assert found.lowest == pytest.approx(known.lowest, abs=1e-9)
    facts = step_facts(steps[name])
    assert facts.volume == pytest.approx(outline_volume(BODIES[name]), rel=1e-9)
    below = points[:, 1] < y
    assert np.array_equal(found.encloses(points), below)
    flat = points * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(known.distance(flat[:, :2]), known.distance(flat))
    np.testing.assert_allclose(known.project(flat[:, :2]), known.project(flat)[:, :2])


def test_what_lies_below_the_surface_is_enclosed_though_outside_its_circle():
    surface = ContactSurface.of(Body(arc_radius_mm=10.0))
    points = np.array([[9.5, 1.0, 0.0], [0.0, 19.9, 0.0], [0.0, 20.1, 0.0], [8.0, 16.1, 0.0]])
    assert surface.encloses(points).tolist() == [True, True, False, False]
    assert surface.distance(points)[0] > 0.0
    assert surface.lowest == pytest.approx(10.0)


def test_areas_by_name_and_heights_that_end_with_the_surface(steps):
    arc_facts, pin_facts = step_facts(steps["arc"]), step_facts(steps["pin"])
    arc = 2 * 20 * np.arcsin(0.5)
    end = 200 + 400 * np.arcsin(0.5) - 10 * np.sqrt(300)
    expected = {"base": 200, "side": 200, "contact": 10 * arc, "end": 2 * end}
    assert arc_facts.area == pytest.approx(expected, rel=1e-9)
    expected = {"base": 25 * np.pi, "side": 80 * np.pi, "contact": 50 * np.pi}
    assert pin_facts.area == pytest.approx(expected, rel=1e-9)
    x = np.array([0.0, 4.999999, 5.0, 5.00001, 9.0])
    found = pin_facts.height(x)
    np.testing.assert_allclose(found[:2], 8 + np.sqrt(25 - x[:2] ** 2), atol=1e-9)
    assert found[2] == pytest.approx(8.0, abs=1e-6)
    assert np.isnan(found[3:]).all()
    assert np.isnan(arc_facts.height(0.0, 5.001))
    assert arc_facts.height(np.nan).shape == ()
    assert np.isnan(arc_facts.height(np.nan))


def test_a_spline_surface_is_the_kernels_own(steps):
    """Points and normals from the kernel, moved along the normal by a known distance."""
    solid = cq.importers.importStep(steps["spline"].file)
    face = max(solid.faces().vals(), key=lambda f: f.geomType() != "PLANE")
    rng, surface = np.random.default_rng(5), surface_of(solid_of(steps["spline"]))
    edge = next(e for e in face.Edges() if e.geomType() == "BSPLINE")
    places, normals = [], []
    for share in rng.uniform(0.02, 0.98, 200):
        where = edge.positionAt(share)
        places.append(where.toTuple())
        normals.append(face.normalAt(where).toTuple())
    places, normals = np.array(places), np.array(normals)
    places[:, 2] = rng.uniform(-4.9, 4.9, 200)
    away = rng.uniform(-0.5, 0.5, 200)
    points = places + away[:, None] * normals
    np.testing.assert_allclose(surface.distance(points), away, atol=1e-7)
    np.testing.assert_allclose(surface.normal(points), normals, atol=1e-7)
    np.testing.assert_allclose(surface.project(points), places, atol=1e-7)
    np.testing.assert_allclose(surface.height(places[:, 0], places[:, 2]), places[:, 1], atol=1e-7)
    assert np.abs(surface.distance(points[:, :2]) - surface.distance(points * [1, 1, 0])).max() == 0


def test_a_lofts_walls(steps):
    """Straight rules between like points of two ellipses."""
    wall = next(c for c in step_carriers(steps["loft"]) if c.name == "side")
    angle, share = np.random.default_rng(6).uniform(0, [2 * np.pi, 1.0], (300, 2)).T
    low = np.column_stack([8 * np.cos(angle), 0 * angle, 5 * np.sin(angle)])
    high = np.column_stack([6 * np.cos(angle), 10 + 0 * angle, 4 * np.sin(angle)])
    points = low + share[:, None] * (high - low)
    # The kernel fits the ellipses by a polynomial; the file says that one.
    assert np.abs(wall.distance(points)).max() < 2e-4
    off = points + 0.3 * wall.normal(points)
    np.testing.assert_allclose(wall.distance(off), wall.distance(points) + 0.3, atol=1e-7)
    assert np.all(wall.normal(points)[:, 1] > 0.0)  # it narrows toward the top


def test_carriers_of_an_arc_finger(steps):
    carriers = {
        (c.name, tuple(np.round(c.normal(np.zeros((1, 3)))[0]))): c
        for c in step_carriers(steps["arc"])
    }
    assert sorted(name for name, _ in carriers) == [
        *("base", "contact", "end", "end", "side", "side")
    ]
    base = carriers["base", (0.0, -1.0, 0.0)]
    points = np.array([[0.0, -1.0, 0.0], [12.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    np.testing.assert_allclose(base.distance(points), [1.0, 0.0, -2.0], atol=1e-12)
    np.testing.assert_allclose(base.misfit(points), [1.0, 2.0, 2.0], atol=1e-9)
    assert base.flat
    assert base.boundaries == ("base",)


def test_smooth_neighbours_are_one_carrier_that_reports_them_apart(steps):
    (base, pin_wall) = sorted(step_carriers(steps["pin"]), key=lambda c: c.name)
    assert base.name == "base"
    assert pin_wall.name == "contact"
    assert set(pin_wall.boundaries) == {"contact", "side"}
    points = np.array([[5.0, 7.9, 0.0], [0.0, 5.0, 6.0], [0.0, 13.1, 0.0], [4.9, 9.0, 0.5]])
    assert pin_wall.names(points).tolist() == ["side", "side", "contact", "contact"]
    np.testing.assert_allclose(pin_wall.distance(points)[:3], [0.0, 1.0, 0.1], atol=1e-12)
    # Across the joint distance and normal go on.
    rim = np.array([[5.2, 8.0 - 1e-7, 0.0], [5.2, 8.0 + 1e-7, 0.0]])
    np.testing.assert_allclose(pin_wall.distance(rim), 0.2, atol=1e-12)
    assert np.ptp(pin_wall.normal(rim), axis=0).max() < 1e-7


def test_a_second_reading_takes_what_was_cached(steps):
    first = step_facts(steps["spline"])
    facts_module._outcome.cache_clear()
    with never_called(facts_module, "call"):
        again = step_facts(steps["spline"])
    assert again is not first
    assert again.volume == first.volume
    assert step_outline(steps["spline"]).Volume() == pytest.approx(first.volume, rel=1e-4)
    np.testing.assert_array_equal(
        again.height(np.arange(-9.0, 9.0)), first.height(np.arange(-9.0, 9.0))
    )


def test_content_counts_not_place_nor_time_of_writing(steps, tmp_path):
    text = Path(steps["arc"].file).read_text("utf-8")
    other = tmp_path / "elsewhere.stp"
    other.write_text(text.replace("Open CASCADE Shape Model", "Another name", 1), "utf-8")
    assert content_of(str(other)) == content_of(steps["arc"].file)
    other.write_text(text.replace("20.,", "20.5,", 1), "utf-8")
    assert content_of(str(other)) != content_of(steps["arc"].file)


@pytest.mark.slow
def test_many_smooth_faces_are_searched_by_boxes_without_missing_any(steps):
    facts = step_facts(steps["rounded"])
    assert len(facts.faces) == 18
    points = np.random.default_rng(7).uniform(-1.2, 1.2, (1000, 3)) * [10, 7, 5] + [0, 6, 0]
    _, away, normal, misfit = nearest(facts.faces, points)
    each = np.stack([face.nearness(points)[2] for face in facts.faces])
    np.testing.assert_allclose(misfit, each.min(axis=0), atol=1e-12)
    # A rounded box: its distance is that to a smaller box, less the radius, above the edges' foot.
    above = (points[:, 1] > 6.0) & (away > 0.0)
    inner = np.maximum(np.abs(points - [0, 6, 0]) - [8, 4.5, 3], 0.0)
    top = np.linalg.norm(inner[above], axis=1) - 1.5 - 0.5 * (inner[above, 1] == 0.0)
    side = inner[above, 1] == 0.0
    np.testing.assert_allclose(away[above][side], top[side], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-12)


@pytest.mark.slow
def test_points_near_a_centre_of_curvature_have_a_distance(tmp_path, monkeypatch):
    """Within an ellipsoid, where a nearest point hardly differs from its neighbours."""
    read_here(monkeypatch, tmp_path / "cache")
    axes = np.array([9.0, 5.0, 7.0])
    stretch = cq.Matrix([[*row, 0.0] for row in np.diag(axes)] + [[0.0, 0.0, 0.0, 1.0]])
    ball = cq.Workplane("XY").sphere(1).val().transformGeometry(stretch)
    upper = cq.Workplane("XY").box(40, 40, 40).translate((0, 20, 0))
    shank = cq.Workplane("XZ").ellipse(9, 7).extrude(8)
    work = cq.Workplane(ball).intersect(upper).union(shank)
    facts = step_facts(StepFile(file=str(write(work, tmp_path / "ellipsoid.step"))))
    (cap,) = facts.contact
    points = np.random.default_rng(0).uniform(facts.low, facts.high, (1500, 3))
    points = np.vstack([points * [1.0, 1.0, 0.0], [[-3.4222, 6.5084, 0.0]]])
    _, foot = cap.shape.foot(points)
    away = np.linalg.norm(points - foot, axis=1)
    np.testing.assert_allclose(np.sum(((foot - [0, 8, 0]) / axes) ** 2, axis=1), 1.0, atol=1e-6)
    samples = cap.shape.sampled()
    nearest_sample = np.array([np.linalg.norm(samples - p, axis=1).min() for p in points])
    assert (away <= nearest_sample + 1e-9).all()
