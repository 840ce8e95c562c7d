"""The ladder's choice, with what an analysis goes on with: its case, model, zone and notes."""

from dataclasses import dataclass, replace

from fingerdesign.analysis.case import Case, Clock
from fingerdesign.analysis.fidelity.ladder import Answer, climb
from fingerdesign.analysis.fidelity.models import InTurn, Model, Solved
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import SolverError
from fingerdesign.fem.model import FiniteElementModel
from fingerdesign.layout.zone import Zone
from fingerdesign.records.result import LadderSummary
from fingerdesign.runtime.progress import Report


@dataclass(frozen=True)
class Choice:
    """The case as it is modelled, condensed, with the zone that it needed and why it was chosen.

    summary: of the ladder that chose it; None where none did.
    """

    case: Case
    model: FiniteElementModel
    zone: Zone
    notes: list[str]
    summary: LadderSummary | None = None

    def after(self, notes: list[str]) -> "Choice":
        """The same, after other notes."""
        return replace(self, notes=[*notes, *self.notes])

    def at_finite_strain(self, note: str) -> "Choice":
        """The same model, for a path at finite strain; the note says why."""
        finite = replace(self.case, fidelity="finite")
        return replace(self, case=finite, notes=[*self.notes, note])


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
    errors = {} if ladder.estimate is None else dict(ladder.estimate.by_quantity)
    reached, why = ladder.reached, "" if ladder.reached else ladder.why_ended
    name, tried = chosen.model.name, tuple(ladder.tried)
    summary = LadderSummary(ladder.tolerance, reached, name, errors, why, tried)
    notes = [f"chosen by --fidelity auto among {len(ladder.tried)}: {ladder.tried[-1].why}"]
    if not scene.path.mirrors_in_z:
        notes.append("the force along z and the twist moment have no error estimate of their own")
    own = replace(case, design=chosen.design, fidelity=fidelity)
    return Choice(own, chosen.built, chosen.zone, notes, summary)
