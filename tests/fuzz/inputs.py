"""Hostile inputs by their number: what kind, which files, and the commands that must refuse them.

A kind is a function that lays files into a folder and gives command lines, the first of which
judges; the others are tried where it refuses, and must refuse as well.
"""

import json
import os
import shutil
import tomllib
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fingerdesign import load_design, parse_design
from fingerdesign.design.shipped import shipped_names, shipped_text
from fingerdesign.sensing.train.result import finger_key
from tests.cli.test_voice import FOLDERS
from tests.control.test_estimator import estimator
from tests.control.test_trace import text as trace_text
from tests.fuzz.hostile import Chance, misvalued, put, spoiled, toml
from tests.search.test_compare_reading import write_study
from tests.support.any_outcomes import any_outcomes

SMALL = """
design.name = "small"
plates = { count = 3, pitch_mm = 3.0 }
grip = { defaults = "fixed", friction_coefficients = [0.5], max_steps = 20 }
[mesh.section]
contact_size_mm = 0.3
plate_size_mm = 0.5
plate_end_size_mm = 0.1
far_size_mm = 2.0
"""
SCENE = "path.increments_mm = [[0.2, 0.0], [0.2, 0.05]]\n"
MOLD = {
    "process": "fdm",
    "shrinkage": 0.01,
    "sheets_mm": [0.1, 0.2],
    "limits": {"wall_mm": 1.0, "slot_mm": 0.3},
    "comb": {"sheet_mm": 0.3, "web_mm": 0.2},
    "gage_types": [
        {"name": "mine", "grid_length_mm": 0.5, "grid_width_mm": 1.0, "carrier_length_mm": 2.0}
    ],
}
FLAT = ("--fidelity", "plane-strain")
Lines = list[list[str]]


class Kind(NamedTuple):
    """A share of all inputs, and what lays one out: folder, OUT, chance -> command lines."""

    share: int
    lay: Callable[[Path, Path, Chance], Lines]


KINDS: dict[str, Kind] = {}


def kind(share: int) -> Callable[[Any], Any]:
    """Register a kind under its function's name, with so many of a hundred inputs."""

    def add(lay: Any) -> Any:
        KINDS[lay.__name__] = Kind(share, lay)
        return lay

    return add


def kind_of(number: int) -> str:
    """The kind of an input: of a hundred in a row each has its share, mixed."""
    names = [name for name, each in KINDS.items() for _ in range(each.share)]
    return names[number * 37 % len(names)]


def chance_of(number: int) -> Chance:
    return np.random.default_rng([20261124, number])


def some(chance: Chance, names: Any) -> Any:
    return names[int(chance.integers(len(names)))]


def base(chance: Chance, what: str) -> str:
    """A shipped file's text."""
    return shipped_text(some(chance, list(shipped_names(what))), what)


def faulty(text: str, chance: Chance, extra: tuple[Any, ...] = ()) -> bytes:
    """A TOML text with faults of its bytes, or of its values."""
    if chance.random() < 0.35:
        return spoiled(text.encode(), chance)
    return toml(misvalued(tomllib.loads(text), chance, extra)).encode("utf-8", "replace")


def laid(folder: Path, name: str, content: bytes, chance: Chance) -> str:
    put(folder / name, content, chance)
    return str(folder / name)


@kind(28)
def designs(folder: Path, out: Path, chance: Chance) -> Lines:
    """A design; each command that takes one refuses what check does."""
    text = SMALL if chance.random() < 0.3 else base(chance, "design")
    file = laid(folder, "a.toml", faulty(text, chance, ("pipe", ".", "a.toml")), chance)
    words = ("analyse", "grip", "mesh", "validate", "mold", "view", "gages", "train", "study")
    return [["check", file], [some(chance, words), file, "--out", str(out), "--quiet"]]


