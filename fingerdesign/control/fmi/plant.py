"""A finger against a plane as a functional mock-up unit: the plant of a regulator.

    (folder / FILE).write_bytes(plant_fmu(grip_problem(design), design))

The condensed model is a resource; plant.c follows it with the simulation's own kernel.c and its
certificate, on dense.c instead of BLAS. A step is one move (dx, dy) of the object, as of
:class:`CondensedPlant`, and answers agree with that to 1e-9. A move without an accepted answer is
an error of the unit, which then is where it was. Rubber relaxes, and sensors err, in Python alone.

A unit has at most MOST_BYTES. Nearly all of it is half of the symmetric compliance. Its doubles are
rounded to 34 bits of mantissa, and what is then zero compresses away: up to some 630 dofs fit, so
all shipped fingers in plane strain, and half a finger in 3-D with ``mesh.layers = 2`` and a zone of
some 210 nodes.
"""

from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact import solver
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.c_code import filled_template
from fingerdesign.control.fmi.pack import Unit, Variable
from fingerdesign.control.signals import reading_readout
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault

MODEL = "plant"
FILE = f"{MODEL}.fmu"
MOST_BYTES = 1_000_000
_LEAST_PACKED = 0.5  # Of a finger's doubles 0.6 is left: beyond this nothing need be compressed.
# Forces of 300 moves then differ by 2e-11 of a step's largest (film_tees and sensitive in 3-D).
# Single precision leaves out 29 bits and is off by 1.5e-8: over the 1e-9 that is promised.
_LEFT_OUT_BITS = 18


def refuse_sliding(design: Design) -> None:
    """Raise DesignError for friction that falls where it slides: the unit knows no such."""
    if (share := design.grip.kinetic_share) != 1.0:
        remedy = "set it to 1: the unit knows one coefficient"
        raise DesignError([Fault("grip.kinetic_share", share, "1", remedy)])


def plant_fmu(problem: ContactProblem, design: Design) -> bytes:
    """The unit of a finger that is posed against a plane, with its readings and its friction.

    Raises DesignError for a unit over MOST_BYTES, and as of :func:`refuse_sliding`.
    """
    refuse_sliding(design)
    grip, model, (m, dim) = design.grip, problem.model, problem.shape
    places = {
        "@design@": design.design.name,
        "@nodes@": str(m),
        "@dim@": str(dim),
        "@gages@": str(len(model.gage_x)),
        "@typical@": repr(problem.typical_compliance),
        "@symmetry@": repr(float(model.symmetry_factor)),
        "@balanced@": ", ".join(str(int(free)) for free in model.balanced),
        "@friction@": repr(float(grip.friction_coefficients[0])),
        "@mass@": repr(float(grip.heaviest_g)),
    }
    sources = {name: filled_template(name, places) for name in ("plant.c", "dense.c", "fmi2.c")}
    sources["kernel.c"] = (Path(solver.__file__).parent / "kernel.c").read_text("utf-8")
    numbers = _numbers(problem, design.gages.face)
    # High bytes first: exponents compress, the rest of a double does not.
    planes = numbers.astype(">f8").view(np.uint8).reshape(-1, 8).T.tobytes()
    period = 1.0 / grip.hardware.sample_rate_Hz
    words = f"the finger {design.design.name} against a plane, {m} contact nodes"
    unit = Unit(MODEL, words, _variables(len(model.gage_x), places), period)
    flags = ("-O3", "-s", "-fvisibility=hidden")
    size = int(_LEAST_PACKED * len(planes))
    if size <= MOST_BYTES:
        packed = unit.packed(sources, {"model.bin": planes}, flags)
        size = len(packed)
    if size > MOST_BYTES:
        given = f"{1e-3 * size:.0f} kB with {m} contact nodes in {dim}-D"
        remedy = "set a larger mesh.section.contact_size_mm, or a smaller grip.max_approach_mm"
        if dim == 3:
            remedy = "take --fidelity plane-strain, or set mesh.layers = 2, and if that is not "
            remedy += "enough a larger mesh.contact_size_mm: some 210 nodes fit"
        raise DesignError([Fault("plant.fmu", given, f"{1e-3 * MOST_BYTES:.0f} kB", remedy)])
    return packed


def _numbers(problem: ContactProblem, face: str) -> Array:
    """The resource, in the order of plant.c."""
    model, (m, dim) = problem.model, problem.shape
    parts = [
        _rounded(problem.compliance[np.tril_indices(m * dim)]),
        problem.gap0,
        problem.modes[:2],
        problem.frames,
        model.reaction_readout,
        reading_readout(model.gage_readout, face),
        model.rim,
    ]
    return np.concatenate([np.ravel(part).astype(float) for part in parts])


def _rounded(values: Array) -> Array:
    """The nearest doubles whose last _LEFT_OUT_BITS bits are zero."""
    step = np.int64(1) << _LEFT_OUT_BITS
    return ((values.view(np.int64) + (step >> 1)) & -step).view(float)


def _variables(gages: int, places: dict[str, str]) -> list[Variable]:
    """In the order of plant.c."""
    friction, mass = places["@friction@"], places["@mass@"]
    lifted = "F_t carries half the object's weight, and something sticks"
    return [
        Variable("dx", "input", "move of the object in a step, toward +x", "mm"),
        Variable("dy", "input", "move of the object in a step, onto the finger", "mm"),
        *(
            Variable(f"reading[{k + 1}]", "output", "of a gage", "microstrain")
            for k in range(gages)
        ),
        Variable("normal_force", "output", "F_n of the whole finger", "N"),
        Variable("tangential_force", "output", "F_t of the whole finger", "N"),
        Variable("approach", "output", "all moves dy", "mm"),
        Variable("shear", "output", "all moves dx", "mm"),
        Variable("friction", "parameter", "coefficient of friction", start=friction),
        Variable("object_mass", "parameter", "of an object in two fingers", "g", start=mass),
        Variable("touching", "output", "contact nodes that are closed", "", "Integer"),
        Variable("sticking", "output", "of these, the ones that stick", "", "Integer"),
        Variable("lifted", "output", lifted, "", "Boolean"),
    ]
