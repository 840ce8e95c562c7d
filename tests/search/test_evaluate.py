"""Jobs: their digest, failures, outcomes that another study computed, how far they are believed."""

import json
from dataclasses import replace

import pytest

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import parse_scene, with_values
from fingerdesign.checks.starter import find_design, find_scene
from fingerdesign.errors import DesignError, Fault, MeshError
from fingerdesign.records.outcome import Outcome
from fingerdesign.records.result import LadderSummary, MeshSummary, ModelSummary, Result
from fingerdesign.search.run import evaluate as module
from fingerdesign.search.run.evaluate import Job, evaluate, relabelled, validity_of
from fingerdesign.search.study.file import Cost
from fingerdesign.search.study.metrics import METRICS
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
    return with_values(find_design("narrow"), QUICK)


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
    scene = find_scene("fundamental")
    for each in (job, replace(job, scene=scene, scene_name="mine", fidelity="auto")):
        back = Job.from_data(json.loads(json.dumps(each.to_data())))
        assert back == each
        assert back.digest() == each.digest()


def test_the_digest_leaves_out_names_prices_and_molds(job, design):
    other = with_values(design, {"design.name": "other", "mold.wall_mm": 5.0})
    assert other.mold != design.mold
    reported = other.model_copy(update={"assumed": ("body.width_mm",)})
    same = Job("t-9", reported, Cost(plate=7.0), {"x": 1}, scene_name="called otherwise")
    assert same.digest() == job.digest()


@pytest.mark.parametrize(
    "values",
    [
        {"body.width_mm": 12.1},
        {"grip.friction_coefficients": [0.51]},
        {"grip.seed": 1},
        {"grip.hardware.gage_noise_microstrain": 0.6},
        {"gages.face": "lower"},
        {"mesh.section.contact_size_mm": 0.11},
    ],
)
def test_the_digest_changes_with_the_design(job, design, values):
    assert replace(job, design=with_values(design, values)).digest() != job.digest()


def test_the_digest_changes_with_what_is_requested(job, monkeypatch):
    scene = find_scene("fundamental")
    requested = [
        job,
        replace(job, scene=scene),  # that path alone, no grips
        replace(job, fidelity="3d"),
        replace(job, fidelity="auto"),
        replace(job, fidelity="auto", tolerance=0.03),
    ]
    found = [each.digest() for each in requested]
    monkeypatch.setattr(module, "METRICS_VERSION", -1)
    found.append(job.digest())
    monkeypatch.setattr("fingerdesign.analysis.summary.__version__", "0.0.other")
    found.append(job.digest())
    assert len(set(found)) == len(found)


def test_what_one_cannot_analyse_is_refused(job):
    scene = parse_scene(SPHERE)
    found = evaluate(replace(job, scene=scene, scene_name="ball"))
    assert found.status == "failed"
    assert found.failure is not None
    assert found.failure.kind == "refused"
    assert "take 3d" in found.failure.sentence
    assert found.scene == "ball"
    assert found.metrics == {}
    assert found.digest != job.digest()


def fail(monkeypatch, error):
    """Have every analysis end with an error."""

    def run(case):
        raise error

    monkeypatch.setattr("fingerdesign.pipeline.run", run)


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        (MeshError("no mesh of it"), "failed"),
        (MemoryError("no mesh of it"), "memory"),
        (DesignError([Fault("a.b", 1, "no mesh of it", "take 2")]), "refused"),
    ],
)
def test_a_failure_is_an_outcome(job, monkeypatch, error, kind):
    fail(monkeypatch, error)
    found = evaluate(job)
    assert found.failure is not None
    assert found.failure.kind == kind
    other = relabelled(found, replace(job, name="t-3"))
    assert (other.name, other.metrics) == ("t-3", {})
    assert "no mesh of it" in found.failure.sentence
    assert (found.digest, found.name, found.values) == (job.digest(), job.name, job.values)
    assert Outcome.from_json(found.to_json()) == found


