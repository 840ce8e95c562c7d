"""Slots in tetrahedra: faces that pair, volume, orientation, angles, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.layers import not_a_sheet
from fingerdesign.mesh.cells import boundary_facets
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.tetra.improve import least_dihedral
from fingerdesign.mesh.tetra.slot_cut import over
from fingerdesign.mesh.tetra.slots import open_slots
from fingerdesign.mesh.tetra.ways import carrier_frames
from fingerdesign.mesh.tetra.widen import fixed_on_faces
from tests.support.boxes import simplices

# Boxes of the grid below are 1 x 0.5 x 1 mm: mid-surfaces lie between its cells.
INSIDE = PlateFrame(0, 0.0, 2.5, 0.0, 2.0, 0.1, -1.0, 1.0)
FLUSH = PlateFrame(0, 0.0, 2.5, 0.0, 2.0, 0.1, -3.0, 3.0)
CROSSWISE = PlateFrame(0, 0.0, 2.5, 180.0, 2.0, 0.1, -1.0, 1.0, "z")
CASES = {"inside": INSIDE, "flush": FLUSH, "crosswise": CROSSWISE}
SHORT = replace(INSIDE, length=1.0)
PAIR = (replace(SHORT, place=-1.5), replace(SHORT, index=1, place=1.5, y=3.0))


def grid(half=False, seed=0):
    """A box of 6 x 5 x 6 mm in tetrahedra; nodes off the planes of INSIDE are shaken."""
    steps = [np.linspace(-3, 3, 7), np.linspace(0, 5, 11), np.linspace(0 if half else -3, 3, 7)]
    if half:
        steps[2] = steps[2][::2]
    points, tets = simplices(*steps)
    shaken = (np.abs(points) < [2.9, 4.9, 2.9]).all(axis=1) & (points[:, 1] > 0.1)
    shaken &= ~np.isin(points[:, 1], [2.5, 3.0]) & (points[:, 2] > 0.01 if half else True)
    rng = np.random.default_rng(seed)
    points[shaken] += rng.uniform(-0.08, 0.08, (shaken.sum(), 3))
    return points, tets


def carriers(points, tets, frames):
    """Regions: the cells above each mid-surface."""
    middle = points[tets].mean(axis=1)
    regions = np.zeros(len(tets), dtype=np.int64)
    for frame in frames:
        s, v = frame.local(middle).T
        w = frame.across(middle)
        own = (np.abs(s) < 0.5 * frame.length) & (v > 0.0) & (v < 0.5 - 0.08)
        near = (w > frame.low) & (w < frame.high)
        regions[own & near] = frame.index + 1
    return regions


def opened(frames, half=False):
    points, tets = grid(half)
    return open_slots(points, tets, carriers(points, tets, frames), frames), points, tets


@pytest.fixture(scope="module", params=[*CASES, "half"])
def case(request):
    """A plate, the slot, and the mesh before; "half" of a mesh and a plate's half."""
    frame, half = CASES.get(request.param, INSIDE), request.param == "half"
    slots, points, tets = opened((frame,), half)
    return replace(frame, low=0.0) if half else frame, slots, points, tets


