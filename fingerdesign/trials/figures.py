"""Figures of a control study: success, peak forces, map of margins, paths of the forces."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.control.roster import ControllerKind
from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.result import GripResult
from fingerdesign.report import style
from fingerdesign.report.page import caption_drawing
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.trials.findings import percent, words
from fingerdesign.trials.record import ControlData, ControllerData
from fingerdesign.trials.summary import Trial, chosen_of

WORDS = Path(__file__).parent / "templates" / "words.toml"
_OTHER = (style.MUTED, "-", "*")
_MARKS = {  # Marker and colour by the reason why a grip did not succeed.
    "dropped": ("x", style.INK),
    "crushed": ("^", style.VERMILION),
    "not lifted": ("_", style.INK),
    "failed": ("$?$", style.PURPLE),
}


def look_of(controller: str) -> tuple[str, Any, str]:
    """Colour, dashes and marker of a controller, the same in every figure."""
    kind: ControllerKind | None = CONTROLLERS.get(controller)
    if kind is None or kind.look is None:
        return _OTHER
    colour, dashes, marker = kind.look
    return style.COLOURS.get(colour, colour), dashes, marker


def success_figure(data: ControlData) -> style.ReportFigure:
    """Success against noise, or by fault, with Wilson's intervals."""
    most, perturbed = data["criteria"]["most_force_ratio"], data["conditions"]["perturbed"]
    name = "success" if perturbed is None else "success_by_fault"
    found = " ".join(
        f"{words(each['controller'])}: {', '.join(_rates(each, perturbed is not None))}."
        for each in data["controllers"]
    )
    with style.house_style():
        return caption_drawing(_success(data), WORDS, name, "success", found=found, most=most)


def _rates(controller: ControllerData, by_fault: bool) -> list[str]:
    """The success of a controller by noise, or by fault."""
    if by_fault:
        rows = [(words(row.fault), row.success.rate) for row in controller["by_fault"]]
    else:
        noises = controller["by_noise"]
        rows = [(f"{row.noise_microstrain:g} microstrain", row.success.rate) for row in noises]
    return [f"{name} {'–' if rate is None else percent(rate)}" for name, rate in rows]


def chart_png(data: ControlData) -> bytes:
    """Success against noise as a PNG on paper's colour."""
    with style.house_style():
        return style.to_png(_success(data))


def _success(data: ControlData) -> style.Canvas:
    figure = style.canvas(8.4, 4.2)
    axes = figure.subplots()
    perturbed, noises = data["conditions"]["perturbed"], data["conditions"]["noises_microstrain"]
    labels = [f"{noise:g}" for noise in noises]
    if perturbed is not None:
        labels = [words(label) for label in perturbed["faults"]]
    count = len(data["controllers"])
    for index, each in enumerate(data["controllers"]):
        colour, dashes, marker = look_of(each["controller"])
        # Next to each other, so that lines that coincide are visible.
        step = 0.035 if perturbed is None else 0.5 / count
        places = np.arange(len(labels)) + step * (index - 0.5 * (count - 1))
        rows = each["by_noise"] if perturbed is None else each["by_fault"]
        shares = [row.success for row in rows]
        rate, low, high = np.array([(each.rate, each.low, each.high) for each in shares]).T
        axes.vlines(places, 100 * low, 100 * high, color=colour, lw=0.9)
        line = dashes if perturbed is None else "none"  # Faults have no order to join.
        label = words(each["controller"])
        axes.plot(places, 100 * rate, color=colour, ls=line, marker=marker, label=label)
    axes.set_xticks(range(len(labels)), labels, rotation=0 if perturbed is None else 60)
    if perturbed is None:
        axes.set_xlabel("gage noise (microstrain, standard deviation of a sample)")
    axes.set_ylabel("success (%)")
    axes.set_ylim(0.0, 104.0)
    figure.legend(loc="outside lower center", ncols=4)
    return figure


def force_figure(data: ControlData, trials: Sequence[Trial], noise: float) -> style.ReportFigure:
    """Peak forces of every controller at one noise: quartiles and extremes, and each grip."""
    names = [each["controller"] for each in data["controllers"]]
    low, high = data["criteria"]["human_margin"]
    most = data["criteria"]["most_force_ratio"]
    rng = np.random.default_rng(0)  # It scatters the dots, nothing else.
    peaks: dict[str, tuple[float, ...] | None] = dict.fromkeys(names)
    with style.house_style():
        figure = style.canvas(8.4, 0.9 + 0.42 * len(names))
        axes = figure.subplots()
        axes.axvspan(low, high, color=style.GREEN, alpha=0.14, lw=0)
        axes.axvline(most, color=style.VERMILION, ls=(0, (4, 3)), lw=1.0)
        axes.axvline(1.0, color=style.INK, ls=":", lw=1.0)
        for place, name in enumerate(names):
            grips = (each.result for each in chosen_of(trials, name, noise))
            ratios = np.array([each.peak_ratio for each in grips if each.lifted])
            if not len(ratios):
                continue
            colour, _, _ = look_of(name)
            jitter = place + rng.uniform(-0.26, 0.26, len(ratios))
            axes.plot(ratios, jitter, color=colour, ls="none", marker=".", ms=3, alpha=0.55)
            first, median, third = np.quantile(ratios, [0.25, 0.5, 0.75])
            axes.plot([first, third], [place, place], color=colour, lw=5, alpha=0.5)
            axes.plot([median], [place], color=style.INK, marker="|", ms=13, mew=2, ls="none")
            peaks[name] = median, first, third, ratios.max()
        axes.set_yticks(range(len(names)), list(map(words, names)))
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.set_xscale("log")
        _plain_log(axes)
        axes.set_xlabel("peak normal force over the least that holds")
        found = " ".join(f"{words(name)}{_quartiles(each)}." for name, each in peaks.items())
        reach: dict[str, Any] = {"low": low, "high": high, "most": most}
        return caption_drawing(figure, WORDS, "force", noise=noise, found=found, **reach)


