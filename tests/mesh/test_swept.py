"""Sections and what is swept through layers: every kind of body, plate and core is the design's."""

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace

import numpy as np
import pytest

from fingerdesign import parse_design, with_values
from fingerdesign.design.schema import Design
from fingerdesign.errors import MeshError
from fingerdesign.fem.sheet import sheet_of
from fingerdesign.layout.layers import not_layered, overlaps
from fingerdesign.layout.rows import mirrors_in_z, plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.quality import assess
from fingerdesign.mesh.section import netgen
from fingerdesign.mesh.section.extrude import distinct, extrude, graded_heights, layer_heights
from fingerdesign.mesh.section.netgen import run_netgen, start_mesher, triangulated
from fingerdesign.mesh.section.outline import BODY, Outline
from fingerdesign.mesh.section.plates import section_frames
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.sheets import open_sheets, room_around
from tests.support.session import never_called

DESIGN = parse_design(
    """
    design.name = "kind"
    body.width_mm = 12.0
    body.base_height_mm = 5.0
    body.arc_radius_mm = 10.0
    body.depth_mm = 6.0
    plates.count = 3
    plates.length_mm = 2.0
    mesh.layers = 2
    mesh.contact_size_mm = 0.8
    mesh.plate_size_mm = 0.5
    [mesh.section]
    plate_size_mm = 0.2
    plate_end_size_mm = 0.05
    contact_size_mm = 0.3
    """
)
SHORT = {"plates.length_mm": 1.5, "plates.span_mm": 3.0}
CORE = {"width_mm": 6.0, "height_mm": 1.0, "bottom_mm": 0.5}
INNER = SHORT | {"body.core": CORE | {"depth_mm": 3.0}}
SHEET = {"plates.model": "sheet"}
BENT = {"plates.follow": "bent", "plates.angle_deg": 0.0, "plates.pitch_mm": 3.2}
BLOCK = {"body.shape": "block", "body.arc_radius_mm": None}
STRONG = {"plates.count": 1, "plates.thickness_mm": 0.26, "plates.length_mm": 1.8}
PLACES = {"plates.placement": [[-2.0, 4.0, 45.0, 0.4], [0, 4, 45], [2, 4, 45, -0.6]]}
KINDS = {
    "rounded": {"body.edge_radius_mm": 2.0},
    "chamfered": {"body.edge_radius_mm": 1.5, "body.edge": "chamfer"},
    "flat": BLOCK,
    "flat, rounded": BLOCK | {"body.edge_radius_mm": 2.5},
    "half circle": {"body.arc_radius_mm": 6.0, "body.edge_radius_mm": 1.0},
    "bone": {"body.core": CORE},
    "backing": {"body.core": CORE | {"bottom_mm": 0.0}},
    "full backing": {"body.core": CORE | {"bottom_mm": 0.0, "width_mm": 12.0}},
    "layer": {"body.core": CORE | {"width_mm": 12.0}},
    "bent": BENT,
    "strongly bent": BENT
    | {"body.arc_radius_mm": 6.0, "body.base_height_mm": 8.0, "plates.cover_mm": 3.9}
    | STRONG,
    "turned": {"plates.follow": "turned", "plates.angle_deg": 30.0, "plates.pitch_mm": 1.5},
    "common span": SHORT,
    "off the middle": SHORT | {"plates.span_offset_mm": 0.5},
    "staggered": SHORT | {"plates.stagger_mm": 1.0},
    "placed": SHORT | PLACES,
    "core ends inside": INNER,
    "bent, ends inside": SHORT | BENT | {"plates.cover_mm": 1.0},
    "sheets": SHEET,
    "sheets end inside": SHEET | SHORT,
    "staggered sheets": SHEET | SHORT | {"plates.stagger_mm": 1.0},
    "sheets and core": SHEET | INNER,
    "crossing, thick sheets": SHEET
    | {"plates.placement": [[-2.2, 5.2, 10.0], [0.5, 5.0, -60.0], [2.6, 4.5, 90.0]]}
    | {"plates.thickness_mm": 0.3},
    "left out, core": INNER | {"plates.model": "none"},
}


