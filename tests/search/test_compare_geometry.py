"""What the comparison page draws of a design, as data: shapes, traces, grips."""

import copy
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from fingerdesign import load_design
from fingerdesign.layout.frames import crest_height, plate_frames, surface_height
from fingerdesign.layout.profile import profile_of
from fingerdesign.records.outcome import GripOutcome, Traces
from fingerdesign.search.compare.data import packed_grips, packed_traces, runs, unrolled
from fingerdesign.search.compare.geometry import MOST_PLATES, outline_of, packed_geometry

DESIGNS = sorted((Path(__file__).parents[2] / "designs").glob("*.toml"))


def data_of(path):
    return load_design(path).model_dump(mode="json", exclude_none=True)


@pytest.mark.parametrize("path", DESIGNS, ids=lambda path: path.stem)
def test_a_shipped_design_is_packed_small_and_whole(path):
    design = load_design(path)
    packed = packed_geometry(data_of(path))
    assert len(json.dumps(packed, allow_nan=False)) < 5000
    assert packed["note"] == ""
    assert packed["words"].startswith("The body is")
    assert packed["size"][1] == pytest.approx(crest_height(design.body), abs=1e-3)
    frames = plate_frames(design)
    assert len(packed["plates"]) == len(frames)
    for drawn, frame in zip(packed["plates"], frames, strict=True):
        assert drawn[:2] == pytest.approx(frame.centre, abs=1e-3)
        assert drawn[5:7] == pytest.approx((frame.low, frame.high), abs=1e-3)
        assert len(drawn) == 10 + len(frame.holes)


@pytest.mark.parametrize("path", DESIGNS, ids=lambda path: path.stem)
def test_the_outline_lies_on_the_surface(path):
    design = load_design(path)
    body, packed = design.body, packed_geometry(data_of(path))["body"]
    if body.shape == "revolved":
        r, y = np.array(packed["rings"]).reshape(-1, 2).T
        assert y == pytest.approx(surface_height(body, r * (1 - 1e-9)), abs=2e-3)
        return
    x, z, heights = (np.array(part) for part in packed["grid"])
    assert x[[0, -1]] == pytest.approx(np.array([-0.5, 0.5]) * body.width_mm)
    assert z[-1] == pytest.approx(body.depth_mm / 2)
    inner = slice(1, -1)  # at the side the outline may be upright
    want = surface_height(body, x[inner, None], z[None, :])
    # Heights are of the places as rounded, to a micrometre: steep ones are farther off.
    assert heights.reshape(len(x), len(z))[inner] == pytest.approx(want, abs=1e-2)


def test_neighbouring_facets_turn_too_little_to_look_like_an_edge():
    for path in DESIGNS:
        body = load_design(path).body
        for chain in profile_of(body).chains():
            points = outline_of(type(profile_of(body))(chain))
            along = np.diff(points, axis=0)
            angle = np.degrees(np.arctan2(along[:, 1], along[:, 0]))
            assert np.abs(np.diff(angle)).max(initial=0) < 13.0, path.stem


def test_files_as_written_do_as_well_as_whole_designs():
    path = DESIGNS[0].with_name("maeno2000.toml")
    written = tomllib.loads(path.read_text("utf-8"))
    assert packed_geometry(written) == packed_geometry(data_of(path))


def test_a_step_body_without_its_file_is_said_and_not_drawn(tmp_path):
    design = data_of(DESIGNS[0].with_name("block.toml"))
    design["body"] = {"shape": "step", "step": {"file": str(tmp_path / "gone.step")}}
    packed = packed_geometry(design)
    assert packed["body"] is None
    assert "STEP file" in packed["note"]


def test_a_step_body_is_drawn_from_border_to_border(tmp_path):
    cadquery = pytest.importorskip("cadquery")
    pin = cadquery.Workplane("XZ").circle(7.0).extrude(-8.0).faces(">Y").edges().chamfer(1.0)
    cadquery.exporters.export(pin, str(tmp_path / "pin.step"))
    path = tmp_path / "pin.toml"
    path.write_text(
        '[design]\nname = "pin"\n[plates]\ncount = 0\n[body]\nshape = "step"\n'
        '[body.step]\nfile = "pin.step"\ncontact_angle_deg = 30.0\n',
        encoding="utf-8",
    )
    packed = packed_geometry(data_of(path))
    assert "STEP" in packed["note"]
    assert packed["size"] == pytest.approx([14.0, 8.0, 14.0], abs=1e-3)
    x, z, heights = (np.array(part, dtype=float) for part in packed["body"]["grid"])
    ends = z.reshape(len(x), -1)[:, [0, -1]]
    across = np.abs(x) < 5.9
    assert np.hypot(x[across, None], ends[across]) == pytest.approx(6.0, abs=0.01)
    assert heights.reshape(len(x), -1)[across] == pytest.approx(8.0, abs=1e-6)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda d: d.clear(),
        lambda d: d["body"].update(arc_radius_mm=float("nan")),
        lambda d: d["body"].update(arc_radius_mm=3.0),
        lambda d: d["body"].update(shape="<script>"),
        lambda d: d.update(plates=["x"]),
        lambda d: d["plates"].update(count=10**9),
    ],
)
def test_data_that_is_no_design_is_said_and_not_drawn(spoil):
    design = copy.deepcopy(data_of(DESIGNS[0].with_name("maeno2000.toml")))
    spoil(design)
    packed = packed_geometry(design)
    assert packed["body"] is None
    assert packed["note"].endswith(".")
    json.dumps(packed, allow_nan=False)


def test_many_plates_are_cut_off_and_said():
    design = data_of(DESIGNS[0].with_name("maeno2000.toml"))
    design["plates"] |= {"count": MOST_PLATES + 5, "pitch_mm": 0.1, "length_mm": 0.05}
    packed = packed_geometry(design)
    assert len(packed["plates"]) == MOST_PLATES
    assert f"Of {MOST_PLATES + 5} plates" in packed["note"]


def test_traces_keep_their_keys_and_four_digits():
    traces = Traces(
        normal_force_N=(0.123456, None, 3.0),
        gages=((1.23456, -200.0), (None, 0.0)),
        contact_x_mm=(0.0, 0.5, 1.0),
        status=("..#", "/##"),
    )
    packed = packed_traces(traces)
    assert packed["normal_force_N"] == [0.1235, None, 3]
    assert packed["gages"] == [[1.235, -200], [None, 0]]
    assert packed["status"] == ["2.1#", "1/2#"]
    assert [unrolled(row) for row in packed["status"]] == list(traces.status)
    assert set(packed) == set(Traces.__dataclass_fields__)


def test_runs_come_back_as_they_were():
    chance = np.random.default_rng(3)
    for size in (0, 1, 7, 500):
        text = "".join(chance.choice(list(".#/"), size))
        assert unrolled(runs(text)) == text


def test_grips_carry_what_is_drawn():
    grip = GripOutcome("regulator", 0.5, 200.0, True, False, 1.23456, 9.87654, 0.4, (1.0,), (0.5,))
    (packed,) = packed_grips([grip])
    assert packed["safety_margin"] == 1.235
    assert packed["normal_force_N"] == [1]
    assert packed["lifted"] is True
