"""A finger that never was: closed forms (Hertz, Cattaneo-Mindlin) in the shape of an analysis.

The report is built and looked at with it, so that it owes nothing to the numerics.
"""

import numpy as np
import pytest
from scipy.spatial import Delaunay
from scipy.stats import spearmanr

from fingerdesign.analysis.analysis import Analysis, study_summary
from fingerdesign.checks.load import parse_design
from fingerdesign.design.schema import Gages
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cells import quadratic
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.types import Mesh
from fingerdesign.records.arrays import (
    OPEN,
    SLIP,
    STICK,
    ContactHistory,
    FieldHistory,
    GripTrace,
    SlipStudy,
)
from fingerdesign.records.result import (
    GageResult,
    GripResult,
    IncrementResult,
    MeshSummary,
    ModelSummary,
    Result,
)

RADIUS, DEPTH, MODULUS = 20.0, 10.0, 4.96 / (1 - 0.49**2)
CREST = 10.0 + RADIUS - np.sqrt(RADIUS**2 - 100.0)
PLATE_X = np.linspace(-7.0, 7.0, 15)
DESIGN = parse_design(
    """
    [design]
    name = "maeno2000"
    [mesh]
    layers = 3
    contact_size_mm = 1.0
    plate_size_mm = 1.0
    [mesh.section]
    contact_size_mm = 0.4
    plate_size_mm = 0.4
    plate_end_size_mm = 0.2
    far_size_mm = 2.0
    """
)


def half_width(force):
    """Hertz line contact, a, mm, of a whole-finger normal force."""
    return float(np.sqrt(4 * force / DEPTH * RADIUS / (np.pi * MODULUS)))


def partial_slip(x, normal, tangential, friction):
    """Pressure, shear traction, half-widths a and c (Cattaneo-Mindlin), at x."""
    a = half_width(normal)
    peak = 2 * normal / DEPTH / (np.pi * a)
    c = a * np.sqrt(max(0.0, 1 - tangential / (friction * normal)))
    pressure = peak * np.sqrt(np.clip(1 - (x / a) ** 2, 0, None))
    held = peak * np.sqrt(np.clip(c**2 - x**2, 0, None)) / a
    return pressure, friction * (pressure - held), a, c


def gage_strains(normal, tangential, friction):
    """Made-up membrane strain of the plates, microstrain, from the tractions above them."""
    x = np.linspace(-8, 8, 801)
    pressure, shear, *_ = partial_slip(x, normal, tangential, friction)
    distance = x[None, :] - PLATE_X[:, None]
    kernel = 1 / (1 + (distance / 1.2) ** 2) ** 2
    return (x[1] - x[0]) * (400 * kernel @ shear - 90 * (kernel * distance) @ pressure)


PATH = [(3.0, 0.2), (6.0, 0.9), *((9.0, each) for each in (1.9, 2.6, 3.2, 3.8, 4.3)), (9, 4.5)]


def increments(friction):
    rows = []
    before = 0.0
    for normal, tangential in PATH:
        x = np.linspace(-4, 4, 161)
        pressure, _, a, c = partial_slip(x, normal, tangential, friction)
        status = np.where(np.abs(x) > a, OPEN, np.where(np.abs(x) <= c, STICK, SLIP))
        membrane = gage_strains(normal, tangential, friction)
        bending = 20 * np.gradient(membrane, PLATE_X) + before
        gages = tuple(
            GageResult(i, m + b, m - b, m, b, m)
            for i, (m, b) in enumerate(zip(membrane.tolist(), bending.tolist(), strict=True))
        )
        rows.append(
            IncrementResult(
                approach_mm=round(0.05 * normal, 3),
                shear_mm=round(0.12 * tangential, 3),
                normal_force_N=normal,
                tangential_force_N=tangential,
                contact_width_mm=2 * a,
                stick_ratio=c / a,
                open_nodes=int(np.sum(status == OPEN)),
                stick_nodes=int(np.sum(status == STICK)),
                slip_nodes=int(np.sum(status == SLIP)),
                peak_pressure_MPa=float(pressure.max()),
                iterations=6,
                residual=3e-13,
                gages=gages,
            )
        )
    return tuple(rows)


