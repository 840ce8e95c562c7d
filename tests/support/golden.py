"""Golden records: what the command line writes, recorded to show that a change changed nothing.

    python tests/support/golden.py record --tree CHECKOUT --out DIR [--only NAME ...] [--jobs N]
    python tests/support/golden.py compare OLD_DIR NEW_DIR [--numbers]

``record`` runs every case in a folder of its own with a fresh cache, so that none leans on another,
on an older run or on the caches of whoever runs it. Of each call it records the exit code and what
was printed; of each file written what must come again: text without times, folders and versions,
the digest of all else. ``compare`` (golden_compare.py) shows what differs and exits with 1 if
anything does. Run it with a Python that has the program's dependencies. Libraries run on one
thread: sums keep their order.
"""

import argparse
import base64
import contextlib
import csv
import gzip
import hashlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.support.golden_compare import differences

FINGER = """
[design]
name = "{name}"
[body]
shape = "{shape}"
depth_mm = 8.0
[plates]
count = {count}
material = "polyimide"
[mesh]
mesher = "sweep"
contact_size_mm = 0.7
plate_size_mm = 0.7
far_size_mm = 3.0
layers = 2
[mesh.section]
contact_size_mm = 0.15
plate_size_mm = 0.15
plate_end_size_mm = 0.06
far_size_mm = 1.5
gradation = 0.4
[grip]
friction_coefficients = [0.3, 0.8]
object_mass_g = 150.0
max_approach_mm = 0.5
[grip.regulator]
taught_grips = 60
taught_fingers = 1
"""
STUDY = """
[study]
name = "few"
base = "finger.toml"
count = 2
seed = 1
[parameters]
"body.arc_radius_mm" = { low = 20.0, high = 40.0 }
"plates.count" = { low = 5, high = 9, step = 2 }
[[objectives]]
metric = "stick_error"
[[objectives]]
metric = "cost"
goal = "min"
[optimise]
confirm = 1
"""
SCENE = """
[object]
shape = "cylinder"
radius_mm = 30.0
axis = "z"
friction_coefficient = 0.4
[path]
increments_mm = [[0.05, 0.0], [0.1, 0.0], [0.1, 0.03], [0.1, 0.06]]
[readout]
points_mm = [[0.0, 9.0, 0.0]]
"""
TRACE = "time_s,dx_mm,dy_mm,normal_force_N,tangential_force_N," + ",".join(
    f"gage_{n}" for n in range(1, 8)
)
ROWS = [
    f"{0.01 * k:.2f},{0.004 * (k > 9):.3f},{0.01 * (k < 10):.2f},{0.3 * min(k + 1, 10):.2f},"
    f"{0.1 * max(k - 9, 0):.2f}," + ",".join(f"{(n - 3) * 0.5 + 0.8 * k:.2f}" for n in range(7))
    for k in range(20)
]
INPUTS = {  # written into the folder of every case
    "finger.toml": FINGER.format(name="finger", shape="arc", count=7),
    "bare.toml": FINGER.format(name="bare", shape="arc", count=0),
    "tetwild.toml": FINGER.format(name="tetwild", shape="arc", count=3).replace("sweep", "tetwild"),
    "few.toml": STUDY,
    "scene.toml": SCENE,
    "trace.csv": "\n".join([TRACE, *ROWS, ""]),
    "wrong.toml": "[body]\nwidht_mm = 3.0\narc_radius_mm = 2.0\n[plates]\ncount = 99\n",
    "broken.toml": "[body\n",
    "wrong_study.toml": STUDY.replace("body.arc", "body.ark").replace("cost", "coast"),
    "wrong_scene.toml": SCENE.replace("cylinder", "cone").replace("0.4", "-1"),
    "torn.csv": "\n".join([TRACE, *ROWS[:3], ROWS[4].replace("0.30", "nan"), "1,2", ""]),
}
# Cheap ones first. The calls of a case share its folder and its cache.
CASES: dict[str, tuple[str, ...]] = {
    "help": ("--help", "--version"),  # and, found there, the --help of every command
    "wrong": (
        "analyse wrong.toml --out out",
        "analyse maeno2001 --out out",
        "analyse broken.toml --out out",
        "analyse maeno2000 --out finger.toml",
        "analyse finger.toml --out out --scene wrong_scene.toml --fidelity plane-strain",
        "check wrong.toml broken.toml finger.toml --json",
        "check finger.toml --scene wrong_scene.toml",
        "grip maeno2000 --out out --controller papre",
        "grip maeno2000 --out out --friction -1",
        "mesh finger.toml --out out --format doc",
        "validate maeno2000 --out out --only nothing",
        "identify finger.toml torn.csv --out out",
        "teach maeno2000 --out out --workers 0",
        "gages bare.toml --out out",
        "generate wrong_study.toml --out out",
        "sweep wrong_study.toml --out out",
        "optimise none.toml --out out",
        "compare . --out out.html",
        "view .",
        "new finger.toml",
        "study-control bare.toml --out out",
        "mold bare.toml --out out --process wax",
        "analyze maeno2000",
    ),
    "check": ("check maeno2000 domed sensitive finger.toml --json", "check narrow --scene edge"),
    "new": (
        "new mine.toml",
        "new other.toml --from maeno2000",
        "new ball.toml --scene --from ball",
        "check mine.toml --quiet",
    ),
    "mesh": (
        "mesh finger.toml --out flat --fidelity plane-strain --format vtu --format vtk "
        "--format xdmf --format msh --format inp --format mdpa",
        "mesh finger.toml --out solid --no-picture --format vtu --format msh --json",
    ),
    "analyse": (
        "analyse maeno2000 sensitive --out out --fidelity plane-strain --json",
        "compare out --out compare.html --csv compare.csv --json compare.jsonl",
        "view out",
        "view out/maeno2000 --json",
    ),
    "scenes": (
        "analyse narrow --out pull --scene pull --fidelity plane-strain",
        "analyse finger.toml --out scene --scene scene.toml --fidelity plane-strain",
        "analyse finger.toml --out auto --scene scene.toml --fidelity auto --tolerance 0.2 --json",
    ),
    "solid": (
        "analyse finger.toml --out out",
        "analyse bare.toml --out out --scene scene.toml --json",
    ),
    "grip": ("grip maeno2000 --out out --friction 0.3 --friction 0.6 --json",),
    "control": (
        "teach finger.toml --out taught --workers 1",
        "grip finger.toml --out grip --controller regulator "
        "--estimator taught/finger/estimator.json",
        "study-control finger.toml --out study --quick --workers 1 "
        "--estimator taught/finger/estimator.json",
    ),
    "validate": (
        "validate finger.toml --out out --only poissons_ratio --only gage_point "
        "--only small_strain --only sheets",
    ),
    "generate": ("generate few.toml --out out --workers 1",),
    "sweep": (
        "sweep few.toml --out out --workers 1",
        "sweep few.toml --out out --workers 1 --json",
        "compare out/few --out compare.html --json",
    ),
    "optimise": ("optimise few.toml --out out --trials 3 --workers 1",),
    "mold": ("mold maeno2000 --out out", "mold maeno2000 --out slots --fixture slots --json"),
    "gages": ("validate finger.toml --gages --out out --grips 40 --workers 1",),
    "paper": ("paper --design finger.toml --out out",),
    "tetwild": ("analyse tetwild.toml --out out --scene scene.toml",),
    "tune": ("tune tetwild.toml --out out --controller fixed_force --workers 1",),
    "bench": ("bench suite --quick", "bench stability --quick --out stable"),
}
# Keys and columns of the moment or of the machine, in JSON and CSV; their values are left out.
MOMENT = {
    *("timings_s", "seconds", "better_seconds", "seconds_by_method", "seconds_left", "time_s"),
    *("wall_s", "cpu_s", "core_s", "core_seconds", "saving", "datetime_start", "datetime_complete"),
    *("peak_memory_MB", "memory_MB", "versions", "machine", "worker_id"),
}
WORDS = (  # of the moment, in texts and pages
    (re.compile(r"\b\d[\d.,]*([ \xa0]|&nbsp;)(core )?(s|MB|seconds?)\b"), r"N \3"),
    (re.compile(r"saves a factor [\d.]+"), "saves a factor N"),
    (re.compile(r"^\S+: \d+ of \d+(, N s left)?\n", re.M), ""),  # printed when the clock says so
    (re.compile(r"on \d+ cores?, one of which .*?(?=[\"\n<]|$)"), "on this machine"),
    (re.compile(r"\d{4}-\d\d-\d\d([T ]\d\d:\d\d(:\d\d(\.\d+)?)?Z?)?"), "DATE"),
    (re.compile(r"\b([a-z][a-z0-9-]+) \d+\.\d+\.\d+\b"), r"\1 VERSION"),
)
TIME_HEADINGS = {  # of tables' columns
    *("s", "better s", "saves", "saving", "seconds", "core seconds", "time (s)")
}
UUID = re.compile(rb"[0-9a-fA-F]{8}(-[0-9a-fA-F]{4}){3}-[0-9a-fA-F]{12}")


