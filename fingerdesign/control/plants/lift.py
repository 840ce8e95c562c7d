"""Two fingers lift an object off its support; then it hangs, is tugged, changes weight, drops.

Quasi-static, along x alone. W is the object's weight and what tugs at it, toward +x; the hand moves
toward -x, ``hand`` mm in all. While the object is supported, the fingers are sheared by all that,

    shear = hand,          F_t + F_t' <= W                     (the support carries the rest)

and where they would carry more than W, it hangs: they carry W and it rises by what is left,

    F_t + F_t' = W,        rise = hand - shear > 0

A hanging object that friction cannot carry falls back onto its support: complete slip. It can be
gripped again there. Tilting, the support's own friction and dynamics are left out; an arm that
accelerates by a pulls at the object as m a more does. Rubber that relaxes loses a share of all its
forces since the touch, evenly in the logarithm of time: at the same motions

    f(t) = R(t) f,   R = 1 - r log(1 + t / T) / log(1 + 60 s / T),   T = 0.1 s,

r of it in a minute. Moduli all fall alike, so contact and strains stay; what is pressed later meets
the softer finger too, where a full model of the rubber's memory would let it meet the fresh one.
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Self

import numpy as np

from fingerdesign.contact.force_control import NoEquilibrium
from fingerdesign.contact.gross_slip import coefficient_under
from fingerdesign.contact.memory import Rubber
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.contact.turning import MOST_TURN_DEG, turning
from fingerdesign.control.plants.fingers import DifferentPair, Kind, MirrorPair, PairState, Warming
from fingerdesign.control.plants.plant import Truth, observe, with_turning_ratio
from fingerdesign.control.plants.slide import Inertia, frequency, slide
from fingerdesign.control.signals import Sample, gage_readings
from fingerdesign.design.grip import (
    Grip,
    Tug,
    WeightChange,
    lifting_tugs,
    mass_at,
    pull_at,
    weight_per_finger,
)
from fingerdesign.shapes.friction import FrictionLaw

_RELAXES_s = 0.1  # T
_BEGUN = 1e-6  # mm: so far the last node has slid that begins to


class Disturbance(Tug):
    """A tug at the lifted object: ``extra_force_N`` toward +x (down), or up where negative.

    It acts from move ``step_after_lift`` after the one that lifted (1 is the next), for
    ``duration_steps`` moves. Raises ValueError on numbers that cannot be.
    """

    def __init__(self, step_after_lift: int, extra_force_N: float, duration_steps: int = 1) -> None:
        super().__init__(
            step_after_lift=step_after_lift,
            extra_force_N=extra_force_N,
            duration_steps=duration_steps,
        )


@dataclass(frozen=True)
class Relaxation:
    """share: r of the module, of all forces in a minute; rate: moves a second."""

    share: float
    rate: float

    def left(self, moves: int) -> float:
        """R after so many moves."""
        passed, minute = (math.log1p(t / _RELAXES_s) for t in (moves / self.rate, 60.0))
        return 1.0 - self.share * passed / minute


@dataclass(frozen=True)
class Timed:
    """Processes that take time in a lift, None where there is none.

    relaxation, rubber: of all forces alike, or of each as it came (contact/memory.py); of both
    their product. inertia: of the object. warming: of the fingers.
    """

    relaxation: Relaxation | None = None
    rubber: Rubber | None = None
    inertia: Inertia | None = None
    warming: Warming | None = None

    @classmethod
    def of(cls, grip: Grip) -> Self:
        """Read a design's ``[grip]`` table."""
        rate, share = grip.hardware.sample_rate_Hz, grip.relaxation_per_minute
        memory = grip.rubber_memory
        shares, times = zip(*memory, strict=True) if memory else ((), ())
        return cls(
            Relaxation(share, rate) if share > 0.0 else None,
            Rubber(shares, times, 1.0 / rate) if memory else None,
            Inertia(rate, grip.drop_mm) if grip.inertia else None,
            Warming(grip.warming_K, grip.warming_s, rate) if grip.warming_K else None,
        )


def off_centre(problem: ContactProblem, grip: Grip, mass_g: float) -> ContactProblem:
    """The problem with the object's centre of mass where ``[grip]`` says; unchanged in the middle.

    Raises ValueError for half a finger, or a section, where it is elsewhere.
    """
    centre = grip.off_centre_mm
    return turning(problem, centre, weight_per_finger(mass_g)) if centre else problem


