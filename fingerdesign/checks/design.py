"""Faults of a design's geometry, each with the worst value, the plates (numbered from 0, row by
row) and a computed remedy.

One fault for one cause. Everything is in closed form; nothing here loads a CAD kernel.
"""

from dataclasses import replace

from fingerdesign.checks.body import body_faults, sound_outline
from fingerdesign.checks.grip import grip_faults
from fingerdesign.checks.meshing import mesh_faults
from fingerdesign.checks.placing import placing_findings
from fingerdesign.checks.plates import gage_faults, plate_faults
from fingerdesign.checks.remedies import Misplacement
from fingerdesign.checks.spacing import spacing_findings
from fingerdesign.design.mesh import mesh_file_faults
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.layout.row_keys import with_key


def design_faults(design: Design) -> list[Fault]:
    """Find every fault of the geometry of a design whose keys are sound; empty when it can be
    built.

    Where plates lie is judged in a body that can exist, with a core that fits into it; of any
    other, what plates and gages are by themselves.
    """
    body = body_faults(design.body)
    faults = body + _beside_body(design)
    if not design.plates.number:
        return faults
    shaped = all(fault.key.startswith("body.core.") for fault in body)
    left_out: dict[str, object] = {"core": None} if body else {}
    if not shaped:  # below a flat top
        left_out |= {"shape": "block", "edge_radius_mm": None, "dome_radius_mm": None}
    rest = design.model_copy(update={"body": design.body.model_copy(update=left_out)})
    own = _of_plates(rest)
    blamed = {fault.key for fault in own}
    placed = placing_faults(rest) if shaped else []
    return faults + own + [fault for fault in placed if fault.key not in blamed]


def placing_faults(design: Design) -> list[Fault]:
    """Find every fault of where the plates lie in a sound body, with remedies that have been
    tried."""

    def keys(trial: Design) -> set[str]:
        wrong = body_faults(trial.body)
        if wrong or not sound_outline(trial.body):
            return {fault.key for fault in wrong} | {"body"}
        return {each.key for each in _findings(trial)} | {each.key for each in _of_plates(trial)}

    every = _findings(design)
    before = {found.key for found in every}
    faults = [found.fault(design, before, keys) for found in every]
    # Followed together, one remedy may want more of another: that of a second round, if it does.
    trial = _followed(design, faults)
    if trial is None or not keys(trial) <= before:
        return faults
    again = {found.key: found.fault(design, before, keys) for found in _findings(trial)}
    pairs = [(each, again.get(each.key, each)) for each in faults]
    joint = [replace(each, remedy=more.remedy, mends=more.mends) for each, more in pairs]
    mended = _followed(design, joint)
    return faults if mended is None or keys(mended) else joint


def _followed(design: Design, faults: list[Fault]) -> Design | None:
    """Return the design with the first remedy of each fault; None where one has none."""
    trial: Design | None = design
    for fault in faults:
        if trial is None or not fault.mends:
            return None
        trial = with_key(trial, *next(iter(fault.mends.items())))
    return trial


def is_sound(design: Design) -> bool:
    """Tell whether :func:`design_faults` finds nothing; faster where it does, for it seeks no
    remedy."""
    if body_faults(design.body) or _beside_body(design):
        return False
    return not (design.plates.number and (_of_plates(design) or _findings(design)))


def _beside_body(design: Design) -> list[Fault]:
    return mesh_faults(design) + grip_faults(design) + mesh_file_faults(design.mesh)


def _of_plates(design: Design) -> list[Fault]:
    return plate_faults(design) + gage_faults(design)


def _findings(design: Design) -> list[Misplacement]:
    return placing_findings(design) + spacing_findings(design)
