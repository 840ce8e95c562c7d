"""Effect of the leads of a finger's gages on its readings, as it is wired when it is cast.

The finger is pressed and sheared in 3-D (placement's scene) without leads and with them, as bars
along its plates (fem/bars.py). Changes are shares of the largest reading of their row. Where they
are above MOST, other leads and courses are tried, and those that do are its "fixes".
"""

import math
import time
from typing import Any

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.fidelity.models import Solved, solve
from fingerdesign.analysis.fidelity.readings import errors
from fingerdesign.analysis.fidelity.rungs import rung
from fingerdesign.analysis.stages import zone_of
from fingerdesign.analysis.verdicts import two_digits
from fingerdesign.design.leads import Leads
from fingerdesign.design.schema import Design
from fingerdesign.design.stock import GageType
from fingerdesign.errors import FingerDesignError
from fingerdesign.layout.leads import lead_words, leads_as_cast, thin_bundle, traces_possible
from fingerdesign.mold.placement import scene_for

MOST = 0.05  # of the largest reading: as much as is left of a calibration from day to day
# Of element sizes: film_tees' changes are within a hundredth of those at 2.0; at 4.0, with two
# layers in half the depth instead of three, they are a third less. In tetrahedra of film_dome they
# are 1.6, 1.3, 1.7 % at 5.6, 4.0, 2.8, within 70 s, of which meshing takes 25.
SCALE = 2.8
_READS = 1e-6  # microstrain

Effect = dict[str, Any]


def leads_effect(design: Design, type_: GageType | None) -> Effect:
    """The leads' effect as plain values for the record; "reason": why there are no numbers.

    "reading_error": the greatest change of a reading, "force_error": of F_n or F_t; "fixes": lines
    for the design with the change that is left ("reading_error"), where it is above MOST.
    """
    start, leads = time.perf_counter(), leads_as_cast(design, type_)
    found: Effect = {"reason": None, "words": lead_words(design, leads), **_sizes(design, leads)}
    why = _untold(design, type_)
    if why is None:
        try:
            found |= _measured(design, leads, type_)
        except FingerDesignError as error:
            why = f"the finger could not be analysed: {' '.join(str(error).split())}"
    if why is not None:
        name = design.design.name
        sentence = f"What {found['words']} do to the readings is not known: {why}."
        hint = f"`fingerdesign validate {name} --only leads` computes it"
        return found | {"reason": why, "sentences": [f"{sentence} {hint}."]}
    return found | {"seconds": round(time.perf_counter() - start, 2)}


def _untold(design: Design, type_: GageType | None) -> str | None:
    if not design.plates.number:
        return "the finger has no plates"
    if type_ is None:
        return "no gage fits its plates"
    return "its plates are left out of the model" if design.plates.model == "none" else None


def _sizes(design: Design, leads: Leads) -> Effect:
    """Stiffness E A of a plate's leads, N, and over that of the thinnest plate along z."""
    count = design.gages.lead_count if leads.number is None else leads.number
    plates, whole = design.plates, count * leads.stiffness
    modulus = design.material_of("plates").youngs_modulus_MPa
    plate = modulus * plates.thickness_mm * plates.length_mm if plates.number else math.inf
    return {
        "kind": leads.kind,
        "course": leads.course,
        "number": count,
        "stiffness_N": whole,
        "over_plate": whole / plate,
    }


def _measured(design: Design, leads: Leads, type_: GageType | None) -> Effect:
    scene = scene_for(design)
    zone = zone_of(Case(design, scene, grips=False, fields=False), scene)
    model = rung(design, scene, "3-D", SCALE)

    def solved(own: Leads | None) -> Solved:
        gages = design.gages.model_copy(update={"leads": own})
        return solve(design.model_copy(update={"gages": gages}), scene, model, zone)

    bare = solved(None)
    most = np.abs(bare.readings.reading).max(axis=1)
    if not (most > _READS).all():
        return {"reason": "no gage reads anything", "sentences": []}

    def change(own: Leads) -> tuple[np.ndarray[Any, Any], float]:
        other = solved(own).readings
        apart = errors(other, bare.readings)
        forces = max(float(apart[name].max()) for name in ("normal_force", "tangential_force"))
        return np.abs(other.reading - bare.readings.reading) / most[:, None], forces

    share, forces = change(leads)
    worst = float(share.max())
    found: Effect = {
        "reading_error": worst,
        "rms": float(np.sqrt((share**2).mean())),
        "worst_plate": int(share.max(axis=0).argmax()),
        "force_error": forces,
        "fixes": [],
    }
    if worst > MOST:
        tried = ((lines, float(change(own)[0].max())) for lines, own in _others(design, type_))
        fixes = ({"lines": lines, "reading_error": left} for lines, left in tried if left <= MOST)
        found["fixes"] = list(fixes)
    times = f"{_sizes(design, leads)['over_plate']:.2g} times"
    reading, force = (f"{two_digits(100.0 * each)} %" for each in (worst, forces))
    sentence = (
        f"{lead_words(design, leads)} change a reading by up to {reading} of the largest, a force "
        f"by up to {force}; they are {times} as stiff as a plate."
    )
    return found | {"sentences": [sentence[:1].upper() + sentence[1:]]}


def _others(design: Design, type_: GageType | None) -> list[tuple[list[str], Leads]]:
    """Other leads that may do, each with its lines for the design: traces on the leg where the
    plate or its gage is film, thin wire, fewer of them."""
    if design.mold.leads == "leg":
        return []
    found: list[tuple[list[str], Leads]] = []
    bare = design.model_copy(update={"gages": design.gages.model_copy(update={"leads": None})})

    def with_mold(**values: object) -> Leads:
        mold = design.mold.model_copy(update=values)
        return leads_as_cast(bare.model_copy(update={"mold": mold}), type_)

    if traces_possible(design, type_):
        found.append((['mold.leads = "leg"'], with_mold(leads="leg")))
    thin = thin_bundle(design)
    if thin < design.mold.wire_mm:
        found.append(([f"mold.wire_mm = {thin:g}"], with_mold(wire_mm=thin)))
    return found
