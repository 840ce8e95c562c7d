"""Measurability of slip by a finger's gages, and remedies where they respond too little."""

import math
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

from fingerdesign.analysis.case import Case, gage_array
from fingerdesign.analysis.detection import (
    HELD_USED,
    WANTED_STICK_CHANGE,
    amplifier_noise,
    measured_states,
)
from fingerdesign.analysis.path import problem_at_touch
from fingerdesign.analysis.stages import condense, make_mesh
from fingerdesign.checks.load import with_values
from fingerdesign.checks.meshing import plane_strain_faults
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.design.grip import weight_per_finger
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import FingerDesignError, SolverError
from fingerdesign.layout.zone import candidate_zone
from fingerdesign.materials import MATERIALS
from fingerdesign.mesh.make import mesher_of
from fingerdesign.mesh.section.netgen import start_mesher
from fingerdesign.records.result import GageRemedy, Measurability, MeasuredState
from fingerdesign.runtime.threads import one_thread

Sections = Future[list[ContactProblem]]

_FIRST = 1.0 / 8.0  # of a key's value, the trial that the power law goes through
_LEAST_PLATE_MM = 0.02  # the thinnest foil that is sold and handled
_LEAST_STIFF = 20.0  # times the rubber's modulus: a softer plate is rubber itself
_SPARE = 1.1  # A proposal gains a little more than the target, since models differ.
# The section's element edges, times the design's: gains are ratios of two such models.
_COARSER = {"contact": 4.0, "plate": 4.0, "plate_end": 5.0, "far": 2.0}
_GRADATION = 0.6


def start_sections(case: Case) -> Sections | None:
    """Begin the models that remedies are found with, on the core that the case's mesher leaves
    idle. None where the case proposes none."""
    if case.fidelity in ("plane-strain", "auto") or mesher_of(case.design).sections:
        start_mesher()  # It loads while this process loads the rest.
    design = case.design
    seen = _sees(case) and case.path_scene.object.law.is_coulomb
    if not seen or case.scene is not None or not case.for_page or plane_strain_faults(design):
        return None
    pool = ThreadPoolExecutor(1)
    sections = pool.submit(_sections, design)
    pool.shutdown(wait=False)
    return sections


def _sees(case: Case) -> bool:
    return bool(case.gage_array) and case.design.plates.model != "none"


def states_seen(
    case: Case, scene: Scene, array: ContactProblem, steps: Sequence[Step]
) -> tuple[MeasuredState, ...]:
    """Changes of slip that the gages of the array measure.

    The load is that of the held object of the design's grips, or, with a scene of the user's, the
    greatest of its path. Empty without gages, where no load is reached at which they respond, and
    under another law than Coulomb's.
    """
    design = case.design
    if not (_sees(case) and array.law.is_coulomb):
        return ()
    if case.scene is None:
        loads = held_loads(design)
    else:
        most = max(step.measures.normal_force for step in steps)
        loads = [(scene.object.friction_coefficient, most)] if most > 0.0 else []
    noise = amplifier_noise(design.rig.hardware, design.gage_factor)
    return measured_states(array, design.gages.face, loads, noise)


def measurability(
    design: Design, states: tuple[MeasuredState, ...], sections: Sections | None
) -> Measurability | None:
    """The verdict on ``states``, with remedies from ``sections`` where they are not enough.

    None without states.
    """
    if not states:
        return None
    hardware = design.rig.hardware
    found = Measurability(
        noise_microstrain=amplifier_noise(hardware, design.gage_factor),
        noise_stated=hardware.gage_noise_microstrain > 0.0,
        wanted_stick_change=WANTED_STICK_CHANGE,
        states=states,
    )
    if sections is None or found.smallest_stick_change <= WANTED_STICK_CHANGE:
        return found
    try:
        return replace(found, remedies=_remedies(design, found, sections.result()))
    except FingerDesignError:  # none can be made, or does not bear the load: nothing is proposed
        return found


def held_loads(design: Design) -> list[tuple[float, float]]:
    """(friction, F_n in N) at which the objects of the grips are held with a margin of 1.5, at the
    least and the greatest of their frictions; of a range of masses its ends."""
    grip = design.grip
    frictions = sorted(set(grip.friction_coefficients))
    ends = dict.fromkeys((frictions[0], frictions[-1]))
    weights = [weight_per_finger(mass) for mass in grip.masses_g]
    return [(mu, weight / (HELD_USED * mu)) for weight in weights for mu in ends]


