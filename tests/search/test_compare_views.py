"""The views of two designs in a real browser: drawn, turned, followed, chosen; names stay text."""

import re
from dataclasses import replace

import pytest

from fingerdesign.records.outcome import Traces
from fingerdesign.search.compare.page import compare_html
from fingerdesign.search.compare.read import facts_of
from fingerdesign.search.compare.recommend import Wanted
from tests.support.any_outcomes import HOSTILE, any_outcomes
from tests.support.browser import Browser, chromium

pytestmark = pytest.mark.skipif(
    chromium() is None, reason="no chromium on this machine: the views are not opened in a browser"
)
WANTED = (Wanted("stick_error", "min"), Wanted("cost", "min"))
FLAT = any_outcomes(12, seed=1, failed=0.0)
DEEP = any_outcomes(2, seed=2, failed=0.0, deep=True)
EYE = "Object.values(document.getElementById('shape-{}').layout.scene.camera.eye)"


def page_in(folder, outcomes, wanted=WANTED):
    page = folder / "views.html"
    page.write_text(compare_html(outcomes, facts_of("views", outcomes, wanted)), encoding="utf-8")
    return page


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


@pytest.fixture(scope="module")
def opened(tmp_path_factory):
    work = tmp_path_factory.mktemp("views")
    with Browser(page_in(work, FLAT), work) as browser:
        seen(browser, "views", "document.getElementById('forces-1').data")
        yield browser
        assert browser.console == []
        assert browser.requests == []


@pytest.fixture
def browser(opened):
    choose(opened, 0, 1)
    seen(opened, "views", "document.getElementById('forces-1').data")
    return opened


def test_plotly_runs_under_the_policy_and_nothing_else_does(browser):
    assert browser.evaluate("Plotly.version").split(".")[0].isdigit()
    before = len(browser.console)
    browser.evaluate("document.head.append(FD.el('script', {}, 'window.foreign = 1'))")
    assert browser.evaluate("window.foreign === undefined")
    blocked = browser.console[before:]
    assert blocked
    assert all("Content Security Policy" in each for each in blocked)
    del browser.console[before:]


def test_two_designs_are_drawn(browser):
    plots = browser.evaluate(
        "[...document.querySelectorAll('#views .plot')].map((e) =>"
        "[e.id, e.data?.length ?? 0, e.getAttribute('aria-label')?.length ?? 0])"
    )
    assert len(plots) == 2 * 4 + 1
    for place, traces, words in plots:
        assert traces > 0, place
        assert words > 20, place
    kinds = [trace["type"] for trace in data(browser, "shape-0")]
    assert kinds.count("mesh3d") >= 3  # body, plates, gages
    assert kinds.count("scatter3d") == 3  # edges, stick, slip
    assert browser.evaluate("document.querySelectorAll('#shape-0 canvas').length") >= 1


def test_turned_by_keys_buttons_and_hand(browser):
    browser.click('#views [aria-label="Reset the view"]')
    start = [browser.evaluate(EYE.format(k)) for k in (0, 1)]
    browser.evaluate("document.getElementById('shape-0').focus()")
    for key in ("ArrowLeft", "ArrowUp", "+", "-"):
        ratio = "document.getElementById('shape-1').layout.scene.aspectratio.x"
        before = browser.evaluate(ratio), browser.evaluate(EYE.format(1))
        browser.key(key)
        assert (browser.evaluate(ratio), browser.evaluate(EYE.format(1))) != before, key
    browser.key("0")
    assert [browser.evaluate(EYE.format(k)) for k in (0, 1)] == start
    browser.click('#views [aria-label="View from the front"]')
    assert browser.evaluate(EYE.format(1)) == pytest.approx([0, 0, 2], abs=1e-9)
    assert "turned 0°, tilted 0°" in browser.evaluate(
        "document.getElementById('turned').textContent"
    )
    browser.click("#turn-both")
    alone = browser.evaluate(EYE.format(1))
    browser.show("shape-0")
    x, y = browser.evaluate(
        "(() => { const r = document.getElementById('shape-0').getBoundingClientRect();"
        "return [r.x + r.width / 2, r.y + r.height / 2]; })()"
    )
    mouse = {"button": "left", "buttons": 1, "clickCount": 1}
    for kind, step in [("Pressed", 0), *(("Moved", k) for k in range(1, 7)), ("Released", 6)]:
        at = {"x": x + 10 * step, "y": y + 3 * step}
        browser.call("Input.dispatchMouseEvent", type=f"mouse{kind}", **at, **mouse)
        browser.evaluate("new Promise(requestAnimationFrame)")  # the scene follows by frames
    browser.wait(f"{EYE.format(0)}[0] !== 0")
    assert browser.evaluate(EYE.format(1)) == alone
    browser.click("#turn-both")
    browser.click('#views [aria-label="Reset the view"]')
    assert [browser.evaluate(EYE.format(k)) for k in (0, 1)] == start


