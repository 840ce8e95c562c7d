"""The C file's regulator in numpy's single precision, operation by operation in the same order.

A Python number next to a single is rounded to a single, as a C literal that ends with f.
"""

from collections import deque
from types import SimpleNamespace

import numpy as np

from fingerdesign.control.c_code import constants, in_16_bits
from fingerdesign.control.completion import LARGEST
from fingerdesign.control.features import LAGS, SILENT, readings_at

CURVES = "normal_force", "pressed", "sticking", "approach", "stiffness"
RADIUS = "turn_radius"
S = np.float32
ZERO = S(0.0)
MOST_TURNS = 50  # of conjugate gradients


def logarithm(x):
    """Natural logarithm by the C file's series."""
    m, power = np.frexp(x)
    if m < S(0.70710678):
        m, power = m + m, power - 1
    s = (m - 1.0) / (m + 1.0)
    q = s * s
    series = 1.0 + q * (0.33333333 + q * (0.2 + q * (0.14285714 + q * 0.11111111)))
    return 2.0 * s * series + S(0.69314718) * S(power)


def interpolated(x, xs, ys):
    """The value of a curve, held constant beyond its ends."""
    x = min(max(x, xs[0]), xs[-1])
    k = min(max(int(np.searchsorted(xs, x)) - 1, 0), len(xs) - 2)
    return ys[k] + (x - xs[k]) / (xs[k + 1] - xs[k]) * (ys[k + 1] - ys[k])


def total(values):
    """Sum of singles, one after the other."""
    found = ZERO
    for each in values:
        found = found + each
    return found


