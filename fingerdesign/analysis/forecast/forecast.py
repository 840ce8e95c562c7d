"""The forecast: size, memory and time of an analysis, before anything is built.

    forecast_case(Case(design, scene, "3d")).memory_MB

Counts of elements come from the same size fields that the meshers are given (counts.py), what
they cost from fitted laws and this machine's measured speed (runtime/machine.py).
"""

import functools
import math
from contextlib import suppress
from dataclasses import dataclass, replace

from fingerdesign.analysis.answers import requested_products
from fingerdesign.analysis.case import FIDELITIES, Case, Clock
from fingerdesign.analysis.fidelity.ladder import tolerance_faults
from fingerdesign.analysis.fidelity.rungs import can_extrude
from fingerdesign.analysis.finite_path import finite_faults
from fingerdesign.analysis.forecast.counts import Counts, count_model
from fingerdesign.analysis.mesh_error import absence
from fingerdesign.analysis.path import steps_sideways
from fingerdesign.analysis.stages import zone_of
from fingerdesign.checks.meshing import plane_strain_faults
from fingerdesign.checks.scene import scene_faults
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault, MeshError
from fingerdesign.layout.rows import mirrors_in_z
from fingerdesign.mesh.make import mesher_of
from fingerdesign.mesh.section.section import sheet_room_faults
from fingerdesign.runtime.machine import Machine, busy, this_machine
from fingerdesign.runtime.progress import ForecastProgress, Progress, Report

# Operations, memory and seconds by stage of a model of a given size.
#
# Laws fitted by least squares in logarithms to whole runs of `analyse` (shipped and random designs,
# plane strain and 3-D, 13k to 400k dofs), each in a process of its own. Times are those of a core
# that multiplies matrices at ONE_CORE GFLOP/s, and grow as a machine is slower than that; measured
# seconds were scaled by what dgemm reached right before and after each run.

ONE_CORE = 60.0  # GFLOP/s of one core: what the seconds below are those of
# Operations of the factorisation with its border, n dofs, and how many times they were that:
#   plane strain   12 models of 13k to 402k dofs   exp(5.66) n^1.30 retained^0.18       0.88 to 1.09
#   extruded       22 models of 12k to 499k dofs   exp(3.40) (n / L)^1.77 L^2.68        0.62 to 1.49
#   tetrahedra     12 models of 18k to 500k dofs   exp(5.09) n^1.754, half of a finger  0.75 to 1.35
#                                                  2.25 times that, a whole one
# L: layers and a half. P1 and P2 meshes, and fingers of 1 to 21 plates, are among them.
_FLAT = (5.66, 1.30, 0.18)
_SWEPT = (3.40, 1.77, 2.68)
_TETRAHEDRA, _WHOLE = (5.09, 1.754), 2.25
# PARDISO's factors, kB: exp(a) n^b operations^c; the process, MB: base + per dof + factors.
_FACTORS = {2: (-2.311, 0.719, 0.253), 3: (-3.467, 0.546, 0.414)}  # 0.98 to 1.02, 0.93 to 1.12
_BASE_MB = 140.0  # libraries, and what the report's figures take
_OF_PROCESS = {2: (-1.71e-3, 3.82), 3: (3.02e-3, 0.975)}  # 0.95 to 1.06, 0.94 to 1.05
# Of tetrahedra, what the contact's m nodes add, MB: exp(a) m^b n^c. 29 random fingers of 17k to
# 144k dofs and 170 to 1749 nodes took 0.71 to 1.40 times the whole.
_CONTACT_SPACE = (4.62, 1.197, -0.537)
_TETRAHEDRA_MB = 500.0  # CAD's process, for fTetWild; its own stayed below up to 80k tetrahedra
# Entries of the upper triangle per dof, and seconds for each to be ordered and laid out.
_ENTRIES = {2: 14.6, 3: 47.0}
_ORDERING_S = 0.64e-6
_FACTOR_SHARE = 0.6  # of dgemm's speed


