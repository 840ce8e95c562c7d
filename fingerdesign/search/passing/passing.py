"""Search from one design for a finger that passes all verdicts.

    found = search_passing(design, Freedom(), journal, Callbacks(evaluated, confirm))

Trials judge the gages alone, on the swept model in 3-D: the hand does not change them. For a finger
whose gages do, a hand is searched; then the whole finger is analysed on its own mesh, by default of
tetrahedra, and judged as `analyse` judges it. The search ends with the first that passes. Where no
round body does, nor the user's own CAD, an arc of its size replaces it.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from fingerdesign.analysis.shortfall import GRIP_FORCE, LIFTS
from fingerdesign.checks.load import with_values
from fingerdesign.design.schema import Design
from fingerdesign.mesh.make import mesher_of
from fingerdesign.records.outcome import Outcome
from fingerdesign.records.result import Result
from fingerdesign.search.optimise.optimise import Evaluator, Search, Tried, searched
from fingerdesign.search.optimise.trials import Trials, refuse_other_file
from fingerdesign.search.passing.found import (
    SPARED,
    Candidate,
    Found,
    SearchStopped,
    castable,
    conflicts_of,
    order_of,
)
from fingerdesign.search.passing.freedom import Freedom
from fingerdesign.search.passing.hands import (
    MOST_TRIED,
    NO_HAND,
    hand_of,
    shortfall_of,
    with_travel,
)
from fingerdesign.search.passing.space import Space, space_of
from fingerdesign.search.run.cluster import Cluster
from fingerdesign.search.run.evaluate import Job, Part
from fingerdesign.search.run.run import FUNDAMENTAL, Planned, Store, run_jobs
from fingerdesign.search.study.file import Cost, Limits, Study
from fingerdesign.search.study.values import Choice, set_keys
from fingerdesign.sensing.model import meshed_for_grips

BATCH = 4  # Trials between two looks at the best.
SWEPT_TRIALS, TETRAHEDRA_TRIALS = 48, 16  # A trial on tetrahedra takes four times as long.
_MOST_GRIPPED = 8  # Fingers for which a hand is searched: each takes a minute or two.
_MOST_CONFIRMED = 4  # Whole analyses, a minute each.
_LIMIT_S = 900.0  # Of one trial.
# A search ends after so many round bodies whose gages fall short, or trials of which none is good,
# where a plainer finger is searched next.
_MOST_SHORT, _MOST_POOR = 4, 20
_BODIES = 2  # Round bodies analysed at once: each takes a minute or two on one core.
# Sizes that a trial changes for speed; a hand is searched again with the design's own.
_OWN_MESH = (
    "mesh.section.gradation",
    "mesh.contact_size_mm",
    "mesh.layers",
    "mesh.layer_growth",
    "mesh.mesher",
)

_SHARE = "gages.area_share"  # No parameter: the best is known from any analysis of the finger.

Confirm = Callable[[Design], Result]
Report = Callable[[str], None]


@dataclass(frozen=True)
class Callbacks:
    """Functions that a search calls; it raises what these raise."""

    evaluated: Evaluator  # Outcomes of jobs, in order.
    confirm: Confirm  # The whole analysis of a design.
    report: Report = lambda message: None
    improved: Callable[[Candidate], None] = lambda best: None  # Receives each new best finger.
    unready: Callable[[Design], str] = lambda design: ""  # What a finger lacks as cast.


def study_of(space: Space) -> Study:
    """The search as a study, whose only objective is the distance from passing."""
    name = space.base.design.name
    tables = {
        "study": {"name": name, "base": name, "count": 1, "fidelity": "3d"},
        "parameters": space.parameters,
        "objectives": [{"metric": "shortfall"}],
        "limits": {"time_s": _LIMIT_S},
    }
    return Study.model_validate(tables)


def evaluated_by(cluster: Cluster, retry: bool = False) -> Evaluator:
    """Outcomes of jobs from the user's store or a cluster. retry: again what failed for time."""
    store, limits = Store(), Limits(time_s=_LIMIT_S)
    return lambda plan: run_jobs(plan, store, cluster, limits, retry=retry)


