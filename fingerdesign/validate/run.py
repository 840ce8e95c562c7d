"""All assumptions of one design in one scene, and the folder that a user opens.

validation = validate(design, scene)
validation.row("plane_strain").advice
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

from fingerdesign.analysis.case import Case, fundamental_scene, result_digest
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, FingerDesignError
from fingerdesign.records.folder import RecordFolder
from fingerdesign.report.page import paragraphs
from fingerdesign.runtime.machine import largest_memory_MB
from fingerdesign.runtime.registry import unknown_name
from fingerdesign.validate.advice import TEMPLATES, advise
from fingerdesign.validate.assumptions import ASSUMPTIONS, Assumption, NotTestable
from fingerdesign.validate.page import chart_png, validate_html
from fingerdesign.validate.record import (
    CSV_FILE,
    RECORD_FILE,
    THRESHOLDS,
    Row,
    Validation,
    worst_side,
)
from fingerdesign.validate.solves import Solves, warm
from fingerdesign.version import versions

Report = Callable[[str, float], None]

PAGE_FILE, CHART_FILE = "validate.html", "validate.png"
FOLDER = RecordFolder("validation", RECORD_FILE, (RECORD_FILE, CSV_FILE, PAGE_FILE, CHART_FILE))


def validate(
    design: Design,
    scene: Scene | None = None,
    *,
    deep: bool = False,
    scene_name: str = "",
    keys: Sequence[str] = (),
    report: Report = lambda message, fraction: None,
) -> Validation:
    """Report the cost of each assumption, or of ``keys`` alone. ``scene`` None: fundamental case.

    deep: finite strain in three dimensions too. An assumption that this design cannot tell of, or
    one of whose models fails, is a row that says so. status is "failed", with ``failure``, where a
    model failed and no assumption was reported; "ok" where there is merely nothing to report.
    Raises DesignError for a wrong input.
    """
    chosen = _chosen(keys)
    name = scene_name or ("fundamental" if scene is None else "scene")
    scene = fundamental_scene(design) if scene is None else scene
    # The models here are of their own sizes: that the design's mesh asks for more is no fault.
    refuse(Case(design, scene, grips=False, fields=False, go_on=True), scene)
    start = time.perf_counter()
    done = 0

    def say(message: str) -> None:
        report(message, done / len(chosen))

    solves = Solves(design, scene, say)
    rows, failed = list[Row](), list[Row]()
    say("loading")
    warm()
    for each in chosen:
        rows.append(_row(each, solves, deep, failed))
        done += 1
    solves.release()
    failure = _failure(rows, failed)
    return Validation(
        schema_version=1,
        design=design.design.name,
        scene=name,
        digest=result_digest(design, scene, "validate"),
        status="ok" if failure is None else "failed",
        failure=failure,
        deep=deep,
        gages=design.plates.number,
        thresholds=THRESHOLDS,
        assumptions=tuple(rows),
        seconds=time.perf_counter() - start,
        peak_memory_MB=largest_memory_MB(),
        versions=versions(),
    )


def write_validation(validation: Validation, folder: Path) -> None:
    """All products into a folder that exists; the record comes last."""
    (folder / CHART_FILE).write_bytes(chart_png(validation))
    (folder / PAGE_FILE).write_text(validate_html(validation), encoding="utf-8")
    (folder / CSV_FILE).write_text(validation.to_csv(), encoding="utf-8")
    (folder / RECORD_FILE).write_text(validation.to_json(), encoding="utf-8")


def _chosen(keys: Sequence[str]) -> list[Assumption]:
    """The assumptions of these keys, all without any. DesignError for an unknown one."""
    known = [each.key for each in ASSUMPTIONS]
    if faults := [unknown_name(key, "--only", known) for key in keys if key not in known]:
        raise DesignError(faults)
    return [each for each in ASSUMPTIONS if not keys or each.key in keys]


def _failure(rows: Sequence[Row], failed: Sequence[Row]) -> str | None:
    """The reasons of all failures where no assumption was tested; None else."""
    if not failed or any(row.tested for row in rows):
        return None
    reasons = "; ".join(f"{row.title}: {row.reason}" for row in failed)
    return f"no assumption could be tested: {reasons}"


def _row(of: Assumption, solves: Solves, deep: bool, failed: list[Row]) -> Row:
    """The row of an assumption; one whose models failed goes to ``failed`` too."""
    try:
        comparisons = of.pairs(solves, deep)
    except FingerDesignError as error:
        row = untested_row(of, "; ".join(str(error).splitlines()).rstrip("."))
        if not isinstance(error, NotTestable):
            failed.append(row)
        return row
    if not any(each.equal_motion or each.equal_force for each in comparisons):
        why = "; ".join(chain.from_iterable(each.missing for each in comparisons))
        failed.append(untested_row(of, why))
        return failed[-1]
    verdict, words = advise(of.kind, comparisons, gages=solves.design.plates.number > 0)
    most = max(comparisons, key=lambda each: each.better.seconds)
    seconds, better = most.assumed.seconds, most.better.seconds
    value = of.kind == "value"  # the better one is the design's, and another value costs the same
    return replace(
        untested_row(of, ""),
        tested=True,
        reason=None,
        seconds=better if value else seconds,
        better_seconds=None if value else better,
        saving=None if value else better / max(seconds, 1e-9),
        equal_motion=worst_side([each.equal_motion for each in comparisons]),
        equal_force=worst_side([each.equal_force for each in comparisons]),
        verdict=verdict,
        advice=words,
        comparisons=tuple(comparisons),
    )


def untested_row(of: Assumption, reason: str) -> Row:
    """The row of an assumption that could not be tested."""
    title, assumed, better = paragraphs(TEMPLATES / "assumptions.toml", of.key)
    nothing = dict.fromkeys(("seconds", "better_seconds", "saving", "equal_motion", "equal_force"))
    return Row(
        assumption=of.key,
        title=title,
        assumed=assumed,
        better=better,
        kind=of.kind,
        tested=False,
        reason=reason,
        verdict="not tested",
        advice=f"Not tested: {reason}.",
        comparisons=(),
        **nothing,
    )
