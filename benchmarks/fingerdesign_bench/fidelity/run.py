"""Every rung of every pair, solved once and stored: the ladder and fixed models are judged by them.

A record has readings, equations, seconds, and cost: seconds on one thread, of the processor where
that was busy with other work as well (the mesher's by the clock). References, much finer models in
space, are computed once and shipped (fidelity_references.json).
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from fingerdesign.analysis.fidelity.ladder import GROWTH
from fingerdesign.analysis.fidelity.models import Dimension, InTurn, Model
from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.analysis.fidelity.rungs import SECTION_SCALES, SPACE_SCALES, rung
from fingerdesign.errors import FingerDesignError
from fingerdesign_bench.fidelity.pairs import Pair, pairs
from fingerdesign_bench.files import Record

MOST_DOFS = 150_000  # of the rungs, so that references can be finer than they
REFERENCE_SCALES = (0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 1.0)
_REFERENCE_DOFS = 350_000  # the finest of them with about so many equations: 8 GB
_WHOLE_DOFS = 420_000  # of the one model for all where the ladder has ended before: 10 GB


@dataclass(frozen=True)
class Recorded:
    """A solved rung as it was stored; the ladder takes it for the solve itself."""

    model: Model
    readings: Readings
    dofs: int
    contact_nodes: int
    total: float


def model_key(model: Model) -> str:
    """Name of a rung, different from those of the pair's others."""
    return f"{model.name}, {model.sizes.far_size_mm:.3g}"


def plain(readings: Readings) -> Record:
    """Readings as lists, for JSON."""
    return {
        name: np.round(value, 9).tolist() if isinstance(value, np.ndarray) else value
        for name, value in vars(readings).items()
    }


def readings_from(record: Record) -> Readings:
    """The readings that :func:`plain` wrote."""
    arrays = {name: np.array(value) for name, value in record.items() if name != "face"}
    rows = len(arrays["normal_force"])
    arrays["gages"] = arrays["gages"].reshape(rows, -1, 2)
    return Readings(**arrays, face=record["face"])


def rungs_of() -> list[tuple[Dimension, float]]:
    """Dimension and scale of every rung that the ladder may try, cheapest first."""
    section: list[tuple[Dimension, float]] = [("plane strain", SPACE_SCALES[0])]
    section += [("plane strain", scale) for scale in SECTION_SCALES if scale != SPACE_SCALES[0]]
    return [*section, *(("3-D", scale) for scale in SPACE_SCALES)]


def solve_rungs(pair: Pair) -> list[Record]:
    """All rungs of a pair, the finest as far as the ladder would go."""
    solve = InTurn()
    found: list[Record] = []
    last = (0, 0.0)
    first = rungs_of()[0]
    solve(pair.design, pair.scene, rung(pair.design, pair.scene, *first))  # loads the libraries
    for dimension, scale in rungs_of():
        if dimension == "3-D" and last[0] * (last[1] / scale) ** GROWTH > MOST_DOFS:
            break
        found.append(_record(pair, dimension, scale, solve))
        if dimension == "3-D":
            last = (found[-1]["dofs"], scale)
    return found


def _record(pair: Pair, dimension: Dimension, scale: float, solve: InTurn) -> Record:
    model = rung(pair.design, pair.scene, dimension, scale)
    start = time.process_time()
    solved = solve(pair.design, pair.scene, model)
    spent = time.process_time() - start
    return {
        "pair": pair.number,
        "dimension": dimension,
        "scale": scale,
        "key": model_key(model),
        "dofs": solved.dofs,
        "contact_nodes": solved.contact_nodes,
        "seconds": solved.seconds,
        "cost_s": min(solved.total, spent + solved.seconds["mesh"]),
        "readings": plain(solved.readings),
    }


def _finest(scales: Sequence[float], dofs_at_one: int, most: int) -> float:
    """The first scale with about ``most`` equations or fewer; the last where none has."""
    return next((s for s in scales if dofs_at_one * s**-GROWTH <= most), scales[-1])


def solve_reference(pair: Pair, dofs_at_one: int) -> Record:
    """The much finer model in space: plates as the design says, more layers, smaller sizes."""
    scale = _finest(REFERENCE_SCALES, dofs_at_one, _REFERENCE_DOFS)
    solve, coarsest = InTurn(), SPACE_SCALES[0]  # which shows how wide a zone it takes
    for each in (coarsest, scale):
        solved = solve(pair.design, pair.scene, rung(pair.design, pair.scene, "3-D", each))
    return {
        "pair": pair.number,
        "scale": scale,
        "dofs": solved.dofs,
        "contact_nodes": solved.contact_nodes,
        "seconds": solved.total,
        "digest": pair.digest(),
        "readings": plain(solved.readings),
    }


def solve_finest(pair: Pair, dofs_at_one: int) -> list[Record]:
    """The finest size of all, where the ladder of the pair ends before it: one model for all has
    it everywhere. As near to it as the machine's memory lets; none where the rungs have it."""
    finest = SPACE_SCALES[-1]
    if dofs_at_one * finest**-GROWTH <= MOST_DOFS:
        return []
    sizes = [s for s in REFERENCE_SCALES if s >= finest]
    scale, solve = _finest(sizes, dofs_at_one, _WHOLE_DOFS), InTurn()
    solve(pair.design, pair.scene, rung(pair.design, pair.scene, "3-D", SPACE_SCALES[0]))
    found = _record(pair, "3-D", scale, solve)
    return [{**found, "scale": finest, "made_scale": scale, "beyond": True}]


def work(task: tuple[str, int, int]) -> Record:
    """The "records" of one task of a pair: kind, number, and its equations at scale 1."""
    kind, number, dofs = task
    pair = pairs()[number]
    try:
        with threadpool_limits(1):
            if kind == "reference":
                return {"records": [solve_reference(pair, dofs)]}
            return {"records": solve_finest(pair, dofs) if dofs else solve_rungs(pair)}
    except FingerDesignError as error:
        return {"failure": str(error)}


def recorded(pair: Pair, record: Record) -> Recorded:
    """A rung's record as the ladder sees it."""
    made = float(record.get("made_scale") or record["scale"])
    model = rung(pair.design, pair.scene, record["dimension"], made)
    return Recorded(
        model,
        readings_from(record["readings"]),
        record["dofs"],
        record["contact_nodes"],
        record["cost_s"],
    )
