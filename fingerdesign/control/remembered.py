"""A plant that remembers: the same moves give the same answers, and are solved once.

Grips that differ in their sensors' noise alone, by a hand that does not feel it, make the same
moves. A :class:`Memory` holds what a plant answered to every sequence of moves so far; the plant
itself is made, and brought up to date, when a move is new.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from fingerdesign.control.plant import Plant, PlantMaker, Truth
from fingerdesign.control.signals import Sample


@dataclass
class Memory:
    """What followed on a sequence of moves, and what follows on each next one."""

    sample: Sample | None = None
    truth: Truth | None = None
    after: dict[tuple[float, float], Memory] = field(default_factory=dict)


class RememberedPlant:
    """A :class:`Plant` in front of another one, of which all that share ``memory`` are equal.

    The plant made by ``make_plant`` must be a function of its moves alone: no noise of its own.
    """

    def __init__(self, make_plant: PlantMaker, memory: Memory) -> None:
        self._make_plant = make_plant
        self._plant: Plant | None = None
        self._here = memory
        self._moves: list[tuple[float, float]] = []
        self._made = 0  # moves that the plant itself has made

    def move(self, dx: float, dy: float) -> Sample:
        """As the plant; raises what it raises, anew each time."""
        following = self._here.after.get((dx, dy))
        self._moves.append((dx, dy))
        if following is None:
            sample, truth = self._solve()
            following = Memory(sample, truth)
            self._here.after[dx, dy] = following
        self._here = following
        assert following.sample is not None
        return following.sample

    def truth(self) -> Truth:
        """The state after the last move."""
        if self._here.truth is None:
            self._here.truth = self._make_plant().truth()
        return self._here.truth

    def _solve(self) -> tuple[Sample, Truth]:
        """Make the moves that the plant has not made yet; the answer to the last of them."""
        if self._plant is None:
            self._plant = self._make_plant()
        for dx, dy in self._moves[self._made :]:
            self._made += 1
            sample = self._plant.move(dx, dy)
        return sample, self._plant.truth()