def test_another_pair_is_seen_from_where_the_last_one_was(browser):
    browser.click('#views [aria-label="View from the side"]')
    eye = browser.evaluate(EYE.format(0))
    browser.change("increment", 3)
    choose(browser, 2, 3)
    assert browser.evaluate(EYE.format(0)) == eye
    assert browser.evaluate("document.getElementById('increment').value") == "3"
    browser.click('#views [aria-label="Reset the view"]')
    browser.change("increment", 24)


def test_the_slider_moves_all_pictures(browser):
    state = (
        "[...document.querySelectorAll('#views .plot')].flatMap((e) =>"
        "[...(e.layout.shapes ?? []), ...e.data.filter((t) => t.type === 'scatter3d').slice(1),"
        "...(e.id === 'profile' ? e.data : [])].map((part) => JSON.stringify(part)))"
    )
    browser.change("increment", 24)
    before = browser.evaluate(state)
    browser.change("increment", 3)
    after = browser.evaluate(state)
    assert len(after) == len(before)
    changed = sum(p != q for p, q in zip(before, after, strict=True))
    assert changed >= len(before) - 2, "what slips may slip nowhere before and after"
    assert browser.evaluate("document.getElementById('increment-shown').textContent") == "3 of 24"
    cells = browser.evaluate(
        "[...document.querySelectorAll('#readings [data-key=normal_force_N]')].map((e) =>"
        "Number(e.textContent))"
    )
    want = [FLAT[k].traces.normal_force_N[2] for k in (0, 1)]
    assert cells == pytest.approx(want, rel=0.01)
    browser.change("increment", 24)


def test_what_sticks_and_slips_lies_on_the_finger(browser):
    browser.change("increment", 20)
    stick, slip = data(browser, "shape-0")[-2:]
    row = FLAT[0].traces.status[19]
    assert stick["x"].count(None) == row.count("#")  # a gap after each line
    assert slip["x"].count(None) == row.count("/")
    browser.change("increment", 24)


def test_a_gage_is_brought_out(browser):
    widths = "document.getElementById('gages-0').data.map((trace) => trace.line.width)"
    peak = [max(map(abs, each)) for each in zip(*FLAT[0].traces.gages, strict=True)]
    wide = browser.evaluate(widths)
    assert wide.index(max(wide)) == peak.index(max(peak))
    browser.change("gage-0", 1, "change")
    wide = browser.evaluate(widths)
    assert (wide.index(max(wide)), wide.count(max(wide))) == (1, 1)


def test_one_design_alone(browser):
    choose(browser, 0, None)
    columns = "[...document.querySelectorAll('.v-column')].filter((e) => !e.hidden).length"
    assert browser.evaluate(columns) == 5
    browser.evaluate("FD.select(null, null)")
    browser.wait("document.getElementById('views').hidden")
    assert "none chosen" in browser.evaluate("document.getElementById('table-pair').textContent")


def test_contact_in_3d_is_a_top_view_of_the_chosen_increment(tmp_path):
    with Browser(page_in(tmp_path, DEEP), tmp_path) as browser:
        browser.evaluate("FD.select(0, 1)")
        seen(browser, "views", "document.getElementById('contact-1').data?.[0].x")
        browser.change("increment", 20)
        row = DEEP[0].traces.status[19]
        found = [trace["x"].count(None) for trace in data(browser, "contact-0")]
        assert found == [row.count(each) for each in "#/."]
        stick = data(browser, "shape-0")[-2]
        assert stick["mode"] == "markers"
        assert stick["x"].count(None) == row.count("#")
        assert browser.console == browser.requests == []


