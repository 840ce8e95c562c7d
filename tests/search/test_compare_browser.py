"""The comparison page in a real Chromium: clicks, keys, sorting, filters, downloads, silence."""

import csv
import io
import json
import re
from dataclasses import replace

import pytest

from fingerdesign.search.compare.page import compare_html
from fingerdesign.search.compare.read import facts_of
from fingerdesign.search.compare.recommend import Bound, Wanted, recommend
from tests.support.any_outcomes import any_outcomes
from tests.support.browser import Browser, BrowserError, chromium

pytestmark = pytest.mark.skipif(
    chromium() is None, reason="no chromium on this machine: the page is not opened in a browser"
)
WANTED = (Wanted("stick_error", "min"), Wanted("cost", "min"), Wanted("safety_margin", "max"))
MADE = any_outcomes(60, hostile=True)
SHOWN = "[...document.querySelectorAll('#table-designs tbody tr:not([hidden])')]"
# The designs that the chart of two measures draws as points.
POINTS = (
    "document.getElementById('pareto').data.filter((t) => !['line', 'ring'].includes(t.name))"
    ".flatMap((t) => t.customdata)"
)
NUMBERS = f"{SHOWN}.map((row) => Number(row.dataset.i))"


@pytest.fixture(scope="module")
def opened(tmp_path_factory):
    work = tmp_path_factory.mktemp("compare")
    page = work / "compare.html"
    facts = facts_of("a study", MADE, WANTED, (Bound("peak_ratio", at_most=2.0),))
    page.write_text(compare_html(MADE, facts), encoding="utf-8")
    with Browser(page, work) as browser:
        yield browser
        # Whatever the tests did: no word in the console, nothing asked of any network.
        assert browser.console == []
        assert browser.requests == []


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


def test_watch_sees_errors_and_requests(tmp_path):
    page = tmp_path / "bad.html"
    page.write_text(
        '<img src="http://127.0.0.1:9/x.png"><script>noSuchFunction()</script>', encoding="utf-8"
    )
    with Browser(page, tmp_path) as browser:
        assert "noSuchFunction" in "".join(browser.console)
        assert browser.requests == ["http://127.0.0.1:9/x.png"]
        with pytest.raises(BrowserError, match="nothing"):
            browser.evaluate("nothing")


@pytest.mark.parametrize("few", [(), any_outcomes(3, failed=1.0), MADE[20:21], MADE[20:22]])
def test_a_page_of_few_or_none_is_silent(tmp_path, few):
    page = tmp_path / "few.html"
    page.write_text(compare_html(few, facts_of("few", few, WANTED)), encoding="utf-8")
    with Browser(page, tmp_path) as browser:
        for place in ("views", "parallel-chart"):
            browser.show(place)
            browser.evaluate("new Promise((f) => setTimeout(f, 200))")
        assert browser.evaluate("FD.shown.length") == sum(o.status == "ok" for o in few)
        assert browser.console == browser.requests == []


def test_opens_with_the_recommended_one_chosen(opened):
    name = opened.evaluate("document.getElementById('recommended-name').textContent")
    first = opened.evaluate(f"{SHOWN}[0].textContent")
    assert name in first
    assert "recommended" in first
    assert opened.evaluate("document.title") == "a study: fingers compared"


def test_sorts_by_mouse_and_keys_both_ways(browser):
    button = f"{head(browser, 'cost')} button"
    browser.click(button)
    up = [cost(number) for number in browser.evaluate(NUMBERS)]
    assert up == sorted(up)
    sort = f"document.querySelector({head(browser, 'cost')!r}).getAttribute('aria-sort')"
    assert browser.evaluate(sort) == "ascending"
    browser.key("Enter")
    assert browser.evaluate(sort) == "descending"
    assert [cost(n) for n in browser.evaluate(NUMBERS)] == up[::-1]


def test_most_first_and_no_value_last(browser):
    browser.click(f"{head(browser, 'safety')} button")
    margins = [MADE[number].metrics["safety_margin"] for number in browser.evaluate(NUMBERS)]
    known = [margin for margin in margins if margin is not None]
    assert known == sorted(known, reverse=True)
    assert margins[: len(known)] == known


def test_filters_by_bounds_and_words(browser):
    write_into(browser, "cost", "10..15")
    write_into(browser, "design", "any_")
    numbers = browser.evaluate(NUMBERS)
    requested = {
        i
        for i, o in enumerate(MADE)
        if o.status == "ok" and 10 <= o.metrics["cost"] <= 15 and "any_" in o.name
    }
    assert set(numbers) == requested
    assert 0 < len(requested) < 40
    count = browser.evaluate("document.getElementById('shown-count').textContent")
    good = sum(o.status == "ok" for o in MADE)
    assert count == f"{len(requested)} of {good} shown"
    browser.wait(f"{POINTS}.length === {len(requested)}")


