"""``[body.step]`` when a design is read: where the file lies, and the sizes that its solid has.

``body.width_mm``, ``depth_mm`` and ``base_height_mm`` of a STEP body are its solid's; the rest of
the program then reads them as of any body. What such a body is, extents, faces, heights, volume,
is read once by the CAD kernel in a process of its own, then stored in the cache under the file's
content and the rules of ``[body.step]``; this process computes with numpy alone.
"""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from fingerdesign.arrays import Array
from fingerdesign.design.body import StepFile
from fingerdesign.design.mesh import mesh_file_digest
from fingerdesign.errors import DesignError, Fault, GeometryError
from fingerdesign.runtime.cache import GARBLED, Cache, unpacked
from fingerdesign.runtime.files import keep_request
from fingerdesign.runtime.isolate import ProcessError, call
from fingerdesign.shapes.faces import Border, CadFace, top_height
from fingerdesign.shapes.nurbs import Nurbs
from fingerdesign.shapes.quadrics import Cone, Plane, Sphere

READ = "fingerdesign.cad.step_read:read_body"
FORMAT = 8  # raise it when what that returns changes
TIME_LIMIT_S = 120.0  # 1 s for a dozen faces; a body of 2000 takes half a minute
MAX_BYTES = 100_000_000  # of a file; a body of 2000 faces has 2 MB
LEAST_BASE_HEIGHT_MM = 0.5  # The least of every body; a contact surface may run down to the base.
SAME_MM = 1e-6  # A size given with the file may differ so much: a design is written and read again.
KEPT = 100  # Bodies in the cache; the longest unused go first.
_KEY = "body.step.file"
_KINDS = (CadFace, Border, Plane, Cone, Sphere, Nurbs)  # what the cache holds of a body's faces


@dataclass(frozen=True, eq=False)
class StepFacts:
    """A STEP body, turned and moved as its rules say; lengths in mm.

    low, high  extents (3,) along x, y, z
    volume     mm^3
    digest     SHA-256 of the file's geometry and of the rules, in hexadecimal
    brep       the solid, for the CAD kernel
    outline    SHA-256 of that file, in hexadecimal
    faces      as numpy computes with them
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    volume: float
    digest: str
    brep: Path
    outline: str
    faces: tuple[CadFace, ...]

    @property
    def contact(self) -> tuple[CadFace, ...]:
        """The faces of the contact surface."""
        return tuple(face for face in self.faces if face.name == "contact")

    @property
    def area(self) -> dict[str, float]:
        """Area by name ("base", "contact", "side", "end"), mm^2."""
        found: dict[str, float] = {}
        for face in self.faces:
            found[face.name] = found.get(face.name, 0.0) + face.area
        return found

    @property
    def lowest(self) -> float:
        """Least height of the contact surface, at its border, mm."""
        return float(min(_lowest(face) for face in self.contact))

    def height(self, x: Array | float, z: Array | float = 0.0) -> Array:
        """Height of the contact surface over (x, z), mm; NaN where it has none."""
        x, z = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(z, dtype=float))
        known = np.isfinite(x) & np.isfinite(z)
        found = np.full(x.shape, np.nan)
        # Grids of points share their lines.
        lines, back = np.unique(np.column_stack([x[known], z[known]]), axis=0, return_inverse=True)
        found[known] = top_height(self.contact, *lines.T)[back.reshape(-1)]
        return found


def _lowest(face: CadFace) -> float:
    """Find the height of the border; a closed face's by its distances from far below."""
    if len(face.border.start):
        return float(face.border.start[:, 1].min())
    return float(np.nanmin(face.heights(*np.zeros((2, 1)))))


def step_facts(step: StepFile) -> StepFacts:
    """The facts of a STEP body. Raises DesignError where the file or its rules will not do,
    GeometryError where this machine fails (disk, memory)."""
    found = _outcome(step, content_of(step.file))
    if isinstance(found, Fault):
        raise DesignError([found])
    return found


def outline_file(step: StepFile) -> Path:
    """The solid of a STEP body, turned and moved, as BREP; made again where it was cleared away or
    garbled."""
    found = step_facts(step)
    if not _intact(found.brep, found.outline):
        _outcome.cache_clear()
        found = step_facts(step)
    return found.brep


def content_of(file: str) -> str:
    """SHA-256, in hexadecimal, of what a STEP file says: all after its header, which holds the time
    and program of writing. DesignError where it cannot be read."""
    path = Path(file)
    try:
        if path.exists() and not path.is_file():
            raise _refused(file, "an ordinary file", "a folder, device or pipe is none")
        about = path.stat()
        if about.st_size > MAX_BYTES:
            remedy = "simplify the body; export it alone"
            raise _refused(file, f"at most {MAX_BYTES // 1_000_000} MB", remedy)
        return _content(str(path), about.st_mtime_ns, about.st_size, about.st_ino)
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise _refused(file, "a STEP file that can be read", str(why)) from None


@lru_cache(maxsize=256)
def _content(path: str, modified: int, size: int, node: int) -> str:
    content = Path(path).read_bytes()
    if not content.lstrip()[:20].upper().startswith(b"ISO-10303-21"):
        remedy = "it does not begin with ISO-10303-21; export the body as STEP (AP203, 214 or 242)"
        raise _refused(path, "a STEP file", remedy)
    start = content.find(b"DATA;")
    return hashlib.sha256(content[max(start, 0) :]).hexdigest()


def _refused(file: str, bound: str, remedy: str) -> DesignError:
    return DesignError([Fault(_KEY, Path(file).name, bound, remedy)])


