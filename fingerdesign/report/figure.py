"""Figures by Plotly, for pages that open offline and for notebooks; the finger in space.

A figure is {data, layout} as Plotly has them. Colours are names of the page's variables ("--blue"):
a page's script puts in their values, :func:`in_notebook` the colours of print. A figure holds no
text of a design or an outcome, which Plotly might take for markup.
"""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.report.page import COMMON, macros, pack, paragraphs
from fingerdesign.report.style import COLOURS, ReportFigure

Figure = dict[str, Any]
# The common look of charts and of the parts of a finger. The lines of "series" differ in colour,
# dashes and marker, so that a reader needs only one of the three.
LOOKS: Figure = json.loads((COMMON / "looks.json").read_text(encoding="utf-8"))
DIGITS = 4  # Significant digits: a drawing is a thousand points wide.
_MICRO = 3  # Decimals of a place in mm: micrometres.
START = (-32.0, 24.0)  # Degrees: turn about y and tilt of a finger's first view.
_FONT = 'system-ui, "Segoe UI", Roboto, Helvetica, Arial, sans-serif'


def round_values(values: Any) -> list[float | int | None]:
    """To DIGITS significant digits, whole numbers without a point; what is no number is None.

    >>> round_values((1.23456, None, 120.0, 0.0, float("nan")))
    [1.235, None, 120, 0, None]
    """
    return [number(value) for value in values]


def number(value: float | None) -> float | int | None:
    """A number to DIGITS significant digits; None where it is no number."""
    return None if value is None else _whole(float(f"{value:.{DIGITS}g}"))


def _whole(value: float) -> float | int | None:
    """A whole number without its point; None where it is no number."""
    return None if not math.isfinite(value) else int(value) if value == int(value) else value


