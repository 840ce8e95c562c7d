"""State and actions of one open page, without the page: moves, answers, pins, saves.

A session is worked by one thread; what it shows is a dict of plain values, ready for the browser.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.design.keys import leaves
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, FingerDesignError
from fingerdesign.studio.document import Document
from fingerdesign.studio.engine import Engine
from fingerdesign.studio.figures import bars, section, shape, trace, tractions
from fingerdesign.studio.numbers import Numbers
from fingerdesign.studio.sliders import Press, Slider, sliders_of
from fingerdesign.studio.verdict import table, verdict

FLAT, DEEP = "plane strain, coarse section", "3-D"
Shown = dict[str, Any]


@dataclass(frozen=True)
class Pinned:
    """A state that is shown next to the present one."""

    design: Design
    values: dict[str, float]
    numbers: Numbers
    model: str


class Session:
    """One design on one page."""

    def __init__(self, name: Path | None = None) -> None:
        self.document = Document.of(name)
        self.design = self.document.design()
        self.sliders: tuple[Slider, ...] = sliders_of(self.design)
        self.values = {each.key: each.value for each in self.sliders}
        self.engine = Engine(reach=self.values_of("approach").high)
        self.numbers: Numbers | None = None
        self.pinned: Pinned | None = None
        self.picked: int | None = None
        self.model = FLAT
        self.faults: list[str] = []
        self._file_faults: list[str] = []
        self._shapes: dict[str, Shown | None] = {}

    def values_of(self, key: str) -> Slider:
        """The slider of that key."""
        return next(each for each in self.sliders if each.key == key)

    @property
    def press(self) -> Press:
        """Motion of the object."""
        return Press.of(self.values)

    def start(self) -> Shown:
        """Everything, for a page that opens."""
        return {
            "name": self.design.design.name,
            "file": str(self.document.path),
            "sliders": [each.data() for each in self.sliders],
            "values": dict(self.values),
            "note": "",
            **self.answer(),
        }

    def move(self, values: Mapping[str, Any]) -> Shown:
        """Sliders were moved: the new answer, in plane strain. Unknown keys are passed over."""
        for key, value in values.items():
            if not (key in self.values and isinstance(value, int | float)):
                continue
            if -math.inf < value < math.inf:  # an integer may be too large for a float
                slider = self.values_of(key)
                self.values[key] = float(min(max(value, slider.low), slider.high))
        keys = {each.key: self.values[each.key] for each in self.sliders if each.of_design}
        self.document.put(keys)
        return self.answer()

    def answer(self) -> Shown:
        """Numbers in plane strain; where there are none, why, and the picture before stays."""
        begin = time.perf_counter()
        try:
            self.design = self.document.design()
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
        try:
            changed = self.document.changed()
        except DesignError as error:
            return self._refused([f"the file: {fault}" for fault in error.faults])
        if not changed:
            if not self._file_faults:
                return {}
            self._file_faults = []  # mended, and as it was before
            return self.answer()
        self._file_faults = []
        self.design = self.document.design()
        values = dict(leaves(self.design.model_dump(mode="json")))
        object_part = [each for each in self.sliders if not each.of_design]
        own = [each for each in sliders_of(self.document.saved_design()) if each.of_design]
        self.sliders = (*object_part, *own)
        self.values = {
            each.key: float(values[each.key]) if each.of_design else self.values[each.key]
            for each in self.sliders
        }
        self.numbers, self.picked = None, None
        return self.start() | {"note": "the file has changed: taken over"}

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
            "unsaved": len(self.document.unsaved),
            "picked": self.picked,
            "pinned": self._pinned_words(),
            "sketch": section(self.design, now, self.picked),
            "sketch_before": section(pinned.design, before) if pinned is not None else "",
            "shape": self._shape(self.design),
            "shape_before": self._shape(pinned.design) if pinned is not None else None,
        }
        if now is not None:
            found |= {
                "tractions": tractions(now, before),
                "bars": bars(now, self.picked, before),
                "trace": trace(now, self.picked, before),
                "verdict": verdict(now),
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
        was = self.pinned.values
        changed = [
            f"{each.label} {was[each.key]:g} → {self.values[each.key]:g} {each.unit}".strip()
            for each in self.sliders
            if each.key in was and was[each.key] != self.values[each.key]
        ]
        return f"pinned ({self.pinned.model}); since then: {', '.join(changed) or 'nothing'}"
