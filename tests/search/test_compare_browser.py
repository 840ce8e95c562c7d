"""The comparison page in a real Chromium: clicks, keys, sorting, filters, downloads, silence.

The views of two designs: drawn, turned, followed, chosen; names stay text.
"""

import csv
import io
import json
import re
from dataclasses import replace

import pytest

from fingerdesign.records.outcome import Traces
from fingerdesign.search.compare.page import compare_html
from fingerdesign.search.compare.read import facts_of
from fingerdesign.search.compare.recommend import Bound, Objective
from tests.support.accessible import faults
from tests.support.any_outcomes import HOSTILE, any_outcomes
from tests.support.browser import chromium

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        chromium() is None, reason="no chromium: the page is not opened in a browser"
    ),
]
WANTED = (
    Objective("stick_error", "min"),
    Objective("cost", "min"),
    Objective("safety_margin", "max"),
)
# Many, of which twelve have anything to draw.
FLAT = any_outcomes(300, seed=1, failed=0.0)
FLAT = (*FLAT[:12], *(replace(each, traces=Traces(), grips=()) for each in FLAT[12:]))
BOUNDS = (Bound("peak_ratio", at_most=2.0),)
MADE = any_outcomes(60, hostile=True)
GOOD = [number for number, made in enumerate(MADE) if made.status == "ok"]
SHOWN = "[...document.querySelectorAll('#table-designs tbody tr:not([hidden])')]"
# The designs that the chart of two measures draws as points.
POINTS = (
    "document.getElementById('pareto').data.filter((t) => !['line', 'ring'].includes(t.name))"
    ".flatMap((t) => t.customdata)"
)
NUMBERS = f"{SHOWN}.map((row) => Number(row.dataset.i))"

EYE = "Object.values(document.getElementById('shape-{}').layout.scene.camera.eye)"
DRAWN = "document.getElementById('forces-1').data"
LINES = "document.getElementById('parallel-chart').data"


@pytest.fixture
def page_of(window, tmp_path):
    """Opens the page of outcomes; it is silent in the end, and asks no network."""

    def opened(outcomes, wanted=WANTED[:2], bounds=(), change=str, page=tmp_path / "page.html"):
        if window.page != page:
            facts = facts_of("a study", outcomes, wanted, bounds)
            page.write_text(change(compare_html(outcomes, facts)), encoding="utf-8")
            window.goto(page)
        return window

    yield opened
    assert window.console == window.requests == []


@pytest.fixture
def opened(window, page_of):
    return page_of(MADE, WANTED, BOUNDS, page=window.work / "many.html")


@pytest.fixture
def unchosen(window, page_of):
    """A page in which no design is chosen yet."""
    return page_of(FLAT, page=window.work / "views.html")


@pytest.fixture
def views(unchosen):
    """Of the first two designs."""
    choose(unchosen, 0, 1)
    seen(unchosen, "views", DRAWN)
    return unchosen


def seen(browser, place, ready):
    """Bring a place into sight and wait until ``ready`` is true."""
    browser.show(place)
    browser.wait(ready)


def choose(browser, a, b):
    """Choose two designs, and give the page the time to draw them; chosen ones stay as they are."""
    if browser.evaluate("FD.selected") == [a, b]:
        return
    browser.evaluate(f"FD.select({a}, {'null' if b is None else b})")
    browser.evaluate("new Promise((f) => setTimeout(f, 150))")


def data(browser, place):
    return browser.evaluate(f"document.getElementById('{place}').data")


def text(browser, place):
    return browser.evaluate(f"document.getElementById('{place}').textContent")


@pytest.fixture
def browser(opened):
    opened.evaluate("FD.select(null, null)")
    opened.click("#clear-filter")
    opened.show("pareto")
    opened.wait("document.getElementById('pareto').data")
    return opened


def point(browser, number):
    """Where a design's point of the chart is in the window, scrolled into view."""
    browser.show("pareto")
    return browser.evaluate(
        "(() => { const p = document.getElementById('pareto');"
        f"const t = p.data.find((each) => each.customdata.includes({number}));"
        f"const k = t.customdata.indexOf({number});"
        "const { xaxis, yaxis } = p._fullLayout; const r = p.getBoundingClientRect();"
        "return [r.x + xaxis._offset + xaxis.l2p(t.x[k]),"
        "r.y + yaxis._offset + yaxis.l2p(t.y[k])]; })()"
    )


