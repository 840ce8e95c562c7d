"""A plant that remembers: the same moves give the same answers, and are solved once.

Grips that differ in their sensors' noise alone, by a hand that does not respond to it, make the
same moves. A :class:`Memory` holds the answers of a plant to every sequence of moves so far; the
plant itself is made, and brought up to date, when a move is new.
"""

from dataclasses import dataclass, field
from typing import Self

from fingerdesign.control.plants.plant import Plant, PlantMaker, Truth
from fingerdesign.control.signals import Sample


@dataclass
class Memory:
    """The result of a sequence of moves, and of each next one.

    plant: one that has made just these moves, to go on from.
    """

    sample: Sample | None = None
    truth: Truth | None = None
    plant: Plant | None = None
    after: dict[tuple[float, float], Self] = field(default_factory=dict)


class RememberedPlant:
    """A :class:`Plant` in front of others, which are equal for all that share ``memory``.

    The plants made by ``make_plant`` must be functions of their moves alone: no noise of their own.
    """

    def __init__(self, make_plant: PlantMaker, memory: Memory) -> None:
        self._make_plant = make_plant
        self._path = [memory]
        self._moves: list[tuple[float, float]] = []

    def move(self, dx: float, dy: float) -> Sample:
        """Move like the plant; raises what it raises, each time."""
        here = self._path[-1]
        following = here.after.get((dx, dy))
        if following is None:
            plant = self._standing_here()
            following = Memory(plant.move(dx, dy), plant.truth(), plant)
            here.after[dx, dy], here.plant = following, None
        self._path.append(following)
        self._moves.append((dx, dy))
        assert following.sample is not None
        return following.sample

    def truth(self) -> Truth:
        """The state after the last move."""
        here = self._path[-1]
        if here.truth is None:
            here.truth = self._make_plant().truth()
        return here.truth

    def _standing_here(self) -> Plant:
        """A plant that has made all moves so far: one left here, else the last on the way."""
        last = len(self._moves)
        while last > 0 and self._path[last].plant is None:
            last -= 1
        plant = self._path[last].plant or self._make_plant()
        self._path[last].plant = None
        for move in self._moves[last:]:
            plant.move(*move)
        return plant
