"""Hertz and Cattaneo-Mindlin: a rigid cylinder or sphere on a half-space, a ball under a plane.

E = 1 MPa, the last contact's half-width 1 mm. Values are over Hertz's at the last normal load.
"""

from functools import lru_cache

import numpy as np

from fingerdesign_bench.accuracy import analytic
from fingerdesign_bench.accuracy import verification_contact as rounds
from fingerdesign_bench.accuracy.verification_contact import Pressed
from fingerdesign_bench.accuracy.verification_product import dome_errors
from fingerdesign_bench.known.case import Curve, Picture, Solution, compare_curves

line_contact = lru_cache(maxsize=8)(rounds.line_contact)
point_contact = lru_cache(maxsize=4)(rounds.point_contact)


def line(size: float = 0.025) -> Solution:
    """A cylinder: facets of ``size`` half-widths."""
    return _hertz(line_contact(size))


def sphere(size: float = 0.1) -> Solution:
    """A sphere: the approach, too."""
    case = point_contact(size)
    solution = _hertz(case)
    solution.values["force at the approach"] = 1.0 + float(rounds.approach_errors(case)[-1])
    return solution


def ball(size: float = 0.1) -> Solution:
    """An elastic half ball under a plane."""
    return _hertz(rounds.ball_on_plane(size))


def _hertz(case: Pressed) -> Solution:
    """Half-width and peak over Hertz's, stick c / a, worst L2 errors; the last shear's picture."""
    last, model = case.pressed[-1], case.problem.model
    contact = rounds.hertz_of(case, last)
    named = {f"stick at {q:g}": s for q, s in zip(rounds.SHEARS, case.sheared, strict=True)}
    named |= {f"stick back at {q:g}": s for q, s in zip(rounds.BACK, case.returned, strict=True)}
    values = {
        name: rounds.half_width(case, step.measures.stick_area) / contact.half_width
        for name, step in named.items()
    }
    width = rounds.half_width(case, last.measures.contact_area)
    values |= {
        "half-width": width / contact.half_width,
        "peak pressure": last.measures.peak_pressure / contact.peak_pressure,
        "pressure, L2": rounds.pressure_error(case, last),
        "traction, L2": max(rounds.traction_error(case, step) for step in case.sheared),
    }
    row = np.abs(model.points[:, 2]) < 1e-9 if model.dimension == 3 else np.ones(model.nodes, bool)
    x, step = model.points[row, 0], case.sheared[-1]
    share, friction = rounds.stick_share(case, step), case.problem.friction_coefficient
    known = analytic.cattaneo_mindlin_traction(x, contact, share, friction)
    found = step.increment.force[row, 0] / model.areas[row]
    picture = compare_curves("x / a", "shear traction at Q = 0.8 mu P (MPa)", x, known, found)
    return Solution(values, picture, (case.problem, case.steps))


def line_rates(sizes: tuple[float, ...] = (0.1, 0.07, 0.05, 0.035, 0.025)) -> Solution:
    """Fitted orders in the facets' size."""
    return _rates([line_contact(size) for size in sizes], sizes)


def sphere_rates(sizes: tuple[float, ...] = (0.2, 0.14, 0.1)) -> Solution:
    """The same of a sphere."""
    return _rates([point_contact(size) for size in sizes], sizes)


def _rates(cases: list[Pressed], sizes: tuple[float, ...]) -> Solution:
    """1 is expected of pressure and traction in L2 and of the borders, 2 of the peak pressure."""
    errors = {
        "pressure, L2": [[rounds.pressure_error(c, s) for s in c.pressed] for c in cases],
        "traction, L2": [[rounds.traction_error(c, s) for s in c.sheared] for c in cases],
        "peak pressure": [list(rounds.peak_errors(c)) for c in cases],
        "half-width": [list(rounds.width_errors(c)) for c in cases],
    }
    means = {name: np.sqrt(np.mean(np.square(rows), axis=1)) for name, rows in errors.items()}
    return orders(np.array(sizes), means, "log10 of size / a")


def orders(sizes: np.ndarray, errors: dict[str, np.ndarray], across: str) -> Solution:
    """Fitted orders of each error, and the errors on logarithmic axes."""
    values = {
        name: float(np.polyfit(np.log(sizes), np.log(np.abs(e)), 1)[0])
        for name, e in errors.items()
    }
    curves = tuple(
        Curve(name, np.log10(sizes), np.log10(np.abs(e)), False) for name, e in errors.items()
    )
    return Solution(values, Picture(across, "log10 of the error", curves))


def product(shape: str, size: float) -> Solution:
    """A design with a round crest through ``analyse``, its mesh by fTetWild: over Hertz's."""
    errors = dome_errors(size, shape)
    number = np.arange(len(errors.peak), dtype=float)
    curves = tuple(
        Curve(name, number, 100.0 * np.array(each), False)
        for name, each in (("peak", errors.peak), ("width", errors.width), ("stick", errors.stick))
    )
    worst = {
        "peak pressure": 1.0 + max(errors.peak, key=abs),
        "width": 1.0 + max(errors.width, key=abs),
        "stick, off": max(errors.stick, key=abs),
    }
    return Solution(worst, Picture("increment", "error (%)", curves))
