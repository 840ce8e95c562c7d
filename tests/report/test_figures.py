"""Figures are there, can be read in light, dark, print and by ear, and survive odd data."""

import base64
import gzip
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.page.contact import force_figure, traction_figure
from fingerdesign.analysis.page.gage import area_figure, response_figure
from fingerdesign.analysis.page.page import report_figures
from fingerdesign.records.arrays import OPEN
from fingerdesign.report.figure import LOOKS, Panel, Triangles, panels
from fingerdesign.report.style import COLOURS, house_style


def drawn(figure):
    """The data and layout of a figure that Plotly draws, as the page unpacks them."""
    data = re.search(r'<script type="text/plain">(.*)</script>', figure.image)[1]
    return gzip.decompress(base64.b64decode(data)).decode()


def flat(figures):
    return [figure for section in figures.values() for figure in section]


def test_every_figure_of_the_paper_is_there(figures):
    keys = {section: [figure.key for figure in inside] for section, inside in figures.items()}
    assert keys == {
        "contact": ["forces", "status", "tractions"],
        "gages": ["areas", "response-0-5", "strains"],
        "grips": ["paths", "rule"],
        "model": ["quality"],  # that of time is drawn last
    }


def test_each_is_sound_svg_with_words_and_colours_of_the_theme(figures):
    for figure in flat(figures):
        assert len(figure.reading) > 40
        assert re.search(r"\d", figure.alternative), "words without a number say little"
        if figure.drawn:
            continue
        root = ElementTree.fromstring(figure.image)
        assert root.tag == "{http://www.w3.org/2000/svg}svg"
        assert root.get("role") == "img"
        assert root.get("aria-label") == figure.alternative
        bare = re.findall(r"(?:fill|stroke): (#[0-9a-f]{6})", figure.image)
        assert set(bare) <= {"#ffffff", "#000000"}, figure.key
        assert f"var(--ink, {COLOURS['ink']})" in figure.image


def test_what_is_missing_is_left_out(plane_strain, failed):
    assert flat(report_figures(failed)) == []
    bare = replace(plane_strain.result, increments=(), timings_s={})
    only_mesh = Analysis(bare, mesh=plane_strain.mesh)
    assert [figure.key for figure in flat(report_figures(only_mesh))] == ["quality"]


def test_never_touching_and_single_increment(plane_strain):
    contact, row = plane_strain.contact, plane_strain.result.increments[0]
    names = ("status", "normal_traction", "tangential_traction", "slip")
    first = {name: getattr(contact, name)[:1] for name in names}
    away = replace(contact, **first | {"status": first["status"] * 0 + OPEN})
    result = replace(plane_strain.result, increments=(replace(row, stick_ratio=None),))
    figures = flat(report_figures(Analysis(result, contact=away)))
    words = {figure.key: figure.alternative for figure in figures}
    assert words["status"].startswith("0 increments have contact")
    assert words["forces"].endswith("The last stick ratio is –.")


def test_noise_is_neither_drawn_nor_named(plane_strain):
    """Without friction and after unloading: no scale of 1e-16, no minus zero."""
    contact, result = plane_strain.contact, plane_strain.result
    status, pressure = contact.status.copy(), contact.normal_traction.copy()
    status[-1], pressure[-1] = OPEN, -1e-17
    shear = 1e-16 * np.sign(contact.tangential_traction + 0.5)
    quiet = replace(contact, status=status, normal_traction=pressure, tangential_traction=shear)
    rows = [replace(row, tangential_force_N=-6e-16) for row in result.increments]
    rows[-1] = replace(rows[-1], normal_force_N=-1e-15, stick_ratio=None)
    changed = replace(result, increments=tuple(rows))
    analysis = replace(plane_strain, result=changed, contact=quiet, slip_studies=(), grip_traces=())
    shown = {figure.key: figure for figure in flat(report_figures(analysis))}
    for key, words in (
        ("forces", "from 3 to 0 N"),
        ("forces", "tangential force from 0 to 0 N"),
        ("tractions", "At increment 7 the pressure reaches"),
        ("tractions", "the shear traction 0 MPa"),
        ("strains", "At increment 7 the largest membrane"),
    ):
        assert words in shown[key].alternative
    for figure in shown.values():
        text = drawn(figure) if figure.drawn else figure.image
        assert "1e" not in re.sub(r"<[^>]*>|--green", "", text).replace("−", "-"), figure.key
        assert not re.search(r"e-1\d|-0\.0+\b|-0 ", figure.alternative), figure.key


