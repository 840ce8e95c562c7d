"""Jobs: their digest, failures, outcomes that another study computed, how far they are believed.

Metrics and traces against results made by hand.
"""

import json
from dataclasses import MISSING, fields, replace

import numpy as np
import pytest

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.io import parse_scene
from fingerdesign.design.shipped import load_scene
from fingerdesign.errors import DesignError, Fault, MeshError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.pipeline import run
from fingerdesign.records.arrays import OPEN, SLIP, STICK, ContactHistory, GripTrace
from fingerdesign.records.outcome import Outcome
from fingerdesign.records.result import (
    GageResult,
    GripResult,
    IncrementResult,
    LadderSummary,
    MeshSummary,
    ModelSummary,
    Result,
)
from fingerdesign.search.run import hand as hand_module
from fingerdesign.search.run.as_made import placement_of
from fingerdesign.search.run.evaluate import (
    Job,
    evaluate,
    finite_metrics,
    made_metrics,
    relabelled,
    validity_of,
)
from fingerdesign.search.run.measured import (
    grip_metrics,
    grips_of,
    metrics_of,
    own_metrics,
    stick_error_of,
    traces_of,
)
from fingerdesign.search.run.run import planned
from fingerdesign.search.study.file import Cost, parse_study
from fingerdesign.search.study.metrics import METRICS, ON_REQUEST, SPREAD
from fingerdesign.search.study.variants import base_design, variants
from fingerdesign.tolerance.spread import tolerance
from fingerdesign.validate.plane_strain import plane_strain_error

QUICK = {
    "grip.friction_coefficients": [0.5],
    "mesh.section.contact_size_mm": 0.1,
    "mesh.section.plate_size_mm": 0.1,
}

SPHERE = """
[object]
shape = "sphere"
radius_mm = 20.0
[path]
increments_mm = [[0.1, 0.0], [0.2, 0.0], [0.2, 0.05]]
"""


@pytest.fixture(scope="module")
def design():
    return with_values(load_design("narrow"), QUICK)


@pytest.fixture(scope="module")
def job(design):
    return Job("s-0001", design, Cost(), {"plates.count": 7})


@pytest.fixture(scope="module")
def outcome(job):
    return evaluate(job)


def test_every_metric_has_a_value(outcome):
    assert outcome.status == "ok"
    assert set(outcome.metrics) == set(METRICS)
    assert outcome.metrics["grip_success"] == 1.0
    assert 0.0 < outcome.metrics["stick_error"] < 0.4
    assert outcome.metrics["plane_strain_error"] == outcome.validity.plane_strain_error > 0.0
    assert outcome.metrics["core_seconds"] == outcome.core_seconds > 0.0
    assert outcome.peak_memory_MB > 50.0
    assert outcome.seeds == {"grip": 0, "stick_error": 0}
    assert "numpy" in outcome.versions
    assert Outcome.from_json(outcome.to_json()) == outcome


def test_a_job_survives_a_pipe(job):
    scene = load_scene("fundamental")
    given = replace(job, scene=scene, scene_name="mine", fidelity="auto")
    back = Job.from_data(json.loads(json.dumps(given.to_data())))
    assert (back, back.digest()) == (given, given.digest())


def test_the_digest_leaves_out_names_prices_and_molds(job, design):
    other = with_values(design, {"design.name": "other", "mold.wall_mm": 5.0})
    reported = other.model_copy(update={"assumed": ("body.width_mm",)})
    same = Job("t-9", reported, Cost(plate=7.0), {"x": 1}, scene_name="called otherwise")
    assert same.digest() == job.digest()


def test_the_digest_changes_with_the_design_and_with_what_is_requested(job, design, monkeypatch):
    values = {
        "body.width_mm": 12.1,
        "grip.friction_coefficients": [0.51],
        "grip.seed": 1,
        "grip.hardware.gage_noise_microstrain": 0.6,
        "gages.face": "lower",
        "mesh.section.contact_size_mm": 0.11,
    }
    requested = [
        job,
        *(replace(job, design=with_values(design, dict([each]))) for each in values.items()),
        replace(job, scene=load_scene("fundamental")),  # that path alone, no grips
        replace(job, part="hand"),
        replace(job, part="sensing"),
        replace(job, fidelity="3d"),
        replace(job, fidelity="auto"),
        replace(job, fidelity="auto", tolerance=0.03),
    ]
    found = [each.digest() for each in requested]
    for version in ("search.run.evaluate.METRICS_VERSION", "analysis.case.__version__"):
        monkeypatch.setattr(f"fingerdesign.{version}", "0.0.other")
        found.append(job.digest())
    assert len(set(found)) == len(found)


