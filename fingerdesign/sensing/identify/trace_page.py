"""Files of an identified trace: the record, the design, and a page of measured and modelled."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.design.io import dump_design
from fingerdesign.records.base import json_text
from fingerdesign.records.verdict import Status, Verdict, VerdictView
from fingerdesign.report import style
from fingerdesign.report.page import Item, Page, Section, Text, caption_drawing, page_html
from fingerdesign.report.table import Table
from fingerdesign.sensing.identify.trace_fit import Identified
from fingerdesign.sensing.identify.trace_report import (
    DESIGN_FILE,
    PAGE_FILE,
    RECORD_FILE,
    IdentificationData,
    identification,
    identified_design,
)

WORDS = Path(__file__).parent / "templates" / "figures.toml"
_SHOWN = 4  # The gages with the largest response are drawn.


def write_identification(found: Identified, trace: str, folder: Path) -> IdentificationData:
    """The record, the design and the page into a folder; trace: its name."""
    data = identification(found, trace)
    (folder / RECORD_FILE).write_text(json_text(data, indent=1), encoding="utf-8")
    text = dump_design(identified_design(found, data))
    (folder / DESIGN_FILE).write_text(text, encoding="utf-8")
    (folder / PAGE_FILE).write_text(identify_html(found, data), encoding="utf-8")
    return data


def identify_html(found: Identified, data: IdentificationData) -> str:
    """The page of an identified finger."""
    with style.house_style():
        forces, gages = _forces(found, data), _gages(found)
    model = "3-D" if data.fidelity == "3d" else "plane strain"
    against: list[Item] = [gages, *(Text(f"{each}.", "warnings") for each in data.warnings)]
    words = "Intervals are of all values together, from the noise that the trace shows. They hold "
    words += f"for the model's own errors as far as the misfit, {data.misfit:.3g}, is about 1."
    tables = [value_table(data, of_gages) for of_gages in (False, True)]
    files = "Next to this file: identification.json (all values), identified.toml (the design)."
    return page_html(
        Page(
            title=f"{data.design}: identified from {data.trace}",
            heading=f"{data.design}: identified from one trace",
            lead=f"{data.trace} · {data.rows} rows in {data.seconds:.3g} s · {model}",
            first=forces,
            view=VerdictView(data.design, model, data.seconds, tuple(_verdicts(found, data))),
            sections=[
                Section("values", "Values", [*tables, Text(words, "quiet")]),
                Section("gages", "Gages, measured and modelled", against),
            ],
            record=[Text(f"Digest of the design {data.digest}"), Text(files, "quiet")],
        )
    )


def _verdicts(found: Identified, data: IdentificationData) -> Iterator[Verdict]:
    """Modulus, relaxation and friction, and the motion that would tell more."""
    values = {each.name: each for each in data.values}
    names = {"youngs_modulus": "Young's modulus", "friction_coefficient": "friction coefficient"}
    for key, name in names.items():
        value, (number, interval) = values[key], values[key].shown()
        status: Status = "pass" if value.determined else "warning"
        yield Verdict(status, name, f"{number} {value.unit}".strip(), f"95 %: {interval}")
    if "relaxed_modulus" in values:
        left, terms = values["relaxed_modulus"].shown()[0], len(found.fit.terms)
        count = f"{terms} term{'s' * (terms != 1)}"
        yield Verdict("note", "modulus at rest", f"{left} MPa", count=count)
    if (following := data.next_motion) is not None:
        narrower = f"{following.now:.2g} to {following.then:.2g} of the target width"
        of = following.of.replace("_", " ")
        yield Verdict("note", "next motion", following.words, f"{of}: {narrower}")


def _forces(found: Identified, data: IdentificationData) -> style.ReportFigure:
    fit, path = found.fit, found.fit.model.path
    modelled, measured = fit.model.fitted(fit.x), fit.model.data
    off = (measured - modelled)[:, :2]
    figure = style.canvas(8.4, 4.6)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
    for k, name in enumerate(("F_n", "F_t")):
        colour, _, marker = style.SERIES[k]
        look = style.points(colour, marker, 3.0, f"{name} measured")
        upper.plot(path.time, measured[:, k], **look)
        upper.plot(path.time, modelled[:, k], color=colour, lw=1.2, label=f"{name} modelled")
        lower.plot(path.time, 1e3 * off[:, k], color=colour, lw=0.8, marker=marker, ms=2)
    upper.set_ylabel("N")
    lower.set_ylabel("residual, mN")
    lower.set_xlabel("time (s)")
    lower.margins(x=0.02)
    figure.legend(loc="outside lower center", ncols=4)
    left, most = float(np.sqrt(np.mean(off**2))), float(measured[:, 0].max())
    noise = [1e3 * each for each in data.force_noise_N]
    return caption_drawing(figure, WORDS, "forces", left_mN=1e3 * left, most=most, noise_mN=noise)


def _gages(found: Identified) -> style.ReportFigure:
    plates, fit, path = gage_array(found.design), found.fit, found.fit.model.path
    modelled, measured = fit.model.fitted(fit.x)[:, 2:], fit.model.data[:, 2:]
    largest = np.argsort(-np.ptp(modelled, axis=0))[:_SHOWN]
    figure = style.canvas(8.4, 3.4)
    axes = figure.subplots()
    for k, gage in enumerate(sorted(largest.tolist())):
        colour, dashes, marker = style.SERIES[k]
        name = f"gage {gage + 1}, plate {plates[gage]}"
        axes.plot(path.time, measured[:, gage], **style.points(colour, marker, 2.5))
        axes.plot(path.time, modelled[:, gage], color=colour, ls=dashes, lw=1.1, label=name)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("microstrain")
    axes.margins(x=0.02)
    figure.legend(loc="outside lower center", ncols=4)
    left = np.sqrt(np.mean((measured - modelled) ** 2, axis=0))
    return caption_drawing(
        figure, WORDS, "gages", left=float(np.median(left)), worst=float(left.max())
    )


def value_table(data: IdentificationData, gages: bool) -> Table:
    """The values of the gages, or all others, with their intervals."""
    rows = []
    for each in data.values:
        if each.name.startswith("gage_") == gages:
            name = each.name.replace("_", " ").replace(".", ", ")
            status = "pass" if each.determined else "warning"
            rows.append((name, *each.shown(), each.unit or "–", status))
    columns = ("value", "found", "95 % interval", "unit", "determined")
    key, caption = ("gages", "Gages") if gages else ("values", "Rubber and contact")
    return Table(key, caption, columns, tuple(rows), frozenset({0, 3, 4}))
