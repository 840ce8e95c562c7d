"""The outline of a parametric body: an arc or a flat top, its edges, down to the straight side."""

from functools import lru_cache

import numpy as np

from fingerdesign.design.body import Body
from fingerdesign.layout.outline import Piece, Profile


@lru_cache(maxsize=256)
def _outline(
    half: float, height: float, radius: float, edge: float | None, chamfer: bool
) -> Profile:
    flat = not np.isfinite(radius)
    crest = height if flat else height + radius - float(np.sqrt(radius**2 - half**2))
    middle = crest - radius  # the arc's centre

    def top(x: float) -> float:
        return height if flat else middle + float(np.sqrt(radius**2 - x**2))

    def upper(end: tuple[float, float]) -> Piece:
        start = (0.0, crest)
        return Piece(start, end) if flat else Piece(start, end, 0.0, middle, radius)

    side = (half, height)
    if edge is None:
        return Profile((upper(side),))
    if chamfer:
        corner = (half - edge, top(half - edge))
        return Profile((upper(corner), Piece(corner, (half, height - edge))))
    x = half - edge
    if flat:
        y, joint = height - edge, (x, height)
    else:
        y = middle + float(np.sqrt((radius - edge) ** 2 - x**2))
        share = radius / (radius - edge)
        joint = (share * x, middle + share * (y - middle))
    rounding = Piece(joint, (half, y), x, y, edge)
    return Profile((upper(joint), rounding) if joint[0] > 1e-9 else (rounding,))


def profile_of(body: Body) -> Profile:
    """The outline of a parametric body. Raises ValueError where the edge leaves no top."""
    radius = body.kind.top_radius(body)
    half, edge = 0.5 * body.width_mm, body.edge_radius_mm
    if radius < half or (edge is not None and not edge <= min(half, radius)):
        raise ValueError("the arc or its edge does not fit the width")
    return _outline(half, body.base_height_mm, radius, edge, body.edge == "chamfer")
