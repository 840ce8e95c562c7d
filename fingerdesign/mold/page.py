"""A mold's report.html: pictures and verdicts first, casting notes to tick, tables; printable."""

from collections.abc import Iterator

from fingerdesign.mold import tables
from fingerdesign.mold.base_plan import plan_svg, plan_words
from fingerdesign.mold.leads import MOST
from fingerdesign.mold.picture import Picture, Pictures
from fingerdesign.mold.products.hours import hours_words
from fingerdesign.mold.products.notes import percent
from fingerdesign.mold.ready import MOST_ERROR
from fingerdesign.mold.record import MoldData
from fingerdesign.mold.tables import TEMPLATES, WORDS
from fingerdesign.records.verdict import Fix, Status, Verdict, VerdictView
from fingerdesign.report.page import (
    Bullets,
    Fold,
    Item,
    Page,
    Section,
    Steps,
    Text,
    page_html,
)
from fingerdesign.report.style import ReportFigure, png_element

FASTENERS = ("bolt", "threaded rod", "nut", "washer", "dowel pin", "core pin", "core screw")


def mold_html(data: MoldData, pictures: Pictures | None, missing: str = "") -> str:
    """The page, from what mold_report.json holds; ``missing`` says why there are no pictures."""
    silicone = data["silicone"]["sentence"] if data["silicone"] else ""
    process = f"{WORDS['process'][data['process']['name']]}, {data['process']['cure']} cure"
    first = Text(missing) if pictures is None else _opened(pictures.opened)
    sections = (
        Section("findings", "Findings", list(_findings(data))),
        Section("parts", "Parts", list(_parts(data))),
        Section("notes", "Casting notes", list(_notes(data, pictures)), "notes"),
        Section("fixture", "Plates", list(_plates(data))),
        Section("bill", "Bill of materials", list(_bill(data))),
        Section("checks", "Checks", list(_checks(data))),
        Section("files", "Files", [Bullets(data["files"], "files"), _text("files", "words")]),
    )
    page = Page(
        title=f"{data['design']}: mold",
        heading=f"{data['design']}: mold",
        lead=" · ".join(filter(None, (process, silicone))),
        sections=[each for each in sections if each.items],
        record=list(_record(data)),
        first=first,
        view=VerdictView(data["design"], "", data["seconds"], tuple(_verdicts(data)), _fixes(data)),
        style=(TEMPLATES / "mold.css").read_text(encoding="utf-8"),
    )
    return page_html(page)


def _text(table: str, key: str, look: str = "quiet") -> Text:
    return Text(WORDS[table][key], look)


def _opened(picture: Picture) -> ReportFigure:
    """The mold opened, with the numbers of its parts."""
    badges = (
        f'<span class="badge" aria-hidden="true" style="left: {100 * badge.left:.2f}%; '
        f'top: {100 * badge.top:.2f}%">{badge.number}</span>'
        for badge in picture.badges
    )
    image = png_element(picture.png, picture.alternative)
    shown = f'<div class="exploded">{image}{"".join(badges)}</div>'
    words = WORDS["parts"]["picture"]
    return ReportFigure("opened", "The mold opened", shown, words, picture.alternative)


def _verdicts(data: MoldData) -> Iterator[Verdict]:
    """Can it be cast, is it a sensor then, and what it takes."""
    failing, checked = sum(not each["ok"] for each in data["checks"]), len(data["checks"])
    if data["failure"] is None:
        ready = "ready to cast" if data["sensor"]["ready"] else "can be cast"
        yield Verdict("pass", ready, f"All {checked} checks passed")
    elif not data["parts"]:
        yield Verdict("fail", "not made", data["failure"])
    else:
        number = f"{failing} of {checked} checks failed"
        yield Verdict("fail", "not ready", number, "see findings before anything is printed")
    gage, to_measure = data["sensor"]["gage"], data["sensor"]["to_measure"]
    yield from _effect("plates' places", data["sensor"]["reading_error"], MOST_ERROR)
    yield from _effect("leads", data["sensor"]["lead_error"], MOST)
    if data["plates"]:
        words = f"{gage}, {'made to measure' if to_measure else 'on sale'}"
        words = words if gage else "none on sale fits the plates"
        yield Verdict("pass" if gage else "fail", "gage", words)
    if data["parts"]:
        yield Verdict("note", "parts", f"{len(data['parts'])} parts and {_bolts(data)} bolts")
    if data["hours"]:
        yield Verdict("note", "hands-on", hours_words(data["hours"]))


