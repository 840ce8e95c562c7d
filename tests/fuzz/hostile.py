"""What a stranger, a full disk or a slip of the hand makes of a file; the same for the same chance.

Bytes are flipped, cut, doubled and put in; values of tables are set to what is no value; in the
place of a file comes a folder, a pipe, a link, a device or a giant.
"""

import copy
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

Chance = np.random.Generator
NAN, INF = float("nan"), float("inf")
VALUES: tuple[Any, ...] = (
    *(NAN, INF, -INF, 0, -1, 1, 0.5, 1e-300, 5e-324, 1e308, -1e308, 1e18, 2**63, -(2**63), 10**40),
    *(True, False, "", " ", "x" * 5000, "\u202egnp.exe", "a\u0000b", "\ud7ff", "\x1b[31m", "\n"),
    *[
        "../../etc/passwd",
        "/dev/zero",
        "con",
        "nul.toml",
        "-1",
        "nan",
        "=1+1",
        "<script>",
        "{{7*7}}",
    ],
    *("maeno2000", "plane", "cylinder", "step", "dome", "none", "sheet", "file", "os:system"),
    *([], {}, [[]], [0.0], [[0.1, 0.0]], [[NAN, INF]], [1] * 1000, [[0.1]] * 200, {"a": {"b": 1}}),
)
TOKENS = (
    *b"\x00 \xff\xfe \xef\xbb\xbf \r \n[ ] { \" ''' = , #".split(b" "),
    *(b"nan", b"-inf", b"1e999", b"9" * 400, b"0x", b"1_0", b"1979-05-27", b"\x1b[2J", b"NaN"),
    *(b"[" * 3000, b"{a=" * 500, b"a." * 500, b'"' * 200, "\u202e".encode(), b"\xed\xa0\x80"),
)


def spoiled(content: bytes, chance: Chance) -> bytes:
    """The content with one to four small faults."""
    for _ in range(int(chance.integers(1, 5))):
        at, to = sorted(int(each) for each in chance.integers(0, len(content) + 1, 2))
        kind = int(chance.integers(6))
        if kind == 0:
            content = _flipped(content, chance)
        elif kind == 1:
            content = content[:to]
        elif kind == 2:
            content = content[:at] + content[min(to, at + 40) :]
        elif kind == 3:
            content = content[:to] + content[at:to] + content[to:]
        elif kind == 4:
            content = content[:at] + TOKENS[int(chance.integers(len(TOKENS)))] + content[at:]
        else:
            content = content[:at] + chance.bytes(int(chance.integers(1, 30))) + content[at:]
    return content


def _flipped(content: bytes, chance: Chance) -> bytes:
    flipped = bytearray(content)
    for at in chance.integers(0, max(1, len(content)), int(chance.integers(1, 20))):
        if flipped:
            flipped[at] ^= 1 << int(chance.integers(8))
    return bytes(flipped)


def places(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The way to each value in nested tables and lists, some of very long ones."""
    found = [path] if path else []
    if isinstance(data, dict):
        pairs: list[tuple[Any, Any]] = list(data.items())
    else:
        pairs = list(enumerate(data[:8])) if isinstance(data, list) else []
    for key, each in pairs:
        found += places(each, (*path, key))
    return found


def misvalued(data: Any, chance: Chance, extra: tuple[Any, ...] = ()) -> Any:
    """Nested data with one to three values set to what is none, away, misspelt or elsewhere."""
    data = copy.deepcopy(data)
    values = (*VALUES, *extra)
    for _ in range(int(chance.integers(1, 4))):
        ways = places(data)
        if not ways:
            return data
        *above, last = ways[int(chance.integers(len(ways)))]
        table = data
        for key in above:
            table = table[key]
        kind = chance.random()
        if kind < 0.7:
            table[last] = copy.deepcopy(values[int(chance.integers(len(values)))])
        elif kind < 0.8:
            del table[last]
        elif isinstance(table, dict):
            other = f"{last}{chance.choice(['s', '_mm', '', ' ', '.x'])}"
            table[other] = table.pop(last)
        else:
            table.append(copy.deepcopy(table[last]))
    return data


def toml(value: Any, top: bool = True) -> str:
    """Nested data as TOML, every table inline."""
    if isinstance(value, dict):
        pairs = [f"{json.dumps(str(key))} = {toml(each, False)}" for key, each in value.items()]
        return "\n".join(pairs) + "\n" if top else "{" + ", ".join(pairs) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml(each, False) for each in value) + "]"
    if isinstance(value, float) and not np.isfinite(value):
        return str(value)
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else json.dumps(value)


def put(path: Path, content: bytes, chance: Chance, odd: float = 0.06) -> None:
    """Write a file; with the chance ``odd`` something else comes in its place."""
    path.unlink(missing_ok=True)
    kind = int(chance.integers(7)) if chance.random() < odd else -1
    if kind == 0:
        path.mkdir()
    elif kind == 1 and hasattr(os, "mkfifo"):
        os.mkfifo(path)
    elif kind == 2:
        path.symlink_to(path.name)
    elif kind == 3:
        path.symlink_to("/dev/zero")
    elif kind == 4:
        path.symlink_to("nowhere")
    elif kind == 5:
        with path.open("wb") as stream:
            stream.truncate(6_000_000_000)  # takes no room
    else:
        path.write_bytes(b"" if kind == 6 else content)