@lru_cache(maxsize=64)
def _outcome(step: StepFile, content: str) -> StepFacts | Fault:
    """Return the facts of a file or its fault, from the cache or from the worker."""
    rules = step.model_dump(mode="json", exclude={"file"})
    text = json.dumps({"format": FORMAT, "content": content, "rules": rules}, sort_keys=True)
    digest = hashlib.sha256(text.encode()).hexdigest()
    cache = Cache("steps", 2 * KEPT)
    found = _cached(cache, digest)
    if found is not None:
        return found
    name = Path(step.file).name
    try:
        file = str(Path(step.file).resolve())
        about, arrays, brep = call(READ, file, name, rules, time_s=TIME_LIMIT_S)
    except DesignError as error:
        return error.faults[0]
    except OSError as error:
        raise _unread(name, str(error)) from error
    except ProcessError as error:
        if error.machine:
            raise _unread(name, str(error)) from error
        remedy = f"{error}; mend or simplify the body in your CAD"
        return Fault(_KEY, name, "a STEP file that the CAD kernel can take in", remedy)
    try:
        outline = cache.put(f"{digest}.brep", brep)
        cache.put_arrays(f"{digest}.npz", arrays, about)
    except OSError:  # where the cache cannot be written, it costs time alone
        try:
            outline = keep_request("step", "outline.brep", brep)
        except OSError as error:
            raise _unread(name, str(error)) from error
    return _facts(digest, outline, about, arrays)


def _unread(name: str, why: str) -> GeometryError:
    """The machine's failure, not the file's: not stored, so that the next reading may succeed."""
    return GeometryError(
        f"{name} could not be read now: {why}; the file need not be wrong: see to memory and disk, "
        "then try again"
    )


def _cached(cache: Cache, digest: str) -> StepFacts | None:
    """Read the cached facts; None: there are none, or they cannot be read."""
    found, outline = cache.arrays(f"{digest}.npz"), cache.path(f"{digest}.brep")
    try:
        if found is None:
            return None
        facts = _facts(digest, outline, found[1], found[0])
        if not facts.faces or not _intact(outline, facts.outline):
            return None
        os.utime(outline)
        return facts
    except GARBLED:
        return None


def _facts(
    digest: str, outline: Path, about: dict[str, Any], arrays: dict[str, NDArray[Any]]
) -> StepFacts:
    faces = unpacked(about["faces"], arrays, {kind.__name__: kind for kind in _KINDS})
    low, high, volume = _triple(about["low"]), _triple(about["high"]), float(about["volume"])
    return StepFacts(low, high, volume, digest, outline, str(about["outline"]), faces)


def _triple(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = values
    return float(x), float(y), float(z)


def _intact(brep: Path, outline: str) -> bool:
    """Tell whether the solid is there as it was written."""
    try:
        return hashlib.sha256(brep.read_bytes()).hexdigest() == outline
    except OSError:
        return False


def resolved(
    data: Mapping[str, Any], folder: Path | None = None
) -> tuple[dict[str, Any], tuple[Fault, ...]]:
    """A design's raw table with the places of its files made absolute, from ``folder`` (None: from
    here), and the sizes of a STEP body filled in; faults: why the file will not do, or which sizes
    stand in the design too.

    The STEP file is read only where every key of [body.step] is sound.
    """
    out, home = deepcopy(dict(data)), folder or Path.cwd()
    body: Any = out.get("body")
    step = body.get("step") if isinstance(body, dict) and body.get("shape") == "step" else None
    tables: tuple[Any, ...] = (step, out.get("mesh"))
    for table in tables:
        file = table.get("file") if isinstance(table, dict) else None
        if isinstance(file, str) and file:
            table["file"] = str((home / file).absolute())
    try:
        sizes = step_sizes(StepFile.model_validate(step)) if step else {}
    except ValidationError:  # its keys are judged with all others
        return out, ()
    except DesignError as error:
        return out, error.faults
    return out, tuple(_fill_sizes(body, sizes))


def _fill_sizes(body: dict[str, Any], sizes: Mapping[str, float]) -> Iterator[Fault]:
    """Set the sizes of the file's solid in a raw [body]; find other ones that it gives."""
    for key, value in sizes.items():
        given = body.get(key)
        same = isinstance(given, (int, float)) and abs(given - value) <= SAME_MM
        if given is not None and not same:
            bound = f"absent where body.shape = 'step' (the file's solid has {value:.6g})"
            yield Fault(f"body.{key}", given, bound, "remove it: the file says it")
        body[key] = value


def step_sizes(step: StepFile) -> dict[str, float]:
    """The sizes of a [body] that a STEP solid decides, mm: extents along x and z, the least height
    of its contact surface. DesignError where the file or its rules will not do."""
    facts = step_facts(step)
    return {
        "width_mm": round(facts.high[0] - facts.low[0], 9),
        "depth_mm": round(facts.high[2] - facts.low[2], 9),
        "base_height_mm": round(max(facts.lowest, LEAST_BASE_HEIGHT_MM), 9),
    }


def portable(parameters: Mapping[str, object]) -> dict[str, object]:
    """Dotted parameters of a design for records: files by their name and content, not by their
    place on this machine."""
    out = dict(parameters)
    for key, digest in (("body.step", content_of), ("mesh", mesh_file_digest)):
        file = out.get(f"{key}.file")
        if isinstance(file, str):
            out[f"{key}.file"] = Path(file).name
            try:
                out[f"{key}.content"] = digest(file)
            except DesignError:
                out[f"{key}.content"] = "absent"
    return out
