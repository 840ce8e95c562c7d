"""``fingerdesign identify DESIGN TRACE``: modulus, relaxation, friction, gages, or why not."""

import json
import re
from dataclasses import replace

import jsonschema
import numpy as np
import pytest

from fingerdesign import load_design, parse_design
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.trace import Trace, parse_trace
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.records.base import DATA, plain
from fingerdesign.sensing.identify.simulated_trace import simulated_trace
from fingerdesign.sensing.identify.trace_fit import identified
from fingerdesign.sensing.identify.trace_model import noise_of
from fingerdesign.sensing.identify.trace_path import MOST_MOVES, TracePath, played
from fingerdesign.sensing.identify.trace_report import identification, identified_design
from fingerdesign.sensing.model import grip_problem
from fingerdesign.shapes.friction import FrictionLaw
from tests.sensing.conftest import FINGER


@pytest.fixture(scope="module")
def design():
    return parse_design(FINGER)


@pytest.fixture(scope="module")
def made(design):
    """Seed 1 draws one term of relaxation, of 2.3 s."""
    return simulated_trace(design, 1, hold_s=15.0)


@pytest.fixture(scope="module")
def found(design, made):
    return identified(design, made.trace, "trace.csv")


@pytest.fixture(scope="module")
def data(found):
    return identification(found, "trace.csv")


@pytest.mark.slow
def test_what_was_drawn_is_found_within_its_intervals(data, made):
    values = {each.name: each for each in data.values}
    assert values.keys() - {"relaxed_modulus"} == made.truth.keys()
    beyond = [
        name
        for name, true in made.truth.items()
        if not values[name].low <= true <= values[name].high
    ]
    assert len(beyond) <= 0.15 * len(made.truth), beyond
    for name, share in (("youngs_modulus", 0.01), ("friction_coefficient", 0.01), ("time_1", 0.1)):
        assert values[name].value == pytest.approx(made.truth[name], rel=share)
        assert values[name].determined
    shares = sum(true for name, true in made.truth.items() if name.startswith("share_"))
    fresh = made.truth["youngs_modulus"]
    assert values["relaxed_modulus"].value == pytest.approx(fresh * (1.0 - shares), rel=0.01)
    assert 0.8 < data.misfit < 1.25
    assert data.next_motion is None


@pytest.mark.slow
def test_what_the_model_does_not_explain_widens_deviations(found):
    """By the root of what is left over noise; less than the noise makes none narrower."""
    narrow, usual, wide = (replace(found.fit, misfit=each) for each in (0.25, 1.0, 4.0))
    assert narrow.deviations == pytest.approx(usual.deviations)
    modulus, friction = wide.deviations[:2] / usual.deviations[:2]
    assert (modulus, friction) == pytest.approx((2.0, 2.0), rel=0.02)


@pytest.mark.slow
def test_a_press_alone_tells_no_friction_and_asks_for_a_shear(design, made):
    trace = cut(made.trace, 150)
    assert trace.dx.max() == 0.0
    data = identification(identified(design, trace, "press.csv", terms=0), "press.csv")
    values = {each.name: each for each in data.values}
    assert not values["friction_coefficient"].determined
    assert data.next_motion is not None
    assert data.next_motion.motion == "shear"
    assert data.next_motion.of == "friction_coefficient"
    assert data.next_motion.then < 1.0 < data.next_motion.now
    assert "grip.bench_friction_coefficient" not in str(values)
    assert any("does not decide whether friction depends" in each for each in data.warnings)


def cut(trace, rows):
    return Trace(
        *(getattr(trace, name)[:rows] for name in ("time", "dx", "dy")),
        *(getattr(trace, name)[:rows] for name in ("normal_force", "tangential_force")),
        trace.readings[:rows],
        trace.rows[:rows],
        temperature=trace.temperature[:rows],
    )


@pytest.mark.slow
def test_the_design_carries_what_was_found_and_its_source(design, found, data):
    own = identified_design(found, data)
    modulus = data.values[0]
    assert own.materials["silicone"].youngs_modulus_MPa == pytest.approx(modulus.value, rel=1e-5)
    assert "identified from trace.csv" in own.materials["silicone"].source
    assert own.grip.rubber_memory == ()  # of a plant that cannot feel it
    assert any("rubber_memory" in each for each in data.warnings)
    assert own.plates == design.plates


