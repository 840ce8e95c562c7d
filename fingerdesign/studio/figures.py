"""Charts of the numbers and the finger in space, as Plotly has them, in the comparison's look.

Colours are names of the page's variables ("--blue"); the page's chart component puts in what they
stand for. What is pinned is drawn beneath, thin.
"""

from typing import Any

import numpy as np

from fingerdesign.analysis.page.section import Touch, section_svg
from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.report.figure import LOOKS, Figure, chart, finger_in_space, round_values
from fingerdesign.search.compare.geometry import packed_geometry
from fingerdesign.studio.numbers import PRESSES, Numbers
from fingerdesign.studio.words import section_words


def section(design: Design, now: Numbers | None, picked: int | None = None) -> str:
    """The section z = 0 with the contact, as SVG; now: None before the first result."""
    touch = None
    if now is not None:
        touch = Touch(now.status_x, now.status, now.normal[-1], now.tangential[-1])
    return section_svg(design, section_words(design, now), touch, picked)


def tractions(now: Numbers, pinned: Numbers | None = None) -> Figure:
    """Pressure, shear traction and what friction allows of it, along the contact."""
    lines = [
        _line(now.x, now.friction * now.pressure, "friction × pressure", "--muted", "dash", 1.2),
        _line(now.x, now.pressure, "pressure", "--blue", "solid"),
        _line(now.x, now.shear, "shear traction", "--vermilion", "dash"),
    ]
    if pinned is not None:
        lines = [*(_beneath(pinned.x, each) for each in (pinned.shear, pinned.pressure)), *lines]
    touched = now.status_x[now.status > 0]
    reach = 1.25 * float(np.abs(touched).max()) if len(touched) else float(np.abs(now.x).max())
    more = {"xaxis": {"range": [-reach, reach]}, "showlegend": True}
    return _figure(lines, "Tractions", "x (mm)", "MPa", **more)


def bars(now: Numbers, picked: int | None, pinned: Numbers | None = None) -> Figure:
    """Change of each gage by the shear, over its place; a click picks one."""
    looks = ["--vermilion" if k == picked else "--blue" for k in range(len(now.gage_x))]
    data = [{"type": "bar", "name": "now", "marker": {"color": looks}, **_signals(now, "plate")}]
    if pinned is not None:
        marks = {"color": "--muted", "symbol": "line-ew-open", "size": 14}
        own = _signals(pinned, "pinned, plate")
        data.append({"mode": "markers", "name": "pinned", "marker": marks, **own})
    return _figure(data, "Gages: change by the shear", "plate", "microstrain")


def _signals(numbers: Numbers, name: str) -> Figure:
    """The signals over the plates' numbers, and their words under the mouse."""
    plates, hover = list(range(len(numbers.gage_x))), f"{name} %{{x}}: %{{y}} µε<extra></extra>"
    signals = round_values(numbers.signals)
    return {"x": plates, "y": signals, "customdata": plates, "hovertemplate": hover}


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
    place = {"yref": "paper", "y0": 0, "y1": 1, "x0": PRESSES + 0.5, "x1": PRESSES + 0.5}
    border = {"type": "line", **place, "line": {"color": "--muted", "width": 1, "dash": "dot"}}
    words = f"Gage of plate {picked}: pressed, then sheared"
    return _figure(lines, words, "increment", "microstrain", shapes=[border])


def shape(design: Design) -> Figure | None:
    """The finger in space; None where it cannot be drawn. The view that a hand chose stays."""
    found = packed_geometry(design.model_dump(mode="json", exclude_none=True))
    if found["body"] is None:
        return None
    figure = finger_in_space(found)
    layout = {"template": LOOKS["template"], **figure["layout"], "height": 300}
    layout["scene"] |= {"uirevision": "unchanged"}
    return {**figure, "layout": layout, "words": found["words"]}


def _line(
    x: Array, y: Array, name: str, colour: str, dash: str = "solid", width: float = 2.0
) -> Figure:
    line = {"color": colour, "dash": dash, "width": width}
    return {"mode": "lines", "x": round_values(x), "y": round_values(y), "name": name, "line": line}


def _beneath(x: Array, y: Array) -> Figure:
    return {**_line(x, y, "pinned", "--muted", "dot", 1.4), "showlegend": False}


def _figure(data: list[Figure], title: str, across: str, up: str, **more: Any) -> Figure:
    return {**chart(data, title, across, up, **more), "words": title}