def without_moment(value):
    """JSON's value without what is of the moment: by key, and by words in its texts."""
    if isinstance(value, dict):
        return {k: "MOMENT" if k in MOMENT else without_moment(v) for k, v in value.items()}
    if isinstance(value, list):
        return [without_moment(each) for each in value]
    return worded(value) if isinstance(value, str) else value


def worded(text):
    """A text without numbers of seconds, dates and versions; tables without their times."""
    for pattern, instead in WORDS:
        text = pattern.sub(instead, text)
    return "\n".join(table_lines(text.split("\n")))


def table_lines(lines):
    """Lines of text; tables without times and without the padding and folds that hang on them."""
    timed: set[int] = set()
    plain: list[str] = []
    for line in lines:
        first = line[:1] or " "
        if first == "┏":  # lines before it that are as wide are its title, folded
            title: list[str] = []
            while plain and len(plain[-1]) == len(line):
                title.insert(0, plain.pop().strip())
            plain.append(" ".join(title))
        elif first in "┃│":
            yield from (each.rstrip() for each in plain)
            plain = []
            cells = [cell.strip() for cell in re.split("[┃│]", line)[1:-1]]
            if first == "┃":
                timed = {place for place, cell in enumerate(cells) if cell in TIME_HEADINGS}
            cells = ["N" if place in timed else cell for place, cell in enumerate(cells)]
            plain.append(" | ".join(cells))
        elif first not in "┡└":
            plain.append(line)
    yield from (line.rstrip() for line in plain)


