"""The hand of a finger: how far it presses, and the values of the paper's rule that lift gently.

The rule is tried on the frictions of the verdict and between them, so that it does not fit only
those. The better ones are tried with shorter and longer steps too: whether the rule fires can turn
on one sample, so a hand that passes with one step length may squeeze with the next. The first hands
are the design's own and those of shipped fingers that pass, with forces in proportion to the
weight; the others are near the one whose worst step length is best. The search ends with the first
that passes with all of them.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from operator import attrgetter

import numpy as np

from fingerdesign.checks.follow import MOST_TRAVEL
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.control.roster import Range
from fingerdesign.design.grip import weight_per_finger
from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.passing.ranges import PASSING
from fingerdesign.search.run.hand import RULE, STEPS
from fingerdesign.trials.tuning import ranges_of

MOST_HANDS, BATCH = 40, 4  # Hands tried for a finger, and how many at once.
MOST_TRIED = MOST_HANDS + BATCH - 1  # They come in batches.
# A hand near another: standard deviations of the logarithm, one drawn for each hand, and the share
# of values that change. For film_tees such a search found in 10 hands what 20 of a box did not.
_NEAR = (0.05, 0.15, 0.4)
_CHANGED = 0.6
# A finger whose best hand is short by so much after half of the hands gets no more of them: a lift
# fails, or a force is 1.4 times its limit. Searches that ended well were below 0.3 by then.
_HOPELESS = 0.5
_PRESS = 2.0  # The travel presses with this times the least force at the lowest friction.
_STEPS = 75  # Control steps from the first contact to the end of the travel.
_SHEAR = 7.5  # A tangential step over a normal one.
_FORCES = ("grip.force_floor_N", "grip.hold_force_N")
# Another mesh, or another stiffness, moves samples by as much. The widest pair comes first: it
# fails most often.
WIDEST_STEPS = 1.05
STEP_FACTORS = ((0.95, WIDEST_STEPS), (0.975, 1.025))
_NO_FORCE = 1e-9  # N: rounding noise of a contact without load.

Values = dict[str, float]
# Outcomes of hands: the design with each of some values of [grip].
Judge = Callable[[Sequence[Design]], Sequence[Outcome]]
Allows = Callable[[str], bool]


@dataclass(frozen=True)
class Hand:
    """Values of [grip] that were tried, and the shortfall of lifts and forces (inf: no answer).

    stepped: the shortfall with steps of other lengths, the largest; inf: not tried.
    """

    values: Values
    shortfall: float
    stepped: float = math.inf

    @property
    def worst(self) -> float:
        """The shortfall with any length of steps."""
        return max(self.shortfall, self.stepped)

    @property
    def steady(self) -> bool:
        """True if it lacks nothing with steps of other lengths either."""
        return self.worst == 0.0

    @property
    def order(self) -> tuple[float, float]:
        """Less is better."""
        return self.shortfall, self.stepped


NO_HAND = Hand({}, math.inf)


def shortfall_of(outcome: Outcome) -> float:
    """The outcome's distance from passing; inf where it has none."""
    found = outcome.metrics.get("shortfall")
    return math.inf if found is None else found


def with_travel(design: Design, sensed: Outcome, allows: Allows = bool) -> Design:
    """The design with a stage travel that its measured stiffness asks for, and steps to match.

    allows: tells whether a key may change.
    """
    grip = design.grip
    weight = weight_per_finger(grip.pulled_g(grip.heaviest_g))
    force = _PRESS * weight / min(grip.friction_coefficients)
    if (deep := _approach(sensed, force)) is None:
        return design
    most = min(MOST_TRAVEL * float(crest_height(design.body)), design.body.base_height_mm)
    travel = _rounded(min(deep, most))
    step = travel / _STEPS
    values = {
        "grip.controller": RULE,
        "grip.max_approach_mm": travel,
        "grip.preload_mm": _rounded(_SHEAR * step),
        "grip.approach_step_mm": _rounded(step),
        "grip.shear_step_mm": _rounded(_SHEAR * step),
    }
    return with_values(design, {key: value for key, value in values.items() if allows(key)})


def _approach(sensed: Outcome, force: float) -> float | None:
    """Approach, mm, that presses with ``force``: F_n ~ approach^n through two loaded increments."""
    trace = sensed.traces
    rows = zip(trace.approach_mm, trace.normal_force_N, strict=True)
    pressing = {deep: load for deep, load in rows if deep and load and load > _NO_FORCE}
    if len(pressing) < 2:
        return None
    (less, low), *_, (more, high) = sorted(pressing.items())
    power = math.log(high / low) / math.log(more / less) if high > low else 0.0
    return float(more * (force / high) ** (1.0 / power)) if power > 0.0 else None


