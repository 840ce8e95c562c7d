"""``[body.step]`` when a design is read: where the file lies, and the sizes that its solid has.

``body.width_mm``, ``depth_mm`` and ``base_height_mm`` of a STEP body are its solid's; the rest of
the program then reads them as of any body.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shutil
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.errors import DesignError, Fault, GeometryError
from fingerdesign.runtime.cache import cache_folder
from fingerdesign.runtime.process import ProcessError, machine_failed, run_module
from fingerdesign.shapes.faces import CadFace, faces_of, nearest, top_height

if TYPE_CHECKING:
    from fingerdesign.design.body import StepFile


# What a STEP body is: extents, faces, heights, volume; read once in a process, then kept.
#
# The CAD kernel runs in a process of its own (``cad/step_worker.py``) with a time limit; what it
# finds is kept in the cache folder under the file's content and the rules of ``[body.step]``. This
# process computes with numpy alone.

WORKER = "fingerdesign.cad.step_worker"
FORMAT = 6  # raise it when what the worker writes changes
TIME_LIMIT_S = 120.0  # 1 s for a dozen faces; a body of 2000 takes half a minute
MAX_BYTES = 100_000_000  # of a file; a body of 2000 faces has 2 MB
KEPT = 100  # bodies; the longest unused go first
_KEY = "body.step.file"


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

    def names(self, points: Array) -> NDArray[np.str_]:
        """Name (n,) of the face nearest to each point (n, 3)."""
        names = np.array([face.name for face in self.faces])
        return np.asarray(names[nearest(self.faces, points)[0]])


def _lowest(face: CadFace) -> float:
    """Of the border; a closed face's by its distances from far below."""
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
    """The solid of a STEP body, turned and moved, as BREP; made anew where it was cleared away or
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
    """What is kept of a file, or was found by the worker now: facts or a fault."""
    rules = step.model_dump(mode="json", exclude={"file"})
    text = json.dumps({"format": FORMAT, "content": content, "rules": rules}, sort_keys=True)
    digest = hashlib.sha256(text.encode()).hexdigest()
    home = cache_folder("steps") / digest
    found = _kept(home, digest)
    if found is not None:
        return found
    name = Path(step.file).name
    request = {"file": str(Path(step.file).resolve()), "name": name, "rules": rules}
    try:
        folder = Path(tempfile.mkdtemp(prefix="fingerdesign-step-"))
    except OSError as error:
        raise _unread(name, str(error)) from error
    try:
        (folder / "request.json").write_text(json.dumps(request), "utf-8")
        run_module(WORKER, [str(folder)], folder, TIME_LIMIT_S)
    except OSError as error:
        shutil.rmtree(folder, ignore_errors=True)
        raise _unread(name, str(error)) from error
    except ProcessError as error:
        shutil.rmtree(folder, ignore_errors=True)
        if machine_failed(error):
            raise _unread(name, str(error)) from error
        remedy = f"{error}; mend or simplify the body in your CAD"
        return Fault(_KEY, name, "a STEP file that the CAD kernel can take in", remedy)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    try:
        if (folder / "fault.json").exists():
            key, value, bound, remedy = json.loads((folder / "fault.json").read_text("utf-8"))
            return Fault(key, value, bound, remedy)
        home = _keep(folder, home)
        found = _kept(home, digest)
    finally:
        if folder != home:
            shutil.rmtree(folder, ignore_errors=True)
    if found is None:
        raise _unread(name, "the CAD kernel's process left no answer")
    return found


def _unread(name: str, why: str) -> GeometryError:
    """The machine's failure, not the file's: not kept, so that the next reading may do."""
    return GeometryError(
        f"{name} could not be read now: {why}; the file need not be wrong: see to memory and disk, "
        "then try again"
    )


def _keep(folder: Path, home: Path) -> Path:
    """Move the worker's answer into the cache; where that cannot be written, it stays in place."""
    aside = home.with_name(f".{folder.name}")
    try:
        home.parent.mkdir(parents=True, exist_ok=True)
        shutil.copytree(folder, aside)
        if _kept(home, home.name) is None:  # what lies there cannot be read
            shutil.rmtree(home, ignore_errors=True)
        with contextlib.suppress(OSError):  # somebody else was faster: theirs says the same
            os.replace(aside, home)
        if not (home / "facts.npz").exists():
            return folder
        old = sorted(home.parent.glob("[0-9a-f]*"), key=lambda each: each.stat().st_mtime)
        for each in old[:-KEPT]:
            shutil.rmtree(each, ignore_errors=True)
    except OSError:
        return folder
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return home


def _kept(home: Path, digest: str) -> StepFacts | None:
    """The facts in a folder; None: nothing there, or what cannot be read."""
    brep = home / "outline.brep"
    try:
        with (home / "facts.npz").open("rb") as file, np.load(file, allow_pickle=False) as data:
            arrays = {name: data[name] for name in data.files}
        about: dict[str, Any] = json.loads(str(arrays.pop("about")))
        found = StepFacts(
            _triple(about["low"]),
            _triple(about["high"]),
            float(about["volume"]),
            digest,
            brep,
            str(about["outline"]),
            tuple(faces_of(about["faces"], arrays)),
        )
        if not found.faces or not _intact(brep, found.outline):
            return None
        os.utime(home)
    except (
        *(OSError, EOFError, KeyError, ValueError, TypeError, IndexError, AttributeError),
        *(zipfile.BadZipFile, zlib.error, struct.error, OverflowError, NotImplementedError),
    ):
        return None
    return found


def _intact(brep: Path, outline: str) -> bool:
    """Whether the solid is there as it was written."""
    try:
        return hashlib.sha256(brep.read_bytes()).hexdigest() == outline
    except OSError:
        return False


def _triple(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = values
    return float(x), float(y), float(z)
