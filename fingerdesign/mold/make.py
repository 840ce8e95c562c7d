"""The story of a mold: from a design to the folder that a caster opens.

design ─▶ plan ─▶ exact parts (STEP, STL) ─▶ checks ─▶ 3MF, DXF, bill, notes ─▶ report
             └─▶ placement's effect, beside                 └─▶ picture, beside the checks

report = write_mold(design, out / name)
"""

from __future__ import annotations

import errno
import json
import os
import re
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.analysis.summary import peak_memory_MB
from fingerdesign.design.schema import Design
from fingerdesign.errors import FingerDesignError, GeometryError, PictureError
from fingerdesign.mold.cad.built import mold_meshes
from fingerdesign.mold.page.picture import exploded_job, exploded_of
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.products.products import write_products
from fingerdesign.mold.record import (
    RECORD_FILE,
    MoldReport,
    base_data,
    checks_data,
    fixture_data,
    mold_digest,
    mold_versions,
    placement_rows,
    process_data,
    write_record,
)
from fingerdesign.records.folder import RecordFolder
from fingerdesign.records.result import ResultError
from fingerdesign.runtime.files import DAY_S, sweep_abandoned, swept
from fingerdesign.runtime.isolate import beside

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.page.picture import Exploded
    from fingerdesign.mold.part import Check
    from fingerdesign.mold.plan.plan import MoldPlan
    from fingerdesign.runtime.isolate import Job

Report = Callable[[str, float], None]

REPORT_FILE, PICTURE_FILE = "report.html", "exploded.png"
_STEMS = ("contact_insert", "end_wall_*", "side_wall_*", "comb_*", "jig_*", "base_plate", "core")
FOLDER = RecordFolder(
    "mold",
    RECORD_FILE,
    (
        *(RECORD_FILE, REPORT_FILE, PICTURE_FILE, "assembly.step"),
        *("bill_of_materials.csv", "mold.3mf", "plates.dxf", "comb_*.dxf", "jig_*.dxf"),
        *(f"{stem}.{kind}" for stem in (*_STEMS, "plate_*", "rubber") for kind in ("stl", "step")),
    ),
)
PLACEMENT_LIMIT_S = 60.0  # it takes 1 to 4 s; a busy machine far longer
CAD_LIMIT_S = 300.0  # ten times what a mold of many plates takes on a busy machine


_PROBE_BYTES = 2**22  # what a disk must still take for a file to have failed for another reason


@dataclass
class Clock:
    """Seconds of each stage, and since it was made."""

    stages: dict[str, float] = field(default_factory=dict)
    start: float = field(default_factory=time.perf_counter)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the block's time under a name."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.stages[name] = self.stages.get(name, 0.0) + time.perf_counter() - start

    @property
    def seconds(self) -> float:
        """Since it was made."""
        return time.perf_counter() - self.start


def write_mold(
    design: Design, target: Path | str, report: Report = lambda message, fraction: None
) -> MoldReport:
    """Make a mold into the folder ``target``, which is replaced once the new one is whole.

    DesignError as :func:`make_mold`. ResultError where ``target`` holds what is no mold, or the
    disk is full: an older mold then stays as it was.
    """
    target = Path(target).absolute()
    FOLDER.refuse_foreign(target)
    sweep_abandoned(target)
    swept(Path(tempfile.gettempdir()), re.compile(r"fingerdesign-mold-\w{8}"), DAY_S)
    try:
        with FOLDER.written(target) as folder:
            return make_mold(design, folder, report)
    except OSError as error:
        older = "; the older mold is as it was" if target.is_dir() else ""
        raise ResultError(
            f"{target} was not written: {error.strerror or error}{older}; free space there and in "
            f"{tempfile.gettempdir()}, or choose another --out"
        ) from error


def placement_job(design: Design, plan: MoldPlan, time_limit_s: float = PLACEMENT_LIMIT_S) -> Job:
    """The effect of placement, found beside the CAD: enter it, and give it to
    :func:`placement_of`."""
    return beside("fingerdesign.mold.placement:placement_effect", design, plan, time_s=time_limit_s)


def placement_of(job: Job) -> dict[str, Any]:
    """What ``placement.placement_effect`` found, or a record that says how its process failed."""
    try:
        found: dict[str, Any] = job.result()
    except FingerDesignError as error:
        reason = f"its analysis failed: {error}"
        sentence = f"What the plates' tolerance does to the gages is not known: {reason}."
        return {"reason": reason, "sentences": [sentence]}
    return found