def _effect(name: str, error: float | None, most: float) -> Iterator[Verdict]:
    """The change of a reading by a cause, where it is known."""
    if error is not None:
        status: Status = "fail" if error > most else "pass"
        number = f"a reading changes by up to {percent(error)}"
        yield Verdict(status, name, number, f"target ≤ {100 * most:.0f} %")


def _fixes(data: MoldData) -> tuple[Fix, ...]:
    lines = data["sensor"]["fix"]
    effect = "mends what is named" if len(lines) == 1 else "all of them mend what is named"
    return tuple(Fix(line, effect) for line in lines)


def _bolts(data: MoldData) -> int:
    return sum(each["count"] for each in data["bill"] if each["item"] in ("bolt", "threaded rod"))


def _findings(data: MoldData) -> Iterator[Item]:
    """Everything that failed, what it lacks as a sensor with what helps, and warnings."""
    failed = [each for each in data["checks"] if not each["ok"]]
    if failed:
        yield tables.checks_table("failed", "Failed", failed)
    reasons = [f"{each[:1].upper()}{each[1:].rstrip('.')}." for each in data["sensor"]["reasons"]]
    if found := [*reasons, *data["warnings"]]:
        yield Bullets(found, "warnings")


def _parts(data: MoldData) -> Iterator[Item]:
    if not data["parts"]:
        return
    words, process = WORDS["parts"], data["process"]
    yield Text(words[process["pour"]].format(why=process["closed_for"]))
    yield tables.parts_table(data)
    held = [each for each in data["bill"] if each["item"] in FASTENERS]
    if held:
        things = (
            f"{each['count']} {each['item']}{'s' * (each['count'] > 1)} ({each['size']})"
            for each in held
        )
        yield Text(f"To hold them together: {'; '.join(things)}.")
    shrunk = words["shrunk"].format(scale=data["scale"], percent=100 * data["shrinkage"])
    yield Text(f"{words['sizes']} {shrunk if data['shrinkage'] else words['size']}", "quiet")
    if data["base"]["holes"]:
        base, reading = data["base"], words[f"plan_{process['pour']}"]
        title = "Plan of the base plate"
        yield ReportFigure("base-plan", title, plan_svg(base), reading, plan_words(base))
        yield tables.holes_table(base["holes"])


def _notes(data: MoldData, pictures: Pictures | None) -> Iterator[Item]:
    """The casting notes, each step with its picture; the coupon's table after its section."""
    if not data["notes"]:
        return
    yield _text("notes", "first")
    drawn = {} if pictures is None else pictures.steps
    images = {place: png_element(each.png, each.alternative) for place, each in drawn.items()}
    before, first, *others = (
        Steps(
            section["title"],
            [(step, images.get((section["title"], k), "")) for k, step in enumerate(steps, 1)],
        )
        for section in data["notes"]
        for steps in [section["steps"]]
    )
    yield before
    yield first
    yield tables.coupon_table(data)
    yield from others


def _plates(data: MoldData) -> Iterator[Item]:
    if not data["placements"]:
        return
    if data["plates"]:
        yield tables.patterns_table(data)
    yield tables.fixture_table(data)
    if data["placement"]:
        known = data["placement"]["reason"] is None
        found: list[Item] = [tables.effects_table(data["placement"])] if known else []
        sentences = Bullets(data["placement"]["sentences"])
        yield Fold("What a plate off its place changes", [sentences, *found])
    yield tables.plates_table(data)


def _bill(data: MoldData) -> Iterator[Item]:
    """The order, with its texts, the rest, and the hours that it takes."""
    if not data["bill"]:
        return
    yield tables.bill_table(data)
    texts = [item["words"] for item in data["bill"] if item["words"]]
    yield Fold("Texts to send with the drawings", [Bullets(texts)])
    yield tables.hours_table(data)


def _checks(data: MoldData) -> Iterator[Item]:
    if not data["checks"]:
        return
    yield tables.kinds_table(data["checks"])
    if passed := [each for each in data["checks"] if each["ok"]]:
        yield Fold("Every check that passed", [tables.checks_table("passed", "Passed", passed)])
    yield tables.limits_table(data)
    yield _text("checks", "limits")


def _record(data: MoldData) -> Iterator[Item]:
    times = "".join(f", {name} {each:.1f} s" for name, each in data["timings_s"].items())
    yield Text(f"{data['seconds']:.1f} s in all{times}; {data['peak_memory_MB']:.0f} MB.")
    yield Text(f"Digest of the mold {data['digest']}, of the finger {data['design_digest']}.")
    versions = ", ".join(f"{name} {each}" for name, each in data["versions"].items())
    yield Text(f"Versions: {versions or 'not recorded'}.")
