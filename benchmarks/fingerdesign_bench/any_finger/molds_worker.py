"""One design's mold, in a process of its own: whatever happens to it happens to one mold.

A case is a shipped design's name or the seed of a random one.
"""

from __future__ import annotations

import os
import re
import tempfile
import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from fingerdesign.checks.load import with_values
from fingerdesign.errors import DesignError, Fault
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.plan.refusals import MoldRefused
from fingerdesign.mold.plan.remedies import remedied

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.record import MoldData

Record = dict[str, Any]
ROUNDS = 3  # of remedies, where one leads to the next refusal
_CHANGE = re.compile(r"(\w+(?:\.\w+)+)(?: = | to at (?:least|most) )('\w+'|[\d.]*\d)")
_BOUND = re.compile(r"^at (?:least|most) ([\d.]*\d)")


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
        except MoldRefused as refused:
            error = remedied(design, refused)
            seconds = round(time.perf_counter() - start, 2)
            reason = " | ".join(str(fault) for fault in error.faults)
            remedy, then = after_remedies(design, error.faults)
            record |= {"status": "refused", "reason": reason, "seconds": seconds}
            return record | {"remedy": remedy, "then": then}
        record["seconds"] = round(time.perf_counter() - start, 2)
        record["cpu_s"] = round(sum(os.times()[:4]) - before, 2)
        return record | reported(report)


def after_remedies(design: Design, faults: Sequence[Fault]) -> tuple[str, str]:
    """The first remedies of a refusal that lead to a plan ("key = value, ..."; "": none did), and
    what then becomes of the mold: "made", "failed" or "refused"."""
    from fingerdesign.mold.make import make_mold

    tried: dict[str, object] = {}
    for _ in range(ROUNDS):
        for values in [values for fault in faults for values in remedies_of(fault)]:
            try:
                mended = with_values(design, tried | values)
                plan_mold(mended)
            except DesignError:
                continue
            setting = ", ".join(f"{key} = {value}" for key, value in (tried | values).items())
            with tempfile.TemporaryDirectory(prefix="fingerdesign-bench-") as name:
                return setting, str(reported(make_mold(mended, name))["status"])
        tried |= {
            key: value for each in faults for key, value in next(remedies_of(each), {}).items()
        }
        try:
            plan_mold(mended := with_values(design, tried))
        except MoldRefused as refused:
            faults = remedied(mended, refused).faults
        except DesignError as error:
            faults = error.faults
    return "", "refused"


def remedies_of(fault: Fault) -> Iterator[dict[str, object]]:
    """Changes that a refusal names, one change at a time, as values by their keys.

    >>> list(remedies_of(Fault("body.core.height_mm", 1.0, "at least 1.6 for it", "thicken it")))
    [{'body.core.height_mm': 1.6}]
    >>> list(remedies_of(Fault("plates.pitch_mm", 0.8, "wider", "set mold.wire_mm = 0")))
    [{'mold.wire_mm': 0.0}]
    """
    found = _CHANGE.findall(fault.remedy) or [
        (fault.key, each) for each in _BOUND.findall(fault.bound)
    ]
    for key, value in found:
        yield {key: value.strip("'") if value.startswith("'") else float(value)}


def reported(report: MoldData) -> Record:
    """Part of a mold's record that the bench stores."""
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

    design = load_design(case)
    return design, ["shipped", design.body.shape]
