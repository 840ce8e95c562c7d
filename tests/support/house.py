"""The floors of the house, read from the code: every import, inside functions and for typing too.

python tests/support/house.py --picture FILE     draws the floors; size.py counts the rest
"""

import argparse
import ast
from collections import defaultdict
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = {"fingerdesign": "", "fingerdesign_cli": "cli", "fingerdesign_bench": "benchmarks"}

# From the ground up. A folder imports from floors below it, and on its own floor from those to its
# left. The root package, which hands the public names on, is on no floor.
FLOORS = (
    ("errors", "arrays", "version", "runtime", "materials", "reduced"),
    ("shapes", "design", "layout", "records"),
    ("contact", "checks", "cad"),
    ("mesh", "control"),
    ("report", "fem"),
    ("analysis", "sensitivity"),
    ("sensing",),
    ("pipeline", "trials", "validate", "mold", "tolerance", "robots"),
    ("search", "studio"),
    ("fingerdesign_cli", "fingerdesign_bench"),
)
FUNCTION = ast.FunctionDef | ast.AsyncFunctionDef
PLACES = {name: (up, place) for up, row in enumerate(FLOORS) for place, name in enumerate(row)}


@dataclass(frozen=True)
class Import:
    """One name that a module takes from another module of the project."""

    source: str
    target: str
    name: str
    line: int
    inside: bool  # a function


@cache
def modules():
    """Dotted name to file, of the package, the command line and the benchmarks."""
    found = {}
    for package, folder in PACKAGES.items():
        base = ROOT / folder
        for path in sorted((base / package).rglob("*.py")):
            parts = path.relative_to(base).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def imports():
    """Every import of the project by the project."""
    return tuple(found for name in modules() for found in _imports_of(name))


def _imports_of(module):
    known = modules()
    for node, inside in imports_in(tree(known[module])):
        taken = [(alias.name, alias.name) for alias in node.names]
        if isinstance(node, ast.ImportFrom):
            wholes = [(f"{node.module}.{alias.name}", alias.name) for alias in node.names]
            taken = [(whole if whole in known else node.module, name) for whole, name in wholes]
        for target, name in taken:
            if target in known:
                yield Import(module, target, name, node.lineno, inside)


@cache
def tree(path):
    """A file's syntax tree."""
    return ast.parse(path.read_text("utf-8"))


def imports_in(node, inside=False):
    """Import statements below a node, each with whether it stands inside a function."""
    for each in ast.iter_child_nodes(node):
        if isinstance(each, ast.Import | ast.ImportFrom):
            yield each, inside
        elif isinstance(each, ast.stmt | ast.ExceptHandler | ast.match_case):
            yield from imports_in(each, inside or isinstance(each, FUNCTION))


def room(module):
    """The folder (or loose file) of the package in which a module stands; empty: the root."""
    package, _, rest = module.partition(".")
    return package if package != "fingerdesign" else rest.partition(".")[0]


def against_the_order():
    """Imports that go up, or to the right on one floor."""
    return [
        each
        for each in imports()
        if (low := room(each.target)) and (high := room(each.source))
        if low != high and PLACES[low] > PLACES[high]
    ]


def circles():
    """Groups of modules that import each other in a loop, wherever the imports stand (Tarjan)."""
    graph = defaultdict(set)
    for each in imports():
        graph[each.source].add(each.target)
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(module):
        index[module] = low[module] = len(index)
        stack.append(module)
        for other in graph[module]:
            if other not in index:
                visit(other)
                low[module] = min(low[module], low[other])
            elif other in stack:
                low[module] = min(low[module], index[other])
        if low[module] == index[module]:
            place = stack.index(module)
            group = stack[place:]
            del stack[place:]
            if len(group) > 1:
                found.append(sorted(group))

    for module in modules():
        if module not in index:
            visit(module)
    return found


def inside_functions():
    """Names of the package that the wheel's code imports inside functions."""
    return [e for e in imports() if e.inside and not e.source.startswith("fingerdesign_bench")]


def long_functions(most=60):
    """Functions of the wheel with more lines than that, as module:line."""
    every = ((m, node) for m, path in wheel().items() for node in ast.walk(tree(path)))
    functions = ((m, node) for m, node in every if isinstance(node, FUNCTION))
    lines = [(f"{m}:{node.lineno}", node.end_lineno - node.lineno + 1) for m, node in functions]
    return [f"{place} {count}" for place, count in lines if count > most]


def wheel():
    """The modules that are shipped."""
    return {m: p for m, p in modules().items() if not m.startswith("fingerdesign_bench")}


def draw(path):
    """The floors as a picture: each folder is as wide as it has lines."""
    from matplotlib.figure import Figure

    lines: dict[str, int] = defaultdict(int)
    for module, file in modules().items():
        if room(module):
            lines[room(module)] += len(file.read_text("utf-8").splitlines())
    figure = Figure(figsize=(9.0, 5.6), layout="constrained")
    axes = figure.subplots()
    widest = max(sum(lines[name] for name in row) for row in FLOORS)
    for floor, row in enumerate(FLOORS):
        left = 0.0
        for name in row:
            width = lines[name]
            axes.barh(floor, width, left=left, height=0.8, color="#dbe7f3", edgecolor="#33557a")
            size = 8 if width > 0.06 * widest else 5
            if width > 0.02 * widest:
                text = f"{name}\n{width / 1000:.1f}k"
                axes.text(left + width / 2, floor, text, ha="center", va="center", fontsize=size)
            left += width
    axes.set_yticks(range(len(FLOORS)))
    axes.set_ylabel("floor: imports go down, or to the left")
    axes.set_xlabel("lines")
    figure.savefig(path, dpi=150)


def main():
    """Draw the floors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--picture", type=Path, metavar="FILE", required=True)
    draw(parser.parse_args().picture)


if __name__ == "__main__":
    main()