def older_passed(target: Path | str) -> bool:
    """Whether a mold is there whose checks all passed."""
    try:
        record = json.loads((Path(target) / RECORD_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(record, dict) and record.get("status") == "ok"


def make_mold(
    design: Design, folder: Path | str, report: Report = lambda message, fraction: None
) -> MoldReport:
    """Make a mold's files into a folder that exists; ``status`` of the record says how it went.

    DesignError, before anything is written, names every reason why this finger can't be molded so.
    What the CAD kernel cannot build, and checks that fail, are in the record as its ``failure``;
    record and report are written all the same. A disk that is full is an OSError or a ResultError,
    and no record. TypeError for what is no design.
    """
    if not isinstance(design, Design):
        raise TypeError(
            f"make_mold takes a Design, not {type(design).__name__}: read one with load_design"
        )
    folder, clock = Path(folder), Clock()
    if not folder.is_dir():
        raise ResultError(f"{folder} is no folder: make it before, or use write_mold")
    report("planning", 0.0)
    with clock.stage("plan"):
        plan = plan_mold(design)
    with placement_job(design, plan) as placing:
        try:
            return _made(design, plan, folder, placing, clock, report)
        except GeometryError as error:
            return _not_made(design, plan, folder, error, clock)


def _made(
    design: Design, plan: MoldPlan, folder: Path, placing: Job, clock: Clock, report: Report
) -> MoldReport:
    from fingerdesign.mold.checks import run_checks

    report("building the parts", 0.05)
    with clock.stage("cad"):
        meshes = mold_meshes(design, plan, folder, CAD_LIMIT_S)
    with exploded_job(meshes) as drawing:
        report("checking the parts", 0.45)
        with clock.stage("checks"):
            checks = run_checks(design, plan, meshes)
        report("writing the files", 0.8)
        try:
            with clock.stage("files"):
                products = write_products(design, plan, meshes, folder)
        except GeometryError as error:
            return _not_made(design, plan, folder, error, clock, checks)
        with clock.stage("placement"):
            placement = placement_of(placing)
        report("writing the report", 0.9)
        picture: Exploded | None = None
        missing = ""
        with clock.stage("picture"):
            try:
                picture = exploded_of(drawing, meshes)
                (folder / PICTURE_FILE).write_bytes(picture.png)
            except PictureError as error:
                missing = f"The mold could not be drawn: {error}."
    values = {
        "failure": failure_of(checks),
        **products.values(design, plan, meshes, checks, placement),
    }
    return _written(design, plan, folder, values, clock, picture, missing)


def _not_made(
    design: Design,
    plan: MoldPlan,
    folder: Path,
    error: GeometryError,
    clock: Clock,
    checks: tuple[Check, ...] = (),
) -> MoldReport:
    """The record and the report of a mold that could not be built; files that were begun go.

    OSError where it was the disk that failed: that is no finding about the mold.
    """
    _refuse_full(folder, error)
    for path in folder.iterdir():
        path.unlink()
    values: dict[str, Any] = dict.fromkeys(("parts", "plates", "notes", "bill"), ())
    values |= {"fixture": fixture_data(plan), "placements": placement_rows(plan, ())}
    values |= {"silicone": None, "placement": None, "warnings": ()}
    values["checks"] = checks_data(checks)
    reported = [" ".join(str(error).split()), failure_of(checks)]
    values["failure"] = "; ".join(each for each in reported if each)
    return _written(design, plan, folder, values, clock, None, "There are no parts to draw.")


def _refuse_full(folder: Path, error: BaseException) -> None:
    """Raise the OSError that is behind an error, or that writing into the folder gives now."""
    behind: BaseException | None = error
    while behind is not None:
        if isinstance(behind, OSError):
            raise OSError(behind.errno or errno.EIO, behind.strerror or str(behind)) from error
        behind = behind.__cause__
    with tempfile.TemporaryFile(dir=folder) as stream:
        stream.write(bytes(_PROBE_BYTES))
        stream.flush()
        os.fsync(stream.fileno())


def failure_of(checks: tuple[Check, ...]) -> str | None:
    """Which checks failed, as a sentence; None where all passed.

    >>> from fingerdesign.mold.part import Check
    >>> failure_of((Check("wall", "core", False, 0.5, 1.0, "mm", "its wall is 0.5 mm"),))
    '1 of 1 check failed: wall (core)'
    """
    failed = [check for check in checks if not check.ok]
    if not failed:
        return None
    names = [f"{check.name} ({check.part})" if check.part else check.name for check in failed]
    more = f" and {len(names) - 6} more" if len(names) > 6 else ""
    whole = f"{len(checks)} check{'' if len(checks) == 1 else 's'}"
    return f"{len(failed)} of {whole} failed: {', '.join(names[:6])}{more}"


def _written(
    design: Design,
    plan: MoldPlan,
    folder: Path,
    values: dict[str, Any],
    clock: Clock,
    picture: Exploded | None,
    missing: str,
) -> MoldReport:
    """Report and record into the folder. The page's own time is not yet known to either."""
    from fingerdesign.mold.page.page import mold_html

    names = {path.name for path in folder.iterdir()} | {RECORD_FILE, REPORT_FILE}
    report = MoldReport(
        base=base_data(plan),
        design=design.design.name,
        digest=mold_digest(design),
        design_digest=design.digest(),
        process=process_data(design),
        shrinkage=design.mold.shrinkage_used,
        scale=plan.scale,
        files=tuple(sorted(names)),
        timings_s=dict(clock.stages),
        seconds=clock.seconds,
        peak_memory_MB=peak_memory_MB(),
        versions=mold_versions(),
        **values,
    )
    page = mold_html(report.data(), picture, missing)
    (folder / REPORT_FILE).write_text(page, encoding="utf-8")
    write_record(report, folder)
    return report
