"""recorded.html: our detectors next to the authors', and the law of friction, for offline use."""

from collections.abc import Iterator
from pathlib import Path

from fingerdesign.records.base import json_text
from fingerdesign.records.statistics import Share
from fingerdesign.records.verdict import Verdict, VerdictView
from fingerdesign.report import page, style
from fingerdesign.report.table import Table
from fingerdesign.trials.figures import WORDS
from fingerdesign.trials.recorded import pillars
from fingerdesign.trials.recorded.detect import ANSWER_S
from fingerdesign.trials.recorded.friction import CONSTANT, FrictionData
from fingerdesign.trials.recorded.recording import SPAN_S
from fingerdesign.trials.recorded.sets import PAGE, RECORD, RecordedData, SetData

NONE = "–"
_CHANCE = 0.5  # Rank of a detector that knows nothing.
_SHOWN = 10  # files that were not read; a clone of a repository may have hundreds


def write_recorded(data: RecordedData, folder: Path, seconds: float) -> None:
    """The record and the page of a judgement into a folder."""
    (folder / RECORD).write_text(json_text(data), encoding="utf-8")
    words = page.texts_of(WORDS)["recorded"]
    rules = {each.detector: each.note for own in data.sets for each in own.scores}
    notes: list[page.Item] = [page.Bullets([f"{name}: {note}" for name, note in rules.items()])]
    notes.append(page.Text(words["protocol"].format(span=SPAN_S, answer=ANSWER_S), "quiet"))
    theirs = any(not each.ours for own in data.sets for each in own.scores)
    more = {"authors": theirs, "friction": data.friction is not None}
    notes += [page.Text(words[name], "quiet") for name, there in more.items() if there]
    sources = {each.name: each.source for each in data.sets}
    sources |= {"friction": pillars.SOURCE} if data.friction is not None else {}
    record: list[page.Item] = [page.Text(f"{name}: {source}.") for name, source in sources.items()]
    if data.unread:
        record += [page.Text(words["unread"]), page.Bullets(unread(data), "warnings")]
    with style.house_style():
        figure = _figure(data)
    made = page.Page(
        title="Recordings of others",
        heading="Judged on what others measured",
        lead=f"{Path(data.folder).name} · {seconds:.0f} s",
        sections=[page.Section("tables", "Detectors and laws", [*tables(data), *notes])],
        record=[*record, page.Text("Next to this file: recorded.json.", "quiet")],
        first=figure,
        view=VerdictView("recorded", "", seconds, tuple(verdicts(data))),
    )
    (folder / PAGE).write_text(page.page_html(made), encoding="utf-8")


def unread(data: RecordedData) -> list[str]:
    """The first files that were not read, each with the reason, and the number of the others."""
    more = len(data.unread) - _SHOWN
    return [*data.unread[:_SHOWN], *([f"{more} more, in {RECORD}"] if more > 0 else [])]


def verdicts(data: RecordedData) -> Iterator[Verdict]:
    """Judge each set: our stick share ranks slip as well as the authors' detector, or better
    than chance where there is none; and the exponents of friction."""
    yield from map(_ranked, data.sets)
    if (law := data.friction) is not None:
        for name, each in (("whole contact", law.whole), ("single pillars", law.single)):
            holds = each.low <= CONSTANT <= each.high
            number = f"n = {each.value:.2f} ({each.low:.2f} to {each.high:.2f})"
            count = f"{each.count} slips"
            yield Verdict("pass" if holds else "fail", name, number, "theory 0.33", count)


def _ranked(own: SetData) -> Verdict:
    first, theirs = own.scores[0], [each.rank for each in own.scores if not each.ours]
    if first.rank is None:
        return Verdict("note", own.name, "nothing to rank", "slip and rest are needed")
    best = max((each for each in theirs if each is not None), default=None)
    target = f"chance {_CHANCE:.2f}" if best is None else f"authors {best:.2f}"
    apart = _ends(first.found)[0] > _ends(first.false)[1]
    reached = apart if best is None else first.rank >= best
    number, count = f"stick share ranks {first.rank:.2f}", f"{own.recordings} recordings"
    if best is None and not apart and first.rank > _CHANCE:
        return Verdict("note", own.name, number, f"{target}: too few to tell", count)
    return Verdict("pass" if reached else "fail", own.name, number, target, count)