def column(browser, title):
    """The number of a column of the table, by its heading."""
    heads = "[...document.querySelectorAll('#table-designs thead tr:first-child th')]"
    return browser.evaluate(f"{heads}.findIndex((e) => e.textContent.startsWith({title!r})) + 1")


def head(browser, title):
    return f"#table-designs thead th:nth-child({column(browser, title)})"


def write_into(browser, title, text):
    browser.click(f"#table-designs .filters td:nth-child({column(browser, title)}) input")
    browser.write(text)


def cost(number):
    return MADE[number].metrics["cost"]


@pytest.mark.parametrize("few", [(), any_outcomes(3, failed=1.0), MADE[20:21], MADE[20:22]])
def test_a_page_of_few_or_none_is_silent(page_of, few):
    browser = page_of(few, WANTED)
    for place in ("views", "parallel-chart"):
        browser.show(place)
        browser.evaluate("new Promise((f) => setTimeout(f, 200))")
    assert browser.evaluate("FD.shown.length") == sum(o.status == "ok" for o in few)


def test_sorts_by_mouse_and_keys_both_ways_most_first_and_no_value_last(browser):
    button = f"{head(browser, 'cost')} button"
    browser.click(button)
    up = [cost(number) for number in browser.evaluate(NUMBERS)]
    assert up == sorted(up)
    sort = f"document.querySelector({head(browser, 'cost')!r}).getAttribute('aria-sort')"
    assert browser.evaluate(sort) == "ascending"
    browser.key("Enter")
    assert browser.evaluate(sort) == "descending"
    assert [cost(n) for n in browser.evaluate(NUMBERS)] == up[::-1]
    browser.click(f"{head(browser, 'safety')} button")
    margins = [MADE[number].metrics["safety_margin"] for number in browser.evaluate(NUMBERS)]
    known = sorted((each for each in margins if each is not None), reverse=True)
    assert margins[: len(known)] == known


def test_filters_by_bounds_and_words_and_by_the_front(browser):
    write_into(browser, "cost", "10..15")
    write_into(browser, "design", "any_")
    requested = {i for i in GOOD if 10 <= cost(i) <= 15 and "any_" in MADE[i].name}
    assert set(browser.evaluate(NUMBERS)) == requested
    assert 0 < len(requested) < 40
    assert text(browser, "shown-count") == f"{len(requested)} of {len(GOOD)} shown"
    browser.wait(f"{POINTS}.length === {len(requested)}")
    browser.click("#clear-filter")
    write_into(browser, "cost", "cheap")  # makes no sense
    assert "cost" in text(browser, "fault")
    assert len(browser.evaluate(NUMBERS)) == len(GOOD)
    browser.click("#clear-filter")
    browser.click("#only-front")
    front = browser.evaluate("FD.data.designs.flatMap((d, i) => (d.front ? [i] : []))")
    assert sorted(browser.evaluate(NUMBERS)) == front


def test_choosing_in_the_chart_by_mouse_and_keys(browser):
    browser.evaluate("document.getElementById('pareto').focus()")
    browser.key("Home")
    browser.key("ArrowRight")
    assert "stick error" in text(browser, "pareto-active")
    browser.key("Enter")
    by_error = sorted(GOOD, key=lambda i: (MADE[i].metrics["stick_error"], cost(i)))
    assert browser.evaluate("FD.selected[0]") == by_error[1]
    browser.press_until(lambda: point(browser, by_error[-1]), "FD.selected[1] !== null")
    assert browser.evaluate("FD.selected") == [by_error[1], by_error[-1]]
    assert browser.evaluate(f"FD.name({by_error[-1]})") in text(browser, "chosen")


def test_front_of_two_measures_is_right(browser):
    option = "[...e.options].find((o) => o.text === '{}').value"
    browser.change("axis-y", option.format("safety margin"), "change")
    browser.wait("document.getElementById('pareto').layout.yaxis.title.text.includes('margin')")
    drawn = data(browser, "pareto")[0]["customdata"]
    feasible = browser.evaluate("FD.data.designs.flatMap((d, i) => (d.feasible ? [i] : []))")
    pairs = {
        i: (MADE[i].metrics["stick_error"], -MADE[i].metrics["safety_margin"]) for i in feasible
    }
    front = [
        i
        for i, (x, y) in pairs.items()
        if not any(u <= x and v <= y and (u, v) != (x, y) for u, v in pairs.values())
    ]
    assert sorted(drawn) == sorted(front)
    browser.change("axis-y", option.format("cost"), "change")


