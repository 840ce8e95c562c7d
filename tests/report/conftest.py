"""Figures and a whole report of the closed forms, made once: drawing takes seconds."""

import pytest

from fingerdesign.analysis.folder import write_page
from fingerdesign.analysis.page import page
from fingerdesign.analysis.page.page import report_figures


@pytest.fixture(scope="session")
def figures(plane_strain):
    return report_figures(plane_strain)


@pytest.fixture(scope="session")
def solid_figures(solid):
    return report_figures(solid)


@pytest.fixture
def drawn_before(monkeypatch, figures):
    """Pages hold the figures that have been drawn already."""
    monkeypatch.setattr(page, "report_figures", lambda analysis: figures)


@pytest.fixture(scope="session")
def solid_report(solid, solid_figures, tmp_path_factory):
    """The path of a report with pictures."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "report_figures", lambda analysis: solid_figures)
        return write_page(solid, tmp_path_factory.mktemp("report"))
