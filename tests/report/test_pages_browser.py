"""Pages as people meet them: light, dark, on a phone, on paper, by keyboard; and their glossary."""

import re
from html import unescape

import pytest

from fingerdesign.report.page import explained, glossary, term_pattern, terms_in
from tests.support.accessible import faults
from tests.support.browser import Browser, chromium

browsed = pytest.mark.skipif(chromium() is None, reason="no chromium on this machine")
# Words of headings, columns and captions that any reader knows; all others are terms.
PLAIN_WORDS = """
both centre difference faces geometry incr forces half mean mg page step surface weight
a across all along and any are as at axial be before begins best by came cases change changed
chosen come complete contact content contents degrees design did do does each ended engineering
error estimated everything final finger first follow for force from g gages glossary go good
grips has how in is it its key kind largest last least left length lifted limits main mass
memory microstrain mm model mpa n names no not nothing number objects of off on one open opens
or other out over part peak per point points positions quality read reading record remark report
reported s same saw says scene seconds see seen short size slips steps table than the their this
time times to took tried true under used value values verdict warning warnings was went what
where which why with without words work worst x y z
"""
PLAIN = set(PLAIN_WORDS.split())


@pytest.fixture(scope="module")
def window(solid_report, tmp_path_factory):
    with Browser(solid_report, tmp_path_factory.mktemp("window")) as browser:
        yield browser


@browsed
@pytest.mark.parametrize("look", ["light", "dark", "narrow", "print"])
def test_a_report_bars_nobody(window, solid_report, look):
    window.appear(dark=look == "dark", paper=look == "print")
    window.goto(solid_report, (360, 800) if look == "narrow" else (1100, 900))
    assert faults(window) == []
    assert window.evaluate("document.documentElement.scrollWidth") <= window.evaluate("innerWidth")
    assert window.console == window.requests == []
    window.appear()


@browsed
def test_the_keyboard_reaches_the_content_and_shows_where_it_is(window, solid_report):
    window.goto(solid_report)
    window.key("Tab")
    assert window.evaluate("document.activeElement.className") == "skip"
    window.key("Tab")
    outline = "getComputedStyle(document.activeElement).outlineStyle"
    assert window.evaluate(f"document.activeElement.matches('a') && {outline}") == "solid"


@browsed
def test_the_check_finds_what_it_is_for(window, tmp_path):
    page = tmp_path / "bad.html"
    page.write_text(
        "<title></title><h1>x</h1><h3>y</h3><img src='data:,'><button></button><input id=a>"
        "<p id=a style='color: #bbb; background: #fff'>pale</p><a href='#no'>to</a>"
    )
    window.goto(page)
    rules = {each.partition(":")[0].rstrip("0123456789. ") for each in faults(window)}
    assert rules == {
        *("lang", "title", "duplicate id", "name", "heading order", "contrast", "leads nowhere")
    }


def test_a_page_links_the_first_use_of_each_term_to_its_entry():
    page = explained(
        '<main id="main"><h2>Gage area</h2><p title="stick ratio">The stick ratio, gage&#39;s '
        "<code>stick ratio</code>; stick ratios.</p></main>"
    )
    assert page.count('href="#term-stick_ratio"') == 1
    assert '<p title="stick ratio">The <a class="term" href="#term-stick_ratio">' in page
    links = set(re.findall(r'href="#([^"]+)"', page))
    assert links <= set(re.findall(r'id="([^"]+)"', page))
    assert 'id="term-gage_area"' in page  # a heading holds no link, its term has an entry
    assert explained('<main id="main"><p>Nothing.</p></main>') == (
        '<main id="main"><p>Nothing.</p></main>'
    )


def test_every_entry_has_a_meaning_and_names_of_its_own():
    entries = {entry.key: entry for entry in glossary().values()}.values()
    names = [name.lower() for entry in entries for name in entry.names]
    assert len(names) == len(set(names))
    assert all(len(each.text) > 20 for each in glossary().values())


def unexplained(page):
    """Words of headings, columns, captions and drawings that are neither plain nor in an entry."""
    inside = (
        page.partition("<main")[2].partition("</main>")[0].partition('<dl class="glossary">')[0]
    )
    labels = re.findall(r"<(?:th|caption|h2|h3|text)\b[^>]*>([^<]*)<", inside)
    left = (
        term_pattern().sub(" ", unescape(re.sub(r"\w+(\.\w+)+", " ", label))) for label in labels
    )
    words = {word.lower() for each in left for word in re.findall(r"[^\W\d_]{2,}", each)}
    return sorted(words - PLAIN)


def test_every_term_of_a_report_has_an_entry(solid_report):
    page = solid_report.read_text(encoding="utf-8")
    assert unexplained(page) == []
    assert len(page) < 6e6
    used = terms_in(page.partition("<main")[2].partition("</main>")[0])
    assert {"stick_ratio", "gage_area", "safety_margin", "compensated"} <= set(used)
    assert all(f'id="term-{key}"' in page for key in used)


def test_a_new_term_without_an_entry_is_found():
    assert unexplained('<main id="main"><table><th>stick ratio</th></table></main>') == []
    assert unexplained('<main id="main"><table><th>wobble (mm)</th></table></main>') == ["wobble"]
