"""State and actions of one open page, without the page: moves, answers, pins, saves.

A session is worked by one thread; what it shows is a dict of plain values, ready for the browser.
"""

import time
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.design.keys import leaves
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import shipped_names
from fingerdesign.errors import DesignError, FingerDesignError
from fingerdesign.records.verdict import VerdictView
from fingerdesign.studio.document import Document
from fingerdesign.studio.engine import Engine
from fingerdesign.studio.figures import bars, section, shape, trace, tractions
from fingerdesign.studio.history import History, State
from fingerdesign.studio.judge import PLANE, SPACE
from fingerdesign.studio.numbers import Numbers
from fingerdesign.studio.passing import Progress, default_trials
from fingerdesign.studio.sliders import Press, Slider, Value, renewed, sliders_of
from fingerdesign.studio.words import finding, table

FLAT, DEEP = "plane strain, coarse section", "3-D"
_COMMAND = "fingerdesign "  # A fix that begins so is a command, not a key.
Shown = dict[str, Any]


@dataclass(frozen=True)
class Pinned:
    """A state that is shown next to the present one."""

    design: Design
    values: dict[str, Value]
    numbers: Numbers
    model: str


class Session:
    """One design on one page."""

    def __init__(self, name: Path | None = None) -> None:
        self.document = Document.of(name)
        self.design = self.document.design()
        self.sliders: tuple[Slider, ...] = sliders_of(self.design)
        self.values: dict[str, Value] = {each.key: each.value for each in self.sliders}
        self.engine = Engine(reach=self.values_of("approach").high)
        self.history = History()
        self.numbers: Numbers | None = None
        self.pinned: Pinned | None = None
        self.picked: int | None = None
        self.model = FLAT
        self.faults: list[str] = []
        self.searching: Progress | None = None  # also the last one, once it has ended
        self._file_faults: list[str] = []
        self._shapes: dict[str, Shown | None] = {}
        self._views: dict[tuple[str, str], VerdictView | str] = {}

    def values_of(self, key: str) -> Slider:
        """The slider of that key."""
        return next(each for each in self.sliders if each.key == key)

    @property
    def press(self) -> Press:
        """Motion of the object."""
        return Press.of(self.values)

    def start(self) -> Shown:
        """Everything, for a page that opens."""
        trials = default_trials(self.design)
        return {"starts": list(shipped_names()), "trials": trials, **self._replaced()}

    def move(self, values: Mapping[str, Any]) -> Shown:
        """Controls were moved: the new answer, in plane strain. Unknown keys are passed over."""
        given = {each.key: each.allowed(values.get(each.key)) for each in self.sliders}
        changed = {k: v for k, v in given.items() if v is not None and v != self.values[k]}
        if changed:
            self._record(frozenset(changed))
            self.values |= changed
            self._put({key: value for key, value in changed.items() if "." in key})
        return self.answer()

    def _put(self, values: dict[str, Any]) -> None:
        """Set keys of the design, and those that would misfit without."""
        plates, gages = self.design.plates, self.design.gages
        depth = values.get("body.depth_mm")
        if depth is not None and plates.span_mm == self.design.body.depth_mm:
            values["plates.span_mm"] = depth  # Plates of full span stay so.
        if values.get("gages.grid", "tee") != "tee" and gages.transverse_weight is not None:
            values["gages.transverse_weight"] = None
        self.document.put(values)

    def apply(self, change: str) -> Shown:
        """Make a change that a shown verdict proposes: a key and its value."""
        view = self.view()
        if view is None or change not in (each.change for each in view.fixes):
            return {}
        self._record()
        self._put(dict(leaves(tomllib.loads(change))))
        return self._replaced()

    def begin_from(self, name: str) -> Shown:
        """Begin from a shipped finger."""
        if name not in shipped_names():
            return {}
        self._record()
        self.document = Document.of(Path(name))
        self.numbers, self.picked = None, None
        return self._replaced(fresh=True)

    def undo(self) -> Shown:
        """Take the last change back."""
        return self._restored(self.history.undo(self._state()))

    def redo(self) -> Shown:
        """Make the change again that was taken back last."""
        return self._restored(self.history.redo(self._state()))

    def begin_search(self) -> Shown:
        """A search for a passing finger begins."""
        self._record()
        self.searching = Progress()
        return self.shown() | {"note": ""}

    def follow(self, progress: Progress) -> Shown:
        """Take the best finger of a search so far."""
        before, self.searching = self.searching, progress
        best, view = progress.best, progress.view
        if best is None or view is None:
            return self.shown()
        if progress.confirmed:
            self.store(best, SPACE, view)
        if before is not None and before.best == best:
            return self.shown()
        self.document.take(best)
        return self._replaced()

    def store(self, design: Design, fidelity: str, view: VerdictView | str) -> Shown:
        """A design was judged; a sentence where it could not be."""
        self._views = dict(list(self._views.items())[-60:])
        self._views[design.digest(), fidelity] = view
        return self.shown()

    def view(self) -> VerdictView | None:
        """The verdicts on the present design: in 3-D where they are known."""
        found = (self._views.get((self.design.digest(), each)) for each in (SPACE, PLANE))
        return next((each for each in found if isinstance(each, VerdictView)), None)

    def is_judged(self) -> bool:
        """True if there is an answer for the present design, in either model."""
        digest = self.design.digest()
        return any((digest, each) in self._views for each in (SPACE, PLANE))

    def _state(self) -> State:
        return State.of(self.document, self.values)

    def _record(self, keys: frozenset[str] = frozenset()) -> None:
        self.searching = None
        self.history.record(self._state(), keys)

    def _restored(self, state: State | None) -> Shown:
        if state is None:
            return {}
        self.searching = None
        fresh = state.document is not self.document
        with suppress(DesignError):  # else the present design stays
            self.document = state.restored()
        if fresh:
            self.numbers, self.picked = None, None
        self.values = dict(state.values)
        return self._replaced(fresh)

    def _replaced(self, fresh: bool = False) -> Shown:
        """Controls and answer for the document's design; fresh: controls with their own ends."""
        if fresh:
            self.design = self.document.design()
            self._renew(fresh)
        found = self.answer()
        own = {"name": self.design.design.name, "file": str(self.document.path)}
        return {**found, **own, "values": dict(self.values), "note": ""}

    def _renew(self, fresh: bool = False) -> None:
        """Make the controls of the present design; values of the object stay between the ends."""
        new = sliders_of(self.design)
        self.sliders = new if fresh else renewed(self.sliders, new)
        values = dict(leaves(self.design.model_dump(mode="json")))
        before, self.values = self.values, {}
        for each in self.sliders:
            known = values[each.key] if each.of_design else before.get(each.key, each.value)
            found = known if each.of_design else each.allowed(known)
            self.values[each.key] = each.value if found is None else found
        self.engine.reach = self.values_of("approach").high

    def answer(self) -> Shown:
        """Numbers in plane strain; where there are none, why, and the picture before stays."""
        begin = time.perf_counter()
        try:
            self.design = self.document.design()
            self._renew()
            self.numbers = self.engine.numbers(self.design, self.press)
            self.model, self.faults = FLAT, []
        except DesignError as error:
            self.faults = [str(fault) for fault in error.faults]
        except FingerDesignError as error:
            self.faults = [str(error)]
        self.faults = [*self._file_faults, *self.faults]
        if self.picked is None and self.numbers is not None and len(self.numbers.gage_x):
            self.picked = int(np.abs(self.numbers.signals).argmax())
        return self.shown() | {"took_ms": round(1e3 * (time.perf_counter() - begin))}

    def deep(self, numbers: Numbers) -> Shown:
        """3-D has answered: its numbers take the place of plane strain's."""
        self.numbers, self.model = numbers, DEEP
        return self.shown()

    def pick(self, plate: int) -> Shown:
        """A gage was clicked."""
        if self.numbers is not None and 0 <= plate < len(self.numbers.gage_x):
            self.picked = plate
        return self.shown()

    def pin(self) -> Shown:
        """Pin the present state next to what follows, or remove the pin."""
        if self.pinned is not None:
            self.pinned = None
        elif self.numbers is not None:
            self.pinned = Pinned(self.design, dict(self.values), self.numbers, self.model)
        return self.shown()

    def save(self) -> Shown:
        """Write the file; what was written, or why not, as ``note``."""
        try:
            note = f"saved {self.document.save()}"
        except (FingerDesignError, OSError, ValueError) as error:  # TOML beyond what tomlkit edits
            note = f"not saved: {error}"
        return self.shown() | {"note": note, "file": str(self.document.path)}

    def look(self) -> Shown:
        """Take over a change of the file; empty where it has not changed."""
        before = self._state()
        try:
            changed = self.document.changed()
        except DesignError as error:
            return self._refused([f"the file: {fault}" for fault in error.faults])
        mended, self._file_faults = bool(self._file_faults), []
        if not changed:
            return self.answer() if mended else {}  # it is as it was before
        self.history.record(before)
        self.numbers, self.picked = None, None
        return self._replaced() | {"note": "the file has changed: taken over"}

    def _refused(self, found: list[str]) -> Shown:
        """The file has faults: they are shown, once, and its former content stays."""
        if found == self._file_faults:
            return {}
        other = [each for each in self.faults if each not in self._file_faults]
        self._file_faults, self.faults = found, [*found, *other]
        return self.shown()

    def shown(self) -> Shown:
        """The page's pictures and words of the present state."""
        now, pinned = self.numbers, self.pinned
        before = pinned.numbers if pinned is not None else None
        found: Shown = {
            "model": self.model,
            "faults": self.faults,
            "unsaved": self.document.changes(),
            "sliders": [each.data() for each in self.sliders],
            "undo": len(self.history.back),
            "redo": len(self.history.forward),
            "search": _search_data(self.searching),
            **self._judged(),
            "picked": self.picked,
            "pinned": self._pinned_words(),
            "sketch": section(self.design, now, self.picked),
            "sketch_before": "" if pinned is None else section(pinned.design, before),
            "shape": self._shape(self.design),
            "shape_before": None if pinned is None else self._shape(pinned.design),
        }
        if now is not None:
            found |= {
                "tractions": tractions(now, before),
                "bars": bars(now, self.picked, before),
                "trace": trace(now, self.picked, before),
                "finding": finding(now),
                "table": table(now, before),
            }
        return found

    def _shape(self, design: Design) -> Shown | None:
        """The finger in space, drawn once a design."""
        name = design.digest()
        if name not in self._shapes:
            self._shapes = dict(list(self._shapes.items())[-4:])
            self._shapes[name] = shape(design)
        return self._shapes[name]

    def _pinned_words(self) -> str:
        """List the changes since the pin: "plate angle 45 to 30 °, friction 0.5 to 0.3"."""
        if self.pinned is None:
            return ""
        was, now = self.pinned.values, self.values
        changed = [
            f"{each.label} {_short(was[key])} → {_short(now[key])} {each.unit}".strip()
            for each in self.sliders
            if (key := each.key) in was and was[key] != now[key]
        ]
        return f"pinned ({self.pinned.model}); since then: {', '.join(changed) or 'nothing'}"

    def _judged(self) -> Shown:
        """The verdicts on the present design, and changes that help."""
        view, digest = self.view(), self.design.digest()
        words = self._views.get((digest, PLANE), "")
        if view is None:
            found: Shown = {"verdicts": [], "fixes": [], "judged": "", "summary": ""}
            return found | {"unjudged": words if isinstance(words, str) else ""}
        return {
            "verdicts": _verdicts(view),
            "fixes": [
                {"change": each.change, "effect": each.effect}
                for each in view.fixes
                if not each.change.startswith(_COMMAND)
            ],
            "judged": view.fidelity,
            "summary": view.summary,
            "unjudged": view.failure or "",
        }


def _search_data(progress: Progress | None) -> Shown | None:
    """A search for the page."""
    if progress is None:
        return None
    found: Shown = {"message": progress.message, "conflict": progress.conflict}
    if (view := progress.view) is None:
        return found | {"model": "", "summary": "", "verdicts": []}
    return found | {"model": view.fidelity, "summary": view.summary, "verdicts": _verdicts(view)}


def _verdicts(view: VerdictView) -> list[Shown]:
    return [{**asdict(each), "sign": each.sign} for each in view.verdicts]


def _short(value: Value) -> str:
    return value if isinstance(value, str) else f"{value:g}"
