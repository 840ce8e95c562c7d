"""One design's mold, in a process of its own: whatever happens to it happens to one mold.

A case is a shipped design's name or the seed of a random one.
"""

from __future__ import annotations

import os
import tempfile
import time
from typing import TYPE_CHECKING, Any

from fingerdesign.errors import DesignError

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.record import MoldData

Record = dict[str, Any]


def mold_one(case: str) -> Record:
    """Make a design's mold and throw it away; how it went, as plain values.

    seconds: from the design to the last file, without those to start Python and to draw the design;
    cpu_s: of this process and of those that it waited for, which a busy machine stretches less.
    """
    from fingerdesign.mold.make import make_mold

    design, kinds = design_of(case)
    record: Record = {"case": case, "name": design.design.name, "kinds": kinds}
    start, before = time.perf_counter(), sum(os.times()[:4])
    with tempfile.TemporaryDirectory(prefix="fingerdesign-bench-") as name:
        try:
            report = make_mold(design, name)
        except DesignError as error:
            seconds = round(time.perf_counter() - start, 2)
            reason = " | ".join(str(fault) for fault in error.faults)
            return record | {"status": "refused", "reason": reason, "seconds": seconds}
        record["seconds"] = round(time.perf_counter() - start, 2)
        record["cpu_s"] = round(sum(os.times()[:4]) - before, 2)
        return record | reported(report)


def reported(report: MoldData) -> Record:
    """What of a mold's record the bench keeps."""
    checks = report["checks"]
    wrong = [each["sentence"] for each in checks if not each["ok"]]
    if not wrong and report["status"] != "ok":
        wrong = [str(report["failure"])]  # nothing could be built, so nothing was checked

    def worst(name: str, part: str | None = None) -> float | None:
        found = [
            each["measured"]
            for each in checks
            if each["name"] == name
            and part in (None, each["part"])
            and each["measured"] is not None
        ]
        return max(found, default=None)

    return {
        "status": "failed" if wrong else "made",
        "reason": None,
        "failed": wrong,
        "checks": len(checks),
        "volume_error": worst("cavity is the finger"),
        "insert_chord_mm": worst("chord", "contact_insert"),
        "chord_mm": worst("chord"),
        "timings_s": report["timings_s"],
    }


def design_of(case: str) -> tuple[Design, list[str]]:
    """The design of a case, and its kinds as in any_designs: body, "edged", "cored", plates."""
    from fingerdesign.checks.load import load_design, parse_design

    if case.isdigit():
        import tomlkit

        from fingerdesign_bench.any_finger.designs import kinds, random_design

        seed = int(case)
        return parse_design(tomlkit.dumps(random_design(seed))), list(kinds(seed))
    from fingerdesign.checks.starter import shipped_path

    design = load_design(shipped_path(case))
    return design, ["shipped", design.body.shape]
