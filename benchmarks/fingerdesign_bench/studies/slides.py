"""``fingerdesign bench slides``: a hanging object grows heavier; is it held, caught or dropped?

Every hand lifts the object, raises it by 0.03 mm a step and more, and holds it; after
:data:`AFTER` steps, some centimetre above the support, the weight grows at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from fingerdesign.analysis.stages import one_thread
from fingerdesign.checks.load import with_values
from fingerdesign.control.episode import run_episodes
from fingerdesign.design.schema import Design
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.model import grip_problem

CONTROLLERS = ("reactive", "fixed_ratio")
FRICTIONS = (0.3, 0.6)
SHARES = (0.3, 0.6)
AFTER, HELD = 400, 150  # steps from the lift to the change, and from there on


@dataclass(frozen=True)
class SlideRow:
    """What one hand made of one growth of the weight (``share`` of it); names as in GripResult.

    outcome: "held", "caught", "dropped", or how else the grip ended.
    """

    controller: str
    friction_coefficient: float
    share: float
    safety_margin: float | None
    outcome: str
    slid_mm: float
    catch_s: float | None
    swing_Hz: float | None
    reason: str


def measure_slides(
    design: Design,
    controllers: Sequence[str] = CONTROLLERS,
    frictions: Sequence[float] = FRICTIONS,
    shares: Sequence[float] = SHARES,
    fidelity: Literal["plane-strain", "3d"] = "plane-strain",
    report: Report = lambda message: None,
) -> list[SlideRow]:
    """All hands at all frictions and growths, on one model; the design's hardware and memory."""
    mass, found = design.grip.object_mass_g, []
    problem = grip_problem(design, fidelity, report=report)
    for controller in controllers:
        for share in shares:
            report(f"{controller}, {100 * share:g} % heavier")
            heavier = {"step_after_lift": AFTER, "object_mass_g": (1.0 + share) * mass}
            values: dict[str, object] = {
                "grip.plant": "lift",
                "grip.inertia": True,
                "grip.controller": controller,
                "grip.hold_steps": AFTER + HELD,
                "grip.weight_changes": [heavier],
            }
            own = with_values(design, values)
            with one_thread():
                episodes = run_episodes(problem, own, frictions, mass)
            for episode in episodes:
                result = episode.result
                found.append(
                    SlideRow(
                        controller,
                        result.friction_coefficient,
                        share,
                        result.safety_margin,
                        _OUTCOMES.get(episode.ending, episode.ending),
                        result.slid_mm,
                        result.catch_s,
                        result.swing_Hz,
                        episode.reason,
                    )
                )
    return found


_OUTCOMES = {"lifted": "held", "complete slip": "dropped"}
