"""A few STEP bodies of given sizes, made with CadQuery on demand: bench and examples use them.

Each is a finger in our axes: base in y = 0, contact surface toward +y, its own mirror image in
x = 0 and z = 0. The file's name holds the shape and the sizes, so each is made once.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from fingerdesign.cad.from_python import written
from fingerdesign.runtime.cache import Cache

# Part of the file name: raise it when a shape changes.
FORMAT = 1
SHAPES = ("spline", "ball", "tip", "filleted")  # each is a function of this module


def sample_step(shape: str, width: float, depth: float, height: float, crown: float) -> Path:
    """Path of the STEP file of a sample body; sizes in mm.

    ``shape``: one of ``SHAPES``; ``height``: of the crest; ``crown``: how far the contact surface
    falls from there to its border. KeyError for an unknown shape.
    """
    make: Callable[..., Any] = {each.__name__: each for each in (spline, ball, tip, filleted)}[
        shape
    ]
    sizes = "-".join(f"{size:.3f}" for size in (width, depth, height, crown))
    cache, name = Cache("samples"), f"{shape}-{FORMAT}-{sizes}.step"
    if not cache.path(name).is_file():
        made = written(make(width, depth, height, crown))
        cache.put(name, made.read_bytes())
    return cache.path(name)


def spline(width: float, depth: float, height: float, crown: float) -> Any:
    """A section below a spline through points of crest - crown |2 x / width|^2.5, along z."""
    import cadquery as cq

    x = [(k / 4.0 - 1.0) * 0.5 * width for k in range(9)]
    points = [(each, height - crown * abs(2.0 * each / width) ** 2.5) for each in x]
    start = cq.Workplane("XY", origin=(0, 0, -0.5 * depth)).moveTo(*points[0])
    section = start.spline(points[1:], includeCurrent=True)
    return section.lineTo(0.5 * width, 0.0).lineTo(-0.5 * width, 0.0).close().extrude(depth)


def ball(width: float, depth: float, height: float, crown: float) -> Any:
    """A box below a sphere that is ``crown`` lower at the corners."""
    import cadquery as cq

    corner = 0.25 * (width**2 + depth**2)
    radius = (corner + crown**2) / (2.0 * crown)
    box = cq.Workplane("XY").box(width, height, depth).translate((0, 0.5 * height, 0))
    return box.intersect(cq.Workplane("XY").sphere(radius).translate((0, height - radius, 0)))


def tip(width: float, depth: float, height: float, crown: float) -> Any:
    """A tip that narrows toward a flat top, its upper edges rounded."""
    import cadquery as cq

    base = cq.Workplane("XZ").rect(width, depth)
    lofted = base.workplane(offset=-height).rect(0.8 * width, 0.8 * depth).loft(combine=True)
    return lofted.faces(">Y").edges().fillet(min(crown, 0.2 * width, 0.2 * depth))


def filleted(width: float, depth: float, height: float, crown: float) -> Any:
    """A box whose upper edges are all rounded."""
    import cadquery as cq

    box = cq.Workplane("XY").box(width, height, depth).translate((0, 0.5 * height, 0))
    return box.faces(">Y").edges().fillet(min(crown, 0.3 * width, 0.3 * depth))
