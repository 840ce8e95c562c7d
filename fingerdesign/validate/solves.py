"""The models that the comparisons share, each solved once.

Sizes are the ladder's (fidelity.rungs): one of SPACE in three dimensions, SECTION in plane strain,
and in plane strain too that of the finger in space where both are compared, on the same section.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.fidelity.models import Dimension, Plates, Solved, design_for, solve
from fingerdesign.analysis.fidelity.readings import MICRO, Readings, readings_of
from fingerdesign.analysis.fidelity.rungs import can_extrude, rung
from fingerdesign.analysis.path import follow_path, problem_at_touch, targets
from fingerdesign.analysis.stages import condense, zone_of
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import Motion
from fingerdesign.design.scene import Scene, ScenePath
from fingerdesign.design.schema import Design, Gages
from fingerdesign.errors import FingerDesignError, SolverError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.report.page import paragraphs
from fingerdesign.runtime.progress import Report
from fingerdesign.runtime.threads import one_thread
from fingerdesign.validate.advice import WORDS
from fingerdesign.validate.comparison import Answer

Values = Mapping[str, object]
Made = TypeVar("Made", "Solved", "Answer")

SPACE = (2.0, 3.0, 4.0, 6.0)  # the first whose forecast holds MOST_DOFS and MOST_NODES
FINER_SPACE = 0.7  # of that: the next finer mesh
SECTION, FINER_SECTION = 1.4, 0.7
MOST_DOFS = 120_000  # 10 s and 1.5 GB here, for each of about eight models
MOST_NODES = 600  # in contact: the next finer mesh has twice as many, and takes 3 GB
_FORECAST = 2.0  # within it forecasts hold
_WARM = 3.0


@dataclass(frozen=True)
class Requested:
    """A model to solve: in which dimension, sizes times ``scale``, with some keys changed."""

    dimension: Dimension
    scale: float
    values: Values
    plates: Plates | None


@dataclass
class Solves:
    """Every model of one design in one scene, solved when first needed.

    A failure is stored too, and raised again: no model is tried twice.
    """

    design: Design
    scene: Scene
    report: Report = lambda message: None
    _known: dict[str, Any] = field(default_factory=dict)
    _reader: Reader | None = None

    @cached_property
    def scale(self) -> float:
        """Factor of the sizes in three dimensions: the finest of SPACE that MOST_DOFS allow."""
        from fingerdesign.analysis.forecast.counts import count_model

        for scale in SPACE:
            model = rung(self.design, self.scene, "3-D", scale)
            own = design_for(self.design, model)
            mesh = own.mesh.model_copy(update={"section": model.sizes})
            own = own.model_copy(update={"mesh": mesh})
            case = Case(own, self.scene, grips=False)
            counts = count_model(case, zone_of(case, self.scene))
            # A mesh that the cache knows is counted, not forecast: let both choose the same.
            factor = _FORECAST if counts.mesh_kept else 1.0
            if counts.dofs <= factor * MOST_DOFS and counts.contact_nodes <= factor * MOST_NODES:
                return scale
        return SPACE[-1]

    @cached_property
    def zone(self) -> Zone:
        """Zone of the design's contact: the same for other values, which then share a mesh."""
        return zone_of(Case(self.design, self.scene, grips=False), self.scene)

    def space(
        self, finer: float = 1.0, values: Values | None = None, plates: Plates | None = None
    ) -> Solved:
        """The finger in three dimensions, sizes times ``finer``, with some keys changed."""
        return self._get(Requested("3-D", finer * self.scale, values or {}, plates))

    def section(self, scale: float = SECTION, plates: Plates | None = None) -> Solved:
        return self._get(Requested("plane strain", scale, {}, plates))

    def reader(self) -> Reader:
        """The finger in three dimensions, to be read by other gages."""
        if self._reader is None:
            self._reader = Reader(self.space())
        return self._reader

    def in_single_increments(self, solved: Solved) -> Solved:
        """The same with one increment a row where the scene leaves it open, as at finite strain."""
        path = self.scene.path
        whole = path.model_copy(update={"substeps": path.substeps or 1})
        scene = self.scene.model_copy(update={"path": whole})
        with one_thread():
            steps = follow_path(solved.problem, scene, solved.design)
        readings = readings_of(steps, solved.design.gages.face)
        return replace(solved, scene=scene, steps=steps, readings=readings)

    def finite(self, solved: Solved) -> Answer:
        """The same mesh, zone and scene at finite strain."""
        words = f"{solved.model.dimension} at finite strain"
        return self._kept(f"{solved.model}", words, lambda: _finite_answer(solved))

    def warmer(self, kelvin: float) -> Answer:
        """The finger in three dimensions, so much warmer than when its gages were zeroed and the
        object first touched it. Raises SolverError where its plates are no solids."""
        solved = self.space()
        if solved.design.plates.model != "solid":
            raise SolverError("the mesh is too coarse here for plates as solids")
        return self._kept(
            f"{kelvin} K", f"{kelvin:g} K warmer", lambda: _warmer(solved, self.zone, kelvin)
        )

    def _get(self, model: Requested) -> Solved:
        key = f"{model.dimension} {model.scale} {sorted(model.values.items())} {model.plates}"
        words = paragraphs(WORDS, "solving", of=model)[0]
        return self._kept(key, words, lambda: self._solve(model))

    def _kept(self, key: str, words: str, make: Callable[[], Made]) -> Made:
        """Result under a key, or failed to be, the first time."""
        if key not in self._known:
            self.report(words)
            try:
                self._known[key] = make()
            except FingerDesignError as error:
                self._known[key] = error
        known: Made | FingerDesignError = self._known[key]
        if isinstance(known, FingerDesignError):
            raise known
        return known

    def _solve(self, of: Requested) -> Solved:
        own = with_values(self.design, of.values) if of.values else self.design
        model = rung(self.design, self.scene, of.dimension, of.scale)  # of the design: sizes stay
        model = replace(model, plates=of.plates)
        if model.dimension == "3-D" and model.mesher == "sweep" and not can_extrude(own):
            model = replace(model, mesher="tetwild")
        solved = solve(own, self.scene, model, self.zone)
        if of != Requested("3-D", self.scale, {}, None):
            solved.built = None  # its factors are needed only where gages are read again
        return solved

    def release(self) -> None:
        """Let go of the factors and fields that are still held."""
        self._reader = None
        for known in self._known.values():
            if isinstance(known, Solved):
                known.built = None