def test_variants_are_meshed_as_grips_are_but_for_what_the_study_says(job, design):
    solid = replace(job, fidelity="3d")
    mesh = solid.case.design.mesh
    assert (mesh.layers, mesh.layer_growth, mesh.section.gradation) == (3, 1.3, 0.4)
    one_face = replace(solid, design=with_values(design, {"gages.face": "upper"}))
    for even in (one_face, replace(solid, part="sensing"), replace(solid, part="hand")):
        assert (even.case.design.mesh.layers, even.case.design.mesh.layer_growth) == (4, 1.0)
    stated = replace(
        solid, study_keys=("mesh.layers", "mesh.mesher", "plates.count")
    ).case.design.mesh
    assert (stated.layers, stated.mesher) == (design.mesh.layers, design.mesh.mesher)
    assert (stated.layer_growth, stated.contact_size_mm) == (1.0, mesh.contact_size_mm)
    assert solid.digest() != replace(solid, study_keys=("mesh.layers",)).digest()
    flat, own = replace(job, fidelity="plane-strain").case.design.mesh.section, design.mesh.section
    assert (flat.gradation, flat.contact_size_mm) == (0.4, own.contact_size_mm)
    assert replace(job, fidelity="auto").case.design == design


@pytest.mark.slow
def test_hands_of_a_finger_share_what_they_cannot_change(job):
    """Of four hands: one model, two calibrations (two lengths of steps), and each hand's own
    answer. Another travel is another finger."""

    def judged(**values):
        keys = {f"grip.{key}": value for key, value in values.items()}
        return replace(job, part="hand", design=with_values(job.design, keys))

    def last():
        (finger,) = hand_module._last.values()
        return finger.followed.problem, finger.rig.calibrations

    hands = [judged(), judged(threshold_share=0.8), judged(curve_per_N=0.2)]
    hands.append(judged(approach_step_mm=0.9 * job.design.grip.approach_step_mm))
    found = [evaluate(hands[0])]
    problem, calibrations = last()
    found += [evaluate(each) for each in hands[1:]]
    assert last()[0] is problem
    assert last()[1] is calibrations
    assert len(calibrations) == 2
    for each, own in zip(hands, found, strict=True):
        alone = run(each.case)
        assert own.status == "ok"
        assert own.grips == grips_of(alone)
        assert own.traces == traces_of(alone)
        assert own.metrics["peak_ratio"] == metrics_of(each.design, each.cost, alone)["peak_ratio"]
    assert len({each.grips for each in found}) >= 3
    evaluate(judged(max_approach_mm=0.9 * job.design.grip.max_approach_mm))
    assert last()[0] is not problem


def test_what_one_cannot_analyse_is_refused(job):
    found = evaluate(replace(job, scene=parse_scene(SPHERE), scene_name="ball"))
    assert (found.status, found.scene, found.metrics) == ("failed", "ball", {})
    assert found.failure.kind == "refused"
    assert "take 3d" in found.failure.sentence


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        (MeshError("no mesh of it"), "failed"),
        (MemoryError("no mesh of it"), "memory"),
        (DesignError([Fault("a.b", 1, "no mesh of it", "take 2")]), "refused"),
        (ZeroDivisionError(), None),
    ],
)
def test_a_failure_is_an_outcome_and_a_fault_of_the_program_is_raised(
    job, monkeypatch, error, kind
):
    def run(case):
        raise error

    monkeypatch.setattr("fingerdesign.pipeline.run", run)
    if kind is None:
        with pytest.raises(ZeroDivisionError):
            evaluate(job)
        return
    found = evaluate(job)
    assert found.failure.kind == kind
    assert "no mesh of it" in found.failure.sentence
    assert (found.digest, found.name, found.values) == (job.digest(), job.name, job.values)
    other = relabelled(found, replace(job, name="t-3"))
    assert (other.name, other.metrics) == ("t-3", {})


def test_a_scene_is_its_path_alone(job):
    scene = parse_scene(SPHERE.replace("sphere", "cylinder"))
    found = evaluate(replace(job, scene=scene, scene_name="bar"))
    assert (found.status, found.scene, found.grips) == ("ok", "bar", ())
    assert found.metrics.get("grip_success") is None
    assert len(found.traces.approach_mm) == len(found.traces.status) == 3
    assert 0.0 < found.metrics["stick_error"] < 0.4


