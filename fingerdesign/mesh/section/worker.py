"""The process that runs netgen: ``python -m fingerdesign.mesh.section.worker``, asked over pipes.

Each line in is one outline as JSON. The answer is a line of JSON, {"points": n, "triangles": t},
then n x 2 doubles and t x 4 integers (three corners from 0, the domain), little-endian; or a line
{"error": words}, and the process ends. Native code: it runs here, alone, under the time limit of
whoever started it. Only this file imports netgen.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from typing import Any

from fingerdesign.mesh.worker import die_with_parent


def main() -> int:
    """Answer outlines until the input ends."""
    die_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who asks decides what an interruption means
    # Netgen may print: it gets a stream that goes nowhere, and the answers one of their own.
    answers = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    import netgen.geom2d  # noqa: F401  loaded while nobody waits for it yet

    for line in sys.stdin.buffer:
        try:
            points, table = mesh_outline(json.loads(line))
        except Exception as error:  # whatever netgen raises goes back in words
            words = f"{type(error).__name__}: {error}"[:300]
            answers.write(json.dumps({"error": words}).encode() + b"\n")
            return 0
        answers.write(json.dumps({"points": len(points), "triangles": len(table)}).encode() + b"\n")
        answers.write(points.tobytes())
        answers.write(table.tobytes())
        answers.flush()
    return 0


def mesh_outline(outline: dict[str, Any]) -> tuple[Any, Any]:
    """Points (n, 2) and triangles with their domain (t, 4) of an ``Outline.as_dict``."""
    import numpy as np
    from netgen.geom2d import SplineGeometry

    geometry = SplineGeometry()
    for x, y, size in outline["points"]:
        if size is None:
            geometry.AppendPoint(x, y)
        else:
            geometry.AppendPoint(x, y, maxh=size)
    for points, left, right, size in outline["curves"]:
        kind = "line" if len(points) == 2 else "spline3"
        geometry.Append([kind, *points], leftdomain=left, rightdomain=right, maxh=size)
    for domain, size in outline["domains"]:
        geometry.SetDomainMaxH(domain, size)
    mesh = geometry.GenerateMesh(maxh=outline["far_size"], grading=outline["gradation"])
    elements = mesh.Elements2D().NumPy()
    table = np.empty((len(elements), 4), dtype="<i8")
    table[:, :3] = elements["nodes"][:, :3]
    table[:, :3] -= 1
    table[:, 3] = elements["index"]
    where = np.ascontiguousarray(np.asarray(mesh.Coordinates(), dtype="<f8")[:, :2])
    return where, table


if __name__ == "__main__":
    sys.exit(main())
