"""recorded.html: our detectors next to the authors', and the law of friction, for offline use."""

from collections.abc import Iterator

from fingerdesign.records.statistics import Share
from fingerdesign.records.verdict import Verdict, VerdictView
from fingerdesign.report import style
from fingerdesign.report.page import Item, Page, Section, Text, caption_drawing, page_html, texts_of
from fingerdesign.report.table import Table
from fingerdesign.trials.figures import WORDS
from fingerdesign.trials.recorded.detect import ANSWER_S, SPAN_S
from fingerdesign.trials.recorded.friction import CONSTANT, Exponent, FrictionData
from fingerdesign.trials.recorded.sets import RecordedData, SetData

NONE = "–"


def recorded_html(data: RecordedData, seconds: float) -> str:
    """The page of a judgement."""
    words = texts_of(WORDS)["recorded"]
    notes = [Text(words["protocol"].format(span=SPAN_S, answer=ANSWER_S), "quiet")]
    if any(not each.ours for own in data.sets for each in own.scores):
        notes.append(Text(words["eflesh"], "quiet"))
    sections = [Section("slip", "Slip", [*map(slip_table, data.sets), *notes])] * bool(data.sets)
    figures: list[Item] = []
    with style.house_style():
        if data.sets:
            figures.append(_slip_figure(data.sets))
        if data.friction is not None:
            figures.append(_friction_figure(data.friction))
            items = [*figures[1:], friction_table(data.friction), Text(words["friction"], "quiet")]
            sections.append(Section("friction", "Friction by load", items))
    record: list[Item] = [Text(f"{each.name}: {each.source}.") for each in data.sets]
    if data.absent:
        files = ", ".join(data.absent)
        record.append(Text(words["absent"].format(files=files), "warnings"))
    count = sum(each.recordings for each in data.sets)
    return page_html(
        Page(
            title="Recordings of others",
            heading="Judged on what others measured",
            lead=f"{count} recordings · {data.folder} · {seconds:.0f} s",
            sections=sections,
            record=[*record, Text("Next to this file: recorded.json.", "quiet")],
            first=figures[0],
            view=VerdictView("recorded", "", seconds, tuple(verdicts(data))),
        )
    )


def verdicts(data: RecordedData) -> Iterator[Verdict]:
    """Of each set: whether our stick share ranks slip as well as the authors' detector, or better
    than chance where there is none; and the exponents of friction."""
    for own in data.sets:
        first, theirs = own.scores[0], [each.rank for each in own.scores if not each.ours]
        if first.rank is None:
            yield Verdict("note", own.name, "slip or rest is absent: nothing to rank")
            continue
        best = max((each for each in theirs if each is not None), default=None)
        target = "chance 0.50" if best is None else f"authors {best:.2f}"
        apart = _ends(first.found)[0] > _ends(first.false)[1]
        reached = apart if best is None else first.rank >= best
        count = f"{own.recordings} recordings"
        number = f"stick share ranks {first.rank:.2f}"
        yield Verdict("pass" if reached else "fail", own.name, number, target, count)
    if (law := data.friction) is not None:
        for name, each in (("whole contact", law.whole), ("single pillars", law.single)):
            holds = each.low <= CONSTANT <= each.high
            number = f"n = {_exponent(each)}"
            count = f"{each.count} slips"
            yield Verdict("pass" if holds else "fail", name, number, "theory 0.33", count)


def slip_table(own: SetData) -> Table:
    """All detectors on a set."""
    columns = ("detector", "by", "right, %", "found, %", "false, %", "early, %", "lead, s", "rank")
    rows = tuple(
        (
            each.detector,
            "us" if each.ours else "authors",
            *map(_share, (each.right, each.found, each.false, each.early)),
            NONE if each.lead_s is None else f"{each.lead_s:.2f}",
            NONE if each.rank is None else f"{each.rank:.2f}",
        )
        for each in own.scores
    )
    caption = f"{own.name}: {own.recordings} recordings, {own.slips} with slip"
    caption += f", {own.unknown} more of which nobody knows" if own.unknown else ""
    caption += f". Published by the authors: {own.published}"
    return Table(own.name.replace(" ", "-"), caption, columns, rows, frozenset({0, 1}))


