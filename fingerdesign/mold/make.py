"""The making of a mold: from a design to the folder that a caster opens.

design ─▶ plan ─▶ exact parts (STEP, STL) ─▶ checks ─▶ 3MF, DXF, bill, notes ─▶ report
             └─▶ placement's effect, concurrently           └─▶ picture, concurrently

report = write_mold(design, out / name)
"""

import errno
import json
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fingerdesign.analysis.case import Clock
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, FingerDesignError, GeometryError, PictureError
from fingerdesign.layout.fitting import gage_fit
from fingerdesign.mold.aids import aids_of
from fingerdesign.mold.checks.run import run_checks
from fingerdesign.mold.page import mold_html
from fingerdesign.mold.part import MoldMeshes
from fingerdesign.mold.picture import Pictures, pictures_job, pictures_of
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.plan.refusals import MoldRefused
from fingerdesign.mold.plan.remedies import remedied
from fingerdesign.mold.products.bill import bill_of_materials, write_bill
from fingerdesign.mold.products.casting import casting_of
from fingerdesign.mold.products.drawing import write_drawings
from fingerdesign.mold.products.notes import casting_notes, unknown_effect
from fingerdesign.mold.products.three_mf import write_3mf
from fingerdesign.mold.profile import PROFILE_FILE, profile_text
from fingerdesign.mold.record import RECORD_FILE, MoldData, Outcome, mold_record
from fingerdesign.records.base import ResultError, json_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.runtime.isolate import ProcessError, Wait, call, concurrently

Report = Callable[[str, float], None]

REPORT_FILE, PICTURE_FILE = "report.html", "exploded.png"
PRINT_FILE, COUPON_FILE, BILL_FILE = "mold.3mf", "coupon.3mf", "bill_of_materials.csv"
_STEMS = (
    *("contact_insert", "frame_*", "end_wall_*", "side_wall_*", "comb_*"),
    *("base_plate", "base_frame", "core", "plate_*", "coupon*", "finger", "mount", "spacer"),
)
FOLDER = RecordFolder(
    "mold",
    RECORD_FILE,
    (
        *(RECORD_FILE, REPORT_FILE, PICTURE_FILE, "assembly.step"),
        *(BILL_FILE, PRINT_FILE, COUPON_FILE, PROFILE_FILE, "plates.dxf", "nested_*.dxf"),
        *("comb_*.dxf", "coupon_comb_*.dxf", "mount.dxf"),
        *(f"{stem}.{kind}" for stem in _STEMS for kind in ("stl", "step")),
    ),
)
# Plates' places take 1 to 4 s, leads 10, in tetrahedra 70 to 150; a busy machine far longer.
EFFECT_LIMIT_S = 600.0
CAD_LIMIT_S = 300.0  # ten times what a mold of many plates takes on a busy machine

_PROBE_BYTES = 2**22  # what a disk must still take for a file to have failed for another reason


def write_mold(
    design: Design, target: Path | str, report: Report = lambda message, fraction: None
) -> MoldData:
    """Make a mold into the folder ``target``, which is replaced once the new one is whole.

    DesignError names every fault with its remedies. ResultError where ``target`` holds what is no
    mold, or the disk is full: an older mold then stays as it was.
    """
    target = Path(target).absolute()
    FOLDER.refuse_foreign(target)
    try:
        with FOLDER.written(target) as folder:
            return make_mold(design, folder, report)
    except MoldRefused as refused:
        raise remedied(design, refused) from None
    except OSError as error:
        older = "; the older mold is as it was" if target.is_dir() else ""
        raise ResultError(
            f"{target} was not written: {error.strerror or error}{older}; free space there and in "
            f"{tempfile.gettempdir()}, or choose another --out"
        ) from error


