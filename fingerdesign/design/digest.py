"""Content digests: the same for two files that mean the same."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from pydantic import BaseModel


def content_digest(model: BaseModel) -> str:
    """SHA-256, in hexadecimal, of a validated model's values.

    Comments, formatting, key order, defaults left out or written, and whole numbers written as
    integers or floats make no difference; any value that differs does. The class's name is part
    of it, so a design and a scene never share a digest.
    """
    content = {"kind": type(model).__name__, "values": _plain(model.model_dump(mode="json"))}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _plain(value: Any) -> Any:
    """Drop absent keys and make -0.0 the 0.0 that it equals."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value + 0.0
    return value
