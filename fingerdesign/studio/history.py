"""Undo and redo: the states of a page between its changes."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Self

from fingerdesign.studio.document import Document

_ONE_CHANGE_S = 1.0  # Moves of one slider within this time are one change.
_MOST = 200  # States.


@dataclass(frozen=True)
class State:
    """A document, its changes that were not saved, and the values of the controls."""

    document: Document
    text: str
    draft: str | None
    unsaved: dict[str, Any]
    values: dict[str, Any]

    @classmethod
    def of(cls, document: Document, values: dict[str, Any]) -> Self:
        """The present state."""
        return cls(document, document.text, document.draft, dict(document.unsaved), dict(values))

    def restored(self) -> Document:
        """The document with the design of this state. What was saved since stays in the file: the
        difference is unsaved then. DesignError where the state before a save was faulty."""
        document = self.document
        if document.text == self.text:
            document.draft, document.unsaved = self.draft, dict(self.unsaved)
        else:
            former = replace(document, text=self.text, draft=self.draft, unsaved=dict(self.unsaved))
            document.take(former.design())
        return document


@dataclass
class History:
    """States to go back to, and forward again after that."""

    back: list[State] = field(default_factory=list)
    forward: list[State] = field(default_factory=list)
    clock: Callable[[], float] = time.monotonic
    _keys: frozenset[str] = frozenset()
    _last: float = 0.0

    def record(self, before: State, keys: frozenset[str] = frozenset()) -> None:
        """Store the state before a change of ``keys``; a slider that moves on is one change."""
        now = self.clock()
        same = bool(keys) and keys == self._keys and now - self._last < _ONE_CHANGE_S
        self._keys, self._last = keys, now
        self.forward.clear()
        if not same:
            self.back = [*self.back, before][-_MOST:]

    def undo(self, now: State) -> State | None:
        """The state before the last change; None where there is none."""
        return self._move(self.back, self.forward, now)

    def redo(self, now: State) -> State | None:
        """The state after the change that was undone last; None where there is none."""
        return self._move(self.forward, self.back, now)

    def _move(self, out: list[State], into: list[State], now: State) -> State | None:
        if not out:
            return None
        into.append(now)
        self._keys = frozenset()
        return out.pop()