def digest(data):
    """What is recorded of bytes."""
    return f"{len(data)} bytes, SHA-256 {hashlib.sha256(data).hexdigest()}\n"


def json_recorded(text):
    """A JSON text without the moment."""
    return json.dumps(without_moment(json.loads(text)), indent=1, sort_keys=True) + "\n"


def lines_recorded(text):
    """Lines of JSON, each without the moment."""
    return "".join(json_recorded(line) for line in text.splitlines())


def printed(text):
    """What a call printed: JSON, lines of JSON, or words."""
    for reading in (json_recorded, lines_recorded):
        with contextlib.suppress(ValueError):
            return reading(text) if text[:1] in ("{", "[") else worded(text)
    return worded(text)


def csv_recorded(text):
    """A table of values without columns of the moment."""
    rows = list(csv.reader(text.splitlines()))
    timed = {place for place, head in enumerate(rows[0] if rows else []) if head in MOMENT}
    cells = (["N" if k and n in timed else c for n, c in enumerate(r)] for k, r in enumerate(rows))
    return worded("".join(",".join(row) + "\n" for row in cells))


def html_recorded(text):
    """A page, a tag a line: images as digests, data opened, tables and charts without times."""

    def image(found):
        return "base64," + digest(base64.b64decode(found[1]))[:-1]

    def packed(found):
        data = gzip.decompress(base64.b64decode(found[2])).decode()
        name = re.search(r'data-name="[^"]*(\.\w+)"', found[1])
        return f"{found[1]}{TEXTS.get(name[1], str)(data) if name else printed(data)}</script>"

    text = re.sub(r"base64,([A-Za-z0-9+/=]+)", image, text)
    text = re.sub(r"(<script[^>]*>)(H4sI[A-Za-z0-9+/=]+)</script>", packed, text)
    text = re.sub(
        r"(<script[^>]*application/json[^>]*>)(.*?)(?=</script>)",
        lambda found: found[1] + printed(found[2].strip()),
        text,
        flags=re.S,
    )
    text = re.sub(r"<table.*?</table>", lambda found: untimed(found[0]), text, flags=re.S)
    text = re.sub(r"<svg(?:(?!</svg>).)*#time-.*?</svg>", "CHART OF TIMES", text, flags=re.S)
    return worded(re.sub(r"(?<=>)(?=<)", "\n", text))


def untimed(table):
    """A page's table with the cells of its columns of times left empty."""
    heads = re.findall(r'<th scope="col".*?</th>', table, re.S)
    words = [" ".join(re.sub("<.*?>", "", head).split()) for head in heads]
    timed = {place for place, head in enumerate(words) if head in TIME_HEADINGS}
    rows = []
    for row in re.split(r"(?=<tr)", table):
        cells = re.split(r"(?=<t[dh][ >])", row)
        rows += ["<td>N</td>" if n - 1 in timed else c for n, c in enumerate(cells)]
    return "".join(rows)


def step_recorded(text):
    """A STEP file's digest: its statements without numbers and date, for their order varies."""
    text = re.sub(r"'\d{4}-\d\d-\d\dT[\d:]+'", "'DATE'", text)
    statements = (re.sub(r"#\d+|\s+", "", each) for each in text.split(";"))
    return digest(";".join(sorted(statements)).encode())


def dxf_recorded(text):
    """A DXF file's digest, its times and random names left out."""
    text = re.sub(r"(\$TD\w+\s+40\s+)\S+", r"\1TIME", text)
    text = re.sub(r"\{[0-9A-F-]{36}\}", "{GUID}", text)
    return digest(re.sub(r"\d{4}-\d\d-\d\dT\S+", "DATE", text).encode())


