"""Forecast of a lift, before any model is built: force, approach, contact nodes, gages.

Forecasts, no results; how far off they were against the models of the shipped fingers is in
docs/reference/fingers.md and is held by tests/analysis/test_lift_forecast.py.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from fingerdesign.analysis.analysis import ENOUGH_NODES, SMALL_STRAIN
from fingerdesign.analysis.case import gage_array
from fingerdesign.analysis.detection import HELD_USED, SEEN, WANTED_STICK_CHANGE, amplifier_noise
from fingerdesign.checks.follow import lift_approach, lift_force
from fingerdesign.checks.remedies import edge
from fingerdesign.control.calibration import LEAST_GAGES
from fingerdesign.design.grip import MOST_MASS_G, weight_per_finger
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.rows import mirrors_in_z, plate_frames
from fingerdesign.layout.zone import approach_for, contact_reach
from fingerdesign.records.result import MOST_FORCE

# Strain of a plate over that of the rubber around it: 1 / (1 + c E_p t / (E_r L)), shear lag in a
# short fibre; with the change of all gages per unit of stick ratio over that strain per N times
# F_n, fitted to the gages of the shipped straight fingers, where it is off by a factor of 5.
_SHEAR_LAG = 2.0
_CHANGE = 0.4
_GAGES_OFF = 5.0  # Within this factor of the target the forecast is open.
_FINEST_MM = {"plane-strain": 1e-3, "3d": 1e-2}  # the least contact_size_mm of a mesh
_FACET = 0.87  # area to a node of a mesh of triangles, over the square of their size


@dataclass(frozen=True, kw_only=True)
class Lift:
    """The object of the grips held with a margin of 1.5 at one friction, to the end; forecasts.

    contact_nodes: by fidelity. smallest_stick_change: that gages show above noise; None without
    gages; measurable: it is clearly under the target, clearly over, or open (None).
    remedies: sentences, each with key, value, bound and remedy.
    """

    friction_coefficient: float
    object_mass_g: float
    normal_force_N: float
    tangential_force_N: float
    approach_mm: float
    contact_half_width_mm: float
    contact_nodes: dict[str, int]
    smallest_stick_change: float | None
    measurable: bool | None
    remedies: tuple[str, ...] = ()


def lifts(design: Design) -> list[Lift]:
    """The forecast of each mass at each friction; none of a finger that is not gripped with."""
    if len(gage_array(design)) < LEAST_GAGES:
        return []
    frictions = sorted(design.grip.friction_coefficients)
    found = [_lift(design, mu, mass) for mass in design.grip.masses_g for mu in frictions]
    return [replace(each, remedies=tuple(_remedies(design, each, found))) for each in found]


def _lift(design: Design, friction: float, mass_g: float) -> Lift:
    pulled_g = design.grip.pulled_g(mass_g)
    force = lift_force(design, friction, 1.0 / HELD_USED, pulled_g)
    approach = lift_approach(design, friction, 1.0 / HELD_USED, pulled_g)
    wide, area = _touched(design, approach)
    size = design.mesh.contact_size_mm
    nodes = {
        "plane-strain": round(2.0 * wide / design.mesh.section.contact_size_mm) + 1,
        "3d": round(_modelled(design, area) / (_FACET * size * size)),
    }
    change = _stick_change(design, force, wide, area)
    return Lift(
        friction_coefficient=friction,
        object_mass_g=mass_g,
        normal_force_N=force,
        tangential_force_N=weight_per_finger(pulled_g),
        approach_mm=approach,
        contact_half_width_mm=wide,
        contact_nodes=nodes,
        smallest_stick_change=change,
        measurable=_measurable(change),
    )


def _touched(design: Design, approach: float) -> tuple[float, float]:
    """Half-width, mm, and area, mm^2, of the contact at an approach."""
    body = design.body
    wide, deep = contact_reach(design, SceneObject(), approach)
    wide, deep = min(wide, 0.5 * body.width_mm), min(deep, 0.5 * body.depth_mm)
    straight = deep >= 0.5 * body.depth_mm
    return wide, (4.0 if straight else math.pi) * wide * deep


def _modelled(design: Design, area: float) -> float:
    """The part of a contact's area that a model in 3-D has."""
    return (0.5 if mirrors_in_z(design) else 1.0) * area