def test_relabelled_for_another_study(outcome, job, design):
    renamed = with_values(design, {"design.name": "t-0002"})
    other = Job("t-0002", renamed, Cost(plate=100.0), {"z": 2}, scene_name="other")
    found = relabelled(outcome, other)
    assert (found.name, found.values, found.scene) == ("t-0002", {"z": 2}, "other")
    assert found.design["design"]["name"] == "t-0002"
    assert found.metrics["cost"] == pytest.approx(outcome.metrics["cost"] + 98.0 * 7)
    assert found.metrics["stick_error"] == outcome.metrics["stick_error"]
    assert relabelled(found, job) == outcome
    assert "s-0001" not in found.to_json()
    with pytest.raises(ValueError, match="digests differ"):
        relabelled(outcome, replace(job, design=with_values(design, {"body.width_mm": 12.1})))


MODEL, MESH = ModelSummary(2, "t", 10, 5, False), MeshSummary("m", 3, 30.0, 0.0, None)
PAPER = load_design("maeno2000")


def judged(design=PAPER, dimension=2, ladder=None, fidelity="plane-strain"):
    model = replace(MODEL, dimension=dimension)
    result = Result("a", "s", "d", {}, "3d", model=model, mesh=MESH, ladder=ladder)
    return validity_of(Case(design, fidelity=fidelity), Analysis(result))


def test_plane_strain_has_a_forecast_and_space_has_none():
    forecast = plane_strain_error(PAPER, Case(PAPER).path_scene).errors["normal_force"]
    assert judged().plane_strain_error == pytest.approx(forecast)
    assert judged().mesh_error is None
    found = judged(dimension=3, fidelity="3d")
    assert (found.plane_strain_error, found.mesh_error) == (None, None)
    found = judged(with_values(load_design("domed"), {"plates.count": 0}))
    assert found.plane_strain_error is None  # no section shows it
    assert "body.shape" in found.sentences[0]


@pytest.mark.parametrize(
    ("errors", "worst"), [({"normal_force": 0.01, "stick_ratio": 0.04}, 0.04), ({}, None)]
)
def test_the_ladder_reports_its_worst(errors, worst):
    ladder = LadderSummary(0.02, False, "fine", errors, "no more memory", ())
    found = judged(dimension=3, ladder=ladder, fidelity="auto")
    assert found.mesh_error == worst
    assert "no more memory" in " ".join(found.sentences)


DESIGN = with_values(load_design("narrow"), {"plates.count": 2, "plates.pitch_mm": 2.0})


def row(approach, shear, normal, tangential, stick, readings=(0.0, 0.0)):
    gages = tuple(GageResult(k, r, r, r, 0.0, r) for k, r in enumerate(readings))
    counts = (5, 3, 2)
    pressure = 0.1 * normal
    return IncrementResult(
        approach, shear, normal, tangential, 1.0, stick, *counts, pressure, 3, 0.0, gages
    )


ROWS = (
    row(0.1, 0.0, 2.0, 0.0, 0.7, (10.0, -4.0)),
    row(0.2, 0.0, 6.0, 0.0, 0.6, (30.0, -9.0)),
    row(0.2, 0.01, 6.1, 1.0, 0.95, (28.0, -4.0)),
    row(0.2, 0.02, 6.0, 1.8, 0.87, (26.0, -1.0)),
    row(0.2, 0.03, 5.9, 2.4, 0.8, (25.0, 3.0)),
    row(0.2, 0.04, 5.8, 2.9, None, (25.0, 3.0)),
)


def gripped(mu, mass, margin, peak, lifted=True, slips=False):
    return GripResult("paper", mu, mass, lifted, slips, 5.0, 2.0, margin, 0.4, peak, 0.0, 30)


def trace(mu, mass, steps):
    """Forces that rise to 5 N and 2 N; the rest is of no matter here."""
    rise, none = np.linspace(0.0, 1.0, steps), np.zeros(steps)
    arrays = {each.name: none for each in fields(GripTrace) if each.default is MISSING}
    forces = {"normal_force": 5.0 * rise, "tangential_force": 2.0 * rise}
    own = {"controller": "paper", "friction_coefficient": mu, "object_mass_g": mass}
    own |= {"hold": none > 0.0, "gage_readings": np.zeros((steps, 2))}
    return GripTrace(**(arrays | forces | own))


def analysis(**changes):
    reported = {"increments": ROWS, "model": MODEL, "mesh": MESH} | changes
    made = Result("narrow", "made", "d" * 64, {}, "plane-strain", **reported)
    return Analysis(made, plates=plate_frames(DESIGN))


