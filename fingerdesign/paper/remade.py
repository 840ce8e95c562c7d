"""Every figure of the paper, remade for one design: the numbers, and what they say of its words.

    found = remake(load_design("designs/maeno2000.toml"))
    found.claims[0].verdict

Maeno, Hiromitsu and Kawai 2000. Figures 1, 4, 5, 9 and 11 of the paper are drawings of what was
built and planned; the others are made here, in plane strain as there.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fingerdesign.analysis.case import fundamental_scene
from fingerdesign.analysis.path import contact_history, increment_result
from fingerdesign.analysis.stages import one_thread, zone_of
from fingerdesign.checks.load import with_values
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion
from fingerdesign.control.slip_study import slip_studies
from fingerdesign.paper.case import FRICTIONS, PATHS, build_case, check_case
from fingerdesign.paper.claims import Remade, claims_of
from fingerdesign.paper.lifts import SAMPLES, SEEDS, lifts, rig_of, squeeze
from fingerdesign.paper.places import gage_verdicts, likeness, rubber_verdicts
from fingerdesign.paper.rectangles import rectangles
from fingerdesign.paper.relation import make_bench, relation

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.layout.zone import Zone
    from fingerdesign.paper.case import PaperCase

Report = Callable[[str, float], None]

SOFT_MATERIAL = "polyimide"  # of designs/sensitive.toml: gages that answer 50 times as much
_FACES = {"both": "both faces read", "upper": "upper face read", "lower": "lower face read"}
_WIDEN = 1.4  # a candidate zone that the contact has outgrown


@dataclass(frozen=True)
class Effort:
    """How much is run: friction coefficients of Fig. 8 (the scene's among them), samples a step and
    seeds of Fig. 12. The default is what the page is made with."""

    frictions: tuple[float, ...] = FRICTIONS
    samples: tuple[int, ...] = SAMPLES
    seeds: int = SEEDS


FULL = Effort()


def remake(
    design: Design, report: Report = lambda message, fraction: None, effort: Effort = FULL
) -> Remade:
    """Make all figures' numbers. Raises DesignError for a design without an array of gages or that
    has no section, another FingerDesignError where a stage fails."""
    start = time.perf_counter()
    scene = fundamental_scene()
    case = check_case(design, scene)
    zone = zone_of(case, scene)
    while True:
        try:
            with one_thread():
                found = _remade(case_in(design, scene, zone, report), zone, scene, report, effort)
            break
        except ZoneExhausted:
            if zone.fills(design):
                raise
            zone = zone.widened(_WIDEN, design)
            report(f"widening the contact zone to {zone}", 0.0)
    found = replace(found, seconds=time.perf_counter() - start)
    return replace(found, claims=claims_of(found))


def case_in(design: Design, scene: Scene, zone: Zone, report: Report) -> PaperCase:
    """The design and its twin, condensed."""
    report("condensing the finger, with plates and without", 0.02)
    return build_case(check_case(design, scene), scene, zone)


def _remade(case: PaperCase, zone: Zone, scene: Scene, report: Report, effort: Effort) -> Remade:
    report("Figs 6 and 7: the eight steps", 0.2)
    steps = list(follow(case.finger, [Motion(*row) for row in case.rows]))
    report("Fig. 3: rectangles near the surface", 0.25)
    turned = rectangles(case)
    report("plates against the rubber's shear strain", 0.28)
    alike = likeness(case)
    report("Fig. 8: gage area and stick area", 0.3)
    bench = make_bench(case)
    studies = slip_studies(case.finger, case.rows, case.face, effort.frictions)
    relations = tuple(relation(case, bench, path, effort.frictions) for path in PATHS)
    report("each gage and the surface near it", 0.4)
    places = (
        *gage_verdicts(case, bench.floor, effort.frictions),
        *rubber_verdicts(case, bench.floor, effort.frictions),
    )
    report("Figs 2 and 10: lifts", 0.5)
    grips = tuple(lifts(case))
    route = squeeze(case)
    report("Fig. 12: lifts on a rig", 0.6)
    material = case.design.plates.material
    name = f"{material.replace('_', ' ')}, {_FACES[case.face]}"
    rigs = [rig_of(case, name, effort.samples, effort.seeds)]
    if (material, case.face) != (SOFT_MATERIAL, "both"):
        report("Fig. 12: the same with plates of polyimide, both faces read", 0.8)
        soft = {"plates.material": SOFT_MATERIAL, "gages.face": "both"}
        other = with_values(case.design, soft)
        softer = case_in(other, scene, zone, lambda message, fraction: None)
        soft_name = f"{SOFT_MATERIAL}, {_FACES['both']}"
        rigs.append(rig_of(softer, soft_name, effort.samples, effort.seeds))
    return Remade(
        design=case.design,
        dofs=case.dofs,
        friction=case.friction,
        increments=tuple(increment_result(step, case.face) for step in steps),
        contact=contact_history(case.finger, steps),
        rectangles=turned,
        likeness=alike,
        studies=studies,
        relations=relations,
        places=places,
        lifts=grips,
        route=route,
        rigs=tuple(rigs),
        seconds=0.0,
    )