def hand_of(
    design: Design, judge: Judge, report: Callable[[int], None], allows: Allows = bool
) -> Hand:
    """The best hand found; the search ends with the first that lacks nothing, with its own steps
    and with others. Only the design's own is tried where none of its keys may change.

    judge: outcomes of designs that differ in [grip] alone, at :func:`between` frictions. report:
    receives how many hands were tried. allows: tells whether a key may change.
    """
    tuned = design.grip.controller == RULE
    ranges = [each for each in _ranges(design) if tuned and allows(each.key)]
    chance = np.random.default_rng(0)
    tried: list[Hand] = []
    new = _starts(design, ranges) if ranges else [{}]
    while new:
        shortfalls = _judged(design, new, judge)
        hands = [Hand(v, found) for v, found in zip(new, shortfalls, strict=True)]
        for hand in sorted(hands, key=lambda each: each.shortfall):
            least = min((each.worst for each in tried), default=math.inf)
            if hand.shortfall < least:
                hand = replace(hand, stepped=_stepped_shortfall(design, hand, judge, least))
            tried.append(hand)
        report(len(tried))
        # Of hands of which none has an answer with all steps, the best with its own.
        best = min(tried, key=lambda each: (each.worst, each.shortfall))
        hopeless = best.shortfall > _HOPELESS and len(tried) >= MOST_HANDS // 2
        if best.steady or hopeless or not ranges or len(tried) >= MOST_HANDS:
            break
        new = [_near(best.values, ranges, chance) for _ in range(BATCH)]
    return min(tried, key=lambda each: each.order)


def _near(values: Values, ranges: Sequence[Range], chance: np.random.Generator) -> Values:
    """Values near to others, in their ranges."""
    spread = float(chance.choice(_NEAR))
    factors = np.exp(spread * chance.normal(size=len(ranges)))
    changed = chance.random(len(ranges)) < _CHANGED
    return _short(
        {
            own.key: min(max(values[own.key] * (by if moves else 1.0), own.low), own.high)
            for own, by, moves in zip(ranges, factors.tolist(), changed.tolist(), strict=True)
        }
    )


def _judged(design: Design, hands: Sequence[Values], judge: Judge) -> list[float]:
    """Shortfall of each hand, inf where its lifts have no answer."""
    designs = [with_values(between(design), {**values}) for values in hands]
    return [shortfall_of(outcome) for outcome in judge(designs)]


def _stepped_shortfall(design: Design, hand: Hand, judge: Judge, enough: float) -> float:
    """The largest shortfall of a hand with shorter and longer steps; where those of the first pair
    are short by ``enough``, no other is tried."""
    worst = 0.0
    for factors in STEP_FACTORS:
        hands = [
            {**hand.values, **{key: by * float(attrgetter(key)(design)) for key in STEPS}}
            for by in factors
        ]
        worst = max(worst, *_judged(design, hands, judge))
        if worst >= enough:
            break
    return worst


def between(design: Design) -> Design:
    """The design lifted also at frictions between its own: a hand must not fit those alone."""
    own = sorted(set(design.grip.friction_coefficients))
    middle = [_rounded(math.sqrt(low * high)) for low, high in pairwise(own)]
    return with_values(design, {"grip.friction_coefficients": sorted({*own, *middle})})


def _ranges(design: Design) -> list[Range]:
    """The rule's ranges, forces in proportion to the weight."""
    scale = _scale(design)
    scaled = ((each, _by(each.key, scale)) for each in ranges_of(RULE))
    return [replace(each, low=each.low * by, high=each.high * by) for each, by in scaled]


def _starts(design: Design, ranges: Sequence[Range]) -> list[Values]:
    """The design's own values, and those of shipped fingers that pass, inside the ranges."""
    found: list[Values] = []
    for each, by in _known(design):
        values = {own.key: float(attrgetter(own.key)(each)) * _by(own.key, by) for own in ranges}
        clipped = {own.key: min(max(values[own.key], own.low), own.high) for own in ranges}
        found.append(_short(clipped))
    return [each for k, each in enumerate(found) if each not in found[:k]]


def _known(design: Design) -> Iterator[tuple[Design, float]]:
    """Designs with values to begin with, and the scale of their forces."""
    for name in PASSING:
        known = load_design(name)
        yield known, _scale(design) / _scale(known)
    if design.grip.controller == RULE:
        yield design, 1.0


def _scale(design: Design) -> float:
    """Weight over that of the ranges' own 500 g; of a range of masses that of its middle."""
    grip = design.grip
    return (grip.middle_g or grip.heaviest_g) / 500.0


def _by(key: str, scale: float) -> float:
    """Factor of a key where all forces have the factor ``scale``."""
    if key in _FORCES:
        return scale
    return 1.0 / scale if key == "grip.curve_per_N" else 1.0


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")


def _short(values: Values) -> Values:
    return {key: _rounded(value) for key, value in values.items()}
