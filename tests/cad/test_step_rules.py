"""The rules of [body.step]: which way is up, base and contact surface, files that will not do."""

import cadquery as cq
import numpy as np
import pytest

from fingerdesign import DesignError, load_design, parse_design, with_values
from fingerdesign.design import step as facts_module
from fingerdesign.design.body import StepFile
from fingerdesign.design.io import dump_design
from fingerdesign.design.step import portable, resolved, step_facts
from fingerdesign.layout.rows import plate_frames
from tests.support.steps import read_here, write

TEXT = """
design.name = "mine"
plates.count = 3
[body]
shape = "step"
[body.step]
file = "body.step"
"""


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch, tmp_path):
    read_here(monkeypatch, tmp_path / "cache")


def block(chamfer=1.0):
    """20 x 12 x 10 (x, y, z) with its upper edges along z chamfered; base in y = 0."""
    work = cq.Workplane("XY").box(20, 12, 10).translate((0, 6, 0))
    return work.faces(">Y").edges("|Z").chamfer(chamfer)


def fault_of(path, **rules):
    with pytest.raises(DesignError) as caught:
        step_facts(StepFile(file=str(path), **rules))
    (fault,) = caught.value.faults
    return fault


# How a body drawn with +y up is turned so that the file's axis ``up`` points there.
TURNED = {
    "x": ((0, 0, 0), (0, 0, 1), -90),
    "-x": ((0, 0, 0), (0, 0, 1), 90),
    "z": ((0, 0, 0), (1, 0, 0), 90),
    "-z": ((0, 0, 0), (1, 0, 0), -90),
    "-y": ((0, 0, 0), (0, 0, 1), 180),
}


def test_plates_follow_a_file_that_is_written_again(tmp_path):
    path = write(block(), tmp_path / "body.step")
    design = parse_design(TEXT.replace('"body.step"', f'"{path}"'))
    before = [frame.y for frame in plate_frames(design)]
    write(block().union(cq.Workplane("XY").box(18, 2, 10).translate((0, 12, 0))), path)
    assert [frame.y for frame in plate_frames(design)] == pytest.approx(np.array(before) + 1.0)


@pytest.mark.parametrize("up", TURNED)
def test_any_axis_may_be_up(up, tmp_path):
    start, axis, angle = TURNED[up]
    # A wedge that is its own image in nothing: a wrong turn or mirror shows.
    corners = [(0, 0), (8, 0), (8, 6), (0, 10)]
    work = cq.Workplane("XY").polyline(corners).close().extrude(5)
    path = write(work.rotate(start, axis, angle).translate((3, -7, 2)), tmp_path / "w.step")
    facts = step_facts(StepFile(file=str(path), up=up))
    np.testing.assert_allclose(facts.low, (-4, 0, -2.5), atol=1e-6)
    np.testing.assert_allclose(facts.high, (4, 10, 2.5), atol=1e-6)
    np.testing.assert_allclose(facts.height(np.array([-3.0, 3.0]), 2.0), [9.5, 6.5], atol=1e-9)


@pytest.mark.slow
def test_edges_and_ledges_belong_to_the_contact_surface_by_angle_and_height(tmp_path):
    path = str(write(block().translate((2.0, 5.0, 1.0)), tmp_path / "b.step"))
    areas = step_facts(StepFile(file=path)).area
    assert areas == pytest.approx(
        {"base": 200, "contact": 180 + 20 * np.sqrt(2), "side": 220, "end": 2 * (240 - 1)}
    )
    narrow = step_facts(StepFile(file=path, contact_angle_deg=40)).area
    assert narrow["contact"] == pytest.approx(180)
    assert narrow["side"] == pytest.approx(220 + 20 * np.sqrt(2))
    left = step_facts(StepFile(file=path, centre=False))  # as it was drawn
    np.testing.assert_allclose((*left.low, *left.high), (-8, 0, -4, 12, 12, 6), atol=1e-9)
    work = cq.Workplane("XY").box(20, 4, 10).translate((0, 2, 0))
    whole = work.union(cq.Workplane("XY").box(8, 12, 10).translate((0, 6, 0)))
    path = str(write(whole, tmp_path / "t.step"))
    assert step_facts(StepFile(file=path)).area["contact"] == pytest.approx(200)
    high = step_facts(StepFile(file=path, contact_above_mm=5.0))
    assert high.area["contact"] == pytest.approx(80)
    assert high.lowest == pytest.approx(12.0)
    inner = work.union(cq.Workplane("XY").box(8, 12, 6).translate((0, 6, 0)))
    path = str(write(inner, tmp_path / "inner.step"))
    assert step_facts(StepFile(file=path)).area["end"] == pytest.approx(2 * 80)  # not its tower's


