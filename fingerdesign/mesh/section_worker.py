"""The process that runs netgen: ``python -m fingerdesign.mesh.section_worker IN.json OUT.npz``.

Native code: it runs here, alone, under the time limit of whoever started it. Only this file imports
netgen.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path


def main(arguments: list[str]) -> int:
    """Read the outline, make triangles, write points, triangles and domains."""
    import numpy as np
    from netgen.geom2d import SplineGeometry

    from fingerdesign.mesh.worker import die_with_parent

    die_with_parent()
    source, target = Path(arguments[0]), Path(arguments[1])
    outline = json.loads(source.read_text("utf-8"))
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
    aside = target.with_suffix(".part.npz")
    np.savez(
        aside,
        points=np.array(mesh.Coordinates(), dtype=float)[:, :2],
        triangles=np.asarray(elements["nodes"][:, :3], dtype=np.int64) - 1,
        domains=np.asarray(elements["index"], dtype=np.int64),
    )
    aside.rename(target)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
