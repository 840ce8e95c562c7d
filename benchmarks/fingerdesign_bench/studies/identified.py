"""Values that one trace tells of drawn fingers, beside those that were drawn."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

import fingerdesign.sensing
from fingerdesign.checks.starter import find_design
from fingerdesign.errors import SolverError
from fingerdesign.runtime.machine import usable_cores
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.identify.simulated_trace import simulated_trace
from fingerdesign.sensing.identify.trace_fit import identified
from fingerdesign.sensing.identify.trace_report import identification
from fingerdesign_bench.check import Check
from fingerdesign_bench.lines import Record, code_version, resumed

RIGS = 200
_COVER = (0.93, 0.97)  # of intervals that say 95 %
_KINDS = ("modulus", "friction", "touch", "share", "time", "gain", "offset", "drift", "per_kelvin")


def rig_found(name: str, seed: int) -> Record:
    """One drawn finger, recorded and identified from the design's own modulus.

    covered: by kind of value, of each whether its interval holds the truth; modulus_error: of one;
    terms: how many more than were drawn; seconds, of one core; status: found, or failed and why.
    """
    design = find_design(name)
    made = simulated_trace(design, seed)
    start = time.process_time()
    try:
        found = identified(design, made.trace, "simulated")
    except SolverError as error:
        seconds = time.process_time() - start
        return {"seed": seed, "status": "failed", "why": str(error), "seconds": seconds}
    values = {each.name: each for each in identification(found, "simulated").values}
    drawn = sum(key.startswith("time_") for key in made.truth)
    covered: dict[str, list[bool]] = {}
    for key, true in made.truth.items():
        if key in values:
            each = values[key]
            covered.setdefault(each.kind, []).append(bool(each.low <= true <= each.high))
    modulus = values["youngs_modulus"].value / made.truth["youngs_modulus"] - 1.0
    return {
        "seed": seed,
        "status": "found",
        "covered": covered,
        "modulus_error": abs(modulus),
        "terms": len(found.fit.terms) - drawn,
        "seconds": time.process_time() - start,
    }


def identify_checks(
    folder: Path, rigs: int = RIGS, name: str = "sensitive", report: Report = lambda message: None
) -> list[Check]:
    """Coverage of the intervals, errors of the modulus, seconds of one fit.

    Each rig is a line of rigs.jsonl in the folder: an interrupted run goes on where it stopped.
    """
    code = Path(str(fingerdesign.sensing.__file__)).parent
    with Pool(usable_cores()) as pool:
        found = resumed(
            folder / "rigs.jsonl",
            "seed",
            range(rigs),
            lambda seed: dict(pool.call(rig_found, name, seed)),
            code_version(code),
            pool.workers,
            report,
            lambda record: f"{record['status']} in {record['seconds']:.0f} s",
        )
    return list(_checks(found))


def _checks(found: Sequence[Record]) -> Iterator[Check]:
    sound = [each for each in found if each["status"] == "found"]
    yield Check("fits that failed", 0.0, float(len(found) - len(sound)))
    pooled = [hit for each in sound for hits in each["covered"].values() for hit in hits]
    for words, hits in (("all values", pooled), *_by_kind(sound)):
        share, middle = float(np.mean(hits)), 0.5 * sum(_COVER)
        words = f"{words}: {share:.3f} of {len(hits)} intervals hold the truth, off 0.95 by"
        yield Check(words, _COVER[1] - middle, abs(share - middle))
    errors = [each["modulus_error"] for each in sound]
    yield Check("modulus, greatest error", 0.03, max(errors))
    wrong = float(np.mean([each["terms"] != 0 for each in sound]))
    yield Check("share with another number of terms than drawn", 0.05, wrong)
    seconds = max(each["seconds"] for each in found)
    yield Check("seconds of one core for a fit, greatest", 60.0, seconds, "s")


def _by_kind(sound: Sequence[Record]) -> Iterator[tuple[str, list[bool]]]:
    for kind in _KINDS:
        hits = [hit for each in sound for hit in each["covered"].get(kind, ())]
        if hits:
            yield kind, hits
