"""What the engine is held to: analytic solutions and published results, asked against measured.

Every check is an error (relative unless said) and the most that is asked of it. Where theory is for
half spaces or large deformations and the case is not, the check's name says so.
"""

import numpy as np

from fingerdesign_bench.accuracy import analytic
from fingerdesign_bench.accuracy import verification_bodies as bodies
from fingerdesign_bench.accuracy.verification_contact import (
    Pressed,
    approach_errors,
    ball_on_plane,
    line_contact,
    peak_errors,
    point_contact,
    pressure_error,
    stick_errors,
    traction_error,
    width_errors,
)
from fingerdesign_bench.accuracy.verification_product import dome_errors
from fingerdesign_bench.check import Check

LINE_SIZES = (0.1, 0.07, 0.05, 0.035, 0.025, 0.0125)
POINT_SIZES = (0.2, 0.14, 0.1, 0.07)


def verification_checks() -> list[Check]:
    """All of them: about two minutes on two cores."""
    return [*line_checks(), *point_checks(), *dome_checks(), *two_body_checks(), *flat_checks()]


def line_checks() -> list[Check]:
    """Line contact at nu = 0.4999, 1000 half-widths deep, facets from 1/10 to 1/80 of one."""
    cases = [line_contact(size) for size in LINE_SIZES]
    name = f"line, {cases[-1].dofs} dofs"
    return [
        *_hertz_checks(name, cases[-1]),
        *_order_checks("line", LINE_SIZES, cases),
    ]


def point_checks() -> list[Check]:
    """A sphere at nu = 0.4999, 1000 contact radii deep, facets from 1/5 to 1/14 of one."""
    cases = [point_contact(size) for size in POINT_SIZES]
    name = f"sphere, {cases[-1].dofs} dofs"
    return [
        Check(f"{name}: force at its approach", 5e-3, _worst(approach_errors(cases[-1]))),
        *_hertz_checks(name, cases[-1]),
        *_order_checks("sphere", POINT_SIZES, cases),
        *_hertz_checks("elastic half ball under a plane", ball_on_plane(POINT_SIZES[-1])),
    ]


def dome_checks() -> list[Check]:
    """A dome under a plane as ``fingerdesign analyse`` solves it, nine contact radii high."""
    errors = dome_errors()
    return [
        Check("dome by fTetWild: peak pressure", 1e-2, _worst(np.array(errors.peak))),
        Check("dome by fTetWild: contact width", 4e-2, _worst(np.array(errors.width))),
        Check(
            "dome by fTetWild: stick radius",
            4e-2,
            _worst(np.array(errors.stick)),
            "of the contact's",
        ),
        *pin_checks(),
    ]


def pin_checks() -> list[Check]:
    """A sphere-ended pin, its contact sixteen facets across a radius."""
    errors = dome_errors(0.075, "pin")
    return [
        Check("pin by fTetWild: peak pressure", 1e-2, _worst(np.array(errors.peak))),
        Check("pin by fTetWild: contact radius", 1e-2, _worst(np.array(errors.width))),
        Check("pin by fTetWild: stick radius", 4e-2, _worst(np.array(errors.stick))),
    ]


def two_body_checks() -> list[Check]:
    """Equal cylinders and NAFEMS' roller, both bodies elastic."""
    cylinders = bodies.equal_cylinders(0.01)
    pressed, sheared = cylinders.steps[0].measures, cylinders.steps[-1].measures
    smooth, rough = bodies.nafems_roller(0.1), bodies.nafems_roller(0.1, 0.1)
    roller, rubbed = smooth.steps[-1].measures, rough.steps[-1].measures
    moved = float(rough.displacement(np.zeros(2))[1])
    share = sheared.stick_width / sheared.contact_width
    return [
        Check("equal cylinders: half-width", 1e-2, _off(0.5 * pressed.contact_width, 0.6808)),
        Check("equal cylinders: peak pressure", 5e-3, _off(pressed.peak_pressure, 9.351)),
        Check("equal cylinders: stick over contact width", 1e-2, _off(share, 0.7293)),
        Check("NAFEMS roller: half-width", 1e-2, _off(0.5 * roller.contact_width, 6.215)),
        Check("NAFEMS roller: peak pressure", 5e-3, _off(roller.peak_pressure, 3585.0)),
        Check(
            "NAFEMS roller, mu = 0.1: settlement of the block's top (another code)",
            3e-2,
            _off(moved, -1.30264),
        ),
        Check(
            "NAFEMS roller, mu = 0.1: peak against a stress extrapolated from the volume",
            4e-2,
            _off(rubbed.peak_pressure, 3542.7),
        ),
    ]


