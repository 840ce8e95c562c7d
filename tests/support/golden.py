"""Golden records: what commands print and write, recorded so that a change of any of it is seen.

    def test_pages(golden, tmp_path):
        ...
        golden("pages", tmp_path / "out", printed)

``golden(name, *things)`` compares folders, files, texts and values with ``tests/golden/name.txt``.
Words must be equal; numbers may differ by three thousandths or by one of the last digit shown, for
other processors round otherwise. Times, versions and folders are left out. Of long arrays the
record has their size, mean, deviation, a mean weighted by place, which sees order, least, largest.
``GOLDEN=renew make every-test`` writes the records anew: read what changed before you commit it.
"""

import base64
import contextlib
import csv
import difflib
import gzip
import json
import os
import re
import tempfile
import zipfile
from collections import Counter, defaultdict
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

RECORDS = Path(__file__).resolve().parents[1] / "golden"
SHARE, LEAST = 3e-3, 1e-9  # numbers are equal that differ by less of the larger, or by less
# A node at the border of stick and slip goes either way by rounding, here and on another processor;
# with it go a thousandth of a reading, and a half of how far two paths are apart.
ESTIMATE, ESTIMATE_SHARE = "path_error.", 0.5
ARRAY = "~ "  # before the line of an array, whose largest number is the scale of all
NOTHING = 1e-9  # what is less than this of an array's largest value is noise
LONG = 8  # arrays of more numbers are recorded by their measures
COPIES = ("design.toml", "design.schema.json", "scene.schema.json", "study.schema.json")
FEW = 3  # more alike objects are recorded by their columns
MOMENT = re.compile(  # keys and columns, by their dotted place
    r"(^|\.)(timings?_s|(better_|core_)?seconds.*|saving|saves|(wall|cpu|core)_s|s|better s"
    r"|core seconds|time \(s\)|datetime_.*|(peak_)?memory_MB|machine|versions?|worker_id|digest"
    r"|commit|date|created|.*evaluations|iterations)$|forecast.*time_s$"
)
WORDS = (  # of the moment, in texts and pages
    (re.compile(r"\b\d[\d.,]*(?: to [\d.,]+)?[ \xa0](core[ -])?(s|MB|GB|min|seconds?)\b"), r"T \2"),
    (re.compile(r"\d{4}-\d\d-\d\d([T ]\d\d:\d\d(:\d\d(\.\d+)?)?Z?)?"), "DATE"),
    (re.compile(r"\b([a-z][a-z0-9-]+) \d+\.\d+\.\d+\b"), r"\1 VERSION"),
    (re.compile(r"\{?[0-9a-fA-F]{8}(-[0-9a-fA-F]{4}){3}-[0-9a-fA-F]{12}\}?"), "UUID"),
    (re.compile(r"\b(?=\d*[a-f])(?=[a-f]*\d)[0-9a-f]{12,64}\b"), "DIGEST"),
    (re.compile(r"saves (a factor [\d.]+|nothing)"), "saves N"),
    (re.compile(r"plate_\d+ \(worst"), "plate_N (worst"),  # where none is bad
    (re.compile(r"matrices at \d+ GFLOP/s( now \(it is busy\))?"), "matrices at N GFLOP/s"),
    (re.compile(r"((?:plane-strain|3d|finite)\b.*│)[^│\n]*│$", re.M), r"\1 T │"),  # a forecast
    (re.compile(re.escape(tempfile.gettempdir()) + r"(/[\w.+\[\]-]+)*/"), "FOLDER/"),
)
PLACES = (*("d", "points", "x", "y", "x1", "x2", "y1", "y2", "cx", "cy", "r"), "width", "height")
NUMBER = re.compile(r"(?<![\w.])[-+−]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


@pytest.fixture
def golden():
    """``golden(name, *things)``: compare with the record of that name, or write it anew."""

    def compare(name, *things):
        text = "\n".join(line for each in things for line in lines_of(each)) + "\n"
        path = RECORDS / f"{name}.txt"
        if os.environ.get("GOLDEN") == "renew":
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
        found = differences(path.read_text(encoding="utf-8").splitlines(), text.splitlines())
        assert not found, "\n".join([f"{path.name}: {len(found)} lines differ", *found[:20]])

    return compare


def differences(old, new):
    """List the lines that differ by more than rounding, with "-" before the recorded ones."""
    if len(old) == len(new):
        pairs = [(a, b) for a, b in zip(old, new, strict=True) if not alike(a, b)]
        return [f"- {a[:200]}\n+ {b[:200]}" for a, b in pairs]
    bare = [[NUMBER.sub("#", line) for line in lines] for lines in (old, new)]
    return [line[:200] for line in difflib.unified_diff(*bare, n=0, lineterm="")][2:]


def alike(a, b):
    """True of lines with the same words and the same numbers, but for rounding."""
    if a == b:
        return True
    if NUMBER.split(a) != NUMBER.split(b):
        return False
    pairs = list(zip(NUMBER.findall(a), NUMBER.findall(b), strict=True))
    numbers = [float(each.replace("−", "-")) for pair in pairs for each in pair if "." in each]
    scale = max(map(abs, numbers), default=0.0) if a.startswith(ARRAY) else 0.0
    share = ESTIMATE_SHARE if a.startswith(ESTIMATE) else SHARE
    return all(_near(one, other, scale, share) for one, other in pairs)


def _near(a, b, scale, share):
    one, other = (float(each.replace("−", "-")) for each in (a, b))
    if "." not in a + b:
        return abs(one - other) <= LEAST
    digit = 1.01 * max(map(_last_digit, (a, b)))
    return abs(one - other) <= share * max(abs(one), abs(other), scale) + digit + LEAST


def _last_digit(number):
    """What one of the last digit that is shown is worth."""
    mantissa, _, power = number.lower().partition("e")
    return 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))


