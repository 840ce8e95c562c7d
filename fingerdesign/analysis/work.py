"""One case while it is worked: what a stage hands to the next."""

from dataclasses import dataclass, field, replace

from fingerdesign.analysis.case import Case, Clock
from fingerdesign.analysis.enough import finer
from fingerdesign.analysis.fidelity.choice import Choice
from fingerdesign.analysis.stages import widened, zone_of
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.design.scene import Scene
from fingerdesign.layout.zone import Zone
from fingerdesign.records.arrays import GripTrace, SlipStudy
from fingerdesign.records.result import ErrorEstimate, GripResult, Measurability
from fingerdesign.runtime.progress import Report


@dataclass(frozen=True)
class Followed:
    """A model, its problem at first contact, and the steps of the scene's path on it.

    error: the path's share; None at finite strain, or where it could not be estimated.
    """

    chosen: Choice
    problem: ContactProblem
    steps: list[Step]
    error: ErrorEstimate | None = None

    @property
    def array(self) -> ContactProblem:
        """The problem with the gages of the array alone."""
        model = self.problem.model.with_gages(self.chosen.case.gage_array)
        return replace(self.problem, model=model)


@dataclass(frozen=True)
class Lifted:
    """Results on a followed model: slip studies, grips, what the gages can measure.

    mesh_error: the mesh's share in the errors of the path, or why it was not estimated.
    """

    studies: tuple[SlipStudy, ...]
    grips: list[tuple[GripResult, GripTrace]]
    measurable: Measurability | None
    mesh_error: ErrorEstimate | str


@dataclass
class Work:
    """A case, the zone of its contact candidates, and how often its contact was meshed.

    requested: as given; case: the same, or with a finer mesh. notes: of everything that was
    repeated, a sentence each.
    """

    requested: Case
    clock: Clock
    report: Report
    case: Case = field(init=False)
    zone: Zone = field(init=False)
    notes: list[str] = field(default_factory=list)
    attempt: int = 1

    def __post_init__(self) -> None:
        self.case = self.requested
        self.zone = zone_of(self.requested, self.scene)

    @property
    def scene(self) -> Scene:
        """The scene whose path is followed."""
        return self.requested.path_scene

    def note(self, message: str) -> None:
        """Report a message, and store it for the record."""
        self.notes.append(message)
        self.report(message)

    def widen(self, exhausted: ZoneExhausted) -> None:
        """Take a wider zone; raises ``exhausted`` where it fills the finger already."""
        self.zone = widened(self.case.design, self.zone, exhausted)
        self.note(f"candidate zone widened to {self.zone}: {exhausted}")

    def refine_if_needed(self, followed: Followed) -> bool:
        """Take a case with a finer mesh where the contact held too few nodes; True if so.

        Raises SolverError where no mesh that is fine enough can be made.
        """
        found = finer(followed.chosen, self.scene, followed.problem, followed.steps, self.attempt)
        if found is None:
            return False
        self.case, self.zone = found
        self.attempt += 1
        self.note(f"the contact held too few nodes: it is meshed finer over {self.zone}")
        return True