def flat_checks() -> list[Check]:
    """Flat faces, thin layers, bodies that contact alone holds."""
    plate = bodies.pressed_plate()
    moved = {0.0: 2.86e-2, 1.25: 2.72e-2, 5.0: 2.28e-2, 7.5: 1.98e-2, 11.25: 1.50e-2}
    punch = bodies.flat_punch()
    x = punch.problem.model.points[:, 0]
    inner = np.abs(x) < 0.9
    exact = analytic.flat_punch_pressure(x[inner], 1.0, 1.0)
    layer = bodies.bonded_layer().steps[-1].measures
    force, peak, _ = analytic.bonded_incompressible_layer(40.0, 1e6, 1.0, 1.0)
    wedge = bodies.wedge().steps[-1].measures
    ratio = wedge.tangential_force / wedge.normal_force
    return [
        *(
            Check(
                f"SSNV128: tangential displacement at x = {place:g} mm",
                5e-2,
                _off(float(plate.displacement(np.array([place, 0.0]))[0]), wanted),
            )
            for place, wanted in moved.items()
        ),
        Check(
            "flat punch: pressure in |x| < 0.9 of its half-width",
            1.5e-2,
            _worst(punch.pressure[inner] / exact - 1.0),
        ),
        Check("bonded layer, a / b = 40: force", 1e-2, _off(layer.normal_force, force)),
        Check("bonded layer, a / b = 40: peak pressure", 1e-2, _off(layer.peak_pressure, peak)),
        Check("NAFEMS CGS-4 wedge: F / G", 6e-4, _off(ratio, analytic.sliding_wedge(0.1, 0.3))),
    ]


def _hertz_checks(name: str, case: Pressed) -> list[Check]:
    return [
        Check(f"{name}: peak pressure", 5e-3, _worst(peak_errors(case))),
        Check(f"{name}: contact half-width", 1e-2, _worst(width_errors(case))),
        Check(
            f"{name}: stick half-width, loading",
            1e-2,
            _worst(stick_errors(case, case.sheared)),
            "of the contact's",
        ),
        Check(
            f"{name}: stick half-width, unloading and reversed",
            1e-2,
            _worst(stick_errors(case, case.returned)),
            "of the contact's",
        ),
    ]


def _order_checks(name: str, sizes: tuple[float, ...], cases: list[Pressed]) -> list[Check]:
    """Fitted orders, as how much they fall below the expected ones.

    1 for pressure and traction in L2 and for the borders, 2 for the peak: see
    benchmarks/tests/test_round_contact.py.
    """
    errors = {
        ("pressure, L2", 1.0): [[pressure_error(c, s) for s in c.pressed] for c in cases],
        ("shear traction, L2", 1.0): [[traction_error(c, s) for s in c.sheared] for c in cases],
        ("peak pressure", 2.0): [list(peak_errors(c)) for c in cases],
        ("contact half-width", 1.0): [list(width_errors(c)) for c in cases],
    }
    checks = []
    for (what, expected), rows in errors.items():
        means = np.sqrt(np.mean(np.square(rows), axis=1))
        order = float(np.polyfit(np.log(sizes), np.log(means), 1)[0])
        label = f"{name}: order of the {what} {order:.2f}, below the expected {expected:g} by"
        checks.append(Check(label, 0.4, max(0.0, expected - order)))
    return checks


def _worst(errors: np.ndarray) -> float:
    return float(np.abs(errors).max())


def _off(measured: float, wanted: float) -> float:
    return abs(measured / wanted - 1.0)
