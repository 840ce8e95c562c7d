"""The plants as a Gymnasium environment: a hand learns to lift what it knows nothing of.

An episode is one lift by two fingers (:class:`LiftPlant` behind :class:`ImperfectPlant`): friction
and mass are drawn, the fingers press to the preload, and from there on each step is one move.
Needs the extra ``gym`` (``pip install fingerdesign[gym]``).
"""

import warnings
from collections.abc import Sequence
from math import ceil, isfinite, log
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from fingerdesign.analysis.case import gage_array
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Bounds
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.features import Moment
from fingerdesign.control.plants.hardware import ImperfectPlant
from fingerdesign.control.plants.lift import LiftPlant
from fingerdesign.control.plants.plant import Truth, press, safety_margin
from fingerdesign.control.signals import Sample
from fingerdesign.design.grip import LEAST_FRICTION, LEAST_MASS_G, weight_per_finger
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.records.result import MOST_FORCE
from fingerdesign.runtime.extras import needs
from fingerdesign.sensing.model import grip_problem, model_data, opposite_problem
from fingerdesign.sensing.train.ready import estimator_of, shipped_estimator
from fingerdesign.sensing.train.result import estimator_faults

try:
    from gymnasium import Env
    from gymnasium.error import ResetNeeded
    from gymnasium.spaces import Box
except ImportError:  # Reported where an environment is made: the module can be imported without.
    Env = object

STEP_COST = 0.001
_STRAIN, _FORCE_N = 20_000.0, 1000.0  # microstrain, N: ends of the scales, beyond any grip
_LIMITS = {"frictions": (LEAST_FRICTION, 5.0), "masses_g": (LEAST_MASS_G, 1e5)}

Observation = NDArray[np.float32]


