"""Sections of every kind of body, plate and core: areas exact, edges kept, nodes on the surface."""

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict

import numpy as np
import pytest

from fingerdesign import with_values
from fingerdesign.design.schema import Design
from fingerdesign.errors import MeshError
from fingerdesign.fem.elements import physical_gradients
from fingerdesign.layout.frames import plate_frames
from fingerdesign.layout.surface import surface_of
from fingerdesign.layout.volume import section_area
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.measures import aspects, cell_angles, cell_volumes
from fingerdesign.mesh.section.extrude import extrude, layer_heights
from fingerdesign.mesh.section.netgen import run_netgen, start_mesher
from fingerdesign.mesh.section.outline import BODY, Outline
from fingerdesign.mesh.section.section import mesh_section, section_frames

CORE = {"width_mm": 6.0, "height_mm": 1.5, "bottom_mm": 1.0}
KINDS = {
    "rounded": {"body": {"edge_radius_mm": 2.0}},
    "chamfered": {"body": {"edge_radius_mm": 1.5, "edge": "chamfer"}},
    "flat": {"body": {"shape": "block"}},
    "flat, rounded": {"body": {"shape": "block", "edge_radius_mm": 2.5}},
    "half circle": {"body": {"arc_radius_mm": 6.0, "edge_radius_mm": 1.0}},
    "bone": {"body": {"core": CORE}},
    "backing": {"body": {"core": CORE | {"bottom_mm": 0.0}}},
    "full backing": {"body": {"core": CORE | {"bottom_mm": 0.0, "width_mm": 12.0}}},
    "layer": {"body": {"core": CORE | {"width_mm": 12.0}}},
    "bent": {"plates": {"follow": "bent", "angle_deg": 0.0, "pitch_mm": 3.2, "count": 3}},
    "turned": {"plates": {"follow": "turned", "angle_deg": 30.0, "pitch_mm": 1.5}},
}


def design_of(name, **more):
    tables = {
        "design": {"name": "kind"},
        "body": {"width_mm": 12.0, "base_height_mm": 5.0, "arc_radius_mm": 10.0, "depth_mm": 4.0},
        "plates": {"count": 3, "length_mm": 2.0},
        "mesh": {
            "layers": 2,
            "contact_size_mm": 0.8,
            "section": {"plate_size_mm": 0.2, "plate_end_size_mm": 0.05, "contact_size_mm": 0.3},
        },
    }
    for change in (KINDS.get(name, {}), more):
        for table, values in change.items():
            tables[table] = tables[table] | values
    if tables["body"].get("shape") == "block":
        del tables["body"]["arc_radius_mm"]
    return Design.model_validate(tables)


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_fills_its_section(name):
    design = design_of(name)
    for mesh, depth in ((mesh_section(design, 2.0), 1.0), (extrude(design, Zone(2.0)), 2.0)):
        _, weights = physical_gradients(mesh.points, mesh.cells, 4)
        sizes = np.bincount(mesh.regions, weights.sum(axis=1)) / depth
        assert sizes.sum() == pytest.approx(section_area(design.body), rel=2e-5)
        for frame in section_frames(design):
            assert sizes[frame.index + 1] == pytest.approx(2.0 * 0.1, rel=1e-7)
        if design.body.core is not None:
            core = design.body.core
            assert sizes[design.core_region] == pytest.approx(core.width_mm * core.height_mm)
            assert mesh.region_name(design.core_region) == "core"
        contact = mesh.points[np.unique(mesh.facets["contact"])]
        assert np.abs(surface_of(design.body).distance(contact)).max() < 1e-12


@pytest.mark.parametrize("name", ["rounded", "chamfered", "flat", "full backing"])
def test_base_sides_and_contact_are_named(name):
    """The contact surface takes the edges in; a core on the outside keeps the outside's names."""
    design = design_of(name)
    mesh = mesh_section(design, 2.0)
    corners = {key: mesh.points[facets[:, :2]] for key, facets in mesh.facets.items()}
    width = {key: np.ptp(p[:, :, 0]) for key, p in corners.items()}
    assert width["base"] == pytest.approx(12.0)
    assert width["contact"] == pytest.approx(12.0)
    side = 5.0 - (design.body.edge_radius_mm or 0.0)
    if name == "rounded":  # the rounding's own end on the side
        side = float(surface_of(design.body).lowest)
    assert corners["side"][:, :, 1].max() == pytest.approx(side)
    assert corners["contact"][:, :, 1].min() == pytest.approx(side)


def test_a_section_shows_the_plates_that_it_cuts():
    """Of rows staggered beyond z = 0, only plates whose span covers it; none of those along z."""
    staggered = design_of("plain", plates={"span_mm": 1.5, "stagger_mm": 2.0, "count": 4})
    assert section_frames(staggered) == ()
    wide = design_of("plain", plates={"span_mm": 2.5, "stagger_mm": 2.0, "count": 4})
    assert [frame.index for frame in section_frames(wide)] == [0, 1, 2, 3]
    both = design_of("plain", plates={"rows": [{"along": "z", "cover_mm": 4.0}]})
    assert [frame.index for frame in section_frames(both)] == [0, 1, 2]
    assert set(np.unique(mesh_section(both, 2.0).regions)) == {0, 1, 2, 3}


