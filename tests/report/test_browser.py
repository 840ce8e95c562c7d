"""The report in a real browser, from file://: no console message, no request, nothing cut off."""

import json
import shutil
import subprocess

import pytest

from fingerdesign.analysis.page.page import write_report

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium on this machine: the report is not opened in a browser"
)


def visit(page, work):
    """Console messages, addresses that the page asked for, and the page as the browser has it."""
    log = work / "net.json"
    done = subprocess.run(
        [
            *(str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"),
            *("--disable-background-networking", "--disable-component-update", "--no-first-run"),
            *("--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={work / 'profile'}"),
            *(f"--log-net-log={log}", "--enable-logging=stderr", "--v=0", "--dump-dom"),
            page.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    events = json.loads(log.read_text(encoding="utf-8"))["events"]
    # The browser's own errands (updates, the time) have no origin; those of a page have one.
    requested = {
        event["params"]["url"]
        for event in events
        if event.get("params", {}).get("initiator", "not an origin") != "not an origin"
        and "url" in event["params"]
    }
    return console, requested, done.stdout


def test_the_watch_sees_errors_and_requests(tmp_path):
    page = tmp_path / "bad.html"
    page.write_text(
        '<img src="http://127.0.0.1:9/x.png"><script>noSuchFunction()</script>', encoding="utf-8"
    )
    console, requested, _ = visit(page, tmp_path)
    assert "noSuchFunction" in "".join(console)
    assert requested == {"http://127.0.0.1:9/x.png"}


def test_report_opens_in_silence(solid, tmp_path):
    console, requested, shown = visit(write_report(solid, tmp_path), tmp_path)
    assert console == []
    assert requested == set()
    assert shown.count("<svg") == 12
    assert "The finger deformed as in increment 8" in shown
