"""The whole road in plane strain, in 3-D, by the ladder; one factorisation, failures, record."""

import pytest

from fingerdesign import analyse, load_design, parse_design, parse_scene, pipeline, with_values
from fingerdesign.analysis import stages
from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.page.tables import ladder_table
from fingerdesign.checks.meshing import plane_strain_faults
from fingerdesign.contact.force_control import Forces, NoEquilibrium, solve_forces
from fingerdesign.contact.problem import ContactState
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.shipped import shipped_names
from fingerdesign.errors import DesignError, MeshError
from fingerdesign.fem import factor
from fingerdesign.fem.model import FiniteElementModel
from fingerdesign.layout.zone import Zone
from fingerdesign.pipeline import analyse_into, run
from fingerdesign.records.result import Result
from fingerdesign.records.result_files import read_result

COARSE = {
    "mesh.section.contact_size_mm": 0.15,
    "mesh.section.plate_size_mm": 0.2,
    "mesh.section.plate_end_size_mm": 0.1,
    "mesh.section.far_size_mm": 1.5,
}
SCENE = parse_scene("[path]\nincrements_mm = [[0.1, 0.0], [0.15, 0.05]]")


def cut_by_one_section():
    """The shipped designs that plane strain can show."""
    designs = {name: load_design(name) for name in shipped_names()}
    return [name for name, design in designs.items() if not plane_strain_faults(design)]


@pytest.fixture
def without_remedies(monkeypatch):
    """Look for no remedies of gages: they take models of other plates, half of an analysis."""
    monkeypatch.setattr(pipeline, "start_sections", lambda case: None)


@pytest.mark.usefixtures("without_remedies")
@pytest.mark.parametrize("name", cut_by_one_section())
def test_every_shipped_design_is_analysed(name):
    """The fundamental case with its study and the grips, on a coarse section."""
    design = with_values(load_design(name), COARSE)
    analysis = run(Case(design, fidelity="plane-strain", fields=False))
    result = analysis.result
    assert result.status == "ok"
    assert len(result.increments) == 8
    assert result.increments[0].normal_force_N > 0
    if design.plates.number:
        assert len(result.grips) == len(design.grip.friction_coefficients)
        assert len(analysis.slip_studies) >= 5
    else:
        assert result.grips == ()
        assert any("no plates" in warning for warning in result.warnings)


def test_public_call_and_its_record():
    design = with_values(load_design("maeno2000"), COARSE)
    result = analyse(design, SCENE, "plane-strain")
    last = result.increments[-1]
    assert last.normal_force_N > last.tangential_force_N > 0
    assert last.approach_mm == 0.15
    assert len(last.gages) == 15
    gage = last.gages[7]
    assert gage.membrane == pytest.approx(0.5 * (gage.upper + gage.lower))
    assert (result.model.dimension, result.grips) == (2, ())
    assert (result.scene, analyse(design, "pull", "plane-strain").scene) == ("scene", "pull")
    again = analyse(design, SCENE, "plane-strain")
    assert again.digest == result.digest
    assert again.increments == result.increments
    deep = parse_scene("[path]\nincrements_mm = [[30.0, 0.0]]")
    with pytest.raises(DesignError) as caught:
        analyse(design, deep, "2.5d")
    assert {"--fidelity", "path.increments_mm[0][0]"} <= {f.key for f in caught.value.faults}


def test_a_zone_too_narrow_is_widened_and_reported(monkeypatch):
    design = with_values(load_design("homogeneous"), COARSE)
    wide = analyse(design, SCENE, "plane-strain")
    monkeypatch.setattr(stages, "candidate_zone", lambda *given: Zone(0.8))
    narrow = analyse(design, SCENE, "plane-strain")
    assert any("widened" in reason for reason in narrow.model.reasons)
    assert narrow.increments[-1].normal_force_N == pytest.approx(
        wide.increments[-1].normal_force_N, rel=2e-3
    )


def test_failed_work_leaves_a_failed_record(tmp_path, monkeypatch):
    def broken(*_):
        raise MeshError("the mesher gave up")

    monkeypatch.setattr(pipeline, "make_mesh", broken)
    design = parse_design('design.name = "unlucky"\nplates.count = 0')
    case = Case(design, SCENE, "plane-strain", scene_name="short")
    result = analyse_into(case, tmp_path, page=True, cad=True)
    assert result.status == "failed"
    stored = read_result(tmp_path / "unlucky")
    assert stored.scene == "short"
    assert stored.failure == "the mesher gave up"
    assert stored.timings_s["report"] > 0
    assert (tmp_path / "unlucky" / "report.html").exists()


LIFTED = """
[design]
name = "coarse"
[plates]
length_mm = 1.0
cover_mm = 1.2
[gages]
length_mm = 0.6
[mesh.section]
contact_size_mm = 0.2
plate_size_mm = 0.3
plate_end_size_mm = 0.1
[grip]
defaults = "fixed"
friction_coefficients = [0.4]
object_mass_g = 60.0
controller = "oracle_1.5"
max_steps = 60
plant = "lift"
hold_steps = 8
"""
WEIGHT = 0.060 * 9.80665