def test_downloads(browser):
    write_into(browser, "cost", "<12")
    browser.click('[data-save="designs_shown.csv"]')
    saved = browser.downloaded("designs_shown.csv").read_text("utf-8")
    shown = [row["digest"] for row in csv.DictReader(io.StringIO(saved))]
    assert shown == [MADE[number].digest for number in browser.evaluate(NUMBERS)]
    browser.click('[data-save="outcomes.json"]')
    reported = json.loads(browser.downloaded("outcomes.json").read_text("utf-8"))
    assert [each["digest"] for each in reported] == [o.digest for o in MADE]
    assert reported[20]["traces"]["gages"] == [list(row) for row in MADE[20].traces.gages]


def test_plotly_runs_under_the_policy_and_nothing_else_does(views):
    assert views.evaluate("Plotly.version").split(".")[0].isdigit()
    before = len(views.console)
    views.evaluate("document.head.append(FD.el('script', {}, 'window.foreign = 1'))")
    assert views.evaluate("window.foreign === undefined")
    blocked = views.console[before:]
    assert blocked
    assert all("Content Security Policy" in each for each in blocked)
    del views.console[before:]


def test_two_designs_are_drawn(views):
    plots = views.evaluate(
        "[...document.querySelectorAll('#views .plot')].map((e) =>"
        "[e.id, e.data?.length ?? 0, e.getAttribute('aria-label')?.length ?? 0])"
    )
    assert len(plots) == 2 * 4 + 1
    for place, traces, words in plots:
        assert traces > 0, place
        assert words > 20, place
    kinds = [trace["type"] for trace in data(views, "shape-0")]
    assert kinds.count("mesh3d") >= 3  # body, plates, gages
    assert kinds.count("scatter3d") == 3  # edges, stick, slip
    assert views.evaluate("document.querySelectorAll('#shape-0 canvas').length") >= 1


def test_turned_by_keys_and_buttons(views):
    def eyes():
        return [views.evaluate(EYE.format(k)) for k in (0, 1)]

    views.click('#views [aria-label="Reset the view"]')
    start = eyes()
    views.evaluate("document.getElementById('shape-0').focus()")
    for key in ("ArrowLeft", "ArrowUp", "+", "-"):
        ratio = "document.getElementById('shape-1').layout.scene.aspectratio.x"
        before = views.evaluate(ratio), eyes()
        views.key(key)
        assert (views.evaluate(ratio), eyes()) != before, key
    views.key("0")
    assert eyes() == start
    views.click('#views [aria-label="View from the front"]')
    assert eyes()[1] == pytest.approx([0, 0, 2], abs=1e-9)
    assert "turned 0°, tilted 0°" in text(views, "turned")


def test_the_slider_moves_all_pictures(views):
    state = (
        "[...document.querySelectorAll('#views .plot')].flatMap((e) =>"
        "[...(e.layout.shapes ?? []), ...e.data.filter((t) => t.type === 'scatter3d').slice(1),"
        "...(e.id === 'profile' ? e.data : [])].map((part) => JSON.stringify(part)))"
    )
    views.change("increment", 24)
    before = views.evaluate(state)
    views.change("increment", 3)
    after = views.evaluate(state)
    assert len(after) == len(before)
    changed = sum(p != q for p, q in zip(before, after, strict=True))
    assert changed >= len(before) - 2, "what slips may slip nowhere before and after"
    assert text(views, "increment-shown") == "3 of 24"
    cells = views.evaluate(
        "[...document.querySelectorAll('#readings [data-key=normal_force_N]')].map((e) =>"
        "Number(e.textContent))"
    )
    want = [FLAT[k].traces.normal_force_N[2] for k in (0, 1)]
    assert cells == pytest.approx(want, rel=0.01)
    views.change("increment", 20)  # what sticks and slips lies on the finger
    stick, slip = data(views, "shape-0")[-2:]
    row = FLAT[0].traces.status[19]
    assert stick["x"].count(None) == row.count("#")  # a gap after each line
    assert slip["x"].count(None) == row.count("/")
    views.change("increment", 24)


