"""``fingerdesign bench molds``: molds of every shipped design and of random ones of every kind.

A case is a shipped design's name or the seed of a random one.
"""

import os
import re
import statistics
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import fingerdesign.mold
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import shipped_names
from fingerdesign.errors import DesignError, Fault
from fingerdesign.mold.make import make_mold
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.plan.refusals import MoldRefused
from fingerdesign.mold.plan.remedies import remedied
from fingerdesign.mold.record import MoldData
from fingerdesign.runtime.files import scratch
from fingerdesign.runtime.machine import usable_cores
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.any_finger.designs import kinds, parsed_design
from fingerdesign_bench.check import Check, Shown
from fingerdesign_bench.files import CRASHED, Record, apart, code_version, resumed
from fingerdesign_bench.machine import machine

TIME_LIMIT_S = 300.0  # of one mold, CAD and pictures and all: fifteen times the target
JOURNAL = "molds.sqlite"
# Targets: a share, two lengths and the seconds that a user waits for a mold.
MADE_SHARE, VOLUME_ERROR, CHORD_MM, SECONDS = 0.97, 1e-3, 0.01, 20.0
# Every check holds; refused before any CAD; made, but checks do not hold.
MADE, REFUSED, FAILED = "made", "refused", "failed"
ROUNDS = 3  # of remedies, where one leads to the next refusal
HEADINGS = ("kind", "designs", "made", "refused", "median s", "volume error")
_CHANGE = re.compile(r"(\w+(?:\.\w+)+)(?: = | to at (?:least|most) )('\w+'|[\d.]*\d)")
_BOUND = re.compile(r"^at (?:least|most) ([\d.]*\d)")


def measure_molds(folder: Path, report: Report, seeds: int, workers: int | None) -> Shown:
    """Make molds that ``folder`` has no record of yet: of shipped designs and ``seeds`` others."""
    begun, workers = machine(), workers or usable_cores()
    cases = {name: name for name in (*shipped_names(), *(str(seed) for seed in range(seeds)))}
    version = code_version(fingerdesign.mold)
    work = apart("fingerdesign_bench.any_finger.molds:mold_one", TIME_LIMIT_S)
    found = resumed(folder / JOURNAL, version, cases, work, report, words, workers)
    records = list(found.values())
    kinds = [
        [f"{cell:.3g}" if isinstance(cell, float) else str(cell) for cell in each.values()]
        for each in by_kind(records)
    ]
    return Shown(
        "Molds",
        checks_of(records, workers),
        begun,
        {
            "workers": workers,
            "kinds": by_kind(records),
            "designs": [{"case": case} | record for case, record in found.items()],
        },
        tables=[("Molds by kind", HEADINGS, kinds)],
        notes=[words(*each) for each in found.items() if each[1]["status"] != MADE],
    )


def checks_of(records: Sequence[Record], workers: int) -> list[Check]:
    """List the targets and what was measured, with ``workers`` at work at once."""
    count = {
        status: sum(each["status"] == status for each in records)
        for status in (MADE, FAILED, CRASHED)
    }
    # Refused designs of which no change that the refusal names makes a mold.
    unmended = [e for e in records if e["status"] == REFUSED and e.get("then") != MADE]

    def worst(name: str, statuses: tuple[str, ...] = (MADE, FAILED)) -> float:
        own = [each[name] for each in records if each["status"] in statuses]
        return max((float(each) for each in own if each is not None), default=0.0)

    slowest = worst("seconds", (MADE, FAILED, REFUSED))
    return [
        Check("designs without a mold", 1.0 - MADE_SHARE, 1.0 - count[MADE] / max(1, len(records))),
        Check("refusals whose remedies give no mold", 0, len(unmended)),
        Check("molds that fail a check", 0, count[FAILED]),
        Check("crashes and hangs", 0, count[CRASHED]),
        Check("cavity less plates against the finger's body", VOLUME_ERROR, worst("volume_error")),
        Check("chord on the contact surface", CHORD_MM, worst("insert_chord_mm"), "mm"),
        Check("chord on any part", CHORD_MM, worst("chord_mm"), "mm"),
        Check(f"slowest answer, {workers} at once", SECONDS, slowest, "s"),
    ]


def words(case: str, record: Record) -> str:
    """A design's record in a line."""
    kinds = f" ({', '.join(record['kinds'])})" if record.get("kinds") else ""
    name = f"{record.get('name', case)}{kinds}"
    if record["status"] == MADE:
        return f"{name}: {record['checks']} checks hold, {record['seconds']:.1f} s"
    if record["status"] == FAILED:
        return f"{name}: failed: {'; '.join(record['failed'])}"
    text = f"{name}: {record['status']}: {record['reason']}"
    return f"{text}; with {record['remedy']}: {record['then']}" if record.get("remedy") else text


