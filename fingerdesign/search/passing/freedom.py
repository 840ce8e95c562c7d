"""Keys that the user of a search keeps, and those that he frees besides the search's own."""

import difflib
from dataclasses import dataclass
from typing import Any

from fingerdesign.design.keys import leaves
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.search.study.values import is_number


@dataclass(frozen=True)
class Freedom:
    """Keys that the user keeps, and that he frees: dotted keys, or tables such as "plates"."""

    keep: tuple[str, ...] = ()
    free: tuple[str, ...] = ()

    def allows(self, key: str) -> bool:
        """True if none of the keys and tables to keep contains the key."""
        return not any(key == each or key.startswith(f"{each}.") for each in self.keep)

    def holds(self, key: str) -> bool:
        """True if the user keeps the key or frees it: the search sets it by no rule of its own."""
        return key in self.free or not self.allows(key)

    def faults(self, design: Design) -> list[Fault]:
        """Faults of keys that the design does not have, or that cannot vary."""
        data = design.model_dump(mode="json")
        known = dict(leaves(data))
        parts = (key.split(".")[:-1] for key in known)
        tables = {".".join(each[: k + 1]) for each in parts for k in range(len(each))}
        found = []
        options = ("--keep", self.keep, {*known, *tables}), ("--free", self.free, {*known})
        for option, keys, own in options:
            for key in (each for each in keys if each not in own):
                near = difflib.get_close_matches(key, own, 1)
                remedy = f"did you mean '{near[0]}'?" if near else "see docs/reference/keys.md"
                if key in tables:
                    remedy = "it is a table: name its keys, one --free for each"
                found.append(Fault(option, key, "a key of the design", remedy))
        return found + [
            Fault("--free", key, *refused)
            for key in self.free
            if key in known and (refused := self._refused(key, known[key]))
        ]

    def _refused(self, key: str, value: Any) -> tuple[str, str] | None:
        """Bound and remedy of a key that cannot vary."""
        if not is_number(value):
            return "a key with a number", "only numbers can vary between bounds"
        if not value:
            return "a key that is not 0", "it varies by 0.7 to 1.4 times; set a number"
        if key.startswith("mesh."):
            return "a key of the finger", "an element's size would vary the error"
        kept = "a key that is not kept", "leave out --keep or --free of it"
        return None if self.allows(key) else kept
