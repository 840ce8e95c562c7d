"""``fingerdesign bench compare``: how large the comparison page is, how fast it opens and sorts.

In a real headless Chromium, with outcomes that nobody analysed (any_outcomes.py). Each time is the
median of fresh browsers, by the clock and in processor time of the page's main thread: on a busy
machine only the latter tells of the page.
"""

import json
import statistics
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Check
from fingerdesign_bench.machine import machine
from tests.support.any_outcomes import any_outcomes
from tests.support.browser import Browser

DESIGNS, QUICK_DESIGNS = 500, 50
ASKED_S, ASKED_MB = 1.0, 20.0
ASKED_CHART_S = 3.0  # until the first chart stands: the text can be read and sorted before
TIMES, QUICK_TIMES = 5, 1
# Until the browser has painted what came of the act.
_PAINTED = "new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)))"
_CHART = (
    "(async () => { const place = document.getElementById('pareto'); place.scrollIntoView();"
    f"while (!place.data) await {_PAINTED}; }})()"
)
_SORT = (
    "(async () => { const from = performance.now();"
    "document.querySelector('#table-designs thead th:nth-child({column}) button').click();"
    f"await {_PAINTED}; return (performance.now() - from) / 1000; }})()"
)
_COLUMNS = (1, 3, 4)  # a name and two metrics


@dataclass(frozen=True)
class PageTimes:
    """One opening: s by the clock and of the main thread; the slowest of the sorts.

    chart_s, chart_busy_s: from asking for the page until its first chart is drawn.
    """

    open_s: float
    open_busy_s: float
    chart_s: float
    chart_busy_s: float
    sort_s: float
    sort_busy_s: float


@dataclass(frozen=True)
class PageMeasured:
    """A page of ``designs``; requests, console: what all openings asked for and said."""

    designs: int
    kind: str
    megabytes: float
    times: tuple[PageTimes, ...]
    requests: tuple[str, ...]
    console: tuple[str, ...]

    def median(self, name: str) -> float:
        """The median of one of the times, s."""
        return float(statistics.median(getattr(each, name) for each in self.times))


@dataclass(frozen=True)
class Comparisons:
    """Pages of plane strain and of 3-D outcomes, and the machine."""

    pages: tuple[PageMeasured, ...]
    machine: dict[str, Any]

    def checks(self) -> list[Check]:
        """What issue 8 asks, against what was measured."""
        found = []
        for page in self.pages:
            of = f"{page.designs} designs, {page.kind}"
            found += [
                Check(f"{of}: opened", ASKED_S, page.median("open_s"), "s"),
                Check(f"{of}: opened, main thread", ASKED_S, page.median("open_busy_s"), "s"),
                Check(
                    f"{of}: first chart, main thread",
                    ASKED_CHART_S,
                    page.median("chart_busy_s"),
                    "s",
                ),
                Check(f"{of}: sorted", ASKED_S, page.median("sort_s"), "s"),
                Check(f"{of}: sorted, main thread", ASKED_S, page.median("sort_busy_s"), "s"),
                Check(f"{of}: size", ASKED_MB, page.megabytes, "MB"),
                Check(f"{of}: requests and console messages", 0, len(page.requests + page.console)),
            ]
        return found

    def as_dict(self) -> dict[str, Any]:
        """As comparison.json holds it."""
        checks = [check.as_dict() for check in self.checks()]
        return {
            "pages": [asdict(page) for page in self.pages],
            "checks": checks,
            "machine": self.machine,
        }


def measure_comparison(report: Report = lambda message: None, quick: bool = False) -> Comparisons:
    """Make the pages, open each in fresh browsers, sort by three columns. Needs Chromium."""
    found = machine()
    designs, times = (QUICK_DESIGNS, QUICK_TIMES) if quick else (DESIGNS, TIMES)
    pages = []
    for kind, deep in (("plane strain", False), ("3-D", True)):
        report(f"{kind}: making the page")
        text = _page(designs, deep)
        report(f"{kind}: opening it")
        pages.append(_measured(text, designs, kind, times))
    return Comparisons(tuple(pages), found)


def write_comparison(found: Comparisons, folder: Path) -> list[Path]:
    """comparison.json into a folder; its path."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "comparison.json"
    path.write_text(json.dumps(found.as_dict(), indent=1, allow_nan=False) + "\n", "utf-8")
    return [path]


def _page(designs: int, deep: bool) -> str:
    from fingerdesign.search.compare.page import compare_html
    from fingerdesign.search.compare.read import facts_of
    from fingerdesign.search.compare.recommend import Bound, Wanted

    outcomes = any_outcomes(designs, deep=deep)
    wanted = (Wanted("stick_error", "min"), Wanted("cost", "min"))
    bounds = (Bound("peak_ratio", at_most=2.5),)
    return compare_html(outcomes, facts_of("made up", outcomes, wanted, bounds))


def _measured(text: str, designs: int, kind: str, times: int) -> PageMeasured:
    seen: list[PageTimes] = []
    requests: list[str] = []
    console: list[str] = []
    # Helpers of a browser that has been closed may still write into its profile.
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        page = Path(folder) / "compare.html"
        page.write_text(text, encoding="utf-8")
        for number in range(times):
            with Browser(page, Path(folder) / str(number)) as browser:
                seen.append(_times(browser))
                requests += browser.requests
                console += browser.console
    size = len(text.encode()) / 1e6
    return PageMeasured(designs, kind, size, tuple(seen), tuple(requests), tuple(console))


def _times(browser: Browser) -> PageTimes:
    browser.evaluate(_PAINTED)
    opened = browser.busy_s()
    begun = time.monotonic()
    browser.evaluate(_CHART)
    chart_s, chart_busy_s = browser.opened_s + time.monotonic() - begun, browser.busy_s()
    clock, busy = [], []
    for column in _COLUMNS:
        before = browser.busy_s()
        clock.append(float(browser.evaluate(_SORT.replace("{column}", str(column)))))
        busy.append(browser.busy_s() - before)
    return PageTimes(browser.opened_s, opened, chart_s, chart_busy_s, max(clock), max(busy))
