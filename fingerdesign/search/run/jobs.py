"""From a study to its jobs: one a variant and scene; a variant that is no finger as an outcome."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from fingerdesign.analysis.summary import versions
from fingerdesign.checks.starter import find_scene
from fingerdesign.records.outcome import Failure, Outcome
from fingerdesign.search.run.evaluate import Job

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.search.study.file import Study
    from fingerdesign.search.study.variants import Variant

Planned = Job | Outcome  # an outcome: of a variant that is no finger
FUNDAMENTAL = "fundamental"


def study_scenes(study: Study, folder: Path | None = None) -> dict[str, Scene | None]:
    """The study's scenes by name; None: the fundamental case and the design's grips.

    A file lies in ``folder`` (None: the working directory). DesignError with a scene's faults.
    """
    if not study.study.scenes:
        return {FUNDAMENTAL: None}
    found: dict[str, Scene | None] = {}
    for name in study.study.scenes:
        beside = (folder or Path.cwd()) / name
        found[Path(name).stem] = find_scene(beside if beside.is_file() else name)
    return found


def planned(
    study: Study, variants: Iterator[Variant], scenes: Mapping[str, Scene | None]
) -> Iterator[Planned]:
    """The jobs of each variant, a scene each, in order; an outcome where it is invalid."""
    for variant in variants:
        yield from planned_variant(study, variant, scenes)


def planned_variant(
    study: Study, variant: Variant, scenes: Mapping[str, Scene | None]
) -> list[Planned]:
    """The jobs of one variant, a scene each; one outcome where it is invalid."""
    if variant.design is None:
        return [_invalid(study, variant)]
    table = study.study
    return [
        Job(
            name=variant.name,
            design=variant.design,
            cost=study.cost,
            values=variant.values,
            scene=scene,
            scene_name=name,
            fidelity=table.fidelity,
            tolerance=table.tolerance,
        )
        for name, scene in scenes.items()
    ]


def _invalid(study: Study, variant: Variant) -> Outcome:
    """The outcome of a variant that is no finger; its digest is of the values and their base."""
    reported = json.dumps([study.study.base, study.fixed, variant.values], default=str)
    return Outcome(
        digest=hashlib.sha256(f"invalid\n{reported}".encode()).hexdigest(),
        name=variant.name,
        values=dict(variant.values),
        design={},
        scene="",
        fidelity=study.study.fidelity,
        status="failed",
        failure=Failure("invalid", "\n".join(str(fault) for fault in variant.faults)),
        versions=versions(),
    )