def lines_of(thing, name=""):
    """List the recorded lines of a folder, a file, a text or a value."""
    if isinstance(thing, Path) and thing.is_dir():
        files = sorted(each for each in thing.rglob("*") if each.is_file())
        return [line for each in files for line in _file(each, str(each.relative_to(thing)))]
    if isinstance(thing, Path):
        return _file(thing, thing.name)
    return worded(thing).splitlines() if isinstance(thing, str) else flat(thing, name)


def worded(text):
    """A text without times, dates, versions, digests and folders; its tables without padding."""
    for pattern, instead in WORDS:
        text = pattern.sub(instead, text)
    lines = (re.sub(r"[ ─━]{2,}", "  ", line).rstrip() for line in text.splitlines())
    return "\n".join(line for line in lines if line)


def flat(value, place=""):
    """List a value's parts, a line each, by their dotted place; of many alike, by their column."""
    if MOMENT.search(place):
        return []
    if isinstance(value, dict):
        return [x for k, each in value.items() for x in flat(each, f"{place}.{k}".strip("."))]
    if isinstance(value, list | tuple | np.ndarray):
        return _listed(value, place)
    text = shown(value) if isinstance(value, float) else worded(str(value))
    return [f"{place}: {text}"]


def _listed(values, place):
    numbers = _array(values)
    if numbers is not None and numbers.size > LONG:
        return [f"{ARRAY}{place}: {measures(numbers)}"]
    if numbers is not None:
        return [f"{ARRAY}{place}: {' '.join(shown(each) for each in numbers.ravel())}"]
    if all(isinstance(each, str | bool | int | float | None) for each in values):
        words = [worded(str(each)) for each in values]
        if len(words) > LONG:
            words = [f"{count} x {word}" for word, count in Counter(words).items()]
        return [f"{place}: {' | '.join(words)}"]
    if len(values) > FEW and all(isinstance(each, dict) for each in values):
        keys = dict.fromkeys(key for each in values for key in each)
        columns = {k: [each[k] for each in values if k in each] for k in keys}
        return flat(columns, f"{place}[{len(values)}]")
    if len(values) > FEW and all(isinstance(each, list | tuple) for each in values):
        joined = [x for each in values for x in each]  # of unequal lengths
        return flat(joined, f"{place}[{len(values)}]")
    return [x for k, each in enumerate(values) for x in flat(each, f"{place}.{k}")]


def _array(value):
    """A list as an array of numbers, None as NaN; None where it is no array of numbers."""
    try:
        numbers = np.array(value)
        if numbers.dtype == object:
            numbers = np.array(value, dtype=float)
    except (ValueError, TypeError):
        return None
    return numbers.astype(float) if numbers.dtype.kind in "biuf" and numbers.size else None


def shown(value):
    """A number by its first digits."""
    return "0" if abs(value) < 1e-12 else f"{float(value):#.5g}"


def measures(numbers):
    """The size of an array, mean, deviation, ends, and a mean that is weighted by place."""
    numbers = np.asarray(numbers, dtype=float)
    here = np.isfinite(numbers.ravel())
    flat_numbers = numbers.ravel()[here]
    if not flat_numbers.size:
        return f"{numbers.shape} none"
    weights = np.cos(0.7 * np.sqrt(np.flatnonzero(here)))
    ends = flat_numbers.min(), flat_numbers.max()
    means = flat_numbers.mean(), flat_numbers.std(), (weights * flat_numbers).mean()
    noise = NOTHING * np.abs(flat_numbers).max()
    words = (shown(0.0 if abs(each) < noise else each) for each in (*means, *ends))
    missing = f" {np.count_nonzero(~here)} missing" if not here.all() else ""
    return f"{numbers.shape}{missing} {' '.join(words)}"