def _stick_change(design: Design, normal: float, wide: float, area: float) -> float | None:
    """Smallest change of the stick ratio that gages show: the rubber under the contact shears by
    F_t / (G area), less below half of the contact's width; a plate at an angle takes
    sin(2 angle) / 2 of that as far as it is not too stiff."""
    plates, frames = design.plates, plate_frames(design)
    if plates.model == "none":
        return None
    rubber, metal = design.material_of("body"), design.material_of("plates")
    shear = 2.0 * (1.0 + rubber.poissons_ratio) / (rubber.youngs_modulus_MPa * area)
    slope = max(abs(math.sin(math.radians(2.0 * each.angle_deg))) for each in frames)
    deep = 1.0 / (1.0 + (plates.cover_mm / wide) ** 2)
    stiff = metal.youngs_modulus_MPa * plates.thickness_mm
    stiff /= rubber.youngs_modulus_MPa * plates.length_mm
    response = 1e6 * 0.5 * slope * deep * shear / (1.0 + _SHEAR_LAG * stiff)
    if not response > 0.0:
        return None
    noise = amplifier_noise(design.rig.hardware, design.gage_factor)
    return SEEN * noise / (_CHANGE * response * normal)


def _measurable(change: float | None) -> bool | None:
    if change is None or 1.0 / _GAGES_OFF < change / WANTED_STICK_CHANGE < _GAGES_OFF:
        return None
    return change < WANTED_STICK_CHANGE


def _remedies(design: Design, lift: Lift, every: Sequence[Lift]) -> Iterator[str]:
    """Remedies of a lift, where it is the worst of all: what mends it mends the others."""
    pulled_g = design.grip.pulled_g(lift.object_mass_g)
    later = f", pulled later as by {pulled_g:.4g} g," if pulled_g > lift.object_mass_g else ""
    what = (
        f"a lift of {lift.object_mass_g:g} g{later} at a friction of {lift.friction_coefficient:g}"
    )
    if lift is max(every, key=lambda each: each.approach_mm):
        yield from _depths(design, lift, what, bool(later))
    yield from _first_moves(design, lift)
    if lift is min(every, key=lambda each: each.approach_mm):
        yield from _fine_enough(design, lift, what)
    worst = max(every, key=lambda each: each.smallest_stick_change or 0.0)
    if lift is worst and lift.measurable is False and lift.smallest_stick_change is not None:
        gain = lift.smallest_stick_change / WANTED_STICK_CHANGE
        noise = amplifier_noise(design.rig.hardware, design.gage_factor)
        yield (
            f"at a friction of {lift.friction_coefficient:g} gages on plates of "
            f"{design.plates.material} will hardly be measurable: about {gain:.2g} times too "
            f"little for {noise:.3g} microstrain of noise (a forecast, right within a factor of "
            f"{_GAGES_OFF:g}; analyse measures it); take softer or thinner plates, or a quieter "
            "amplifier"
        )


def _fine_enough(design: Design, lift: Lift, what: str) -> Iterator[str]:
    """Sizes of a mesh with enough contact nodes, or that there is none."""
    wide, area = _touched(design, lift.approach_mm)
    for fidelity, count in lift.contact_nodes.items():
        flat = fidelity == "plane-strain"
        least = ENOUGH_NODES[2 if flat else 3]
        if count >= least:
            continue
        size = 2.0 * wide / least if flat else math.sqrt(_modelled(design, area) / (_FACET * least))
        key = f"mesh.{'section.' if flat else ''}contact_size_mm"
        change = f"lower {key} to {_below(size):g}"
        if size < _FINEST_MM[fidelity]:
            change = "no mesh is fine enough for so small a contact"
        yield (
            f"{what} will have about {count} contact nodes in {fidelity}, {least} are enough: "
            f"{change}"
        )


