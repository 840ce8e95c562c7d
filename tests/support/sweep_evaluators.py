"""Evaluators for tests, named "sweep_evaluators:NAME": quick, and bad in every way.

The package is loaded (1.5 s) where an outcome is made: what dies, and what takes it from a file,
needs it not.
"""

import os
import time
from dataclasses import replace
from pathlib import Path


def outcome_of(data, seconds=0.0):
    """A good outcome, the same whenever and wherever it is computed."""
    from fingerdesign.records.outcome import Failure
    from fingerdesign.search.run.evaluate import Job, failed

    job = Job.from_data(data)
    metrics = {"plates": float(job.design.plates.count), "cost": 1.0}
    empty = failed(job, Failure("failed", ""))
    return replace(empty, status="ok", failure=None, metrics=metrics, seconds=seconds)


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
        os.kill(os.getppid(), 9)
        time.sleep(10.0)
    return slow(data)


def elsewhere(data):
    """As a worker of another version answers."""
    found = outcome_of(data)
    older = found.versions | {"fingerdesign": "0.0.1"}
    return replace(found, digest="0" * 64, versions=older).to_json()
