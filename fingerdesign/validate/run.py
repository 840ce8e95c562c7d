"""All assumptions of one design in one scene, and the folder that a user opens.

validation = validate(design, scene)
validation.row("plane_strain").advice
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from fingerdesign.case import Case, fundamental_scene
from fingerdesign.errors import DesignError, Fault, FingerDesignError
from fingerdesign.identity import result_digest, versions
from fingerdesign.refusals import refuse
from fingerdesign.validate.advice import advise, off_middle
from fingerdesign.validate.assumptions import ASSUMPTIONS, Assumption, profile_along_z
from fingerdesign.validate.record import (
    CSV_FILE,
    RECORD_FILE,
    Row,
    Validation,
    compared_row,
    untested_row,
    write_csv,
)
from fingerdesign.validate.solves import Solves, warm

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design

Tell = Callable[[str, float], None]

PAGE_FILE, CHART_FILE = "validate.html", "validate.png"
PRODUCTS = (RECORD_FILE, CSV_FILE, PAGE_FILE, CHART_FILE)


def validate(
    design: Design,
    scene: Scene | None = None,
    *,
    deep: bool = False,
    scene_name: str = "",
    keys: Sequence[str] = (),
    tell: Tell = lambda message, fraction: None,
) -> Validation:
    """What each assumption costs; ``keys``: of these alone. ``scene`` None: the fundamental case.

    deep: finite strain in three dimensions too. An assumption that this design cannot tell of, or
    one of whose models fails, is a row that says so. Raises DesignError for a wrong input.
    """
    chosen = [each for each in ASSUMPTIONS if not keys or each.key in keys]
    _refuse_unknown(keys)
    name = scene_name or ("fundamental" if scene is None else "scene")
    scene = fundamental_scene() if scene is None else scene
    # The models here are of their own sizes: that the design's mesh asks for more is no fault.
    refuse(Case(design, scene, grips=False, fields=False, go_on=True), scene)
    start = time.perf_counter()
    done = 0

    def say(message: str) -> None:
        tell(message, done / len(chosen))

    solves, rows = Solves(design, scene, say), []
    say("loading")
    warm()
    for each in chosen:
        rows.append(_row(each, solves, deep))
        done += 1
    solves.release()
    from fingerdesign.summaries import peak_memory_MB

    return Validation(
        design=design.design.name,
        scene=name,
        digest=result_digest(design, scene, "validate"),
        deep=deep,
        gages=design.plates.number,
        rows=tuple(rows),
        seconds=time.perf_counter() - start,
        versions=versions(),
        peak_memory_MB=peak_memory_MB(),
    )


def write_validation(validation: Validation, folder: Path) -> None:
    """All products into a folder that exists; the record comes last."""
    from fingerdesign.report.figures_validate import chart_png
    from fingerdesign.report.validate_html import validate_html

    data = validation.data()
    (folder / CHART_FILE).write_bytes(chart_png(data))
    (folder / PAGE_FILE).write_text(validate_html(data), encoding="utf-8")
    write_csv(folder / CSV_FILE, validation)
    (folder / RECORD_FILE).write_text(validation.to_json(), encoding="utf-8")


def _row(of: Assumption, solves: Solves, deep: bool) -> Row:
    try:
        comparisons = of.pairs(solves, deep)
    except FingerDesignError as error:
        return untested_row(of, _one_line(error))
    if all(each.motion is None and each.force is None for each in comparisons):
        return untested_row(of, "; ".join(each for c in comparisons for each in c.missing))
    advice = advise(of.kind, comparisons, gages=solves.design.plates.number > 0)
    profile = profile_along_z(solves) if of.key == "plane_strain" else None
    words = advice.sentence if profile is None else f"{advice.sentence} {off_middle(profile)}"
    return compared_row(of, comparisons, advice.verdict, words, profile)


def _one_line(error: FingerDesignError) -> str:
    return "; ".join(str(error).splitlines()).rstrip(".")


def _refuse_unknown(keys: Sequence[str]) -> None:
    known = [each.key for each in ASSUMPTIONS]
    faults = [
        Fault("--only", key, f"one of {', '.join(known)}", "choose one of them")
        for key in keys
        if key not in known
    ]
    if faults:
        raise DesignError(faults)