def _below(value: float) -> float:
    """Two digits of a value, rounded down."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{digit * math.floor(value / digit * (1.0 + 1e-9)):.2g}")


def _first_moves(design: Design, lift: Lift) -> Iterator[str]:
    """Moves of ``[grip]`` that crush the object which the least force holds.

    The hand learns that it holds enough one move late: preload, one normal move and, by the paper's
    rule, hold_force_N come on top of the least force. On film_tees with 50 to 500 g and rubber of 5
    to 30 MPa this is within a ninth of the greatest ratio of the grips in plane strain.
    """
    grip = design.grip
    least = lift.tangential_force_N / lift.friction_coefficient
    gentlest = (grip.lightest_g, max(grip.friction_coefficients))
    if (lift.object_mass_g, lift.friction_coefficient) != gentlest:
        return
    moves = _force_at(design, grip.preload_mm + grip.approach_step_mm)
    moves += grip.hold_force_N if grip.controller == "paper" else 0.0
    over = moves / least
    if 1.0 + over >= MOST_FORCE:
        heavier = 1.1 * lift.object_mass_g * over / (MOST_FORCE - 1.0)
        suit = "no object bears them"
        if heavier <= MOST_MASS_G:
            suit = f"they suit {float(f'{heavier:.2g}'):g} g or more"
        yield (
            f"the moves of grip press with up to about {1.0 + over:.2g} times the least force that "
            f"holds {lift.object_mass_g:g} g at a friction of {lift.friction_coefficient:g}, and "
            f"{MOST_FORCE:g} times crush it (forecast): {suit}; fit "
            "preload_mm, approach_step_mm and hold_force_N with `fingerdesign study FILE --tune`"
        )


def _force_at(design: Design, approach: float) -> float:
    """The normal force, N, that is forecast to press ``approach`` mm: approach_for turned round."""

    def enough(force: float) -> bool:
        return not approach_for(design, SceneObject(), force) < approach

    high = 1.0
    while not enough(high) and high < 1e9:
        high *= 2.0
    return edge(enough, high, 0.0, 50)


def _depths(design: Design, lift: Lift, what: str, later: bool) -> Iterator[str]:
    """Remedies of a travel that the stage, or small strains, do not have."""
    takes = f"{what} takes about {lift.normal_force_N:.3g} N and {lift.approach_mm:.2g} mm"
    height = float(crest_height(design.body))
    if lift.approach_mm > SMALL_STRAIN * height:
        if lift.approach_mm > 0.499 * height:  # where the forecast ends
            takes = takes.replace(" N and ", " N and more than ")
        spare = _force_at(design, SMALL_STRAIN * height) / lift.normal_force_N
        name, stiff = design.body.material, design.material_of("body").youngs_modulus_MPa
        less = f"grip.object_mass_g to {_below(lift.object_mass_g * spare):g}"
        later_keys = [key for key in ("weight_changes", "tugs") if getattr(design.grip, key)]
        less = " and ".join(f"grip.{key}" for key in later_keys) if later else less
        yield (
            f"{takes}, {lift.approach_mm / height:.0%} of the finger's height, where small strains "
            f"end ({SMALL_STRAIN:.0%}): raise materials.{name}.youngs_modulus_MPa from {stiff:g} "
            f"to {1.0 / _below(spare / stiff):.3g}, or lower {less}"
        )
    elif lift.approach_mm > design.grip.max_approach_mm:
        follows = ", or set it to 'auto'" if design.grip.defaults == "follow" else ""
        yield (
            f"{takes}, more than grip.max_approach_mm = {design.grip.max_approach_mm:g}: raise it "
            f"to at least {1.5 * lift.approach_mm:.2g}{follows}"
        )
