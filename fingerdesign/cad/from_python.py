"""A body of the user's own, made by a Python function in CadQuery.

The function's solid is written as a STEP file in the cache, named by its content, and goes the
way of every other STEP body. Importing this module loads no CAD kernel; calling it does.
"""

import hashlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fingerdesign.checks.load import with_values
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault, GeometryError
from fingerdesign.runtime.cache import Cache
from fingerdesign.runtime.files import scratch

# Keys of [body] that a solid of one's own replaces.
_IDLE = (
    *("width_mm", "base_height_mm", "arc_radius_mm", "depth_mm", "dome_radius_mm"),
    *("edge_radius_mm", "edge"),
)


def with_body(design: Design, make: Callable[[], Any], **rules: object) -> Design:
    """Return a copy of ``design`` whose body is the solid that ``make()`` returns.

    ``make`` takes nothing and returns a CadQuery Workplane, Solid, or Compound of one solid; axes
    and units are those of a design: base in y = 0, contact surface toward +y, mm. ``rules``: the
    keys of [body.step], as ``up="z"`` or ``contact_above_mm=5.0``. Plates, materials, core and all
    else stay the design's.

    A finger with an elliptic crest:

    >>> import fingerdesign
    >>> def elliptic():
    ...     import cadquery as cq
    ...     sides = cq.Workplane("XY", origin=(0, 0, -5)).moveTo(-10, 10).lineTo(-10, 0)
    ...     section = sides.lineTo(10, 0).lineTo(10, 10).ellipseArc(10, 4, 0, 180, sense=1)
    ...     return section.close().extrude(10)
    >>> plain = fingerdesign.parse_design('''design.name = "elliptic"
    ... plates.count = 3''')
    >>> design = fingerdesign.with_body(plain, elliptic, mirrors_in_z=True)
    >>> design.body.shape, design.body.width_mm, design.body.depth_mm
    ('step', 20.0, 10.0)

    Raises DesignError where the solid or a rule will not do (as of any STEP file), or the design's
    plates do not fit into it; GeometryError where ``make`` returns no CadQuery shape. What
    ``make`` itself raises comes through.
    """
    file = written(make())
    values: dict[str, object] = {f"body.{key}": None for key in _IDLE}
    values |= {"body.shape": "step", "body.step": None, "body.step.file": str(file)}
    values |= {f"body.step.{key}": value for key, value in rules.items()}
    if "file" in rules:
        raise DesignError(
            [Fault("body.step.file", rules["file"], "absent", "the function makes the body")]
        )
    return with_values(design, values)


def written(shape: Any) -> Path:
    """Write a CadQuery shape as STEP into the cache folder, named by its content; its path."""
    import cadquery as cq
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.Interface import Interface_Static
    from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer

    if isinstance(shape, cq.Workplane):
        shape = shape.val() if shape.size() == 1 else cq.Compound.makeCompound(shape.vals())
    if not isinstance(shape, cq.Shape):
        raise GeometryError(
            f"the body's function returned {type(shape).__name__}; it must return a CadQuery "
            "Workplane, Solid or Compound"
        )
    writer, cache = STEPControl_Writer(), Cache("bodies")
    Interface_Static.SetCVal_s("write.step.product.name", "finger")
    try:
        with scratch("body") as folder:
            file = folder / "body.step"
            done = writer.Transfer(shape.wrapped, STEPControl_AsIs) == IFSelect_RetDone
            if not done or writer.Write(str(file)) != IFSelect_RetDone:
                raise GeometryError("the CAD kernel could not write the function's body as STEP")
            # The writer counts its products, which would make each call's content another.
            content = re.sub(rb"'finger \d+'", b"'finger'", file.read_bytes())
        start = max(content.find(b"DATA;"), 0)  # the header holds the time of writing
        name = f"{hashlib.sha256(content[start:]).hexdigest()[:32]}.step"
        if cache.path(name).exists():  # never taken away: designs name it
            return cache.path(name)
        return cache.put(name, content)
    except OSError as error:
        raise GeometryError(f"{cache.folder} cannot be written: {error.strerror}") from error
