"""The studio in a real Chromium: moves are answered, the view stays, all is local."""

import itertools
import json

import pytest

from fingerdesign.design.starter import starter_text
from tests.support.browser import Browser, chromium
from tests.support.coarser import write_coarser
from tests.support.studio import READY, memory_MB, moved, running

pytest.importorskip("trame", reason="trame is missing: pip install 'fingerdesign[studio]'")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(chromium() is None, reason="no chromium on this machine"),
]
NUMBERS = "document.getElementById('numbers').innerText"
EYE = "Object.values(document.getElementById('shape')._fullLayout.scene._scene.getCamera().eye)"
# trame asks once whether a launcher started it; the answer is no.
USUAL = ("405 (Method Not Allowed)", "Vue.use")


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    """A studio of a file, and a browser on its page."""
    work = tmp_path_factory.mktemp("studio")
    path = work / "mine.toml"
    path.write_text(starter_text("mine", "maeno2000"), encoding="utf-8")
    write_coarser(path)
    with running(str(path), folder=work) as (process, address), Browser(address, work) as browser:
        browser.wait(READY)
        yield process, browser, path


def test_moves_of_the_object_and_of_the_finger_are_answered(studio):
    process, browser, _ = studio
    for key, value in (("friction", 0.3), ("plates.angle_deg", 30.0)):
        before = browser.evaluate(NUMBERS)
        moved(browser, key, value)  # on a busy machine an earlier answer may come first
        browser.wait(f"{NUMBERS} !== {json.dumps(before)}")
    assert memory_MB(process) < 1000


def test_a_click_on_a_gage_shows_its_trace(studio):
    _, browser, _ = studio
    browser.click('[data-gage="1"] .target')
    title = "document.getElementById('trace').innerText.includes('Gage of plate 1')"
    browser.wait(title)
    assert browser.evaluate("document.getElementById('gage').value") == "1"


def test_pin_save_and_watch(studio):
    _, browser, path = studio
    browser.click("#pin")
    browser.wait("document.querySelectorAll('.pair.two').length === 2")
    moved(browser, "plates.angle_deg", 33.0)
    browser.wait("document.querySelector('.pinned').innerText.includes('→ 33')")
    saved(browser)
    assert "angle_deg = 33.0" in path.read_text("utf-8")
    path.write_text(path.read_text("utf-8").replace("angle_deg = 33.0", "angle_deg = 21.0"))
    browser.wait("document.querySelector('[data-key=\"plates.angle_deg\"]').value === '21'")
    browser.click("#pin")
    browser.wait("!document.querySelector('.pinned')")


CHANGE = """(() => {
  const control = document.querySelector('[data-key="%s"]');
  control.value = '%s';
  control.dispatchEvent(new Event('change'));
})()"""
MATERIAL = "document.querySelector('[data-key=\"plates.material\"]').value"


def saved(browser):
    """Save as soon as there is something to save, and wait for the note."""
    browser.wait("!document.getElementById('save').disabled")
    browser.click("#save")
    browser.wait("document.querySelector('p.note')?.innerText.startsWith('saved')")


def test_a_material_is_chosen_and_taken_back(studio):
    _, browser, _ = studio
    browser.evaluate(CHANGE % ("plates.material", "spring_steel"))
    browser.wait("!document.getElementById('undo').disabled")
    browser.wait("document.querySelector('.title').innerText.includes('unsaved')")
    browser.click("#undo")
    browser.wait(f"{MATERIAL} === 'phosphor_bronze'")
    browser.click("#redo")
    browser.wait(f"{MATERIAL} === 'spring_steel'")
    browser.click("#undo")
    browser.wait(f"{MATERIAL} === 'phosphor_bronze'")


def test_verdicts_follow_when_the_sliders_rest(studio):
    _, browser, _ = studio
    browser.wait("document.querySelectorAll('#verdict li').length === 4", 400)
    assert "plane strain" in browser.evaluate("document.querySelector('.answers').innerText")
    assert "gage signal" in browser.evaluate("document.getElementById('verdict').innerText")


def test_the_controls_follow_a_search_which_can_be_stopped(studio):
    """The search begins with a trial like the design, of another plate material."""
    _, browser, path = studio
    before = path.read_text("utf-8")
    browser.evaluate(
        "(() => { const e = document.getElementById('trials'); e.value = 1;"
        " e.dispatchEvent(new Event('change')); })()"
    )
    browser.click("#search")
    browser.wait("document.getElementById('search').innerText === 'Stop'")
    browser.wait(f"{MATERIAL} === 'polyimide'", 400)
    browser.wait("document.getElementById('best')?.innerText.includes('slip sensing')")
    assert browser.evaluate("document.getElementById('slider-0').disabled")
    browser.click("#search")
    browser.wait("document.getElementById('search').innerText !== 'Stop'")
    browser.wait("document.getElementById('progress').innerText.includes('stopped')")
    assert browser.evaluate(MATERIAL) == "polyimide"
    saved(browser)
    assert 'material = "polyimide"' in path.read_text("utf-8")
    assert path.read_text("utf-8").splitlines()[0] == before.splitlines()[0]
    browser.click("#undo")
    browser.wait(f"{MATERIAL} === 'phosphor_bronze'")


def test_sliders_stand_at_the_side_of_the_pictures_on_a_wide_screen(studio):
    _, browser, _ = studio
    screen = {"width": 1440, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", **screen)
    places = browser.evaluate(
        "[...document.querySelector('main').children].map(e => e.getBoundingClientRect())"
        ".filter(r => r.width > 0).map(r => [r.left, r.right, r.top])"
    )
    assert len(places) >= 2
    for (_, right, top), (left, _, neighbour_top) in itertools.pairwise(places):
        assert right <= left
        assert neighbour_top == pytest.approx(top, abs=2.0)


def test_nothing_is_wider_than_a_telephone_and_nothing_is_fetched(studio):
    _, browser, _ = studio
    screen = {"width": 360, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", **screen)
    assert browser.evaluate("document.documentElement.scrollWidth") <= 360
    assert browser.requests == []
    assert [each for each in browser.console if not any(word in each for word in USUAL)] == []
