"""``fingerdesign view``: a design drawn, or a result in the terminal, and where its report is."""

import shlex
import textwrap
from dataclasses import asdict, dataclass
from pathlib import Path

from jinja2 import TemplateError

from fingerdesign.analysis.answers import ARRAYS, DESIGN, PAGE
from fingerdesign.analysis.page.sketch import draw_sketch, facts
from fingerdesign.analysis.page.tables import detail_tables
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.design.shipped import shipped_names
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import ResultError
from fingerdesign.records.result import Result
from fingerdesign.records.result_files import RESULT_FILE, read_result
from fingerdesign.records.verdict import SIGNS, VerdictView
from fingerdesign.report import style
from fingerdesign.report.table import Table
from fingerdesign.runtime.files import write_whole
from fingerdesign_cli import terminal
from fingerdesign_cli.inputs import read_case
from fingerdesign_cli.looks import Kind, Look, kind_of, look_at, marked

_DRAWING = "a dimensioned drawing"  # in the words of each: by them its file is known
_WRONG = (
    *(ValueError, TypeError, AttributeError, LookupError, ArithmeticError, RecursionError),
    StopIteration,  # of what holds nothing
)


def view(target: Path, out: Path, cad: bool) -> None:
    """Draw a design, or show the result in a folder, or each result in the folders inside it."""
    if target.is_dir() or _known(target):
        try:
            _show_results(target, cad)
        except ResultError as error:
            raise DesignError([Fault("DIR", target, "a whole result", str(error))]) from error
    elif target.exists() or target.suffix == ".toml" or str(target) in shipped_names("design"):
        _draw(target, out)
    else:
        bound = "a design's file, a shipped design's name, or a folder that a command wrote"
        remedy = "`fingerdesign list designs` names what is shipped"
        raise DesignError([Fault("DESIGN|DIR", target, bound, remedy)])


def _draw(design_file: Path, out: Path) -> None:
    """Write the dimensioned drawing of a design to OUT/NAME.svg and OUT/NAME.png."""
    design, _ = read_case(design_file)
    name = design.design.name
    files = [out / f"{name}.svg", out / f"{name}.png"]
    if files[0].is_file() and _DRAWING not in files[0].read_text("utf-8", "replace"):
        bound = f"a folder without {files[0].name}, which no command has written"
        raise DesignError([Fault("--out", str(out), bound, "choose another --out")])
    words = facts(design)
    with style.house_style():
        drawing = draw_sketch(design)
        png = style.to_png(drawing)
        svg = style.to_svg(drawing, "sketch", f"{name}, {_DRAWING}: {'; '.join(words)}")
    out.mkdir(parents=True, exist_ok=True)
    write_whole(files[0], svg)
    write_whole(files[1], png)
    about = {"design": name, "facts": words, "files": [str(path) for path in files]}
    terminal.say_done(about, f"drawn: {files[0]}, {files[1]}", files[0])


def _show_results(folder: Path, cad: bool) -> None:
    views = [_view(place) for place in _places(folder)]
    for each in views:
        if isinstance(each, _View):
            _complete(
                each.place, terminal.opens() or not (terminal.quiet() or terminal.as_json()), cad
            )
    terminal.say_result(lambda: [_summary(each) for each in views], lambda: _show_all(views))
    for each in views:
        if each.report is not None:
            terminal.open_page(Path(each.report))


def _complete(place: Path, page: bool, cad: bool) -> None:
    """Draw what is missing; a result without arrays is shown without."""
    if (cad or page) and (place / ARRAYS).is_file():
        from fingerdesign.analysis.folder import complete

        try:
            complete(place, page, cad)
        except (*_WRONG, TemplateError, OSError) as error:
            why = f"{type(error).__name__}: {error}"[:200]
            raise ResultError(f"{place}: its report cannot be drawn: {why}") from error


def _places(folder: Path) -> list[Path]:
    """DIR itself, or what is known right inside it."""
    if _known(folder):
        return [folder]
    inside = sorted(folder.iterdir()) if folder.is_dir() else []
    if found := [each for each in inside if not each.name.startswith(".") and _known(each)]:
        return found
    pages = [e for e in inside if e.suffix == ".html" and e.is_file() and e.name[0] != "."]
    remedy = "give DIR/NAME of what was written, or the DIR that it got as --out"
    if pages:  # of a search that has found no finger yet
        remedy = f"{shlex.quote(str(pages[0]))} is a page: open it in a browser"
    bound = "a folder that a command wrote, or that holds such folders"
    raise DesignError([Fault("DIR", folder, bound, remedy)])


