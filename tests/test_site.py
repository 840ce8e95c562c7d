"""docs/gallery: each example says what it shows, is short, and uses what the API pages show."""

import ast
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
EXAMPLES = sorted(DOCS.glob("gallery/*/*.py"))
PUBLIC = {"fingerdesign"} | {
    name
    for page in DOCS.glob("api/*.md")
    for name in re.findall(r"automodule:: (\S+)", page.read_text("utf-8"))
}
OTHERS = {"numpy", "scipy", "matplotlib", "pyvista", "cadquery", "mujoco"}
OTHERS |= set(sys.stdlib_module_names)
PICTURES = ("pyplot.show()", "plotter.show()", "draw_sketch(")


def named(path):
    return f"{path.parent.name}/{path.stem}"


def test_every_folder_of_examples_has_its_page():
    folders = {path.parent for path in EXAMPLES}
    assert all((folder / "README.rst").is_file() for folder in folders)


@pytest.mark.parametrize("path", EXAMPLES, ids=named)
def test_an_example_has_a_title_an_explanation_and_a_picture(path):
    text = path.read_text("utf-8")
    title, line, blank, *words = (ast.get_docstring(ast.parse(text)) or "").splitlines()
    assert set(line) == {"="}
    assert len(line) >= len(title) > 5
    assert blank == ""
    assert len(" ".join(words).split()) >= 15
    assert any(picture in text for picture in PICTURES)
    assert len(text.splitlines()) <= 65


@pytest.mark.parametrize("path", EXAMPLES, ids=named)
def test_an_example_imports_public_names_only(path):
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            assert {alias.name.partition(".")[0] for alias in node.names} <= OTHERS
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            assert module in PUBLIC or module.partition(".")[0] in OTHERS, module
            names = {alias.name for alias in node.names}
            assert not any(name.startswith("_") for name in names)
            if module in PUBLIC:
                there = import_module(module)
                assert all(hasattr(there, name) for name in names), module


def test_every_page_is_on_the_site():
    pages = {path.relative_to(DOCS).with_suffix("").as_posix() for path in DOCS.glob("*/*.md")}
    listed = (DOCS / "index.md").read_text("utf-8").split()
    assert {page for page in pages if not page.startswith("api/")} <= set(listed)


@pytest.mark.slow
@pytest.mark.parametrize("stem", ["01_arc", "03_tractions", "01_one_lift"])
def test_an_example_runs(stem):
    (path,) = (each for each in EXAMPLES if each.stem == stem)
    environment = os.environ | {"MPLBACKEND": "agg"}
    subprocess.run([sys.executable, path], env=environment, check=True, timeout=120)