@dataclass(frozen=True)
class _Found:
    """Result of a move. slid: the whole contact has slid with the object hanging; sliding: it
    still does."""

    held: PairState
    lifted: bool
    dropped: bool = False
    slid: bool = False
    sliding: bool = False


@dataclass(frozen=True)
class _Move:
    """closing, hand: mm in all; speed of the hand (mm/s); pull (N) at the object of mass_g; left:
    of the rubber's forces."""

    closing: float
    hand: float
    speed: float
    pull: float
    mass_g: float
    left: float

    @property
    def weight(self) -> float:
        """Pull at fingers that have not relaxed."""
        return self.pull / self.left

    def acceleration(self, friction: float) -> float:
        """mm/s^2 down, of an object that friction holds with so much, before relaxing."""
        return 1e6 * self.left * (self.weight - friction) / self.mass_g


def _refuse(problem: ContactProblem, mass_g: float, timed: Timed) -> None:
    """Raise ValueError for a mass that cannot be, and for what this plant does not know."""
    if not (isfinite(mass_g) and mass_g > 0.0):
        raise ValueError(f"a mass of {mass_g} g must be over 0")
    law = problem.law
    if (timed.rubber and not law.is_coulomb) or (
        timed.relaxation and (law.strength or law.cap < inf)
    ):
        raise ValueError(f"forces of rubber that relaxes do not scale at friction {law}")
    if problem.softness is not None and timed.inertia is not None:
        raise ValueError("an object that turns has no inertia here: leave one of them out")