def _quartiles(peaks: tuple[float, ...] | None) -> str:
    if peaks is None:
        return " lifts nothing"
    return ": median {:.2f}, half of them from {:.2f} to {:.2f}, at most {:.2f}".format(*peaks)


def map_figure(data: ControlData, trials: Sequence[Trial], noise: float) -> style.ReportFigure:
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
        labels = "friction coefficient", "mass (g)"
        panels = style.small_multiples(
            figure, len(names), columns, *labels, sharex=True, sharey=True
        )
        colours = LinearSegmentedColormap.from_list(
            "margin", [style.GREEN, style.OPEN_COLOUR, style.BLUE]
        )
        scale = Normalize(1.0, 3.0, clip=True)
        for axes, name in zip(panels, names, strict=True):
            own = [each.result for each in chosen_of(trials, name, noise)]
            _draw_map(axes, own, frictions, masses, colours, scale)
            axes.set_title(words(name))
            found = Counter(map(_why, own))
            counts[name] = {why: found[why] for why in ("", *_MARKS) if found[why]}
        figure.colorbar(
            ScalarMappable(scale, colours), ax=panels, label="margin at lift", shrink=0.8
        )
        handles = [
            Line2D([], [], color=colour, marker=marker, ls="none", ms=5, label=why)
            for why, (marker, colour) in _MARKS.items()
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
        texts = " ".join(f"{words(name)}: {_reasons(each)}." for name, each in counts.items())
        return caption_drawing(figure, WORDS, "maps", noise=noise, found=texts)


def _reasons(counts: dict[str, int]) -> str:
    """The count of grips that succeed, and why the others do not."""
    whole = f"{counts.get('', 0)} of {sum(counts.values())} succeed"
    return "; ".join([whole, *(f"{count} {why}" for why, count in counts.items() if why)])


def _draw_map(
    axes: style.Axes,
    grips: Sequence[GripResult],
    frictions: list[float],
    masses: list[float],
    colours: Any,
    scale: Any,
) -> None:
    values = np.full((len(masses), len(frictions)), np.nan)
    places = [
        (masses.index(grip.object_mass_g), frictions.index(grip.friction_coefficient))
        for grip in grips
    ]
    for place, grip in zip(places, grips, strict=True):
        values[place] = np.nan if grip.safety_margin is None else grip.safety_margin
    axes.imshow(values, origin="lower", aspect="auto", cmap=colours, norm=scale)
    for why, (marker, colour) in _MARKS.items():
        found = [place for place, grip in zip(places, grips, strict=True) if _why(grip) == why]
        y, x = np.array(found, dtype=int).reshape(-1, 2).T
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
        labels = "normal force (N)", "tangential force (N)"
        panels = style.small_multiples(figure, len(objects), len(objects), *labels)
        for axes, ((mu, mass), own) in zip(panels, objects.items(), strict=True):
            _draw_paths(axes, own)
            axes.set_title(f"μ = {mu:g}, {mass:g} g")
        style.shared_legend(panels, 5)
        every = [each for own in objects.values() for each in own]
        found = " ".join(map(_lift, every))
        return caption_drawing(figure, WORDS, "paths", noise=noise, found=found)


def _lift(trace: GripTrace) -> str:
    """A grip in words: its object, and the force at the lift."""
    mu = trace.friction_coefficient
    grip = f"{words(trace.controller)}, friction {mu:g}, {trace.object_mass_g:g} g"
    if trace.lift_step is None:
        return f"{grip}: not lifted."
    normal = trace.normal_force[trace.lift_step]
    ratio = normal * mu / trace.weight_per_finger_N
    return f"{grip}: lifted at {normal:.2f} N, {ratio:.2f} times the least."


def _draw_paths(axes: style.Axes, traces: Sequence[GripTrace]) -> None:
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
        name = words(trace.controller)
        axes.plot(normal, tangential, color=colour, ls=dashes, lw=1.4, label=name)
        if trace.lift_step is not None:
            here = trace.lift_step
            axes.plot([normal[here]], [tangential[here]], color=colour, marker="*", ms=8)
    axes.plot([weight / mu], [weight], color=style.INK, ls="none", marker="x", ms=7, mew=1.6)
    axes.set_xlim(0, reach)
    axes.set_ylim(0, 1.3 * weight)


def _why(grip: GripResult) -> str:
    """The reason that a grip is no success; "" where it is one."""
    if grip.outcome == "failed":
        return "failed"
    if grip.gross_slip:
        return "dropped"
    if not grip.lifted:
        return "not lifted"
    return "crushed" if grip.crushed else ""


def _plain_log(axes: style.Axes) -> None:
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    low, high = axes.get_xlim()
    ticks = (0.5, 0.7, 1.0, 1.2, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0)
    axes.xaxis.set_major_locator(FixedLocator([t for t in ticks if low <= t <= high]))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
