"""What the comparison page draws of a design, as data: shapes, traces, grips."""

import gzip
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fingerdesign import load_design
from fingerdesign.analysis.page.shapes import SHARP_DEG, body_triangles, hole_rims, outline_of
from fingerdesign.analysis.page.surfaces import gage_quads
from fingerdesign.layout.bodies import crest_height, surface_height
from fingerdesign.layout.profile import profile_of
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.volume import outline_volume
from fingerdesign.records.outcome import Traces
from fingerdesign.report.figure import fans
from fingerdesign.search.compare.figures import contact_figure, forces_figure, frictions_of
from fingerdesign.search.compare.geometry import packed_geometry
from tests.support.any_outcomes import any_outcomes

DESIGNS = sorted((Path(__file__).parents[2] / "designs").glob("*.toml"))
PAPER = DESIGNS[0].with_name("maeno2000.toml")


def data_of(path):
    return load_design(path).model_dump(mode="json", exclude_none=True)


def points(packed):
    return np.column_stack([np.array(packed[axis], dtype=float) for axis in "xyz"])


@pytest.mark.parametrize("path", DESIGNS, ids=lambda path: path.stem)
def test_a_shipped_design_is_packed_small_and_whole(path):
    design = load_design(path)
    packed = packed_geometry(data_of(path))
    assert len(gzip.compress(json.dumps(packed, allow_nan=False).encode())) < 5000
    assert packed["note"] == ""
    assert packed["size"][1] == pytest.approx(crest_height(design.body), abs=1e-3)
    assert points(packed["body"])[:, 1].max() == pytest.approx(packed["size"][1], abs=1e-3)
    assert (packed["plates"] is None) == (not plate_frames(design))
    for frame in plate_frames(design):  # gages and holes are marked on the plates' faces
        upper = design.gages.model_copy(update={"face": "upper"})
        gages, holes = fans(gage_quads((frame,), upper)), fans(hole_rims(frame))
        assert len(gages.triangles) == (2 if frame.bend_radius is None else 12)
        above = frame.local(gages.vertices.mean(axis=0, keepdims=True))[0, 1]
        assert above > 0.5 * frame.thickness - 1e-9
        assert len(holes.triangles) == 2 * 14 * len(frame.holes)
    for deep in (False, True):
        the_contact_lies_on_the_surface(design.body, data_of(path), deep)


def the_contact_lies_on_the_surface(body, data, deep):
    (made,) = any_outcomes(1, seed=3, failed=0.0, deep=deep)
    touch = packed_geometry(data, made.traces)["touch"]
    found = points(touch["places"])
    assert len(found) == touch["each"] * len(made.traces.contact_x_mm)
    there = np.isfinite(found).all(axis=1)
    assert there.mean() > 0.9
    x, y, z = found[there].T
    assert y == pytest.approx(surface_height(body, x, z), abs=0.1)
    assert (y >= surface_height(body, x, z)).all()
    assert touch["each"] == 1 if deep else np.ptp(z) > 0.9 * min(body.depth_mm, body.width_mm)


@pytest.mark.parametrize("path", DESIGNS, ids=lambda path: path.stem)
def test_the_body_is_closed_of_the_right_volume_and_on_the_surface(path):
    body = load_design(path).body
    solid, height = body_triangles(body)
    ends, cosine = solid.edges()
    assert np.isfinite(cosine).all(), "an edge with one facet: the body is open"
    # Chords of a convex outline lose a little.
    a, b, c = np.moveaxis(solid.vertices[solid.triangles], 1, 0)
    volume = float((a * np.cross(b, c)).sum() / 6.0)  # by the divergence theorem
    assert volume == pytest.approx(outline_volume(body), rel=0.01)
    assert height == pytest.approx(crest_height(body))
    x, y, z = solid.vertices.T
    half = 0.5 * body.width_mm
    assert np.abs(x).max() == pytest.approx(half)
    inner = (y > 1e-9) & (np.abs(x) < half - 1e-6)
    inner &= (np.hypot(x, z) < half - 1e-6) | (body.shape != "revolved")
    assert y[inner] == pytest.approx(surface_height(body, x[inner], z[inner]), abs=2e-3)
    # Lines are drawn along edges of the body alone: facets of one surface turn too little.
    some = len(solid.sharp_edges(SHARP_DEG))
    assert 0 < some < 0.4 * len(ends)
    assert some == (cosine < np.cos(np.radians(SHARP_DEG))).sum()
    for chain in profile_of(body).chains():
        along = np.diff(outline_of(type(profile_of(body))(chain)), axis=0)
        angle = np.degrees(np.arctan2(along[:, 1], along[:, 0]))
        assert np.abs(np.diff(angle)).max(initial=0) < 13.0


