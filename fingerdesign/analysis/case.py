"""One analysis as requested: design, scene and fidelity; and the clock that times it."""

import hashlib
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from fingerdesign.control.calibration import LEAST_GAGES
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.design.io import parse_scene
from fingerdesign.design.scene import Scene, SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import shipped_text
from fingerdesign.layout.row_keys import plate_rows
from fingerdesign.layout.rows import mirrors_in_z
from fingerdesign.version import __version__

FIDELITIES = ("plane-strain", "3d", "finite", "auto")
TOLERANCE = 0.02  # of "auto", where none is given


@dataclass(frozen=True)
class Case:
    """One analysis as requested. ``scene`` None: the fundamental case, its study and the grips.

    fidelity "finite": in 3-D, the path at finite strain, all else as in "3d"; "auto": the cheapest
    model whose estimated error is under ``tolerance``. fields:
    recover displacement fields, for files and pictures. go_on: even where the forecast says that
    the machine's free memory will not do. estimator: what grip.controller = "regulator" grips by;
    None: trained on the design. studied: with the study, at several frictions, of the fundamental
    case. for_page: find what only a page shows, which are remedies for gages that see too little,
    and each grip of the paper's rule with the rule off. mesh_error: estimate the mesh's share in
    the errors, by a second model. surface: a level plane, whose friction that of the fundamental
    case is, and of the grips instead of ``grip.friction_coefficients``.
    """

    design: Design
    scene: Scene | None = None
    fidelity: str = "3d"
    scene_name: str = ""
    grips: bool = True
    fields: bool = True
    go_on: bool = False
    tolerance: float = TOLERANCE
    estimator: GripEstimator | None = None
    studied: bool = True
    for_page: bool = True
    mesh_error: bool = False
    surface: SceneObject | None = None

    @property
    def path_scene(self) -> Scene:
        """The scene whose path is followed."""
        if self.scene is not None:
            return self.scene
        scene = fundamental_scene(self.design)
        return scene if self.surface is None else scene.model_copy(update={"object": self.surface})

    @property
    def requested(self) -> str:
        """The fidelity with what belongs to it: "3d", "auto, 0.02"."""
        return f"auto, {self.tolerance:g}" if self.fidelity == "auto" else self.fidelity

    @property
    def symmetric(self) -> bool:
        """True if half of the finger says all: design, scene and lifts mirror in z = 0."""
        centred = self.design.grip.off_centre_mm == 0.0
        return centred and mirrors_in_z(self.design) and self.path_scene.mirrors_in_z

    @property
    def runs_grips(self) -> bool:
        """True if the grips of the ``[grip]`` table are run: with gages enough for a hand."""
        return self.grips and self.scene is None and len(self.gage_array) >= LEAST_GAGES

    @property
    def gage_array(self) -> tuple[int, ...]:
        """The plates whose gages the slip rule reads, see :func:`gage_array`."""
        return gage_array(self.design)


@dataclass
class Clock:
    """Seconds by stage."""

    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add({name: time.perf_counter() - start})

    def add(self, seconds: Mapping[str, float]) -> None:
        """Add seconds by stage."""
        for name, more in seconds.items():
            self.seconds[name] = self.seconds.get(name, 0.0) + more


def fundamental_scene(design: Design | None = None) -> Scene:
    """The shipped scene of paper 3.1; as deep as the design's ``grip.fundamental_approach_mm``
    says, its shears in proportion."""
    scene = parse_scene(shipped_text("fundamental", "scene"), "fundamental")
    deep = None if design is None else design.grip.fundamental_approach_mm
    if deep is None:
        return scene
    scale = deep / max(row[0] for row in scene.path.increments_mm)
    rows = tuple((scale * row[0], scale * row[1]) for row in scene.path.increments_mm)
    path = scene.path.model_copy(update={"increments_mm": rows})
    return scene.model_copy(update={"path": path})


def gage_array(design: Design) -> tuple[int, ...]:
    """The plates whose gages make the paper's array: one row along x, which feels shear in x.

    Area measures need gages that differ in x alone: rows at other depths answer at other levels,
    and rows along z feel shear in z. Of several rows along x the one with most plates counts, the
    first of those; centres placed one by one are one row.
    """
    every = 2 if design.gages.grid == "double_axial" else 1  # a pair goes by its first plate
    rows = [row.frames for row in plate_rows(design) if row.table.along == "x"]
    return tuple(frame.index for frame in max(rows, key=len, default=())[::every])


def result_digest(design: Design, scene: Scene, fidelity: str) -> str:
    """SHA-256 over design, scene, fidelity and this package's version, in hexadecimal."""
    parts = (design.digest(), scene.digest(), fidelity, __version__)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()
