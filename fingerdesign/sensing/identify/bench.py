"""Bench of a finger on its model (docs/how_to/identify.md), with noise and without."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.arrays import Array
from fingerdesign.checks.load import with_values
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.bench_curves import (
    BenchCurves,
    Kind,
    Phase,
    Points,
    bench_curves,
    points_of,
)
from fingerdesign.control.calibration import DEPTHS, SLIDE_DEPTH, STICKING_SHEAR
from fingerdesign.control.plants.hardware import Hardware, ImperfectPlant
from fingerdesign.control.plants.plant import CondensedPlant, Plant
from fingerdesign.control.trace import trace_of
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.fem.model import ContactOf
from fingerdesign.mesh.make import mesher_name
from fingerdesign.reduced import ReducedModel
from fingerdesign.runtime.streams import stream
from fingerdesign.runtime.threads import in_threads
from fingerdesign.sensing.model import BenchFinger, against, against_plane, meshed_for_grips
from fingerdesign.sensing.perturb.faults import ALL
from fingerdesign.sensing.perturb.finger import perturb

TILT_DEG = 2.0  # The protocol tilts the surface by this much.
MOST_LEAN_DEG = 3.0  # The contact's zone covers this lean of the bench itself.


@dataclass(frozen=True)
class BenchMesh:
    """A swept mesh of a bench next to that of grips: facets of the contact and elements at the
    plates' ends are so many times as long, and there are so many times as many layers. growth: of
    their heights toward the gages at z = 0, a layer."""

    contact: float
    layers: float
    plate_end: float
    growth: float = 1.0


# Readings of two drawn fingers of `sensitive`, in the design's mesh with its plates moved, against
# facets of 0.075 mm, six layers and ends of an eighth: RMS in microstrain after a gain for each
# gage, and processor time.
#     facets  layers  ends
#     0.2 mm  3       0.5     1.2; 1.5    10 s
#     0.4     4       0.5     1.1; 1.3    13      as grips, but for the ends
#     0.15    4       0.5     0.6; 0.8    16
#     0.15    4       0.25    0.6; 0.8    21
#     0.15    5       0.35    0.4; 0.5    26      FINE
#     0.15    6       0.25    0.5; 0.5    40
# A coarse mesh with the design's fine contact, facets of 0.4 mm (0.8 mm reads the same):
#     2 layers        0.5     1.4; 1.6     4
#     3               0.5     0.6; 0.9     6
#     3               0.35    0.5; 0.8     7
#     3, growing      0.35    0.6; 0.6     7      COARSE: gains are nearer, too
# ROUGH is for slopes and for the bench's lean.
FINE, COARSE = BenchMesh(0.375, 1.25, 0.35), BenchMesh(1.0, 0.75, 0.35, 0.7)
ROUGH = BenchMesh(1.0, 0.5, 0.5)
# The step of differences by the lean, degrees: a third of a degree a millimetre of the facets. By a
# larger one the fit takes more steps; by 0.035 with facets of 0.4 mm it stopped too early.
LEAN_STEP = {"plane-strain": 0.035, "3d": 0.15}
# Faults of grips have no effect on a bench.
OF_GRIPS = frozenset({"radius", "dying", "relaxation", "arm", "patches", "kinetic"})
_SLIDE, _SLIDES = 6.0, 15  # The slide: its length over friction x depth, its moves.
_TILT_DEPTH, _TILTS = 0.6, 20  # The tilted press: depth over the stage's travel, moves.
_QUICK = 40  # The quick press has so many samples beyond the hardware's delay.
_AT_REST, _POINTS_A_SECOND = 100, 1.0  # Each point is the mean of so many samples.
# Keys that a bench's mesh sets.
_FREE = ("mesh.contact_size_mm", "mesh.layers", "mesh.layer_growth")


def protocol(design: Design, tilts: Sequence[float] = (TILT_DEG,)) -> tuple[Phase, ...]:
    """The phases of a bench by the design's ``[grip]`` table: their moves; forces are all 0."""
    grip = design.grip
    most, step = grip.max_approach_mm, grip.approach_step_mm
    friction = grip.bench_friction_coefficient

    def phase(name: str, kind: Kind, approach: Array, shear: Array, tilt: float = 0.0) -> Phase:
        none = np.zeros(len(approach))
        points = Points(approach, shear, none, none, none[:, None], none)
        return Phase(f"{name}.csv", kind, friction, tilt, points)

    def closing(depth: float, moves: int) -> Array:
        return np.linspace(0.0, depth, moves + 1)[1:]

    def sheared(name: str, kind: Kind, depth: float, shear: Array) -> Phase:
        down = closing(depth, max(1, int(np.ceil(depth / max(step, 0.2 * depth) - 1e-9))))
        approach = np.concatenate([down, np.full(len(shear), depth)])
        return phase(name, kind, approach, np.concatenate([np.zeros(len(down)), shear]))

    press = closing(most, max(1, int(np.ceil(most / step - 1e-9))))
    found = [phase("press", "press", press, np.zeros(len(press)))]
    for number, depth in enumerate(np.geomspace(grip.preload_mm, most, DEPTHS), 1):
        shear = np.array([STICKING_SHEAR * float(depth)])
        found.append(sheared(f"shear_{number}", "shear", float(depth), shear))
    depth = SLIDE_DEPTH * most
    way = closing(_SLIDE * friction * depth, _SLIDES)
    found.append(sheared("slide", "slide", depth, way))
    found.append(sheared("slide_back", "slide", depth, -way))
    for number, tilt in enumerate(tilts, 1):
        down = closing(_TILT_DEPTH * most, _TILTS)
        found.append(phase(f"tilt_{number}", "tilt", down, np.zeros(len(down)), tilt))
    return tuple(found)