def _file(path, name):
    """The lines of a file, under a line with its name."""
    reader = None if path.name in COPIES else READERS.get(path.suffix)
    return [f"== {name}", *(reader(path) if reader else [])]


def _text(path):
    return worded(path.read_text(encoding="utf-8", errors="replace")).splitlines()


def _json(path):
    return flat(json.loads(path.read_text(encoding="utf-8")))


def _json_lines(path):
    return flat([json.loads(each) for each in path.read_text(encoding="utf-8").splitlines()])


def _csv(path):
    rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
    found = []
    for head, *column in zip(*rows, strict=True):
        with contextlib.suppress(ValueError):
            column = [float(cell) if cell else None for cell in column]
        found += flat(column, head)
    return found


def _numbers(path):
    """Of a text that is mostly numbers: its lines of words, and the measures of its numbers."""
    text = worded(path.read_text(encoding="utf-8", errors="replace"))
    lines = [line for line in text.splitlines() if re.search("[A-Za-z]{3}", line)]
    numbers = [float(each) for each in NUMBER.findall(text)]
    return [*lines[:200], ARRAY + measures([each for each in numbers if abs(each) < 1e15])]


def _arrays(path):
    with np.load(path) as arrays:
        numbers = {name: arrays[name] for name in sorted(arrays.files)}
    return [f"{ARRAY}{k}: {measures(v)}" for k, v in numbers.items() if v.dtype.kind in "biuf"]


def _grid(path):
    import pyvista

    grid = pyvista.read(path)
    own = {"points": grid.points, **grid.point_data, **grid.cell_data}
    return [f"{ARRAY}{k}: {measures(np.asarray(v))}" for k, v in sorted(own.items()) if len(v)]


def _surface(path):
    import trimesh

    solid = trimesh.load_mesh(path)
    sizes = (solid.volume, solid.area, *solid.bounds.ravel())
    return [" ".join(shown(round(float(each), 6)) for each in sizes)]


def _zip(path):
    with zipfile.ZipFile(path) as archive, tempfile.TemporaryDirectory() as folder:
        archive.extractall(folder)
        return lines_of(Path(folder))


class _Page(HTMLParser):
    """The words of a page and its data; of each drawing its words, and measures of its lines."""

    def __init__(self):
        super().__init__()
        self.lines = []
        self._inside, self._group, self._words = "", "", None
        self._drawn = defaultdict(list)

    def handle_starttag(self, tag, attrs):
        self._inside = tag
        given = {key: value or "" for key, value in attrs}
        if tag == "svg" and self._words is None:
            self._words = []
        if self._words is not None:
            self._group = (
                re.sub(r"([_-]?\d+|\b[mp][0-9a-f]{8,})$", "", given.get("id", "")) or self._group
            )
            for key, value in given.items():
                if key in PLACES:
                    numbers = map(float, NUMBER.findall(value))
                    self._drawn[f"{self._group} {tag} {key}"] += numbers
        for key in ("title", "aria-label", "alt", "value", "min", "max", "step", "href"):
            if given.get(key, "data:")[:5] not in ("data:", "#"):
                self.lines.append(f"{tag} {key}: {given[key]}")

    def handle_endtag(self, tag):
        if tag == "svg" and self._words is not None:
            self.lines.append(" | ".join(self._words))
            self.lines += [f"{ARRAY}{k}: {measures(v)}" for k, v in self._drawn.items() if v]
            self._words = None
            self._drawn.clear()

    def handle_data(self, data):
        data = data.strip()
        if self._inside == "style" or not data:
            return
        if self._inside != "script":
            (self.lines if self._words is None else self._words).append(data)
            return
        if data.startswith("H4sI"):
            data = gzip.decompress(base64.b64decode(data)).decode().strip()
        if data[0] in "{[":
            documents = [json.loads(each) for each in data.splitlines()]
            self.lines += flat(documents[0] if len(documents) == 1 else documents)


def _page(path):
    page = _Page()
    page.feed(path.read_text(encoding="utf-8"))
    return worded("\n".join(page.lines)).splitlines()


READERS = {
    **dict.fromkeys((".txt", ".md", ".toml", ".xml", ".urdf", ".py", ".c", ".h", ".rst"), _text),
    **{".json": _json, ".jsonl": _json_lines, ".csv": _csv, ".html": _page, ".svg": _page},
    **dict.fromkeys((".inp", ".msh", ".mdpa", ".dxf", ".model", ".vtk"), _numbers),
    **{".npz": _arrays, ".vtu": _grid, ".stl": _surface, ".3mf": _zip},
}
