"""
Train a hand, judge it by GripBench
===================================

SciPy's differential evolution trains eight weights on the Gymnasium environment, from forces alone.
``python 07_trained_hand.py 07_trained_hand.py.txt`` takes minutes; this page trains for seconds.
``fingerdesign study gripbench --controller 07_trained_hand:Hand`` judges the class below.
"""

import sys

import numpy as np
from matplotlib import pyplot
from scipy.optimize import differential_evolution

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.control.roster import Command
from fingerdesign.trials.environment import GripEnvironment


class Hand:
    name = "trained"

    def __init__(self, grip, own=None, held=None, given=None):
        self.grip, self.weights = grip, np.loadtxt(__file__ + ".txt") if given is None else given

    def start(self, calibration, sample):
        self.most, self.softening, self.up = 1e-9, 0.0, 0.0

    def parts(self, normal, tangential, lifted):
        if self.up > 0.05:
            self.most = max(self.most, stiffness := max(tangential - self.last, 0.0) / self.up)
            self.softening += 0.3 * (1.0 - stiffness / self.most - self.softening)
        given = np.array([1.0, tangential / max(normal, 0.1), self.softening, 0.1 * normal])
        up, closing = np.clip(np.reshape(self.weights, (2, 4)) @ given, 0.0, 1.0).tolist()
        self.last, self.up = tangential, 0.0 if lifted else up
        return self.up, closing

    def command(self, sample):
        up, closing = self.parts(sample.normal_force, sample.tangential_force, sample.lifted)
        return Command(up * self.grip.shear_step_mm, closing * self.grip.approach_step_mm, False)


def loss(weights, env, lifts):
    total = 0.0
    for seed in range(lifts):
        (*_, normal, tangential, _, _, lifted), _ = env.reset(seed=seed)
        hand, over = Hand(None, given=weights), False
        hand.start(None, None)
        while not over:
            action = hand.parts(normal, tangential, lifted > 0.5)
            (*_, normal, tangential, _, _, lifted), reward, ended, cut, _ = env.step(action)
            total, over = total + reward, ended or cut
    return -total / lifts


if __name__ == "__main__":
    held = {"grip.plant": "lift", "grip.hold_steps": 20}  # 0.2 s after the lift, as GripBench
    env = GripEnvironment(with_values(load_design("sensitive"), held), "plane-strain")
    size = 12 if sys.argv[1:] else 4  # lifts, and generations
    about = {"popsize": 3, "maxiter": size, "polish": False, "seed": 0}
    found = differential_evolution(loss, [(-1.0, 1.0)] * 8, (env, size), **about)
    np.savetxt(*[*sys.argv[1:], sys.stdout][:1], found.x)
    pyplot.plot(np.sort(-found.population_energies), "o")  # mean reward of the last hands
    pyplot.show()