def bench_finger(
    design: Design,
    phases: Sequence[Phase],
    fidelity: str,
    neighbour: Design | None = None,
    mesh: BenchMesh = FINE,
) -> BenchFinger:
    """The finger with contact nodes for all surfaces of a bench's phases.

    The zone, and so the mesh, does not depend on the lean. neighbour: see BenchFinger; mesh: of a
    finger that is swept.
    """
    tilts = [abs(phase.tilt_deg) for phase in phases if phase.kind == "tilt"]
    room = (SceneObject(tilt_deg=max(tilts) + MOST_LEAN_DEG),) if tilts else ()
    if not _is_swept(design, fidelity):
        return BenchFinger(design, room, fidelity, neighbour=neighbour)
    own, near = _meshed(design, mesh), neighbour and _meshed(neighbour, mesh)
    return BenchFinger(own, room, fidelity, _FREE, near, mesh.plate_end)


def _is_swept(design: Design, fidelity: str) -> bool:
    return fidelity == "3d" and mesher_name(meshed_for_grips(design, fidelity)) == "sweep"


def _meshed(design: Design, mesh: BenchMesh) -> Design:
    """The design with the facets and the layers of a bench's mesh."""
    of_grips = meshed_for_grips(design, "3d").mesh
    layers = math.ceil(mesh.layers * (of_grips.layers or 1))
    sizes = (mesh.contact * of_grips.contact_size_mm, layers, mesh.growth)
    return with_values(design, dict(zip(_FREE, sizes, strict=True)))


def leaning(
    bench: ContactProblem, design: Design, phases: Sequence[Phase], lean_deg: float
) -> list[ContactProblem]:
    """The condensed finger against each phase's surface; nothing is condensed again."""

    @cache
    def met(tilt: float) -> ContactProblem:
        """All phases but the tilted ones share one place: to let a plane down takes 16 ms."""
        return against(bench, SceneObject(tilt_deg=tilt), design) if tilt else bench

    def facing(phase: Phase) -> ContactProblem:
        return met(phase.tilt_deg + lean_deg).with_friction(phase.friction_coefficient)

    return [facing(phase) for phase in phases]


