"""From sliders to numbers: one answer a move, condensed anew for the finger alone."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.starter import starter_text
from fingerdesign.studio import numbers as module
from fingerdesign.studio.engine import flat_scene
from fingerdesign.studio.figures import bars, trace, tractions
from fingerdesign.studio.numbers import PRESSES, SHEARS, Numbers, motions
from fingerdesign.studio.session import Session
from fingerdesign.studio.sliders import Press, _one_of, renewed, sliders_of
from fingerdesign.studio.words import finding, table
from tests.support.pages import run_python


@pytest.fixture(scope="module")
def session():
    found = Session()
    found.start()
    return found


@pytest.fixture
def numbers(session):
    return session.numbers


def test_friction_approach_and_shear_do_not_condense_anew(session):
    session.move({})
    before = session.engine.condensed
    shown = [
        session.move(values)
        for values in ({"friction": 0.3}, {"approach": 0.2}, {"shear": 0.02}, {"approach": 0.41})
    ]
    assert session.engine.condensed == before
    tables = [{row[0]: row[2] for row in each["table"]} for each in shown]
    assert len({each["normal force"] for each in tables}) > 2
    assert all(not each["faults"] for each in shown)
    session.move({"plates.angle_deg": 40.0})
    assert session.engine.condensed == before + 1
    session.move({"plates.angle_deg": 45.0, "approach": 0.1, "shear": 0.05, "friction": 0.5})
    assert session.engine.condensed == before + 1  # cached


def test_numbers_obey_the_laws(numbers):
    assert len(numbers.normal) == PRESSES + SHEARS
    assert (np.diff(numbers.normal[:PRESSES]) > 0.0).all()
    limit = numbers.friction * numbers.pressure
    assert (np.abs(numbers.shear) <= limit + 1e-9).all()
    assert (np.diff(numbers.ratio[PRESSES:]) <= 1e-9).all()
    assert numbers.readings.shape == (PRESSES + SHEARS, 15)


def test_numbers_are_of_the_designs_face_and_options_rise(half_plane, calls_of):
    faces = calls_of(module, "gage_readings")
    design = with_values(load_design("maeno2000"), {"gages.face": "lower"})
    module.numbers_of(design, half_plane, Press(0.1, 0.01, 0.5))
    assert {face for (_, face), _ in faces} == {"lower"}
    assert _one_of("body.width_mm", "", "", 2.0, (1.0, 3.0)).options == (1.0, 2.0, 3.0)


def made(more=0.0, **changes):
    steps = np.arange(PRESSES + SHEARS) + more
    facts = {"dimension": 2, "friction": 0.5, "width": 1.5 + more, "peak": 0.25 + more}
    facts |= {"normal": 2.0 + steps, "tangential": 3.0 * steps, "ratio": np.full(20, 0.5)}
    facts |= {"x": np.array([-2.0, 2.0]), "pressure": np.array([1.0, 2.0]) + more}
    facts |= {"shear": np.array([0.3, 0.4]) + more, "status_x": np.array([-2.0, 1.0])}
    facts |= {"status": np.array([0, 2]), "gage_x": np.array([-1.0, 1.0])}
    return Numbers(**facts | {"readings": np.outer(steps, [-1.0 - more, -2.0])} | changes)


def test_charts_and_table_show_their_own_numbers_and_those_that_are_pinned():
    now, pinned = made(), made(1.0)
    drawn = [each["y"] for each in tractions(now, pinned)["data"]]
    assert drawn == [[1.3, 1.4], [2, 3], [0.5, 1], [1, 2], [0.3, 0.4]]
    assert tractions(now)["layout"]["xaxis"]["range"] == [-1.25, 1.25]  # what is touched
    assert [each["y"] for each in bars(now, 0, pinned)["data"]] == [[-12, -24], [-24, -24]]
    beneath, own = trace(now, 0, pinned)["data"]
    assert (own["y"][-1], beneath["y"][-1]) == (-19, -40)
    assert len(trace(now, 1, made(readings=np.zeros((20, 1))))["data"]) == 1
    rows = {name: cells for name, _, *cells in table(now, pinned)}
    assert rows["normal force"] == ["22", "21"]  # pinned, now
    assert [cells[1] for cells in rows.values()] == ["21", "57", "1.50", "0.50", "0.25", "24"]
    found = [finding(made(ratio=np.array([end])))["status"] for end in (0.2, 0.19, 0.0, np.nan)]
    assert found == ["pass", "warning", "fail", "note"]


def test_a_pin_keeps_its_state_and_names_what_changed_since():
    session = Session(Path("both_ways"))
    session.engine = SimpleNamespace(numbers=lambda design, press: made(press.friction))
    session.answer()
    assert session.picked == 1  # the greatest change, though it is negative
    assert session.engine.reach == session.values_of("approach").high
    assert session.deep(made())["model"] == "3-D"
    session.pin()
    shown = session.move({"friction": 0.3, "body.width_mm": 21.0})
    assert shown["pinned"] == "pinned (3-D); since then: friction 0.5 → 0.3, width 18 → 21 mm"
    assert shown["model"] != "3-D"
    assert shown["shape_before"] != shown["shape"]
    assert session.pin()["pinned"] == ""


def test_what_cannot_be_moved_has_no_slider_and_ends_stay_where_they_hold_the_value():
    def sliders(name="maeno2000", **values):
        found = sliders_of(
            with_values(load_design(name), {k.replace("__", "."): v for k, v in values.items()})
        )
        return {each.key: each for each in found}

    assert "body.depth_mm" not in sliders("pin")
    assert "grip.object_mass_g" not in sliders(grip__object_mass_g=[100.0, 300.0])
    old, key = sliders(), "body.width_mm"
    assert (old[key].low, old[key].high) == (11.0, 33.0)
    for width, ends in ((25.0, 33.0), (40.0, 60.0)):
        new = renewed([*old.values()], [*sliders(body__width_mm=width).values()])
        assert next(each.high for each in new if each.key == key) == ends


def test_the_coarse_section_is_near_the_fine_one(numbers):
    """docs/how_to/studio.md: 0.3 and 0.7 % of the forces, 0.003 of the ratio, 0.8 % of readings."""
    from fingerdesign import analyse

    press = Press(0.1, 0.05, 0.5)
    design = load_design("maeno2000")
    rows = [[each.approach, each.shear] for each in motions(press)]
    scene = flat_scene(press).model_copy(
        update={"path": type(flat_scene(press).path)(increments_mm=rows)}
    )
    fine = analyse(design, scene, "plane-strain").increments
    assert numbers.normal[-1] == pytest.approx(fine[-1].normal_force_N, rel=0.01)
    assert numbers.tangential[-1] == pytest.approx(fine[-1].tangential_force_N, rel=0.02)
    assert numbers.ratio[-1] == pytest.approx(fine[-1].stick_ratio, abs=0.03)
    readings = np.array([[gage.reading for gage in row.gages] for row in fine])
    signals = readings[-1] - readings[PRESSES - 1]
    worst = np.abs(numbers.signals - signals).max() / np.abs(signals).max()
    assert worst < 0.05


def test_the_finding_on_a_press_answers_with_numbers(session):
    assert session.shown()["finding"]["status"] == "pass"
    assert "6.56 N normal" in session.shown()["finding"]["detail"]
    assert session.move({"shear": 0.41})["finding"]["status"] == "fail"
    assert session.move({"approach": 0.0, "shear": 0.0})["finding"]["status"] == "note"
    session.move({"approach": 0.1, "shear": 0.05})


def test_a_fault_is_shown_and_the_picture_stays(session):
    before = session.shown()["table"]
    shown = session.move({"plates.pitch_mm": 0.38, "plates.angle_deg": 0.0})
    assert "plates" in shown["faults"][0]
    assert shown["table"] == before
    assert session.move({"plates.pitch_mm": 0.75, "plates.angle_deg": 45.0})["faults"] == []


def test_a_clicked_gage_shows_its_trace(session):
    shown = session.pick(3)
    drawn = shown["trace"]["data"][-1]["y"]
    assert drawn == pytest.approx(session.numbers.readings[:, 3], rel=1e-3)
    assert 'class="gage picked" data-gage="3"' in shown["sketch"]
    assert session.pick(99)["picked"] == 3


def test_a_finger_without_plates_has_no_gages_and_no_failure():
    session = Session(Path("homogeneous"))
    shown = session.start()
    assert shown["faults"] == []
    assert not any(each["key"].startswith(("plates", "gages")) for each in shown["sliders"])
    assert shown["picked"] is None


def test_the_file_is_watched(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(starter_text("mine", "maeno2000"), encoding="utf-8")
    session = Session(path)
    session.start()
    assert session.look() == {}
    path.write_text(path.read_text("utf-8").replace("angle_deg = 45.0", "angle_deg = 30.0"))
    shown = session.look()
    assert shown["values"]["plates.angle_deg"] == 30.0
    assert session.design.plates.angle_deg == 30.0
    assert session.save()["note"].startswith("saved")
    sound = path.read_text("utf-8")
    path.write_text("[plates]\ncount = -1\n")
    assert "plates.count" in " ".join(session.look()["faults"])
    assert session.look() == {}
    path.write_text(sound)
    assert session.look()["faults"] == []


@pytest.mark.parametrize("value", [10**400, -(10**400), float("nan"), float("inf"), "1", None, [2]])
def test_no_value_of_a_client_leaves_a_slider(session, value):
    keys = ("friction", "approach", "plates.count", "plates.material", "gages.grid", "no.such")
    session.move(dict.fromkeys(keys, value))
    for each in session.sliders:
        assert each.allowed(session.values[each.key]) == session.values[each.key]
    session.move({"friction": 0.5, "approach": 0.2, "plates.count": 15})


def test_the_pages_python_runs(capsys):
    run_python("how_to/studio.md")
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("plane strain, coarse section pass")
    assert printed[1] == "{'plates.angle_deg': 40.0}"
