"""Code of the documents, run as a reader would run it."""

import re
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def blocks(page, kind="python"):
    """List the code blocks of one kind of a page of docs/."""
    text = (DOCS / page).read_text("utf-8")
    return re.findall(rf"```{kind}\n(.*?)```", text, flags=re.DOTALL)


def run_python(page, number=0):
    """Run one Python block of a page."""
    exec(compile(blocks(page)[number], page, "exec"), {"__name__": "page"})
