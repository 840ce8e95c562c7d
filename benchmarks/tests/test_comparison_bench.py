"""The bench of the comparison page: its numbers add up; one small page in a real browser."""

import json

import pytest
from fingerdesign_bench.any_finger.comparison import (
    Comparisons,
    PageMeasured,
    PageTimes,
    measure_comparison,
    write_comparison,
)

from tests.support.browser import chromium


def page(**changes):
    reported = {
        "designs": 5,
        "kind": "3-D",
        "megabytes": 3.0,
        "times": (PageTimes(0.2, 0.1, 0.8, 0.5, 0.3, 0.2), PageTimes(0.4, 0.1, 0.9, 0.6, 0.5, 0.2)),
        "requests": (),
        "console": (),
    }
    return PageMeasured(**(reported | changes))


def failing(found):
    return [check.name for check in Comparisons((found,), {}).checks() if not check.holds]


def test_what_falls_short_is_reported():
    assert failing(page()) == []
    assert page().median("open_s") == pytest.approx(0.3)
    assert failing(page(megabytes=21.0)) == ["5 designs, 3-D: size"]
    assert "requests" in failing(page(requests=("http://127.0.0.1/",)))[0]
    assert "opened" in failing(page(times=(PageTimes(1.2, 0.1, 0.8, 0.5, 0.3, 0.2),)))[0]


@pytest.mark.slow
@pytest.mark.skipif(chromium() is None, reason="no chromium on this machine")
def test_a_page_is_measured(tmp_path):
    found = measure_comparison(quick=True)
    assert [each.requests + each.console for each in found.pages] == [(), ()]
    (path,) = write_comparison(found, tmp_path)
    assert len(json.loads(path.read_text("utf-8"))["checks"]) == 14
