"""control.html: who lifts what, and with what force, on one page that opens offline.

Data as in control.json; rows: a dictionary a grip, JudgedGrip's fields and crushed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.control.roster import ControllerKind
from fingerdesign.records.arrays import GripTrace
from fingerdesign.report import style
from fingerdesign.report.page import caption_drawing, render_page, sentences
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.trials.record import ControlData

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

Row = dict[str, Any]

TEMPLATES = Path(__file__).parent / "templates"
WORDS = TEMPLATES / "words.txt.j2"
HELD_SHARE = 0.99  # of the grid: what is asked of the regulator
_OTHER = (style.MUTED, "-", "*")
_MARKS = {  # why a grip did not succeed -> marker, colour
    "dropped": ("x", style.INK),
    "crushed": ("^", style.VERMILION),
    "not lifted": ("_", style.INK),
    "failed": ("$?$", style.PURPLE),
}


@dataclass(frozen=True)
class Question:
    """One question of the study, its answer ("yes", "no", "partly" or "best") and the numbers."""

    answer: str
    question: str
    detail: str


def answers(data: ControlData) -> list[Question]:
    """Answers to the study's questions that it can give; none for a lone rival."""
    rows = {
        (each["controller"], row.noise_microstrain): row
        for each in data["controllers"]
        for row in each["by_noise"]
    }
    said = sentences(WORDS, "answers", data, rows, HELD_SHARE)
    if not said and len(data["controllers"]) > 1:
        said = sentences(WORDS, "best_of", data["controllers"])
    return [Question(*line.split("\t")) for line in said]


def control_html(
    data: ControlData, rows: Sequence[Row], traces: Sequence[GripTrace], noise: float
) -> str:
    """The page, from what control.json and grips.csv hold; ``noise``: the one that is drawn."""
    figures = [
        success_figure(data),
        force_figure(data, rows, noise),
        map_figure(data, rows, noise),
        paths_figure(traces, noise),
    ]
    page = TEMPLATES / "control.html.j2"
    return render_page(page, data=data, answers=answers(data), figures=figures, noise=noise)


def look_of(controller: str) -> tuple[str, Any, str]:
    """Colour, dashes and marker of a controller, the same in every figure."""
    kind: ControllerKind | None = CONTROLLERS.get(controller)
    if kind is None or kind.look is None:
        return _OTHER
    colour, dashes, marker = kind.look
    return style.COLOURS.get(colour, colour), dashes, marker


def success_figure(data: ControlData) -> style.ReportFigure:
    """Success against noise, a line a controller, with Wilson's intervals."""
    most = data["criteria"]["most_force_ratio"]
    with style.house_style():
        return caption_drawing(
            _success(data), WORDS, "success", controllers=data["controllers"], most=most
        )


def chart_png(data: ControlData) -> bytes:
    """Success against noise as a PNG on paper's colour."""
    with style.house_style():
        return style.to_png(_success(data))


def _success(data: ControlData) -> Canvas:
    figure = style.canvas(8.4, 4.2)
    axes = figure.subplots()
    noises = data["conditions"]["noises_microstrain"]
    count = len(data["controllers"])
    for index, each in enumerate(data["controllers"]):
        colour, dashes, marker = look_of(each["controller"])
        # Side by side, so that lines that coincide are seen.
        places = np.arange(len(noises)) + 0.035 * (index - 0.5 * (count - 1))
        shares = [row.success for row in each["by_noise"]]
        rate, low, high = np.array([(each.rate, each.low, each.high) for each in shares]).T
        axes.vlines(places, 100 * low, 100 * high, color=colour, lw=0.9)
        label = each["controller"].replace("_", " ")
        axes.plot(places, 100 * rate, color=colour, ls=dashes, marker=marker, label=label)
    axes.set_xticks(range(len(noises)), [f"{noise:g}" for noise in noises])
    axes.set_xlabel("gage noise (microstrain, standard deviation of a sample)")
    axes.set_ylabel("success (%)")
    axes.set_ylim(0.0, 104.0)
    figure.legend(loc="outside lower center", ncols=4)
    return figure


