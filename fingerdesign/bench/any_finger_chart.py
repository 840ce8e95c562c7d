"""Random fingers drawn: seconds against tetrahedra, and the least angle of each mesh."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

MARKS = "osD^v<>PX*hd"


def draw_any_finger(records: Sequence[dict[str, Any]], path: Path) -> None:
    """Two panels: each mesh's time over its size, by body; a histogram of least dihedral angles."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    meshed = [each for each in records if each["status"] == "meshed"]
    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    bodies = list(dict.fromkeys(each["kinds"][0] for each in meshed))
    for number, body in enumerate(bodies):
        mine = [each for each in meshed if each["kinds"][0] == body]
        left.scatter(
            [each["elements"] for each in mine],
            [each["seconds"] for each in mine],
            marker=MARKS[number % len(MARKS)],
            s=26,
            alpha=0.8,
            label=f"{body} ({len(mine)})",
        )
    left.set(xscale="log", yscale="log", xlabel="tetrahedra", ylabel="seconds, CAD to mesh, s")
    left.xaxis.set_minor_formatter(NullFormatter())
    left.axhline(120.0, color="#c8321e", linewidth=1.0)
    left.text(0.02, 122.0, "asked: 120 s a try", transform=left.get_yaxis_transform(), fontsize=8)
    left.legend(fontsize=8, title="body (designs)")
    left.set_title(
        f"{len(meshed)} of {len(records)} random designs meshed", loc="left", fontsize=10
    )
    right.hist([each["min_dihedral_deg"] for each in meshed], bins=24, color="#4c78a8")
    right.axvline(5.0, color="#c8321e", linewidth=1.0)
    right.set(xlabel="least dihedral angle of a mesh, degrees", ylabel="meshes")
    right.set_title("asked: over 5 degrees", loc="left", fontsize=10)
    for axes in (left, right):
        axes.grid(alpha=0.25)
    figure.savefig(path, dpi=130)