def test_metrics_of_the_path():
    found = metrics_of(DESIGN, Cost(), analysis())
    assert (found["normal_force_N"], found["tangential_force_N"]) == (5.8, 2.9)
    assert found["stiffness_N_per_mm"] == pytest.approx(6.0 / 0.2)
    assert found["peak_pressure_MPa"] == pytest.approx(0.61)
    assert found["first_slip_N"] == 2.4  # 0.8 < 0.9 x 0.95; that pressing slips is not counted
    assert found["gage_response"] == pytest.approx(5.0)  # gage 1, the first step that only pulls
    assert "grip_success" not in found


def test_what_a_path_or_a_model_does_not_tell_is_none():
    found = metrics_of(DESIGN, Cost(), analysis(increments=ROWS[:2]))  # it only presses
    assert (found["first_slip_N"], found["gage_response"]) == (None, None)
    assert stick_error_of(Case(DESIGN), analysis()) == (None, ())
    found = grip_metrics([gripped(0.2, 500.0, None, 15.0, lifted=False)])
    assert found["grip_success"] == 0.0
    assert {found[name] for name in ("safety_margin", "least_margin", "peak_ratio")} == {None}


def test_the_cost_is_what_it_says_and_rubber_the_body_without_plates():
    prices = Cost(fixed=3.0, plate=2.0, gage=8.0, silicone_per_ml=1.0)
    found = own_metrics(DESIGN, prices)
    assert found["plates"] == 2.0
    assert found["cost"] == pytest.approx(3.0 + 4.0 + 32.0 + found["rubber_volume_ml"])
    one_face = with_values(DESIGN, {"gages.face": "upper"})
    assert own_metrics(one_face, prices)["cost"] == pytest.approx(found["cost"] - 16.0)
    plates, body = DESIGN.plates, DESIGN.body
    less = 2 * plates.length_mm * plates.thickness_mm * (plates.span_mm or body.depth_mm) * 1e-3
    whole = own_metrics(with_values(DESIGN, {"plates.count": 0}), Cost())["rubber_volume_ml"]
    assert whole - found["rubber_volume_ml"] == pytest.approx(less)
    box = body.width_mm * body.base_height_mm * body.depth_mm * 1e-3
    assert box < whole < 1.5 * box


def test_traces_are_thinned_and_keep_both_ends():
    rows = tuple(replace(ROWS[3], approach_mm=k / 1000) for k in range(101))
    found = traces_of(analysis(increments=rows))
    assert len(found.approach_mm) == len(found.gages) == 40
    assert (found.approach_mm[0], found.approach_mm[-1]) == (0.0, 0.1)
    assert traces_of(analysis()).stick_ratio[-1] is None
    assert len(found.gage_x_mm) == len(found.gages[0]) == 2


def contact(points, status):
    m, dim = points.shape
    k = len(status)
    facets = np.zeros((0, dim), dtype=np.int64)
    slips = np.zeros((k, m, dim - 1))
    return ContactHistory(points, np.ones(m), facets, status, np.zeros((k, m)), slips, slips)


def test_the_contact_map_of_a_section_runs_along_x():
    x = np.random.default_rng(1).permutation(np.linspace(-4.0, 4.0, 301))
    status = np.where(np.abs(x) < 1.0, STICK, np.where(np.abs(x) < 2.0, SLIP, OPEN))
    made = contact(np.column_stack([x, 10.0 - 0.01 * x**2]), np.tile(status, (len(ROWS), 1)))
    found = traces_of(replace(analysis(), contact=made))
    assert len(found.contact_x_mm) == len(found.status[0]) == 120
    assert found.contact_x_mm == tuple(sorted(found.contact_x_mm))
    assert found.contact_z_mm == ()
    for x_mm, mark in zip(found.contact_x_mm, found.status[2], strict=True):
        assert mark == ("#" if abs(x_mm) < 1.0 else "/" if abs(x_mm) < 2.0 else ".")


def test_the_contact_map_in_space_is_about_what_is_touched():
    rng = np.random.default_rng(2)
    x, z = rng.uniform(-10.0, 10.0, 4000), rng.uniform(-5.0, 5.0, 4000)
    touched = (np.abs(x) < 1.5) & (np.abs(z) < 4.0)
    made = contact(np.column_stack([x, 0 * x, z]), np.tile(np.where(touched, STICK, OPEN), (6, 1)))
    found = traces_of(replace(analysis(), contact=made))
    assert 80 < len(found.contact_x_mm) == len(found.contact_z_mm) <= 120
    assert max(abs(each) for each in found.contact_x_mm) < 2.5
    assert found.status[0].count("#") > 50
    assert "." in found.status[0]
    spread = np.histogram2d(found.contact_x_mm, found.contact_z_mm, (3, 3))[0]
    assert spread.min() > 5  # everywhere, not in a corner


