"""Comparison of two golden records (golden.py).

``--numbers`` compares the values of JSON, CSV and TOML, exit codes, and the digests of geometry and
fields; words, pages, pictures and schemas are left out.
"""

import contextlib
import csv
import difflib
import fnmatch
import json
import re
import tomllib
from pathlib import PurePosixPath

# Files that two recordings of one tree do not share: the reason, and how they are compared:
# "words" (numbers left out, lines in any order) or "there" (both records have the file).
UNSTEADY = (
    ("tetwild/*.html.txt", "fTetWild never makes the same mesh twice", "there"),
    ("tetwild/*", "fTetWild never makes the same mesh twice", "words"),
)
VALUES = (".json", ".jsonl", ".csv", ".toml")
GEOMETRY = (".stl", ".step", ".3mf", ".dxf", ".vtu", ".vtk", ".msh", ".inp", ".mdpa", ".xdmf")
GEOMETRY += (".h5", ".npz")
_SHOWN = 12  # Differences of one file that are shown.


def differences(one, other, numbers=False):
    """Yield each difference of two records: cases, then calls and files, then their content."""
    cases = [{each.name for each in folder.iterdir() if each.is_dir()} for folder in (one, other)]
    for name in sorted(cases[0] ^ cases[1]):
        yield f"{name}: recorded only in {one if name in cases[0] else other}"
    left_out = {"help", "schemas"} if numbers else set()
    for name in sorted(cases[0] & cases[1] - left_out):
        found = [_texts(folder / name) for folder in (one, other)]
        for key in sorted(found[0].keys() ^ found[1].keys()):
            yield f"{name}/{key}: only in {one if key in found[0] else other}"
        for key in sorted(found[0].keys() & found[1].keys()):
            lines = _compared(f"{name}/{key}", found[0][key], found[1][key], numbers)
            if lines:
                yield "\n    ".join([f"{name}/{key}:", *lines[:_SHOWN]])


def _texts(folder):
    """Return the texts of a case: of calls by the call, of files by their path."""
    found = {}
    for path in sorted(folder.rglob("*.txt")):
        text = path.read_text("utf-8")
        if path.name.startswith("call_"):
            line, _, text = text.partition("\n")
            found[line] = text
        else:
            found[str(path.relative_to(folder))] = text
    return found


def _compared(key, a, b, numbers):
    """Return the lines that show how two texts of a file or a call differ; none if they do not."""
    for pattern, _, way in UNSTEADY:
        if fnmatch.fnmatch(key, pattern):
            same = way == "there" or numbers or _words(a) == _words(b)
            return [] if same else _lines(a, b)
    suffix = PurePosixPath(key.removesuffix(".txt")).suffix if key.endswith(".txt") else ""
    if "$ fingerdesign" in key:
        return _compared_calls(a, b, numbers)
    if numbers and suffix in VALUES:
        return _unequal(_values(suffix, a), _values(suffix, b))
    if numbers:
        return _lines(a, b) if suffix in GEOMETRY else []
    return _lines(a, b)


def _compared_calls(a, b, numbers):
    if not numbers:
        return _lines(a, b)
    codes = [text.partition("\n")[0] for text in (a, b)]
    lines = [] if codes[0] == codes[1] else codes
    outs = [text.partition("\n")[2].partition("\n--- stderr")[0].strip() for text in (a, b)]
    if all(text[:1] in ("{", "[") for text in outs):
        with contextlib.suppress(ValueError):  # Words in brackets are no JSON.
            lines += _unequal(*(_values(".jsonl", text) for text in outs))
    return lines


def _words(text):
    """Return the different lines of a text, digests and numbers left out."""
    text = re.sub(r"SHA-256 \w+|[-+]?\d[\d.,]*(e[-+]?\d+)?", "#", text)
    return sorted(set(text.splitlines()))


def _lines(a, b):
    changed = difflib.unified_diff(a.splitlines(), b.splitlines(), n=0, lineterm="")
    return [line[:200] for line in list(changed)[2:]]


def _documents(text):
    """Return the JSON documents that stand in a text one after another."""
    decoder, at, found = json.JSONDecoder(), 0, []
    while text[at:].strip():
        at += len(text[at:]) - len(text[at:].lstrip())
        value, at = decoder.raw_decode(text, at)
        found.append(value)
    return found


def _parsed(suffix, text):
    """Return the values of a file. Raises ValueError where it has none."""
    if suffix == ".csv":
        return [*csv.DictReader(text.splitlines())]
    return [tomllib.loads(text)] if suffix == ".toml" else _documents(text)


def _values(suffix, text):
    """Return the numbers and truth values of a file by their dotted place; words are left out."""
    found = {}

    def walk(place, value):
        for key, each in value.items() if isinstance(value, dict) else enumerate(value):
            own = f"{place}.{key}" if place else str(key)
            if isinstance(each, dict | list):
                walk(own, each)
            elif isinstance(each, str) and suffix == ".csv":
                if re.fullmatch(r"[-+]?(\d[\d.]*(e[-+]?\d+)?|inf|nan)", each):
                    found[own] = float(each)
            elif not isinstance(each, str):
                found[own] = each

    walk("", _parsed(suffix, text))
    return found


def _unequal(a, b):
    """Return a line for each value that differs or that only one side has."""
    places = sorted(
        place for place in a.keys() | b.keys() if a.get(place, "-") != b.get(place, "-")
    )
    return [f"{place}: {a.get(place, '-')} -> {b.get(place, '-')}" for place in places]
