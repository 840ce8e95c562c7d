"""The contact surface of a STEP body as a few lines of heights, for the comparison page."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array

if TYPE_CHECKING:
    from fingerdesign.design.body_table import Body

Known = Callable[[Array], NDArray[np.bool_]]

LINES, POINTS = 25, 13  # of the grid: along z, and on each line
_SAMPLES = 41  # along x and along z, to find where the surface ends
_HALVINGS = 8  # of a sample's width, to find the end itself
_INNER = 1.0 - 1e-4  # on the border itself a height may be missing


@lru_cache(maxsize=32)
def step_grid(body: Body, content: str) -> tuple[tuple[Array, Array, Array], float]:
    """x (LINES,), z and heights (LINES, POINTS) of the contact surface, and its greatest height.

    Each line along z goes from border to border, so that a round outline is drawn round; where one
    leaves the surface in between, all lines go over the whole depth, and heights are NaN there.
    ``content``: of the STEP file (a study's variants share theirs). Lengths in mm. ValueError where
    there is no surface; DesignError where the file cannot be read.
    """
    from fingerdesign.design.layout import surface_height

    wide, deep = (
        0.5 * _INNER * size * np.linspace(-1.0, 1.0, _SAMPLES)
        for size in (body.width_mm, body.depth_mm)
    )

    def covered(x: Array) -> NDArray[np.bool_]:
        return np.isfinite(surface_height(body, x[:, None], deep[None, :]))

    there = np.flatnonzero(covered(wide).any(axis=1))
    if not len(there):
        raise ValueError("the contact surface has no height anywhere")

    def any_covered(x: Array) -> NDArray[np.bool_]:
        return np.asarray(covered(x).any(axis=1))

    left, right = (
        _border(any_covered, wide[[end]], wide, way)
        for end, way in ((there[0], -1.0), (there[-1], 1.0))
    )
    x = 0.5 * (left + right) + 0.5 * (right - left) * _dense_at_ends(LINES)
    known = covered(x)
    first, last = known.argmax(axis=1), _SAMPLES - 1 - known[:, ::-1].argmax(axis=1)
    places = np.arange(_SAMPLES)
    if (known == (places >= first[:, None]) & (places <= last[:, None])).all():

        def on_surface(z: Array) -> NDArray[np.bool_]:
            return np.isfinite(surface_height(body, x, z))

        near = _border(on_surface, deep[first], deep, -1.0)
        far = _border(on_surface, deep[last], deep, 1.0)
    else:
        near, far = np.full(LINES, deep[0]), np.full(LINES, deep[-1])
    z = 0.5 * (near + far)[:, None] + 0.5 * (far - near)[:, None] * _dense_at_ends(POINTS)
    heights = surface_height(body, np.broadcast_to(x[:, None], z.shape), z)
    return (x, z, heights), float(np.nanmax(heights))


def _border(known: Known, start: Array, samples: Array, way: float) -> Array:
    """Places (n,) where ``known`` ends, from ``start`` (n,) on, within a sample's width."""
    place, step = start, 0.5 * float(samples[1] - samples[0])
    for _ in range(_HALVINGS):
        further = np.clip(place + way * step, samples[0], samples[-1])
        place = np.where(known(further), further, place)
        step *= 0.5
    return place


def _dense_at_ends(count: int) -> Array:
    """Numbers (count,) from -1 to 1, closer together near both, where a rounding comes down."""
    return np.asarray(np.sin(np.linspace(-0.5, 0.5, count) * np.pi))