class LiftPlant:
    """A finger with gages and an opposite one, an object between them on a support.

    dx is the hand's move away from the support, dy what each finger closes by, both mm; a step is
    one move. Forces and truth are those of the finger with gages. opposite: another finger's
    problem, without it a mirror image. The support is where the object is first touched.
    kinetic_share: of either finger's friction, what is left where it slides (contact/history.py).

    Of a problem whose object turns (contact/turning.py) the support is under the centre of mass.
    There, and under another law than Coulomb's, the truth's slip ratio is that at the least force
    which holds the object; with ``ratio_of_now`` that of the moment.

    Raises ValueError where a tug upward exceeds the weight: nothing would hold the object then; and
    for rubber that relaxes under a law whose bounds do not scale with forces.
    """

    def __init__(
        self,
        problem: ContactProblem,
        face: str,
        object_mass_g: float,
        opposite: ContactProblem | None = None,
        disturbances: Sequence[Tug | WeightChange] = (),
        timed: Timed = Timed(),
        kinetic_share: float = 1.0,
        ratio_of_now: bool = False,
    ) -> None:
        _refuse(problem, object_mass_g, timed)
        self._slip_ratio: float | None = None
        self._ratio_of_now = ratio_of_now
        changes = problem.softness is not None or not problem.law.is_coulomb
        if changes and not ratio_of_now:
            self._slip_ratio = coefficient_under(problem, weight_per_finger(object_mass_g))
        self._timed = timed
        self._face, kind = face, Kind(timed.rubber, kinetic_share, timed.warming)
        self._fingers: MirrorPair | DifferentPair = MirrorPair(problem, kind)
        if opposite is not None:
            self._fingers = DifferentPair(problem, opposite, kind)
        alone = problem.model.load_gage_strain  # of one kelvin
        self._warmed = np.zeros(1) if alone is None else gage_readings(alone, face)
        self._mass = object_mass_g
        self._tugs = [each for each in disturbances if isinstance(each, Tug)]
        self._changes = [each for each in disturbances if isinstance(each, WeightChange)]
        for number, _ in lifting_tugs(object_mass_g, self._tugs, self._changes):
            raise ValueError(
                f"a tug of {self._tugs[number].extra_force_N:g} N lifts the object out of the "
                "fingers; tug less, or use a heavier object"
            )
        self._moves = 0
        self._closing = self._hand = 0.0
        self._since_lift: int | None = None  # moves since the first lift
        self._lifted = False
        sliding = None if timed.inertia is None else False
        self._truth = Truth(slip_ratio=self._slip_ratio, lifted=False, sliding=sliding)
        self.held: PairState | None = None  # of both fingers after the last move
        self._weight = 0.0  # at the last move
        self._speed = 0.0  # of the object, upward, mm/s
        self._friction = 0.0  # on an object that slides, N before relaxing
        self._slide_way = self._slide_time = 0.0  # since this slide began; mm, s
        self._slid_before = 0.0  # in slides that are over, mm
        self._sample: Sample

    @classmethod
    def of(
        cls,
        grip: Grip,
        problem: ContactProblem,
        face: str,
        friction: float | FrictionLaw,
        object_mass_g: float,
        opposite: ContactProblem | None = None,
    ) -> Self:
        """Read a design's ``[grip]`` table, both fingers at one friction."""
        return cls(
            off_centre(problem.with_friction(friction), grip, object_mass_g),
            face,
            object_mass_g,
            None if opposite is None else opposite.with_friction(friction),
            [*grip.tugs, *grip.weight_changes],
            Timed.of(grip),
            grip.kinetic_share,
        )

    def move(self, dx: float, dy: float) -> Sample:
        """Raise the hand by ``dx``, close each finger by ``dy``; see :class:`Plant`."""
        if self._since_lift is not None:
            self._since_lift += 1
        self._moves += 1
        move = self._move_of(dx, dy)
        self._fingers.relax(move.left)
        if self._only_rises(move):
            self._hand, self._speed = move.hand, move.speed
            self._truth = replace(self._truth, rise=move.hand - self._truth.shear)
            return self._sample
        inertia = self._timed.inertia
        if inertia is not None and self._truth.sliding:
            found = self._slide_on(move, inertia)
        else:
            found = self._find(move)
        if abs(found.held.increment.state.motion.twist_deg) > MOST_TURN_DEG:
            found = replace(found, lifted=False, dropped=True)
        truth, sample = observe(self._fingers.problem, found.held.increment, self._face)
        self._fingers.accept(found.held)
        self._fingers.passed()
        self.held = found.held
        begins = found.lifted and not self._lifted
        self._closing, self._hand, self._lifted = move.closing, move.hand, found.lifted
        self._weight = move.weight
        if found.lifted and self._since_lift is None:
            self._since_lift = 0
        self._report(move, found, truth, sample)
        if inertia is not None:
            self._note_motion(move, inertia, found, begins)
        return self._sample

    def _only_rises(self, move: _Move) -> bool:
        """True if nothing changes but the height of a hanging object."""
        same = (move.closing, move.weight) == (self._closing, self._weight)
        moved = self._truth.sliding is not None and self._truth.complete_slip
        calm = same and not moved and self._fingers.settled
        return calm and self._lifted and move.hand > self._truth.shear

    def _move_of(self, dx: float, dy: float) -> _Move:
        """The move as the fingers make it; a hanging object adds its inertia."""
        relaxation, inertia = self._timed.relaxation, self._timed.inertia
        left = 1.0 if relaxation is None else relaxation.left(self._moves)
        after = self._since_lift or 0
        mass = mass_at(after, self._mass, self._changes)
        pull = pull_at(after, self._mass, self._tugs, self._changes)
        speed = 0.0
        if inertia is not None:
            speed = dx * inertia.rate
            if self._lifted and not self._truth.sliding:
                pull += 1e-6 * mass * (speed - self._speed) * inertia.rate
        return _Move(self._closing + dy, self._hand + dx, speed, pull, mass, left)

    def _report(self, move: _Move, found: _Found, truth: Truth, sample: Sample) -> None:
        """Set truth and sample after a move, from those of the increment alone."""
        share, warming = found.held.relaxation * move.left, self._timed.warming
        kelvin = 0.0 if warming is None else warming.after(self._moves)
        before, all_slid = self._truth, found.dropped or found.slid
        if self._ratio_of_now:
            truth = with_turning_ratio(truth, self._fingers.problem, found.held.increment)
        self._truth = replace(
            truth,
            normal_force=share * truth.normal_force,
            tangential_force=share * truth.tangential_force,
            stick_ratio=0.0 if all_slid else truth.stick_ratio,  # it all slid as it dropped
            complete_slip=truth.complete_slip or all_slid,
            slip_ratio=self._slip_ratio or truth.slip_ratio,
            lifted=found.lifted,
            rise=move.hand - truth.shear if found.lifted else 0.0,
            sliding=None if before.sliding is None else found.sliding,
            slid=before.slid,
            caught=before.caught,
            catch_time=before.catch_time,
            frequency=before.frequency,
        )
        self._sample = replace(
            sample,
            readings=found.held.relaxation * sample.readings + kelvin * self._warmed,
            normal_force=share * sample.normal_force,
            tangential_force=share * sample.tangential_force,
            lifted=found.lifted,
            torque=None if sample.torque is None else share * sample.torque,
        )

    def truth(self) -> Truth:
        """The state after the last move, for the judge."""
        return self._truth

    def _find(self, move: _Move) -> _Found:
        """State of an object that does not slide after a move."""
        closing, hand, weight = move.closing, move.hand, move.weight
        if self._lifted:
            try:
                hanging = self._fingers.hang(closing, weight)
            except NoEquilibrium:
                if (inertia := self._timed.inertia) is not None:
                    return self._slide_from(move, inertia)
            else:
                if hanging.shear < hand:
                    return _Found(hanging, lifted=True)
                # The hand has set it down.
                return _Found(self._fingers.stand(closing, hand), lifted=False)
        standing = self._fingers.stand(closing, hand)
        if standing.carried <= weight:
            return _Found(standing, lifted=False, dropped=self._lifted)
        return _Found(self._fingers.hang(closing, weight, hand), lifted=True)

    def _slide_from(self, move: _Move, inertia: Inertia) -> _Found:
        """A slide begins: what friction carried before this move's closing it carries first. The
        hand's jerk is no pull any more: the object keeps its speed."""
        fingers = self._fingers
        verge = fingers.slide(self._closing)
        at = max(self._truth.shear, verge.shear - verge.slid) + _BEGUN
        fingers.accept(fingers.stand(self._closing, at))  # now friction in motion holds
        self._friction = fingers.slide(self._closing).carried
        self._slide_way = self._slide_time = 0.0
        jerk = 1e-6 * move.mass_g * (move.speed - self._speed) * inertia.rate
        return self._slide_on(replace(move, pull=move.pull - jerk), inertia, at)

    def _slide_on(self, move: _Move, inertia: Inertia, begun: float | None = None) -> _Found:
        """A control step of an object that slides: caught in it, dropped, or sliding still.

        begun: the shear at which it begins to.
        """
        all_slides = self._fingers.slide(move.closing)
        at = self._truth.shear if begun is None else begun
        first, last = (move.acceleration(each) for each in (self._friction, all_slides.carried))
        slid = slide(move.speed - self._speed, first, last, 1.0 / inertia.rate)
        way = max(min(slid.way, move.hand - at), 0.0)  # the support ends it
        at += slid.way
        self._friction, self._speed = all_slides.carried, move.speed - slid.speed
        self._slide_way += way
        until = 1.0 / inertia.rate if slid.caught is None else slid.caught
        self._slide_time += until - slid.waited
        if at >= move.hand or self._slide_way > inertia.drop:
            landed = self._fingers.stand(move.closing, move.hand)
            return _Found(landed, lifted=False, dropped=True)
        held, sliding = self._fingers.stand(move.closing, at), True
        if slid.caught is not None:
            self._fingers.accept(held)
            with suppress(NoEquilibrium):  # held for a part of the step alone
                held, sliding = self._fingers.hang(move.closing, move.weight), False
        return _Found(held, lifted=True, slid=True, sliding=sliding)

    def _note_motion(self, move: _Move, inertia: Inertia, found: _Found, begins: bool) -> None:
        """The object's speed from here on, and the report of its slides."""
        if not found.sliding:
            self._speed = move.speed if found.lifted else 0.0
        truth = self._truth
        if begins:
            self._speed = truth.rise * inertia.rate
            swing = frequency(move.left * self._fingers.stiffness(), move.mass_g)
            self._truth = replace(truth, frequency=swing)
        if not (found.slid or found.dropped):
            return
        caught = found.lifted and not found.sliding
        times = [truth.catch_time, self._slide_time if caught else None]
        longest = max((time for time in times if time is not None), default=None)
        self._truth = replace(
            truth, slid=self._slid_before + self._slide_way, caught=caught, catch_time=longest
        )
        if not found.sliding:
            self._slid_before, self._slide_time = self._truth.slid, 0.0
