"""The forecast: size, memory and time of an analysis, before anything is built.

    forecast(design, scene, "3d").memory_MB

Counts of elements come from the same size fields that the meshers are given (section_count,
space_count), what they cost from fitted laws (costs) and this machine's measured speed (machine).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from fingerdesign.case import Case
from fingerdesign.errors import DesignError, MeshError
from fingerdesign.resources.costs import operations, peak_memory_MB, stage_seconds
from fingerdesign.resources.counts import count_model
from fingerdesign.resources.machine import Machine, busy, this_machine

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design


_BUSY = " now (it is busy)"


@dataclass(frozen=True)
class Forecast:
    """What an analysis will take.

    fidelity        "plane-strain" or "3d"; half: half of the finger is modelled
    mesh_kept       its mesh stands in the cache or in a file: counts are its own, no time to make
    dofs            equations of the element used; contact_nodes: candidates for contact
    memory_MB       greatest resident memory of the process, or of one that it starts
    seconds         by stage, as result.timings_s; total_s: their sum
    operations      floating-point ones of condensing
    words           what it rests on, a sentence; machine_words: the machine it is for
    """

    fidelity: str
    half: bool
    mesher: str
    element: str
    elements: int
    dofs: int
    contact_nodes: int
    memory_MB: float
    seconds: dict[str, float] = field(default_factory=dict)
    operations: float = 0.0
    mesh_kept: bool = False
    words: str = ""
    machine_words: str = ""

    @property
    def total_s(self) -> float:
        """Seconds from the design to the written report."""
        return sum(self.seconds.values())

    def __str__(self) -> str:
        return (
            f"{self.dofs} equations, {self.contact_nodes} contact nodes, "
            f"{self.memory_MB / 1024.0:.1f} GB, {self.total_s:.0f} s"
        )

    def as_dict(self) -> dict[str, object]:
        """Plain values, units in the keys."""
        return {
            "fidelity": self.fidelity,
            "half": self.half,
            "mesher": self.mesher,
            "element": self.element,
            "elements": self.elements,
            "dofs": self.dofs,
            "contact_nodes": self.contact_nodes,
            "memory_MB": round(self.memory_MB),
            "time_s": round(self.total_s, 1),
            "timings_s": {name: round(value, 2) for name, value in self.seconds.items()},
            "mesh_kept": self.mesh_kept,
            "words": self.words,
        }


def forecast(
    design: Design,
    scene: Scene | None = None,
    fidelity: str = "3d",
    machine: Machine | None = None,
) -> Forecast:
    """What ``analyse`` of a sound design would take; scene None: the fundamental case with grips.

    machine: its speed, by default this one's as measured within a day. Of 42 analyses, 10k to 250k
    dofs, dofs were foretold within 1.5, memory within 1.3, time within 1.5 (``bench forecast``);
    farthest off where the contact outgrew its zone and the model was made again.
    """
    return forecast_case(Case(design, scene, fidelity), machine)


def forecasts(design: Design, scene: Scene | None = None) -> list[Forecast]:
    """The forecast at each fidelity that the design can be analysed at in the scene."""
    from fingerdesign.refusals import refuse

    found = []
    for fidelity in ("plane-strain", "3d"):
        case = Case(design, scene, fidelity, go_on=True)
        try:
            refuse(case, case.path_scene)
            found.append(forecast_case(case))
        except (DesignError, MeshError):
            continue  # it cannot be analysed so: the analysis says why
    return found


def forecast_case(case: Case, machine: Machine | None = None) -> Forecast:
    """What ``pipeline.run`` and the report of a case would take.

    ValueError for fidelity "auto": which models that will take is found while it works.
    """
    if case.fidelity not in ("plane-strain", "3d"):
        raise ValueError(f"fidelity {case.fidelity!r}: only plane-strain and 3d can be foretold")
    bare = replace(case, go_on=False, estimator=None)  # neither changes what it takes
    return _forecast(bare, this_machine() if machine is None else machine)


@functools.lru_cache(maxsize=16)  # a command asks for the same one several times
def _forecast(case: Case, machine: Machine) -> Forecast:
    from fingerdesign.pipeline import zone_of

    zone = zone_of(case, case.path_scene)
    counts = count_model(case, zone)
    made = {
        "netgen": "netgen's size field integrated over the section",
        "extrude": "netgen's size field integrated over the section, times the layers",
        "tetwild": "fTetWild's size field integrated over the body",
    }.get(counts.mesher, "the mesh's file")
    if counts.known:
        read = case.design.mesh.mesher == "file"
        made = "the mesh's file" if read else "the mesh in the cache"
    own = (
        f"{machine.cores} core{'s' * (machine.cores != 1)}, one of which multiplies matrices at "
        f"{machine.one_core:.0f} GFLOP/s{_BUSY if busy(machine.cores) else ''}"
    )
    words = f"elements from {made}; memory and time from laws fitted to measured runs, on {own}"
    return Forecast(
        fidelity="plane-strain" if case.fidelity == "plane-strain" else "3d",
        half=counts.half,
        mesher=counts.mesher,
        element=counts.element,
        elements=round(counts.elements),
        dofs=round(counts.dofs),
        contact_nodes=round(counts.contact_nodes),
        memory_MB=peak_memory_MB(counts),
        seconds=stage_seconds(counts, case, machine),
        operations=operations(counts),
        mesh_kept=counts.known,
        words=words,
        machine_words=own,
    )
