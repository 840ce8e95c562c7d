"""Moves of sliders in a real Chromium, timed from the slider to the picture.

    python tests/support/studio.py [DESIGN]

Beside the clock's time stands the processor time that the studio's process and the page's thread
took: on a machine that others use it alone says what the studio costs.
"""

import subprocess
import sys
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import psutil

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.support.browser import Browser

OBJECT = [("friction", 0.3 + 0.02 * k) for k in range(8)]
OBJECT += [("shear", 0.02 + 0.01 * k) for k in range(6)]
OBJECT += [("approach", 0.08 + 0.02 * k) for k in range(6)]
FINGER = [("plates.angle_deg", 30.0 + 2 * k) for k in range(8)]
FINGER += [("plates.cover_mm", 0.8 + 0.03 * k) for k in range(6)]
FINGER += [("body.width_mm", 21.0 + 0.4 * k) for k in range(6)]
READY = "Number(document.querySelector('.studio')?.dataset.stamp) > 0"
# Until the numbers have changed and the browser has drawn twice since.
_MOVE = """(async () => {
  const page = document.querySelector('.studio'), was = page.dataset.stamp;
  const slider = document.querySelector('[data-key="%s"]');
  const begin = performance.now();
  slider.value = %s;
  slider.dispatchEvent(new Event('input'));
  while (page.dataset.stamp === was) await new Promise(requestAnimationFrame);
  for (let k = 0; k < 2; k += 1) await new Promise(requestAnimationFrame);
  return performance.now() - begin;
})()"""


@dataclass(frozen=True)
class Times:
    """Of each move, s: by the clock; of processors, the studio's and the page's thread's."""

    clock: list[float]
    busy: list[float]

    def words(self, name: str) -> str:
        """95th percentiles."""
        clock, busy = (1e3 * float(np.quantile(each, 0.95)) for each in (self.clock, self.busy))
        count = f"95th percentile of {len(self.clock)}"
        return f"{name}: {clock:.0f} ms by the clock, {busy:.0f} ms of processors ({count})"


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


def used_s(process):
    """Processor time of a process and all that it started, s."""
    family = [process, *process.children(recursive=True)]
    return sum(sum(each.cpu_times()[:2]) for each in family if each.is_running())


def moved(browser, process, moves):
    """Times of moves, one after another."""
    family, clock, busy = psutil.Process(process.pid), [], []
    for key, value in moves:
        begin = used_s(family) + browser.busy_s()
        clock.append(1e-3 * browser.evaluate(_MOVE % (key, value)))
        busy.append(used_s(family) + browser.busy_s() - begin)
    return Times(clock, busy)


def memory_MB(process):
    """Resident memory of the studio's processes, MB."""
    family = psutil.Process(process.pid)
    return sum(each.memory_info().rss for each in [family, *family.children(recursive=True)]) / 1e6


def _show(arguments, work):
    with (
        running(*arguments, folder=work) as (process, address),
        Browser(address, work) as browser,
    ):
        browser.wait(READY, 120)
        moved(browser, process, [("friction", 0.9), ("friction", 0.8)])
        print(moved(browser, process, OBJECT).words("approach, shear, friction"))
        print(moved(browser, process, FINGER).words("the finger"))
        print(f"memory of the studio: {memory_MB(process):.0f} MB")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        _show(sys.argv[1:], Path(folder))
