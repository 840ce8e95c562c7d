"""Netgen run safely and often: a process that stays, with a time limit for each mesh, and a cache
of the triangulations by outline.

Starting Python and loading netgen takes longer than meshing a section, and a sweep meshes hundreds.
So the process is started once (``start_mesher`` does it ahead of need, without waiting) and called
again and again. One that crashes, fails or runs out of time is ended, and the next mesh starts
another. Each thread has its own: a process ends with the thread that started it. Only this file
imports netgen.
"""

import hashlib
import json
import threading
from importlib.metadata import version
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.measures import aspects
from fingerdesign.runtime.cache import Cache
from fingerdesign.runtime.isolate import ProcessError, Worker

_SLOWER = (1.0, 2.0 / 3.0, 4.0 / 9.0)  # of the gradation, one after the other
_NEEDLE = 5.0  # aspect of a triangle from which netgen runs again; 2 to 4 are usual
FORMAT = 3  # raise it when the way from outline to triangles changes
MOST_SECTIONS = 300  # triangulations, half a MB each; the longest unused go first
_LOCAL = threading.local()


def start_mesher() -> Worker:
    """This thread's process, started where there is none; does not wait until it is ready."""
    worker: Worker | None = getattr(_LOCAL, "worker", None)
    if worker is None:
        worker = _LOCAL.worker = Worker(load=load_netgen)
    worker.start()
    return worker


def triangulated(outline: dict[str, Any], time_limit_s: float) -> tuple[Array, IntArray, IntArray]:
    """Result of :func:`run_netgen`, from the cache for the same outline and netgen."""
    about = json.dumps([FORMAT, version("netgen-mesher"), outline])
    cache = Cache("sections", MOST_SECTIONS)
    name = hashlib.sha256(about.encode()).hexdigest() + ".npz"
    names = ("points", "triangles", "domains")
    found = cache.arrays(name)
    if found is not None and set(found[0]) == set(names):
        points, triangles, domains = (found[0][each] for each in names)
        return points, triangles.astype(np.int64), domains.astype(np.int64)
    points, triangles, domains = run_netgen(outline, time_limit_s)
    whole = (points, triangles.astype(np.int32), domains.astype(np.int32))
    cache.put_arrays(name, dict(zip(names, whole, strict=True)), None, packed=False)
    return points, triangles, domains


def run_netgen(outline: dict[str, Any], time_limit_s: float) -> tuple[Array, IntArray, IntArray]:
    """Points (n, 2), triangles (t, 3) and domains (t,) of an outline (an ``Outline`` as a dict).
    Raises MeshError where netgen fails, crashes or takes longer than ``time_limit_s``."""
    try:
        points, table = start_mesher().call(mesh_outline, outline, time_s=time_limit_s)
    except ProcessError as error:
        raise MeshError(str(error)) from error
    return points, table[:, :3].copy(), table[:, 3].copy()


def load_netgen() -> None:
    """Load netgen, in its process."""
    import netgen.geom2d  # noqa: F401


def mesh_outline(outline: dict[str, Any]) -> tuple[Array, IntArray]:
    """Points (n, 2) and triangles with their domain (t, 4), by netgen; in its process."""
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
    return _generated(geometry, outline["far_size"], outline["gradation"])


def _generated(geometry: Any, far_size: float, gradation: float) -> tuple[Array, IntArray]:
    """netgen's points (n, 2) and triangles with their domain (t, 4).

    Where the largest size is over a hundred times the least, its front may not close, or close with
    needles: then sizes grow more slowly, and of what was made the best counts.
    """
    from netgen.libngpy._meshing import NgException

    made: list[tuple[float, Array, IntArray]] = []
    for share in _SLOWER:
        try:
            mesh = geometry.GenerateMesh(maxh=far_size, grading=share * gradation)
        except NgException:
            if share == _SLOWER[-1] and not made:
                raise
            continue
        points = np.asarray(mesh.Coordinates(), dtype=float)[:, :2].copy()
        elements = mesh.Elements2D().NumPy()
        table = np.empty((len(elements), 4), dtype=np.int64)
        table[:, :3] = elements["nodes"][:, :3]
        table[:, :3] -= 1
        table[:, 3] = elements["index"]
        made.append((float(aspects(points, table[:, :3]).max()), points, table))
        if made[-1][0] < _NEEDLE:
            break
    _, points, table = min(made, key=lambda each: each[0])
    return points, table
