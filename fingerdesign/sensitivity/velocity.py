"""Velocity of a mesh's nodes with a dimension: body and plates as they go, the rubber between.

Of a straight body every section point keeps its share of width and height,

    x -> x w' / w,     y -> y H'(x') / H(x),     z -> z d' / d        (H: height of the surface)

so base, sides and surface go where the new body's are. Plates move as rigid bodies, or as their
length and thickness grow, and carry the rubber along by ``mesh.moved.plate_weights``. Gages end at
nodes, and these go along with the gages' length: beyond an edge of a cell its strain is another.
"""

from collections.abc import Iterator

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.body import Body
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.bodies import surface_height
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.moved import straightened
from fingerdesign.mesh.types import Mesh
from fingerdesign.sensitivity.variant import Parameter, Variant

_STILL = 1e-9  # mm (or degrees) per unit: a slower motion is rounding of the differences


def immovable_faults(parameter: Parameter, dimension: int) -> list[Fault]:
    """Faults of a parameter that no velocity is known for, in a mesh of 2 or 3 dimensions: what is
    needed, and what to do instead. None where nothing moves."""
    if parameter.kind == "materials" or not _moves(parameter):
        return []
    return [
        Fault("parameters", f"'{parameter.name}'", bound, remedy)
        for wrong, bound, remedy in _immovable(parameter, dimension)
        if wrong
    ]


def _moves(parameter: Parameter) -> bool:
    """True where body or plates change."""
    rates = parameter.rate(lambda t: _places(parameter.at(t)))
    return parameter.kind == "body" or bool(np.abs(rates).max(initial=0.0) >= _STILL)


def is_rigid(parameter: Parameter, dimension: int) -> bool:
    """True where plates and gages keep their sizes: they move as rigid bodies."""
    if parameter.kind == "placement":
        return True

    def sizes(change: float) -> Array:
        varied = parameter.at(change)
        numbers = [[frame.length, frame.thickness] for frame in varied.frames]
        gages = varied.design.gages
        return np.array([gages.length_mm, gages.width_mm, gages.z_mm, *np.ravel(numbers)])

    deeper = dimension == 3 and parameter.name == "body.depth_mm"
    return not deeper and bool(np.abs(parameter.rate(sizes)).max() < _STILL)


def _immovable(parameter: Parameter, dimension: int) -> Iterator[tuple[bool, str, str]]:
    """Cases that no velocity is known for: if it is so, what is needed, what to do instead."""
    design, _, frames = parameter.at(0.0)
    yield design.plates.model != "solid", 'plates.model = "solid"', "model the plates as solids"
    bars = design.gages.leads is not None or design.gages.kind is not None
    barred = dimension == 3 and bars
    needed = "plates without [gages.leads] and gages.kind, which are stiff"
    yield barred and not is_rigid(parameter, dimension), needed, "leave them out"
    remedy = "leave this parameter out"
    if parameter.kind == "placement":
        moves = np.abs(parameter.rate(lambda t: _places(parameter.at(t)))).max(axis=1) > _STILL
        across = any(f.along != "x" for f, own in zip(frames, moves, strict=True) if own)
        yield across, "plates along x", remedy
        return
    flat = all(frame.along == "x" and frame.bend_radius is None for frame in frames)
    yield not flat, "flat plates along x", remedy
    yield design.body.core is not None, "a body without a core", remedy
    yield any(f.holes for f in frames), "plates without holes", remedy
    kind, body = design.body.kind, parameter.kind == "body"
    width = parameter.name in ("body.width_mm", "body.arc_radius_mm", "body.edge_radius_mm")
    edged = design.body.edge_radius_mm is not None and width
    needed = "a straight body, of width and radius without an edge"
    yield body and (not kind.straight or edged), needed, remedy
    if dimension == 3 and parameter.name != "body.depth_mm":
        ends = parameter.rate(lambda t: np.array([f.span for f in parameter.at(t).frames]))
        needed = "a key that leaves the plates' span in space as it is"
        yield bool(np.abs(ends).max(initial=0.0) > _STILL), needed, "leave it out"


def node_velocity(parameter: Parameter, mesh: Mesh, weights: Array) -> Array | None:
    """Velocity (n, dim) of the nodes per unit of the parameter; None where none moves. weights: of
    ``mesh.moved.plate_weights``."""
    if not _moves(parameter):
        return None
    if faults := immovable_faults(parameter, mesh.dimension):
        raise DesignError(faults[:1])
    rates = parameter.rate(lambda t: _places(parameter.at(t)))
    (design, _, frames), body = parameter.at(0.0), parameter.kind == "body"
    velocity, old = np.zeros_like(mesh.points), design.body
    if body:
        velocity = parameter.rate(lambda t: _mapped(mesh.points, old, parameter.at(t).design.body))
    section, carried = mesh.points[:, :2], velocity[:, :2].copy()
    for frame, rate, weight in zip(frames, rates, weights, strict=True):
        if np.abs(rate).max() < _STILL and not body:
            continue
        near = np.flatnonzero(weight)
        own = _motion(frame, design.gages.length_mm, rate, section[near])
        velocity[near, :2] += weight[near, None] * (own - carried[near])
    return straightened(mesh, velocity)


def _places(variant: Variant) -> Array:
    """Place, height, angle (rad), length, thickness, and the gage's length (plates, 6)."""
    gage = variant.design.gages.length_mm
    rows = [
        [f.place, f.y, np.radians(f.angle_deg), f.length, f.thickness, gage] for f in variant.frames
    ]
    return np.array(rows).reshape(-1, 6)


def _motion(frame: PlateFrame, gage: float, rate: Array, section: Array) -> Array:
    """Velocity (n, 2) of section points that go with a plate."""
    arm = section - frame.centre
    s, v = arm @ frame.axis, arm @ frame.normal
    spin = rate[2] * np.column_stack([-arm[:, 1], arm[:, 0]])
    ends, grown = (0.5 * np.array(pair) for pair in ((gage, frame.length), (rate[5], rate[3])))
    first = int(not gage < frame.length)
    knots, values = np.append(0.0, ends[first:]), np.append(0.0, grown[first:])
    along = np.sign(s) * np.interp(np.abs(s), knots, values)
    off = np.clip(v / frame.thickness, -0.5, 0.5) * rate[4]
    return np.asarray(rate[:2] + spin + np.outer(along, frame.axis) + np.outer(off, frame.normal))


def _mapped(points: Array, old: Body, new: Body) -> Array:
    """Points (n, dim) of a straight body, in another one."""
    half, wide = 0.5 * old.width_mm, 0.5 * new.width_mm
    x = np.clip(points[:, 0], -half, half)
    there = np.clip(x * (wide / half), -wide, wide)
    moved = points.copy()
    moved[:, 0] += there - x
    moved[:, 1] *= surface_height(new, there) / surface_height(old, x)
    if points.shape[1] == 3:
        moved[:, 2] *= new.depth_mm / old.depth_mm
    return moved