def _known(place: Path) -> bool:
    return _has_result(place) or kind_of(place) is not None


def _has_result(place: Path) -> bool:
    """Tell whether there is a record, or a pipe in its place, which reading then refuses."""
    record = place / RESULT_FILE
    return record.exists() and not record.is_dir()


@dataclass(frozen=True)
class _View:
    place: Path
    result: Result
    tables: tuple[Table, ...]

    @property
    def report(self) -> str | None:
        """Path of its report, if it is there."""
        report = self.place / PAGE
        return str(report) if report.is_file() else None


@dataclass(frozen=True)
class _Other:
    """A folder, or a page, that is no result."""

    place: Path
    kind: Kind
    look: Look

    @property
    def report(self) -> str | None:
        """The page or picture that shows it, if it is there."""
        page = self.place if self.place.is_file() else self.place / self.kind.page
        return str(page) if page.is_file() else None


def _view(place: Path) -> _View | _Other:
    """Read what is shown of a folder; DesignError where its values cannot be shown."""
    try:
        if not _has_result(place):
            kind = kind_of(place)
            assert kind is not None
            return _Other(place, kind, look_at(kind, place))
        result = read_result(place)
        return _View(place, result, detail_tables(result))
    except (*_WRONG, TemplateError) as error:
        lacks = isinstance(error, KeyError)  # whose text is the key
        why = f"it has no {error}" if lacks else f"{type(error).__name__}: {error}"[:200]
        bound = "a result whose values can be shown"
        remedy = f"{why}; run its command again"
        raise DesignError([Fault("RESULT", place, bound, remedy)]) from error


def _summary(view: _View | _Other) -> dict[str, object]:
    if isinstance(view, _Other):
        place = {"folder": str(view.place), "report": view.report}
        return {**place, "record": view.kind.record, **view.look.data()}
    facts = ("design", "scene", "fidelity", "status", "failure")
    found = _verdicts(view)
    return {
        "folder": str(view.place),
        "report": view.report,
        **{key: getattr(view.result, key) for key in facts},
        "warnings": list(view.result.warnings),
        "verdicts": [asdict(each) for each in found.verdicts],
        "fixes": [asdict(each) for each in found.fixes],
    }


def _show(view: _View | _Other) -> None:
    """A result's block, or what was found in another folder; with --details all of it."""
    if isinstance(view, _Other):
        look = view.look
        terminal.say("\n".join(textwrap.wrap(look.what, terminal.WIDTH - 6)), bold=True)
        for sign, sentence in marked(look, whole=terminal.details()):
            terminal.say_marked(sign, sentence)
        if look.rows:
            terminal.print_table("", look.headings, look.rows, terminal.WIDTH)
        if view.report:
            terminal.say(f"report: {view.report}")
        return
    terminal.say_block(_verdicts(view), view.place)
    if terminal.details():
        terminal.say_details(view.result.warnings, view.tables)


def _verdicts(view: _View) -> VerdictView:
    return verdict_view(view.result, shlex.quote(str(view.place / DESIGN)))


def _show_line(view: _View | _Other) -> None:
    """One line for one of several results: a sign, the folder, and what fails."""
    if isinstance(view, _Other):
        bad = [terminal.shortened(each) for each in view.look.bad]
        words, good = [view.look.what, *bad[:1]], bool(view.look.good)
    else:
        found = _verdicts(view)
        bad = [each.name for each in found.verdicts if each.status == "fail"]
        words = [found.fidelity, f"{found.seconds:.0f} s", found.summary, ", ".join(bad)]
        bad += [found.failure] if found.failure else []
        good = "pass" in {each.status for each in found.verdicts}
    sign = SIGNS["fail" if bad else "pass" if good else "note"]
    terminal.say(terminal.shortened(f"{sign} {view.place.name}: {' · '.join(filter(None, words))}"))


def _show_all(views: list[_View | _Other]) -> None:
    """One result in full; of several a line each, but with --details all of each."""
    show = _show if len(views) == 1 or terminal.details() else _show_line
    for each in views:
        show(each)
