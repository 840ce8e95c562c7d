"""Additions to Sphinx for the site: pictures of examples, docstrings, links to source, keys."""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from textwrap import indent
from typing import Any

ROOT = Path(__file__).parents[1]
GENERATED = "generated"  # The folder of files that the build writes.
DESIGNS = ("design", "scene")


# Pictures of examples


def fresh_look(gallery_conf: dict[str, Any], name: str) -> None:
    """Give every example matplotlib's settings of the package's own figures, on white paper."""
    import matplotlib
    from matplotlib import pyplot

    from fingerdesign.report import style

    pyplot.close("all")
    matplotlib.rcdefaults()
    matplotlib.use("agg")
    matplotlib.rcParams.update(matplotlib.rc_params_from_file(style.LOOK, False, False))
    paper = dict.fromkeys(("figure.facecolor", "savefig.facecolor"), style.PAPER)
    matplotlib.rcParams.update(paper | {"figure.dpi": 110, "savefig.dpi": 150})


def drawings(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save matplotlib figures that pyplot does not know: what ``draw_sketch`` returns."""
    from matplotlib.figure import Figure
    from sphinx_gallery.scrapers import figure_rst

    known = block_vars["example_globals"].setdefault("__drawn__", set())
    paths = []
    values = [*block_vars["example_globals"].values()]
    for value in [w for v in values for w in (v if isinstance(v, list) else [v])]:
        if isinstance(value, Figure) and value.canvas.manager is None and id(value) not in known:
            known.add(id(value))
            paths.append(next(block_vars["image_path_iterator"]))
            value.savefig(paths[-1], dpi=150)
    return str(figure_rst(paths, gallery_conf["src_dir"]))


def scenes(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save what pyvista's plotters show, where an example has loaded pyvista."""
    if "pyvista" not in sys.modules:
        return ""
    from pyvista.plotting.utilities.sphinx_gallery import Scraper

    return str(Scraper()(block, block_vars, gallery_conf))


def turnable(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Show Plotly figures that an example has made, each with its script: pages fetch nothing."""
    if "plotly.graph_objects" not in sys.modules:
        return ""
    from plotly.graph_objects import Figure

    known = block_vars["example_globals"].setdefault("__turned__", set())
    found = [each for each in block_vars["example_globals"].values() if isinstance(each, Figure)]
    shown = [each for each in found if id(each) not in known]
    known.update(map(id, shown))
    pages = [each.to_html(full_html=False, include_plotlyjs=k == 0) for k, each in enumerate(shown)]
    return "".join(f"\n.. raw:: html\n\n{indent(page, '    ')}\n\n" for page in pages)


# Docstrings: plain text with aligned columns and |forces|, which reStructuredText would misread


def plain(lines: list[str]) -> list[str]:
    """Turn a docstring into reStructuredText; indented lines and columns stay as they are."""
    found: list[str] = []
    for paragraph in _paragraphs(lines):
        paragraph[-1] = re.sub(r"\s*::$", "", paragraph[-1])  # What follows is indented.
        if paragraph[0].lstrip().startswith(">>>"):
            found += [line.strip() for line in paragraph]
        elif any(line.startswith("  ") or re.search(r"\S {3,}\S", line) for line in paragraph):
            found += ["::", "", *("    " + line for line in paragraph)]
        else:
            found += [re.sub(r"([|*]|(?<=\w)_(?!\w))", r"\\\1", line) for line in paragraph]
        found.append("")
    return found


def _paragraphs(lines: list[str]) -> Iterator[list[str]]:
    lines_so_far: list[str] = []
    for line in [*lines, ""]:
        if line.strip():
            lines_so_far.append(line)
        elif lines_so_far:
            yield lines_so_far
            lines_so_far = []


def read_docstring(
    app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]
) -> None:
    """Pass autodoc's docstrings through :func:`plain`."""
    lines[:] = plain(lines)


# Links and files


def source_links(app: Any, docname: str, source: list[str]) -> None:
    """Replace relative links to source files by their words: the site has no such files."""
    source[0] = re.sub(r"\[([^\]]+)\]\(((?:\.\./)+[^)]+\.py)\)", r"\1", source[0])


def write_keys(app: Any) -> None:
    """Write the starter files with every key and its meaning, for the page that shows them."""
    from fingerdesign.design.starter import starter_scene_text, starter_text

    folder = Path(app.srcdir) / GENERATED
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for name, text in zip(DESIGNS, (starter_text("mine"), starter_scene_text()), strict=True):
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")


def setup(app: Any) -> dict[str, bool]:
    """Connect all of it."""
    app.connect("builder-inited", write_keys, priority=100)
    app.connect("autodoc-process-docstring", read_docstring)
    app.connect("source-read", source_links)
    return {"parallel_read_safe": True}