# Time of a row that is cut by default, its error's estimate included, in times of one increment a
# row: 2.3 and 1.5 in plane strain, 1.7 and 1.2 in 3-D.
_CUT = 3.5
_TANGENTS = 2.5  # factorisations a row at finite strain, with what is solved between them
_FINITE_MEMORY = 1.8  # The factors at rest stay in memory too.
# Work on the second model of the mesh's error over that on the first, by the first's mesher.
_SECOND = {"netgen": 0.45, "sweep": 0.2, "tetwild": 0.15}
_BUSY = " now (it is busy)"


def impossible(case: Case, scene: Scene) -> list[Fault]:
    """Every fault that design, scene and fidelity have together; none: they go together."""
    faults = list(scene_faults(scene, case.design))
    if case.fidelity not in FIDELITIES:
        bound = f"one of {', '.join(FIDELITIES)}"
        faults.append(Fault("--fidelity", case.fidelity, bound, "choose one"))
    if case.fidelity in ("3d", "finite"):
        faults += _space_faults(case, scene)
    if case.fidelity == "finite":
        faults += finite_faults(case.design, scene)
    if case.fidelity == "plane-strain":
        faults += _section_faults(case.design)
        if steps_sideways(scene):
            bound = "'3d' for a scene that is not the same in every section"
            need = "take 3d: a sphere, a turned object or one along x, shear_z and twist need it"
            faults.append(Fault("--fidelity", case.fidelity, bound, need))
    if case.fidelity in ("plane-strain", "auto") and (off := case.design.grip.off_centre_mm):
        bound = f"0 for --fidelity {case.fidelity}: an object turns about the normal in 3-D alone"
        faults.append(Fault("grip.off_centre_mm", off, bound, "take --fidelity 3d"))
    if case.fidelity == "auto":
        faults += tolerance_faults(case.tolerance)
        if case.design.mesh.mesher == "file":
            bound = "'tetwild' or 'sweep' for --fidelity auto, which makes meshes of its own"
            faults.append(Fault("mesh.mesher", "file", bound, "take --fidelity 3d"))
        faults += [] if can_extrude(case.design) else _space_faults(case, scene)
    return faults


def _section_faults(design: Design) -> list[Fault]:
    """Faults that one section cannot show, and a mesh's file that would not be read."""
    faults = plane_strain_faults(design) or sheet_room_faults(design)
    if design.mesh.mesher == "file":
        bound = "'tetwild' or 'sweep' for plane strain, which reads no mesh.file"
        faults = [*faults, Fault("mesh.mesher", "file", bound, "take --fidelity 3d")]
    return faults


def _space_faults(case: Case, scene: Scene) -> list[Fault]:
    """Faults that the design's mesher refuses."""
    half = mirrors_in_z(case.design) and scene.mirrors_in_z
    return mesher_of(case.design).refusals(case.design, half)


def operations(counts: Counts) -> float:
    """Floating-point operations of condensing."""
    if counts.dimension == 2:
        a, b, c = _FLAT
        return float(math.exp(a) * counts.dofs**b * max(counts.retained, 1.0) ** c)
    if counts.layers:
        (a, b, c), parts = _SWEPT, counts.parts
        layers = counts.layers / parts + 0.5
        return float(parts * math.exp(a) * (counts.dofs / parts / layers) ** b * layers**c)
    a, b = _TETRAHEDRA
    return float(math.exp(a) * counts.dofs**b * (1.0 if counts.half else _WHOLE))


def peak_memory_MB(counts: Counts) -> float:
    """The process's greatest resident memory, or that of one it starts."""
    (a, b, c), (per_dof, share) = _FACTORS[counts.dimension], _OF_PROCESS[counts.dimension]
    work, parts = operations(counts), counts.parts
    factors = 1e-3 * parts * math.exp(a) * (counts.dofs / parts) ** b * (work / parts) ** c
    own = _BASE_MB + per_dof * counts.dofs + share * factors
    if counts.dimension == 2 or counts.layers:  # no other process meshes
        return float(own)
    a, b, c = _CONTACT_SPACE
    own += math.exp(a) * max(counts.contact_nodes, 1.0) ** b * counts.dofs**c
    return float(max(own, _TETRAHEDRA_MB))