def test_parallel_coordinates_choose_by_keys_and_by_click_and_their_axes_are_chosen(views):
    place = "document.getElementById('parallel-chart')"
    views.evaluate("FD.select(2, 5)")
    seen(views, "parallel", f"{LINES}?.length > 4")
    views.evaluate(f"{place}.focus()")
    views.key("ArrowDown", 2)
    words = text(views, "parallel-chart-active")
    views.key("Enter")
    number = views.evaluate("FD.selected[1]")
    assert number in views.evaluate("FD.shown")
    assert words.startswith(FLAT[number].name)
    views.wait(f"{place}.getAttribute('aria-label').includes({json.dumps(FLAT[number].name)})")
    titles = [each["text"] for each in views.evaluate(f"{place}.layout.annotations")]
    assert any("arc radius" in title for title in titles)
    assert any("cost" in title and "▲" in title for title in titles)
    views.evaluate("FD.select(null, null)")
    count = f"{place}.layout.annotations.length"
    views.wait(f"{LINES}.length === 2 + {count}")
    views.show("parallel-chart")
    drawn = views.evaluate(f"(({{ x, y, customdata }}) => [x, y, customdata])({place}.data[0])")
    points = sorted(each for each in zip(*drawn, strict=True) if each[0] is not None)
    ends = [(None, None, None)]
    between = zip([*ends, *points], points, [*points[1:], *ends], strict=False)
    gaps = {
        point: min(abs(y - point[1]) for x, y, _ in (below, above) if x == point[0])
        for below, point, above in between
    }
    at_x, at_y, target = max(gaps, key=gaps.get)  # where no other line is near
    on_line = (
        f"(() => {{ const p = {place};"
        "const { xaxis, yaxis } = p._fullLayout; const r = p.getBoundingClientRect();"
        f"return [r.x + xaxis._offset + xaxis.l2p({at_x}),"
        f"r.y + yaxis._offset + yaxis.l2p({at_y})]; }})()"
    )
    views.press_until(lambda: views.evaluate(on_line), "FD.selected[0] !== null")
    assert views.evaluate("FD.selected") == [target, None]
    seen(views, "parallel", LINES)
    before = views.evaluate(count)
    views.evaluate("document.querySelector('#parallel-axes input:checked').click()")
    views.wait(f"{count} === {before - 1}")
    views.evaluate("document.querySelector('#parallel-axes input').click()")
    views.wait(f"{count} === {before}")


def test_names_stay_text_and_what_is_missing_is_named_also_without_webgl(page_of):
    off = "<head><script>HTMLCanvasElement.prototype.getContext = () => null</script>"

    def without(text):
        text = re.sub(
            r"'sha256-[^']*'", "", text.replace("script-src ", "script-src 'unsafe-inline' ")
        )
        return text.replace("<head>", off, 1)

    made = any_outcomes(len(HOSTILE) + 2, seed=4, failed=0.3, hostile=True)
    empty = replace(made[0], traces=Traces(), grips=(), design={}, failure=None, status="ok")
    browser = page_of((empty, *made[1:]), change=without)
    browser.evaluate("FD.select(0, 1)")
    seen(browser, "views", "document.getElementById('shape-words-0').textContent")
    for k in range(0, len(made), 2):
        choose(browser, k, k + 1)
    assert browser.evaluate("document.getElementById('no-webgl').checkVisibility()")
    assert not browser.evaluate("document.getElementById('shape-0').checkVisibility()")
    assert data(browser, "contact-0")
    seen(browser, "parallel", LINES)
    foreign = "document.querySelectorAll('#views img, main script, #parallel-chart a').length"
    assert browser.evaluate(foreign) == 0
    choose(browser, 0, None)
    seen(browser, "views", "document.getElementById('forces-none-0').checkVisibility()")
    bare = browser.evaluate("document.getElementById('views').innerText")
    for words in ("cannot be drawn", "No contact", "No gages", "No forces"):
        assert words in bare
    assert browser.evaluate("document.body.textContent").count("noSuchFunction") > 1


@pytest.mark.parametrize("look", ["light", "dark", "narrow", "print"])
def test_the_page_bars_nobody(unchosen, look, tmp_path):
    unchosen.appear(dark=look == "dark", paper=look == "print")
    unchosen.goto(unchosen.page, (360, 800) if look == "narrow" else (1100, 900))
    assert faults(unchosen) == []
    wide = unchosen.evaluate("document.documentElement.scrollWidth")
    assert wide <= unchosen.evaluate("innerWidth")
    bar = unchosen.evaluate("getComputedStyle(document.getElementById('chosen')).position")
    assert look != "narrow" or bar == "static"  # on a narrow screen the bar covers nothing
    assert look != "print" or unchosen.pdf(tmp_path / "page.pdf").stat().st_size > 20_000
    unchosen.appear()