def tables(data: RecordedData) -> Iterator[Table]:
    """All detectors on each set; forces at slip, measured and foretold."""
    shares = map("{}, %".format, ("right", "found", "false", "early"))
    columns: tuple[str, ...] = ("detector", "by", *shares, "early by, s", "rank")
    for own in data.sets:
        rows = tuple(
            (
                each.detector,
                "us" if each.ours else "authors",
                *map(_share, (each.right, each.found, each.false, each.early)),
                *(NONE if v is None else f"{v:.2f}" for v in (each.lead_s, each.rank)),
            )
            for each in own.scores
        )
        caption = f"{own.name}: {own.recordings} recordings, {own.slips} with slip"
        caption += f", {own.unknown} more without a label" if own.unknown else ""
        caption += f". Published by the authors: {own.published}"
        yield Table(
            own.name.replace(" ", "-").replace(",", ""), caption, columns, rows, frozenset({0, 1})
        )
    if (law := data.friction) is not None:
        columns = ("weight, N", *(f"{each:.2f}" for each in law.weights_N), "lifts right, %")
        forces = {"slips slowly": (law.slow_N, NONE), "authors’ hand": (law.own_N, NONE)}
        for each in law.foretold:
            forces[f"{each.law}, n = {each.n:.2f}"] = each.slips_at_N, _share(each.right)
        rows = tuple((k, *(f"{f:.1f}" for f in own), end) for k, (own, end) in forces.items())
        caption = "Force of both fingers at slip, N"
        yield Table("forces", caption, columns, rows, frozenset({0}))


def _share(share: Share | None) -> str:
    if share is None or share.rate is None:
        return NONE
    low, high = (100.0 * end for end in _ends(share))
    return f"{100.0 * share.rate:.0f} ({low:.0f}–{high:.0f})"


def _ends(share: Share) -> tuple[float, float]:
    """The interval of a share; 0 to 1 of nothing."""
    return share.low or 0.0, 1.0 if share.high is None else share.high


def _figure(data: RecordedData) -> style.ReportFigure:
    count = len(data.sets) + (data.friction is not None)
    columns = 2 if count == 4 else min(count, 3)
    rows = -(-count // columns)
    figure = style.canvas(3.0 * columns, 2.2 * rows + 0.9)
    every = style.small_multiples(figure, count, columns)
    for axes, own in zip(every, data.sets, strict=False):
        _draw_scores(axes, own)
    if data.friction is not None:
        _draw_forces(every[-1], data.friction)
    style.shared_legend(every, columns)
    found = " ".join(f"{each.name}: {each.number}, {each.target}." for each in verdicts(data))
    return page.caption_drawing(figure, WORDS, "recorded_figure", "recorded", found=found)


def _draw_scores(axes: style.Axes, own: SetData) -> None:
    axes.set(title=own.name, xlabel="false alarms", ylabel="slip found")
    axes.set(xlim=(-0.03, 1.03), ylim=(-0.03, 1.05))
    axes.plot([0, 1], [0, 1], color=style.MUTED, ls=":", lw=1.0)
    for each, (colour, _, marker) in zip(own.scores, style.SERIES, strict=False):
        x, y = each.false, each.found
        if x.rate is None or y.rate is None:
            continue
        look = style.points(colour, marker, 6, each.detector, lw=1.0)
        look |= {"mfc": colour if each.ours else style.PAPER}
        for name, rate, (low, high) in (("xerr", x.rate, _ends(x)), ("yerr", y.rate, _ends(y))):
            look[name] = [[rate - low], [high - rate]]
        axes.errorbar([x.rate], [y.rate], **look)


def _draw_forces(axes: style.Axes, law: FrictionData) -> None:
    axes.set(title="friction", xlabel="weight (N)", ylabel="force at slip (N)")
    for each, (colour, dashes, _) in zip(law.foretold, style.SERIES, strict=False):
        axes.plot(law.weights_N, each.slips_at_N, color=colour, ls=dashes, label=each.law)
    axes.plot(law.weights_N, law.slow_N, **style.points(style.INK, "o", 6, "slips slowly"))
    hand = style.points(style.INK, "o", 6, "authors’ hand", mfc=style.PAPER)
    axes.plot(law.weights_N, law.own_N, **hand)
    axes.set_ylim(bottom=0.0)
