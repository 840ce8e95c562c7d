"""Assembly: the plan and the parts as solids, which every check of a mold is given."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.mold.part import MoldMeshes
from fingerdesign.mold.plan.pieces import CorePin, Side, Slot, across, direction
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.solids import solid_of


def place_text(point: Array) -> str:
    """A place as a sentence has it, mm."""
    return f"({', '.join(f'{value:.2f}' for value in point)})"


def seen_from(side: Side, points: Array) -> tuple[Array, Array]:
    """Coordinates (place, distance outward) of points (n, 3) as seen from a side."""
    return points @ across(side), points @ direction(side)


def from_slot(slot: Slot, points: Array) -> Array:
    """Distance by which points (n, 3) on a slot's side lie beyond it and its mouth, mm; negative:
    within. NaN for points of the other half of the mold."""
    place, out = seen_from(slot.side, points)
    angle = np.radians(slot.angle_deg)
    dx, dy = place - slot.place, points[:, 1] - slot.y
    along = np.abs(dx * np.cos(angle) + dy * np.sin(angle)) - 0.5 * slot.length
    over = np.abs(dy * np.cos(angle) - dx * np.sin(angle)) - 0.5 * slot.width
    beyond = np.hypot(np.maximum(along, 0.0), np.maximum(over, 0.0))
    beyond = beyond + np.minimum(np.maximum(along, over), 0.0)
    if slot.mouth:
        below = [along, slot.mouth[1] - points[:, 1], out - slot.mouth[0], dy]
        beyond = np.minimum(beyond, np.max(below, axis=0))
    return np.asarray(np.where(out > 0.0, beyond, np.nan))


def from_pin(pin: CorePin, points: Array) -> Array:
    """Distance by which points (n, 3) lie beyond a core pin, mm; NaN for the other half."""
    place, out = seen_from(pin.side, points)
    beyond = np.hypot(place - pin.place, points[:, 1] - pin.y) - 0.5 * pin.diameter
    return np.asarray(np.where(out > 0.0, beyond, np.nan))


def planned(plan: MoldPlan, points: Array, slack_mm: float) -> BoolArray:
    """Test if points (n, 3) lie in an opening of the plan, or within ``slack_mm`` of one."""
    below = points[:, 1] < slack_mm
    open_ = (points[:, 1] > 0.0) & (points[:, 1] < plan.seam + slack_mm) & (plan.seam > 0.0)
    for hole in plan.base_holes:
        radius = hole.radius + slack_mm
        open_ |= below & (np.hypot(points[:, 0] - hole.x, points[:, 2] - hole.z) <= radius)
    for side in plan.sides:
        for slot in side.slots:  # NaN compares false
            open_ |= from_slot(slot, points) <= slack_mm
    for pin in plan.core_pins:
        open_ |= from_pin(pin, points) <= pin.clearance + slack_mm
    return open_


@dataclass(frozen=True)
class Assembly:
    """A closed mold: ``solids`` by name (parts, plates, "rubber")."""

    plan: MoldPlan
    meshes: MoldMeshes
    solids: Mapping[str, Manifold]

    @property
    def chord(self) -> float:
        """The greatest distance of any part's triangles from its surface, mm."""
        return max(part.chord for part in (*self.meshes.parts, self.meshes.outline))


def assemble(plan: MoldPlan, meshes: MoldMeshes) -> Assembly:
    """All solids of a mold; one that is not ``sound`` is in it too."""
    everything = (*meshes.parts, *meshes.plates, meshes.rubber)
    solids = {part.name: solid_of(part.vertices, part.triangles) for part in everything}
    return Assembly(plan, meshes, solids)