def _remedies(
    design: Design, found: Measurability, sections: Sequence[ContactProblem]
) -> tuple[GageRemedy, ...]:
    """Softer plates, thinner plates: by how much."""
    worst = max(found.states, key=lambda state: state.smallest_stick_change)
    load = (worst.friction_coefficient, worst.normal_force_N)
    target = found.smallest_stick_change / found.wanted_stick_change
    given = (design.gages.face, load, found.noise_microstrain)
    with one_thread():
        now, *answers = [_answer(section, *given) for section in sections]
    remedies = []
    for (key, value, least), answer in zip(_trials(design), answers, strict=True):
        trial = max(_FIRST * value, least)
        changed, gained = _search(value, trial, answer / now, least, _SPARE * target)
        enough = gained >= target
        known = _known(changed, _soft(design)) if key.startswith("materials") and enough else ()
        remedies.append(GageRemedy(key, value, changed, gained, enough, known))
    return tuple(remedies)


def _trials(design: Design) -> list[tuple[str, float, float]]:
    """Keys that may mend the gages, with their value and the least that they may have."""
    plates, modulus = design.plates, design.material_of("plates").youngs_modulus_MPa
    keys = (
        (f"materials.{plates.material}.youngs_modulus_MPa", modulus, _soft(design)),
        ("plates.thickness_mm", plates.thickness_mm, _LEAST_PLATE_MM),
    )
    return [each for each in keys if each[1] > each[2]]


def _soft(design: Design) -> float:
    return _LEAST_STIFF * design.material_of("body").youngs_modulus_MPa


def _search(
    value: float, trial: float, gained: float, least: float, target: float
) -> tuple[float, float]:
    """The value, and its gain, at which the gain is ``target``, or the least value: by a power law
    through the trial."""
    slope = math.log(gained) / math.log(value / trial)
    if slope <= 0.0:
        return trial, gained
    aim = float(f"{max(value * target ** (-1.0 / slope), least):.2g}")
    return aim, (value / aim) ** slope


def _sections(design: Design) -> list[ContactProblem]:
    """Coarse sections of a design, and of the same with the first trial of each remedy.

    Raises FingerDesignError where there is no section.
    """
    trials = [{key: max(_FIRST * value, least)} for key, value, least in _trials(design)]
    return [_section(with_values(design, trial)) for trial in ({}, *trials)]


def _section(design: Design) -> ContactProblem:
    scene, section = Case(design).path_scene, design.mesh.section
    factors = {f"{name}_size_mm": by for name, by in _COARSER.items()}
    sizes = {f"mesh.section.{key}": by * getattr(section, key) for key, by in factors.items()}
    gradation = max(_GRADATION, section.gradation)
    design = with_values(design, {**sizes, "mesh.section.gradation": gradation})
    # The section may press deeper than the finger does: the zone is that of its own stage.
    zone = candidate_zone(design, scene.object, design.grip.max_approach_mm)
    mesh = make_mesh(design, "plane-strain", zone)
    model = condense(design, mesh, zone, scene).reduced.with_gages(gage_array(design))
    return problem_at_touch(model, scene.object, design.body)


def _answer(section: ContactProblem, face: str, load: tuple[float, float], noise: float) -> float:
    """Microstrain per newton in the section where all sticks, at a load (friction, F_n in N): what
    is seen of slip goes about with it, and coarse meshes change it by 7 % at most (three fingers),
    where they change that by half. FingerDesignError where there is no answer."""
    states = measured_states(section, face, [load], noise)
    if not states:
        raise SolverError("the section does not reach the load")
    return states[0].response_microstrain_per_N


def _known(modulus: float, least: float) -> tuple[str, ...]:
    """Materials of the library no stiffer than ``modulus`` (MPa), and no softer than ``least``."""
    moduli = {name: each.youngs_modulus_MPa for name, each in MATERIALS.items()}
    return tuple(name for name, each in moduli.items() if least <= each <= modulus)
