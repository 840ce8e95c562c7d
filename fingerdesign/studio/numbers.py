"""Results of a press: forces, contact, tractions, readings; the same of every model."""

from dataclasses import dataclass

import numpy as np

from fingerdesign.analysis.page.contact import middle_tractions
from fingerdesign.analysis.path import contact_history
from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.measures import COMPLETE_SLIP
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.control.signals import gage_readings
from fingerdesign.design.schema import Design
from fingerdesign.studio.sliders import Press

PRESSES, SHEARS = 8, 12  # increments of each leg


@dataclass(frozen=True, eq=False)
class Numbers:
    """The answer of one model, increment by increment (k) or at the last one, on the line z = 0.

    normal, tangential  (k,) N; ratio (k,) stick area over contact area, NaN without contact
    width               mm, of the contact at the last increment; peak (MPa) its pressure
    x, pressure, shear  (l,) mm, MPa: tractions along the contact at the last increment
    status_x, status    (s,) open, stick, slip at the last increment
    readings            (k, gages) microstrain; gage_x (gages,) mm
    """

    dimension: int
    friction: float
    normal: Array
    tangential: Array
    ratio: Array
    width: float
    peak: float
    x: Array
    pressure: Array
    shear: Array
    status_x: Array
    status: IntArray
    readings: Array
    gage_x: Array

    @property
    def slips(self) -> bool:
        """True where the contact slips as a whole at the end."""
        return bool(self.tangential[-1] > 0.0 and self.ratio[-1] < COMPLETE_SLIP[self.dimension])

    @property
    def touches(self) -> bool:
        """True where there is a contact at the end."""
        return bool(np.isfinite(self.ratio[-1]))

    @property
    def signals(self) -> Array:
        """Change of each reading by the shear alone (gages,), microstrain."""
        return np.asarray(self.readings[-1] - self.readings[PRESSES - 1])


def motions(press: Press) -> list[Motion]:
    """The path: pressed in equal increments, then sheared in equal increments."""
    down = [Motion(press.approach * k / PRESSES, 0.0) for k in range(1, PRESSES + 1)]
    across = [Motion(press.approach, press.shear * k / SHEARS) for k in range(1, SHEARS + 1)]
    return down + across


def numbers_of(design: Design, problem: ContactProblem, press: Press) -> Numbers:
    """Follow the press on a condensed finger.

    Raises SolverError where an increment has no accepted answer, ZoneExhausted where the contact
    outgrows the candidates.
    """
    problem = problem.with_friction(press.friction)
    steps = list(follow(problem, motions(press)))
    measures = [step.measures for step in steps]
    contact = contact_history(problem, steps)
    line = contact.mid_line()
    x, pressure, shear = middle_tractions(contact, line)
    face = design.gages.face
    ratios = [np.nan if each.stick_ratio is None else each.stick_ratio for each in measures]
    return Numbers(
        dimension=problem.model.dimension,
        friction=press.friction,
        normal=np.array([each.normal_force for each in measures]),
        tangential=np.array([each.tangential_force for each in measures]),
        ratio=np.array(ratios),
        width=measures[-1].contact_width,
        peak=measures[-1].peak_pressure,
        x=x,
        pressure=pressure[-1],
        shear=shear[-1, :, 0],
        status_x=contact.points[line, 0],
        status=contact.status[-1, line],
        readings=np.array([gage_readings(each.gages, face) for each in measures]),
        gage_x=problem.model.gage_x,
    )