@pytest.mark.slow
def test_the_record_has_its_schema_and_the_page_its_terms(found, data):
    from fingerdesign.sensing.identify.trace_page import identify_html

    schema = json.loads((DATA / "identification.schema.json").read_text("utf-8"))
    jsonschema.validate(plain(data), schema)
    page = identify_html(found, data)
    assert "trace.csv" in page
    hostile = replace(data, trace="<script>alert(1)</script>")
    assert "<script>alert" not in identify_html(found, hostile)


def test_points_are_the_rows_that_move_and_means_of_those_at_rest(made):
    path = TracePath.of(made.trace)
    assert path.samples.sum() <= len(made.trace)
    moving = path.samples == 1.0
    assert MOST_MOVES <= moving.sum() < MOST_MOVES + 30
    assert path.rest == pytest.approx(15.0, rel=0.1)
    assert (np.diff(path.time) > 0.0).all()
    last = path.samples[-1]
    assert path.readings[-1] == pytest.approx(made.trace.readings[-int(last) :].mean(axis=0))


def test_a_played_path_is_that_of_the_plant(design):
    """Without a memory; with one, forces at the end of a long rest are those that are left."""
    problem = grip_problem(design).with_friction(0.5)
    down = np.linspace(0.0, 0.15, 11)[1:]
    approach, shear = np.r_[down, np.full(8, 0.15)], np.r_[np.zeros(10), np.linspace(0.01, 0.08, 8)]
    none = np.zeros(18)
    time = np.r_[np.arange(1, 18) * 0.01, 1e4]
    path = TracePath(time, approach, shear, np.zeros((18, 2)), none[:, None], none + 1.0)
    plant = CondensedPlant(problem, "upper")
    samples = [
        plant.move(*move)
        for move in zip(np.diff(shear, prepend=0.0), np.diff(approach, prepend=0.0), strict=True)
    ]
    answers = played(problem, "upper", path)
    assert answers[:, 0] == pytest.approx([each.normal_force for each in samples])
    assert answers[:, 2:] == pytest.approx(np.array([each.readings for each in samples]))
    relaxed = played(problem, "upper", replace(path, shear=none), [(0.2, 0.5)])
    fresh = played(problem, "upper", replace(path, shear=none))
    assert relaxed[-1, 0] == pytest.approx(0.8 * fresh[-1, 0], rel=1e-3)


def slid_at_two_depths(design, law):
    """Pressed to 0.08 mm, sheared until all slips, pressed on to 0.22 mm, sheared again; noise."""
    deep = np.repeat([0.08 / 40, 0.0, 0.14 / 40, 0.0], [40, 40, 40, 93])
    across = np.repeat([0.0, 0.003, 0.0, 0.00825, 0.0], [40, 40, 40, 40, 53])
    rows, none = np.arange(213), np.zeros(213)
    trace = Trace((rows + 1) / 27.0, across, deep, none, none, none[:, None], rows + 2)
    problem = grip_problem(design).with_friction(law)
    answers = played(problem, design.gages.face, TracePath.every(trace))
    noisy = answers + np.random.default_rng(3).standard_normal(answers.shape) * np.array(
        [0.005, 0.005, *[0.5] * (answers.shape[1] - 2)]
    )
    forces = {"normal_force": noisy[:, 0], "tangential_force": noisy[:, 1]}
    return replace(trace, readings=noisy[:, 2:], temperature=none + 20.0, **forces)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "exponent", "words"),
    [
        (FrictionLaw(0.5), 0.0, None),
        (FrictionLaw(0.5, exponent=0.31, reference=0.3), 0.31, "friction falls with the pressure"),
        (FrictionLaw(0.0, strength=0.1), None, "a constant strength of 0.0"),
    ],
)
def test_two_slides_tell_the_law_of_friction(design, law, exponent, words):
    found = identified(design, slid_at_two_depths(design, law), "two.csv", terms=0)
    value, deviation = found.exponent
    if exponent is not None:
        assert abs(value - exponent) < 4.0 * deviation + 1e-3
    assert deviation < 0.01
    data = identification(found, "two.csv")
    about = [each for each in data.warnings if "pressure" in each]
    assert [words in each for each in about] == ([] if words is None else [True])
    assert any(each.name == "friction_exponent" for each in data.values) == (words is not None)
    assert data.misfit < 1.25
    assert data.values[0].value == pytest.approx(4.96, rel=2e-3)


