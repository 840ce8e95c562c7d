"""The process that runs fTetWild: ``python -m fingerdesign.mesh.tetra.worker IN.npz OUT.npz``.

fTetWild can crash, hang and write into its working directory, so it runs here, alone, and whoever
started this process waits for it with a time limit. Only this file imports pytetwild.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from fingerdesign.mesh.worker import die_with_parent


def main(arguments: list[str]) -> int:
    """Read surface, background grid and options, tetrahedralise, write points and tetrahedra."""
    import numpy as np
    import pytetwild

    die_with_parent()
    source, target = Path(arguments[0]), Path(arguments[1])
    with np.load(source) as data:
        options = json.loads(str(data["options"]))
        points, tets = pytetwild.tetrahedralize(
            data["vertices"],
            data["triangles"].astype(np.int32),
            bg_vertices=data["grid_points"],
            bg_tets=data["grid_tets"],
            bg_values=data["grid_values"],
            quiet=True,
            **options,
        )
    aside = target.with_suffix(".part.npz")
    np.savez(aside, points=points, tets=tets)
    aside.rename(target)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