@dataclass(frozen=True)
class BenchModel:
    """A design's model on its bench, where the moves of ``phases`` are played.

    Plates of other fingers are moved in the design's mesh (see BenchFinger). A finger that is swept
    has a coarse mesh and the design's fine contact: what a coarse mesh misses is nearly the same of
    both. With C the compliance, or readouts, at the fine contact's nodes, E the rubber's modulus,
    f and c the meshes, ' of the design,

        C = C_c + (C_f' - C_c') E' / E
    """

    design: Design
    phases: tuple[Phase, ...]
    fidelity: str = "plane-strain"

    @property
    def moved(self) -> tuple[Phase, ...]:
        """The phases whose moves are played."""
        return tuple(phase for phase in self.phases if phase.kind != "quick")

    @property
    def lean_step(self) -> float:
        """The step of differences by the bench's lean, degrees."""
        return LEAN_STEP[self.fidelity] * (FINE.contact if self._swept else 1.0)

    @property
    def _swept(self) -> bool:
        return _is_swept(self.design, self.fidelity)

    @cached_property
    def _fine(self) -> ContactOf:
        model = bench_finger(self.design, self.moved, self.fidelity).model()[0]
        return ContactOf(model.mesh, model.condensed.trace, model.reduced)

    @property
    def _fine_model(self) -> ReducedModel:
        return self._fine.reduced.with_gages(gage_array(self.design))

    @cached_property
    def _missed(self) -> tuple[Array, Array]:
        """Differences of fine and coarse mesh for the design: compliance and readouts."""
        fine, own = self._fine_model, self._coarse(self.design)
        return fine.compliance - own.compliance, fine.gage_readout - own.gage_readout

    def _coarse(self, finger: Design) -> ReducedModel:
        own = bench_finger(finger, self.moved, self.fidelity, self.design, COARSE)
        return own.onto(self._fine)

    def bench(self, finger: Design) -> ContactProblem:
        """Condense a finger and pose it against a level bench."""
        if not self._swept:
            return bench_finger(finger, self.moved, self.fidelity, self.design).model()[1]
        if finger == self.design:
            return against_plane(self._fine_model, finger)
        own, missed = self._coarse(finger), self._missed
        moduli = [each.material_of("body").youngs_modulus_MPa for each in (self.design, finger)]
        more = [moduli[0] / moduli[1] * each for each in missed]
        compliance, readout = own.compliance + more[0], own.gage_readout + more[1]
        model = replace(own, compliance=compliance, gage_readout=readout)
        return against_plane(model, finger)

    def curves(self, finger: Design | None = None, lean_deg: float = 0.0) -> BenchCurves:
        """Play the moves on a finger, or on the design. Raises SolverError where the model has no
        answer, DesignError for a finger that is not sound."""
        return self.curves_by_lean(finger or self.design)(lean_deg)

    def curves_by_lean(self, finger: Design) -> Callable[[float], BenchCurves]:
        """Condense once, and give what plays the moves on a bench that leans, degrees."""
        return self.played_on(self.bench(finger), finger)

    def rough_curves_by_lean(self) -> Callable[[float], BenchCurves]:
        """The same of the design in the rough mesh alone."""
        rough = bench_finger(self.design, self.moved, self.fidelity, mesh=ROUGH)
        return self.played_on(rough.model()[1], self.design)

    def played_on(self, bench: ContactProblem, own: Design) -> Callable[[float], BenchCurves]:
        """Make a player of the moves on a condensed finger, on a bench that leans, degrees."""
        moved = self.moved

        def played(of: tuple[Phase, ContactProblem]) -> Phase:
            return of[0].played(CondensedPlant(of[1], own.gages.face))

        def curves(lean_deg: float) -> BenchCurves:
            problems = leaning(bench, own, moved, lean_deg)
            found = [*in_threads(played, zip(moved, problems, strict=True))]
            return bench_curves(found, bench.model.gage_x)

        return curves


@dataclass(frozen=True)
class SimulatedBench:
    """The measurements of a simulated rig: phases with their traces, the finger drawn, the bench's
    lean (degrees)."""

    phases: tuple[Phase, ...]
    design: Design
    lean_deg: float


def simulated_bench(
    design: Design,
    faults: Iterable[str],
    seed: int,
    fidelity: str = "plane-strain",
    mesh: BenchMesh = FINE,
) -> SimulatedBench:
    """Play the protocol on a perturbed finger of the design, with its ``[grip.hardware]``.

    Every point is the mean of so many samples at rest; the quick press is sampled as it goes.
    Raises DesignError for faults that are unknown, or of grips alone.
    """
    chosen = set(faults)
    known = [name for name in ALL if name not in OF_GRIPS]
    if wrong := sorted(chosen - set(known)):
        bound = f"one of {', '.join(known)}"
        raise DesignError([Fault("--fault", name, bound, "correct it") for name in wrong])
    drawn = perturb(design, chosen, seed)
    own, rng = drawn.design, stream(seed, "noise on a simulated bench")
    hardware, plates = own.rig.hardware, gage_array(own)
    plan, lean = protocol(design), drawn.object.tilt_deg
    problems = leaning(bench_finger(own, plan, fidelity, mesh=mesh).model()[1], own, plan, lean)

    def imperfect(problem: ContactProblem, of: Hardware) -> Plant:
        return ImperfectPlant(CondensedPlant(problem, own.gages.face), of, rng, plates)

    phases = [
        _recorded(phase, imperfect(problem, hardware.at_rest(_AT_REST)))
        for phase, problem in zip(plan, problems, strict=True)
    ]
    moves = [(0.0, design.grip.preload_mm)] + [(0.0, 0.0)] * (_QUICK + hardware.delay_samples)
    plant = imperfect(problems[0], hardware)
    trace = trace_of([plant.move(*each) for each in moves], moves, hardware.sample_rate_Hz)
    quick = replace(plan[0], name="quick.csv", kind="quick", points=points_of(trace), trace=trace)
    return SimulatedBench((*phases, quick), own, lean)


def _recorded(phase: Phase, plant: Plant) -> Phase:
    moves = phase.points.moves
    trace = trace_of([plant.move(*each) for each in moves], moves, _POINTS_A_SECOND)
    trace = replace(trace, lifted=None)
    points = points_of(trace, _AT_REST)
    return replace(phase, points=points, samples=float(_AT_REST), trace=trace)