def test_noise_is_found_by_second_differences(made):
    noise = noise_of(made.trace)
    assert noise[:2] == pytest.approx(0.005, rel=0.15)
    assert noise[2:] == pytest.approx(0.5, rel=0.15)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: replace(t, dy=-t.dy), "over 0"),
        (lambda t: replace(t, dx=t.dy, dy=t.dx), "are dx_mm and dy_mm exchanged?"),
        (lambda t: cut(replace(t, dx=t.dy, dy=t.dx), 150), "are dx_mm and dy_mm exchanged?"),
        (lambda t: replace(t, dy=3.0 * t.dy), "grip.max_approach_mm"),
        (lambda t: replace(t, dy=np.cumsum(t.dy)), "a row has its own move"),
        (lambda t: replace(t, tangential_force=-t.tangential_force), "the other way"),
        (
            lambda t: replace(t, normal_force=0.001 * t.normal_force + 1e-3 * np.sin(1e3 * t.time)),
            "twenty times",
        ),
    ],
)
def test_traces_that_tell_nothing_are_refused(design, made, change, words):
    with pytest.raises(DesignError, match=re.escape(words)):
        identified(design, change(made.trace), "trace.csv")


@pytest.mark.parametrize(("factor", "doubted"), [(1e-3, True), (1.0, False), (1e3, True)])
def test_times_of_another_unit_are_doubted_before_the_fit(design, made, factor, doubted):
    """A report that ends the work as the fit begins."""
    shown = []

    def report(message, share=None):
        shown.append(message)
        if "condensing" in message:
            raise SolverError("enough")

    trace = replace(made.trace, time=factor * made.trace.time)
    with pytest.raises(SolverError, match="enough"):
        identified(design, trace, "trace.csv", report=report)
    assert any("is time_s in seconds?" in each for each in shown) is doubted


@pytest.mark.slow
def test_forces_of_another_unit_are_refused(design, made):
    """1000 times too small; after two fits, not when a file of such a modulus cannot be written."""
    names = ("normal_force", "tangential_force")
    small = {name: 1e-3 * getattr(made.trace, name) for name in names}
    with pytest.raises(SolverError, match=r"over 64 times as large or as small .* forces in N"):
        identified(design, replace(made.trace, **small), "kN.csv", terms=0)


def test_temperature_is_read_and_written(made):
    text = made.trace.to_csv()
    assert "temperature_C" in text.splitlines()[0]
    again = parse_trace(text, 4)
    assert again.temperature == pytest.approx(made.trace.temperature)


@pytest.mark.slow
def test_the_command_and_its_mistakes(design, made, tmp_path, terminal):
    file, trace = tmp_path / "mine.toml", tmp_path / "trace.csv"
    file.write_text(FINGER)
    trace.write_text(cut(made.trace, 320).to_csv())
    out = tmp_path / "out"
    found = terminal("identify", file, trace, "--terms", "0", "--out", out, "--json").out
    assert json.loads(found)["design"] == "mine"
    for name in ("identification.json", "identified.toml", "identify.html"):
        assert (out / "mine" / name).is_file()
    assert load_design(out / "mine" / "identified.toml").design.name == "mine"
    assert "youngs modulus" in terminal("view", out / "mine").out
    assert "either SOURCE" in terminal("identify", file, code=2).err
    assert "makes a page" in terminal("identify", file, "--simulate", "--open", code=2).err
    trace.write_text("time_s\n1\n")
    assert "trace.csv" in terminal("identify", file, trace, code=2).err
    terminal("identify", file, "--simulate", "--out", tmp_path / "sim", "--quiet")
    assert json.loads((tmp_path / "sim/mine/truth.json").read_text())["youngs_modulus"] > 0.0