def by_kind(records: Sequence[Record]) -> list[Record]:
    """Designs, made, refused, median seconds and greatest volume error of each kind."""
    groups: dict[str, list[Record]] = {}
    for each in records:
        for kind in each.get("kinds", ()):
            groups.setdefault(kind, []).append(each)
    rows = []
    for kind, mine in sorted(groups.items()):
        made = [each for each in mine if each["status"] == MADE]
        refused = sum(each["status"] == REFUSED for each in mine)
        seconds = statistics.median(each["seconds"] for each in made) if made else 0.0
        worst = max((each["volume_error"] or 0.0 for each in made), default=0.0)
        row = {"kind": kind, "designs": len(mine), "made": len(made), "refused": refused}
        rows.append({**row, "median_s": seconds, "volume_error": worst})
    return rows


def mold_one(case: str) -> Record:
    """Make a design's mold and throw it away; how it went, as plain values.

    seconds: from the design to the last file, without those to start Python and to draw the design;
    cpu_s: of this process and of those that it waited for, which a busy machine stretches less.
    """
    design, kinds = design_of(case)
    record: Record = {"name": design.design.name, "kinds": kinds}
    start, before = time.perf_counter(), sum(os.times()[:4])
    with scratch("bench") as folder:
        try:
            report = make_mold(design, folder)
        except MoldRefused as refused:
            error = remedied(design, refused)
            record["seconds"] = round(time.perf_counter() - start, 2)
            reason = " | ".join(str(fault) for fault in error.faults)
            remedy, then = after_remedies(design, error.faults)
            return record | {"status": REFUSED, "reason": reason, "remedy": remedy, "then": then}
    record["seconds"] = round(time.perf_counter() - start, 2)
    record["cpu_s"] = round(sum(os.times()[:4]) - before, 2)
    return record | reported(report)


def after_remedies(design: Design, faults: Sequence[Fault]) -> tuple[str, str]:
    """The first remedies of a refusal that lead to a plan ("key = value, ..."; "": none did), and
    what then becomes of the mold: "made", "failed" or "refused"."""
    tried: dict[str, object] = {}
    for _ in range(ROUNDS):
        for values in [values for fault in faults for values in remedies_of(fault)]:
            try:
                mended = with_values(design, tried | values)
                plan_mold(mended)
            except DesignError:
                continue
            setting = ", ".join(f"{key} = {value}" for key, value in (tried | values).items())
            with scratch("bench") as folder:
                return setting, str(reported(make_mold(mended, folder))["status"])
        for fault in faults:
            tried |= next(remedies_of(fault), {})
        try:
            plan_mold(mended := with_values(design, tried))
        except MoldRefused as refused:
            faults = remedied(mended, refused).faults
        except DesignError as error:
            faults = error.faults
    return "", REFUSED


def remedies_of(fault: Fault) -> Iterator[dict[str, object]]:
    """Changes that a refusal names, one change at a time, as values by their keys.

    >>> list(remedies_of(Fault("body.core.height_mm", 1.0, "at least 1.6 for it", "thicken it")))
    [{'body.core.height_mm': 1.6}]
    >>> list(remedies_of(Fault("plates.pitch_mm", 0.8, "wider", "set mold.wire_mm = 0")))
    [{'mold.wire_mm': 0.0}]
    """
    bounds = [(fault.key, each) for each in _BOUND.findall(fault.bound)]
    for key, value in _CHANGE.findall(fault.remedy) or bounds:
        yield {key: value.strip("'") if value.startswith("'") else float(value)}


def reported(report: MoldData) -> Record:
    """Part of a mold's record that the bench stores."""
    checks = report["checks"]
    wrong = [each["sentence"] for each in checks if not each["ok"]]
    if not wrong and report["status"] != "ok":
        wrong = [str(report["failure"])]  # nothing could be built, so nothing was checked

    def worst(name: str, part: str | None = None) -> float | None:
        own = [each for each in checks if each["name"] == name and part in (None, each["part"])]
        return max((e["measured"] for e in own if e["measured"] is not None), default=None)

    return {
        "status": FAILED if wrong else MADE,
        "failed": wrong,
        "checks": len(checks),
        "volume_error": worst("cavity is the finger"),
        "insert_chord_mm": worst("chord", "contact_insert"),
        "chord_mm": worst("chord"),
        "timings_s": report["timings_s"],
    }


def design_of(case: str) -> tuple[Design, list[str]]:
    """The design of a case, and its kinds: body, "edged", "cored", plates; or "shipped", body."""
    if case.isdigit():
        return parsed_design(int(case)), list(kinds(int(case)))
    design = load_design(case)
    return design, ["shipped", design.body.shape]
