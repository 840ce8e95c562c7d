"""The page about the studio: its Python runs, and says what it prints."""

import re

from tests.support.house import ROOT


def test_python_of_the_page_runs(capsys):
    text = (ROOT / "docs/how_to/studio.md").read_text("utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    exec(compile(block, "studio.md", "exec"), {"__name__": "page"})
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("plane strain, coarse section ['yes', ")
    assert printed[1] == "{'plates.angle_deg': 40.0}"
