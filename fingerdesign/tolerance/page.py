"""report.html: what to tighten first, and the spread of each row."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from fingerdesign.analysis.verdicts import FIDELITY_WORDS, two_digits
from fingerdesign.records.base import json_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.records.verdict import Verdict, VerdictView
from fingerdesign.report import style
from fingerdesign.report.page import Bullets, Page, Section, Text, caption_drawing, page_html
from fingerdesign.report.table import Table
from fingerdesign.tolerance.record import RowData, SourceData, ToleranceData

FOLDER = RecordFolder("tolerance", "tolerance.json", ("tolerance.json", "report.html"))
_WORDS = Path(__file__).parent / "templates" / "words.txt.j2"
_KINK = 1e-3  # Share of the force on kinks that is worth a sentence.
_MODEL = (
    "By one analysis and its derivatives: spreads are standard deviations of a linear model, any "
    "value within a tolerance being as likely. Where nodes change their status within a tolerance "
    "it is an approximation: kink % is the share of the normal force on such nodes."
)


def view_of(found: ToleranceData) -> VerdictView:
    """Content of the terminal and of the first screen: the row whose stick ratio scatters most (of
    equal ones the last), and the causes."""
    scatter = [row.stick_ratio_std[0] for row in found.rows]
    row = max(range(len(scatter)), key=lambda k: (scatter[k], k))
    where = f"{row + 1} of {len(scatter)}: the stick ratio scatters most"
    notes = [("increment", where), *_spreads(found.rows[row])]
    if (response := found.gage_response) is not None:
        number = f"{response[0]:.3g} µε/N as designed; 90 % of fingers reach {response[1]:.3g}"
        notes.append(("response", number))
    notes += [*_yields(found), *_tighten(found.sources)]
    worst = max(row.on_kink for row in found.rows)
    text = f"{100 * worst:.2g} % of the force stands between two statuses: one side's derivatives"
    warnings = [text] if worst > _KINK else []
    if found.other_model:
        keys = " and ".join(found.other_model)
        warnings.append(f"plates are solid, elements quadratic; not as designed ({keys})")
    about = found.design, FIDELITY_WORDS[found.fidelity], found.seconds
    verdicts = tuple(Verdict("note", *each) for each in notes)
    return VerdictView(*about, verdicts, warnings=tuple(warnings))


def _tighten(sources: Sequence[SourceData]) -> Iterator[tuple[str, str]]:
    """The cause to tighten first, and the next one: where a calibration finds the first, the one
    that it leaves."""
    first, *others = sources
    yield "tighten first", _source(first)
    stays = [each for each in others if not each.calibrated]
    if first.calibrated and stays:
        left = sum(each.share for each in stays) or 1.0  # of what a calibration leaves
        yield "once calibrated", _source(replace(stays[0], share=stays[0].share / left))
    elif others:
        yield "then", _source(others[0])


def _quantities(row: RowData) -> list[tuple[float | None, tuple[float, float]]]:
    """Forces, stick ratio, reading, gage area: as designed, and deviations as made, calibrated."""
    return [
        (row.normal_force_N, row.normal_force_std_N),
        (row.tangential_force_N, row.tangential_force_std_N),
        (row.stick_ratio, row.stick_ratio_std),
        (row.largest_reading_microstrain, row.reading_std_microstrain),
        (row.gage_area_mm, row.gage_area_std_mm),
    ]


def _spreads(row: RowData) -> Iterator[tuple[str, str]]:
    """Names and numbers of a row: as designed, spread as made, once calibrated."""
    names = ("normal force", "tangential force", "stick ratio", "readings", "gage area")
    units = (" N", " N", "", " µε at most", " mm")
    for name, unit, (value, stds) in zip(names, units, _quantities(row), strict=True):
        if value is not None:
            made, calibrated = map(two_digits, stds)
            yield name, f"{value:.3g}{unit} ± {made} as made, ± {calibrated} calibrated"


def _yields(found: ToleranceData) -> Iterator[tuple[str, str]]:
    """Yields in words: by motion alone, and of real models where there are any."""
    made, known = (100 * share for share in found.yield_by_motion)
    text = f"{made:.0f} % as made, {known:.0f} % calibrated have a margin of 1.1 to 1.5"
    yield "yield by motion", text
    scatter = [two_digits(100 * std) for std in found.margin_std]
    yield "margin", "± {} % as made, ± {} % calibrated".format(*scatter)
    if (cast := found.cast) is not None:
        low, high = (100 * each for each in cast.interval)
        text = f"{100 * cast.share:.0f} % ({low:.0f} to {high:.0f}) of the lifts of {cast.fingers}"
        text += f" fingers are in that band; {100 * cast.lifted:.0f} % succeed"
        yield "yield by control", text


def _source(source: SourceData) -> str:
    """A cause in words: "plates in height, ± 0.05 mm: 61 % of reading variance"."""
    return (
        f"{source.words}, ± {two_digits(source.tolerance)} {source.unit}: "
        f"{100 * source.share:.0f} % of reading variance"
    )


def _chart(found: ToleranceData) -> style.Canvas:
    figure = style.canvas(7.2, 3.2)
    axes = figure.subplots()
    names = [source.words for source in found.sources][::-1]
    shares = [100.0 * source.share for source in found.sources][::-1]
    edge = style.SERIES[0][0]
    fill = [style.PAPER if source.calibrated else edge for source in found.sources][::-1]
    axes.barh(names, shares, color=fill, edgecolor=edge, height=0.6)
    axes.set_xlabel("share of the readings' variance (%)")
    axes.grid(visible=False, axis="y")
    return figure


def tolerance_html(found: ToleranceData) -> str:
    """The page of a finger's tolerances."""
    with style.house_style():
        chart = caption_drawing(_chart(found), _WORDS, "shares", sources=found.sources)
    versions = ", ".join(f"{name} {each}" for name, each in found.versions.items())
    title, view = f"{found.design}: tolerances", view_of(found)
    sections = [
        Section("spread", "Spread", [_rows(found.rows), Text(_MODEL)]),
        Section("causes", "Causes", [_causes(found.sources), _gages(found)]),
    ]
    if view.warnings:
        sections.insert(0, Section("warnings", "Warnings", [Bullets(view.warnings, "warnings")]))
    return page_html(
        Page(
            title=title,
            heading=title,
            lead=f"scene {found.scene} · {FIDELITY_WORDS[found.fidelity]} · {found.seconds:.0f} s",
            first=chart,
            view=view,
            sections=sections,
            record=[Text("Next to this file: tolerance.json (all numbers)."), Text(versions)],
        )
    )