@pytest.mark.slow
def test_bodies_that_a_rule_does_not_fit(tmp_path):
    """Each fault names the rule to blame and says what would do."""
    plain, ball = block(), cq.Workplane("XY").sphere(6.0)
    bulged = cq.Workplane("XY").box(10, 8, 10).translate((0, 4, 0)).union(cq.Workplane().sphere(3))
    lean = block().faces(">Z").edges("|X").edges(">Y").chamfer(0.5)
    two = block().add(block().translate((40, 0, 0)))
    sheet = cq.Workplane("XY").box(10, 10, 10).faces("not >Y")
    tiny = cq.Workplane("XY").box(0.02, 0.012, 0.01)  # metres for millimetres
    down, up = {"base_direction": (-1.0, -1.0, 0.0)}, {"base_direction": (0.0, 1.0, 0.0)}
    oblique = {"contact_direction": (1.0, 1.0, 1.0), "contact_angle_deg": 5.0}
    cases = [
        (plain, down, "base_direction", ("[0, -1, 0]", "[0, 0, 1]")),
        (plain, up, "base_direction", ("same face",)),
        (plain, oblique, "contact_direction", ("[0, 1, 0] at y = 12",)),
        (plain, {"contact_above_mm": 20.0}, "contact_above_mm", ("y = 12",)),
        (plain.translate((30.0, 0.0, 0.0)), {"centre": False}, "file", ("x = z = 0",)),
        (ball, {}, "base_direction", ()),
        (bulged, {}, "base_direction", ("3 mm below",)),
        (lean, {"mirrors_in_z": True}, "mirrors_in_z", ("0.35 mm",)),
        (two, {}, "file", ("2 solids",)),
        (sheet, {}, "file", ("0 solids",)),
        (tiny, {}, "file", ("unit",)),
    ]
    for number, (work, rules, key, words) in enumerate(cases):
        fault = fault_of(write(work, tmp_path / f"{number}.step"), **rules)
        assert fault.key == f"body.step.{key}"
        assert all(word in f"{fault.bound} {fault.remedy}" for word in words)


@pytest.mark.parametrize("within", [False, True])
def test_holes_that_do_not_mirror_are_reported_though_the_volume_would(within, tmp_path):
    def pierced(*places):
        work = cq.Workplane("XY").box(20, 12, 20).translate((0, 6, 0))
        for x, z in places:
            ball = cq.Workplane("XY").sphere(2).translate((x, 6, z))
            drill = cq.Workplane("XZ").center(x, z).circle(1.5).extrude(-12)
            work = work.cut(ball if within else drill)
        return work

    across = write(pierced((4, 4), (-4, -4)), tmp_path / "across.step")
    assert fault_of(across, mirrors_in_z=True).key == "body.step.mirrors_in_z"
    mirrored = write(pierced((4, 4), (4, -4)), tmp_path / "mirrored.step")
    assert step_facts(StepFile(file=str(mirrored), mirrors_in_z=True)).volume < 4780.0