def stage_seconds(counts: Counts, case: Case, machine: Machine) -> dict[str, float]:
    """Seconds by stage, as a result's timings_s names them."""
    entries = _ENTRIES[counts.dimension] * counts.dofs
    slow = ONE_CORE / machine.one_core
    seconds = {
        "geometry": 0.0,  # CAD files are made concurrently.
        "mesh": _mesh_seconds(counts, case) * slow,
        "assemble": (9e-6 if counts.dimension == 2 else 60e-6) * counts.elements * slow,
        "condense": 0.05 * slow
        + _ORDERING_S * entries * slow
        + operations(counts) / (1e9 * _FACTOR_SHARE * machine.all_cores),
        "increments": _increments(counts, case) * slow,
    }
    if case.fidelity == "finite":
        rows = len(case.path_scene.path.rows) * (case.path_scene.path.substeps or 1)
        once = seconds["condense"] + 5.0 * seconds["assemble"]
        seconds["increments"] += _TANGENTS * rows * once
    grips = _grips(counts, case)
    waited = _second_seconds(counts, case, seconds, machine.cores, grips * slow)
    if grips or waited:
        seconds["grips"] = grips * slow + waited
    page, _ = requested_products(case, None, None)
    drawn = 1.5 + (1.0 if grips else 0.0) if page else 0.0
    seconds["report"] = (0.2 + drawn + 1e-5 * counts.elements) * slow
    return seconds


def _second_seconds(
    counts: Counts, case: Case, seconds: dict[str, float], cores: int, grips: float
) -> float:
    """Wait for the mesh's second model, which is made while another core follows the path and
    grips; the stage "grips" has it."""
    if absence(case):
        return 0.0
    first = sum(seconds[stage] for stage in ("assemble", "condense", "increments"))
    second = _SECOND[counts.mesher] * first
    return max(0.0, second - (seconds["increments"] + grips if cores > 1 else 0.0))


def _mesh_seconds(counts: Counts, case: Case) -> float:
    """fTetWild's time goes with the root of what it makes; it scatters by 1.5 (a standard
    deviation), and by as much again where an attempt is made again."""
    if counts.mesh_kept:
        return 0.3 + 5e-6 * counts.elements
    if counts.mesher == "netgen":
        return 0.1 + 52e-6 * counts.elements
    if counts.mesher == "sweep":
        return 0.15 + 10e-6 * counts.elements
    revolved = 1.35 if case.design.body.kind.turned else 1.0
    return 0.13 * revolved * math.sqrt(counts.elements)


def _row(counts: Counts, followed: bool = False) -> float:
    """Seconds of one increment of contact, small dense systems of the contact's dofs; ``followed``
    from the one before, as a grip's small steps are."""
    contact = counts.dimension * counts.contact_nodes
    return 0.5e-3 + 1.0e-9 * contact**2 if followed else 1e-3 + 4.6e-9 * contact**2


def _increments(counts: Counts, case: Case) -> float:
    """The path, and where no scene is given the slip study of it at further frictions."""
    path = case.path_scene.path
    studied = 5 if case.scene is None and len(case.gage_array) > 1 else 0
    return len(path.rows) * ((path.substeps or _CUT) + studied) * _row(counts)


def _grips(counts: Counts, case: Case) -> float:
    """Each grip with the rule and without, and the rig's calibration; 60 % of the stage's travel
    is what grips used."""
    if not case.runs_grips:
        return 0.0
    grip = case.design.grip
    travel = (grip.max_approach_mm - grip.preload_mm) / grip.approach_step_mm
    steps = min(float(grip.max_steps), 0.6 * max(travel, 1.0))
    runs = 2 if case.for_page else 1
    masses = len(grip.masses_g) + (grip.middle_g is not None)
    grips = masses * (runs * len(grip.friction_coefficients) + 1)
    return grips * steps * _row(counts, followed=True)