def write_tolerance(found: ToleranceData, folder: Path) -> None:
    """Write tolerance.json and report.html into a folder."""
    (folder / "tolerance.json").write_text(json_text(found), encoding="utf-8")
    (folder / "report.html").write_text(tolerance_html(found), encoding="utf-8")


def _rows(rows: tuple[RowData, ...]) -> Table:
    forces = ("normal force, N", "tangential force, N")
    names = (*forces, "stick ratio", "reading, µε", "gage area, mm")
    columns = ("increment", *(each for name in names for each in (name, "±")), "kink %")
    cells = []
    for number, row in enumerate(rows, start=1):
        shown = [
            "–" if value is None else f"{each:.3g}"
            for value, (made, _) in _quantities(row)
            for each in (value, made)
        ]
        cells.append((str(number), *shown, f"{100 * row.on_kink:.2g}"))
    return Table("rows", "As made: standard deviations", columns, tuple(cells))


def _causes(sources: tuple[SourceData, ...]) -> Table:
    columns = ("cause", "tolerance ±", "share %", "most sensitive", "calibrated")
    cells = [
        (
            each.words,
            f"{each.tolerance:.3g} {each.unit}",
            f"{100 * each.share:.1f}",
            each.most_sensitive,
            "drops out" if each.calibrated else "stays",
        )
        for each in sources
    ]
    return Table("causes", "Causes of scatter", columns, tuple(cells), frozenset({0, 1, 3, 4}))


def _gages(found: ToleranceData) -> Table:
    cells = [(str(k), f"{value:.3g}") for k, value in enumerate(found.gage_std_microstrain, 1)]
    return Table("gages", "Each gage: RMS over the increments", ("gage", "± µε"), tuple(cells))
