"""Siconos and GetFEM on problems handed over as arrays; run by the Python that they belong to.

    python3 peers_worker.py probe - OUT.json
    python3 peers_worker.py condensed|full PROBLEM.npz OUT.npz

Debian installs both for its own Python, so this file imports numpy and them, nothing of ours. Times
are processor seconds of one thread; imports and reading files are not in them.
"""

import json
import sys
import time
from importlib import import_module, metadata
from pathlib import Path
from typing import Any

import numpy as np

SAME = 1e-6  # of the largest nodal force: what an answer may differ from the reference
TOLERANCES = 10.0 ** -np.arange(5, 13)  # of a solver's own residual, about the loosest that does
# Solver of Siconos, iterations, whether it begins from given forces. Parameters are Siconos's own
# but for the local solver of Gauss-Seidel: projections take 0.7 of the default's time here. The
# plane solvers begin from zero whatever is given.
METHODS = {
    2: (("2D_NSGS", 20_000, False), ("2D_LEMKE", 20_000, False)),
    3: (("3D_NSGS", 5000, True), ("3D_NSN_AC", 100, True), ("3D_ADMM", 3000, True)),
}
LOCAL = "ONECONTACT_ProjectionOnConeWithLocalIteration"
RESIDUAL = 1e-7  # of GetFEM's Newton; rounding ends it at 4e-9
AUGMENTATION = 1.0  # MPa/mm: from 10 on it does not converge, 0.1 takes a fifth more iterations
# Our nodes, corners before mid-edge ones, in GetFEM's order.
ORDER = {2: (0, 3, 1, 5, 4, 2), 3: (0, 4, 1, 6, 5, 2, 7, 8, 9, 3)}


def probe() -> dict[str, str]:
    """Versions of what this Python can import."""
    found = {}
    for name, module in (("siconos", "siconos.numerics"), ("getfem", "getfem")):
        try:
            loaded = import_module(module)
        except ImportError:
            continue
        getfem = name == "getfem"
        found[name] = loaded.getfem_env("version") if getfem else metadata.version(name)
    return found


def condensed(problem: Any) -> dict[str, Any]:
    """Each increment by each method, from zero and from the forces of the increment before.

    problem: compliance (m dim, m dim), offset, start and reference (k, m, dim), friction, scale
    mm/N; tolerance (runs, k) where an earlier call found it. Returns, a row a run: names, seconds,
    tolerance, converged (runs, k), forces (runs, k, m, dim).
    """
    reference = problem["reference"]
    runs = [
        (name, most, warm)
        for name, most, either in METHODS[reference.shape[2]]
        for warm in ((False, True) if either else (False,))
    ]
    known = problem.get("tolerance", np.zeros((len(runs), len(reference))))
    rows: dict[str, list[Any]] = {"seconds": [], "tolerance": [], "converged": [], "forces": []}
    for run, tolerances in zip(runs, known, strict=True):
        found, first = [], 0
        for k, tolerance in enumerate(tolerances):
            # One looser than the last increment needed, then tighter.
            tried = [tolerance] if tolerance else TOLERANCES[first:]
            found.append(_loosest(problem, k, run, tried))
            first = max(int(np.searchsorted(-TOLERANCES, -found[-1][1])) - 1, 0)
        for key, values in zip(rows, zip(*found, strict=True), strict=True):
            rows[key].append(values)
    names = [f"{name} {'warm' if warm else 'cold'}" for name, _, warm in runs]
    return {"names": names, **rows}


def _loosest(
    problem: Any, k: int, run: tuple[str, int, bool], tolerances: Any
) -> tuple[float, float, bool, Any]:
    """Seconds, tolerance, whether it converged, and forces by the first tolerance that does."""
    answer = problem["reference"][k]
    for tolerance in tolerances:
        seconds, ended, force = _solve(problem, k, run, float(tolerance))
        close = np.abs(force - answer).max() <= SAME * np.abs(answer).max()
        if close or not ended:
            break
    return seconds, tolerance, ended and close, force


def _solve(
    problem: Any, k: int, run: tuple[str, int, bool], tolerance: float
) -> tuple[float, bool, Any]:
    """Seconds of the driver, whether it says that it converged, forces (m, dim)."""
    name, most, warm = run
    siconos = import_module("siconos.numerics")
    m, dim = problem["offset"][k].shape
    options = siconos.SolverOptions(getattr(siconos, f"SICONOS_FRICTION_{name}"))
    options.dparam[siconos.SICONOS_DPARAM_TOL] = tolerance
    options.iparam[siconos.SICONOS_IPARAM_MAX_ITER] = most
    if name == "3D_NSGS":
        local = getattr(siconos, f"SICONOS_FRICTION_3D_{LOCAL}")
        siconos.solver_options_update_internal(options, 0, local)
    # Some residuals add forces and motions: motions are divided by a typical compliance.
    compliance, offset = (problem[key] / problem["scale"] for key in ("compliance", "offset"))
    friction = np.full(m, float(problem["friction"]))
    given = siconos.FrictionContactProblem(dim, m, compliance, offset[k].ravel().copy(), friction)
    force = problem["start"][k].ravel().copy() if warm else np.zeros(m * dim)
    motion = np.zeros(m * dim)
    driver = siconos.fc3d_driver if dim == 3 else siconos.fc2d_driver
    begin = time.process_time()
    ended = driver(given, force, motion, options) == 0
    return time.process_time() - begin, ended, force.reshape(m, dim)