def test_bent_faces_are_bent_and_no_triangle_is_flat():
    design = design_of("bent")
    mesh = mesh_section(design, 2.0)
    for frame in section_frames(design):
        own = mesh.regions == frame.index + 1
        face = np.intersect1d(mesh.cells[own], mesh.cells[~own])
        s, v = frame.local(mesh.points[face]).T
        long = np.abs(s) < 0.999
        assert np.abs(np.abs(v[long]) - 0.05).max() < 1e-9
    assert cell_volumes(mesh.points, mesh.corners).min() > 0.0
    assert aspects(mesh.points, mesh.corners).max() < 20.0


def test_a_strongly_bent_plate_is_whole():
    """Its chords leave 0.7 % of it out; with its faces bent nothing is missing."""
    body = {"arc_radius_mm": 6.0, "base_height_mm": 8.0}
    plates = {"count": 1, "thickness_mm": 0.26, "length_mm": 1.8, "cover_mm": 3.9}
    design = design_of("bent", body=body, plates=plates)
    mesh = extrude(design, Zone(2.0))
    _, weights = physical_gradients(mesh.points, mesh.cells, 4)
    volume = np.bincount(mesh.regions, weights.sum(axis=1))[1]
    assert volume == pytest.approx(1.8 * 0.26 * 2.0, rel=1e-5)


def test_a_step_body_has_no_section():
    body = {"shape": "step", "step": {"file": "finger.step"}}
    design = Design.model_validate({"design": {"name": "s"}, "body": body, "plates": {"count": 0}})
    with pytest.raises(MeshError, match="3-D"):
        mesh_section(design, 2.0)


def test_thin_plates_get_lower_layers():
    """The least dihedral angle of an extruded mesh stays over a degree however thin the plates."""
    thin = design_of("plain", plates={"thickness_mm": 0.02}, mesh={"plate_size_mm": 0.4})
    layers = []
    for design in (design_of("plain"), thin):
        mesh = extrude(design, Zone(2.0))
        assert cell_angles(mesh.points, mesh.corners).min() >= 1.0
        layers.append(mesh.notes["layers"])
    assert layers[0] == 2
    assert layers[1] > 2


def test_layers_stop_growing_at_the_height_given():
    heights = layer_heights(5.0, 4, 1.15, 0.8)
    steps = np.diff(heights)
    assert heights[0] == 0.0
    assert heights[-1] == pytest.approx(5.0)
    assert steps.max() <= 0.8
    assert (np.diff(steps) < 1e-12).all()
    assert len(layer_heights(5.0, 4, 1.15)) == 5
    steps = np.diff(layer_heights(5.0, 4, 1.25))
    assert steps[:-1] / steps[1:] == pytest.approx(1.25)  # thin toward the free end
    assert np.diff(layer_heights(5.0, 4, 0.8))[::-1] == pytest.approx(steps)  # toward z = 0


def test_fine_where_the_contact_is():
    design = design_of("plain", mesh={"section": {}})
    mesh = mesh_section(design, 2.0)
    facets = mesh.facets["contact"][:, :2]
    ends = mesh.points[facets]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    inside = np.abs(ends[:, :, 0]).max(axis=1) <= 2.0
    assert length[inside].max() <= 1.2 * design.mesh.section.contact_size_mm


def test_gage_ends_are_nodes():
    mesh = mesh_section(design_of("plain"), 2.0)
    frame = plate_frames(design_of("plain"))[2]
    for side in (-0.5, 0.5):
        for end in (-0.5, 0.5):
            place = np.array([frame.x, frame.y]) + end * 1.0 * frame.axis
            place = place + side * frame.thickness * frame.normal
            assert np.linalg.norm(mesh.points - place, axis=1).min() < 1e-9


def test_a_body_that_changes_along_z_cannot_be_extruded():
    dome = with_values(design_of("plain"), {"body.shape": "dome", "body.dome_radius_mm": 20.0})
    with pytest.raises(MeshError, match=r"body\.shape = 'dome'.*tetwild"):
        extrude(dome, Zone(2.0))


# The netgen process that stays: the same answers, and what becomes of one that fails.


def square(size, width=1.0):
    outline = Outline(size, 0.3)
    corners = [outline.point(x * width, y) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)):
        outline.curve([corners[a], corners[b]], BODY, 0, size)
    return asdict(outline)


def test_one_process_answers_again_and_again_and_alike():
    first, number = run_netgen(square(0.2), 30.0), start_mesher().pid
    run_netgen(square(0.1, 3.0), 30.0)
    again = run_netgen(square(0.2), 30.0)
    assert start_mesher().pid == number
    for one, two in zip(first, again, strict=True):
        assert np.array_equal(one, two)
    points, triangles, domains = first
    assert np.abs(cell_volumes(points, triangles)).sum() == pytest.approx(1.0, rel=1e-12)
    assert set(domains.tolist()) == {BODY}


def test_failures_are_said_in_words_and_the_next_mesh_is_made():
    with pytest.raises(MeshError, match="it failed: KeyError"):
        run_netgen({"points": []}, 30.0)
    old = start_mesher()
    with pytest.raises(MeshError, match=r"did not finish in 0\.2 s"):
        run_netgen(square(0.001), 0.2)
    assert not old.alive
    assert len(run_netgen(square(0.5), 30.0)[1]) > 0


def test_each_thread_has_its_own():
    def work(_):
        return len(run_netgen(square(0.2), 30.0)[1]), start_mesher().pid, started.wait(30.0)

    started = threading.Barrier(2)
    with ThreadPoolExecutor(2) as pool:
        (one, first, _), (two, second, _) = pool.map(work, range(2))
    assert one == two
    assert first != second