def friction_table(law: FrictionData) -> Table:
    """Forces at slip of each weight, measured and foretold."""
    columns = ("both fingers, N", *(f"{each:.2f} N" for each in law.weights_N), "lifts right, %")
    rows = [
        ("slips slowly", *_forces(law.slow_N), NONE),
        ("authors’ hand", *_forces(law.own_N), NONE),
    ]
    rows += [
        (f"{each.law}, n = {each.n:.2f}", *_forces(each.slips_at_N), _share(each.right))
        for each in law.foretold
    ]
    caption = f"Exponent n: whole contact {_exponent(law.whole)}, single pillars "
    return Table("forces", caption + _exponent(law.single), columns, tuple(rows), frozenset({0}))


def _exponent(law: Exponent) -> str:
    return f"{law.value:.2f} ({law.low:.2f} to {law.high:.2f})"


def _share(share: Share | None) -> str:
    if share is None or share.rate is None:
        return NONE
    low, high = (100.0 * end for end in _ends(share))
    return f"{100.0 * share.rate:.0f} ({low:.0f}–{high:.0f})"


def _ends(share: Share) -> tuple[float, float]:
    """The interval of a share; 0 to 1 of nothing."""
    return share.low or 0.0, 1.0 if share.high is None else share.high


def _slip_figure(sets: tuple[SetData, ...]) -> style.ReportFigure:
    figure = style.canvas(7.2, 3.4)
    every = style.small_multiples(
        figure, len(sets), len(sets), "false alarms", "slip found", sharex=True, sharey=True
    )
    found = []
    for axes, own in zip(every, sets, strict=True):
        axes.set_title(own.name)
        axes.plot([0, 1], [0, 1], color=style.MUTED, ls=":", lw=1.0)
        for k, each in enumerate(own.scores):
            x, y = each.false.rate, each.found.rate
            if x is None or y is None:
                continue
            across, up = (
                [[rate - _ends(share)[0]], [_ends(share)[1] - rate]]
                for rate, share in ((x, each.false), (y, each.found))
            )
            colour, _, marker = style.SERIES[k]
            face = colour if each.ours else style.PAPER
            axes.errorbar(
                [x],
                [y],
                up,
                across,
                color=colour,
                marker=marker,
                mfc=face,
                ms=6,
                lw=1.0,
                ls="none",
                label=each.detector,
            )
            found.append(f"{own.name}, {each.detector}: {y:.2f} found, {x:.2f} false.")
    every[0].set_xlim(-0.03, 1.03)
    every[0].set_ylim(-0.03, 1.05)
    style.shared_legend(every, 2)
    return caption_drawing(figure, WORDS, "recorded_slip", found=" ".join(found))


def _friction_figure(law: FrictionData) -> style.ReportFigure:
    figure = style.canvas(7.2, 3.2)
    axes = figure.subplots()
    weights = list(law.weights_N)
    for k, each in enumerate(law.foretold):
        name = f"{each.law}, n = {each.n:.2f}"
        style.series(axes, weights, each.slips_at_N, k, name, marker="")
    axes.plot(weights, law.slow_N, **style.points(style.INK, "o", 6, "slips slowly"))
    axes.plot(
        weights, law.own_N, **style.points(style.INK, "o", 6, "authors’ hand", mfc=style.PAPER)
    )
    axes.set_xlabel("weight (N)")
    axes.set_ylabel("force of both fingers (N)")
    axes.set_ylim(bottom=0.0)
    style.shared_legend([axes], 3)
    found = f"The whole contact has n = {_exponent(law.whole)}."
    return caption_drawing(figure, WORDS, "recorded_friction", found=found)
