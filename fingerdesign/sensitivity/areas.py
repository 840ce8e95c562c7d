"""Rates of the contact and stick areas: of the quadrature of contact/measures.py (numpy only).

Both areas are differentiable wherever no level set passes through a node; statuses may change
then, as the borders fall between nodes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.increment import Increment
from fingerdesign.contact.laws import OPEN, SLIP, STICK, lengths
from fingerdesign.contact.measures import border_compliances, level_sets, positive_fraction
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.sensitivity.path import PathRates

# Of the largest force: no change of a parameter that matters keeps a smaller pull's direction.
_NO_PULL = 1e-6


@dataclass(frozen=True)
class OwnRates:
    """Explicit rates that areas need: compliance (pairs, P), mm/N, of :func:`border_pairs`, normal
    by normal; areas (m, P), facet_areas (f, P) mm^2; friction (P,)."""

    pairs: tuple[IntArray, IntArray]
    compliance: Array
    areas: Array
    facet_areas: Array
    friction: Array


def area_rates(
    problem: ContactProblem, steps: Sequence[Step], rates: PathRates, own: OwnRates
) -> Array:
    """Rates (rows, 2, P) of contact area and stick area of the whole finger, mm^2, at each row."""
    border = _border_rates(problem, rates.nodes, own)
    found = np.empty((len(steps), 2, own.friction.size))
    first = 0
    for row, step in enumerate(steps):
        slid = np.zeros((len(rates.nodes), own.friction.size))
        for k, increment in enumerate(step.row, first):
            past = rates.local[k - 1] if k else np.zeros_like(rates.local[0])
            slip = increment.slip_increment[rates.nodes]
            size, sliding = lengths(slip)[:, None], increment.state.sliding[rates.nodes, None]
            moving = (sliding > 0.0) & (size > 0.0)
            way = np.divide(slip, size, out=np.zeros_like(slip), where=moving)
            more = np.einsum("na,nap->np", way, (rates.local[k] - past)[:, 1:])
            slid = np.where(moving, slid + more, 0.0)
        first += len(step.row)
        fields = _level_rates(problem, step.increment, rates, first - 1, own, border, slid)
        found[row] = _areas(problem, step.increment, rates.nodes, fields, own)
    return found


def border_pairs(
    problem: ContactProblem, steps: Sequence[Step], nodes: IntArray
) -> tuple[IntArray, IntArray]:
    """Pairs of near nodes, by their places in ``nodes``, on whose compliances areas depend.

    Of each node of a facet that a border crosses, itself, and in plane strain its neighbour too.
    """
    m, dim = problem.shape
    crossed = np.zeros(m, dtype=bool)
    for step in steps:
        contact, stick = level_sets(problem, step.increment)
        # Without a gap and a slip a node's own compliance makes no force of them.
        far = (step.increment.status == OPEN) | (step.increment.state.sliding > 0.0)
        for level in (contact, np.minimum(contact, stick)):
            inside = (level > 0.0)[problem.model.facets]
            mixed = inside.any(axis=1) & ~inside.all(axis=1)
            own = problem.model.facets[mixed]
            crossed[own[far[own]]] = True
    mine = np.flatnonzero(crossed[nodes])
    if dim == 3:
        return mine, mine
    place = np.full(m, -1)
    place[nodes] = np.arange(len(nodes))
    most, other = np.full(m, 0.0), np.full(m, -1)
    normal = problem.compliance[::dim, ::dim]
    for here, there in (pair for line in problem.model.facets for pair in (line, line[::-1])):
        if normal[here, there] > most[here]:
            most[here], other[here] = normal[here, there], place[there]
    near = mine[other[nodes[mine]] >= 0]
    return np.append(mine, near), np.append(mine, other[nodes[near]])


def on_corner(problem: ContactProblem, steps: Sequence[Step]) -> Array:
    """Share (rows,) of the normal force on nodes at the border of stick without a tangential force.

    The size of a tangential force has a corner at zero, and so has the stick area there.
    """
    found = np.zeros(len(steps))
    for row, step in enumerate(steps):
        multiplier, facets = step.increment.multiplier, problem.model.facets
        inside = (np.minimum(*level_sets(problem, step.increment)) > 0.0)[facets]
        border = np.zeros(len(multiplier), dtype=bool)
        border[facets[inside.any(axis=1) & ~inside.all(axis=1)]] = True
        normal = multiplier[:, 0]
        still = lengths(multiplier[:, 1:]) < _NO_PULL * normal.max(initial=0.0)
        still &= border & (step.increment.status == STICK) & (normal > 0.0)
        found[row] = normal[still].sum() / max(float(normal.sum()), 1e-300)
    return found


def _border_rates(problem: ContactProblem, nodes: IntArray, own: OwnRates) -> tuple[Array, Array]:
    """Rates (n, P) of both of ``border_compliances`` at the near nodes."""
    first, second = own.pairs
    alone = first == second
    itself, local = np.zeros((2, len(nodes), own.friction.size))
    itself[first[alone]] = own.compliance[alone]
    if problem.shape[1] == 3:
        return itself, itself
    local[:] = itself
    local[first[~alone]] -= own.compliance[~alone]
    beyond = problem.own_compliance[nodes] > 0.05 * problem.self_compliance[nodes]
    local = np.where(beyond[:, None], local, 0.05 * itself)
    return 4.0 * local, 5.0 * local


def _level_rates(
    problem: ContactProblem,
    increment: Increment,
    rates: PathRates,
    k: int,
    own: OwnRates,
    border: tuple[Array, Array],
    slid: Array,
) -> Array:
    """Rates (2, n, P), MPa, of the contact field and of the lesser of both."""
    nodes = rates.nodes
    opened, slipped = (each[nodes][:, None] for each in border_compliances(problem))
    area, areas = problem.model.areas[nodes][:, None], own.areas[nodes]
    multiplier, sliding = increment.multiplier[nodes], increment.state.sliding[nodes][:, None]
    gap = increment.gap[nodes][:, None]
    contact, stick = (each[nodes][:, None] for each in level_sets(problem, increment))
    normal, gap_rate = rates.multiplier[k][:, 0], rates.local[k][:, 0].copy()
    gap_rate[increment.status[nodes] != OPEN] = 0.0
    one = normal - gap_rate / opened + gap * border[0] / opened**2
    one = (one - contact * areas) / area
    size = lengths(multiplier[:, 1:])[:, None]
    way = np.divide(multiplier[:, 1:], size, out=np.zeros_like(multiplier[:, 1:]), where=size > 0.0)
    pull = np.einsum("na,nap->np", way, rates.multiplier[k][:, 1:])
    friction = max(problem.friction_coefficient, 1e-12)
    less = (size + sliding / slipped) / (friction * area)
    more = pull + slid / slipped - sliding * border[1] / slipped**2
    two = one - more / (friction * area) + less * (own.friction / friction + areas / area)
    clipped = (increment.status[nodes] == SLIP)[:, None] & (stick >= 0.0)
    two = np.where(clipped, 0.0, two)
    return np.stack([one, np.where(stick < contact, two, one)])


def _areas(
    problem: ContactProblem, increment: Increment, nodes: IntArray, fields: Array, own: OwnRates
) -> Array:
    """Rates (2, P) of both areas from those of the fields."""
    model = problem.model
    contact, stick = level_sets(problem, increment)
    place = np.full(model.nodes, -1)
    place[nodes] = np.arange(len(nodes))
    near = (place[model.facets] >= 0).all(axis=1)
    corners = place[model.facets[near]]
    found = np.empty((2, own.friction.size))
    for number, level in enumerate((contact, np.minimum(contact, stick))):
        values = level[model.facets]
        share = positive_fraction(values)
        slope = fraction_slopes(values[near])
        rate = np.einsum("fk,fkp->fp", slope, fields[number][corners])
        found[number] = model.facet_areas[near] @ rate + share @ own.facet_areas
    return np.asarray(model.symmetry_factor * found)


def fraction_slopes(values: Array) -> Array:
    """Derivatives (f, k) of ``positive_fraction`` with the corner values.

    >>> fraction_slopes(np.array([[1.0, -1.0]])).tolist()
    [[0.25, 0.25]]
    """
    positive, slope, width = values > 0.0, np.zeros_like(values), values.shape[1]
    count = positive.sum(axis=1)
    rows = np.flatnonzero((count > 0) & (count < width))
    lone_positive = count[rows] == 1
    lone = np.argmax(positive[rows] == lone_positive[:, None], axis=1)
    order = (lone[:, None] + np.arange(width)) % width
    mixed = values[rows[:, None], order]
    own, rest = mixed[:, :1], mixed[:, 1:]
    cut = np.prod(own / (own - rest), axis=1)
    by_rest = cut[:, None] / (own - rest)
    with np.errstate(divide="ignore", invalid="ignore"):
        by_own = cut * (1.0 / own - 1.0 / (own - rest)).sum(axis=1)
    by_own = np.where(own[:, 0] == 0.0, 0.0, by_own)
    sign = np.where(lone_positive, 1.0, -1.0)[:, None]
    slope[rows[:, None], order] = sign * np.column_stack([by_own, by_rest])
    return slope