def test_want_of_memory_is_distinguished_from_a_wrong_design(job, monkeypatch):
    monkeypatch.setattr("fingerdesign.runtime.machine.available_memory_MB", lambda: 10.0)
    monkeypatch.setattr("fingerdesign.analysis.forecast.limits.SMALL_MB", 1.0)
    found = evaluate(job)
    assert found.failure is not None
    assert found.failure.kind == "memory"
    assert "10 MB are free" in found.failure.sentence


def test_a_file_that_is_gone_is_a_failure(job, monkeypatch):
    def gone(design):
        raise DesignError([Fault("body.step.file", "a.step", "a file", "give one")])

    monkeypatch.setattr("fingerdesign.design.digest._by_content", gone)
    found = evaluate(job)
    assert found.failure is not None
    assert "a.step" in found.failure.sentence


def test_a_scene_is_its_path_alone(job):
    scene = parse_scene(SPHERE.replace("sphere", "cylinder"))
    found = evaluate(replace(job, scene=scene, scene_name="bar"))
    assert (found.status, found.scene, found.grips) == ("ok", "bar", ())
    assert found.metrics.get("grip_success") is None
    assert len(found.traces.approach_mm) == len(found.traces.status) == 3
    assert 0.0 < found.metrics["stick_error"] < 0.4


def test_a_fault_of_the_program_is_raised(job, monkeypatch):
    fail(monkeypatch, ZeroDivisionError())
    with pytest.raises(ZeroDivisionError):
        evaluate(job)


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


def test_what_is_no_finite_number_is_none_with_a_warning(job, monkeypatch):
    from fingerdesign.search.run import measured

    def endless(*arguments):
        found = own(*arguments)
        return found | {"cost": float("inf"), "gage_response": float("nan"), "peak_ratio": 1e200}

    own = measured.metrics_of
    monkeypatch.setattr("fingerdesign.search.run.evaluate.metrics_of", endless)
    found = evaluate(job)
    for name in ("cost", "gage_response", "peak_ratio"):
        assert found.metrics[name] is None
        assert f"no {name}: its value is no finite number" in found.warnings
    assert Outcome.from_json(found.to_json()) == found


DESIGN = find_design("maeno2000")
MODEL = ModelSummary(2, "t", 10, 5, False)
MESH = MeshSummary("m", 3, 30.0, 0.0, None)


def judged(design=DESIGN, dimension=2, ladder=None, fidelity="plane-strain"):
    model = replace(MODEL, dimension=dimension)
    result = Result("a", "s", "d", {}, "3d", model=model, mesh=MESH, ladder=ladder)
    return validity_of(Case(design, fidelity=fidelity), Analysis(result))


def test_plane_strain_has_a_forecast():
    found = judged()
    case = Case(DESIGN)
    assert found.plane_strain_error == pytest.approx(
        plane_strain_error(DESIGN, case.path_scene).errors["normal_force"]
    )
    assert "overstates F_n" in found.sentences[0]
    assert found.mesh_error is None


def test_space_has_none():
    found = judged(dimension=3, fidelity="3d")
    assert (found.plane_strain_error, found.mesh_error) == (None, None)
    assert "no estimate" in found.sentences[0]


def test_a_body_that_no_section_shows_has_none_and_says_so():
    found = judged(with_values(find_design("domed"), {"plates.count": 0}))
    assert found.plane_strain_error is None
    assert "body.shape" in found.sentences[0]


@pytest.mark.parametrize(
    ("errors", "worst"), [({"normal_force": 0.01, "stick_ratio": 0.04}, 0.04), ({}, None)]
)
def test_the_ladder_reports_its_worst(errors, worst):
    ladder = LadderSummary(0.02, False, "fine", errors, "no more memory", ())
    found = judged(dimension=3, ladder=ladder, fidelity="auto")
    assert found.mesh_error == worst
    assert "no more memory" in " ".join(found.sentences)
