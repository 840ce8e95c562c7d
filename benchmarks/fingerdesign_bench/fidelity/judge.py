"""The ladder judged: each pair's errors and costs, and those of each rung as one model for all."""

from dataclasses import dataclass

import numpy as np

from fingerdesign.analysis.fidelity.estimate import goal_errors, of_most
from fingerdesign.analysis.fidelity.ladder import Ladder, climb
from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.arrays import Array, BoolArray
from fingerdesign_bench.check import Check
from fingerdesign_bench.fidelity.pairs import Pair
from fingerdesign_bench.fidelity.run import Recorded, model_key, recorded
from fingerdesign_bench.files import Record

SHARE_TARGET, SAVING_TARGET = 0.95, 3.0
Solved = tuple[Record, Recorded]  # a rung as its record, and as the ladder takes it
_PRESCRIBED = ("normal_force", "tangential_force")  # where forces are given


@dataclass(frozen=True)
class PairResult:
    """One pair: what the ladder chose, its estimated error, and what the error is.

    true_errors: of each reading that the scene does not prescribe; section_error: of the finest
    plane strain, of 95 % of its readings, NaN where there is none.
    """

    pair: Pair
    ladder: Ladder
    true_errors: Array
    section_error: float

    @property
    def within(self) -> float:
        """The share of readings whose true error is under the tolerance."""
        return float((self.true_errors <= self.pair.tolerance).mean())

    @property
    def section_used(self) -> bool:
        """True where plane strain was chosen."""
        return self.ladder.chosen.model.dimension == "plane strain"


@dataclass(frozen=True)
class Fixed:
    """One rung for all pairs: its cost, and on how many pairs it meets the tolerance."""

    name: str
    seconds: float
    within: float
    meets: int
    solved: int


@dataclass
class FidelityBench:
    """The result of ``bench fidelity``."""

    outcomes: list[PairResult]
    fixed: list[Fixed]

    @property
    def within(self) -> float:
        """The share of all readings of all pairs under their tolerance."""
        every = [each.true_errors <= each.pair.tolerance for each in self.outcomes]
        return float(np.concatenate(every).mean())

    @property
    def seconds(self) -> float:
        """The ladder's seconds over all pairs, failed rungs and judges included."""
        return sum(each.ladder.seconds for each in self.outcomes)

    @property
    def cheapest(self) -> Fixed | None:
        """The cheapest single model that meets the tolerance on every pair; None if none does."""
        enough = [each for each in self.fixed if each.meets == len(self.outcomes)]
        return min(enough, key=lambda each: each.seconds, default=None)

    @property
    def rival(self) -> Fixed:
        """``cheapest``, or where no single model does, the one that does on most pairs."""
        return self.cheapest or max(self.fixed, key=lambda each: (each.meets, -each.seconds))

    @property
    def missed(self) -> int:
        """Pairs where plane strain would do by a margin of a half, and was not used."""
        return sum(
            each.section_error <= 0.5 * each.pair.tolerance and not each.section_used
            for each in self.outcomes
        )

    def checks(self) -> list[Check]:
        """List the numbers and their targets."""
        short = 1.0 - self.within
        return [
            Check("readings over the tolerance", 1.0 - SHARE_TARGET, short),
            Check("1 / saving over one model for all", 1.0 / SAVING_TARGET, self.seconds_share),
            Check("plane strain would do by half the tolerance, and was not used", 0, self.missed),
            Check("plane strain used where it does not do", 0, self.wrong),
        ]

    @property
    def seconds_share(self) -> float:
        """The ladder's seconds over those of the one model for all."""
        return self.seconds / self.rival.seconds

    @property
    def wrong(self) -> int:
        """Pairs where plane strain was chosen and fewer than SHARE_TARGET of the readings hold."""
        return sum(each.section_used and each.within < SHARE_TARGET for each in self.outcomes)


def judge(every: list[Pair], records: list[Record], truth: dict[int, Readings]) -> FidelityBench:
    """Climb each pair's ladder on its records; compare with the references and with fixed rungs."""
    solved: dict[int, list[Solved]] = {pair.number: [] for pair in every}
    for record in records:
        if record["pair"] in solved:
            solved[record["pair"]].append((record, recorded(every[record["pair"]], record)))
    outcomes = [_climbed(pair, solved[pair.number], truth) for pair in every]
    return FidelityBench(outcomes, fixed_models(every, solved, truth))


def _climbed(pair: Pair, solved: list[Solved], truth: dict[int, Readings]) -> PairResult:
    """One pair's ladder, and its errors."""
    by_key = {record["key"]: answer for record, answer in solved}
    space = [record for record, _ in solved if record["dimension"] == "3-D"]
    ladder = climb(
        pair.design,
        pair.scene,
        pair.tolerance,
        lambda design, scene, model: by_key[model_key(model)],
        most_dofs=np.inf,
        scales=[float(record["scale"]) for record in space if not record.get("beyond")],
    )
    flat = [answer for record, answer in solved if record["dimension"] != "3-D"]
    section = of_most(true_errors(pair, flat[-1].readings, truth)) if flat else float("nan")
    return PairResult(pair, ladder, true_errors(pair, ladder.chosen.readings, truth), section)


def fixed_models(
    every: list[Pair], solved: dict[int, list[Solved]], truth: dict[int, Readings]
) -> list[Fixed]:
    """Each rung as the one model for all pairs; where a pair's ladder ends before it, its last."""
    names = dict.fromkeys(
        (record["dimension"], record["scale"]) for rungs in solved.values() for record, _ in rungs
    )
    found = []
    for dimension, scale in names:
        seconds, holds = 0.0, list[BoolArray]()
        for pair in every:
            own = [
                answer
                for record, answer in solved[pair.number]
                if record["dimension"] == dimension and record["scale"] >= scale
            ]
            if own:
                seconds += own[-1].total
                holds.append(true_errors(pair, own[-1].readings, truth) <= pair.tolerance)
        within = float(np.concatenate(holds).mean())
        meets = sum(bool(each.mean() >= SHARE_TARGET) for each in holds)
        found.append(Fixed(f"{dimension}, x {scale:g}", seconds, within, meets, len(holds)))
    return found


def true_errors(pair: Pair, found: Readings, truth: dict[int, Readings]) -> Array:
    """Errors of all readings that the scene does not prescribe, in one row."""
    off = goal_errors(found, truth[pair.number])
    given = _PRESCRIBED if pair.control == "force" else ()
    return np.concatenate([each for name, each in off.items() if name not in given])