def most_trials(space: Space) -> int:
    """Number of trials by default: fewer where a trial needs a tetrahedral mesh."""
    mesher = mesher_of(meshed_for_grips(space.on_arc(space.base), "3d"))
    return SWEPT_TRIALS if mesher.sections else TETRAHEDRA_TRIALS


def search_passing(
    design: Design, freedom: Freedom, journal: Path, calls: Callbacks, most: int | None = None
) -> Found:
    """Search from a design; see :func:`find_passing`. An interrupted search goes on from its
    journals.

    most: trials of one shape; None: as many as :func:`most_trials`. Raises DesignError where
    nothing can vary, SearchStopped where it is interrupted, and what the others raise.
    """

    def found(space: Space, file: Path, most: int | None, last: bool) -> Found:
        with Trials(study_of(space), space.base, file, space.starts, space.near) as trials:
            allowed = most_trials(space) if most is None else most
            return find_passing(space, freedom, trials, calls, allowed, last)

    space, further = space_of(design, freedom), journal.with_suffix(".plainer.sqlite")
    refuse_other_file(further)  # Now, not after the first shape's trials.
    first = found(space, journal, most, space.plainer(freedom) is None)
    outcomes = [each.outcomes[0] for each in first.tried]
    plainer = None if first.passes else space.plainer(freedom, sorted(outcomes, key=order_of))
    if plainer is None:
        return first
    calls.report(f"no finger passes with your {' and '.join(plainer.given_up)}")
    try:
        return found(plainer, further, most, True)
    except SearchStopped as stopped:
        raise stopped if stopped.found.tried else SearchStopped(first) from stopped


def find_passing(
    space: Space, freedom: Freedom, trials: Trials, calls: Callbacks, most: int, last: bool = True
) -> Found:
    """Search until a finger passes, or ``most`` trials are done.

    last: False where a plainer space is searched after this one, so that this one ends sooner.
    """
    return _Run(space, freedom, trials, calls, last).found(most)