def contact_history(dimension, friction):
    x = np.linspace(-4, 4, 161 if dimension == 2 else 49)
    if dimension == 2:
        points = np.stack([x, CREST - x**2 / (2 * RADIUS)], axis=1)
        facets = np.stack([np.arange(160), np.arange(1, 161)], axis=1)
        flat, z = x, np.zeros_like(x)
    else:
        line = np.linspace(0, 5, 13)
        flat, z = (grid.ravel() for grid in np.meshgrid(x, line, indexing="ij"))
        points = np.stack([flat, CREST - flat**2 / (2 * RADIUS), z], axis=1)
        facets = Delaunay(np.stack([flat, z], axis=1)).simplices
    status, pressures, shears = [], [], []
    for normal, tangential in PATH:
        narrow = flat / (1 - 0.012 * z**2)
        pressure, shear, a, c = partial_slip(narrow, normal, tangential, friction)
        near = np.abs(narrow)
        status.append(np.where(near > a, OPEN, np.where(near <= c - 0.02 * z, STICK, SLIP)))
        pressures.append(pressure)
        shears.append(np.stack([shear, 0 * shear][: dimension - 1], axis=-1))
    areas = np.full(len(points), 0.05 if dimension == 2 else 0.05 * 5 / 12)
    slip = np.where(np.array(status)[..., None] == SLIP, 0.01, 0.0) * np.ones(dimension - 1)
    return ContactHistory(
        points,
        areas,
        facets,
        np.array(status),
        np.array(pressures),
        np.array(shears),
        slip,
        symmetric=dimension == 3,
    )


def slip_study(friction, threshold=9.0):
    normal = np.array([4.0, 8.0, 12.0, *[12.0] * 8])
    tangential = friction * normal * np.array([0.1, 0.2, 0.25, *np.linspace(0.3, 0.995, 8)])
    strains = np.array(
        [gage_strains(*pair, friction) for pair in zip(normal, tangential, strict=True)]
    )
    normal_only = np.array([gage_strains(force, 0.0, friction) for force in normal])
    change = np.diff(tangential, prepend=0.0)[:, None]
    raw = np.abs(np.diff(strains, axis=0, prepend=0.0) / change)
    response = np.abs(np.diff(strains - normal_only, axis=0, prepend=0.0) / change)
    response[0] = np.nan
    fine = np.linspace(-7, 7, 1401)
    areas = [
        np.array([0.01 * np.sum(np.interp(fine, PLATE_X, row) > threshold) for row in rows])
        for rows in (raw, np.nan_to_num(response))
    ]
    widths = [
        partial_slip(PLATE_X, *pair, friction) for pair in zip(normal, tangential, strict=True)
    ]
    stick = np.array([2 * c for *_, c in widths])
    return SlipStudy(
        friction_coefficient=friction,
        stick_ratio=np.array([c / a for *_, a, c in widths]),
        stick_length_mm=stick,
        gage_area_raw_mm=areas[0],
        gage_area_mm=areas[1],
        gage_x_mm=PLATE_X,
        response_raw=raw,
        response=response,
        threshold=threshold,
        rank_correlation_raw=float(spearmanr(areas[0][1:], stick[1:]).statistic),
        rank_correlation=float(spearmanr(areas[1][1:], stick[1:]).statistic),
        tangential_force=tangential,
        normal_force=normal,
        force_floor_N=0.05,
    )


def grip_trace(friction, rule=True, mass=200.0):
    weight = 0.5 * 9.80665e-3 * mass
    normal, tangential, rows = 0.3, 0.0, []
    for step in range(400):
        ratio = np.sqrt(max(0.0, 1 - tangential / (friction * normal)))
        hold = rule and ratio < 0.5
        dx = 0.0 if hold else 0.01 + 0.0004 * step
        dy = 0.02
        normal += 0.04
        tangential = min(tangential + 1.6 * dx, friction * normal)
        ratio = np.sqrt(max(0.0, 1 - tangential / (friction * normal)))
        area = 2 * half_width(normal) * ratio
        rows.append((0.02 * step, 0.01 * step, normal, tangential, ratio, area, dx, dy, hold))
        if tangential >= weight:
            break
    columns = np.array([row[:8] for row in rows]).T
    lifted = tangential >= weight
    return GripTrace(
        "paper",
        friction,
        mass,
        *columns,
        hold=np.array([row[8] for row in rows]),
        gage_readings=np.outer(columns[3], np.linspace(1, 2, 15)),
        lift_step=len(rows) - 1 if lifted else None,
        without_rule=grip_trace(friction, False, mass) if rule else None,
    )


def finger_mesh(dimension):
    """The section, or half of the finger extruded: coarse, of straight cells, with every plate."""
    made = (
        mesh_section(DESIGN, 4.0) if dimension == 2 else extrude(DESIGN, Zone(4.0), symmetric=True)
    )
    corners = made.points[: made.corners.max() + 1]
    points, cells = quadratic(corners, made.corners, made.kind)
    return Mesh(points, cells, made.regions, {}, "synthetic", symmetric=dimension == 3)