class SingleRegulator:
    """State and steps of regulator.c; a moment is (readings, F_n, F_t, dx, dy)."""

    def __init__(self, estimator, grip, calibration):
        self.n = SimpleNamespace(**{k: S(v) for k, v in constants(estimator, grip).items()})
        self.band, self.cross_talk = estimator.band, S(calibration.cross_talk)
        self.layers = [(*in_16_bits(each.weight), S(each.bias)) for each in self.band.layers]
        curves = (S(getattr(estimator.curves, name)) for name in CURVES)
        self.force, self.pressed, self.sticking, self.approach, self.stiff = curves
        self.radius, self.torques = S(estimator.curves.turn_radius), []
        self.delay = self.settling = calibration.delay
        self.stiffness, self.history = S(calibration.tangential_stiffness), []
        self.pulled, self.pending = False, deque([(ZERO, ZERO)] * (self.delay + 1))
        self.pressing = self.weight = self.sum = self.forces = self.used = self.probed = ZERO
        self.exponent, self.first = self.n.EXPONENT, None
        self.carried, self.dead = ZERO, np.zeros(self.pressed.shape[1], dtype=bool)

    def left_by_turn(self, force):
        """Share of the stiffness that a turning object leaves."""
        radius, moment, pulled = interpolated(force, self.force, self.radius), ZERO, ZERO
        for (_, _, tangential, *_), torque in zip(self.history, self.torques, strict=True):
            moment, pulled = moment + torque * tangential, pulled + tangential * tangential
        if not radius > 0.0:
            return S(1.0)
        part = moment / (pulled + self.n.ARM_FORCE * self.n.ARM_FORCE) / radius
        return 1.0 / (1.0 + part * part)

    def changes(self, first, alone, scale, pressed):
        """Features of what changed since a moment."""
        (readings, normal, tangential, *_), n = self.history[-1], self.n
        before = self.history[first]
        dx = dy = along = closed = ZERO
        for *_, x, y in self.history[first + 1 :]:
            dx, dy, along, closed = dx + x, dy + y, along + abs(x), closed + abs(y)
        way = max(along + closed, n.LEAST_MOTION)
        after = interpolated(before[1], self.force, self.approach) + dy
        after = interpolated(after, self.approach, self.force)
        middle = 0.5 * (before[1] + after)
        pulling = interpolated(middle, self.force, self.stiff) * self.left_by_turn(middle) * dx
        rise, pull = normal - before[1], tangential - before[2]
        size = abs(pull) + n.NORMAL_SHARE * abs(rise) + n.LEAST_CHANGE
        alone = alone - interpolated(before[1], self.force, self.pressed)
        forces = rise, pull, rise - (after - before[1]), pull - pulling
        logarithms = logarithm(way), logarithm(size / pressed)
        change = (readings - before[0] - alone) / (scale * size)
        return [*change, *(each / size for each in forces), dx / way, *logarithms]

    def estimate(self):
        """Stick ratio, utilisation and its standard deviation of the last moment."""
        (readings, normal, tangential, dx, _), n = self.history[-1], self.n
        pressed = max(normal, n.LEAST_FORCE)
        alone = interpolated(pressed, self.force, self.pressed)
        sticking = interpolated(pressed, self.force, self.sticking)
        scale = max(abs(sticking).max(), n.LEAST_RESPONSE)
        present = (readings - alone) / (scale * pressed)
        most = max(ZERO, *(each[2] / max(each[1], n.LEAST_FORCE) for each in self.history))
        found = [*present, logarithm(pressed), tangential / pressed, n.LOG_NOISE, most]
        found.append(self.left_by_turn(pressed))
        last, self.pulled = len(self.history) - 1, self.pulled or dx != 0.0
        if not self.pulled:
            self.touch, self.start = present, last
        for first in (*(max(last - lag, 0) for lag in LAGS), self.start):
            found += self.changes(first, alone, scale, pressed)
        values = (S([*found, *self.touch]) - S(self.band.center)) / S(self.band.scale)
        values = np.clip(values, -n.OUTLIER, n.OUTLIER)
        if last + 1 >= SILENT:
            largest = abs(S([each[0] for each in self.history[-SILENT:]])).max(axis=0)
            self.dead |= abs(alone) > n.HEARD * n.NOTHING
            self.dead &= largest < n.NOTHING
        self.complete(values)
        outputs = self.evaluated(values)
        edges, std = S(self.band.spread).T
        stick, used = (min(max(each, ZERO), S(1.0)) for each in outputs[:2])
        return stick, used, std[min(int((edges < outputs[2]).sum()), len(edges) - 1)]

    def complete(self, values):
        """Features of dead gages from all others, gage by gage."""
        relations, gages = self.band.relations, np.flatnonzero(self.dead)
        places = np.add.outer(gages, readings_at(len(self.dead))).ravel()
        root = S(relations.root)
        matrix = (S(np.rint(LARGEST * relations.matrix)) / S(LARGEST))[places]
        values[places] = ZERO
        left, found = np.zeros(len(places), dtype=S), np.zeros(len(places), dtype=S)
        for column, own, value in zip(matrix.T, root, values, strict=True):
            left -= column * (own * value)
        way, size, turns = left.copy(), total(left * left), 0
        first, matrix = size, matrix[:, places]
        while turns < MOST_TURNS and size > S(1e-12) * first:
            turned = np.zeros(len(places), dtype=S)
            for column, value in zip(matrix.T, way, strict=True):
                turned += column * value
            step, before = size / total(way * turned), size
            found, left = found + step * way, left - step * turned
            size, turns = total(left * left), turns + 1
            way = left + size / before * way
        values[places] = np.clip(found / root[places], -self.n.OUTLIER, self.n.OUTLIER)

    def evaluated(self, values):
        """Outputs of the network, summed input by input."""
        for k, (weight, scale, bias) in enumerate(self.layers):
            sums = np.zeros(len(bias), dtype=S)
            for value, row in zip(values, S(weight), strict=True):
                sums += value * row
            values = scale * sums + bias
            values = values if k + 1 == len(self.layers) else np.maximum(values, ZERO)
        return values

    def learn(self, used, std, lifted):
        """Update the stiffnesses and the friction."""
        (_, normal, tangential, dx, dy), n = self.history[-1], self.n
        rise, change = normal - self.history[-2][1], tangential - self.history[-2][2]
        if dy > 0.0 and rise > 0.0:
            self.pressing = rise / dy
        if dx > 0.02 * n.SHEAR_STEP and change > 0.0:
            part = (1.0 - n.STIFFNESS_FADES) * change / dx
            self.stiffness = n.STIFFNESS_FADES * self.stiffness + part
        if lifted or not self.pulled or used < n.LEAST_USED or normal < 2.0 * n.LEAST_FORCE:
            return
        friction = min(max(tangential / (normal * used), n.LEAST_FRICTION), n.MOST_FRICTION)
        sure, memory = used / max(std, S(1e-3)), n.MEMORY
        sure = sure * sure  # A power may be rounded otherwise.
        if dy > 0.0:
            sure, memory = n.CLIMBING * sure, 1.0 - n.CLIMBING * (1.0 - memory)
        self.weight = memory * self.weight + sure
        self.sum = memory * self.sum + sure * friction
        self.forces = memory * self.forces + sure * normal

    def probe_ends(self, pressed):
        """The exponent, from this coefficient and that of the first probe."""
        n, known = self.n, self.weight > 0.0
        if self.probed != 0.0:
            return
        self.probed = pressed
        if not known:
            return
        force = self.forces / self.weight
        friction = self.friction_at(force)
        self.first = self.first or (force, friction)
        force, fall = logarithm(force / self.first[0]), logarithm(self.first[1] / friction)
        found = n.PRIOR * n.EXPONENT + S(0.5) * force * fall
        found = found / (n.PRIOR + S(0.5) * force * force)
        self.exponent = min(max(found, ZERO), n.MOST_EXPONENT)

    def friction_at(self, force):
        """The friction at a normal force."""
        if not self.weight > 0.0:
            return ZERO
        mean = self.forces / self.weight
        both, off = mean + force, self.exponent * (mean - force)
        return self.sum / self.weight * ((both + off) / (both - off))

    def sure_part(self, force):
        """The same less its standard deviation."""
        return self.friction_at(force) * max(1.0 - self.n.CAUTION / np.sqrt(self.weight), S(0.5))

    def close(self, pressed):
        """The next approach."""
        if not self.pressing > 0.0:
            return 0.5 * self.n.APPROACH_STEP
        gentle = self.n.PRESS_SHARE * pressed / self.pressing
        return min(self.n.APPROACH_STEP, max(gentle, S(0.1) * self.n.APPROACH_STEP))

    def shear(self, force):
        """The next shear for a rise of F_t."""
        return min(max(force / self.stiffness, ZERO), self.n.SHEAR_STEP)

    def move(self, stick, used, normal, tangential, lifted):
        """The next dx and dy, of forces as they will be."""
        n, known = self.n, self.weight > 0.0
        pressed = max(normal, n.LEAST_FORCE)
        ratio = tangential / pressed
        friction = self.friction_at(pressed)
        if lifted:
            in_use = ratio / (self.sure_part(pressed) if known else n.UNKNOWN)
            self.carried = self.carried or ratio
            tugged = in_use > n.MOST_HELD or ratio > n.TUGGED * self.carried
            return ZERO, self.close(pressed) if tugged else ZERO
        self.used += n.NEWS * (used - self.used)
        believed = ratio / friction if known else ZERO
        if stick < n.LEAST_STICK or max(self.used, believed) > n.MOST_USED:
            self.probe_ends(pressed)
            return ZERO, self.close(pressed)
        if pressed > n.AGAIN * self.probed > 0.0:
            self.probed, self.forces = ZERO, n.KEPT * self.forces
            self.weight, self.sum = n.KEPT * self.weight, n.KEPT * self.sum
        if self.probed == 0.0:
            if pressed < n.PROBE_FORCE_N:
                return ZERO, self.close(pressed)
            if (step := self.probing_pull(ratio, pressed, friction)) > 0.0:
                return self.shear(step), ZERO
            self.probe_ends(pressed)
        if not known:
            return self.shear(n.PULL_SHARE * pressed), ZERO
        dy = self.close(pressed)
        force = pressed + max(self.pressing, ZERO) * dy
        aim = n.TARGET * self.sure_part(force) * force
        return self.shear(aim - tangential), dy

    def probing_pull(self, ratio, pressed, friction):
        """The rise of F_t of a probe's next step; 0 at its end."""
        n, on_the_way = self.n, max(ratio - self.history[-1][2] / pressed, ZERO)
        on_the_way = on_the_way / friction if friction > 0.0 else ZERO
        room = n.NEAR * n.TARGET - self.used - on_the_way
        if not room > 0.0:
            return ZERO
        step = n.PULL_SHARE * pressed / np.sqrt(S(1 + self.delay))
        if friction > 0.0:
            step = max(min(step, n.OF_ROOM * room * friction * pressed), n.SLOWEST * step)
        return step

    def step(self, readings, normal, tangential, lifted, torque=0.0):
        """Answer a sample: dx, dy, stick ratio, utilisation, friction, unsure."""
        now = S(readings), S(normal), S(tangential) - self.cross_talk * S(normal)
        settles = self.settling > 0
        if settles or not self.history:
            self.history, self.torques = [(*now, ZERO, ZERO)], [S(torque)]
        if settles:
            self.settling -= 1
            return ZERO, ZERO, *self.estimate()[:2], ZERO, True
        self.history.append((*now, *self.pending.popleft()))
        self.torques.append(S(torque))
        stick, used, std = self.estimate()
        self.learn(used, std, lifted)
        dx = dy = ZERO
        for x, y in self.pending:
            dx, dy = dx + x, dy + y
        ahead = now[1] + self.pressing * dy, now[2] + self.stiffness * dx
        self.pending.append(self.move(stick, used, *ahead, lifted))
        friction = self.sum / self.weight if self.weight > 0.0 else ZERO
        return *self.pending[-1], stick, used, friction, self.weight < self.n.SURE

    def miss(self):
        """Pass a sample over: its move counts with the next one's, and none follows."""
        if self.settling > 0:
            self.settling -= 1
        elif self.delay > 0:
            (x, y), (x1, y1), *rest = self.pending
            self.pending = deque([(x1 + x, y1 + y), *rest, (ZERO, ZERO)])
