"""Pictures of the finger: its inside, and deformed. Drawn off-screen, no display needed.

VTK is native code that can crash where its graphics drivers are odd, so it runs in a process of its
own with a time limit; its failure is a :class:`PictureError` and the report does without.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

import fingerdesign.report.picture_worker as picture_worker
from fingerdesign.arrays import Array
from fingerdesign.errors import FingerDesignError
from fingerdesign.mesh.types import Mesh
from fingerdesign.report.finger_words import count_text
from fingerdesign.report.surfaces import Surface, gage_quads, plate_boxes, region_of, surface_of
from fingerdesign.results import OPEN, Analysis, FieldHistory

TIME_LIMIT_S = 60.0  # the pictures take 2 to 4 s; a software renderer on a busy machine far longer

UNMOVED_MM = 1e-6  # a displacement that is not worth a picture


class PictureError(FingerDesignError):
    """The picture could not be drawn; the message says why."""


@dataclass(frozen=True)
class Picture:
    """A PNG and what it shows, in words; scale_mm: the colour scale's top, None without colours."""

    png: bytes
    alternative: str
    scale_mm: float | None = None


class PictureJob:
    """Pictures being drawn in a process of their own, while the caller goes on.

    Use as a context manager; leaving it ends the process. Needs an analysis with a mesh.
    """

    def __init__(self, analysis: Analysis, time_limit_s: float = TIME_LIMIT_S) -> None:
        self.time_limit_s = time_limit_s
        self.words: dict[str, str] = {}
        self._arrays = _scene(analysis, self.words)

    def __enter__(self) -> PictureJob:
        self._folder = tempfile.TemporaryDirectory(prefix="fingerdesign-picture-")
        folder = Path(self._folder.name)
        np.savez(folder / "scene.npz", **self._arrays)
        root = str(Path(__file__).parents[2])
        path = os.pathsep.join(filter(None, [root, os.environ.get("PYTHONPATH", "")]))
        command = [sys.executable, "-m", picture_worker.__name__, "scene.npz"]
        self._errors = (folder / "errors.txt").open("wb")
        self._process = subprocess.Popen(
            command,
            cwd=folder,
            env=os.environ | {"PYTHONPATH": path},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
        )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        self._errors.close()
        self._folder.cleanup()

    def pictures(self) -> dict[str, Picture]:
        """Name ("inside", "deformed") -> picture. Waits; raises PictureError."""
        try:
            code = self._process.wait(self.time_limit_s)
        except subprocess.TimeoutExpired as error:
            raise PictureError(f"drawing took longer than {self.time_limit_s:g} s") from error
        folder = Path(self._folder.name)
        if code != 0:
            lines = (folder / "errors.txt").read_text("utf-8", "replace").strip().splitlines()
            how = f"ended by signal {-code}" if code < 0 else f"exit code {code}"
            reason = f": {lines[-1][:300]}" if lines else ""
            raise PictureError(f"the drawing process failed ({how}){reason}")
        return {
            name: Picture((folder / f"{name}.png").read_bytes(), words, self._scale(name))
            for name, words in self.words.items()
        }

    def _scale(self, name: str) -> float | None:
        if name != "deformed":
            return None
        return float(np.linalg.norm(self._arrays["moved"], axis=1).max())


def _scene(analysis: Analysis, words: dict[str, str]) -> dict[str, Any]:
    """All that the worker draws, as arrays; fills ``words`` with what each picture shows."""
    mesh = analysis.mesh
    if mesh is None:
        raise PictureError("there is no mesh to draw")
    everything = np.ones(len(mesh.cells), dtype=bool)
    body = surface_of(mesh, everything, analysis.depth_mm)
    arrays: dict[str, Any] = {"body_points": body.points, "body_triangles": body.triangles}
    count = len(analysis.plates)
    solid, core = region_of(mesh, "plates"), region_of(mesh, "core")
    if solid.any():
        plates = surface_of(mesh, solid, analysis.depth_mm)
        count = len(set(mesh.regions[solid].tolist()))
    else:  # sheets, or left out: drawn as they are cast
        plates = plate_boxes(analysis.plates)
    if len(plates.triangles):
        arrays |= {"plate_points": plates.points, "plate_triangles": plates.triangles}
    if core.any():
        drawn = surface_of(mesh, core, analysis.depth_mm)
        arrays |= {"core_points": drawn.points, "core_triangles": drawn.triangles}
    if analysis.gages is not None and analysis.plates:
        arrays["gages"] = gage_quads(analysis.plates, analysis.gages)
    touched = _contact_zone(analysis)
    arrays |= touched
    words["inside"] = (
        "The finger seen from the front, above: a translucent body, "
        f"{count_text(count, 'plate')} inside it"
        + (", a green core" if core.any() else "")
        + (", the gages on them blue" if "gages" in arrays else "")
        + (", and the surface that touched the object tinted." if touched else ".")
    )
    if analysis.fields is not None and len(analysis.fields.increments):
        moved, said = _moved(mesh, analysis.fields, body)
        if moved is None:
            words["inside"] += f" {said}"
        else:
            arrays["moved"], words["deformed"] = moved, said
    return arrays


def _moved(mesh: Mesh, fields: FieldHistory, body: Surface) -> tuple[Array | None, str]:
    """Displacement of the body's surface points in the last field, None if it is next to nothing;
    and words for it."""
    last = fields.displacement[-1]
    if len(last) != len(mesh.points):
        raise PictureError("the displacement field does not belong to the mesh")
    moved = np.zeros_like(body.points)
    moved[:, : last.shape[1]] = last[body.nodes]
    if mesh.symmetric:
        moved[body.points[:, 2] < 0, 2] *= -1.0
    size = np.linalg.norm(moved, axis=1)
    number = fields.increments[-1] + 1
    if size.max() < UNMOVED_MM:
        return None, f"There is no picture of it deformed: in increment {number} nothing moves it."
    words = (
        f"The finger deformed as in increment {number}, true to scale, coloured "
        f"by the length of its displacement: up to {size.max():.3g} mm at the surface."
    )
    return moved, words


def _contact_zone(analysis: Analysis) -> dict[str, Any]:
    """The candidate surface and which of its points ever touched; empty if none did."""
    contact = analysis.contact
    if contact is None or not (contact.status != OPEN).any():
        return {}
    touched = (contact.status != OPEN).any(axis=0)
    points, triangles = contact.points, contact.facets
    if contact.dimension == 2:
        half, n = 0.5 * analysis.depth_mm, len(points)
        points = np.concatenate([np.column_stack([points, np.full(n, z)]) for z in (-half, half)])
        a, b = triangles.T
        triangles = np.concatenate([np.stack([a, b, b + n], 1), np.stack([a, b + n, a + n], 1)])
        touched = np.tile(touched, 2)
    elif contact.symmetric:
        triangles = np.concatenate([triangles, triangles + len(points)])
        points = np.concatenate([points, points * np.array([1.0, 1.0, -1.0])])
        touched = np.tile(touched, 2)
    return {"zone_points": points, "zone_triangles": triangles, "zone_touched": touched}