@dataclass
class _Run:
    """A search while it runs."""

    space: Space
    freedom: Freedom
    trials: Trials
    calls: Callbacks
    last: bool
    tried: tuple[Tried, ...] = ()
    candidates: list[Candidate] = field(default_factory=list)
    judged: set[str] = field(default_factory=set)
    bodies: dict[str, Outcome] = field(default_factory=dict)  # Of an arc's digest: its round body.
    castable: dict[str, bool] = field(default_factory=dict)  # By the digest of a trial.
    best_sensed: float = math.inf
    nearest: Candidate | None = None  # By its trial alone.

    def found(self, most: int) -> Found:
        try:
            passed = self._passed(most)
            if self.last and not (passed or any(each.result for each in self.candidates)):
                self._judge_nearest()
            return self._as_cast(self._ended())
        except KeyboardInterrupt as stopped:
            raise SearchStopped(self._ended()) from stopped

    def _passed(self, most: int) -> bool:
        """Make trials until a finger passes: True; or until there are ``most``: False."""
        search = Search(study_of(self.space), self.space.base, {FUNDAMENTAL: None})
        for count in [*range(BATCH, most, BATCH), most]:
            begun = (count - 1) // BATCH * BATCH + 1
            self.calls.report(f"trials {begun} to {count} of at most {most}{self._best_words()}")
            self.tried = searched(search, self.trials, self._sensed, count, BATCH)
            promising = self._cast_first(self._promising(0.0))
            for k, outcome in enumerate(promising):
                self._look_at_bodies(promising[k : k + _BODIES])
                if self._candidate(outcome).passes:
                    return True
                if self._given_up():
                    return False
            if not (self.last or self.candidates) and count >= _MOST_POOR:
                return False
        return False

    def _judge_nearest(self) -> None:
        """Analyse the nearest finger as a whole: none has room to spare, it may pass without."""
        gripping = [each for each in self.candidates if math.isfinite(each.hand.shortfall)]
        sensing = [each for each in self.candidates if each.hand is NO_HAND]
        if gripping:
            nearest = min(gripping, key=lambda each: each.hand.order)
            self.candidates.remove(nearest)
            self.candidates.append(nearest)
            self._judge_whole(nearest)
        elif sensing:
            nearest = min(sensing, key=lambda each: shortfall_of(each.sensed))
            self.candidates.remove(nearest)
            self._gripped(nearest.design, nearest.sensed, whole=True)
        else:
            for outcome in self._promising(math.inf)[:1]:
                self._look_at_bodies([outcome])
                self._candidate(outcome, whole=True)

    def _given_up(self) -> bool:
        """True if further trials could not be judged any more."""
        confirmed = sum(each.result is not None for each in self.candidates)
        # A round body whose gages fall short takes half of the time of one that is given a hand.
        short = sum(each.hand is NO_HAND for each in self.candidates)
        if not self.last and short >= _MOST_SHORT:
            return True
        return confirmed >= _MOST_CONFIRMED or len(self.candidates) - 0.5 * short >= _MOST_GRIPPED

    def _best_words(self) -> str:
        if not math.isfinite(self.best_sensed):
            return ""
        if not self.candidates:
            return f", gages short by {self.best_sensed:.2g}"
        good = f", {len(self.candidates)} with good gages"
        on_arc = sum(each.hand is NO_HAND for each in self.candidates)
        return f"{good}, {on_arc} of them on the arc alone" if on_arc else good

    def _sensed(self, plan: Sequence[Planned]) -> Sequence[Outcome]:
        """Outcomes of the gages alone."""

        def sensing(job: Job) -> Job:
            return replace(job, part="sensing", design=self.space.on_arc(job.design))

        return self._with_best_share([sensing(j) if isinstance(j, Job) else j for j in plan])

    def _with_best_share(self, jobs: Sequence[Planned]) -> list[Outcome]:
        """Outcomes of jobs, each with the share of the response that suits it best."""
        outcomes = [*self.calls.evaluated(jobs)]
        if not self.freedom.allows(_SHARE):
            return outcomes
        again = {
            k: replace(
                job,
                design=with_values(job.design, {_SHARE: share}),
                values={**job.values, _SHARE: share},
            )
            for k, job in enumerate(jobs)
            if isinstance(job, Job)
            and shortfall_of(outcomes[k]) > 0.0
            and (share := outcomes[k].metrics.get("best_area_share"))
            and not math.isclose(share, job.design.gages.area_share)
        }
        for k, better in zip(again, self.calls.evaluated([*again.values()]), strict=True):
            if shortfall_of(better) < shortfall_of(outcomes[k]):
                outcomes[k] = better
        return outcomes

    def _promising(self, most: float) -> list[Outcome]:
        """Outcomes short by at most ``most`` for which no hand was searched, the best first."""
        outcomes = [each.outcomes[0] for each in self.tried]
        short = {
            o.digest: o for o in outcomes if shortfall_of(o) <= most and o.digest not in self.judged
        }
        best = min(map(shortfall_of, outcomes), default=math.inf)
        if best < self.best_sensed:
            self.best_sensed = best
            nearest = min(outcomes, key=shortfall_of)
            self.nearest = Candidate(self._design(nearest), nearest)
            self.calls.improved(self.nearest)
        return sorted(short.values(), key=order_of)

    def _cast_first(self, outcomes: Sequence[Outcome]) -> list[Outcome]:
        """Those first whose mold can be planned."""
        for each in outcomes:
            if each.digest not in self.castable:
                self.castable[each.digest] = castable(self._design(each))
        return sorted(outcomes, key=lambda each: not self.castable[each.digest])

    def _design(self, outcome: Outcome) -> Design:
        """The design of a trial, with the base's own name and mesh."""
        return with_values(self.space.base, set_keys(self.space.base, outcome.values))

    def _candidate(self, outcome: Outcome, whole: bool = False) -> Candidate:
        """Search a hand for a finger; analyse it as a whole where the hand is good enough.

        The last of ``candidates`` is the one that is returned. whole: analyse it in any case.
        """
        self.judged.add(outcome.digest)
        outcome = self.bodies.get(outcome.digest, outcome)
        design = self._design(outcome)
        if shortfall_of(outcome) > (SPARED if self.space.arc_first else 0.0) and not whole:
            found = Candidate(design, outcome)
            self.candidates.append(found)
            return found
        return self._gripped(design, outcome, whole)

    def _look_at_bodies(self, arcs: Sequence[Outcome]) -> None:
        """Analyse the gages of round bodies whose arcs were tried."""
        new = [each for each in arcs if each.digest not in self.bodies]
        if self.space.arc_first and arcs[0] in new:
            self.calls.report("the gages of the round body, on tetrahedra")
            jobs = [_job(self._design(arc), "sensing", values=arc.values) for arc in new]
            found = self._with_best_share(jobs)
            self.bodies |= {arc.digest: body for arc, body in zip(new, found, strict=True)}

    def _gripped(self, design: Design, outcome: Outcome, whole: bool) -> Candidate:
        """Search a hand; analyse the finger as a whole where the hand is good enough, or in any
        case."""
        design = with_travel(design, outcome, self.freedom.allows)
        found = self._with_hand(design, outcome, own_mesh=False)
        self.candidates.append(found)
        whole = whole or found.hand.shortfall <= SPARED
        return self._judge_whole(found) if whole else found

    def _judge_whole(self, found: Candidate) -> Candidate:
        """The last of the candidates with its whole analysis, and with another hand where only the
        hand fails."""
        found = self._confirmed(found)
        by_hand = all(name.startswith((LIFTS, GRIP_FORCE)) for name in found.failing)
        if found.failing and by_hand:
            # The gages hold on this mesh: only the hand was right for the other one alone.
            again = self._with_hand(found.design, found.sensed, own_mesh=True)
            found = self._confirmed(again)
        self.calls.improved(found)
        return found

    def _with_hand(self, design: Design, outcome: Outcome, own_mesh: bool) -> Candidate:
        words = "a hand on the finger's own mesh" if own_mesh else "a hand"

        def judged(designs: Sequence[Design]) -> Sequence[Outcome]:
            return self.calls.evaluated([_job(each, "hand", own_mesh) for each in designs])

        def shown(count: int) -> None:
            tried = f"{count} of at most {MOST_TRIED} tried"
            self.calls.report(f"{words} for a finger with good gages: {tried}")

        hand = hand_of(design, judged, shown, self.freedom.allows)
        return Candidate(with_values(design, {**hand.values}), outcome, hand)

    def _confirmed(self, found: Candidate) -> Candidate:
        self.calls.report("the whole finger, on its own mesh")
        found = replace(found, result=self.calls.confirm(found.design))
        self.candidates[-1] = found
        return found

    def _ended(self) -> Found:
        known = [each for each in self.candidates if each.result is not None] or self.candidates
        best = min(known, key=lambda c: (len(c.failing), c.hand.order), default=self.nearest)
        mold = best is None or castable(best.design)
        found = Found(self.space, self.tried, tuple(self.candidates), best, castable=mold)
        return found if found.passes else replace(found, conflict=" ".join(conflicts_of(found)))

    def _as_cast(self, found: Found) -> Found:
        """The result with what its finger lacks as cast, where it passes."""
        if found.best is None or not (found.passes and found.castable):
            return found
        self.calls.report("what the finger is as cast")
        return replace(found, unready=self.calls.unready(found.best.design))


def _job(
    design: Design, part: Part, own_mesh: bool = False, values: Mapping[str, Choice] | None = None
) -> Job:
    keys, name = _OWN_MESH if own_mesh else (), design.design.name
    values = dict(values or {})
    return Job(name, design, Cost(), values, fidelity="3d", study_keys=keys, part=part)
