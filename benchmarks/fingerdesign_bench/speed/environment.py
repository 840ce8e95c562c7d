"""Steps a second of the Gymnasium environment on one core, by a random and by a scripted hand."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fingerdesign.analysis.stages import one_thread
from fingerdesign.arrays import Array
from fingerdesign.checks.starter import find_design
from fingerdesign.sensing.model import grip_problem
from fingerdesign.trials.environment import GripEnvironment, Observation
from fingerdesign_bench.check import Check

STEPS = 3000  # of each hand
STEP_US = 1000.0  # a thousand steps a second
_WARM = 100  # steps before the clock starts: the kernel is compiled in them

Policy = Callable[[Observation], Array]


@dataclass(frozen=True)
class Pace:
    """Processor seconds of so many steps, and of the resets (presses to the preload) between."""

    steps: int
    episodes: int
    step_s: float
    reset_s: float

    def checks(self, where: str) -> list[Check]:
        """Microseconds a step, with the resets and without."""
        of_one = f"{self.steps / self.episodes:.1f} steps an episode"
        both = {"resets counted": self.step_s + self.reset_s, "steps alone": self.step_s}
        return [
            Check(
                f"{where}, {of_one}, {what}: {self.steps / seconds:.0f} steps/s",
                STEP_US,
                1e6 * seconds / self.steps,
                "us",
            )
            for what, seconds in both.items()
        ]


def environment_checks(
    name: str = "sensitive", fidelity: str = "3d", steps: int = STEPS
) -> list[Check]:
    """A shipped design's model, condensed once, gripped with by both hands on one core."""
    design = find_design(name)
    problem = grip_problem(design, fidelity)
    environment = GripEnvironment(design, problem=problem)
    where = f"{fidelity}, {name}, {problem.model.nodes} contact nodes"
    hands: dict[str, Policy] = {"random": random_hand(environment), "scripted": scripted_hand}
    checks = []
    with one_thread():
        for hand, policy in hands.items():
            paced(environment, policy, _WARM)
            checks += paced(environment, policy, steps).checks(f"{where}, {hand}")
    return checks


def random_hand(environment: GripEnvironment, seed: int = 0) -> Policy:
    """Evenly from the whole action space."""
    space, rng = environment.action_space, np.random.default_rng(seed)
    return lambda felt: rng.uniform(space.low, space.high)


def scripted_hand(felt: Observation) -> Array:
    """Pull until F_t is 0.15 of F_n, then close; a hanging object is closed on too."""
    normal, tangential = felt[-5], felt[-4]
    return np.array([0.1, 1.0] if tangential > 0.15 * normal else [0.2, 0.2])


def paced(environment: GripEnvironment, policy: Policy, steps: int, seed: int = 0) -> Pace:
    """Processor time of ``steps`` steps, begun with a seed."""
    felt, _ = environment.reset(seed=seed)
    episodes, spent = 1, np.zeros(2)
    for _ in range(steps):
        action = policy(felt)
        start = time.process_time()
        felt, _, terminated, truncated, _ = environment.step(action)
        after = time.process_time()
        spent[0] += after - start
        if terminated or truncated:
            felt, _ = environment.reset()
            episodes += 1
            spent[1] += time.process_time() - after
    return Pace(steps, episodes, *spent.tolist())