def test_a_filter_that_makes_no_sense_is_reported(browser):
    write_into(browser, "cost", "cheap")
    fault = browser.evaluate("document.querySelector('.fault').textContent")
    assert "cost" in fault
    assert len(browser.evaluate(NUMBERS)) == sum(o.status == "ok" for o in MADE)


def test_front_alone(browser):
    browser.click("#only-front")
    numbers = browser.evaluate(NUMBERS)
    data = browser.evaluate("FD.data.designs.flatMap((d, i) => (d.front ? [i] : []))")
    assert sorted(numbers) == data


def test_choosing_two_by_keys_in_the_table(browser):
    browser.evaluate("document.querySelector('#table-designs tbody [tabindex=\"0\"]').focus()")
    numbers = browser.evaluate(NUMBERS)
    at = browser.evaluate("Number(document.activeElement.closest('tr').dataset.i)")
    place = numbers.index(at)
    browser.key("Enter")
    browser.key("ArrowDown", 2 if place + 2 < len(numbers) else 0)
    browser.key(" ")
    assert browser.evaluate("FD.selected") == [at, numbers[place + 2]]
    pressed = "document.querySelectorAll('#table-designs [aria-pressed=\"true\"]').length"
    assert browser.evaluate(pressed) == 2
    table = browser.evaluate("document.getElementById('table-pair').innerText")
    assert re.search(r"[AB] is better", table)
    assert (
        browser.evaluate("document.querySelectorAll('#table-designs [tabindex=\"0\"]').length") == 1
    )


def test_choosing_in_the_chart_by_mouse_and_keys(browser):
    browser.evaluate("document.getElementById('pareto').focus()")
    browser.key("Home")
    browser.key("ArrowRight")
    reported = browser.evaluate("document.getElementById('pareto-active').textContent")
    browser.key("Enter")
    number = browser.evaluate("FD.selected[0]")
    assert "stick error" in reported
    by_error = sorted(
        (i for i, o in enumerate(MADE) if o.status == "ok"),
        key=lambda i: (MADE[i].metrics["stick_error"], cost(i)),
    )
    assert number == by_error[1]
    browser.press_at(*point(browser, by_error[-1]))
    browser.wait("FD.selected[1] !== null")
    assert browser.evaluate("FD.selected") == [by_error[1], by_error[-1]]
    chosen = browser.evaluate("document.getElementById('chosen').innerText")
    assert browser.evaluate(f"FD.name({by_error[-1]})") in chosen


def test_of_three_the_oldest_goes_and_any_can_be_left_out(browser):
    seen = []
    for number in (20, 21, 22, 21):
        browser.evaluate(f"FD.toggle({number})")
        seen.append(browser.evaluate("FD.selected"))
    assert seen == [[20, None], [20, 21], [21, 22], [22, None]]
    browser.evaluate("FD.toggle(20)")
    browser.click("#chosen > button")  # swap
    assert browser.evaluate("FD.selected") == [20, 22]
    browser.click("#chosen .one button")  # leave A out
    assert browser.evaluate("FD.selected") == [22, None]
    assert browser.evaluate("document.querySelectorAll('#table-designs tr[data-mark]').length") == 1


def test_front_of_two_measures_is_right(browser):
    option = "[...e.options].find((o) => o.text === '{}').value"
    browser.change("axis-y", option.format("safety margin"), "change")
    line = "document.getElementById('pareto').data[0].customdata"
    browser.wait("document.getElementById('pareto').layout.yaxis.title.text.includes('margin')")
    drawn = browser.evaluate(line)
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


def test_a_box_in_the_chart_filters_the_table(browser):
    number = browser.evaluate("FD.data.study.recommended")
    x, y = point(browser, number)
    browser.press_at(x - 30, y - 30, (x + 30, y + 30))
    total = sum(o.status == "ok" for o in MADE)
    browser.wait(f"FD.shown.length < {total}")
    assert number in browser.evaluate("FD.shown")
    place = column(browser, "cost")
    field = f"document.querySelector('#table-designs .filters td:nth-child({place}) input').value"
    low, high = map(float, browser.evaluate(field).split(".."))
    assert low <= cost(number) <= high


def test_downloads(browser):
    write_into(browser, "cost", "<12")
    browser.click('[data-save="designs_shown.csv"]')
    text = browser.downloaded("designs_shown.csv").read_text("utf-8")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert [row["digest"] for row in rows] == [
        MADE[number].digest for number in browser.evaluate(NUMBERS)
    ]
    browser.click('[data-save="outcomes.json"]')
    reported = json.loads(browser.downloaded("outcomes.json").read_text("utf-8"))
    assert [each["digest"] for each in reported] == [o.digest for o in MADE]
    assert reported[20]["traces"]["gages"] == [list(row) for row in MADE[20].traces.gages]


def test_two_designs_are_drawn_when_they_come_into_sight(browser):
    browser.evaluate("FD.select(10, 12)")
    browser.show("views")
    browser.wait("document.getElementById('forces-1').data")
    assert browser.evaluate("document.querySelectorAll('#views svg, #views canvas').length") >= 2
    browser.show("parallel")
    browser.wait("document.querySelectorAll('#parallel-chart svg').length")


