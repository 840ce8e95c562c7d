"""Lifts of one finger with many hands: its model, path and calibrations are made once a process.

    analysis = lifted(case)

A search tries dozens of hands for a finger. They differ in the steps of the stage and in the values
of the paper's rule (``_OF_HANDS``). These change neither the mesh nor the path, and the steps alone
change the calibration. So the last finger of a process is stored with both.
"""

from dataclasses import dataclass, replace
from typing import Self

from fingerdesign.analysis.analysis import Analysis, analysis_of
from fingerdesign.analysis.case import Case, Clock, result_digest
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.stages import rig_of, run_grips
from fingerdesign.analysis.work import Followed, Lifted, Work
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.control.plants.rig import Rig
from fingerdesign.pipeline import follow, make_model
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing.train.ready import with_estimator
from fingerdesign.trials.tuning import ranges_of

RULE = "paper"  # The controller whose values a search of hands tunes.
STEPS = ("grip.approach_step_mm", "grip.shear_step_mm")
_OF_HANDS = tuple(
    key.removeprefix("grip.") for key in (*STEPS, *(each.key for each in ranges_of(RULE)))
)
_NO_ERROR = "only the hand was judged"


@dataclass(frozen=True)
class _Finger:
    """A finger that was followed to its end, the work that this took, and its rig."""

    work: Work
    followed: Followed
    rig: Rig

    @classmethod
    def of(cls, work: Work, followed: Followed) -> Self:
        chosen = followed.chosen
        return cls(work, followed, rig_of(chosen.case, chosen.zone, work.scene, followed.array))

    def with_hand(self, work: Work) -> Self:
        """The same for work on the same finger with another hand."""
        chosen = self.followed.chosen
        own = work.case
        design = chosen.case.design.model_copy(update={"grip": own.design.grip})
        case = replace(chosen.case, design=design, estimator=own.estimator)
        chosen = replace(chosen, case=case)
        work.case, work.zone = chosen.case, self.work.zone
        rig = self.rig.with_grip(design.rig)
        return type(self)(work, replace(self.followed, chosen=chosen), rig)


def _unheard(message: str) -> None:
    """Report nothing: a job of a study has no terminal."""


_last: dict[str, _Finger] = {}


def lifted(case: Case) -> Analysis:
    """The analysis of a case with its path and its grips, without errors and measurability.

    Path and grips are those of ``pipeline.run``. Raises as it does.
    """
    refuse(case, case.path_scene)
    work, key = Work(with_estimator(case, _unheard), Clock(), _unheard), _key(case)
    known = _last.get(key)
    finger = known.with_hand(work) if known is not None else None
    _last.clear()
    while True:
        try:
            if finger is None:
                followed = follow(work, make_model(work))
                if work.refine_if_needed(followed):
                    continue
                finger = _Finger.of(work, followed)
            with work.clock.stage("grips"), one_thread():
                grips = run_grips(finger.followed.chosen.case, finger.rig)
            break
        except ZoneExhausted as exhausted:
            work.widen(exhausted)
            finger = None
    _last[key] = finger
    return analysis_of(work, finger.followed, Lifted((), grips, None, _NO_ERROR))


def _key(case: Case) -> str:
    """SHA-256 of all that model, path and zone depend on."""
    design = case.design
    neutral = design.grip.model_copy(update=dict.fromkeys(_OF_HANDS, 0.0))
    plain = design.model_copy(update={"grip": neutral})
    return result_digest(plain, case.path_scene, case.requested)
