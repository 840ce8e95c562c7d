"""report.html: whole, offline, safe, and plain about what failed."""

import itertools
import json
import re
import webbrowser
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.page import page as html_module
from fingerdesign.analysis.page.page import report_html
from fingerdesign.errors import PictureError
from fingerdesign.report.page import COMMON, digest
from tests.support.result_folders import write_result_folder

VOID = {"meta", "link", "img", "br", "hr", "input"}


class Page(HTMLParser):
    """Collects what the tests ask for; fails on tags that do not close."""

    def __init__(self, text):
        super().__init__()
        self.found: list[tuple[str, dict[str, str]]] = []
        self.open: list[str] = []
        self.words = ""
        self.feed(text)
        assert not self.open
        self.tags = [tag for tag, _ in self.found]
        self.ids = [values["id"] for _, values in self.found if "id" in values]
        self.drawings = [v for tag, v in self.found if tag == "svg" and v.get("role") == "img"]
        names = ("href", "src", "xlink:href")
        self.links = [v for _, values in self.found for k, v in values.items() if k in names]

    def handle_startendtag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))
        self.open += [] if tag in VOID else [tag]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words += data.replace("\xa0", " ")


@pytest.fixture
def text(plane_strain, drawn_before):
    return report_html(plane_strain)


@pytest.fixture
def page(text):
    return Page(text)


def test_nothing_is_fetched_and_only_scripts_of_known_digests_run(page, text):
    scripts = re.findall(r'<script type="module">(.*?)</script>', text, re.DOTALL)
    assert scripts == [(COMMON / name).read_text("utf-8") for name in ("chart.js", "figures.js")]
    (allowed,) = re.findall(r"script-src ([^;]+);", text.replace("&#39;", "'"))
    assert set(map(digest, scripts)) < set(allowed.split())
    assert "unsafe" not in allowed
    assert all(link.startswith(("#", "data:")) for link in page.links)
    assert not re.search(r"url\((?!#)|@import", text)
    text = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    assert not re.search(r"\son\w+=", re.sub(r'"[^"]*"', '""', text))
    assert "default-src 'none'" in text


def test_ids_are_unique_links_lead_somewhere_and_headings_step_down(page, text):
    assert len(page.ids) == len(set(page.ids))
    links = {link[1:] for link in page.links if link.startswith("#")}
    assert links | set(re.findall(r"url\(#([^)]+)\)", text)) <= set(page.ids)
    levels = [int(tag[1]) for tag in page.tags if re.fullmatch(r"h[1-6]", tag)]
    assert (levels[0], levels.count(1)) == (1, 1)
    assert all(after <= before + 1 for before, after in itertools.pairwise(levels))


def test_verdict_assumptions_figures_and_record_are_there(page):
    for words in (
        *("3 of 3 μ", "lifts 200 g", "plates.cover_mm = 2.0 is thinner"),
        *("body.arc_radius_mm", "12.4°", "3f" * 32, "numpy 2.4.6", "plant 0"),
    ):
        assert words in page.words, words
    assert len(page.drawings) == 6
    assert page.tags.count("table") == 7


def test_words_of_the_design_cannot_become_markup(plane_strain):
    evil = '<script>alert("x")</script><img src=//e.example onerror=alert(1)>'
    result = plane_strain.result
    changed = replace(
        result,
        design=evil,
        scene=evil,
        warnings=(evil,),
        assumed=(evil,),
        versions={evil: evil},
        parameters={evil: evil},
        model=replace(result.model, reasons=(evil,), element=evil),
        grips=(replace(result.grips[0], controller=evil),),
        timings_s={evil: 1.0},
    )
    trace = replace(plane_strain.grip_traces[0], controller=evil)
    page = Page(report_html(Analysis(changed, grip_traces=(trace,))))
    assert "img" not in page.tags
    kinds = [values.get("type") for tag, values in page.found if tag == "script"]
    assert kinds == [*["text/plain"] * 3, "module", "module"]  # charts, plotly; our own
    assert evil in page.words


def test_failed_analysis_says_what_failed(failed):
    page = Page(report_html(failed))
    assert "No mesh passed the acceptance gate after 3 attempts" in page.words
    assert not page.drawings


@pytest.mark.usefixtures("drawn_before")
def test_a_picture_that_fails_costs_only_itself(plane_strain, monkeypatch):
    def broken(*_):
        raise PictureError("the displacement field does not belong to the mesh")

    monkeypatch.setattr(html_module, "finger_report", broken)
    page = Page(report_html(plane_strain))
    assert "could not be drawn: the displacement field does not belong to the mesh." in page.words
    assert len(page.drawings) == 6


@pytest.fixture
def out(tmp_path, plane_strain, failed):
    for analysis in (plane_strain, failed):
        result = analysis.result
        write_result_folder(tmp_path / result.design, result, texts={"report.html": "<p>"})
    return tmp_path


def test_the_browser_opens_only_when_requested(out, monkeypatch, terminal):
    opened = []
    monkeypatch.setattr("click.launch", opened.append)
    webbrowser.register("none", None, webbrowser.GenericBrowser("none"))
    terminal("view", out / "narrow", "--quiet")
    assert opened == []
    terminal("view", out / "narrow", "--quiet", "--open")
    assert opened == [(out / "narrow" / "report.html").as_uri()]


def test_no_result_is_wrong_input_in_one_line(tmp_path, terminal):
    assert terminal("view", tmp_path / "nowhere", code=2).err.startswith("DESIGN|DIR = ")
    (tmp_path / "result.json").write_text("{", encoding="utf-8")
    assert "result.json: JSON = " in terminal("view", tmp_path, code=2).err


def test_results_of_a_folder_are_shown_with_their_reports(out, terminal):
    shown = terminal("view", out / "maeno2000").out
    assert f"report: {out / 'maeno2000' / 'report.html'}" in shown
    assert "✓ slip sensing" in shown
    assert "0.394" in terminal("view", out / "maeno2000", "--details").out  # a stick ratio
    every = json.loads(terminal("view", out, "--json").out)
    assert [item["design"] for item in every] == ["maeno2000", "narrow"]
    assert every[1]["status"] == "failed"
    assert "No mesh passed" in every[1]["failure"]