def test_metrics_of_grips():
    grips = (
        gripped(0.2, 500.0, 1.2, 15.0),
        gripped(0.5, 500.0, 1.6, 8.0),
        gripped(0.8, 500.0, None, 4.0, lifted=False, slips=True),
    )
    traces = tuple(trace(each.friction_coefficient, 500.0, 90) for each in grips)
    made = replace(analysis(grips=grips), grip_traces=traces)
    found = metrics_of(DESIGN, Cost(), made)
    half_weight = 0.25 * 9.80665
    ratios = (15.0 * 0.2 / half_weight, 8.0 * 0.5 / half_weight)  # one that fell is not gentle
    known = {"grip_success": 2 / 3, "safety_margin": 1.4, "least_margin": 1.2}
    known |= {"peak_force_N": 15.0, "peak_ratio": sum(ratios) / 2}
    assert {name: found[name] for name in known} == pytest.approx(known)
    path = grips_of(made)[0]
    assert len(path.normal_force_N) == len(path.tangential_force_N) == 60
    assert path.normal_force_N[-1] == 5.0


def test_a_file_that_is_gone_is_a_failure(job, design, tmp_path):
    mesh = design.mesh.model_copy(update={"file": str(tmp_path / "gone.msh"), "mesher": "file"})
    found = evaluate(replace(job, design=design.model_copy(update={"mesh": mesh})))
    assert "gone.msh" in found.failure.sentence


def test_what_is_no_finite_number_is_none_with_a_warning():
    given = {"cost": float("inf"), "gage_response": float("nan"), "peak_ratio": 1e200, "plates": 3}
    found, warnings = finite_metrics(given)
    assert found == dict.fromkeys(given, None) | {"plates": 3}
    assert warnings == tuple(f"no {name}: its value is no finite number" for name in given)[:3]


ONE = """
[study]
name = "s"
base = "narrow"
sampling = "grid"
[parameters]
"plates.count" = [5]
"""


@pytest.mark.parametrize(
    ("more", "named"),
    [
        ("", ()),
        ("[constraints]\nplacement_effect = { at_most = 0.1 }\n", ("placement_effect",)),
        ('[[objectives]]\nmetric = "reading_std"\n', ("reading_std",)),
    ],
)
def test_what_the_mold_leaves_is_computed_where_a_study_names_it(more, named, tmp_path):
    study = parse_study(ONE + more)
    (job,) = planned(
        study, variants(study, base_design(study, tmp_path / "s.toml")), {"fundamental": None}
    )
    assert job.on_request == named
    machined = replace(job, design=with_values(job.design, {"mold.process": "machined"}))
    assert (machined.digest() != job.digest()) == bool(named)  # No analysis but this sees the mold.


def test_placement_of_what_has_no_plates_is_none_with_a_reason():
    value, (why,) = placement_of(load_design("homogeneous"))
    assert value is None
    assert "plates" in why


def test_spread_where_forces_are_given_is_none_with_a_reason(job):
    pressed = replace(job, scene=load_scene("pull"), on_request=("reading_std",))
    values, (why,) = made_metrics(pressed)
    assert values == dict.fromkeys(ON_REQUEST)
    assert "motion" in why


@pytest.mark.slow
def test_a_study_sees_the_spread_that_tolerance_reports(job):
    found = evaluate(replace(job, part="sensing", on_request=ON_REQUEST)).metrics
    record = tolerance(job.case.design)
    assert found["reading_std"] == pytest.approx(record.reading_std[0])
    assert found["yield_by_motion"] == record.yield_by_motion[0]
    # The same row as the metric of the finger as designed, and less of it.
    assert record.gage_response[0] == pytest.approx(found["gage_response"], rel=1e-3)
    assert found["gage_response_90"] == record.gage_response[1] < 0.97 * found["gage_response"]
    assert 0.0 < found["reading_std_calibrated"] < found["reading_std"] < 1.0
    stiff = {"mold.process": "machined", "mold.comb.tolerance_mm": 0.001}
    machined = replace(job, design=with_values(job.design, stiff), on_request=SPREAD)
    assert made_metrics(machined)[0]["reading_std_calibrated"] < found["reading_std_calibrated"]


@pytest.mark.slow
def test_machined_parts_place_plates_closer_than_prints():
    design = load_design("film_tees")
    machined = with_values(design, {"mold.process": "machined"})
    (printed, _), (cut, _) = placement_of(design), placement_of(machined)
    assert 0.0 < cut < printed < 0.5