@dataclass(frozen=True, kw_only=True)
class Forecast(Counts):
    """Cost of an analysis, with the size of its model in whole numbers.

    fidelity        "plane-strain", "3d" or "finite"
    memory_MB       greatest resident memory of the process, or of one that it starts
    seconds         by stage, as result.timings_s; total_s: their sum
    operations      floating-point ones of condensing
    words           what it rests on, a sentence; machine_words: the machine it is for
    """

    fidelity: str
    memory_MB: float
    seconds: dict[str, float]
    operations: float
    words: str
    machine_words: str

    @property
    def total_s(self) -> float:
        """Seconds from the design to the written report."""
        return sum(self.seconds.values())

    def __str__(self) -> str:
        return (
            f"{self.dofs} equations, {self.contact_nodes} contact nodes, "
            f"{self.memory_MB / 1024.0:.1f} GB, {_duration(self.total_s)}"
        )

    def as_dict(self) -> dict[str, object]:
        """Plain values, units in the keys."""
        names = ("fidelity", "half", "mesher", "element", "elements", "dofs", "contact_nodes")
        return {
            **{name: getattr(self, name) for name in names},
            "memory_MB": round(self.memory_MB),
            "time_s": round(self.total_s, 1),
            "timings_s": {name: round(value, 2) for name, value in self.seconds.items()},
            "mesh_kept": self.mesh_kept,
            "words": self.words,
        }


def _duration(seconds: float) -> str:
    hours = seconds / 3600.0
    long = f"{hours:.1f} hours; fewer rows or a coarser mesh take less, --time-limit ends it"
    return f"{seconds:.0f} s" if hours < 0.5 else long


def forecasts(design: Design, scene: Scene | None = None) -> list[Forecast]:
    """The forecast at each fidelity that the design can be analysed at in the scene."""
    found = []
    for fidelity in ("plane-strain", "3d"):
        case = Case(design, scene, fidelity, go_on=True)
        with suppress(DesignError, MeshError):  # it cannot be analysed so: the analysis says why
            if not impossible(case, case.path_scene):
                found.append(forecast_case(case))
    return found


def forecast_case(case: Case, machine: Machine | None = None) -> Forecast:
    """Forecast the cost of ``pipeline.run`` and of the report.

    machine: its speed, by default this one's as measured within a day. Of 42 analyses, 10k to 250k
    dofs, dofs were predicted within 1.5, memory within 1.3, time within 1.5 (``bench forecast``);
    farthest off where the contact outgrew its zone and the model was made again. Of random fingers
    nine in ten are within a factor of two (``--random``); contact on STEP bodies is underrated.
    ValueError for fidelity "auto": which models that will take is found while it works.
    """
    if case.fidelity == "auto":
        raise ValueError("fidelity auto: which models it will take cannot be predicted")
    bare = replace(case, go_on=False, estimator=None)  # neither changes what it takes
    return _forecast(bare, this_machine() if machine is None else machine)


def forecast_progress(case: Case, show: Progress, clock: Clock) -> Report:
    """A report that shows the fraction of the forecast seconds whose stages ``clock`` has timed.

    Without a fraction for fidelity "auto": its models are found while it works.
    """
    if case.fidelity == "auto":
        return show
    found = forecast_case(case)
    show(f"forecast: {found}")
    return ForecastProgress(show, found.seconds, clock.seconds)


@functools.lru_cache(maxsize=16)  # a command asks for the same one several times
def _forecast(case: Case, machine: Machine) -> Forecast:
    zone = zone_of(case, case.path_scene)
    counts = count_model(case, zone)
    made = mesher_of(case.design).elements_from
    if counts.mesher == "netgen":
        made = "netgen's size field integrated over the section"
    if counts.mesh_kept:
        read = case.design.mesh.mesher == "file"
        made = "the mesh's file" if read else "the mesh in the cache"
    own = (
        f"{machine.cores} core{'s' * (machine.cores != 1)}, one of which multiplies matrices at "
        f"{machine.one_core:.0f} GFLOP/s{_BUSY if busy(machine.cores) else ''}"
    )
    words = f"elements from {made}; memory and time from laws fitted to measured runs, on {own}"
    whole = {key: round(getattr(counts, key)) for key in ("elements", "dofs", "contact_nodes")}
    return Forecast(
        **(vars(counts) | whole),
        fidelity=case.fidelity,
        memory_MB=peak_memory_MB(counts) * (_FINITE_MEMORY if case.fidelity == "finite" else 1.0),
        seconds=stage_seconds(counts, case, machine),
        operations=operations(counts),
        words=words,
        machine_words=own,
    )
