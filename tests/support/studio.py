"""The studio's process, and moves of its sliders in a real Chromium."""

import subprocess
import sys
from contextlib import contextmanager

import psutil

READY = "Number(document.querySelector('.studio')?.dataset.stamp) > 0"
# Until the numbers have changed and the browser has drawn twice since.
_MOVE = """(async () => {
  const page = document.querySelector('.studio'), was = page.dataset.stamp;
  const slider = document.querySelector('[data-key="%s"]');
  slider.value = %s;
  slider.dispatchEvent(new Event('input'));
  while (page.dataset.stamp === was) await new Promise(requestAnimationFrame);
  for (let k = 0; k < 2; k += 1) await new Promise(requestAnimationFrame);
})()"""


@contextmanager
def running(*arguments, folder):
    """The studio's process and its address, while the block lasts."""
    command = [sys.executable, "-m", "fingerdesign_cli.main", "studio", *arguments, "--no-open"]
    with (folder / "err.txt").open("w") as err:
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=err, text=True, cwd=folder
        )
    try:
        line = process.stdout.readline()
        assert line.startswith("studio: http://127.0.0.1:"), (folder / "err.txt").read_text()
        yield process, line.removeprefix("studio: ").strip()
    finally:
        process.terminate()
        try:
            process.wait(30)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()


def moved(browser, key, value):
    """Move a slider, and wait for an answer."""
    browser.evaluate(_MOVE % (key, value))


def memory_MB(process):
    """Resident memory of the studio's processes, MB."""
    family = psutil.Process(process.pid)
    return sum(each.memory_info().rss for each in [family, *family.children(recursive=True)]) / 1e6