@kind(3)
def parts(folder: Path, out: Path, chance: Chance) -> Lines:
    """A design that names a STEP file, or a mesh."""
    known = b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\n"
    mesh = b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n"
    if chance.random() < 0.3:
        laid(folder, "a.step", spoiled(known + b"ENDSEC;\nEND-ISO-10303-21;\n", chance), chance)
        text = 'design.name = "a"\nbody = { shape = "step", step.file = "a.step" }\n'
    else:
        name = f"a.{some(chance, ('msh', 'vtu', 'inp', 'vtk', 'xyz'))}"
        laid(folder, name, spoiled(mesh, chance), chance)
        text = f'{SMALL}[mesh]\nmesher = "file"\nfile = "{name}"\n'.replace("[mesh.section]", "[x]")
        text = text.partition("[x]")[0] + text[text.index("[mesh]") :]
    (folder / "a.toml").write_text(text)
    return [["mesh", str(folder / "a.toml"), "--out", str(out), "--quiet"]]


@kind(5)
def profiles(folder: Path, out: Path, chance: Chance) -> Lines:
    """A process and a machine of the mold's table."""
    data = {"design": {"name": "a"}, "mold": misvalued(MOLD, chance)}
    file = laid(folder, "a.toml", toml(data).encode("utf-8", "replace"), chance)
    return [["check", file], ["mold", file, "--out", str(out), "--quiet"]]


@kind(15)
def scenes(folder: Path, out: Path, chance: Chance) -> Lines:
    file = laid(folder, "s.toml", faulty(base(chance, "scene"), chance), chance)
    to = ["--out", str(out), "--quiet", *FLAT]
    return [["check", "narrow", "--scene", file], ["analyse", "narrow", "--scene", file, *to]]


@kind(14)
def studies(folder: Path, out: Path, chance: Chance) -> Lines:
    file = laid(folder, "b.toml", faulty(base(chance, "study"), chance, ("b.toml",)), chance)
    word = some(chance, ("generate", "sweep", "optimise"))
    return [["check", file], [word, file, "--out", str(out), "--quiet"]]


@kind(8)
def traces(folder: Path, out: Path, chance: Chance) -> Lines:
    """A recorded grip; cells are set to what is no number, too."""
    (folder / "a.toml").write_text(SMALL)
    content = trace_text().encode()
    if chance.random() < 0.5:
        rows = [line.split(",") for line in content.decode().splitlines()]
        rows = misvalued(rows, chance)
        content = "\n".join(
            ",".join(str(cell) for cell in row) if isinstance(row, list) else str(row)
            for row in rows
        ).encode("utf-8", "replace")
    else:
        content = spoiled(content, chance)
    file = laid(folder, "t.csv", content, chance)
    return [["identify", str(folder / "a.toml"), file, "--out", str(out), "--quiet"]]


@kind(3)
def benches(folder: Path, out: Path, chance: Chance) -> Lines:
    """A folder that a bench measured."""
    (folder / "a.toml").write_text(SMALL)
    (folder / "bench").mkdir()
    phases = "trace,phase\n" + "".join(f"{word}.csv,{word}\n" for word in ("press", "slide"))
    laid(folder, "bench/phases.csv", spoiled(phases.encode(), chance), chance)
    for word in ("press", "slide"):
        laid(folder, f"bench/{word}.csv", spoiled(trace_text().encode(), chance), chance)
    measured = [str(folder / "bench"), "--out", str(out), "--quiet"]
    return [["identify", str(folder / "a.toml"), *measured]]


@cache
def _taught() -> str:
    design = parse_design(SMALL)
    return replace(estimator(), design=finger_key(design)).to_json()


@kind(5)
def estimators(folder: Path, out: Path, chance: Chance) -> Lines:
    (folder / "a.toml").write_text(SMALL)
    content = _faulty_json(_taught(), chance)
    file = laid(folder, "e.json", content, chance)
    own, to = str(folder / "a.toml"), ["--out", str(out), "--quiet"]
    return [["export", "--to", "c", file, own, *to]]


