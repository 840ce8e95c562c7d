"""Who decides the next move from gages and forces alone: the flow chart of the paper's Fig. 9.

(Maeno, Hiromitsu and Kawai 2000.) A controller is handed what a hand can know, a :class:`Sample`,
and what its rig learnt of its own finger, a :class:`Calibration`: never the friction, the object's
mass or the true stick area. That the object is lifted is a flag of its sample.

Why the rule works. While both forces grow, nothing slips as long as dF_t/dF_n < mu; beyond it slip
comes in from the contact's edges. On F_t = c F_n^2 the slope 2 c F_n passes mu at F_n = mu / 2c and
the whole contact would slip at mu / c: the rule has dF_n = mu / 2c to see A fall, 1 N at mu = 0.2
and c = 0.1/N. A hold lets F_n grow and starts the slope at zero again; holding as soon as slip
begins gives a mean slope of mu / 2, a margin of 2; holding later, a smaller margin; a long hold, a
larger one. All forces scale with 1/c, so c sets the weight of objects that are a test: at
mu = 0.3 the path without the rule slips at mu^2 / c = 0.9 N of F_t and more, by the preload.

Where it fails. If all gages answer above the threshold at full stick (few plates, reaching hardly
beyond the contact), A is the plates' whole width and cannot fall: ``designs/narrow.toml`` slips at
mu <= 0.4. And right after a hold, while F_t has hardly changed, what F_n does to gages that already
feel a shear is not in the normal-only calibration: A is then off, and its return can look like a
fall. ``force_floor`` keeps the worst of it out; the holds that are left while nearly all sticks
cost margin, not the object.
"""

import math

from fingerdesign.control.roster import Command, Object, Range, controller
from fingerdesign.control.signals import Calibration, Sample, gage_area, line_of, response
from fingerdesign.design.grip import Grip

_LEAST_MOVE = 0.02  # of the largest dx: below it the normal move's own stir of F_t shows


@controller(
    "paper",
    place=1,
    tuned=(
        Range("grip.curve_per_N", 0.01, 1.0),
        Range("grip.threshold_share", 0.1, 0.8, logarithmic=False),
        Range("grip.force_floor_N", 0.005, 0.3),
        Range("grip.dead_band_mm", 0.005, 1.0),
        Range("grip.hold_force_N", 0.05, 5.0),
    ),
    look=("blue", "-", "o"),
)
class PaperController:
    """The paper's rule: while the gage area A falls, hold x; else follow a quadratic F_t(F_n).

    Each step closes by dy. A is made between now and the last sample since the hold whose F_t
    differs by ``force_floor``. It has fallen when it is ``dead_band`` below its largest value since
    the hold: small falls add up, whatever the step. Then dx = 0 until F_n has risen by
    ``hold_force``; from there the curve starts again, with slope zero. A lifted object ends the
    flow chart: the hand stays where it is.

    ``rule=False`` never holds: what the same path does without the rule.
    """

    def __init__(
        self, grip: Grip, own: None = None, held: Object | None = None, rule: bool = True
    ) -> None:
        self.name = "paper" if rule else "paper, never holding"
        # Its keys are in ``[grip]`` itself; it is given no others of that table.
        self._approach_step, self._shear_step = grip.approach_step_mm, grip.shear_step_mm
        self._curve, self._threshold_share = grip.curve_per_N, grip.threshold_share
        self._force_floor, self._dead_band = grip.force_floor_N, grip.dead_band_mm
        self._hold_force = grip.hold_force_N
        self._rule = rule

    def start(self, calibration: Calibration, sample: Sample) -> None:
        self._calibration = calibration
        self._order = line_of(calibration.gage_x)
        self._stiffness = calibration.tangential_stiffness
        self._dx = 0.0
        self._last = sample
        self._area: float | None = None
        self._held_until: float | None = None
        self._largest = -math.inf
        self._begin_curve(sample)

    def command(self, sample: Sample) -> Command:
        if sample.lifted:
            return Command(0.0, 0.0, False, self._area, warns=self._warns(False))
        self._learn_stiffness(sample)
        rise = sample.normal_force - self._last.normal_force
        self._last = sample
        if self._held_until is not None and sample.normal_force >= self._held_until:
            self._begin_curve(sample)
        if self._held_until is None and self._rule_fires(sample):
            self._held_until = sample.normal_force + self._hold_force
        holding = self._held_until is not None
        self._dx = 0.0 if holding else self._shear_to_curve(sample, rise)
        warns = self._warns(holding)
        return Command(self._dx, self._approach_step, holding, self._area, warns=warns)

    def _warns(self, holding: bool) -> bool | None:
        """The rule warns by holding; switched off, it never warns."""
        return holding if self._rule else None

    def _rule_fires(self, sample: Sample) -> bool:
        """True if A has fallen below its largest value since the hold, beyond the dead band."""
        area = self._area_now(sample)
        if area is None:
            return False
        self._area = area
        self._largest = max(self._largest, area)
        return self._rule and area < self._largest - self._dead_band

    def _begin_curve(self, sample: Sample) -> None:
        self._origin = sample
        self._held_until = None
        self._since = [sample]
        self._largest = -math.inf

    def _area_now(self, sample: Sample) -> float | None:
        """A between now and the last sample whose F_t is ``force_floor`` away; None without one."""
        floor = self._force_floor
        far = [s for s in self._since if abs(sample.tangential_force - s.tangential_force) >= floor]
        self._since.append(sample)
        if not far:
            return None
        values = response(far[-1], sample, self._calibration.normal)
        threshold = self._threshold_share * self._calibration.scale
        change = sample.tangential_force - far[-1].tangential_force
        x = self._calibration.gage_x[self._order]
        return gage_area(x, values[self._order], threshold, math.nan, change, floor)

    def _learn_stiffness(self, sample: Sample) -> None:
        """Update dF_t/dx. The normal move changes F_t a little: tiny moves are left out."""
        if self._dx > _LEAST_MOVE * self._shear_step:
            change = sample.tangential_force - self._last.tangential_force
            if change > 0.0:
                self._stiffness = change / self._dx

    def _shear_to_curve(self, sample: Sample, rise: float) -> float:
        """dx that brings F_t onto the curve at the F_n expected after the next move."""
        origin = self._origin
        expected = sample.normal_force + max(rise, 0.0) - origin.normal_force
        aim = origin.tangential_force + self._curve * expected**2
        target = (aim - sample.tangential_force) / self._stiffness
        return min(max(target, 0.0), self._shear_step)