@dataclass(frozen=True)
class Triangles:
    """Vertices (n, 3), and triangles (m, 3) of their numbers, anticlockwise seen from outside."""

    vertices: Array
    triangles: IntArray

    def edges(self) -> tuple[IntArray, Array]:
        """Each edge once, (k, 2), and the cosine (k,) between its two facets; NaN: it has one."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        normal = np.cross(b - a, c - a)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
        directed = np.concatenate([self.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
        ends, place, count = np.unique(
            np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True
        )
        both = np.zeros((len(ends), 3))  # of two unit normals the sum's square is 2 + 2 cosine
        np.add.at(both, place.ravel(), np.tile(normal, (3, 1)))
        return np.asarray(ends), np.where(count == 2, 0.5 * (both**2).sum(axis=1) - 1.0, np.nan)

    def sharp_edges(self, angle_deg: float) -> IntArray:
        """Ends (k, 2) of the edges whose facets meet at more than an angle, or that have one."""
        ends, cosine = self.edges()
        return np.asarray(ends[~(cosine >= np.cos(np.radians(angle_deg)))])

    def outline(self, angle_deg: float, mirrored: bool = False) -> Figure:
        """The sharp edges as lines {x, y, z}, with None between two of them.

        mirrored: of two halves that meet in z = 0, where their seam is no edge.
        """
        ends = self.sharp_edges(angle_deg)
        if mirrored:
            ends = ends[np.abs(self.vertices[ends][..., 2]).max(axis=1) > 1e-9]
        lines = np.full((len(ends), 3, 3), np.nan)
        lines[:, :2] = self.vertices[ends]
        return places(lines.reshape(-1, 3))

    def drawn(self) -> Figure | None:
        """{x, y, z (of the vertices), i, j, k (of the triangles)}; None where there are none."""
        return places(self.vertices) | corners(self.triangles) if len(self.triangles) else None


def corners(triangles: IntArray) -> Figure:
    """Triangles (m, 3) as Plotly has them."""
    return {name: triangles[:, k].tolist() for k, name in enumerate("ijk")}


def places(points: Array) -> Figure:
    """Points (n, 3) as lists x, y, z, to micrometres; None where there is no number."""
    return {name: micrometres(points[:, k]) for k, name in enumerate("xyz")}


def micrometres(values: Any) -> list[float | None]:
    """Lengths in mm to micrometres; None where there is no number; whole ones without a point."""
    near = [round(value, _MICRO) for value in np.asarray(values, dtype=float).tolist()]
    return [_whole(value) for value in near]


def triangles_of(solids: Iterable[Any]) -> Triangles:
    """The surfaces of solids, as layout/gaps.py makes them."""
    meshes = [solid.to_mesh64() for solid in solids]
    return merge_triangles((mesh.vert_properties, mesh.tri_verts.astype(int)) for mesh in meshes)


def fans(polygons: Iterable[Array]) -> Triangles:
    """Convex polygons (n, 3), each as a fan."""
    return merge_triangles(
        (ring, np.array([(0, k, k + 1) for k in range(1, len(ring) - 1)])) for ring in polygons
    )


def merge_triangles(parts: Iterable[tuple[Array, IntArray]]) -> Triangles:
    """Several surfaces, vertices and triangles, as one."""
    vertices, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=int)], 0
    for points, own in parts:
        vertices.append(points)
        triangles.append(own + count)
        count += len(points)
    return Triangles(np.concatenate(vertices), np.concatenate(triangles))


def finger_in_space(parts: Mapping[str, Any]) -> Figure:
    """A finger to be turned: data (each trace by its part's name) and layout.

    parts: body, core, plates, gages, holes (as :meth:`Triangles.drawn`; what is None is not there;
    they may have more keys of a trace), edges (:meth:`Triangles.outline`), size along x, y, z.
    """
    data = [
        {"name": name, **LOOKS["solid"], **look, **parts[name]}
        for name, look in LOOKS["finger"].items()
        if parts.get(name) is not None
    ]
    data.append({"name": "edges", **LOOKS["edges"], **parts["edges"]})
    reach, middle = 0.5 * math.hypot(*parts["size"]), 0.5 * parts["size"][1]
    axes = {
        f"{name}axis": {"visible": False, "range": [centre - reach, centre + reach]}
        for name, centre in (("x", 0.0), ("y", middle), ("z", 0.0))
    }
    ratio = dict.fromkeys("xyz", 1.9)
    shape = LOOKS["shape"]
    scene = {**shape["scene"], **axes, "camera": camera(*START), "aspectratio": ratio}
    return {"data": data, "layout": {**shape, "scene": scene}, "config": LOOKS["options"]}


def camera(turn_deg: float, tilt_deg: float) -> Figure:
    """Plotly's camera, without perspective: turned about y from the front (+z), and tilted down."""
    turn, tilt = np.radians([turn_deg, tilt_deg])
    (ct, cp), (st, sp) = np.cos([turn, tilt]), np.sin([turn, tilt])
    eye, up = (2 * cp * st, 2 * sp, 2 * cp * ct), (-sp * st, cp, -sp * ct)
    ends = ({name: round(float(v), 4) for name, v in zip("xyz", e, strict=True)} for e in (eye, up))
    return {**dict(zip(("eye", "up"), ends, strict=True)), "projection": {"type": "orthographic"}}


def chart(data: Sequence[Figure], title: str, across: str, up: str, **more: Any) -> Figure:
    """A chart of one pair of axes in the common look; ``more``: of its layout."""
    layout: Figure = {
        "template": LOOKS["template"],
        "height": 230,
        "margin": {"l": 54, "r": 12, "t": 30, "b": 40},
        "title": {"text": title, "font": {"size": 13}, "x": 0.01, "y": 0.97},
        "xaxis": {"title": {"text": across, "standoff": 6}, **more.pop("xaxis", {})},
        "yaxis": {"title": {"text": up}, "zeroline": True, **more.pop("yaxis", {})},
        "uirevision": "unchanged",
        **more,
    }
    if layout.get("showlegend"):
        layout["legend"] = {"orientation": "h", "x": 1, "xanchor": "right", "y": 1.14}
    return {"data": list(data), "layout": layout, "config": LOOKS["options"]}


@dataclass(frozen=True)
class Panel:
    """One pair of axes among others: lines (name, x, y) in the looks of "series" by their order.

    reach: of x; looks: another order of them; marked: a marker at each point.
    """

    title: str
    across: str
    up: str
    lines: Sequence[tuple[str, Array, Array]]
    reach: tuple[float, float] | None = None
    rise: tuple[float, float] | None = None
    looks: Sequence[int] = range(5)
    marked: bool = True


def panels(drawn: Sequence[Panel], columns: int) -> Figure:
    """Panels in rows, with one legend below that names each line once."""
    rows, data, named = -(-len(drawn) // columns), [], set[str]()
    layout: Figure = {"template": LOOKS["template"], "height": 70 + 250 * rows, "showlegend": True}
    legend = {"orientation": "h", "y": -0.24 / rows, "yanchor": "top"}
    layout |= {"margin": {"l": 62, "r": 14, "t": 34, "b": 92}, "annotations": [], "legend": legend}
    wide, high = (1.0 + 0.14) / columns, (1.0 + 0.34) / rows
    for k, panel in enumerate(drawn):
        row, column = divmod(k, columns)
        number = f"{k + 1}" if k else ""
        x, top = column * wide, 1.0 - row * high
        across = {"title": {"text": panel.across, "standoff": 4}, "domain": [x, x + wide - 0.14]}
        up = {"title": {"text": panel.up}, "domain": [max(top - high + 0.34, 0.0), top]}
        flat = not any(np.nan_to_num(y).any() for _, _, y in panel.lines)
        rise = (-1.0, 1.0) if flat and panel.rise is None else panel.rise  # else a scale of 1e-16
        layout[f"xaxis{number}"] = across | {"anchor": f"y{number}", "range": panel.reach}
        layout[f"yaxis{number}"] = up | {"anchor": f"x{number}", "zeroline": True, "range": rise}
        place = {"xref": f"x{number} domain", "yref": f"y{number} domain", "x": 0.5, "y": 1.12}
        layout["annotations"].append({"text": f"<b>{panel.title}</b>", **place, "showarrow": False})
        for look, (name, xs, ys) in zip(panel.looks, panel.lines, strict=False):
            own = LOOKS["series"][look]
            trace: Figure = {"x": round_values(xs), "y": round_values(ys)}
            trace |= {"name": name, "legendgroup": name}
            trace |= {"xaxis": f"x{number}", "yaxis": f"y{number}", "showlegend": name not in named}
            trace["mode"] = "lines+markers" if panel.marked else "lines"
            trace["hovertemplate"] = f"{name}<br>{panel.across}: %{{x}}<br>{panel.up}: %{{y}}"
            trace["hovertemplate"] += "<extra></extra>"
            trace["line"] = {"color": own["colour"], "dash": own["dash"], "width": 2}
            data.append(trace | {"marker": {"symbol": own["symbol"], "size": 6}})
            named.add(name)
    return {"data": data, "layout": layout, "config": LOOKS["options"]}


def caption_chart(
    figure: Figure, words: Path, name: str, still: str = "", **values: Any
) -> ReportFigure:
    """A figure for a page with its words: title, how to read it, what it shows.

    It is packed behind its place and behind the fields of its slider and menus: the
    page's script (templates/figures.js) draws it without these. still: an <svg> that is shown
    until then, and where the browser cannot draw in space.
    """
    title, reading, alternative = paragraphs(words, name, **values)
    data = pack(json.dumps(figure, allow_nan=False, separators=(",", ":")))
    image = macros(COMMON / "plot.html.j2").plot(name, figure["layout"], still)
    image += f'<script type="text/plain">{data}</script>\n'
    return ReportFigure(name, title, image, reading, alternative, drawn=True)


def in_notebook(figure: Figure) -> Any:
    """The figure as a plotly.graph_objects.Figure, in the colours of print, with its controls."""
    from plotly.graph_objects import Figure as Drawn

    text = json.dumps(figure).replace('"--figure-font"', json.dumps(_FONT))
    for name, colour in COLOURS.items():
        text = text.replace(f'"--{name}"', f'"{colour}"')
    found = json.loads(text)
    layout = found["layout"]
    for k, menu in enumerate(layout.get("updatemenus", ())):
        menu |= {"x": 0.3 * k, "xanchor": "left", "y": 1.02, "yanchor": "bottom"}
    for slider in layout.get("sliders", ()):
        slider |= {"y": -0.16, "currentvalue": {"prefix": "increment "}}
    if "sliders" in layout or "updatemenus" in layout:  # room for them
        layout["height"] += 150
        layout["margin"] |= {"t": layout["margin"]["t"] + 40, "b": layout["margin"]["b"] + 110}
    return Drawn(found["data"], layout)
