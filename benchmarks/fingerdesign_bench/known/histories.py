"""Answers that hang on the path: Spence, Ciavarella and Jaeger, Mindlin and Deresiewicz, Lubkin,
Carter. A rigid round on a half-space as in rounds.py."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces, solve_forces
from fingerdesign.contact.measures import measure
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion, contact_problem
from fingerdesign.fem.reduction import body_model
from fingerdesign.reduced import ReducedModel
from fingerdesign.shapes.objects import Cylinder, Plane, Sphere
from fingerdesign_bench.accuracy import analytic
from fingerdesign_bench.known.case import Solution
from fingerdesign_bench.known.rounds import (
    FRICTION,
    NU,
    RADIUS,
    line_block,
    line_contact,
    load,
    modulus,
    orders,
    point_block,
)
from fingerdesign_bench.known.theory import (
    line_loss,
    line_shift,
    lubkin,
    mindlin_loss,
    mindlin_shift,
)

STILL = Motion(0.0, 0.0)


@lru_cache(maxsize=4)
def _model(plane: bool, poissons_ratio: float) -> ReducedModel:
    block = line_block(0.025, poissons_ratio) if plane else point_block(0.1, poissons_ratio)
    return body_model(block)


def _problem(plane: bool, friction: float, poissons_ratio: float = NU) -> ContactProblem:
    indenter = Cylinder(RADIUS, RADIUS) if plane else Sphere(RADIUS, RADIUS)
    return contact_problem(_model(plane, poissons_ratio), indenter, friction)


def _stick(step: Step, plane: bool) -> float:
    """c / a: of a circle, the root of the areas' ratio."""
    share = step.measures.stick_ratio or 0.0
    return share if plane else share**0.5


def spence(plane: bool, poissons_ratio: float, friction: float) -> Solution:
    """Normal load alone, each increment wider by one ratio, so that each is like the last.

    Stick c / a, and the pressure in the middle over what Hertz's would be at this force and area.
    """
    ratio = 1.025 if plane else 1.08
    count = int(np.ceil(np.log(20.0 if plane else 5.0) / np.log(ratio)))
    problem = _problem(plane, friction, poissons_ratio)
    widths = ratio ** np.arange(-count, 1.0)
    rows = [Forces(load(plane, float(a), poissons_ratio), held=STILL) for a in widths]
    *_, last = follow(problem, rows)
    measures = last.measures
    centre = measures.peak_pressure * measures.contact_area / measures.normal_force
    values = {"stick": _stick(last, plane), "centre": centre * (np.pi / 4.0 if plane else 2.0 / 3)}
    return Solution(values)


def together(plane: bool, slope: float, start: float, count: int = 20) -> Solution:
    """N to a share ``start`` of its end; then N and T, dT/dN = slope mu, in ``count`` steps.

    slope < 1: nothing slips, q = slope mu (p(N) - p(start)). Else q = mu (p(N) - p(N - T / mu)),
    and the path ends half way: at N = 0.75, T = 0.5 mu for slope = 2 and start = 0.5.
    """
    problem, full = _problem(plane, FRICTION), load(plane)
    model = problem.model
    distance = np.linalg.norm(model.points[:, ::2], axis=1)
    hertz = analytic.hertz_line if plane else analytic.hertz_point

    def pressure(share: float) -> Array:
        if share <= 0.0:
            return np.zeros(model.nodes)
        return hertz(share * full, RADIUS, modulus()).pressure(distance)

    end = 1.0 if slope < 1.0 else 0.5 * (1.0 + start)
    rise = np.linspace(start, end, count + 1)[1:]
    rows = [Forces(start * full, held=STILL)] if start else []
    rows += [Forces(n * full, slope * FRICTION * (n - start) * full) for n in rise]
    steps = tuple(follow(problem, rows))
    inner = start if slope < 1.0 else end - slope * (end - start)
    known = min(slope, 1.0) * FRICTION * (pressure(end) - pressure(inner))
    found = steps[-1].increment.force[:, 0] / model.areas
    off = np.sqrt(model.areas @ (found - known) ** 2 / (model.areas @ known**2))
    values = {"stick": _stick(steps[-1], plane), "traction, L2": float(off)}
    return Solution(values, (problem, steps))


def together_rates() -> Solution:
    """Order in the increment of the traction of a proportional load with dT/dN = mu / 2."""
    counts = (5, 10, 20, 40)
    errors = [together(True, 0.5, 0.0, count).values["traction, L2"] for count in counts]
    return orders(1.0 / np.array(counts), {"traction, L2": np.array(errors)})


def _sheared(
    problem: ContactProblem, full: float, shift: Callable[[float, float], float], most: float
) -> tuple[tuple[Step, ...], Array, float]:
    """Sheared to ``most`` mu P, back to minus it and forth again, in tenths: steps, shifts (k,) mm
    from the first turn on, and the work of the cycle over that of ``shift``, rid of the chords'
    own error."""
    up = np.linspace(0.0, most, round(10 * most) + 1)[1:]
    down = np.linspace(most, -most, round(20 * most) + 1)[1:]
    rows = [Forces(full, held=STILL)]
    rows += [Forces(full, q * FRICTION * full) for q in (*up, *down, *-down)]
    steps = tuple(follow(problem, rows))
    found = np.array([step.increment.motion.shear for step in steps[len(up) :]])
    back = np.array([shift(q, most) for q in (most, *down)])
    shares = np.concatenate([[most], down, -down])
    known = np.concatenate([back, -back[1:]])
    return steps, found, float(np.trapezoid(shares, found) / np.trapezoid(shares, known))