@pytest.mark.usefixtures("without_remedies")
@pytest.mark.parametrize(
    "more", ["[grip.hardware]\ngage_noise_microstrain = 0.5\n", 'opposite = "bare"\n']
)
def test_a_lift_is_held_on_and_recorded_and_plates_carry_more_than_a_bare_finger(more):
    analysis = run(Case(parse_design(LIFTED + more), None, "plane-strain", fields=False))
    (grip,), (trace,) = analysis.result.grips, analysis.grip_traces
    assert (grip.lifted, grip.gross_slip) == (True, False)
    if "bare" in more:
        assert 0.5 * WEIGHT * 1.001 < grip.final_tangential_force_N < 0.6 * WEIGHT
    else:
        assert 2.0 * grip.final_tangential_force_N == pytest.approx(WEIGHT, rel=1e-6)
        assert (trace.rise > 0.0).tolist() == [False] * (len(trace.rise) - 9) + [True] * 9


@pytest.mark.usefixtures("without_remedies")
def test_an_oracle_holds_a_multiple_of_the_least_force_under_a_law_of_pressure():
    """Half the weight over the reported coefficient is the least force: a little less pull is
    carried by it, a little more is not."""
    keys = {"friction_exponent": 0.31, "reference_pressure_MPa": 0.05}
    surface = SceneObject(friction_law="power", friction_coefficient=0.4, **keys)
    case = Case(parse_design(LIFTED), None, "plane-strain", fields=False, surface=surface)
    analysis = run(case)
    (grip,) = analysis.result.grips
    assert (grip.lifted, grip.gross_slip) == (True, False)
    assert grip.safety_margin == pytest.approx(1.5, abs=0.02)  # moves have a length
    assert grip.friction_law == str(surface.law)
    assert any("not Coulomb's" in text for text in analysis.result.warnings)
    assert (analysis.slip_studies, analysis.result.measurability) == ((), None)
    start, normal = ContactState.untouched(analysis.problem), grip.least_force_N
    pressed = solve_forces(analysis.problem, start, Forces(normal))
    carried = Forces(normal, 0.98 * 0.5 * WEIGHT)
    held = solve_forces(analysis.problem, pressed.state, carried)
    assert held.certificate.laws < 1e-8
    with pytest.raises(NoEquilibrium):
        solve_forces(analysis.problem, pressed.state, Forces(normal, 1.02 * 0.5 * WEIGHT))


@pytest.mark.usefixtures("without_remedies", "own_cache")
@pytest.mark.parametrize("scene", [None, fundamental_scene()])
def test_one_factorisation_serves_frictions_grips_and_fields(calls_of, scene):
    factored = calls_of(factor.Condensation, "__init__")
    recovered = calls_of(FiniteElementModel, "displacement_fields")
    values = COARSE | {"grip.friction_coefficients": [0.3, 0.8]}
    design = with_values(load_design("narrow"), values)
    analysis = run(Case(design, scene, "plane-strain", fields=scene is not None))
    assert (len(factored), len(recovered)) == (1, int(scene is not None))
    assert (analysis.fields is None) == (scene is None)
    assert len(analysis.result.grips) == (2 if scene is None else 0)
    assert (len(analysis.slip_studies) >= 5) == (scene is None)  # friction coefficients


SMALL = """
design.name = "small"
body.width_mm = 10.0
body.depth_mm = 4.0
body.base_height_mm = 4.0
body.arc_radius_mm = 12.0
plates.count = 1
plates.length_mm = 1.5
plates.thickness_mm = 0.2
"""
SHORT = "[object]\n[path]\nincrements_mm = [[0.1, 0.0], [0.1, 0.02], [0.1, 0.04]]"


@pytest.fixture(scope="module")
def climbed():
    design, scene = parse_design(SMALL), parse_scene(SHORT)
    return run(Case(design, scene, "auto", tolerance=0.2, fields=False)), design


def test_the_result_says_what_was_tried(climbed):
    analysis, design = climbed
    result = analysis.result
    ladder = result.ladder
    assert ladder.tolerance == 0.2
    assert ladder.reached == (max(ladder.error_estimates.values()) <= 0.2)
    assert ladder.models[-1].name == ladder.chosen
    assert all(each.why for each in ladder.models)
    assert result.fidelity == ("3d" if "3-D" in ladder.chosen else "plane-strain")
    assert result.model.dofs == ladder.models[-1].dofs
    assert any("--fidelity auto" in reason for reason in result.model.reasons)
    assert result.parameters["mesh.mesher"] == design.mesh.mesher  # the design as it was given
    assert Result.from_json(result.to_json()).ladder == ladder
    spent = sum(each.seconds for each in ladder.models)
    stages = ("mesh", "assemble", "condense", "increments")
    assert sum(result.timings_s[stage] for stage in stages) >= 0.99 * spent
    assert len(ladder_table(result).rows) == len(ladder.models)


@pytest.mark.parametrize("tolerance", [0.0, -1.0, 3.0, float("nan")])
def test_a_wrong_tolerance_is_refused_before_work(tolerance):
    with pytest.raises(DesignError, match=f"--accuracy = {tolerance}"):
        run(Case(parse_design(SMALL), parse_scene(SHORT), "auto", tolerance=tolerance))
