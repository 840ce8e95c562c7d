"""
Train a hand, judge it by GripBench
===================================

SciPy's differential evolution trains eight weights on the Gymnasium environment, from forces alone.
``python 07_trained_hand.py hand.txt`` takes minutes and writes the weights; this page trains for
seconds. ``fingerdesign study gripbench --controller 07_trained_hand:Hand`` judges the class below.
"""

import sys

import numpy as np
from matplotlib import pyplot
from scipy.optimize import differential_evolution

from fingerdesign.checks.load import load_design
from fingerdesign.control.roster import Command
from fingerdesign.control.signals import Sample
from fingerdesign.trials.environment import GripEnvironment


class Hand:
    def __init__(self, grip, own=None, held=None, weights=None):
        self.weights = np.loadtxt("hand.txt") if weights is None else weights
        self.grip, self.name = grip, "trained"

    def start(self, calibration, sample):
        self.most, self.last, self.softening, self.up = 1e-9, sample.tangential_force, 0.0, 0.0

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
    total = 0.0  # reward
    for seed in range(lifts):
        (*_, normal, tangential, _, _, lifted), _ = env.reset(seed=seed)
        hand, over = Hand(None, weights=weights), False
        hand.start(None, Sample(np.zeros(0), normal, tangential))
        while not over:
            action = hand.parts(normal, tangential, lifted > 0.5)
            (*_, normal, tangential, _, _, lifted), reward, ended, cut, _ = env.step(action)
            total, over = total + reward, ended or cut
    return -total / lifts


if __name__ == "__main__":
    env = GripEnvironment(load_design("sensitive"), "plane-strain")
    lifts, rounds = (30, 20) if sys.argv[1:] else (4, 4)
    about = {"popsize": 3, "maxiter": rounds, "polish": False, "seed": 0}
    found = differential_evolution(loss, [(-1.0, 1.0)] * 8, (env, lifts), **about)
    np.savetxt(sys.argv[1] if sys.argv[1:] else sys.stdout, found.x)
    pyplot.plot(np.sort(-found.population_energies), "o")
    pyplot.ylabel("reward of the last hands")
    pyplot.show()