def unchecked(values):
    """The design with values that need not be sound together."""
    data = DESIGN.model_dump(exclude_none=True)
    for key, value in values.items():
        table, name = key.split(".")
        data[table].pop(name, None)
        data[table] |= {} if value is None else {name: value}
    return Design.model_validate(data)


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_is_true_to_its_design(name):
    """Regions' volumes, faces' places and areas, in the section and swept, by the closed forms."""
    design = unchecked(KINDS[name])
    mirrors = mirrors_in_z(design)
    assert mirrors == (name not in ("off the middle", "placed") and "stag" not in name)
    swept, flat = extrude(design, Zone(2.0), mirrors), mesh_section(design, 2.0)
    outside = {"base", "side", "contact"}
    for mesh, faces in (
        (swept, outside | {"end"} | ({"symmetry"} if mirrors else set())),
        (flat, outside),
    ):
        report = assess(mesh, design)
        assert report.body_volume_error < 2e-5
        assert report.worst_plate_volume_error < 1e-5
        assert report.worst_face_area_error < 1e-5
        assert max(report.surface_distance_mm.values()) < 1e-9
        assert report.inverted_elements == 0
        assert report.min_dihedral_deg > 1.0
        assert {face for face in mesh.facets if not face.startswith("plate_")} == faces
        cut = plate_frames(design) if mesh is swept else section_frames(design)
        solid = cut if design.plates.model == "solid" else ()
        names = {mesh.region_name(int(number)) for number in np.unique(mesh.regions)}
        core = {"core"} if design.body.core is not None else set()
        assert names == {"elastomer"} | {f"plate_{frame.index}" for frame in solid} | core
        for frame in cut if design.plates.model == "sheet" else ():
            sheet_of(mesh, frame)  # its faces mirror node by node


@pytest.mark.parametrize("model", ["solid", "sheet"])
def test_half_and_whole_are_the_same_finger(model):
    design = with_values(DESIGN, SHORT | {"plates.model": model})
    half, whole = extrude(design, Zone(2.0)), extrude(design, Zone(2.0), symmetric=False)
    assert len(whole.cells) == 2 * len(half.cells)
    assert assess(whole, design).body_volume_error < 1e-6
    assert set(whole.facets) == set(half.facets) - {"symmetry"}


def test_a_section_shows_the_plates_that_it_cuts():
    """Of rows staggered beyond z = 0, only plates whose span covers it; none of those along z."""
    staggered = {"plates.span_mm": 1.5, "plates.stagger_mm": 2.0, "plates.count": 4}
    assert section_frames(with_values(DESIGN, staggered)) == ()
    wide = with_values(DESIGN, staggered | {"plates.span_mm": 2.5})
    assert [frame.index for frame in section_frames(wide)] == [0, 1, 2, 3]
    both = with_values(DESIGN, {"plates.rows": [{"along": "z", "cover_mm": 4.0}]})
    assert [frame.index for frame in section_frames(both)] == [0, 1, 2]
    assert set(np.unique(mesh_section(both, 2.0).regions)) == {0, 1, 2, 3}


@pytest.mark.parametrize("model", ["solid", "sheet"])
def test_gage_ends_are_nodes_and_the_contact_is_fine(model):
    mesh = mesh_section(with_values(DESIGN, {"plates.model": model}), 2.0)
    frame = plate_frames(DESIGN)[2]
    for side in (-0.05, 0.05):
        for end in (-0.5, 0.5):
            place = np.array([frame.x, frame.y]) + end * frame.axis + side * frame.normal
            assert np.linalg.norm(mesh.points - place, axis=1).min() < 1e-9
    ends = mesh.points[mesh.facets["contact"][:, :2]]
    inside = np.abs(ends[:, :, 0]).max(axis=1) <= 2.0
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)[inside].max() <= 1.25 * 0.3


# Layers.


def test_layers_grow_toward_or_away_from_the_free_end():
    heights = layer_heights(5.0, 4, 1.15)
    assert (len(heights), heights[0], heights[-1]) == (5, 0.0, pytest.approx(5.0))
    steps = np.diff(layer_heights(5.0, 4, 1.25))
    assert steps[:-1] / steps[1:] == pytest.approx(1.25)  # thin toward the free end
    assert np.diff(layer_heights(5.0, 4, 0.8))[::-1] == pytest.approx(steps)  # toward z = 0
    # A plate as long as the body needs no border, and changes no layer.
    full = extrude(with_values(DESIGN, {"plates.span_mm": 6.0, "mesh.layers": 3}), Zone(2.0))
    heights = np.unique(np.round(full.points[np.unique(full.corners), 2], 9))
    assert heights == pytest.approx(layer_heights(3.0, 3, 1.15))


def test_layers_are_thin_where_plates_end():
    heights = graded_heights(np.array([0.0, 2.5, 5.0]), np.array([-2.5, 2.5, 5.0]), 0.3, 1.15)
    steps, middle = np.diff(heights), 0.5 * (heights[1:] + heights[:-1])
    assert {0.0, 2.5, 5.0} <= set(heights)
    assert (steps > 0.0).all()
    near = np.abs(middle[:, None] - [2.5, 5.0]).min(axis=1)
    assert (np.abs(steps - 0.3 - 0.15 * near) < 0.1).all()


# What cannot be.


