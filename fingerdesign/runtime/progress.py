"""How long work says what it is doing: one line of plain text at a time."""

from __future__ import annotations

from collections.abc import Callable

Report = Callable[[str], None]