def older_passed(target: Path | str) -> bool:
    """True where a mold is there whose checks all passed."""
    try:
        record = json.loads((Path(target) / RECORD_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(record, dict) and record.get("status") == "ok"


def make_mold(
    design: Design, folder: Path | str, report: Report = lambda message, fraction: None
) -> MoldData:
    """Make a mold's files into a folder that exists; ``status`` of the record says how it went.

    MoldRefused, before anything is written, names every reason why this finger can't be molded so,
    with general remedies; ``write_mold`` adds those that were tried.
    What the CAD kernel cannot build, and checks that fail, are in the record as its ``failure``;
    record and report are written all the same. A disk that is full is an OSError or a ResultError,
    and no record. TypeError for what is no design.
    """
    if not isinstance(design, Design):
        raise TypeError(
            f"make_mold takes a Design, not {type(design).__name__}: read one with load_design"
        )
    folder, clock, start = Path(folder), Clock(), time.perf_counter()
    if not folder.is_dir():
        raise ResultError(f"{folder} is no folder: make it before, or use write_mold")
    report("planning", 0.0)
    with clock.stage("plan"):
        outcome = Outcome(plan_mold(design), gage_fit(design))
    effect = "fingerdesign.mold.ready:placement_with_fixes"
    leads = "fingerdesign.mold.leads:leads_effect"
    type_ = None if outcome.fit is None else outcome.fit.found
    pictures, missing = None, "There are no parts to draw."
    with (
        concurrently(effect, design, outcome.plan, time_s=EFFECT_LIMIT_S) as placing,
        concurrently(leads, design, type_, time_s=EFFECT_LIMIT_S) as leading,
    ):
        try:
            pictures, missing = _make(outcome, folder, (placing, leading), clock, report)
        except GeometryError as error:
            _refuse_full(folder, error)
            for path in folder.iterdir():
                path.unlink()
            outcome.placement, outcome.leads, outcome.casting = None, None, None
            outcome.items, outcome.notes = (), ()
            outcome.broken = " ".join(str(error).split())
    files = sorted({path.name for path in folder.iterdir()} | {RECORD_FILE, REPORT_FILE})
    record = mold_record(outcome, files, clock.seconds, time.perf_counter() - start)
    (folder / REPORT_FILE).write_text(mold_html(record, pictures, missing), encoding="utf-8")
    (folder / RECORD_FILE).write_text(json_text(record), encoding="utf-8")
    return record


def _make(
    outcome: Outcome, folder: Path, effects: tuple[Wait, Wait], clock: Clock, report: Report
) -> tuple[Pictures | None, str]:
    """Make all files but report and record; the pictures, or why there are none."""
    plan, design = outcome.plan, outcome.plan.design
    report("building the parts", 0.05)
    with clock.stage("cad"):
        meshes = mold_meshes(plan, folder)
    casting = casting_of(plan, meshes, outcome.fit)
    notes, views = casting_notes(casting)
    with pictures_job(meshes, views, aids_of(casting)) as drawing:
        report("checking the parts", 0.45)
        with clock.stage("checks"):
            outcome.checks = run_checks(plan, meshes)
        report("writing the files", 0.8)
        with clock.stage("files"):
            outcome.items = bill_of_materials(casting)
            outcome.casting, outcome.notes = casting, notes
            write_bill(outcome.items, folder / BILL_FILE)
            write_3mf(casting.posed, folder / PRINT_FILE, f"{design.design.name}: mold")
            write_3mf(casting.coupon, folder / COUPON_FILE, f"{design.design.name}: coupon")
            write_drawings(casting, folder)
            (folder / PROFILE_FILE).write_text(profile_text(design), encoding="utf-8")
        with clock.stage("placement"):
            outcome.placement = _effect_of(effects[0], "the plates' tolerance does")
        with clock.stage("leads"):
            outcome.leads = _effect_of(effects[1], "the leads do")
        report("writing the report", 0.9)
        with clock.stage("picture"):
            try:
                pictures = pictures_of(drawing, meshes, views)
            except PictureError as error:
                return None, f"The mold could not be drawn: {error}."
            (folder / PICTURE_FILE).write_bytes(pictures.opened.png)
    return pictures, ""


def mold_meshes(plan: MoldPlan, folder: Path, time_limit_s: float = CAD_LIMIT_S) -> MoldMeshes:
    """Build a planned mold in a process of its own, and write its CAD files into ``folder``.

    The kernel is native code that can hang or crash; there it can harm nobody. Files, in mold
    coordinates: NAME.stl and NAME.step of every part and of every different plate, assembly.step.
    GeometryError where a part could not be demoulded or built, or where the kernel crashes or
    exceeds the time limit. ResultError where the disk or the memory is full, or somebody ended the
    process.
    """
    build, name = "fingerdesign.mold.cad.write:build_and_write", plan.design.design.name
    try:
        found: MoldMeshes = call(build, plan, folder.resolve(), time_s=time_limit_s)
    except DesignError as error:
        raise GeometryError(str(error)) from error
    except ProcessError as error:
        if error.machine:
            raise ResultError(
                f"the mold of {name} was not built: {error}; free disk and memory and try again"
            ) from error
        why = f"the CAD kernel did not build the mold of {name}: {error}"
        raise GeometryError(why) from error
    return found


def _effect_of(wait: Wait, of: str) -> dict[str, Any]:
    """Wait for an effect on the readings; where its process failed, a record says how."""
    try:
        found: dict[str, Any] = wait()
    except FingerDesignError as error:
        return unknown_effect(f"its analysis failed: {error}", of)
    return found


def _refuse_full(folder: Path, error: BaseException) -> None:
    """Raise the OSError that is behind an error, or that writing into the folder gives now: that
    is no finding about the mold."""
    behind: BaseException | None = error
    while behind is not None:
        if isinstance(behind, OSError):
            raise OSError(behind.errno or errno.EIO, behind.strerror or str(behind)) from error
        behind = behind.__cause__
    with tempfile.TemporaryFile(dir=folder) as stream:
        stream.write(bytes(_PROBE_BYTES))
        stream.flush()
        os.fsync(stream.fileno())
