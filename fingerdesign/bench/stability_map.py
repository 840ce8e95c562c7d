"""The stability map drawn: kinds of case against friction coefficient, one panel a method."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from fingerdesign.bench.stability_run import METHODS, Outcome, Verdict

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Colour and letter both tell the verdict; the palette is made for colour-blind readers.
LOOKS: dict[Verdict, tuple[str, str]] = {
    Verdict.RIGHT: ("#cfe8f7", ""),
    Verdict.OTHER: ("#8cc4e8", "u"),
    Verdict.REFUSED: ("#d5ecdf", "z"),
    Verdict.FAILED: ("#f3c14b", "F"),
    Verdict.HANG: ("#b0569a", "H"),
    Verdict.WRONG: ("#c8321e", "W"),
}
WORDS: dict[Verdict, str] = {
    Verdict.RIGHT: "all right",
    Verdict.OTHER: "u  right, one of several answers",
    Verdict.REFUSED: "z  right or refused rightly (none, or beyond the zone)",
    Verdict.FAILED: "F  no answer",
    Verdict.HANG: "H  hang",
    Verdict.WRONG: "W  wrong answer",
}
_ORDER = list(Verdict)
_PALE = (Verdict.RIGHT, Verdict.OTHER, Verdict.REFUSED, Verdict.FAILED)


def draw_stability(outcomes: Sequence[Outcome], path: Path) -> None:
    """Each cell: the worst verdict of its cases, with its letter and how many cases have it."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    frictions = sorted({each.friction for each in outcomes})
    families = list(dict.fromkeys(each.family for each in outcomes))
    groups = list(dict.fromkeys(each.group for each in outcomes))
    rows = len(families) + len(groups) + 1
    figure = Figure(figsize=(4.2 + 3.1 * len(METHODS), 1.9 + 0.3 * rows), layout="constrained")
    axes = figure.subplots(1, len(METHODS), sharey=True)
    for panel, method in zip(axes, METHODS, strict=True):
        mine = [each for each in outcomes if each.method == method]
        _draw_panel(panel, mine, frictions, families, groups)
        right = sum(_ORDER.index(e.verdict) <= _ORDER.index(Verdict.REFUSED) for e in mine)
        wrong = sum(e.verdict == Verdict.WRONG for e in mine)
        panel.set_title(
            f"{method}\n{right} of {len(mine)} right or rightly refused, {wrong} wrong",
            fontsize=9.5,
            loc="left",
        )
    axes[0].set_yticks(
        [*range(len(families)), *(len(families) + 1 + k for k in range(len(groups)))],
        [*(f"path: {name}" for name in families), *(f"body: {name}" for name in groups)],
        fontsize=9,
    )
    figure.legend(
        handles=[
            Patch(facecolor=LOOKS[verdict][0], edgecolor="#6c6f73", label=WORDS[verdict])
            for verdict in Verdict
        ],
        loc="outside lower center",
        ncols=len(Verdict),
        frameon=False,
        fontsize=9,
    )
    figure.suptitle(
        "Where each method converges, fails and is wrong: a cell's colour is its worst case, "
        "letter and number say how many cases have that verdict; –: no such case",
        fontsize=11,
    )
    figure.savefig(path, dpi=130)


def _draw_panel(
    panel: Axes,
    outcomes: Sequence[Outcome],
    frictions: list[float],
    families: list[str],
    groups: list[str],
) -> None:
    from matplotlib.patches import Rectangle

    for column, friction in enumerate(frictions):
        here = [each for each in outcomes if each.friction == friction]
        cells = [[each for each in here if each.family == name] for name in families]
        cells += [[]] + [[each for each in here if each.group == name] for name in groups]
        for row, cases in enumerate(cells):
            if not cases:
                if row < len(families):
                    panel.text(column, row, "–", ha="center", va="center", fontsize=8)
                continue
            worst = max((each.verdict for each in cases), key=_ORDER.index)
            colour, letter = LOOKS[worst]
            panel.add_patch(
                Rectangle((column - 0.5, row - 0.5), 1, 1, facecolor=colour, edgecolor="white")
            )
            number = sum(each.verdict == worst for each in cases)
            panel.text(
                column,
                row,
                f"{letter}{number}",
                ha="center",
                va="center",
                fontsize=8,
                color="#1c1d1f" if worst in _PALE else "white",
            )
    panel.set_xlim(-0.5, len(frictions) - 0.5)
    panel.set_ylim(len(families) + len(groups) + 0.5, -0.5)
    panel.set_xticks(range(len(frictions)), [f"{friction:g}" for friction in frictions], fontsize=9)
    panel.set_xlabel("friction coefficient")
    panel.tick_params(length=0)
    for spine in panel.spines.values():
        spine.set_visible(False)
