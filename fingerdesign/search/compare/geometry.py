"""The shape of a finger as the comparison page draws it: triangles, edges, and where it is touched.

No CAD is made.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fingerdesign.analysis.page.shapes import INNER, POINTS, finger_parts
from fingerdesign.analysis.page.sketch import facts
from fingerdesign.design.body import Body
from fingerdesign.design.schema import Design
from fingerdesign.errors import FingerDesignError
from fingerdesign.layout.bodies import surface_height
from fingerdesign.layout.rows import plate_frames
from fingerdesign.records.outcome import Traces
from fingerdesign.report.figure import places

# More plates would make a page slow to turn.
MOST_PLATES = 150
_CONTACT_LIFT = 0.03  # mm: the contact is drawn so far above the surface.

Packed = dict[str, Any]


def packed_geometry(design: Mapping[str, Any], traces: Traces | None = None) -> Packed:
    """Geometry of a design (its TOML data) for drawing, JSON-ready; lengths in mm.

    words   the finger in sentences: the drawing's text alternative
    note    what the drawing leaves out, or why there is none; "" otherwise
    size    extents along x, y, z
    body, core, plates, gages, holes
            triangles {x, y, z (of the vertices), i, j, k (of the triangles)}, None: there is none
    edges   {x, y, z}: lines along the body's sharp edges, with None between two of them
    touch   {places: {x, y, z}, each}: for every contact point of ``traces`` ``each`` places on the
            surface, one after another; in plane strain a line along z

    Never raises for what a design may be: where it cannot be drawn there is no body, and a note.
    """
    from pydantic import ValidationError

    try:
        # The tables that decide the shape: what a later version adds to others does not hinder.
        shaping = {"design", "body", "plates", "gages", "materials"} & design.keys()
        found = Design.model_validate({key: design[key] for key in shaping})
    except ValidationError:
        return _nothing("", "The design's data is not a whole design: it cannot be drawn.")
    words = ""
    try:
        words = "; ".join(each.strip() for each in facts(found))
        return {"words": words, **_drawn(found, traces or Traces())}
    except (FingerDesignError, ValueError):
        step = found.body.step is not None
        why = "its STEP file cannot be read here" if step else "its outline does not close"
        return _nothing(words, f"The finger is not drawn: {why}.")


def _drawn(design: Design, traces: Traces) -> Packed:
    body = design.body
    notes = []
    if body.shape == "step":
        notes.append("Of the STEP body its contact surface is drawn, with straight sides below.")
    frames = [each for each in plate_frames(design) if np.isfinite([each.place, each.y]).all()]
    if len(frames) > MOST_PLATES:
        notes.append(f"Of {len(frames)} plates the first {MOST_PLATES} are drawn.")
        frames = frames[:MOST_PLATES]
    parts = finger_parts(design, frames)
    touch = _touched(body, parts["size"][2], traces)
    return {"note": " ".join(notes), **parts, "touch": touch}


def _nothing(words: str, note: str) -> Packed:
    drawn = ("body", "edges", "core", "plates", "gages", "holes", "touch")
    return {"words": words, "note": note, "size": [1.0, 1.0, 1.0], **dict.fromkeys(drawn)}


def _touched(body: Body, depth: float, traces: Traces) -> Packed | None:
    """Contact points on the surface, a little above it; lines along z in 2-D."""
    x = np.array(traces.contact_x_mm, dtype=float)
    if not len(x) or not traces.status:
        return None
    if traces.contact_z_mm:
        z = np.array(traces.contact_z_mm, dtype=float)[:, None]
        if (z >= -1e-9).all():  # a model of the half z >= 0 alone is its own mirror image
            z = np.concatenate([z, -z], axis=1)
    else:
        straight = body.step is None and body.shape != "revolved" and body.dome_radius_mm is None
        across = np.linspace(-1.0, 1.0, 2 if straight else POINTS)
        far = np.full(len(x), 0.5 * depth)
        if body.shape == "revolved":
            far = np.sqrt(np.maximum(0.0, far**2 - x**2))
        z = INNER * far[:, None] * across
    height = surface_height(body, x[:, None], z)
    points = np.stack([np.broadcast_to(x[:, None], z.shape), height + _CONTACT_LIFT, z], axis=-1)
    return {"places": places(points.reshape(-1, 3)), "each": z.shape[1]}
