"""Areas of a mesh's outer faces against those of the CAD faces."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fingerdesign.design.layout import PlateFrame, plate_frames
from fingerdesign.geometry.checks import face_areas
from fingerdesign.mesh.carriers import carriers_of
from fingerdesign.mesh.measures import curved_areas
from fingerdesign.mesh.types import Mesh

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

_TOUCHES = 1e-6  # mm: a plate that ends in a face of the body


def worst_area_error(mesh: Mesh, design: Design) -> float:
    """Greatest relative error of an outer face's area, by the curved facets; 0 in the section."""
    if mesh.dimension == 2:
        return 0.0
    wanted = outer_areas(mesh, design)
    found = {
        name: float(curved_areas(mesh.points, mesh.facets[name]).sum())
        if name in mesh.facets
        else 0.0
        for name in wanted
    }
    groups = [{name} for name in wanted]
    for face in carriers_of(design, (), mesh.symmetric, core=False).faces:
        joined = [group for group in groups if group & set(face.boundaries)]
        if len(joined) > 1:  # no edge tells where one ends and the next begins
            groups = [group for group in groups if group not in joined] + [set().union(*joined)]
    errors = []
    for group in groups:
        area = sum(wanted[name] for name in group)
        if area > 0.0:
            errors.append(abs(sum(found[name] for name in group) / area - 1.0))
    return max(errors)


def outer_areas(mesh: Mesh, design: Design) -> dict[str, float]:
    """Areas of the outer faces by name, mm^2, less the mouths of sheets' slots."""
    body = design.body
    if body.step is not None:
        wanted = _step_areas(design, mesh)
    else:
        wanted = dict(face_areas(body, mesh.symmetric))
    if design.plates.model != "sheet":
        return wanted
    for frame in plate_frames(design):
        mouth = frame.length * frame.thickness
        for name, area in _mouths(frame, design, mesh.symmetric, mouth):
            if name in wanted:
                wanted[name] -= area
    return wanted


def _mouths(
    frame: PlateFrame, design: Design, symmetric: bool, mouth: float
) -> list[tuple[str, float]]:
    """Where a slot opens in the body's outside, and how much of it."""
    body = design.body
    if frame.along == "x":
        low, high = -0.5 * body.depth_mm, 0.5 * body.depth_mm
        found = [("end", mouth)] if frame.high > high - _TOUCHES else []
        if symmetric:
            return [*found, ("symmetry", mouth)]
        return [*found, ("end", mouth)] if frame.low < low + _TOUCHES else found
    half = 0.5 * body.width_mm
    share = 0.5 if symmetric else 1.0
    sides = (frame.high > half - _TOUCHES) + (frame.low < -half + _TOUCHES)
    found = [("side", share * mouth * sides)] if sides else []
    if symmetric:
        level = abs(frame.axis[0]) > 0.5  # along z: cut across; upright: cut along its mid-surface
        found.append(("symmetry", frame.span * (frame.thickness if level else frame.length)))
    return found


def _step_areas(design: Design, mesh: Mesh) -> dict[str, float]:
    """Areas of a STEP body's faces; of a half model's the halves, without "symmetry"."""
    from fingerdesign.design.step_facts import step_facts

    assert design.body.step is not None
    share = 0.5 if mesh.symmetric else 1.0
    areas = step_facts(design.body.step).area
    return {str(name): share * float(value) for name, value in areas.items()}