def area(points, facets):
    a, b, c = (points[facets[:, k]] for k in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def test_the_slot_is_the_plate(case):
    frame, slots, points, tets = case
    lost = cell_volumes(points, tets).sum() - cell_volumes(slots.points, slots.tets).sum()
    assert lost == pytest.approx(frame.length * frame.thickness * frame.span, rel=1e-9)
    for side, sign in (("upper", 0.5), ("lower", -0.5)):
        facets = slots.facets[f"plate_0_{side}"]
        assert area(slots.points, facets) == pytest.approx(frame.length * frame.span, rel=1e-9)
        v = frame.local(slots.points[np.unique(facets)])[:, 1]
        np.testing.assert_allclose(v, sign * frame.thickness, atol=1e-12)
    ends = area(slots.points, slots.facets["plate_0_end"])
    inner = 0 if frame is FLUSH else 1 if frame.low == 0.0 else 2  # ends inside the mesh
    rim = 2.0 * frame.span + inner * frame.length
    assert ends == pytest.approx(rim * frame.thickness, rel=1e-9)


def test_nothing_is_open_but_the_slot(case):
    """The outside is what it was, and else the slot's faces alone bound the mesh."""
    frame, slots, points, tets = case
    named = np.vstack([*slots.facets.values()])
    outer = {tuple(sorted(f)) for f in boundary_facets(slots.tets).tolist()}
    faces = {tuple(sorted(f)) for f in named.tolist()}
    assert faces < outer
    rest = np.array(sorted(outer - faces))
    before = area(points, boundary_facets(tets))
    mouths = 2 if frame is FLUSH else 1 if frame.low == 0.0 else 0
    mouth = frame.length * frame.thickness
    assert area(slots.points, rest) == pytest.approx(before - mouths * mouth, rel=1e-9)


def test_faces_pair_node_by_node(case):
    """Lower facets list the nodes below those of the upper ones."""
    frame, slots, _, _ = case
    upper, lower = slots.facets["plate_0_upper"], slots.facets["plate_0_lower"]
    assert (slots.origin[upper] == slots.origin[lower]).all()
    apart = slots.points[upper] - slots.points[lower]
    wanted = frame.thickness * frame.direction(frame.normal)
    np.testing.assert_allclose(apart, np.broadcast_to(wanted, apart.shape), atol=1e-12)


def test_sound_tetrahedra_and_what_lies_far_stays(case):
    _, slots, points, _ = case
    assert cell_volumes(slots.points, slots.tets).min() > 0.0
    assert least_dihedral(slots.points[slots.tets]).min() > 5.0
    assert (slots.regions == 0).all()
    assert len(np.unique(slots.tets)) == len(slots.points)
    np.testing.assert_array_equal(slots.origin[: len(points)], np.arange(len(points)))
    shift = np.linalg.norm(slots.points - points[slots.origin], axis=1)
    assert np.median(shift) < 0.02
    assert (shift > 0.06).mean() < 0.1  # a few flat tetrahedra are mended
    low, high = points.min(axis=0), points.max(axis=0)
    for axis in range(3):
        for bound in (low[axis], high[axis]):
            face = np.abs(points[:, axis] - bound) < 1e-12
            assert (slots.points[: len(points)][face, axis] == bound).all()


def test_two_plates_and_another_region():
    points, tets = grid()
    regions = carriers(points, tets, PAIR)
    core = points[tets].mean(axis=1)[:, 1] < 1.0
    regions[core] = 3
    slots = open_slots(points, tets, regions, PAIR)
    assert len(slots.facets) == 6
    lost = cell_volumes(points, tets).sum() - cell_volumes(slots.points, slots.tets).sum()
    assert lost == pytest.approx(2 * 1.0 * 0.1 * 2.0, rel=1e-9)
    assert set(np.unique(slots.regions)) == {0, 3}
    kept = cell_volumes(slots.points, slots.tets)[slots.regions == 3].sum()
    assert kept == pytest.approx(cell_volumes(points, tets)[core].sum(), rel=1e-12)


def test_a_flat_tetrahedron_elsewhere_is_mended():
    """Snapping to a carrier's outer faces may flatten one; once opened, its nodes are free."""
    points, tets = grid()
    regions = carriers(points, tets, (INSIDE,))
    node = int(np.argmin(np.linalg.norm(points - [0.0, 3.5, 0.0], axis=1)))
    cell = tets[np.flatnonzero((tets == node).any(axis=1))[0]]
    points[node] = points[cell[cell != node]].mean(axis=0)
    assert cell_volumes(points, tets).min() < 1e-12
    slots = open_slots(points, tets, regions, (INSIDE,))
    assert least_dihedral(slots.points[slots.tets]).min() > 5.0


def test_what_cannot_be_opened_is_refused():
    points, tets = grid()
    regions = carriers(points, tets, (INSIDE,))
    thick = replace(INSIDE, thickness=6.0)
    with pytest.raises(MeshError, match="turned over"):
        open_slots(points, tets, carriers(points, tets, (thick,)), (thick,))
    above = (np.abs(points[tets, 1] - 2.5) < 1e-9).sum(axis=1) == 3
    regions[np.flatnonzero(above & (regions > 0))[0]] = 0
    with pytest.raises(MeshError, match=r"follows .* of 4 mm\^2 of plate 0's mid-surface"):
        open_slots(points, tets, regions, (INSIDE,))
    points, tets = grid(half=True)
    upright = replace(CROSSWISE, angle_deg=90.0, y=2.0, low=-1.0, high=1.0)
    middle = points[tets].mean(axis=1)
    box = (np.abs(middle[:, 0]) < 1.0) & (np.abs(middle[:, 1] - 2.0) < 1.0) & (middle[:, 2] < 0.9)
    with pytest.raises(MeshError, match="lies on the outside of what is meshed"):
        open_slots(points, tets, box.astype(np.int64), (upright,))


TEXT = """
    design.name = "carriers"
    body.depth_mm = 8.0
    plates.count = 5
    plates.model = "sheet"
"""


def test_what_cannot_be_a_sheet():
    bent = replace(INSIDE, bend_radius=20.0)
    upright = replace(CROSSWISE, angle_deg=90.0)
    assert "bent" in str(not_a_sheet(bent))
    assert "symmetry plane" in str(not_a_sheet(upright, half=True))
    assert not_a_sheet(upright) is None
    assert not_a_sheet(INSIDE, half=True) is None
    design = parse_design(TEXT)
    with pytest.raises(MeshError, match="plate 0 cannot be a sheet: it is bent"):
        carrier_frames((bent,), design)


def test_a_facet_without_area_holds_its_nodes_in_all_directions():
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 0, 1], [0, 1, 0]], dtype=float)
    tets, regions = np.array([[0, 1, 3, 4]]), np.zeros(1, dtype=np.int64)
    held = fixed_on_faces(points, tets, regions, np.array([[0, 1, 2], [0, 1, 3]]))
    assert held[[0, 1, 2]].all()  # of 0, 1, 2 in a row
    assert held[3].tolist() == [False, True, False]  # across y, by 0, 1, 3
    assert not held[4].any()


def test_a_direction_is_over_a_sheet_where_its_projection_is_on_it():
    spans = np.array([[[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]], [[1.0, 1.0, 0.0], [0.0, 2.0, 0.0]]])
    angle = np.radians([-30.0, 1.0, 45.0, 89.0, 120.0, 225.0])
    unit = np.column_stack([np.cos(angle), np.sin(angle), np.linspace(-2.0, 2.0, 6)])
    np.testing.assert_array_equal(over(unit, spans), [False, True, True, True, False, False])