@pytest.mark.parametrize(
    ("spoil", "note"),
    [
        (lambda d: d.clear(), "."),
        (lambda d: d["body"].update(arc_radius_mm=float("nan")), "."),
        (lambda d: d["body"].update(arc_radius_mm=3.0), "."),
        (lambda d: d["body"].update(shape="<script>"), "."),
        (lambda d: d.update(body={"shape": "step", "step": {"file": "/gone"}}), "STEP file"),
        (lambda d: d.update(plates=["x"]), "."),
        (lambda d: d["plates"].update(count=10**9), "."),
    ],
)
def test_data_that_is_no_design_is_named_and_not_drawn(spoil, note):
    design = data_of(PAPER)
    spoil(design)
    packed = packed_geometry(design)
    assert packed["body"] is None
    assert note in packed["note"]
    json.dumps(packed, allow_nan=False)


def test_the_contact_of_half_a_model_is_drawn_with_its_mirror_image():
    design = data_of(PAPER)
    (made,) = any_outcomes(1, seed=3, failed=0.0, deep=True)
    depth = np.linspace(0.0, 4.0, len(made.traces.contact_x_mm))
    traces = replace(made.traces, contact_z_mm=tuple(depth.tolist()))
    touch = packed_geometry(design, traces)["touch"]
    z = points(touch["places"])[:, 2].reshape(-1, 2)
    np.testing.assert_allclose(z, np.column_stack([depth, -depth]), atol=1e-3)


@pytest.mark.parametrize("number", range(3))
def test_contact_rows_are_as_long_as_the_status_says(number):
    made = any_outcomes(3, seed=1, failed=0.0)[number].traces
    rows = "".join(made.status)
    step = made.contact_x_mm[1] - made.contact_x_mm[0]
    for bars, character in zip(contact_figure(made)["data"], "#/", strict=True):
        assert sum(bars["x"]) == pytest.approx(step * rows.count(character), rel=0.01)
        assert set(bars["y"]) <= set(range(1, len(made.status) + 1))


def test_contact_of_a_half_model_is_mirrored():
    deep = any_outcomes(1, seed=2, failed=0.0, deep=True)[0].traces
    marks = contact_figure(deep)["marks"]
    assert (marks["each"], len(marks["places"]["x"])) == (1, len(deep.contact_x_mm))
    half = Traces(contact_x_mm=(0.0, 1.0), contact_z_mm=(0.0, 2.0), status=("#/",))
    marks = contact_figure(half)["marks"]
    assert marks["each"] == 2
    assert marks["places"] == {"x": [0, 0, 1, 1], "y": [0, 0, 2, -2]}


def test_forces_stand_against_their_own_limit():
    outcomes = any_outcomes(3, seed=1, failed=0.0)
    frictions = frictions_of(outcomes)
    assert list(frictions) == [0.2, 0.5, 0.8]
    figure = forces_figure(outcomes[0], frictions)
    limits = [trace for trace in figure["data"] if trace["name"].startswith("limit")]
    for trace, friction in zip(limits, frictions, strict=True):
        assert trace["y"][1] / trace["x"][1] == pytest.approx(friction, rel=1e-3)
    for trace, grip in zip(figure["data"][3:], outcomes[0].grips, strict=False):
        good = grip.lifted and not grip.gross_slip
        assert (trace["marker"]["symbol"] == "x") is not good
        limit = limits[frictions[grip.friction_coefficient]]
        assert trace["line"]["color"] == limit["line"]["color"]
    end = outcomes[0].traces.normal_force_N[-1]
    assert figure["steps"][-1]["shapes[0].xanchor"] == pytest.approx(end, rel=1e-3)
    assert figure["words"].count("regulator") == 3
