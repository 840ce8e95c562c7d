"""Moves of sliders in a real Chromium, timed from the slider to the picture.

The processor time of the studio's process and of the page's thread is measured too: it is the cost
of the studio on a machine that others use.
"""

import subprocess
import sys
from contextlib import contextmanager
from dataclasses import dataclass

import psutil

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
