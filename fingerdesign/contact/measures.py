"""Areas, widths and pressures of an increment, by quadrature of linear fields (numpy only).

Contact is where lambda_n / a_i - gap / (C_ii a_i) > 0, slip where the trial traction exceeds its
bound. Both fields are interpolated linearly over the facets, so areas change smoothly as the
contact moves, and a border falls between nodes.
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.increment import Increment
from fingerdesign.contact.laws import SLIP, lengths
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.reduced import ReducedModel

COMPLETE_SLIP = {2: 0.01, 3: 0.05}  # stick ratio below it under load
_NO_FORCE = 1e-9  # N: below it there is no load


@dataclass(frozen=True)
class Measures:
    """Measures of one increment: whole finger, mm, N, MPa. Strains are plain (not micro)."""

    normal_force: float
    tangential_force: float
    contact_area: float
    stick_area: float
    contact_width: float
    stick_width: float
    peak_pressure: float
    open_nodes: int
    stick_nodes: int
    slip_nodes: int
    slip_distance: float
    gages: Array  # (plates, 2) upper, lower
    points: Array  # (points, 6)
    force_z: float = 0.0  # on the finger, toward +z
    twist_moment: float = 0.0  # N mm, on the finger about +y through x = z = 0

    @property
    def stick_ratio(self) -> float | None:
        """Stick area / contact area, None without contact."""
        return self.stick_area / self.contact_area if self.contact_area > 0.0 else None


def measure(problem: ContactProblem, increment: Increment) -> Measures:
    """All measures of one increment."""
    model = problem.model
    contact, stick = level_sets(problem, increment)
    normal_force, tangential_force = problem.resultant(increment.force).tolist()
    factor = model.symmetry_factor
    # Plane strain: areas are lengths x depth already; in 3-D of the modelled half.
    fields = np.stack([contact, np.minimum(contact, stick)])
    corners = fields[:, model.facets]
    shares = positive_fraction(corners.reshape(-1, corners.shape[2])).reshape(2, -1)
    contact_area, stick_area = (factor * float(model.facet_areas @ share) for share in shares)
    contact_width, stick_width = _widths(model, fields, shares)
    pressure = increment.multiplier[:, 0] / model.areas
    inner = ~model.free_end
    touching = increment.multiplier[:, 0] > 0.0
    travelled = increment.state.travelled[touching]
    opened, stuck, slipping = np.bincount(increment.status, minlength=3)
    force_z, twist_moment = _out_of_section(model, increment.force)
    return Measures(
        normal_force=normal_force + 0.0,  # no minus zero
        tangential_force=tangential_force,
        contact_area=contact_area,
        stick_area=stick_area,
        contact_width=contact_width,
        stick_width=stick_width,
        peak_pressure=float(pressure[inner].max(initial=0.0)),
        open_nodes=int(opened),
        stick_nodes=int(stuck),
        slip_nodes=int(slipping),
        slip_distance=float(travelled.min()) if touching.any() else 0.0,
        gages=model.gage_strain(increment.force),
        points=model.point_strain(increment.force),
        force_z=force_z,
        twist_moment=twist_moment,
    )


def _out_of_section(model: ReducedModel, force: Array) -> tuple[float, float]:
    """Force along z, N, and moment about +y, N mm; zero where the finger mirrors in z = 0."""
    if model.dimension == 2 or model.symmetry_factor == 2:
        return 0.0, 0.0
    moment = model.points[:, 2] @ force[:, 0] - model.points[:, 0] @ force[:, 2]
    return float(force[:, 2].sum()) + 0.0, float(moment) + 0.0


def completely_slips(measures: Measures, dimension: int) -> bool:
    """Complete slip: loaded, and (nearly) nothing sticks."""
    ratio = measures.stick_ratio
    loaded = measures.normal_force > _NO_FORCE and measures.tangential_force > _NO_FORCE
    return loaded and ratio is not None and ratio < COMPLETE_SLIP[dimension]


def level_sets(problem: ContactProblem, increment: Increment) -> tuple[Array, Array]:
    """Nodal fields (m,), MPa: > 0 in contact, > 0 sticking (where in contact)."""
    model = problem.model
    opened, slipped = border_compliances(problem)
    contact = (increment.multiplier[:, 0] - increment.gap / opened) / model.areas
    # In pressure too, so that where nothing pulls sideways both borders are the same.
    size = lengths(increment.multiplier[:, 1:])
    friction = np.maximum(problem.friction.secant(increment.multiplier[:, 0]), 1e-12)
    stick = contact - (size + increment.state.sliding / slipped) / (friction * model.areas)
    sliding = increment.status == SLIP
    stick[sliding] = np.minimum(stick[sliding], 0.0)  # exactly on the cone, whatever the rounding
    return contact, stick


def border_compliances(problem: ContactProblem) -> tuple[Array, Array]:
    """Compliances (m,) mm/N that make forces of gaps, and of slips, next to a border.

    In plane strain a node's own compliance grows with the body's depth and puts the border too far
    out; what it yields beyond its neighbours does not. With 4 and 5 times that, half-widths and
    stick widths of Hertz and Cattaneo-Mindlin came out two to three times as accurate (0.4 % with
    40 facets on a half-width); in 3-D no factor served both.
    """
    own = problem.self_compliance
    if problem.model.dimension == 3:
        return own, own
    local = np.maximum(problem.own_compliance, 0.05 * own)
    return 4.0 * local, 5.0 * local


def positive_fraction(values: Array) -> Array:
    """Part of each line or triangle (f, k) where the linear field with these corner values is > 0.

    >>> positive_fraction(np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 0.0]])).tolist()
    [0.5, 1.0, 0.0]
    >>> positive_fraction(np.array([[1.0, -1.0, -1.0], [1.0, 1.0, -1.0]])).tolist()
    [0.25, 0.75]
    """
    if values.shape[1] == 2:
        high = np.maximum(np.maximum(values[:, 0], values[:, 1]), 0.0)
        span = high - np.minimum(np.minimum(values[:, 0], values[:, 1]), 0.0)
        return np.asarray(np.divide(high, span, out=np.zeros(len(values)), where=span > 0.0))
    positive = values > 0.0
    count = np.einsum("fk->f", positive.view(np.int8))  # a sum along rows is slow
    fraction = (count == 3).astype(float)
    # One corner on its own side: a small triangle similar to the whole is cut off there.
    rows = np.flatnonzero((count == 1) | (count == 2))
    lone_positive = count[rows] == 1
    lone = np.argmax(positive[rows] == lone_positive[:, None], axis=1)
    mixed = values[rows[:, None], (lone[:, None] + np.arange(3)) % 3]  # the lone one first
    own = mixed[:, :1]
    cut = np.prod(own / (own - mixed[:, 1:]), axis=1)
    fraction[rows] = np.where(lone_positive, cut, 1.0 - cut)
    return np.asarray(fraction)


def _widths(model: ReducedModel, fields: Array, shares: Array) -> tuple[float, float]:
    """Lengths along x at z = 0 where the fields (2, m) are positive, given their shares (2, f)."""
    if model.dimension == 2:
        along = np.abs(np.diff(model.points[model.facets, 0])[:, 0])
    else:
        line = model.mid_line
        ends = _along(line, model.points[:, 0])
        along = np.abs(ends[:, 1] - ends[:, 0])
        values = np.concatenate([_along(line, field) for field in fields])
        shares = positive_fraction(values).reshape(2, -1)
    contact, stick = shares @ along
    return float(contact), float(stick)


def _along(line: tuple[IntArray, IntArray, Array], values: Array) -> Array:
    """Nodal values at the end points (s, 2) of the line's pieces."""
    first, second, weight = line
    return np.asarray((1.0 - weight) * values[first] + weight * values[second])


def limits(problem: ContactProblem, increment: Increment) -> tuple[Array, Array]:
    """Borders of contact and of stick on z = 0: two (2,) of x in mm, NaN where none is."""
    line = problem.model.mid_line
    contact, stick = level_sets(problem, increment)
    points = problem.model.points
    return _extent(points, line, contact), _extent(points, line, np.minimum(contact, stick))


def _extent(points: Array, line: tuple[IntArray, IntArray, Array], field: Array) -> Array:
    x, values = _along(line, points[:, 0]), _along(line, field)
    inside = x[values > 0.0]
    crossing = (values[:, 0] > 0.0) != (values[:, 1] > 0.0)
    left, right = values[crossing, 0], values[crossing, 1]
    border = x[crossing, 0] + (x[crossing, 1] - x[crossing, 0]) * left / (left - right)
    every = np.concatenate([inside, border])
    return np.array([every.min(), every.max()]) if len(every) else np.full(2, np.nan)
