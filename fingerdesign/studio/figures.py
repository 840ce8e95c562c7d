"""Charts of the numbers and the finger in space, as Plotly has them, in the comparison's look.

Colours are names of the page's variables ("--blue"); the page's chart component puts in what they
stand for. What is pinned is drawn beneath, thin.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.search.compare.figures import LOOKS
from fingerdesign.search.compare.geometry import packed_geometry
from fingerdesign.studio.numbers import PRESSES, Numbers

Figure = dict[str, Any]
_PINNED = {"color": "--muted", "width": 1.4, "dash": "dot"}
_TURN, _TILT = np.radians(-32.0), np.radians(24.0)  # where the camera starts
_CONFIG = {"displayModeBar": False}
_MARGIN = {"l": 54, "r": 12, "t": 30, "b": 40}


def tractions(now: Numbers, pinned: Numbers | None = None) -> Figure:
    """Pressure, shear traction and what friction allows of it, along the contact."""
    lines = [
        _line(now.x, now.friction * now.pressure, "friction × pressure", "--muted", "dash", 1.2),
        _line(now.x, now.pressure, "pressure", "--blue", "solid"),
        _line(now.x, now.shear, "shear traction", "--vermilion", "dash"),
    ]
    if pinned is not None:
        for values in (pinned.pressure, pinned.shear):
            lines.insert(0, _beneath(pinned.x, values))
    touched = now.status_x[now.status > 0]
    reach = 1.25 * float(np.abs(touched).max()) if len(touched) else float(np.abs(now.x).max())
    return _figure(
        lines, "Tractions", "x (mm)", "MPa", xaxis={"range": [-reach, reach]}, showlegend=True
    )


def bars(now: Numbers, picked: int | None, pinned: Numbers | None = None) -> Figure:
    """What the shear changes of each gage, over its place; a click picks one."""
    plates = np.arange(len(now.gage_x))
    looks = ["--vermilion" if plate == picked else "--blue" for plate in plates]
    data: list[Figure] = [
        {
            "type": "bar",
            "x": plates.tolist(),
            "y": _digits(now.signals),
            "customdata": plates.tolist(),
            "marker": {"color": looks},
            "name": "now",
            "hovertemplate": "plate %{x}: %{y} µε<extra></extra>",
        }
    ]
    if pinned is not None:
        other = np.arange(len(pinned.gage_x))
        marks = {"color": "--muted", "symbol": "line-ew-open", "size": 14}
        data.append(
            {
                "mode": "markers",
                "x": other.tolist(),
                "y": _digits(pinned.signals),
                "customdata": other.tolist(),
                "marker": marks,
                "name": "pinned",
                "hovertemplate": "pinned, plate %{x}: %{y} µε<extra></extra>",
            }
        )
    return _figure(data, "Gages: change by the shear", "plate", "microstrain")


def trace(now: Numbers, picked: int | None, pinned: Numbers | None = None) -> Figure:
    """The reading of one gage, increment by increment."""
    count = now.readings.shape[1]
    if picked is None or picked >= count:
        return _figure([], "No gage", "increment", "microstrain")
    steps = np.arange(1.0, len(now.readings) + 1.0)
    lines = [_line(steps, now.readings[:, picked], "now", "--vermilion", "solid")]
    lines[0]["mode"] = "lines+markers"
    if pinned is not None and picked < pinned.readings.shape[1]:
        lines.insert(0, _beneath(steps, pinned.readings[:, picked]))
    shape = {
        "type": "line",
        "yref": "paper",
        "y0": 0,
        "y1": 1,
        "x0": PRESSES + 0.5,
        "x1": PRESSES + 0.5,
        "line": {"color": "--muted", "width": 1, "dash": "dot"},
    }
    words = f"Gage of plate {picked}: pressed, then sheared"
    return _figure(lines, words, "increment", "microstrain", shapes=[shape])


def shape(design: Design) -> Figure | None:
    """The finger in space; None where it cannot be drawn. The view that a hand chose stays."""
    found = packed_geometry(design.model_dump(mode="json", exclude_none=True))
    if found["body"] is None:
        return None
    data = [
        {**look, **found[name]} for name, look in LOOKS["finger"].items() if found[name] is not None
    ]
    data.append({**LOOKS["touch"][0], **found["edges"]})
    reach, middle = 0.5 * float(np.hypot.reduce(found["size"])), 0.5 * found["size"][1]
    ct, st, cp, sp = np.cos(_TURN), np.sin(_TURN), np.cos(_TILT), np.sin(_TILT)
    eye = {"x": 2 * cp * st, "y": 2 * sp, "z": 2 * cp * ct}
    up = {"x": -sp * st, "y": cp, "z": -sp * ct}
    axes = {
        name: {"visible": False, "range": [centre - reach, centre + reach]}
        for name, centre in (("xaxis", 0.0), ("yaxis", middle), ("zaxis", 0.0))
    }
    scene = {
        **LOOKS["shape"]["scene"],
        **axes,
        "camera": {"eye": eye, "up": up, "projection": {"type": "orthographic"}},
        "aspectratio": dict.fromkeys("xyz", 1.9),
        "uirevision": "kept",
    }
    layout = {**LOOKS["shape"], "height": 300, "scene": scene, "uirevision": "kept"}
    return {
        "data": data,
        "layout": {"template": LOOKS["looks"]["template"], **layout, "hovermode": False},
        "config": _CONFIG,
        "words": found["words"],
    }


def _digits(values: Array) -> list[float]:
    return [float(f"{value:.4g}") for value in values]


def _line(
    x: Array, y: Array, name: str, colour: str, dash: str = "solid", width: float = 2.0
) -> Figure:
    return {
        "mode": "lines",
        "x": _digits(x),
        "y": _digits(y),
        "name": name,
        "line": {"color": colour, "dash": dash, "width": width},
    }


def _beneath(x: Array, y: Array) -> Figure:
    return {
        "mode": "lines",
        "x": _digits(x),
        "y": _digits(y),
        "name": "pinned",
        "line": _PINNED,
        "showlegend": False,
    }


def _figure(data: list[Figure], title: str, across: str, up: str, **more: Any) -> Figure:
    layout: Figure = {
        "template": LOOKS["looks"]["template"],
        "height": 230,
        "margin": _MARGIN,
        "title": {"text": title, "font": {"size": 13}, "x": 0.01, "y": 0.97},
        "xaxis": {"title": {"text": across, "standoff": 6}, **more.pop("xaxis", {})},
        "yaxis": {"title": {"text": up}, "zeroline": True},
        "uirevision": "kept",
        **more,
    }
    if layout.get("showlegend"):
        layout["legend"] = {"orientation": "h", "x": 1, "xanchor": "right", "y": 1.14}
    return {"data": data, "layout": layout, "config": _CONFIG, "words": title}
