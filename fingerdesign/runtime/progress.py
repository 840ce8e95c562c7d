"""How long work says what it is doing: one line of plain text at a time."""

from collections.abc import Callable

Report = Callable[[str], None]
