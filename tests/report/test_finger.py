"""The finger in space: whole surfaces, colours that follow the path; gages where they lie."""

import dataclasses
import json

import numpy as np
import pytest

from fingerdesign.analysis.analysis import Analysis, parameters
from fingerdesign.analysis.case import fundamental_scene
from fingerdesign.analysis.folder import centroid_strain, write_fields
from fingerdesign.analysis.page.finger import MOVED, VIEWS, finger_figure, finger_report
from fingerdesign.analysis.page.gage import gages_chart, plate_rows
from fingerdesign.analysis.page.surfaces import gage_quads, patch_of, surface_of
from fingerdesign.checks.load import load_design
from fingerdesign.design.schema import Gages
from fingerdesign.errors import PictureError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.gaps import solids_of
from fingerdesign.mesh.cells import PRISM
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.pictures import grid_of
from fingerdesign.records.arrays import OPEN, STICK, FieldHistory
from fingerdesign.report.figure import in_notebook, triangles_of

BOTH = pytest.mark.parametrize("which", ["plane_strain", "solid"])


def volume(points, triangles):
    """Inside a closed surface whose triangles are anticlockwise from outside."""
    return float(np.linalg.det(points[triangles]).sum() / 6.0)


def closed(triangles):
    """Every edge is walked once each way, so no triangle is missing or turned."""
    ends = np.concatenate([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    there, back = ({tuple(each) for each in way.tolist()} for way in (ends, ends[:, ::-1]))
    return there == back and len(there) == len(ends)


def cells_volume(mesh):
    return float(np.abs(cell_volumes(mesh.points, mesh.corners)).sum())


def test_surfaces_of_a_section_of_a_half_and_of_a_whole_finger_are_closed(plane_strain, solid):
    whole = whole_mesh(solid.mesh)
    for mesh, times in ((plane_strain.mesh, 10.0), (solid.mesh, 2.0), (whole, 1.0)):
        found = surface_of(mesh, 10.0)
        exact = times * cells_volume(mesh)
        assert volume(found.points, found.whole) == pytest.approx(exact, rel=1e-9)
        assert volume(found.points, found.half) == pytest.approx(0.5 * exact, rel=1e-6)
        assert found.points[found.half][..., 2].max() == pytest.approx(0.0, abs=1e-9)
        assert found.points[:, 2].min() == pytest.approx(-5.0)
        assert closed(found.half)


def whole_mesh(half):
    """The same finger as a mesh without a mirror."""
    mirrored = half.points * [1.0, 1.0, -1.0]
    cells = half.cells.copy() + len(half.points)
    order = [3, 4, 5, 0, 1, 2, 9, 10, 11, 6, 7, 8, *range(12, 18)]  # positively oriented again
    points = np.concatenate([half.points, mirrored])
    found = np.concatenate([half.cells, cells[:, order]])
    plane = np.flatnonzero(np.abs(half.points[:, 2]) < 1e-9)
    number = np.arange(len(points))
    number[plane + len(half.points)] = plane
    regions = np.tile(half.regions, 2)
    facets: dict = {}
    return dataclasses.replace(
        half, points=points, cells=number[found], regions=regions, facets=facets, symmetric=False
    )


@BOTH
def test_the_patch_is_what_touched_and_each_point_keeps_its_own_piece(which, request):
    contact = request.getfixturevalue(which).contact
    patch = patch_of(contact, 10.0)
    touched = (contact.status != OPEN).any(axis=0)
    assert set(np.flatnonzero(touched)) <= set(patch.owner.tolist())
    behind = patch.points[patch.triangles[: patch.half]]
    assert behind[..., 2].max() == pytest.approx(0.0, abs=1e-12)
    points, triangles, owner = patch.apart()
    sizes = [area(each, of) for each, of in ((patch.points, patch.triangles), (points, triangles))]
    assert sizes[0].sum() == pytest.approx(sizes[1].sum())
    first = points[triangles[:, 0]]
    assert np.allclose(first[:, 0], contact.points[owner][:, 0])  # its corner is the contact point


def area(points, triangles):
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


@BOTH
def test_the_slider_gives_each_increment_its_colours(which, request):
    analysis = request.getfixturevalue(which)
    figure = finger_figure(analysis, 2)
    data = {each["name"]: each for each in figure["data"]}
    (slider,) = figure["layout"]["sliders"]
    rows = analysis.result.increments
    assert (len(slider["steps"]), slider["active"]) == (len(rows), 2)
    shades, words, traces = slider["steps"][5]["args"]
    names = [figure["data"][k]["name"] for k in traces]
    for name, values in zip(names, shades["intensity"], strict=True):
        per_cell = data[name].get("intensitymode") == "cell"
        assert len(values) == len(data[name]["i" if per_cell else "x"])
        assert data[name]["cmin"] <= min(values) <= max(values) <= data[name]["cmax"] * 1.01
    assert max(shades["intensity"][names.index("pressure (MPa)")]) == pytest.approx(
        analysis.contact.normal_traction[5].max(), rel=0.01
    )
    assert STICK in shades["intensity"][names.index("stick and slip")]
    seen = dict(zip(names, shades["opacity"], strict=False))
    assert seen["stick and slip"] == data["stick and slip"]["opacity"] < 0.6  # not over the plates
    assert seen["plates"] == data["plates"]["opacity"] == 1.0
    assert f"F<sub>n</sub> {rows[5].normal_force_N:.3g} N" in words["title.text"]
    assert json.loads(json.dumps(figure, allow_nan=False)) == figure


@BOTH
def test_menus_choose_colour_body_and_view(which, request):
    figure = finger_figure(request.getfixturevalue(which))
    menus = {each["name"]: each["buttons"] for each in figure["layout"]["updatemenus"]}
    assert [each["label"] for each in menus["Seen from"]] == list(VIEWS)
    assert menus["Contact"][-1]["label"] == MOVED
    for button in menus["Contact"]:
        change, traces = button["args"]
        names = [figure["data"][k]["name"] for k in traces]
        shown = {n for n, seen in zip(names, change["visible"], strict=True) if seen}
        assert shown == {button["label"]} | (set() if button["label"] == MOVED else {"body"})
    whole, _, cut = (each["args"][0] for each in menus["Body"])
    assert all(len(half) < len(full) for half, full in zip(cut["i"], whole["i"], strict=True))
    texts = [each["text"] for each in figure["layout"]["scene"]["annotations"]]
    assert texts == ["width 20 mm", "depth 10 mm", "height 12.68 mm", "5 mm", "radius 20 mm"]


@pytest.mark.slow
def test_a_notebook_gets_the_same_figure_in_print_colours(solid):
    figure = finger_figure(solid)
    drawn = in_notebook(figure)
    assert [each.name for each in drawn.data] == [each["name"] for each in figure["data"]]
    assert '"--' not in drawn.to_json()


def test_what_does_not_move_is_not_coloured(plane_strain):
    mesh = plane_strain.mesh
    bare = dataclasses.replace(mesh, regions=0 * mesh.regions)
    fields = FieldHistory((3,), 1e-13 * plane_strain.fields.displacement[-1:])
    still = dataclasses.replace(plane_strain, fields=fields, mesh=bare, plates=())
    assert MOVED not in {each["name"] for each in finger_figure(still)["data"]}
    report = finger_report(still)
    assert "stored for increment none" in report.reading
    assert "with no plates" in report.alternative


def test_displacement_is_drawn_of_the_increment_that_the_slider_shows(plane_strain):
    fields = FieldHistory((2, 7), plane_strain.fields.displacement[[2, 7]])
    figure = finger_figure(dataclasses.replace(plane_strain, fields=fields))
    moved = [k for k, each in enumerate(figure["data"]) if each["name"] == MOVED]
    assert len(moved) == 2
    for k, step in enumerate(figure["layout"]["sliders"][0]["steps"]):
        change, _, traces = step["args"]
        shown = [change["opacity"][traces.index(each)] for each in moved]
        assert shown == [float(k == 2), float(k == 7)]


def test_a_still_section_replaces_the_finger_where_nothing_draws(plane_strain):
    keys = parameters(load_design("maeno2000"), fundamental_scene())
    result = dataclasses.replace(plane_strain.result, parameters=keys)
    report = finger_report(dataclasses.replace(plane_strain, result=result))
    assert '<div class="still"><svg class="section"' in report.image


def test_what_cannot_be_drawn_is_refused(plane_strain, solid, failed):
    mixed = Analysis(plane_strain.result, mesh=plane_strain.mesh, fields=solid.fields)
    for analysis, words in ((failed, "no mesh"), (mixed, "does not belong")):
        with pytest.raises(PictureError, match=words):
            finger_figure(analysis)


GAGES = Gages(width_mm=0.6, z_mm=0.2)
FLAT = PlateFrame(0, 0.5, 3.0, 30.0, 2.0, 0.1, -0.5, 2.5)
ALONG_Z = PlateFrame(1, 0.7, 3.0, 40.0, 2.0, 0.1, -1.0, 0.6, along="z")
BENT = PlateFrame(2, 0.5, 3.0, 20.0, 2.0, 0.1, -0.5, 2.5, bend_radius=3.0)


@pytest.mark.parametrize(("face", "sides"), [("upper", {1}), ("lower", {-1}), ("both", {-1, 1})])
@pytest.mark.parametrize("frame", [FLAT, ALONG_Z, BENT])
def test_gages_are_drawn_on_the_faces_that_carry_them(frame, face, sides):
    quads = gage_quads((frame,), GAGES.model_copy(update={"face": face})).reshape(-1, 3)
    s, v = frame.local(quads).T
    across = frame.across(quads) - frame.middle
    assert np.allclose(np.abs(v), 0.07)
    assert set(np.sign(v)) == sides
    assert np.abs(s).max() == pytest.approx(0.5)
    assert (across.min(), across.max()) == pytest.approx((-0.1, 0.5))


@pytest.mark.parametrize("frame", [FLAT, ALONG_Z, BENT])
def test_plates_are_drawn_closed_and_outward(frame):
    drawn = triangles_of(solids_of((frame,)))
    exact = frame.length * frame.thickness * frame.span
    found = volume(drawn.vertices, drawn.triangles)
    assert found == pytest.approx(exact, rel=2e-3 if frame.bend_radius else 1e-9)


def test_rows_are_distinguished():
    row = [dataclasses.replace(FLAT, index=k, place=float(k)) for k in range(3)]
    deep = [dataclasses.replace(FLAT, index=3 + k, place=float(k), y=1.0) for k in range(2)]
    across = [dataclasses.replace(ALONG_Z, index=5 + k, place=3.0 + k) for k in range(2)]
    assert plate_rows([*row, *deep, *across]) == ((0, 1, 2), (3, 4), (5, 6))
    assert plate_rows(row[::-1], placed=True) == ((0, 1, 2),)
    assert plate_rows([]) == ()


def test_a_row_along_z_is_drawn_over_z(plane_strain):
    """Two rows, two pairs of panels, each over the direction along which its plates differ."""
    plates = list(plane_strain.plates)
    for k in range(10, 15):
        plates[k] = dataclasses.replace(ALONG_Z, index=k, place=float(k - 12))
    drawn = gages_chart(plane_strain.result, plates)["layout"]
    plain = gages_chart(plane_strain.result, plane_strain.plates)["layout"]
    labels = [drawn[f"xaxis{k}"]["title"]["text"] for k in ("", "2", "3", "4")]
    assert labels == [*["plate centre x (mm)"] * 2, *["plate centre z (mm)"] * 2]
    assert plain["xaxis2"]["title"]["text"] == "plate centre x (mm)"
    assert "xaxis3" not in plain
    assert "Row 2." in drawn["annotations"][2]["text"]


def bent(mesh):
    """The mesh with its mid-edge nodes moved off the edges' middles."""
    corners = np.unique(mesh.corners)
    points = mesh.points.copy()
    free = np.ones(len(points), dtype=bool)
    free[corners] = False
    points[free] += np.random.default_rng(1).normal(scale=0.002, size=(free.sum(), points.shape[1]))
    return dataclasses.replace(mesh, points=points)


def known_strain(gradient):
    """xx, yy, zz, xy, xz, yz (engineering shear) of a constant 3 x 3 gradient, microstrain."""
    g = 1e6 * gradient
    shear = [g[0, 1] + g[1, 0], g[0, 2] + g[2, 0], g[1, 2] + g[2, 1]]
    return np.array([g[0, 0], g[1, 1], g[2, 2], *shear])


@pytest.mark.parametrize("which", ["plane_strain", "solid"])
def test_linear_displacement_gives_its_strain_on_curved_cells(which, request):
    mesh = bent(request.getfixturevalue(which).mesh)
    gradient = np.zeros((3, 3))
    d = mesh.dimension
    gradient[:d, :d] = np.random.default_rng(0).normal(scale=1e-3, size=(d, d))
    strain = centroid_strain(mesh, mesh.points @ gradient[:d, :d].T)
    assert np.allclose(strain, known_strain(gradient), rtol=0, atol=1e-6)


def test_quadratic_displacement_is_exact_at_the_centroid(plane_strain):
    mesh = plane_strain.mesh
    x, y = mesh.points.T
    displacement = np.stack([1e-4 * x * y, 1e-4 * x**2], axis=1)
    cx, cy = mesh.points[mesh.corners].mean(axis=1).T
    strain = centroid_strain(mesh, displacement)
    assert np.allclose(strain[:, 0], 100 * cy, atol=1e-6)
    assert np.allclose(strain[:, 3], 300 * cx, atol=1e-6)
    assert not strain[:, [2, 4, 5]].any()


@pytest.mark.parametrize("which", ["plane_strain", "solid"])
def test_files_open_in_pyvista_with_all_they_hold(which, request, tmp_path):
    import pyvista

    analysis = request.getfixturevalue(which)
    some = FieldHistory((0, 7), analysis.fields.displacement[[0, 7]] + 0.01)
    paths = write_fields(tmp_path, analysis.mesh, some)
    assert [path.name for path in paths] == ["fields_01.vtu", "fields_08.vtu"]
    many = write_fields(tmp_path, analysis.mesh, dataclasses.replace(some, increments=(7, 99)))
    assert [path.name for path in many] == ["fields_008.vtu", "fields_100.vtu"]
    grid = pyvista.read(paths[1])
    mesh = analysis.mesh
    triangle, prism = 22, 32  # VTK's quadratic ones
    assert set(grid.celltypes) == {triangle if mesh.dimension == 2 else prism}
    assert np.array_equal(grid.cell_data["region"], mesh.regions)
    moved = grid.point_data["displacement_mm"]
    assert moved.shape == (len(mesh.points), 3)
    assert np.allclose(moved[:, : mesh.dimension], some.displacement[1], atol=1e-6)
    strain = centroid_strain(mesh, some.displacement[1])
    for column, part in enumerate(("xx", "yy", "zz", "xy", "xz", "yz")):
        values = grid.cell_data[f"strain_{part}_microstrain"]
        assert np.allclose(values, strain[:, column], rtol=1e-5, atol=1e-3)
    # Straight-edged here, so VTK's own idea of each mid-edge node must be where ours is. (Of a
    # prism of 18 nodes VTK gives a sixth of the volume: there its corners are measured.)
    shown = grid if mesh.dimension == 2 else grid_of(mesh.points, mesh.corners)
    volumes = shown.compute_cell_sizes(length=False, area=True, volume=True)
    size = volumes["Area" if mesh.dimension == 2 else "Volume"]
    exact = cell_volumes(mesh.points, mesh.corners)  # VTK turns linear prisms the other way round
    assert np.allclose(np.abs(size), exact, rtol=1e-6, atol=1e-12)
    if mesh.dimension == 3:
        places = np.reshape(grid.GetCell(0).GetParametricCoords()[:54], (18, 3))
        ends = [*PRISM.edges, *PRISM.squares]
        between = np.array([places[list(each)].mean(axis=0) for each in ends])
        assert np.allclose(places[6:], between)


def test_fields_of_another_mesh_are_refused(plane_strain, solid, tmp_path):
    with pytest.raises(ValueError, match="not of the mesh"):
        write_fields(tmp_path, plane_strain.mesh, solid.fields)
