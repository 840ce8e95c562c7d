"""The stability map drawn: kinds of case against friction coefficient, one panel a method."""

from collections.abc import Sequence
from pathlib import Path

from fingerdesign.report.style import Axes
from fingerdesign_bench.chart import save
from fingerdesign_bench.stability.run import METHODS, CaseResult, Verdict

# Colour, letter and words of each verdict; the palette is made for colour-blind readers.
LOOKS: dict[Verdict, tuple[str, str, str]] = {
    Verdict.RIGHT: ("#cfe8f7", "", "all right"),
    Verdict.OTHER: ("#8cc4e8", "u", "u  right, one of several answers"),
    Verdict.REFUSED: (*("#d5ecdf", "z"), "z  right or refused rightly (none, or beyond the zone)"),
    Verdict.FAILED: ("#f3c14b", "F", "F  no answer"),
    Verdict.HANG: ("#b0569a", "H", "H  hang"),
    Verdict.WRONG: ("#c8321e", "W", "W  wrong answer"),
}
_TITLE = (
    "Where each method converges, fails and is wrong: a cell's colour is its worst case, "
    "letter and number say how many cases have that verdict; –: no such case"
)


def draw_stability(outcomes: Sequence[CaseResult], path: Path) -> Path:
    """Each cell: the worst verdict of its cases, with its letter and how many cases have it."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    rows = [("path", name) for name in dict.fromkeys(each.family for each in outcomes)]
    rows += [("", "")] + [("body", name) for name in dict.fromkeys(e.group for e in outcomes)]
    figure = Figure(figsize=(4.2 + 3.1 * len(METHODS), 1.9 + 0.3 * len(rows)), layout="constrained")
    axes = figure.subplots(1, len(METHODS), sharey=True)
    for panel, method in zip(axes, METHODS, strict=True):
        _draw_panel(panel, [each for each in outcomes if each.method == method], method, rows)
    names = {place: f"{kind}: {name}" for place, (kind, name) in enumerate(rows) if kind}
    axes[0].set_yticks(list(names), list(names.values()), fontsize=9)
    handles = [
        Patch(facecolor=colour, edgecolor="#6c6f73", label=words)
        for colour, _, words in LOOKS.values()
    ]
    look = {"ncols": len(LOOKS), "frameon": False, "fontsize": 9}
    figure.legend(handles=handles, loc="outside lower center", **look)
    figure.suptitle(_TITLE, fontsize=11)
    return save(figure, path, 130)


def _draw_panel(
    panel: Axes, outcomes: Sequence[CaseResult], method: str, rows: list[tuple[str, str]]
) -> None:
    frictions = sorted({each.friction for each in outcomes})
    cells: dict[tuple[str, str, float], list[Verdict]] = {}
    for each in outcomes:
        for row in (("path", each.family), ("body", each.group)):
            cells.setdefault((*row, each.friction), []).append(each.verdict)
    for column, friction in enumerate(frictions):
        for place, row in enumerate(rows):
            _draw_cell(panel, (column, place), cells.get((*row, friction)), row[0] == "path")
    verdicts = [each.verdict for each in outcomes]
    right = sum(each.rank <= Verdict.REFUSED.rank for each in verdicts)
    words = f"{right} of {len(verdicts)} right or rightly refused, "
    words += f"{verdicts.count(Verdict.WRONG)} wrong"
    panel.set_title(f"{method}\n{words}", fontsize=9.5, loc="left")
    panel.set(xlim=(-0.5, len(frictions) - 0.5), ylim=(len(rows) - 0.5, -0.5))
    panel.set_xticks(range(len(frictions)), [f"{friction:g}" for friction in frictions], fontsize=9)
    panel.set_xlabel("friction coefficient")
    panel.tick_params(length=0)
    panel.spines[:].set_visible(False)


def _draw_cell(
    panel: Axes, place: tuple[int, int], verdicts: list[Verdict] | None, is_path: bool
) -> None:
    """The worst verdict and how many cases have it; a dash where a path has no case."""
    from matplotlib.patches import Rectangle

    text, colour = "–" if is_path else "", "#1c1d1f"
    if verdicts:
        worst = max(verdicts, key=lambda each: each.rank)
        face, letter, _ = LOOKS[worst]
        corner = (place[0] - 0.5, place[1] - 0.5)
        panel.add_patch(Rectangle(corner, 1, 1, facecolor=face, edgecolor="white"))
        text = f"{letter}{verdicts.count(worst)}"
        colour = colour if worst.rank <= Verdict.FAILED.rank else "white"
    panel.text(*place, text, ha="center", va="center", fontsize=8, color=colour)