def displacement(mesh):
    x, y = mesh.points[:, 0], mesh.points[:, 1]
    near = (y / CREST) ** 2 * np.exp(-(x**2) / 18)
    frames = []
    for normal, tangential in PATH:
        u = np.zeros_like(mesh.points)
        u[:, 0] = 0.12 * tangential * near
        u[:, 1] = -0.05 * normal * near
        frames.append(u)
    return np.array(frames)


def make_analysis(dimension=2, friction=0.5, name="maeno2000"):
    mesh = finger_mesh(dimension)
    traces = tuple(grip_trace(mu) for mu in (0.3, 0.5, 0.8))
    studies = tuple(slip_study(mu) for mu in (0.3, 0.5, 0.8))
    grips = tuple(
        GripResult(
            controller=trace.controller,
            friction_coefficient=trace.friction_coefficient,
            object_mass_g=trace.object_mass_g,
            lifted=trace.lift_step is not None,
            gross_slip=bool(trace.stick_ratio.min() < 0.01),
            final_normal_force_N=float(trace.normal_force[-1]),
            final_tangential_force_N=float(trace.tangential_force[-1]),
            safety_margin=float(trace.limit[-1] / trace.tangential_force[-1]),
            minimum_stick_ratio=float(trace.stick_ratio.min()),
            peak_normal_force_N=float(trace.normal_force.max()),
            slip_distance_mm=0.0,
            steps=len(trace.dx),
            holds=int(trace.hold.sum()),
            slips_without_rule=bool(trace.without_rule.stick_ratio.min() < 0.01),
        )
        for trace in traces
    )
    result = Result(
        design=name,
        scene="fundamental",
        digest="3f" * 32,
        versions={"fingerdesign": "0.1.0", "numpy": "2.4.6", "python": "3.11.7"},
        fidelity="plane-strain" if dimension == 2 else "3d",
        warnings=("plates.cover_mm = 2.0 is thinner than twice the contact element size.",),
        model=ModelSummary(
            dimension,
            "quadratic triangles" if dimension == 2 else "quadratic tetrahedra",
            2 * len(mesh.points),
            161,
            dimension == 3,
            ("The section is constant along z, so plane strain stands for the middle.",),
        ),
        mesh=MeshSummary("synthetic", len(mesh.cells), 12.4, 2e-6, 3e-5),
        increments=increments(friction),
        grips=grips,
        slip_studies=tuple(study_summary(study) for study in studies),
        seeds={"plant": 0},
        timings_s={
            **{"geometry": 0.4, "mesh": 1.1, "assemble": 0.6, "condense": 0.9},
            **{"increments": 0.3, "grips": 1.7, "report": 2.0},
        },
        peak_memory_MB=612.0,
        parameters={
            **{"body.shape": "arc", "body.width_mm": 20.0, "body.arc_radius_mm": 20.0},
            **{"body.depth_mm": 10.0, "plates.count": 15, "plates.angle_deg": 45.0},
            **{"plates.thickness_mm": 0.1, "plates.cover_mm": 2.0, "plates.placement": None},
            **{"materials.silicone.youngs_modulus_MPa": 4.96},
            **{"materials.silicone.poissons_ratio": 0.49, "gages.face": "both"},
        },
        assumed=("body.arc_radius_mm", "plates.cover_mm", "materials.silicone.poissons_ratio"),
    )
    return Analysis(
        result=result,
        contact=contact_history(dimension, friction),
        slip_studies=studies,
        grip_traces=traces,
        mesh=mesh,
        fields=FieldHistory(tuple(range(len(PATH))), displacement(mesh)),
        plates=plate_frames(DESIGN),
        gages=Gages(),
        depth_mm=DEPTH,
    )


@pytest.fixture(scope="session")
def plane_strain():
    return make_analysis(2)


@pytest.fixture(scope="session")
def solid():
    return make_analysis(3)


@pytest.fixture(scope="session")
def failed():
    """An analysis that stopped before it had a mesh."""
    return Analysis(
        Result(
            design="narrow",
            scene="fundamental",
            digest="0" * 64,
            versions={"fingerdesign": "0.1.0"},
            fidelity="3d",
            status="failed",
            failure="No mesh passed the acceptance gate after 3 attempts (plate 4: 62 % missing).",
        )
    )
