"""The exploded picture of a mold: each part moved along its draw, drawn off-screen in a process."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.analysis.page.picture import PictureError
from fingerdesign.arrays import Array
from fingerdesign.mold.part import CORE, INSERT, MoldMeshes, PartMesh
from fingerdesign.runtime.process import ProcessError, WorkerJob

WORKER = "fingerdesign.mold.page.picture_worker"
TIME_LIMIT_S = 60.0  # it takes 2 to 4 s; a software renderer on a busy machine far longer
COLOURS = {
    "insert": "#5b8fc7",
    "end": "#7fae8c",
    "side": "#a9b6a0",
    "sheet": "#c9a227",
    "base": "#8b8f99",
    "core": "#5f8f4e",
    "rubber": "#8fb4cf",
    "plate": "#b5652a",
}


@dataclass(frozen=True)
class Shown:
    """One thing in the picture: its triangles, how far it is moved, its look, its number."""

    name: str
    mesh: PartMesh
    move: tuple[float, float, float]
    colour: str
    opacity: float
    number: int | None


@dataclass(frozen=True)
class Badge:
    """A part's number, and where its middle is in the picture: shares from the left and top."""

    number: int
    name: str
    left: float
    top: float


@dataclass(frozen=True)
class Exploded:
    """The picture, its badges, and what it shows, in words."""

    png: bytes
    badges: tuple[Badge, ...]
    alternative: str


def numbered(meshes: MoldMeshes) -> dict[str, int]:
    """Part name -> its number in picture and table, in the order of opening, the finger last."""
    return {part.name: number for number, part in enumerate(meshes.parts, start=1)}


def exploded_parts(meshes: MoldMeshes) -> tuple[Shown, ...]:
    """All that is drawn. The finger (rubber, plates, a core that is inside) stays in its place."""
    low, high = np.array(meshes.low), np.array(meshes.high)
    size = high - low
    numbers = numbered(meshes)
    shown = []
    for part in meshes.parts:
        move, colour = _moved(part, size), _colour(part)
        shown.append(Shown(part.name, part, move, colour, 1.0, numbers[part.name]))
    shown += [Shown(p.name, p, (0.0, 0.0, 0.0), COLOURS["plate"], 1.0, None) for p in meshes.plates]
    rubber = meshes.rubber
    shown.append(Shown("rubber", rubber, (0.0, 0.0, 0.0), COLOURS["rubber"], 0.3, None))
    return tuple(shown)


def exploded_job(meshes: MoldMeshes, time_limit_s: float = TIME_LIMIT_S) -> WorkerJob:
    """The drawing process; enter it to start, and give it to :func:`exploded_of`."""
    return WorkerJob(WORKER, _request(exploded_parts(meshes)), time_limit_s)


def exploded_of(job: WorkerJob, meshes: MoldMeshes) -> Exploded:
    """What was drawn; PictureError says why nothing was."""
    try:
        folder = job.finished()
    except ProcessError as error:
        raise PictureError(str(error)) from error
    places = json.loads((folder / "places.json").read_text("utf-8"))
    badges = tuple(
        Badge(number, name, *places[name])
        for name, number in numbered(meshes).items()
        if name in places
    )
    words = ", ".join(f"{badge.number} {badge.name.replace('_', ' ')}" for badge in badges)
    return Exploded(
        (folder / "exploded.png").read_bytes(),
        badges,
        f"The mold opened: each part is moved along its draw. {words}. The finger with its plates "
        "and their legs stands in the middle, base down (it is cast with the base up).",
    )


def _moved(part: PartMesh, size: Array) -> tuple[float, float, float]:
    """How far a part is moved: sheets less than what is behind them."""
    wide, high, deep = size.tolist()
    if part.draw is None:
        if part.name == CORE:
            inside = part.vertices[:, 1].min() > 1e-6
            return (0.0, 0.0 if inside else -0.45 * high, 0.0)
        return (0.0, -0.95 * high, 0.0)
    if part.name == INSERT:
        far = 0.75 * high
    elif abs(part.draw[2]) > 0.5:
        far = (0.3 if part.made == "sheet" else 0.85) * deep
    else:
        far = (0.25 if part.made == "sheet" else 0.5) * wide
    x, y, z = (far * share for share in part.draw)
    return (x, y, z)


def _colour(part: PartMesh) -> str:
    if part.made == "sheet" or part.name.startswith("jig"):
        return COLOURS["sheet"]
    kinds = {"contact": "insert", "end": "end", "side": "side", "base": "base", "core": "core"}
    return COLOURS[kinds.get(part.name.split("_")[0], "base")]


def _request(shown: tuple[Shown, ...]) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        arrays: dict[str, Any] = {}
        for k, each in enumerate(shown):
            arrays[f"points_{k}"] = each.mesh.vertices + np.array(each.move)
            arrays[f"triangles_{k}"] = each.mesh.triangles
        looks = [
            {"name": s.name, "colour": s.colour, "opacity": s.opacity, "move": s.move}
            for s in shown
        ]
        np.savez(folder / "scene.npz", **arrays)
        (folder / "scene.json").write_text(json.dumps(looks), "utf-8")

    return write