TEXTS: dict[str, Callable[[str], str]] = {
    **{".json": json_recorded, ".jsonl": lines_recorded, ".csv": csv_recorded},
    **{".html": html_recorded, ".step": step_recorded, ".dxf": dxf_recorded},
    **{".txt": worded, ".toml": str, ".md": worded},
}


def recorded(path, places):
    """What of a written file must be the same again."""
    if path.suffix == ".3mf":
        with zipfile.ZipFile(path) as archive:
            parts = sorted(archive.namelist())
            texts = {part: UUID.sub(b"UUID", archive.read(part)) for part in parts}
            return "".join(f"{part}: {digest(text)}" for part, text in texts.items())
    if path.suffix not in TEXTS:
        return digest(path.read_bytes())
    text = placed(path.read_text("utf-8", "replace"), places)
    try:
        return TEXTS[path.suffix](text)
    except ValueError:  # it is not what its ending says
        return worded(text)


def placed(text, places):
    """A text with the run's folders replaced by names."""
    for folder, name in places.items():
        text = text.replace(folder, name)
    return text


def run_case(tree, name, target):
    """Run a case of a checkout, record in ``target`` what it wrote; report what each call took."""
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    with tempfile.TemporaryDirectory(prefix="golden-") as home:
        work, cache = Path(home, "work"), Path(home, "cache")
        work.mkdir(exist_ok=True)
        for file, text in INPUTS.items():
            (work / file).write_text(text, "utf-8")
        places = {str(work): "WORK", str(cache): "CACHE", str(tree): "TREE"}
        calls, took = list(CASES[name]), []
        for number, call in enumerate(calls, 1):
            begun = time.monotonic()
            done = run_call(tree, call, work, cache)
            took.append(f"{time.monotonic() - begun:.0f}")
            out, err = (each if name == "help" else printed(each) for each in done[1:])
            text = f"$ fingerdesign {call}\nexit code {done[0]}\n{out}\n--- stderr\n{err}"
            (target / f"call_{number:02}.txt").write_text(placed(text, places), "utf-8")
            if name == "help":  # the help of each command that is found
                before = call.removesuffix("--help")
                found = re.findall(r"^  ([a-z][a-z-]+)  +\S", done[1], re.M)
                calls += [f"{before}{command} --help" for command in found]
        for path in sorted(work.rglob("*")):
            inside = path.relative_to(work)
            if path.is_file() and str(inside) not in INPUTS:
                record_file = target / "files" / f"{inside}.txt"
                record_file.parent.mkdir(parents=True, exist_ok=True)
                record_file.write_text(recorded(path, places), "utf-8")
    return f"{name}: {' + '.join(took)} s"


def run_call(tree, call, work, cache):
    """Run the command line of a checkout: exit code, stdout, stderr."""
    single = ("MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
    environment = os.environ | dict.fromkeys(single, "1")
    environment |= {
        "PYTHONPATH": os.pathsep.join(str(tree / each) for each in (".", "cli", "benchmarks")),
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONHASHSEED": "0",
        "FINGERDESIGN_CACHE": str(cache),
        "COLUMNS": "200",
    }
    done = subprocess.run(
        [sys.executable, "-m", "fingerdesign_cli.main", *shlex.split(call)],
        cwd=work,
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


def record(tree, out, names, jobs):
    """Run cases of a checkout; also record the schemas that it ships, wherever they lie."""
    tree = tree.resolve()
    schemas = out / "schemas"
    shutil.rmtree(schemas, ignore_errors=True)
    schemas.mkdir(parents=True)
    for path in (tree / "fingerdesign").rglob("*.schema.json"):
        (schemas / f"{path.name}.txt").write_text(path.read_text("utf-8"), "utf-8")
    with ThreadPoolExecutor(jobs) as pool:
        for line in pool.map(lambda name: run_case(tree, name, out / name), names):
            print(line, flush=True)


def main():
    """Record or compare; 1 where something differs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    recording = commands.add_parser("record", help="run the cases of a checkout")
    recording.add_argument("--tree", type=Path, required=True, help="the checkout")
    recording.add_argument("--out", type=Path, required=True, help="the record's folder")
    recording.add_argument("--only", nargs="+", default=list(CASES), choices=list(CASES))
    recording.add_argument("--jobs", type=int, default=1, help="cases at a time")
    comparing = commands.add_parser("compare", help="show what differs between two records")
    comparing.add_argument("folders", type=Path, nargs=2, metavar="DIR")
    words = "values of JSON, CSV and TOML, exit codes, digests of geometry; no words and pages"
    comparing.add_argument("--numbers", action="store_true", help=words)
    given = parser.parse_args()
    if given.command == "record":
        record(given.tree, given.out, given.only, given.jobs)
        return 0
    found = list(differences(*given.folders, given.numbers))
    print("\n".join(found) or "nothing differs")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