def force_figure(data: ControlData, rows: Sequence[Row], noise: float) -> style.ReportFigure:
    """Peak forces of every controller at one noise: quartiles and extremes, and each grip."""
    names = [each["controller"] for each in data["controllers"]]
    low, high = data["criteria"]["human_margin"]
    most = data["criteria"]["most_force_ratio"]
    rng = np.random.default_rng(0)  # of the scatter that parts the dots, nothing else
    peaks: dict[str, tuple[float, ...] | None] = dict.fromkeys(names)
    with style.house_style():
        figure = style.canvas(8.4, 0.9 + 0.42 * len(names))
        axes = figure.subplots()
        axes.axvspan(low, high, color=style.GREEN, alpha=0.14, lw=0)
        axes.axvline(most, color=style.VERMILION, ls=(0, (4, 3)), lw=1.0)
        axes.axvline(1.0, color=style.INK, ls=":", lw=1.0)
        for place, name in enumerate(names):
            lifted = [row for row in _at(rows, name, noise) if row["lifted"]]
            ratios = np.array([row["peak_ratio"] for row in lifted])
            if not len(ratios):
                continue
            colour, _, _ = look_of(name)
            jitter = place + rng.uniform(-0.26, 0.26, len(ratios))
            axes.plot(ratios, jitter, color=colour, ls="none", marker=".", ms=3, alpha=0.55)
            first, median, third = np.quantile(ratios, [0.25, 0.5, 0.75])
            axes.plot([first, third], [place, place], color=colour, lw=5, alpha=0.5)
            axes.plot([median], [place], color=style.INK, marker="|", ms=13, mew=2, ls="none")
            peaks[name] = median, first, third, ratios.max()
        axes.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.set_xscale("log")
        _plain_log(axes)
        axes.set_xlabel("peak normal force over the least that holds")
        return caption_drawing(
            figure, WORDS, "force", noise=noise, criteria=data["criteria"], peaks=peaks
        )


