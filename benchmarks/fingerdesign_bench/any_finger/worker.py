"""One random design meshed, in a process of its own: whatever happens happens to one design."""

import time
from typing import Any

from fingerdesign.layout.frames import mirrors_in_z


def mesh_one(seed: int) -> dict[str, Any]:
    """Mesh the random design ``seed`` without the cache; how it went, as plain values."""
    import tomlkit

    from fingerdesign.checks.load import parse_design
    from fingerdesign.design.scene import SceneObject
    from fingerdesign.errors import FingerDesignError
    from fingerdesign.layout.zone import candidate_zone
    from fingerdesign.mesh.quality import assess
    from fingerdesign.mesh.tetra.tetwild import tetrahedralise
    from fingerdesign_bench.any_finger.designs import kinds, random_design

    record: dict[str, Any] = {"seed": seed, "kinds": list(kinds(seed)), "status": "meshed"}
    design = parse_design(tomlkit.dumps(random_design(seed)))
    record["digest"] = design.digest()
    zone = candidate_zone(design, SceneObject(), 0.02 * design.body.base_height_mm)
    start = time.perf_counter()
    try:
        mesh = tetrahedralise(design, zone, mirrors_in_z(design), use_cache=False)
    except FingerDesignError as error:
        record |= {"status": "refused", "reason": f"{type(error).__name__}: {error}"}
        record["seconds"] = round(time.perf_counter() - start, 2)
        return record
    record["seconds"] = round(time.perf_counter() - start, 2)
    report = assess(mesh, design)
    return record | {
        "attempts": int(mesh.notes["attempts"]),
        "elements": len(mesh.cells),
        "dofs": int(mesh.points.size),
        "symmetric": mesh.symmetric,
        "min_dihedral_deg": report.min_dihedral_deg,
        "least_jacobian_ratio": report.least_jacobian_ratio,
        "body_volume_error": report.body_volume_error,
        "worst_plate_volume_error": report.worst_plate_volume_error,
        "worst_face_area_error": report.worst_face_area_error,
        "contact_residual_mm": report.contact_residual_mm,
    }
