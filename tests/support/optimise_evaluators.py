"""Evaluators for tests of the search: metrics by a formula, at once or after a moment."""

import os
import time
from dataclasses import replace

from fingerdesign.records.outcome import Failure
from fingerdesign.search.run.evaluate import Job, failed


def metrics_of(job):
    """Two objectives at odds in the radius; long plates help both, steep ones break a bound."""
    body, plates = job.design.body, job.design.plates
    radius, length = body.arc_radius_mm / 50.0, plates.length_mm
    deep = 0.01 if job.fidelity == "3d" else 0.0
    return {
        "stick_error": (radius - 1.4) ** 2 + 1.0 - 0.5 * length + deep,
        "peak_force_N": 10.0 * (radius - 0.7) ** 2 + 10.0 - 5.0 * length + deep,
        "grip_success": 1.0 if plates.angle_deg > 35.0 else 0.5,
        "core_seconds": 0.0,
    }


def outcome_of(job):
    """A good outcome of the formula."""
    empty = failed(job, Failure("failed", ""))
    return replace(empty, status="ok", failure=None, metrics=metrics_of(job))


def formula(data):
    """After $EVALUATOR_SECONDS, in 3-D once there is a file $EVALUATOR_3D_AFTER; leaves its name in
    the file $EVALUATED."""
    time.sleep(float(os.environ["EVALUATOR_SECONDS"]))
    while data["fidelity"] == "3d" and not os.path.exists(os.environ["EVALUATOR_3D_AFTER"]):
        time.sleep(0.05)
    with open(os.environ["EVALUATED"], "a", encoding="utf-8") as stream:
        stream.write(f"{data['name']}\n")
    return outcome_of(Job.from_data(data)).to_json()