def full(problem: Any) -> dict[str, Any]:
    """The whole body by GetFEM: seconds of set-up and of each row, whether it converged, forces,
    and displacement gradients (rows, q, dim, dim), or transposed, at points_read (q, dim)."""
    getfem = import_module("getfem")
    getfem.util_trace_level(0)
    getfem.util_warning_level(0)
    begin = time.process_time()
    model, integration, right, height, free = _model(getfem, problem)
    setup = time.process_time() - begin
    crest, dim = float(problem["crest"]), right.shape[0]
    seconds, converged, forces, gradients, sheared = [], [], [], [], 0.0
    for approach, shear in problem["path"]:
        begin = time.process_time()
        model.set_variable("obstacle", crest - approach - height)
        # Friction acts on what u moves beyond the object: the last u, moved on with the object.
        model.set_variable("before", model.variable("u") + (shear - sheared) * right[0])
        done = model.solve("max_res", RESIDUAL, "max_iter", 60, "lsolver", "mumps")
        seconds.append(time.process_time() - begin)
        converged.append(bool(done[1]))
        sheared = shear
        sums = [
            np.ravel(getfem.asm_generic(integration, 0, f"force({k + 1})", 1, model))[0]
            for k in range(dim)
        ]
        forces.append(float(problem["thickness"]) * np.array(sums))
        points = np.ascontiguousarray(problem["points_read"].T)
        slopes = model.interpolation("Grad_u", points, model.in_use[0])
        gradients.append(slopes.reshape(-1, dim, dim))
    return {
        "setup": setup,
        "seconds": seconds,
        "converged": converged,
        "forces": forces,
        "gradients": gradients,
        "dofs": int(free.sum()),
    }


def _model(getfem: Any, problem: Any) -> tuple[Any, Any, Any, Any, Any]:
    """Our mesh, elasticity, contact by an augmented Lagrangian: multipliers linear, u quadratic.

    Returns model, integration, unit motions (dim, free dofs), height of the obstacle's nodes, and
    which dofs are free.
    """
    points, cells = problem["points"], problem["cells"][:, ORDER[problem["points"].shape[1]]]
    dim = points.shape[1]
    mesh = getfem.Mesh("empty", dim)
    corners = np.ascontiguousarray(points[cells].transpose(2, 1, 0))
    numbers = mesh.add_convex(getfem.GeoTrans(f"GT_PK({dim},2)"), corners)
    node = np.full(len(points), -1)
    node[cells.reshape(-1)] = mesh.pid_from_cvid(numbers)[0]
    mesh.set_region(1, mesh.faces_from_pid(node[np.unique(problem["contact"])]))

    def space(size: int, element: str) -> Any:
        made = getfem.MeshFem(mesh, size)
        made.set_fem(getfem.Fem(element))
        return made

    whole = space(dim, f"FEM_PK({dim},2)")
    ours = np.empty(whole.nbdof(), dtype=int)
    each = (cells.reshape(-1, 1) * dim + np.arange(dim)).reshape(-1)
    ours[whole.basic_dof_from_cvid(numbers)[0]] = each
    free = ~problem["fixed"].reshape(-1)[ours]
    moved = getfem.MeshFem("partial", whole, np.flatnonzero(free))
    constant = space(1, f"FEM_PK_DISCONTINUOUS({dim},0)")
    linear = space(1, f"FEM_PK({dim},1)")
    place = constant.basic_dof_from_cvid(numbers)[0]
    young, poisson = problem["young"], problem["poisson"]
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))
    model = getfem.Model("real")
    model.add_fem_variable("u", moved)
    for name, values in zip(("first", "second"), lame, strict=True):
        by_dof = np.empty(len(values))
        by_dof[place] = values
        model.add_initialized_fem_data(name, constant, by_dof)
    rule = "IM_TRIANGLE(6)" if dim == 2 else "IM_TETRAHEDRON(6)"
    integration = getfem.MeshIm(mesh, getfem.Integ(rule))
    model.add_isotropic_linearized_elasticity_brick(integration, "u", "first", "second")
    multipliers = space(dim, f"FEM_PK({dim},1)")
    model.add_filtered_fem_variable("force", multipliers, 1)
    height = linear.basic_dof_nodes()[1]
    model.add_initialized_fem_data("obstacle", linear, float(problem["crest"]) - height)
    model.add_initialized_fem_data("before", moved, np.zeros(int(free.sum())))
    values = (("r", AUGMENTATION), ("friction", float(problem["friction"])), ("rate", 1.0))
    for name, value in values:
        model.add_initialized_data(name, [value])
    model.add_integral_contact_with_rigid_obstacle_brick(
        integration, "u", "force", "obstacle", "r", "friction", 1, 1, "rate", "before"
    )
    # GetFEM frees a mesh or a space that Python forgets, though the model still needs it.
    model.in_use = (mesh, whole, moved, constant, linear, multipliers)
    right = np.array([ours[free] % dim == k for k in range(dim)], dtype=float)
    return model, integration, right, height, free


def main(task: str, source: str, target: str) -> None:
    """Do one task; see above."""
    if task == "probe":
        Path(target).write_text(json.dumps(probe()), encoding="utf-8")
        return
    with np.load(source) as problem:
        found = {"condensed": condensed, "full": full}[task](dict(problem))
    np.savez(target, **found)


if __name__ == "__main__":
    main(*sys.argv[1:])