def map_figure(data: ControlData, rows: Sequence[Row], noise: float) -> style.ReportFigure:
    """Margin at lift over friction x weight, a panel a controller, with marks where it failed."""
    names = [each["controller"] for each in data["controllers"]]
    frictions = sorted(data["conditions"]["friction_coefficients"])
    masses = sorted(data["conditions"]["object_masses_g"])
    columns = 4
    panels_down = -(-len(names) // columns)
    counts = {}
    with style.house_style():
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import LinearSegmentedColormap, Normalize
        from matplotlib.lines import Line2D

        figure = style.canvas(1.2 + 2.1 * columns, 0.9 + 2.1 * panels_down)
        panels = style.small_multiples(figure, len(names), columns, sharex=True, sharey=True)
        colours = LinearSegmentedColormap.from_list(
            "margin", [style.GREEN, style.OPEN_COLOUR, style.BLUE]
        )
        scale = Normalize(1.0, 3.0, clip=True)
        for axes, name in zip(panels, names, strict=True):
            own = _at(rows, name, noise)
            _draw_map(axes, own, frictions, masses, colours, scale)
            axes.set_title(name.replace("_", " "))
            found = Counter(map(_why, own))
            counts[name] = {why: found[why] for why in ("", *_MARKS) if found[why]}
        for axes in panels[::columns]:
            axes.set_ylabel("weight (g)")
        for axes in panels[-columns:]:
            axes.set_xlabel("friction coefficient")
        figure.colorbar(
            ScalarMappable(scale, colours), ax=panels, label="margin at lift", shrink=0.8
        )
        handles = [
            Line2D([], [], color=colour, marker=marker, ls="none", ms=5, label=why)
            for why, (marker, colour) in _MARKS.items()
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
        return caption_drawing(figure, WORDS, "maps", noise=noise, counts=counts)


def _draw_map(
    axes: Axes,
    rows: Sequence[Row],
    frictions: list[float],
    masses: list[float],
    colours: Any,
    scale: Any,
) -> None:
    values = np.full((len(masses), len(frictions)), np.nan)
    for row in rows:
        place = masses.index(row["mass_g"]), frictions.index(row["friction"])
        values[place] = np.nan if row["margin_at_lift"] is None else row["margin_at_lift"]
    axes.imshow(values, origin="lower", aspect="auto", cmap=colours, norm=scale)
    for why, (marker, colour) in _MARKS.items():
        found = [row for row in rows if _why(row) == why]
        x = [frictions.index(row["friction"]) for row in found]
        y = [masses.index(row["mass_g"]) for row in found]
        axes.plot(x, y, color=colour, marker=marker, ms=4, mew=1.2, ls="none")
    axes.grid(False)
    for axis, along, decimals in ((axes.xaxis, frictions, 2), (axes.yaxis, masses, 0)):
        ticks = style.evenly_spaced(len(along), 4)
        axis.set_ticks(ticks, [f"{along[k]:.{decimals}f}" for k in ticks])


def paths_figure(traces: Sequence[GripTrace], noise: float) -> style.ReportFigure:
    """F_t over F_n of all controllers on one object a panel, with limit and target."""
    objects: dict[tuple[float, float], list[GripTrace]] = {}
    for trace in sorted(traces, key=lambda each: (each.friction_coefficient, each.object_mass_g)):
        objects.setdefault((trace.friction_coefficient, trace.object_mass_g), []).append(trace)
    with style.house_style():
        figure = style.canvas(9.6, 3.6)
        panels = style.small_multiples(figure, len(objects), len(objects))
        for axes, ((mu, mass), own) in zip(panels, objects.items(), strict=True):
            _draw_paths(axes, own)
            axes.set_title(f"μ = {mu:g}, {mass:g} g")
            axes.set_xlabel("normal force (N)")
        panels[0].set_ylabel("tangential force (N)")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=5)
        every = [each for own in objects.values() for each in own]
        return caption_drawing(figure, WORDS, "paths", noise=noise, traces=every)


def _draw_paths(axes: Axes, traces: Sequence[GripTrace]) -> None:
    weight, mu = traces[0].weight_per_finger_N, traces[0].friction_coefficient
    most = max(float(trace.normal_force.max(initial=0.0)) for trace in traces)
    reach = 1.06 * max(most, weight / mu)
    axes.plot(
        [0, reach], [0, mu * reach], color=style.INK, ls=":", lw=1.2, label="slip limit μ F_n"
    )
    axes.axhline(weight, color=style.MUTED, ls="-.", lw=1.0, label="weight mg/2")
    for trace in traces:
        colour, dashes, _ = look_of(trace.controller)
        normal, tangential = trace.normal_force, trace.tangential_force
        name = trace.controller.replace("_", " ")
        axes.plot(normal, tangential, color=colour, ls=dashes, lw=1.4, label=name)
        if trace.lift_step is not None:
            here = trace.lift_step
            axes.plot([normal[here]], [tangential[here]], color=colour, marker="*", ms=8)
    axes.plot([weight / mu], [weight], color=style.INK, ls="none", marker="x", ms=7, mew=1.6)
    axes.set_xlim(0, reach)
    axes.set_ylim(0, 1.3 * weight)


def _at(rows: Sequence[Row], controller: str, noise: float) -> list[Row]:
    wanted = controller, noise, 0.0
    return [row for row in rows if (row["controller"], row["noise"], row["tug"]) == wanted]


def _why(row: Row) -> str:
    """Why a grip is no success; "" where it is."""
    if row["ending"] == "failed":
        return "failed"
    if row["dropped"]:
        return "dropped"
    if not row["lifted"]:
        return "not lifted"
    return "crushed" if row["crushed"] else ""


def _plain_log(axes: Axes) -> None:
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    low, high = axes.get_xlim()
    ticks = (0.5, 0.7, 1.0, 1.2, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0)
    axes.xaxis.set_major_locator(FixedLocator([t for t in ticks if low <= t <= high]))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