def loop(most: float = 0.8) -> Solution:
    """A sphere sheared to and fro by ``most`` mu P.

    Shifts over Mindlin's 3 mu P (2 - nu) / (16 G a), the work of a cycle over mu P times that.
    """
    problem, full = _problem(False, FRICTION), load(False)
    unit = 3.0 * FRICTION * full * (2.0 - NU) * 2.0 * (1.0 + NU) / 16.0  # E = 1, a = 1
    steps, shifts, work = _sheared(problem, full, mindlin_shift, most)
    values = {
        "shift at the turn": shifts[0] / unit,
        "shift left at no force": shifts[len(shifts) // 4] / unit,
        "work of a cycle": work / unit * mindlin_loss(most),
        "closed": (shifts[-1] - shifts[0]) / unit,
    }
    return Solution(values, (problem, steps))


def line_loop(most: float = 0.8, size: float = 0.0125) -> Solution:
    """A cylinder sheared to and fro by ``most`` mu P.

    The shift over mu P / (pi E*), the work of a cycle over mu P times that.
    """
    problem, full = line_contact(size).problem, load(True)
    unit = FRICTION * full / (np.pi * modulus())
    steps, shifts, work = _sheared(problem, full, line_shift, most)
    values = {
        "shift left at no force": shifts[len(shifts) // 4] / unit,
        "work of a cycle": work / unit * line_loss(most),
    }
    return Solution(values, (problem, steps))


def line_limit(size: float = 0.0125) -> Solution:
    """A cylinder sheared to 0.95 mu P, then on by as much again, where all of it slips."""
    problem, full = line_contact(size).problem, load(True)
    shears = [Forces(full, share * FRICTION * full) for share in (0.5, 0.9, 0.95)]
    steps = tuple(follow(problem, [Forces(full, held=STILL), *shears]))
    near = steps[-1].increment
    beyond = Forces(full, held=Motion(0.0, 2.0 * near.motion.shear))
    force = measure(problem, solve_forces(problem, near.state, beyond)).tangential_force
    values = {"stick at 0.95": _stick(steps[-1], True), "force beyond": force / (FRICTION * full)}
    return Solution(values, (problem, steps))


def torsion(stick: float = 0.5) -> Solution:
    """A sphere pressed, then turned about its axis: on to where Lubkin has c / a = ``stick``, and
    on until all slips. Moments over mu P a."""
    model = body_model(point_block(0.1, depth=30.0, whole=True))
    problem = contact_problem(model, Sphere(RADIUS, RADIUS), FRICTION)
    full, unit = load(False), FRICTION * load(False) * 2.0 * (1.0 + NU)  # mu P / (G a^2)
    turn, _ = lubkin(stick)
    turns = np.append(turn * np.arange(1.0, 7.0) / 6.0, [1.5 * turn, 8.0 * turn])
    rows = [Forces(full, held=STILL)]
    rows += [Forces(full, held=Motion(0.0, 0.0, 0.0, float(np.degrees(t * unit)))) for t in turns]
    steps = tuple(follow(problem, rows))
    moments = np.abs([step.measures.twist_moment for step in steps[1:]]) / (FRICTION * full)
    values = {"moment": moments[5], "stick": _stick(steps[6], False), "most": moments[-1]}
    return Solution(values, (problem, steps))


def rolling(share: float = 0.75, half_width: float = 0.5, step: float = 0.0125) -> Solution:
    """A cylinder rolls 2.8 half-widths over the flat while a force of ``share`` mu P drives it.

    What rolls on is the gap; the object's shear creeps, by so much of the way over mu a / R.
    """
    model = _model(True, NU)
    flat = contact_problem(model, Plane(0.0), FRICTION)
    full = load(True, half_width)
    forces = Forces(full, share * FRICTION * full)
    way = step * np.arange(round(2.8 * half_width / step) + 1)
    shears: list[float] = []
    for moved in way:
        across = model.surface.points[:, 0] - (moved - 1.4 * half_width)
        gap = model.surface.mean(across**2 / (2.0 * RADIUS), model.nodes)
        here = replace(flat, gap0=gap)
        if not shears:
            state = solve_forces(here, ContactState.untouched(here), Forces(full, held=STILL)).state
        increment = solve_forces(here, state, forces)
        state = increment.state
        shears.append(increment.motion.shear)
    measures = measure(here, increment)
    tenth = round(0.1 * len(way))
    creep = (shears[-1] - shears[-1 - tenth]) / (way[-1] - way[-1 - tenth])
    unit = FRICTION * half_width / RADIUS
    return Solution({"stick": measures.stick_ratio or 0.0, "creep": creep / unit})
