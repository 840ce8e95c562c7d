"""A pad and a moving face: the engine's forces, work that is stored, slides, what is outside."""

import numpy as np
import pytest

from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.robots.pad import Pad
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import bump, followed

STILL = np.zeros(3)


def pad_on(friction, nodes=9, **more):
    """A pad with its crest at y = 0, and its problem."""
    problem = contact_problem(bump(nodes), Plane(0.0), friction)
    return Pad(problem, "both", 0.0, **more), problem


def pressed(pad, depth=0.008, steps=4):
    """Press to a depth, mm."""
    for k in range(1, steps + 1):
        found = pad.meet(np.array([0.0, -depth * k / steps, 0.0]), STILL)
    return found


def test_the_wrench_is_the_engines():
    """Approach, shear along x and z and twist, with partial slip: 1e-6 N, N mm, and no less."""
    pad, problem = pad_on(0.4)
    path = [Motion(0.002 * k, 0.0) for k in range(1, 5)]
    path += [Motion(0.008, 2e-4 * k, -1e-4 * k, 0.01 * k) for k in range(1, 12)]
    slid = 0
    for motion, exact in zip(path, followed(problem, path), strict=True):
        place = np.array([motion.shear, -motion.approach, motion.shear_z])
        found = pad.meet(place, np.array([0.0, np.deg2rad(motion.twist_deg), 0.0]))
        forces, points = exact.force, problem.model.points
        moment = np.cross(points, forces).sum(axis=0)
        assert found.wrench[:3] == pytest.approx(-forces.sum(axis=0), abs=1e-6)
        assert found.wrench[3:] == pytest.approx(-moment, abs=1e-6)
        slid += (exact.status == 2).any()
    assert slid >= 5
    assert found.measures.stick_ratio < 0.9


def test_nodes_left_out_change_nothing(monkeypatch):
    """Deeper, sheared and tilted past the nodes at hand: the wrench of all nodes, to 1e-8."""
    alone, problem = pad_on(0.4, 13)
    monkeypatch.setattr("fingerdesign.robots.pad._LEAST", 1000)
    whole, _ = pad_on(0.4, 13)
    counts = []
    for k in range(1, 41):
        place = np.array([1e-4 * k, -4e-4 * min(k, 30), 5e-5 * max(0, k - 20)])
        turned = np.array([2e-4 * max(0, k - 15), 0.0, -3e-4 * max(0, k - 10)])
        found, exact = alone.meet(place, turned), whole.meet(place, turned)
        assert found.wrench == pytest.approx(exact.wrench, abs=1e-8 * exact.normal_force)
        assert found.measures.stick_ratio == pytest.approx(exact.measures.stick_ratio, abs=1e-6)
        counts.append(found.problem.shape[0])
    assert counts[0] < counts[-1] <= exact.problem.shape[0] == problem.shape[0]


def test_a_pose_that_fails_changes_nothing():
    """Nodes taken in for a pose that has no answer are left out again."""
    pad, _ = pad_on(0.4, 13)
    pressed(pad, 0.004)
    stiffness, count = pad.stiffness(), pad.touch.problem.shape[0]
    with pytest.raises(ZoneExhausted):
        pad.meet(np.array([0.0, -0.5, 0.0]), STILL)
    # The inverse that the stiffness is solved with is computed again, not updated.
    assert pad.stiffness() == pytest.approx(stiffness, abs=1e-6 * stiffness.max())
    after = pad.meet(np.array([0.0, -0.005, 0.0]), STILL)
    other, problem = pad_on(0.4, 13)
    pressed(other, 0.004)
    assert count < problem.shape[0]
    assert after.wrench == pytest.approx(other.meet(np.array([0.0, -0.005, 0.0]), STILL).wrench)


def test_what_sticks_stores_the_work_in_all_six_directions():
    """- wrench is the gradient of the stored energy: central differences from one state."""
    step = 1e-6
    poses = np.array([1e-4, -0.008, 2e-4, 2e-4, 3e-4, -1e-4])  # mm and rad

    def stored(change):
        pad, _ = pad_on(50.0)
        pressed(pad)
        found = pad.meet(poses[:3] + change[:3], poses[3:] + change[3:])
        return found.stored_mJ, found.wrench

    wrench = stored(np.zeros(6))[1]
    for axis, unit in enumerate(np.eye(6)):
        up, down = stored(step * unit)[0], stored(-step * unit)[0]
        assert (up - down) / (2 * step) == pytest.approx(-wrench[axis], rel=2e-3, abs=2e-5)


def test_the_stiffness_is_the_slope_of_the_wrench():
    pad, _ = pad_on(50.0)
    pressed(pad)
    place, turned = np.array([1e-4, -0.0081, 0.0]), np.array([1e-4, 0.0, -1e-4])
    pad.meet(place, turned)
    stiffness = pad.stiffness()
    scale = np.sqrt(np.outer(np.diag(stiffness), np.diag(stiffness)))
    assert np.linalg.eigvalsh(stiffness / scale).min() > 0.0
    for axis, unit in enumerate(np.eye(6)):
        found = []
        for side in (1e-7, -1e-7):
            other, _ = pad_on(50.0)
            pressed(other)
            other.meet(place, turned)
            change = side * unit
            found.append(other.meet(place + change[:3], turned + change[3:]).wrench)
        slope = (found[0] - found[1]) / 2e-7
        assert np.abs((-slope - stiffness[:, axis]) / scale[:, axis]).max() < 1e-3