def warm() -> None:
    """Load the libraries by a small solve of another finger, so that no model's seconds hold that.

    A section of a shipped finger without plates: half a second.
    """
    design, scene = load_design("homogeneous"), fundamental_scene()
    solve(design, scene, rung(design, scene, "plane strain", _WARM))


class Reader:
    """Reads a solved finger by other gages on the same plates: its displacements are stored.

    Of a path of more than MOST_ROWS rows, which would fill the memory, as many evenly spread.
    """

    MOST_ROWS = 64

    def __init__(self, solved: Solved) -> None:
        if solved.built is None:
            raise ValueError("the model's factors have been released")
        self.solved = solved
        count = len(solved.steps)
        places = np.linspace(0, count - 1, min(count, self.MOST_ROWS))
        self.rows = [int(row) for row in np.unique(places.round())]
        forces = np.array([solved.steps[row].increment.force for row in self.rows])
        self._fields = solved.built.displacement_fields(forces).reshape(len(forces), -1)

    @property
    def own(self) -> Readings:
        """The model's own readings, of the same rows."""
        return self.solved.readings.part(self.rows)

    def read(self, gages: Gages) -> Readings:
        """The readings with these gages. Raises DesignError where they leave the finger."""
        from fingerdesign.fem.readout import gage_rows

        frames, old = plate_frames(self.solved.design), self.own
        operator = gage_rows(self.solved.mesh, frames, gages, self.solved.design.gage_weights)
        strains = MICRO * (operator @ self._fields.T).T.reshape(old.gages.shape)
        return replace(old, gages=strains, face=gages.face)


def _warmer(solved: Solved, zone: Zone, kelvin: float) -> Answer:
    """Answer of a warmer finger. A free plate's own expansion reads nothing."""
    start = time.perf_counter()
    lift = {"grip.plant": "lift", "grip.warming_K": kelvin}
    design = with_values(solved.design, lift)
    model = condense(design, solved.mesh, zone, solved.scene).reduced
    problem = problem_at_touch(model, solved.scene.object, design.body)
    assert model.load_gage_strain is not None
    own = MICRO * kelvin * model.load_gage_strain

    def steps(scene: Scene) -> tuple[list[Step], Readings]:
        with one_thread():
            found = list(follow(problem, _warm(scene.path, kelvin), scene.path.substeps))
        cold = readings_of(found, design.gages.face)
        return found, replace(cold, gages=cold.gages + own)

    found, readings = steps(solved.scene)
    return Answer(
        f"{solved.model.name}, {kelvin:g} K warmer",
        readings,
        tuple(replace(step.increment.motion, load=0.0) for step in found),
        time.perf_counter() - start,
        solved.dofs,
        solved.mesh.dimension,
        lambda scene: steps(scene)[1],
    )


def _warm(path: ScenePath, kelvin: float) -> list[Motion | Forces]:
    """A path's targets, the finger so much warmer throughout."""
    return [
        replace(each, load=kelvin)
        if isinstance(each, Motion)
        else replace(each, held=replace(each.held, load=kelvin))
        for each in targets(path)
    ]


def _finite_answer(solved: Solved) -> Answer:
    from fingerdesign.analysis.finite_path import finite_readings

    start = time.perf_counter()
    found = finite_readings(solved.design, solved.mesh, solved.zone, solved.scene)
    seconds = solved.seconds["mesh"] + time.perf_counter() - start
    motions = tuple(row.motion for row in found.rows)
    name = f"{solved.model.dimension}, finite strain"
    return Answer(name, found.readings, motions, seconds, found.dofs, solved.mesh.dimension)