class GripEnvironment(Env):  # type: ignore[misc]  # the extra may be missing
    """Lifts of a design's finger, each of an object that the hand does not know.

    Action (2,): dx and dy of one move in parts of ``grip.shear_step_mm`` (0 to 1, up) and
    ``grip.approach_step_mm`` (-1 to 1, closing). Observation (g + 5,): the gages' readings
    (microstrain), F_n and F_t (N), the last move in the action's parts, and whether the object has
    left its support (0 or 1), as ``grip.hardware`` delivers them. With ``estimates`` three more, of
    an estimator: stick ratio, friction utilisation and its standard deviation. The stage goes from
    touch to ``grip.max_approach_mm``; a move beyond is cut.

    Reward: -:data:`STEP_COST` a step, and at the end

        1 - (margin - 1) / (MOST_FORCE - 1)   hung for ``grip.hold_steps`` steps after the lift,
        -1                                    slipped as a whole or dropped, crushed
                                              (F_n >= MOST_FORCE m g / 2 mu), or not lifted
                                              within the stage

    margin = mu F_n / F_t. An episode is truncated, without more reward, after ``grip.max_steps``
    and ``hold_steps`` more, and where the plant has no accepted answer: info["ending"] is then
    "failed", info["reason"] the solver's sentence, and the observation the one before.

    info is the judge's: friction_coefficient, object_mass_g, stick_ratio, safety_margin, rise_mm,
    and at the end ending and reason; what has no value is left out.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}

    def __init__(
        self,
        design: Design,
        fidelity: str = "3d",
        frictions: Sequence[float] = (0.2, 0.8),
        masses_g: Sequence[float] = (100.0, 1000.0),
        noise_microstrain: float = 0.5,
        problem: ContactProblem | None = None,
        estimates: bool | GripEstimator = False,
    ) -> None:
        """frictions, masses_g: ends of what is drawn, evenly and evenly in the logarithm.
        noise_microstrain: of a gage's sample, instead of the design's. problem: the design's
        condensed model for environments that share one; without it it is made, at ``fidelity``.
        estimates: True takes the estimator that ships with the design, or trains one and warns.

        Raises DesignError for wrong input, ValueError where a tug lifts the lightest object out of
        the fingers, ImportError without gymnasium.
        """
        needs("gym", "gymnasium")
        self._frictions, self._masses = tuple(frictions), tuple(masses_g)
        self._face, self._plates = design.gages.face, gage_array(design)
        _refuse(self._frictions, self._masses, noise_microstrain)
        self._problem = grip_problem(design, fidelity) if problem is None else problem
        gages = len(self._problem.model.gage_x)
        if gages != len(self._plates):
            bound = f"the design's {len(self._plates)}"
            raise DesignError([Fault("problem", f"{gages} gages", bound, "condense this design")])
        fidelity = model_data(self._problem)["fidelity"]
        self._opposite = opposite_problem(design, fidelity)
        self._estimator: GripEstimator | None = None
        if estimates:
            given = None if estimates is True else estimates
            if given is not None and (faults := estimator_faults(design, given, fidelity)):
                raise DesignError(faults)
            if given is None and shipped_estimator(design, fidelity) is None:
                words = f"no estimator ships for {design.design.name} in {fidelity}, with these "
                words += "gages, stage and mesh: it is trained"
                warnings.warn(f"{words}, half an hour, or comes from the cache", stacklevel=2)
            own = given or estimator_of(design, fidelity=fidelity)
            self._estimator = own.at_noise(noise_microstrain)
        self._history: list[Moment] = []
        self._moves: list[tuple[float, float]] = []
        self._grip, self._bounds = design.grip, Bounds.of(design.grip)
        self._hardware = design.grip.hardware.model_copy(
            update={"gage_noise_microstrain": noise_microstrain, "gage_noise_microvolt_per_V": 0.0}
        )
        self._lift(self._frictions[0], self._masses[0])
        high = np.array([*[_STRAIN] * gages, _FORCE_N, _FORCE_N, 1.0, 1.0, 1.0], dtype=np.float32)
        low = -high
        low[[-3, -1]] = 0.0
        if self._estimator is not None:
            low = np.append(low, np.zeros(3, np.float32))
            high = np.append(high, np.ones(3, np.float32))
        self.observation_space = Box(low, high)
        self.action_space = Box(np.array([0.0, -1.0], np.float32), np.ones(2, np.float32))
        self._plant: ImperfectPlant | None = None  # none before the first reset and after an end

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Draw friction and mass, press to the preload.

        options: ``friction_coefficient`` and ``object_mass_g`` take the place of what is drawn.
        Raises ValueError for other options, DesignError for values out of bounds, SolverError where
        the press fails.
        """
        super().reset(seed=seed)
        self._plant = None  # also where the press fails
        own = {
            "friction_coefficient": float(self.np_random.uniform(*self._frictions)),
            "object_mass_g": float(np.exp(self.np_random.uniform(*map(log, self._masses)))),
        }
        if unknown := set(options or {}) - set(own):
            raise ValueError(f"options: {min(unknown)} is unknown; known are {', '.join(own)}")
        self._friction, self._mass = map(float, (own | (options or {})).values())
        _refuse((self._friction,) * 2, (self._mass,) * 2, 0.0)
        lift = self._lift(self._friction, self._mass)
        plant = ImperfectPlant(lift, self._hardware, self.np_random, self._plates)
        # Each sample answers the move of so many samples before.
        self._history, self._moves = [], [(0.0, 0.0)] * self._hardware.delay_samples
        preload, step = self._bounds.preload, self._bounds.approach_step
        part = preload / step / max(1, ceil(preload / step - 1e-9))
        for sample in press(plant, preload, step):
            self._observation = self._observed(sample, 0.0, part)
        self._plant = plant
        self._steps = self._held = 0
        return self._observation.copy(), self._info(plant.truth())

    def step(
        self, action: Sequence[float] | NDArray[np.floating]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One move; see the class. Raises ValueError for an action that is not two numbers."""
        plant = self._plant
        if plant is None:
            raise ResetNeeded("the episode has not begun or is over: call reset first")
        if np.shape(action) != (2,):
            raise ValueError(
                "an action is two numbers: the moves along x and y, as shares of a step"
            )
        up, closing = (float(value) for value in action)
        if not (isfinite(up) and isfinite(closing)):
            raise ValueError(f"an action of {up:g}, {closing:g}: both must be finite")
        up, closing = min(max(up, 0.0), 1.0), min(max(closing, -1.0), 1.0)
        step, approach = self._bounds.approach_step, plant.truth().approach
        requested = closing * step
        dy = min(max(requested, -approach), self._bounds.max_approach - approach)
        self._steps += 1
        try:
            sample = plant.move(up * self._grip.shear_step_mm, dy)
        except SolverError as error:
            self._plant = None
            info = self._known() | {"ending": "failed", "reason": str(error)}
            return self._observation.copy(), -STEP_COST, False, True, info
        truth = plant.truth()
        self._held = self._held + 1 if truth.lifted else 0
        self._observation = self._observed(sample, up, dy / step)
        ending, reason = self._ending(truth, beyond=requested > dy + 1e-9)
        info, reward = self._info(truth), -STEP_COST
        if ending:
            self._plant = None
            info |= {"ending": ending, "reason": reason}
        terminated = ending not in ("", "steps")
        if ending == "lifted":
            reward += 1.0 - (info["safety_margin"] - 1.0) / (MOST_FORCE - 1.0)
        elif terminated:
            reward -= 1.0
        return self._observation.copy(), reward, terminated, ending == "steps", info

    def _lift(self, friction: float, mass_g: float) -> LiftPlant:
        own = (friction, mass_g, self._opposite)
        return LiftPlant.of(self._grip, self._problem, self._face, *own)

    def _ending(self, truth: Truth, beyond: bool) -> tuple[str, str]:
        """The end of the episode now and a sentence why; empty while it goes on."""
        force = f"at F_n = {truth.normal_force:.2f} N"
        least = weight_per_finger(self._mass) / self._friction
        if truth.complete_slip:
            return "complete slip", f"the whole contact slips or the object drops {force}"
        if truth.normal_force >= MOST_FORCE * least:
            return "crushed", f"{MOST_FORCE:g} times the least force, {least:.2f} N, {force}"
        if self._held > self._grip.hold_steps:
            return "lifted", f"the object hangs {force}"
        if beyond and not truth.lifted:
            return "stage travel", f"not lifted within {self._bounds.max_approach:g} mm"
        if self._steps >= self._bounds.max_steps + self._grip.hold_steps:
            return "steps", f"not lifted and held in {self._steps} steps"
        return "", ""

    def _observed(self, sample: Sample, up: float, closing: float) -> Observation:
        forces = sample.normal_force, sample.tangential_force
        every = [*sample.readings, *forces, up, closing, sample.lifted]
        if self._estimator is not None:
            dx, dy = up * self._grip.shear_step_mm, closing * self._bounds.approach_step
            self._moves.append((dx, dy))
            self._history.append(Moment(sample, *self._moves[len(self._history)]))
            found = self._estimator.estimate(self._history)
            every += [found.stick_ratio, found.friction_utilisation, found.std]
        space = self.observation_space
        return np.asarray(np.clip(every, space.low, space.high), dtype=np.float32)

    def _known(self) -> dict[str, Any]:
        return {"friction_coefficient": self._friction, "object_mass_g": self._mass}

    def _info(self, truth: Truth) -> dict[str, Any]:
        margin = safety_margin(truth, self._friction)
        values = {"stick_ratio": truth.stick_ratio, "safety_margin": margin}
        found = {key: value for key, value in values.items() if value is not None}
        return self._known() | found | {"rise_mm": truth.rise}


def _refuse(frictions: Sequence[float], masses_g: Sequence[float], noise: float) -> None:
    faults = []
    for key, ends in (("frictions", frictions), ("masses_g", masses_g)):
        least, most = _LIMITS[key]
        if not (len(ends) == 2 and least <= ends[0] <= ends[1] <= most):
            bound = f"two ends, rising, from {least:g} to {most:g}"
            faults.append(Fault(key, ends, bound, "correct it"))
    if not 0.0 <= noise <= 1e5:
        faults.append(Fault("noise_microstrain", noise, "from 0 to 1e5", "correct it"))
    if faults:
        raise DesignError(faults)
