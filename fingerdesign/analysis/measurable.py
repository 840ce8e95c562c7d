"""Whether a finger's gages answer enough for their amplifier, and what would make them."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from fingerdesign.analysis.case import Case, gage_array
from fingerdesign.analysis.path import problem_at_touch
from fingerdesign.analysis.stages import condense, make_mesh, one_thread
from fingerdesign.checks.design import plane_strain_faults
from fingerdesign.checks.load import with_values
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.measurable import (
    HELD_USED,
    WANTED_STICK_CHANGE,
    amplifier_noise,
    measured_states,
)
from fingerdesign.design.grip import weight_per_finger
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import FingerDesignError, SolverError
from fingerdesign.layout.zone import candidate_zone
from fingerdesign.materials import MATERIALS
from fingerdesign.records.result import GageRemedy, Measurability, MeasuredState

_FIRST = 1.0 / 8.0  # of a key's value, the trial that the power law goes through
_LEAST_PLATE_MM = 0.02  # the thinnest foil that is sold and handled
_LEAST_STIFF = 20.0  # times the rubber's modulus: a softer plate is rubber itself
_SPARE = 1.1  # what is proposed reaches a little more than is wanted
# The section's element edges, times the design's: gains are ratios of two such models.
_COARSER = {
    "contact_size_mm": 4.0,
    "plate_size_mm": 4.0,
    "plate_end_size_mm": 8.0,
    "far_size_mm": 2.0,
}
_GRADATION = 0.6


def measurability(
    case: Case, scene: Scene, array: ContactProblem, steps: Sequence[Step]
) -> Measurability | None:
    """What the gages of the array see of slip: while the object of the design's grips is held, or,
    with a scene of the user's, under the most that the path presses with.

    Remedies, each with a model of its own, are worked where too little is seen and the case is
    studied. None without gages, or where no load is reached at which they answer.
    """
    design = case.design
    if not case.gage_array or design.plates.model == "none":
        return None
    if case.scene is None:
        loads = held_loads(design)
    else:
        most = max(step.measures.normal_force for step in steps)
        loads = [(scene.object.friction_coefficient, most)] if most > 0.0 else []
    hardware = design.rig.hardware
    noise = amplifier_noise(hardware)
    with one_thread():
        states = measured_states(array, design.gages.face, loads, noise)
    if not states:
        return None
    found = Measurability(
        noise_microstrain=noise,
        noise_stated=hardware.gage_noise_microstrain > 0.0,
        wanted_stick_change=WANTED_STICK_CHANGE,
        states=states,
    )
    seen = found.smallest_stick_change <= WANTED_STICK_CHANGE
    if case.scene is not None or not case.studied or seen or plane_strain_faults(design):
        return found
    try:
        remedies = _remedies(design, found)
    except FingerDesignError:  # none can be made, or does not bear the load: nothing is proposed
        return found
    return replace(found, remedies=remedies)


def held_loads(design: Design) -> list[tuple[float, float]]:
    """(friction, F_n in N) at which the object of the grips is held with a margin of 1.5, at the
    least and the greatest of their frictions."""
    grip = design.grip
    frictions = sorted(set(grip.friction_coefficients))
    weight = weight_per_finger(grip.object_mass_g)
    ends = dict.fromkeys((frictions[0], frictions[-1]))
    return [(friction, weight / (HELD_USED * friction)) for friction in ends]


def _remedies(design: Design, found: Measurability) -> tuple[GageRemedy, ...]:
    """Softer plates, thinner plates: by how much, by models of the section."""
    worst = max(found.states, key=lambda state: state.smallest_stick_change)
    now = _answer(design, worst, found.noise_microstrain)
    wanted = found.smallest_stick_change / found.wanted_stick_change
    modulus = design.material_of("plates").youngs_modulus_MPa
    soft = _LEAST_STIFF * design.material_of("body").youngs_modulus_MPa
    keys = (
        (f"materials.{design.plates.material}.youngs_modulus_MPa", modulus, soft),
        ("plates.thickness_mm", design.plates.thickness_mm, _LEAST_PLATE_MM),
    )
    remedies = []
    for key, value, least in keys:
        if value <= least:
            continue

        def gain(changed: float, key: str = key) -> float:
            other = with_values(design, {key: changed})
            return _answer(other, worst, found.noise_microstrain) / now

        changed, gained = _search(gain, value, least, _SPARE * wanted)
        known = _known(changed, soft) if key.startswith("materials") and gained >= wanted else ()
        remedies.append(GageRemedy(key, value, changed, gained, gained >= wanted, known))
    return tuple(remedies)


def _search(
    gain: Callable[[float], float], value: float, least: float, wanted: float
) -> tuple[float, float]:
    """The value, and its gain, at which the gain is ``wanted``, or the least value: by a power law
    through one trial."""
    trial = max(_FIRST * value, least)
    gained = gain(trial)
    slope = math.log(gained) / math.log(value / trial)
    if slope <= 0.0:
        return trial, gained
    aim = float(f"{max(value * wanted ** (-1.0 / slope), least):.2g}")
    return aim, (value / aim) ** slope


def _answer(design: Design, worst: MeasuredState, noise: float) -> float:
    """Microstrain per newton in the section where all sticks, at the state's load: what is seen of
    slip goes about with it, and coarse meshes change it by 7 % at most (three fingers), where they
    change that by half. FingerDesignError where there is no section or no answer."""
    scene, section = Case(design).path_scene, design.mesh.section
    sizes = {f"mesh.section.{key}": by * getattr(section, key) for key, by in _COARSER.items()}
    gradation = max(_GRADATION, section.gradation)
    design = with_values(design, {**sizes, "mesh.section.gradation": gradation})
    # The section may press deeper than the finger does: the zone is that of its own stage.
    zone = candidate_zone(design, scene.object, design.grip.max_approach_mm)
    mesh = make_mesh(design, "plane-strain", zone)
    model = condense(design, mesh, zone, scene).reduced.with_gages(gage_array(design))
    problem = problem_at_touch(model, scene.object, design.body)
    load = (worst.friction_coefficient, worst.normal_force_N)
    with one_thread():
        states = measured_states(problem, design.gages.face, [load], noise)
    if not states:
        raise SolverError("the section does not reach the load")
    return states[0].response_microstrain_per_N


def _known(modulus: float, least: float) -> tuple[str, ...]:
    """Materials of the library no stiffer than ``modulus`` (MPa), and no softer than ``least``."""
    return tuple(
        name for name, each in MATERIALS.items() if least <= each.youngs_modulus_MPa <= modulus
    )
