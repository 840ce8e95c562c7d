"""Accepted meshes, cached by content: fTetWild never makes the same mesh twice.

The folder is that of the environment variable FINGERDESIGN_CACHE, or the platform's cache folder.
The name of a mesh is the digest of all its inputs: geometry, sizes, zone and versions; not
the materials.
"""

import hashlib
import json
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.digest import content_digest
from fingerdesign.design.schema import Design
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.sizing import MeshSizes
from fingerdesign.mesh.types import Mesh
from fingerdesign.runtime.cache import GARBLED, Cache
from fingerdesign.version import __version__

FORMAT = 6  # raise it when the way from CAD to mesh changes
MOST_MESHES = 300  # meshes of a few MB each; the longest unused go first


def mesh_key(design: Design, sizes: MeshSizes, zone: Zone, symmetric: bool) -> str:
    """SHA-256, in hexadecimal, of what a tetrahedral mesh depends on."""
    body = design.body
    core = body.core.model_copy(update={"material": ""}) if body.core is not None else None
    bare = body.model_copy(update={"material": "", "core": core})
    content = {
        "format": FORMAT,
        "versions": [__version__, version("pytetwild")],
        "body": content_digest(bare),
        "plates": [asdict(frame) for frame in plate_frames(design)],
        "model": design.plates.model,
        "sizes": asdict(sizes),
        "zone_mm": asdict(zone),
        "symmetric": symmetric,
    }
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def load_mesh(key: str) -> Mesh | None:
    """The mesh cached under a key, or None: there is none, or its file cannot be read."""
    found = _cache().arrays(f"{key}.npz")
    if found is None:
        return None
    data, about = found
    try:
        mesh = Mesh(
            points=data["points"],
            cells=data["cells"].astype(np.int64),
            regions=data["regions"].astype(np.int64),
            facets={name: data[f"facets_{name}"].astype(np.int64) for name in about["facets"]},
            mesher=about["mesher"],
            symmetric=about["symmetric"],
            notes=about["notes"],
            region_names={int(k): name for k, name in about["region_names"].items()},
        )
        _check(mesh)
    except GARBLED:
        return None
    return mesh


def _cache() -> Cache:
    return Cache("meshes", MOST_MESHES)


def _check(mesh: Mesh) -> None:
    """Raise ValueError where arrays do not fit together: a file that somebody changed."""
    nodes, dim = mesh.points.shape
    numbers = [mesh.cells, *mesh.facets.values()]
    if not (
        nodes > 0
        and np.isfinite(mesh.points).all()
        and mesh.cells.ndim == 2
        and mesh.cells.shape[1] == {2: 6, 3: 10}[dim]
        and mesh.regions.shape == (len(mesh.cells),)
        and mesh.regions.min() >= 0
        and all(rows.ndim == 2 and rows.min() >= 0 and rows.max() < nodes for rows in numbers)
    ):
        raise ValueError("the arrays of a cached mesh do not fit together")


def store_mesh(key: str, mesh: Mesh) -> bool:
    """Store a mesh under a key; False where the folder cannot be written (the work goes on)."""
    about = {
        "facets": sorted(mesh.facets),
        "mesher": mesh.mesher,
        "symmetric": mesh.symmetric,
        "notes": mesh.notes,
        "region_names": mesh.region_names,
    }
    arrays: dict[str, NDArray[Any]] = {
        "points": mesh.points,
        "cells": mesh.cells.astype(np.int32),
        "regions": mesh.regions.astype(np.int32),
        **{f"facets_{name}": rows.astype(np.int32) for name, rows in mesh.facets.items()},
    }
    return _cache().put_arrays(f"{key}.npz", arrays, about)
