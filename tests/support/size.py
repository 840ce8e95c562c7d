"""Measure the size and plainness of the project: lines, commands, keys, words, complexity.

    python tests/support/size.py              the table
    python tests/support/size.py --places     and the places behind the counts of code

Each number is counted in one way, which is described by the function that counts it.
"""

import argparse
import ast
import re
import statistics
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "cli"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

try:
    import tomllib

    import click
    from fingerdesign_cli.main import cli
    from packaging.requirements import Requirement

    from fingerdesign.design.schema import Design
    from tests.support.house import FUNCTION, ROOT, tree
    from tests.test_docs import PAGES, sentences
except ModuleNotFoundError as missing:
    sys.exit(f"{missing}: run it by .venv/bin/python, which has it")

DIALECT = ("told", "kept", "said", "asked", "beside")
BAD_FIRST_WORDS = {"What", "Whether", "How", "Of", "Where", "As", "If", "When", "Why"}
FIVE = ["cadquery", "pytetwild", "pyvista", "meshio", "scikit-fem"]
MOST_COMPLEXITY, MOST_ARGUMENTS = 12, 7
BRANCHES = (
    *(ast.If, ast.IfExp, ast.For, ast.AsyncFor, ast.While, ast.ExceptHandler),
    *(ast.comprehension, ast.match_case, ast.Assert),
)
BANNER = re.compile(r"\n\n# .*\n(?=\n)|^# ?[-=~#]{3,}", re.M)  # a comment line between blank lines


def files(folder: str, *endings: str) -> list[Path]:
    """List the files below a folder with one of the endings."""
    return sorted(p for p in (ROOT / folder).rglob("*") if p.suffix in endings and p.is_file())


def lines(paths: list[Path]) -> int:
    """Count lines of files."""
    return sum(len(path.read_text("utf-8").splitlines()) for path in paths)


def product() -> list[Path]:
    """List the Python files of the package and the command line."""
    return files("fingerdesign", ".py") + files("cli", ".py")


def functions(paths: list[Path]) -> Iterator[tuple[Path, FUNCTION]]:
    """Yield every function of files."""
    for path in paths:
        for node in ast.walk(tree(path)):
            if isinstance(node, FUNCTION):
                yield path, node


def own_nodes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a function without those of functions inside it."""
    for each in ast.iter_child_nodes(node):
        if not isinstance(each, FUNCTION | ast.Lambda | ast.ClassDef):
            yield each
            yield from own_nodes(each)


def complexity(node: ast.AST) -> int:
    """Count one, each branch, each comprehension and its conditions, each boolean operator."""
    total = 1
    for each in own_nodes(node):
        total += isinstance(each, BRANCHES)
        total += len(each.values) - 1 if isinstance(each, ast.BoolOp) else 0
        total += len(each.ifs) if isinstance(each, ast.comprehension) else 0
    return total


def argument_count(node: FUNCTION) -> int:
    """Count the parameters of a function, self and cls left out."""
    every = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    return sum(each.arg not in ("self", "cls") for each in every)


def click_command(node: FUNCTION) -> bool:
    """Tell if click calls a function: its options are its parameters."""
    names = " ".join(ast.unparse(each) for each in node.decorator_list)
    return "command" in names or "option" in names


def place(path: Path, node: FUNCTION | ast.stmt) -> str:
    """Name a place as file:line."""
    return f"{path.relative_to(ROOT)}:{node.lineno} {getattr(node, 'name', '')}"


def complex_functions() -> list[str]:
    """Find functions of the product over the bound of complexity."""
    found = functions(product())
    return [f"{place(p, f)} {complexity(f)}" for p, f in found if complexity(f) > MOST_COMPLEXITY]


def long_signatures() -> list[str]:
    """Find functions of the product with too many arguments, click's commands left out."""
    found = [(p, f) for p, f in functions(product()) if not click_command(f)]
    return [
        f"{place(p, f)} {argument_count(f)}" for p, f in found if argument_count(f) > MOST_ARGUMENTS
    ]


def question_docstrings() -> list[str]:
    """Find docstrings of the product that begin with a question word or a preposition."""
    found = []
    for path in product():
        for node in ast.walk(tree(path)):
            if isinstance(node, FUNCTION | ast.ClassDef | ast.Module):
                first = (ast.get_docstring(node) or "x").split()[0].strip(":,.")
                if first in BAD_FIRST_WORDS:
                    found.append(f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 1)} {first}")
    return found


def banners() -> list[str]:
    """Find comments that divide a file."""
    texts = ((p, p.read_text("utf-8")) for p in product())
    return [str(p.relative_to(ROOT)) for p, text in texts for _ in BANNER.findall(text)]


def late_constants() -> list[str]:
    """Find files whose constants stand after their first function or class."""
    found = []
    for path in product():
        defined = False
        for node in tree(path).body:
            defined |= isinstance(node, FUNCTION | ast.ClassDef)
            targets = node.targets if isinstance(node, ast.Assign) else []
            targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
            names = [each.id for each in targets if isinstance(each, ast.Name)]
            if defined and any(re.fullmatch(r"_?[A-Z][A-Z0-9_]+", name) for name in names):
                found.append(place(path, node))
                break
    return found


