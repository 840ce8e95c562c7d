"""Evaluators for tests, named "evaluators:NAME": quick, by a formula, and bad in every way.

The package is loaded (1.5 s) where an outcome is made: what dies, and what takes it from a file,
needs it not.
"""

import os
import time
from dataclasses import replace
from pathlib import Path


def outcome_of(data, seconds=0.0):
    """A good outcome, the same whenever and wherever it is computed."""
    from fingerdesign.search.run.evaluate import Job

    job = Job.from_data(data)
    return _good(job, {"plates": float(job.design.plates.count), "cost": 1.0}, seconds)


def formula_of(job):
    """A good outcome of two objectives at odds in the radius; long plates help both, steep ones
    break a bound."""
    body, plates = job.design.body, job.design.plates
    radius, length = body.arc_radius_mm / 50.0, plates.length_mm
    deep = 0.01 if job.fidelity == "3d" else 0.0
    metrics = {
        "stick_error": (radius - 1.4) ** 2 + 1.0 - 0.5 * length + deep,
        "peak_force_N": 10.0 * (radius - 0.7) ** 2 + 10.0 - 5.0 * length + deep,
        "grip_success": 1.0 if plates.angle_deg > 35.0 else 0.5,
        "core_seconds": 0.0,
    }
    return _good(job, metrics)


def _good(job, metrics, seconds=0.0):
    from fingerdesign.records.outcome import Failure
    from fingerdesign.search.run.evaluate import failed

    empty = failed(job, Failure("failed", ""))
    return replace(empty, status="ok", failure=None, metrics=metrics, seconds=seconds)


def formula(data):
    """After $EVALUATOR_SECONDS, in 3-D once there is a file $EVALUATOR_3D_AFTER; leaves its name in
    the file $EVALUATED."""
    from fingerdesign.search.run.evaluate import Job

    time.sleep(float(os.environ["EVALUATOR_SECONDS"]))
    while data["fidelity"] == "3d" and not os.path.exists(os.environ["EVALUATOR_3D_AFTER"]):
        time.sleep(0.05)
    _report(data)
    return formula_of(Job.from_data(data)).to_json()


def quick(data):
    """At once; leaves a line of its name in the file $EVALUATED, if any."""
    _report(data)
    return outcome_of(data).to_json()


def slow(data):
    """After $EVALUATOR_SECONDS."""
    time.sleep(float(os.environ.get("EVALUATOR_SECONDS", "0.2")))
    return quick(data)


def bad(data):
    """What the value "act" says: crash, exit, hang, eat, raise, babble, killed; else the outcome in
    the file $EVALUATED.NAME."""
    act = data["values"].get("act", "")
    if act == "crash":
        os.abort()
    if act == "exit":
        os._exit(3)
    if act == "hang":
        time.sleep(1e6)
    if act == "eat":
        taken = []
        while True:
            taken.append(bytearray(os.urandom(1 << 20) * 20))
            time.sleep(0.02)
    if act == "raise":
        raise ZeroDivisionError("of the test")
    if act == "babble":
        return '{"no": "outcome"}'
    if act == "killed":  # once
        mark = Path(os.environ["EVALUATED"] + ".killed")
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), 9)
    return Path(f"{os.environ['EVALUATED']}.{data['name']}").read_text("utf-8")


def _report(data):
    path = os.environ.get("EVALUATED")
    if path:
        with open(path, "a", encoding="utf-8") as stream:
            stream.write(f"{data['name']}\n")


def large(data):
    """After a moment; a tenth are of 200 kB."""
    time.sleep(0.1)
    found = outcome_of(data)
    if data["name"].endswith("9"):
        found = replace(found, warnings=("w" * 200_000,))
    _report(data)
    return found.to_json()


def deadly(data):
    """The fifth ends the worker that asks."""
    if data["name"].endswith("0005"):
        os.kill(int(os.environ["ASKED_BY"]), 9)
        time.sleep(10.0)
    return slow(data)


def elsewhere(data):
    """As a worker of another version answers."""
    found = outcome_of(data)
    older = found.versions | {"fingerdesign": "0.0.1"}
    return replace(found, digest="0" * 64, versions=older).to_json()