def test_an_object_may_slide_for_ever_along_a_plane():
    """The force stays mu F_n, and it acts where it did on the pad: the anchor goes on.

    Without the anchor's way the pad's force would act at a place that goes with the object.
    """
    pad, _ = pad_on(0.3)
    pressed(pad)
    first = None
    for x in np.linspace(0.0, 50.0, 200)[1:]:
        place = np.array([x, -0.008, 0.0])
        found = pad.meet(place, STILL)
        on_pad = found.wrench.copy()
        on_pad[3:] += np.cross(place, found.wrench[:3])
        if x > 0.5:
            first = on_pad if first is None else first
            assert on_pad == pytest.approx(first, rel=1e-6, abs=1e-6)
    assert found.wrench[0] == pytest.approx(-0.3 * found.normal_force, rel=1e-6)
    assert found.dissipated_mJ == pytest.approx(0.3 * found.normal_force * 50.0 / 199, rel=1e-3)


def test_a_free_object_begins_anew_where_it_is():
    pad, _ = pad_on(0.5)
    pressed(pad)
    pad.meet(np.array([0.002, -0.008, 0.0]), STILL)
    away = pad.meet(np.array([0.002, 0.1, 0.0]), STILL)
    assert away.wrench == pytest.approx(np.zeros(6))
    assert away.measures is None
    turned = np.array([0.0, 1.0, 0.0])  # free: a turn about the normal is none
    pad.meet(np.array([7.0, 0.1, -3.0]), turned)
    again = pad.meet(np.array([7.0, -0.002, -3.0]), turned)
    assert again.outside == ()
    assert np.abs(again.wrench[[0, 2, 4]]).max() < 1e-6 * again.normal_force


def test_motions_beyond_the_model_are_reported():
    pad, _ = pad_on(0.5)
    pressed(pad)
    place = np.array([0.0, -0.008, 0.0])
    assert pad.meet(place, np.deg2rad([0.0, 2.9, 0.0])).outside == ()
    (words,) = pad.meet(place, np.deg2rad([0.0, 3.2, 0.0])).outside
    assert "turned by 3.2 degrees" in words
    with pytest.raises(ZoneExhausted):
        pad.meet(np.array([0.0, -0.2, 0.0]), STILL)


def test_half_a_finger_reports_what_it_cannot_know():
    model = bump(9)
    half = contact_problem(type(model)(**{**vars(model), "symmetry_factor": 2}), Plane(0.0), 0.5)
    pad = Pad(half, "both", 0.0)
    found = pressed(pad)
    assert found.outside == ()
    assert pad.planar
    other, slid = pad_on(0.5)[0], np.array([0.02, -0.008, 0.0])
    whole = pressed(other)
    assert found.normal_force == pytest.approx(2 * whole.normal_force)
    assert found.stored_mJ == pytest.approx(2 * whole.stored_mJ)
    lost = [each.meet(slid, STILL).dissipated_mJ for each in (pad, other)]
    assert lost == pytest.approx([2 * lost[1], lost[1]], rel=1e-3, abs=0.0)
    (words,) = pad.meet(np.array([0.0, -0.008, 0.2]), STILL).outside
    assert "0.2 mm out of the plane" in words


@pytest.mark.parametrize("bad", [[0.0, np.nan, 0.0], [np.inf, 0.0, 0.0], [0.0, 0.0]])
def test_what_is_no_pose_is_refused_and_changes_nothing(bad):
    pad, other = pad_on(0.5)[0], pad_on(0.5)[0]
    pressed(pad), pressed(other)
    for pose, name in (((bad, STILL), "place"), ((STILL, bad), "rotation")):
        with pytest.raises(ValueError, match=f"{name} = .*three finite numbers"):
            pad.meet(*pose)
    slid = np.array([0.003, -0.008, 0.0])
    assert (pad.meet(slid, STILL).wrench == other.meet(slid.tolist(), STILL).wrench).all()


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"face": "top"}, "face = 'top': must be one of upper"),
        ({"crest_mm": np.nan}, "crest_mm = nan"),
        ({"half_face_mm": (1.0, np.nan)}, "half_face_mm = "),
        ({"half_face_mm": (0.0, 1.0)}, "half_face_mm = "),
    ],
)
def test_a_pad_without_meaning_is_refused(more, words):
    problem = contact_problem(bump(5), Plane(0.0), 0.5)
    with pytest.raises(ValueError, match=words):
        Pad(problem, **{"face": "both", "crest_mm": 0.0, **more})


def test_a_face_ends_at_its_edge():
    """The crest leaves a face of 0.5 mm: first contact past the edge is reported, then it is free;
    a face without an edge is pressed on."""
    pad, endless = pad_on(0.2, half_face_mm=(0.5, 5.0))[0], pad_on(0.2)[0]
    found = {}
    for way in np.linspace(0.0, 0.52, 40):
        pose = np.array([way, -0.008, 0.0]), STILL
        found[way], other = pad.meet(*pose), endless.meet(*pose)
        if way < 0.5:
            assert (found[way].wrench == other.wrench).all()
    assert found[0.0].outside == ()
    assert "past the edge" in found[max(way for way in found if way < 0.5)].outside[0]
    assert not found[0.52].wrench.any()
    assert other.normal_force > 0.0


def test_a_pad_that_is_reset_is_as_a_new_one():
    pad, new = pad_on(0.3)[0], pad_on(0.3)[0]
    pressed(pad)
    for k in range(1, 9):
        pad.meet(np.array([0.004 * k, -0.008, 0.001 * k]), STILL)
    pad.reset()
    assert not pad.touch.wrench.any()
    for pose in ([0.0, -0.006, 0.0], [0.002, -0.006, 0.001]):
        assert (pad.meet(pose, STILL).wrench == new.meet(pose, STILL).wrench).all()