def test_what_cannot_be_layered_is_refused_by_name():
    short = with_values(DESIGN, SHORT)
    near = with_values(short, {"plates.placement": [[-2, 4, 45, 0.0], [2, 4, 45, 0.004]]})
    with pytest.raises(MeshError, match=r"end at z = -1\.5 and -1\.496 mm"):
        extrude(near, Zone(2.0), symmetric=False)
    with pytest.raises(MeshError, match="do not mirror"):
        extrude(with_values(short, {"plates.span_offset_mm": 0.5}), Zone(2.0))
    assert distinct(np.array([1.0, -1.0, 1.0 + 1e-13, 0.5])).tolist() == [-1.0, 0.5, 1.0]
    dome = with_values(DESIGN, {"body.shape": "dome", "body.dome_radius_mm": 20.0})
    with pytest.raises(MeshError, match=r"body\.shape = 'dome'.*tetwild"):
        extrude(dome, Zone(2.0))
    body = {"shape": "step", "step": {"file": "finger.step"}}
    step = Design.model_validate({"design": {"name": "s"}, "body": body, "plates": {"count": 0}})
    with pytest.raises(MeshError, match="3-D"):
        mesh_section(step, 2.0)


def test_parts_over_one_another_and_sheets_without_room_are_refused_by_name():
    """Apart in space, but drawn into one section."""
    crossing = {"plates.span_mm": 2.0, "plates.placement": [[0, 4, 45, -1.5], [0, 4, -45, 1.5]]}
    assert not_layered(with_values(DESIGN, crossing)).startswith("plates 0 and 1 overlap")
    core = {"body.core": CORE | {"depth_mm": 2.0}, "plates.span_mm": 1.5}
    beyond = with_values(DESIGN, core | {"plates.placement": [[0, 1.2, 0, 2.0], [0, 4, 0, -2.0]]})
    assert overlaps(beyond).startswith("plate 0 and the core overlap")
    frames = plate_frames(DESIGN)
    near = replace(frames[1], place=frames[0].place + 0.16)
    with pytest.raises(MeshError, match=r"plate 0 has 0\.0388 mm .* plates\.model = 'solid'"):
        room_around(frames[0], (frames[0], near), DESIGN.body)
    high = replace(frames[1], y=6.25)
    with pytest.raises(MeshError, match=r"plate 1 has 0\.0\d+ mm around its mid-line"):
        room_around(high, (high,), DESIGN.body)
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    with pytest.raises(MeshError, match="does not follow plate 0"):
        open_sheets(points, np.array([[0, 1, 2]]), frames[:1], DESIGN.body, 0.1)


@pytest.mark.parametrize("thickness", [0.03, 0.4])
def test_thin_and_thick_plates_open_without_turning_triangles_over(thickness):
    """Thick ones once did: the mesher cuts the lines beyond their ends into several."""
    row = "count = 8, length_mm = 2.2, angle_deg = 61.0, pitch_mm = 1.53, cover_mm = 1.9"
    plates = f'{{ {row}, thickness_mm = {thickness}, model = "sheet" }}'
    design = parse_design(f'design.name = "many"\nplates = {plates}')
    report = assess(mesh_section(design, 2.0), design)
    assert report.body_volume_error < 1e-6
    assert report.min_dihedral_deg > 3.0


# The netgen process that stays: the same answers, and what becomes of one that fails.


def square(size, width=1.0):
    outline = Outline(size, 0.3)
    corners = [outline.point(x * width, y) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)):
        outline.curve([corners[a], corners[b]], BODY, 0, size)
    return asdict(outline)


def test_one_process_answers_again_and_alike_until_it_fails():
    first, old = run_netgen(square(0.2), 30.0), start_mesher()
    run_netgen(square(0.1, 3.0), 30.0)
    again = run_netgen(square(0.2), 30.0)
    assert start_mesher().pid == old.pid
    for one, two in zip(first, again, strict=True):
        assert np.array_equal(one, two)
    points, triangles, domains = first
    assert np.abs(cell_volumes(points, triangles)).sum() == pytest.approx(1.0, rel=1e-12)
    assert set(domains.tolist()) == {BODY}
    with pytest.raises(MeshError, match="it failed: KeyError"):
        run_netgen({"points": []}, 30.0)
    old = start_mesher()
    with pytest.raises(MeshError, match=r"did not finish in 0\.2 s"):
        run_netgen(square(0.001), 0.2)
    assert not old.alive
    assert len(run_netgen(square(0.5), 30.0)[1]) > 0


def test_an_outline_is_triangulated_once_and_anew_where_it_is_garbled(tmp_path, own_cache):
    first = triangulated(square(0.2), 30.0)
    with never_called(netgen, "run_netgen"):
        kept = triangulated(square(0.2), 30.0)
        with pytest.raises(pytest.fail.Exception):
            triangulated(square(0.25), 30.0)
    for file in (tmp_path / "sections").iterdir():
        file.write_bytes(file.read_bytes()[:-100])
    for other in (kept, triangulated(square(0.2), 30.0)):
        for one, two in zip(first, other, strict=True):
            assert np.array_equal(one, two)
            assert one.dtype == two.dtype


def test_each_thread_has_its_own():
    def work(_):
        return len(run_netgen(square(0.2), 30.0)[1]), start_mesher().pid, started.wait(30.0)

    started = threading.Barrier(2)
    with ThreadPoolExecutor(2) as pool:
        (one, first, _), (two, second, _) = pool.map(work, range(2))
    assert one == two
    assert first != second