def test_every_button_has_a_name_and_every_field_a_label(browser):
    nameless = browser.evaluate(
        "[...document.querySelectorAll('button, input, select')].filter((e) =>"
        "!(e.textContent.trim() || e.getAttribute('aria-label') || e.closest('label')"
        "|| e.labels?.length)).map((e) => e.outerHTML)"
    )
    assert nameless == []


@pytest.mark.parametrize("dark", [False, True])
def test_text_stands_out(browser, dark):
    browser.appear(dark=dark)
    colours = browser.evaluate(
        "['ink', 'muted', 'blue', 'yes', 'no', 'partly', 'paper', 'panel'].map((n) => FD.colour(n))"
    )
    browser.appear()
    *inks, paper, panel = (luminance(colour) for colour in colours)
    for ink in inks:
        for ground in (paper, panel):
            low, high = sorted((ink, ground))
            assert (high + 0.05) / (low + 0.05) >= 4.5


def luminance(colour):
    """Relative luminance of #rrggbb (WCAG 2.2)."""
    whole = colour if len(colour) == 7 else "#" + "".join(2 * c for c in colour[1:])
    parts = [int(whole[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


@pytest.mark.parametrize("width", [360, 800])
def test_fits_narrow_windows(browser, width):
    screen = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", **screen)
    wide = browser.evaluate("document.documentElement.scrollWidth")
    browser.call("Emulation.setDeviceMetricsOverride", **(screen | {"width": 1400, "height": 1000}))
    assert wide <= width


def test_prints(browser, tmp_path):
    assert browser.pdf(tmp_path / "page.pdf").stat().st_size > 20_000


def test_badges_leave_the_star_and_b_is_the_runner_up(browser):
    facts = facts_of("a study", MADE, WANTED, (Bound("peak_ratio", at_most=2.0),))
    found = recommend(MADE, facts.objectives, facts.constraints)
    assert browser.evaluate("FD.data.study.pair") == [found.chosen, found.runner_up]
    browser.evaluate("FD.select(...FD.data.study.pair)")
    badges = "document.getElementById('pareto').layout.annotations"
    browser.wait(f"{badges}.length === 2")
    apart = """(() => {
      const place = document.getElementById("pareto");
      const drawn = [...place.querySelectorAll(".trace.scatter path.point")]; // the star last
      const both = [drawn.pop(), place.querySelector(".annotation")];
      const [a, b] = both.map((e) => e.getBoundingClientRect());
      return a.right <= b.x || b.right <= a.x || a.bottom <= b.y || b.bottom <= a.y;
    })()"""
    assert browser.evaluate(apart)


def test_the_two_say_what_they_miss_and_where_grips_differ(browser):
    missing = next(
        i for i, o in enumerate(MADE) if o.status == "ok" and o.metrics["peak_ratio"] > 2
    )
    rest = [i for i, o in enumerate(MADE) if o.status == "ok" and i != missing]
    browser.evaluate(f"FD.select({missing}, {rest[0]})")
    text = "document.getElementById('pair-numbers').innerText"
    assert "A: not feasible, peak_ratio" in browser.evaluate(text)
    keep = "[FD.data.designs[%d].metrics.grip_success, FD.data.designs[%d].metrics.grip_success]"
    before = browser.evaluate(keep % (missing, rest[0]))
    for success, reported in ((0.5, True), (1.0, False)):
        browser.evaluate(f"{keep % (missing, rest[0])} = [{success}, 1.0]")
        browser.evaluate(f"FD.select({missing}, {rest[0]})")
        assert ("grip success of the two differs" in browser.evaluate(text)) is reported
    browser.evaluate(f"{keep % (missing, rest[0])} = {json.dumps(before)}")


def test_on_a_narrow_screen_the_bar_covers_nothing(tmp_path):
    page = tmp_path / "narrow.html"
    few = MADE[20:26]
    page.write_text(compare_html(few, facts_of("few", few, WANTED)), encoding="utf-8")
    with Browser(page, tmp_path, (400, 800)) as browser:
        place = "getComputedStyle(document.getElementById('chosen')).position"
        assert browser.evaluate("innerWidth") <= 640
        assert browser.evaluate(place) == "static"


def test_a_measure_alike_for_all_has_one_mark(tmp_path):
    page = tmp_path / "alike.html"
    few = [replace(o, metrics=o.metrics | {"cost": 7.0}) for o in MADE if o.status == "ok"][:8]
    page.write_text(compare_html(few, facts_of("few", few, WANTED[:2])), encoding="utf-8")
    with Browser(page, tmp_path) as browser:
        browser.wait("document.querySelector('#pareto .ytick')")
        text = browser.evaluate("document.getElementById('pareto').textContent")
        assert "cost: the same for all" in text
        ticks = "[...document.querySelectorAll('#pareto .ytick')].map((e) => e.textContent)"
        assert browser.evaluate(ticks) == ["7"]