def test_files_that_are_no_solid(tmp_path):
    assert "No such file" in fault_of(tmp_path / "absent.step").remedy
    assert fault_of(tmp_path).bound == "an ordinary file"
    other = tmp_path / "other.step"
    other.write_text("solid cube\n", "utf-8")
    assert "ISO-10303-21" in fault_of(other).remedy
    good = write(block(), tmp_path / "b.step").read_text("utf-8")
    for text in ("ISO-10303-21;\nHEADER;\nthe rest was lost", good[: len(good) // 2]):
        other.write_text(text, "utf-8")
        assert fault_of(other).key == "body.step.file"


def test_a_cache_that_cannot_be_written_costs_time_alone(tmp_path):
    write(block(), tmp_path / "b.step")
    (tmp_path / "cache").write_text("", "utf-8")
    facts = step_facts(StepFile(file=str(tmp_path / "b.step")))
    assert facts.volume == pytest.approx(2390)
    assert facts.brep.is_file()


@pytest.mark.parametrize("ending", [".npz", ".brep"])
@pytest.mark.parametrize("damage", ["cut", "changed", "emptied", "removed"])
def test_garbled_entries_are_made_anew(ending, damage, tmp_path):
    step = StepFile(file=str(write(block(), tmp_path / "b.step")))
    stored = step_facts(step).brep.with_suffix(ending)
    whole = stored.read_bytes()
    middle = len(whole) // 2
    flipped = bytes([whole[middle] ^ 1])
    if damage == "removed":
        stored.unlink()
    else:
        garbled = {"cut": whole[:middle], "emptied": b""}
        garbled["changed"] = whole[:middle] + flipped + whole[middle + 1 :]
        stored.write_bytes(garbled[damage])
    facts_module._outcome.cache_clear()
    assert step_facts(step).volume == pytest.approx(2390)
    assert facts_module.outline_file(step).is_file()
    if ending == ".brep":
        assert stored.read_bytes() == whole
        stored.write_bytes(whole[:middle])  # while this process holds the facts
        assert facts_module.outline_file(step).read_bytes() == whole


def test_a_design_takes_its_sizes_from_the_file(tmp_path):
    write(block(), tmp_path / "body.step")
    (tmp_path / "mine.toml").write_text(TEXT, "utf-8")
    design = load_design(tmp_path / "mine.toml")
    body = design.body
    assert (body.width_mm, body.depth_mm, body.base_height_mm) == (20.0, 10.0, 11.0)
    assert body.step.file == str(tmp_path / "body.step")
    assert parse_design(dump_design(design)) == design
    narrow = with_values(design, {"body.step.contact_angle_deg": 40.0, "body.material": "silicone"})
    assert narrow.body.base_height_mm == 12.0
    assert narrow.digest() != design.digest()
    (tmp_path / "elsewhere").mkdir()
    copy = tmp_path / "elsewhere" / "copy.step"
    copy.write_bytes((tmp_path / "body.step").read_bytes())
    assert with_values(design, {"body.step.file": str(copy)}).digest() == design.digest()
    shown = portable({"body.step.file": str(copy), "body.shape": "step"})
    assert shown["body.step.file"] == "copy.step"
    assert len(str(shown["body.step.content"])) == 64


def test_keys_next_to_the_file_are_judged_with_it(tmp_path):
    """A size of one's own, a bad file with another fault, a faulty rule that keeps it unread."""
    for made, text, keys in (
        (False, TEXT + "\n[gages]\nfaec = 1", {"body.step.file", "gages.faec"}),
        (True, TEXT.replace('"step"\n', '"step"\nwidth_mm = 18.0\n', 1), {"body.width_mm"}),
        (True, TEXT + 'up = "w"\ncontact_above_mm = 50', {"body.step.up"}),
    ):
        if made:
            write(block(), tmp_path / "body.step")
        with pytest.raises(DesignError) as caught:
            parse_design(text, folder=tmp_path)
        assert {fault.key for fault in caught.value.faults} == keys
    odd = {"body": {"shape": "step", "step": {"file": "x.step", "up": "w"}}}
    for data in ({}, {"body": 3}, {"body": {"shape": "arc"}}, {"body": {"shape": "step"}}):
        assert resolved(data)[0] == data
    assert not resolved(odd)[1]  # its keys' own
