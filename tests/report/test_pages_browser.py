"""Pages as people meet them: light, dark, on a phone, on paper, by keyboard; and their glossary."""

import re

import pytest

from fingerdesign.analysis.page.finger import partly_slipping
from fingerdesign.report.page import add_definitions
from tests.support.accessible import faults
from tests.support.browser import chromium

browsed = pytest.mark.skipif(chromium() is None, reason="no chromium on this machine")

pytestmark = pytest.mark.slow


@browsed
@pytest.mark.parametrize("look", ["dark", "narrow", "print"])
def test_a_report_bars_nobody(window, solid_report, look):
    """Nor when it is light, below."""
    window.appear(dark=look == "dark", paper=look == "print")
    window.goto(solid_report, (360, 800) if look == "narrow" else (1100, 900))
    assert faults(window) == []
    assert window.evaluate("document.documentElement.scrollWidth") <= window.evaluate("innerWidth")
    assert window.console == window.requests == []
    window.appear()


def most_pressure(window):
    """Of the contact's colours that are shown, MPa."""
    drawn = "document.getElementById('plot-space').data"
    return window.evaluate(
        f"Math.max(...{drawn}.find((t) => t.visible && t.name.startsWith('pressure')).intensity)"
    )


@browsed
@pytest.mark.parametrize("look", ["light", "dark and narrow"])
def test_the_finger_follows_its_slider_and_menus_by_keys(window, solid_report, solid, look):
    window.appear(dark="dark" in look)
    window.goto(solid_report, (360, 800) if "narrow" in look else (1100, 900))
    window.wait("document.body.dataset.drawn", 60)
    pressures = solid.contact.normal_traction.max(axis=1)
    first = partly_slipping(solid.result)
    drawn = "document.getElementById('plot-space').data"
    shown = f"{drawn}.find((t) => t.name === 'stick and slip').visible"
    assert window.evaluate(shown)
    window.evaluate("document.querySelector('#figure-space select').focus()")
    window.key("p")
    window.wait(f"!{shown}")
    assert most_pressure(window) == pytest.approx(pressures[first], rel=0.01)
    window.evaluate("document.querySelector('#figure-space input').focus()")
    window.key("Home")
    window.wait("document.querySelector('#plot-space .gtitle').textContent.includes('1 of 8')")
    assert most_pressure(window) == pytest.approx(pressures[0], rel=0.01)
    window.key("ArrowRight")
    assert window.evaluate("document.querySelector('#figure-space input').ariaValueText") == "2"
    window.evaluate("document.querySelector('#figure-space select').focus()")
    window.key("s", 3)  # shear traction, slip, stick and slip
    window.wait(shown)
    assert window.evaluate("document.documentElement.scrollWidth") <= window.evaluate("innerWidth")
    assert faults(window) == []
    assert window.console == window.requests == []
    window.appear()


FIRST_SCREEN = """(() => {
  const place = (what) => document.querySelector(what)?.getBoundingClientRect();
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const picture = document.querySelector(".plot");
  let words = 0;
  while (walk.nextNode()) {
    const text = walk.currentNode, e = text.parentElement;
    if (picture.compareDocumentPosition(text) & Node.DOCUMENT_POSITION_FOLLOWING) break;
    const hidden = e.closest("script, style, noscript, .skip, option") || picture.contains(text);
    if (!hidden && e.checkVisibility()) words += text.data.split(/\\s+/).filter(Boolean).length;
  }
  const ends = [".plot", ".tiles", ".fixes"].map((each) => place(each)?.bottom ?? 0);
  return { words, ends, tiles: document.querySelectorAll(".tiles li").length };
})()"""


@browsed
def test_the_first_screen_holds_picture_verdicts_and_fixes_and_is_printed(
    window, solid_report, tmp_path
):
    """A definition opens where its term is used. The drawing, 2 of its pixels to one of the page,
    is in the file that is printed."""
    window.goto(solid_report, (1280, 800))
    window.wait("document.body.dataset.drawn", 60)
    found = window.evaluate(FIRST_SCREEN)
    assert found["words"] <= 60
    assert max(found["ends"]) <= 800
    assert found["tiles"] >= 3
    window.click(".tiles button.term")
    assert window.evaluate("document.querySelectorAll(':popover-open').length") == 1
    assert faults(window) == []
    printed = window.pdf(tmp_path / "page.pdf").read_bytes()
    sizes = re.findall(rb"/Width (\d+)\s/Height (\d+)\s.*?/Length (\d+)", printed, re.DOTALL)
    assert max(int(length) for *_, length in sizes) > 20_000


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


def test_the_first_use_of_each_term_opens_its_definition():
    page = add_definitions(
        '<main id="main"><h2>Gage area</h2><p title="stick ratio">The stick ratio, gage&#39;s '
        "<code>stick ratio</code>; stick ratios.</p></main>"
    )
    assert page.count('popovertarget="term-stick_ratio"') == 1
    assert '<p title="stick ratio">The <button class="term" popovertarget="term-stick' in page
    opened = re.findall(r'popovertarget="([^"]+)"', page)
    assert opened == [f"term-{key}" for key in ("gage_area", "stick_ratio", "gage")]
    assert set(opened) <= set(re.findall(r'id="([^"]+)" popover', page))
    assert add_definitions('<main id="main"><p>Nothing.</p></main>') == (
        '<main id="main"><p>Nothing.</p></main>'
    )


def test_every_term_of_a_report_has_an_entry(solid_report):
    page = solid_report.read_text(encoding="utf-8")
    assert len(page) < 6e6
    for key in ("stick_ratio", "gage_area", "safety_margin", "compensated"):
        assert page.count(f'popovertarget="term-{key}"') == page.count(f'id="term-{key}"') == 1
