"""Mutants drawn by lot: one operator, comparison or number made wrong, somewhere in what matters.

    python tests/support/drawn_mutants.py [--count 200] [--seed 0] [--kept FILE] [--touched FILE]

A line a mutant: where, what became what, and the first test that fails, or LIVES; a run over its
time is caught. --kept: results that are there are taken, new ones added, so a run may be cut off.
--touched, of ``tests/support/touched.py``: a mutant meets the tests that run its line, the quick
ones first; without it, and where none does, all those of its place.
What lives is to be read: it is a test that lacks, or a change that changes nothing (a tolerance,
a first guess, an order of work). Lines of words, errors and types are left out.
"""

import argparse
import ast
import json
import random
import shlex
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tests.support.mutants import Mutant, caught_by, copied  # noqa: E402

# Of each folder or file: the fast tests that must see to it.
PLACES = {
    "fingerdesign/contact": "tests/contact tests/control/test_memory.py tests/control/test_rig.py",
    "fingerdesign/control": "tests/control tests/trials/test_control_page.py "
    "tests/sensing/test_identify_bench.py",
    "fingerdesign/fem/readout.py": "tests/fem",
    "fingerdesign/fem/elements.py": "tests/fem",
    "fingerdesign/design/digest.py": "tests/design",
    "fingerdesign/layout/frames.py": "tests/layout tests/fem/test_gages.py tests/design",
    "fingerdesign/mold/plan/slots.py": "tests/mold/test_planning.py tests/mold/test_legs.py",
}
SWAPS = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.And: ast.Or,
    ast.Or: ast.And,
}


def changed(node):
    """A copy of the node, made wrong; None where there is nothing to change."""
    if isinstance(node, ast.BinOp) and type(node.op) in SWAPS:
        return ast.BinOp(node.left, SWAPS[type(node.op)](), node.right)
    if isinstance(node, ast.BoolOp):
        return ast.BoolOp(SWAPS[type(node.op)](), node.values)
    if isinstance(node, ast.Compare) and type(node.ops[0]) in SWAPS:
        return ast.Compare(node.left, [SWAPS[type(node.ops[0])](), *node.ops[1:]], node.comparators)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
        return node.operand
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        return ast.Constant(not node.value)
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        whole = isinstance(node.value, int) or node.value == 0.0
        return ast.Constant(node.value + 1 if whole else 2.0 * node.value)
    return None


def _skipped(node):
    """Whether nothing below a node is behaviour: words, types, errors that are raised."""
    return isinstance(node, ast.JoinedStr | ast.Raise | ast.Assert | ast.Import | ast.ImportFrom)


def points(node, inside=False):
    """Every node that can be made wrong, in functions; annotations and defaults left out."""
    inside = inside or isinstance(node, ast.FunctionDef)
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "type_comment", "keywords_doc"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or _skipped(child):
                continue
            if inside and child.__class__.__name__ != "arguments" and changed(child) is not None:
                yield child
            yield from points(child, inside)


def drawn(count, seed):
    """So many mutants, by lot over all points of all files."""
    found = []
    for place, tests in PLACES.items():
        at = ROOT / place
        for path in sorted(at.rglob("*.py")) if at.is_dir() else [at]:
            text = path.read_text("utf-8")
            own = [node for node in points(ast.parse(text)) if node.lineno == node.end_lineno]
            found += [(path.relative_to(ROOT), tests, node) for node in own]
    for path, tests, node in random.Random(seed).sample(found, min(count, len(found))):
        lines = (ROOT / path).read_text("utf-8").splitlines(keepends=True)
        line = lines[node.lineno - 1].encode()
        old = line[node.col_offset : node.end_col_offset].decode()
        new = f"({ast.unparse(changed(node))})"
        wrong = line[: node.col_offset] + new.encode() + line[node.end_col_offset :]
        broken = "".join([*lines[: node.lineno - 1], wrong.decode(), *lines[node.lineno :]])
        what = f"{path}:{node.lineno}: {old} -> {new}"
        yield Mutant(what, str(path), tests, "".join(lines), broken)


def closest(mutant, touched):
    """The mutant, to be met by the tests that run its line, quick ones first."""
    of, seconds = touched["lines"], touched["seconds"]
    tests = sorted(of.get(mutant.what.partition(": ")[0], []), key=seconds.__getitem__)
    return mutant._replace(tests=shlex.join(tests)) if tests else mutant


def main():
    """Try the mutants in one copy of the tree, and say which share is caught."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kept", type=Path, help="JSON lines: what is known of each")
    parser.add_argument("--touched", type=Path, help="which tests run which lines")
    given = parser.parse_args()
    known, touched = {}, {"lines": {}}
    if given.touched is not None:
        touched = json.loads(given.touched.read_text("utf-8"))
    if given.kept is not None and given.kept.exists():
        known = dict(json.loads(line) for line in given.kept.read_text("utf-8").splitlines())
    results = []
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        tree = copied(Path(folder))
        for mutant in drawn(given.count, given.seed):
            if mutant.what not in known:
                known[mutant.what] = caught_by(closest(mutant, touched), tree)
                if given.kept is not None:
                    with given.kept.open("a", encoding="utf-8") as file:
                        file.write(json.dumps([mutant.what, known[mutant.what]]) + "\n")
            results.append(known[mutant.what])
            print(f"{mutant.what}: {results[-1] or 'LIVES'}", flush=True)
    caught = sum(each is not None for each in results)
    print(f"{caught} of {len(results)} caught")
    return int(caught < len(results))


if __name__ == "__main__":
    sys.exit(main())
