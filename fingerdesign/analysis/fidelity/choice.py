"""From the ladder's choice to what an analysis goes on with: its case, model, zone and words."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fingerdesign.analysis.fidelity.ladder import Answer, Ladder, climb
from fingerdesign.analysis.fidelity.models import InTurn, Model, Solved
from fingerdesign.errors import SolverError
from fingerdesign.records.result import LadderSummary, TriedModel
from fingerdesign.runtime.progress import Report

if TYPE_CHECKING:
    from fingerdesign.analysis.case import Case, Clock
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.fem.model import FiniteElementModel
    from fingerdesign.layout.zone import Zone


@dataclass(frozen=True)
class Choice:
    """The case as it is modelled, condensed, with the zone that it needed and why it was chosen."""

    case: Case
    model: FiniteElementModel
    zone: Zone
    summary: LadderSummary
    reasons: tuple[str, ...]


def choose(case: Case, scene: Scene, zone: Zone, clock: Clock, report: Report) -> Choice:
    """Climb the ladder for a case of fidelity "auto"; all that it tries is on ``clock``.

    Raises FingerDesignError where a model fails.
    """

    in_turn = InTurn(zone)

    def solver(design: Design, path: Scene, model: Model) -> Answer:
        solved = in_turn(design, path, model)
        clock.add(solved.seconds)
        return solved

    ladder = climb(case.design, scene, case.tolerance, solver, report)
    chosen = ladder.chosen
    if not isinstance(chosen, Solved) or chosen.built is None:
        raise SolverError("the ladder's choice holds no model")
    fidelity = "plane-strain" if chosen.model.dimension == "plane strain" else "3d"
    return Choice(
        case=replace(case, design=chosen.design, fidelity=fidelity),
        model=chosen.built,
        zone=chosen.zone,
        summary=summary(ladder),
        reasons=(
            f"chosen by --fidelity auto among {len(ladder.tried)}: {ladder.tried[-1].why}",
            *_unjudged(scene),
        ),
    )


def _unjudged(scene: Scene) -> tuple[str, ...]:
    """What the scene reads and the ladder does not estimate."""
    if scene.path.mirrors_in_z:
        return ()
    return ("the force along z and the twist moment have no error estimate of their own",)


def summary(ladder: Ladder) -> LadderSummary:
    """What a result says of its ladder."""
    estimate = ladder.estimate
    return LadderSummary(
        tolerance=ladder.tolerance,
        reached=ladder.reached,
        chosen=ladder.chosen.model.name,
        error_estimates=dict(estimate.by_quantity) if estimate is not None else {},
        why_ended="" if ladder.reached else ladder.why_ended,
        models=tuple(
            TriedModel(
                name=each.name,
                dimension=2 if each.dimension == "plane strain" else 3,
                dofs=each.dofs,
                contact_nodes=each.contact_nodes,
                seconds=each.seconds,
                error_estimates=dict(each.estimate.by_quantity) if each.estimate else None,
                why=each.why,
            )
            for each in ladder.tried
        ),
    )