def _faulty_json(text: str, chance: Chance) -> bytes:
    try:
        data = json.loads(text)
    except ValueError:  # spoiled before
        return spoiled(text.encode(), chance)
    if chance.random() < 0.3:
        return spoiled(text.encode(), chance)
    return json.dumps(misvalued(data, chance)).encode("utf-8", "replace")


@kind(10)
def results(folder: Path, out: Path, chance: Chance) -> Lines:
    """A result's folder, its record, its arrays or its design spoiled."""
    shutil.copytree(corpus() / "result", out)
    for _ in range(int(chance.integers(1, 3))):
        path = some(chance, ["result.json", "result.json", "arrays.npz", "design.toml"])
        where = out / path
        if not where.is_file() or where.stat().st_size > 1e9:
            continue
        old = where.read_bytes()
        plain = path.endswith(".json") and chance.random() < 0.7
        content = (
            _faulty_json(old.decode("utf-8", "replace"), chance) if plain else spoiled(old, chance)
        )
        put(where, content, chance)
    page = [] if chance.random() < 0.05 else ["--json"]
    return [["view", str(out), *page]]


@kind(5)
def records(folder: Path, out: Path, chance: Chance) -> Lines:
    """A folder of any other kind that view knows."""
    name = some(chance, sorted(FOLDERS))
    out.mkdir()
    content = _faulty_json(json.dumps(FOLDERS[name]), chance)
    put(out / name, content, chance, odd=0.15)
    return [["view", str(out)]]


@kind(2)
def outcomes(folder: Path, out: Path, chance: Chance) -> Lines:
    """A study's folder that compare reads."""
    made = any_outcomes(3, seed=int(chance.integers(5)))
    write_study(folder / "study", made, name="mine", seed=7)
    path = folder / "study" / some(chance, ("outcomes.jsonl", "outcomes.jsonl", "study.json"))
    lines = path.read_text().splitlines()
    lines[-1] = _faulty_json(lines[-1], chance).decode("utf-8", "replace")
    put(path, "\n".join(lines).encode("utf-8", "replace"), chance)
    return [["compare", str(folder / "study"), "--out", str(out / "page.html"), "--quiet"]]


@kind(2)
def caches(folder: Path, out: Path, chance: Chance) -> Lines:
    """A cache of which files are spoiled: never an answer of it, never a fault."""
    shutil.copytree(corpus() / "cache", folder / "cache")
    cached = sorted(each for each in (folder / "cache").rglob("*") if each.is_file())
    for _ in range(int(chance.integers(1, 4))):
        path = some(chance, cached)
        if path.is_file() and path.stat().st_size < 1e9:
            put(path, spoiled(path.read_bytes(), chance), chance, odd=0.2)
    return [_analyse(corpus(), out)]


def _analyse(folder: Path, out: Path) -> list[str]:
    files = [str(folder / "a.toml"), "--scene", str(folder / "s.toml")]
    return ["analyse", *files, "--out", str(out), *FLAT, "--quiet"]


@cache
def corpus() -> Path:
    """A folder with a result, and the cache that its analysis filled; made once a process."""
    from tests.support.calls import command

    folder = Path(os.environ["FINGERDESIGN_FUZZ"]) / "corpus"
    if not (folder / "result").is_dir():
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "a.toml").write_text(SMALL)
        (folder / "s.toml").write_text(SCENE)
        before = os.environ.get("FINGERDESIGN_CACHE", "")
        os.environ["FINGERDESIGN_CACHE"] = str(folder / "cache")
        code, written = command(_analyse(folder, folder / "out"))
        os.environ["FINGERDESIGN_CACHE"] = before or str(folder / "cache")
        assert code == 0, written
        (folder / "out/small").rename(folder / "result")
        load_design(folder / "result/design.toml")
    return folder