def splatted_bags() -> list[str]:
    """Find calls that receive a plain name with a star: f(*given), f(**options)."""
    found = []
    for path in product():
        for call in (node for node in ast.walk(tree(path)) if isinstance(node, ast.Call)):
            stars = [each.value for each in call.args if isinstance(each, ast.Starred)]
            stars += [each.value for each in call.keywords if each.arg is None]
            if any(isinstance(each, ast.Name) for each in stars):
                found.append(f"{path.relative_to(ROOT)}:{call.lineno}")
    return found


def monkeypatches() -> int:
    """Count the calls of monkeypatch in the tests, of whatever kind."""
    texts = [p.read_text("utf-8") for p in files("tests", ".py") + files("benchmarks", ".py")]
    return sum(len(re.findall(r"monkeypatch\.\w+\(", each)) for each in texts)


def template_files() -> list[Path]:
    """List the Jinja templates of pages and texts."""
    return files("fingerdesign", ".j2")


def template_statements() -> int:
    """Count the statements of templates: {% ... %} without the ends of blocks."""
    texts = [p.read_text("utf-8") for p in template_files()]
    return sum(len(re.findall(r"{%-?\s*+(?!end)", each)) for each in texts)


def commands() -> dict[str, int]:
    """Name the commands of the wheel that --help shows, each with the number of its options."""
    context = click.Context(cli)
    found = {}
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        if command is not None and not command.hidden and name not in ("paper", "bench"):
            options = [p for p in command.params if isinstance(p, click.Option) and not p.hidden]
            found[name] = len(options)
    return found


def design_keys() -> int:
    """Count the keys of a design, in tables of tables too; those of one list entry once."""
    schema = Design.model_json_schema()
    definitions = schema.get("$defs", {})

    def count(node: dict, seen: tuple[str, ...] = ()) -> int:
        references = set(re.findall(r"#/\$defs/(\w+)", str(node)))
        tables = [r for r in references if r not in seen and "properties" in definitions[r]]
        if tables:
            return sum(count_table(definitions[r], (*seen, r)) for r in tables)
        return 1

    def count_table(table: dict, seen: tuple[str, ...] = ()) -> int:
        return sum(count(each, seen) for each in table.get("properties", {}).values())

    return count_table(schema)


def dialect_counts() -> dict[str, int]:
    """Count whole words of the dialect table in code, templates and docs."""
    paths = product() + files("benchmarks", ".py") + template_files() + list(PAGES)
    text = "\n".join(p.read_text("utf-8") for p in paths)
    return {word: len(re.findall(rf"\b{word}\b", text, re.I)) for word in DIALECT}


def installed(roots: list[str]) -> str:
    """Count packages and bytes of these and of all that they require here, without extras."""
    found: dict[str, metadata.Distribution] = {}
    left = [Requirement(root) for root in roots]
    while left:
        needed = left.pop()
        name = re.sub(r"[-_.]+", "-", needed.name).lower()
        if name in found or (needed.marker and not needed.marker.evaluate({"extra": ""})):
            continue
        found[name] = metadata.distribution(name)
        left += map(Requirement, found[name].requires or ())
    paths = {Path(str(d.locate_file(f))) for d in found.values() for f in d.files or []}
    size = sum(path.stat().st_size for path in paths if path.exists())
    return f"{len(found)}, {1e-9 * size:.2f} GB"


def table() -> dict[str, object]:
    """Measure everything."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    every = [page.read_text("utf-8") for page in PAGES]
    lengths = [len(each) for text in every for each in sentences(text)]
    found = commands()
    bench_tests = files("benchmarks", ".py")
    return {
        "product: lines of Python": lines(product()),
        "templates: lines": lines(template_files()),
        "styles and scripts of pages: lines": lines(files("fingerdesign", ".css", ".js", ".html")),
        "template statements": template_statements(),
        "C: lines": lines(files("fingerdesign", ".c", ".h")),
        "benchmarks with their tests: lines": lines(bench_tests),
        "tests: lines": lines(files("tests", ".py")),
        "commands": len(found),
        "options": sum(found.values()),
        "keys of a design": design_keys(),
        "words of docs with README": sum(len(text.split()) for text in every),
        "words of README": len(every[0].split()),
        "mean sentence, words": round(statistics.mean(lengths), 1),
        "sentences over 35 words": sum(each > 35 for each in lengths),
        **{f"word {word!r}": count for word, count in dialect_counts().items()},
        "functions of complexity over 12": len(complex_functions()),
        "functions with over 7 arguments": len(long_signatures()),
        "docstrings that begin with What, Whether, How ...": len(question_docstrings()),
        "banner comments": len(banners()),
        "files with constants after a definition": len(late_constants()),
        "splatted bags": len(splatted_bags()),
        "monkeypatches": monkeypatches(),
        "packages of the default install": installed(project["dependencies"]),
        "packages of the five libraries that it is made of": installed(FIVE),
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--places", action="store_true", help="name the places of the code")
    for name, value in table().items():
        print(f"{name:52} {value}")
    if parser.parse_args().places:
        for find in (complex_functions, long_signatures, question_docstrings, banners):
            print(f"\n{find.__name__}", *find(), sep="\n  ")
        for find in (late_constants, splatted_bags):
            print(f"\n{find.__name__}", *find(), sep="\n  ")


if __name__ == "__main__":
    main()
