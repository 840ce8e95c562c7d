"""The effect of placement in a process: ``python -m fingerdesign.mold.placement_worker FOLDER``.

In FOLDER it finds design.json and plan.pickle (a MoldPlan), and leaves placement.json.
"""

from __future__ import annotations

import json
import pickle
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.design.schema import Design
from fingerdesign.runtime.process import ProcessError, WorkerJob, die_with_parent

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.plan.plan import MoldPlan

TIME_LIMIT_S = 60.0  # it takes 1 to 4 s; a busy machine far longer


def placement_job(design: Design, plan: MoldPlan, time_limit_s: float = TIME_LIMIT_S) -> WorkerJob:
    """The job; enter it to start the process, and give it to :func:`placement_of`."""
    return WorkerJob(__name__, _request(design, plan), time_limit_s)


def placement_of(job: WorkerJob) -> dict[str, Any]:
    """What ``placement.placement_effect`` found, or a record that says how its process failed."""
    try:
        folder = job.finished()
    except ProcessError as error:
        reason = f"its analysis failed: {error}"
        sentence = f"What the plates' tolerance does to the gages is not known: {reason}."
        return {"reason": reason, "sentences": [sentence]}
    found: dict[str, Any] = json.loads((folder / "placement.json").read_text("utf-8"))
    return found


def _request(design: Design, plan: MoldPlan) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        (folder / "design.json").write_text(design.model_dump_json(), "utf-8")
        (folder / "plan.pickle").write_bytes(pickle.dumps(plan))

    return write


def main(arguments: Sequence[str]) -> int:
    """Answer one request."""
    die_with_parent()
    folder = Path(arguments[0])
    from fingerdesign.mold.placement import placement_effect

    design = Design.model_validate_json((folder / "design.json").read_text("utf-8"))
    plan = pickle.loads((folder / "plan.pickle").read_bytes())
    found = placement_effect(design, plan)
    (folder / "placement.json").write_text(json.dumps(found, allow_nan=False), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