def test_parallel_coordinates_choose_by_keys_and_by_click(browser):
    browser.evaluate("FD.select(2, 5)")
    seen(browser, "parallel", "document.getElementById('parallel-chart').data?.length > 4")
    place = "document.getElementById('parallel-chart')"
    shown = browser.evaluate("FD.shown")
    browser.evaluate(f"{place}.focus()")
    browser.key("ArrowDown", 2)
    words = browser.evaluate("document.getElementById('parallel-chart-active').textContent")
    browser.key("Enter")
    number = browser.evaluate("FD.selected[1]")
    assert number in shown
    assert words.startswith(FLAT[number].name)
    titles = [each["text"] for each in browser.evaluate(f"{place}.layout.annotations")]
    assert any("arc radius" in title for title in titles)
    assert any("cost" in title and "▲" in title for title in titles)
    assert FLAT[number].name in browser.evaluate(f"{place}.getAttribute('aria-label')")
    browser.evaluate("FD.select(null, null)")
    browser.wait(f"{place}.data.length === 2 + {place}.layout.annotations.length")
    browser.show("parallel-chart")
    x, y, want = browser.evaluate(
        f"(() => {{ const p = {place};"
        "const { xaxis, yaxis } = p._fullLayout; const r = p.getBoundingClientRect();"
        "return [r.x + xaxis._offset + xaxis.l2p(p.data[0].x[0]),"
        "r.y + yaxis._offset + yaxis.l2p(p.data[0].y[0]), p.data[0].customdata[0]]; })()"
    )
    browser.press_at(x, y)
    browser.wait("FD.selected[0] !== null")
    assert browser.evaluate("FD.selected") == [want, None]


def test_axes_of_the_lines_are_chosen(browser):
    seen(browser, "parallel", "document.getElementById('parallel-chart').data")
    count = "document.getElementById('parallel-chart').layout.annotations.length"
    before = browser.evaluate(count)
    browser.evaluate("document.querySelector('#parallel-axes input:checked').click()")
    browser.wait(f"{count} === {before - 1}")
    browser.evaluate("document.querySelector('#parallel-axes input').click()")
    browser.wait(f"{count} === {before}")


def test_names_stay_text_and_what_is_missing_is_said(tmp_path):
    made = any_outcomes(len(HOSTILE) + 2, seed=4, failed=0.3, hostile=True)
    empty = replace(made[0], traces=Traces(), grips=(), design={}, failure=None, status="ok")
    made = (empty, *made[1:])
    with Browser(page_in(tmp_path, made), tmp_path) as browser:
        browser.evaluate("FD.select(0, 1)")
        seen(browser, "views", "document.getElementById('shape-words-0').textContent")
        for k in range(0, len(made), 2):
            choose(browser, k, k + 1)
        seen(browser, "parallel", "document.getElementById('parallel-chart').data")
        foreign = "document.querySelectorAll('#views img, main script, #parallel-chart a').length"
        assert browser.evaluate(foreign) == 0
        choose(browser, 0, None)
        seen(browser, "views", "document.getElementById('forces-none-0').checkVisibility()")
        bare = browser.evaluate("document.getElementById('views').innerText")
        for words in ("cannot be drawn", "No contact", "No gages", "No forces"):
            assert words in bare
        assert browser.evaluate("document.body.textContent").count("noSuchFunction") > 1
        assert browser.console == browser.requests == []


def test_without_webgl_the_rest_is_drawn(tmp_path):
    page = page_in(tmp_path, FLAT)
    off = "<head><script>HTMLCanvasElement.prototype.getContext = () => null</script>"
    text = page.read_text("utf-8").replace("script-src ", "script-src 'unsafe-inline' ")
    text = re.sub(r"'sha256-[^']*'", "", text)
    page.write_text(text.replace("<head>", off, 1), encoding="utf-8")
    with Browser(page, tmp_path) as browser:
        seen(browser, "views", "document.getElementById('forces-1').data")
        assert browser.evaluate("document.getElementById('no-webgl').checkVisibility()")
        assert not browser.evaluate("document.getElementById('shape-0').checkVisibility()")
        assert data(browser, "contact-0")
        assert browser.console == []


def test_turning_is_quick_and_many_designs_too(tmp_path):
    many = any_outcomes(300, seed=5, failed=0.0)
    many = (*many[:4], *(replace(each, traces=Traces(), grips=()) for each in many[4:]))
    with Browser(page_in(tmp_path, many), tmp_path) as browser:
        browser.evaluate("FD.select(0, 1)")
        seen(browser, "views", "document.getElementById('forces-1').data")
        busy = browser.busy_s()
        browser.evaluate("document.getElementById('shape-0').focus()")
        browser.key("ArrowLeft", 5)
        turned = (browser.busy_s() - busy) / 5
        busy = browser.busy_s()
        seen(browser, "parallel", "document.getElementById('parallel-chart').data")
        drawn = browser.busy_s() - busy
    assert turned < 0.5
    assert drawn < 1.5