def test_study_without_any_response_is_drawn(plane_strain):
    study = plane_strain.slip_studies[0]
    nan = {name: getattr(study, name) + np.nan for name in ("response", "gage_area_mm")}
    silent = replace(study, rank_correlation=None, **nan)
    with house_style():
        assert "<svg" in response_figure(silent, 0.5).image
        assert "– at μ 0.3" in area_figure((silent,)).alternative


def test_what_leaves_the_section_is_drawn(solid):
    aside = {"twist_deg": 0.5, "force_z_N": 0.3, "twist_moment_Nmm": 2.0}
    rows = tuple(replace(row, **aside) for row in solid.result.increments)
    forces = force_figure(replace(solid.result, increments=rows))
    assert "force along z" in drawn(forces)
    assert "moment" not in drawn(force_figure(solid.result))


@pytest.mark.parametrize("along_z", [0.03, 0.0])
def test_tractions_with_a_part_along_z_are_drawn_in_magnitude(solid, along_z):
    aside = np.full_like(solid.contact.tangential_traction, 0.03)
    aside[..., 1] = along_z
    contact = replace(solid.contact, symmetric=False, tangential_traction=aside)
    figure = traction_figure(contact)
    assert ("magnitude of shear traction" in drawn(figure)) == bool(along_z)


@pytest.mark.slow
def test_the_threshold_is_the_design_s_share_of_the_largest_response(plane_strain):
    keys = plane_strain.result.parameters | {"gages.area_share": 0.63}
    changed = replace(plane_strain, result=replace(plane_strain.result, parameters=keys))
    figures = {each.key: each for each in flat(report_figures(changed))}
    assert "which is 0.63 of the finger's largest response" in figures["response-0-5"].reading


def test_panels_stand_in_rows_and_name_each_line_once():
    x = np.array([0.0, 1.0])
    panel = Panel("forces", "mm", "N", [("n", x, 2 * x), ("t", x, 3 * x)])
    still = replace(panel, title="still", lines=[("n", x, 0 * x)], marked=False, looks=[2])
    two = replace(panel, rise=(0.0, 9.0), lines=[("n", x, 0 * x), ("t", x, 0 * x)])
    data, layout, _ = panels([panel, two, still], 2).values()
    assert [each["showlegend"] for each in data] == [True, True, False, False, False]
    assert [each["yaxis"] for each in data] == ["y", "y", "y2", "y2", "y3"]
    assert [each["mode"] for each in data[3:]] == ["lines+markers", "lines"]
    looks = [LOOKS["series"][k]["dash"] for k in (0, 1, 0, 1, 2)]
    assert [each["line"]["dash"] for each in data] == looks
    rises = [layout[f"yaxis{k}"]["range"] for k in ("", 2, 3)]
    assert rises == [None, (0.0, 9.0), (-1.0, 1.0)]  # of zeros no scale of rounding
    assert layout["yaxis3"]["domain"][1] < layout["yaxis2"]["domain"][0]


def test_edges_that_end_at_the_seam_of_two_halves_are_drawn():
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]])
    drawn = Triangles(corners, np.array([[0, 1, 2]])).outline(30.0, mirrored=True)
    assert len(drawn["x"]) == 2 * 3  # of three edges the one that lies in the seam is left out
