"""Changes of the studio's design: controls, remedies, starts, undo, and the best of a search."""

import pickle
from dataclasses import replace
from pathlib import Path

import pytest

from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.checks.load import load_design, parse_design, with_values
from fingerdesign.design.shipped import shipped_names
from fingerdesign.design.starter import starter_text
from fingerdesign.errors import DesignError
from fingerdesign.records.outcome import Outcome
from fingerdesign.records.verdict import Fix, Verdict, VerdictView
from fingerdesign.search.passing.found import Candidate, Found
from fingerdesign.search.passing.space import space_of
from fingerdesign.studio import passing
from fingerdesign.studio.history import History, State
from fingerdesign.studio.judge import PLANE, SPACE, judged
from fingerdesign.studio.passing import PassingSearch, Progress
from fingerdesign.studio.session import Session
from fingerdesign.studio.sliders import sliders_of

REMEDIES = {
    "body.depth_mm",
    "plates.material",
    "plates.thickness_mm",
    "plates.count",
    "gages.grid",
    "gages.length_mm",
    "grip.object_mass_g",
}


class NoNumbers:
    """Stands in for the engine: these tests change designs and need no contact."""

    reach = condensed = 0.0

    def numbers(self, design, press):
        raise DesignError([])


@pytest.fixture
def session():
    found = Session()
    found.engine = NoNumbers()
    found.history.clock = iter(range(0, 10_000, 10)).__next__  # each move is a change of its own
    return found


def changed(session):
    return session.document.unsaved


@pytest.mark.parametrize("name", ["maeno2000", "film_tees", "domed", "block"])
def test_what_the_remedies_ask_for_has_a_control_with_label_and_tip(name):
    controls = {each.key: each for each in sliders_of(load_design(name))}
    assert set(controls) >= REMEDIES
    for each in controls.values():
        assert each.label
        assert len(each.tip) > 10
        assert each.allowed(each.value) == each.value


def test_plates_are_chosen_from_what_is_sold(session):
    sheets = lambda: session.values_of("plates.thickness_mm").options  # noqa: E731
    assert 0.15 in sheets()
    shown = session.move({"plates.material": "polyimide"})
    assert session.design.plates.material == "polyimide"
    assert 0.125 in sheets()
    assert 0.15 not in sheets()
    assert shown["unsaved"] == 1
    assert session.move({"plates.material": "cheese"})["unsaved"] == 1


def test_a_count_stays_whole_and_full_spans_follow_the_depth(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(starter_text("mine", "maeno2000"), encoding="utf-8")
    session = Session(path)
    session.engine = NoNumbers()
    session.move({"plates.count": 11.2, "body.depth_mm": 8.0})
    assert changed(session) == {"plates.count": 11, "body.depth_mm": 8.0, "plates.span_mm": 8.0}
    session.save()
    saved = parse_design(path.read_text("utf-8"))
    assert (saved.plates.count, saved.plates.span_mm) == (11, 8.0)


def test_a_weight_of_a_tee_goes_with_the_tee_and_a_span_of_its_own_stays(session):
    own = {"gages.grid": "tee", "gages.transverse_weight": 0.3, "plates.span_mm": 5.0}
    session.document.put(own)
    session.answer()
    session.move({"gages.grid": "axial", "body.depth_mm": 8.0})
    assert (session.design.gages.transverse_weight, session.design.plates.span_mm) == (None, 5.0)
    assert session.faults == []


def test_undo_and_redo_go_through_all_changes(session):
    begin = session.design
    session.move({"plates.angle_deg": 30.0})
    session.move({"friction": 0.3})
    shown = session.move({"plates.count": 9})
    assert (shown["undo"], shown["redo"]) == (3, 0)
    assert session.undo()["values"]["plates.count"] == 15
    assert session.undo()["values"]["friction"] == 0.5
    assert session.undo()["values"]["plates.angle_deg"] == 45.0
    assert session.design == begin
    assert session.undo() == {}
    assert session.redo()["values"]["plates.angle_deg"] == 30.0
    session.redo()
    assert session.redo()["values"]["plates.count"] == 9
    session.undo()
    session.move({"plates.count": 7})
    assert session.redo() == {}  # a new change ends what could be made again


def test_a_slider_that_moves_on_is_one_change():
    now, history = [0.0], History(clock=lambda: now[0])
    states = [State(None, "", None, {}, {"k": k}) for k in range(4)]
    history.record(states[0], frozenset({"a"}))
    now[0] = 0.5
    history.record(states[1], frozenset({"a"}))
    assert len(history.back) == 1
    history.record(states[2], frozenset({"b"}))
    now[0] = 5.0
    history.record(states[3], frozenset({"b"}))
    assert [each.values["k"] for each in history.back] == [0, 2, 3]
    # After undo the slider's next move is a change of its own, however soon.
    assert history.undo(states[0]) is states[3]
    history.record(states[1], frozenset({"b"}))
    assert history.undo(states[0]) is states[1]


def test_undo_after_save_keeps_the_file_and_takes_the_change_back(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(starter_text("mine", "maeno2000"), encoding="utf-8")
    session = Session(path)
    session.engine = NoNumbers()
    session.move({"plates.angle_deg": 30.0})
    session.save()
    session.undo()
    assert session.look() == {}
    assert changed(session) == {"plates.angle_deg": 45.0}
    assert "angle_deg = 30.0" in path.read_text("utf-8")
    path.write_text(path.read_text("utf-8").replace("angle_deg = 30.0", "angle_deg = 20.0"))
    assert session.look()["values"]["plates.angle_deg"] == 20.0  # an editor's change wins
    assert session.undo()["values"]["plates.angle_deg"] == 45.0


def test_every_shipped_finger_is_a_start_and_undo_leads_back(session):
    session.move({"plates.angle_deg": 30.0})
    assert session.start()["starts"] == list(shipped_names())
    for name in shipped_names():
        shown = session.begin_from(name)
        assert (shown["name"], shown["file"]) == (name, f"{name}.toml")
        assert session.design == load_design(name)
        assert session.undo()["values"]["plates.angle_deg"] == 30.0
    assert session.document.path == Path("maeno2000.toml")
    assert session.begin_from("../secret") == {}


def test_a_remedy_that_is_shown_can_be_made_and_no_other(session):
    fixes = (Fix('plates.material = "polyimide"', "gage signal"), Fix("fingerdesign x", "searches"))
    view = VerdictView("a", "plane strain", 1.0, (Verdict("fail", "b", "c"),), fixes)
    shown = session.store(session.design, PLANE, view)
    assert [each["change"] for each in shown["fixes"]] == ['plates.material = "polyimide"']
    assert shown["summary"] == "1 of 1 fail"
    assert session.apply('plates.material = "abs"') == {}
    session.apply('plates.material = "polyimide"')
    assert changed(session) == {"plates.material": "polyimide"}
    assert session.shown()["verdicts"] == []  # of another finger
    assert session.undo()["verdicts"] != []


def test_verdicts_in_3d_come_before_those_of_plane_strain(session):
    views = [VerdictView("a", each, 1.0, ()) for each in ("plane strain", "3-D")]
    assert not session.is_judged()
    assert session.store(session.design, PLANE, "refused")["unjudged"] == "refused"
    session.store(session.design, SPACE, views[1])
    assert session.store(session.design, PLANE, views[0])["judged"] == "3-D"


def best(**values):
    return with_values(load_design("maeno2000"), values)


def test_the_controls_follow_a_search_and_one_undo_leads_back(session):
    begin = session.design
    session.begin_search()
    view = VerdictView("a", "trial in 3-D", 1.0, (Verdict("fail", "slip sensing", "0.5"),))
    first = best(**{"plates.material": "polyimide", "plates.cover_mm": 0.5})
    shown = session.follow(Progress("trial 4 of 8", first, view))
    assert shown["values"]["plates.cover_mm"] == 0.5
    assert shown["search"]["message"] == "trial 4 of 8"
    assert shown["search"]["verdicts"][0]["sign"] == "✗"
    assert not session.is_judged()  # a trial is no verdict
    second = best(**{"plates.material": "polyimide", "plates.cover_mm": 0.6, "plates.count": 9})
    confirmed = VerdictView("a", "3-D", 1.0, (Verdict("pass", "slip sensing", "0.9"),))
    shown = session.follow(Progress("4 trials", second, confirmed, confirmed=True))
    assert shown["values"]["plates.count"] == 9
    assert (shown["judged"], shown["summary"]) == ("3-D", "passes")
    assert session.design == second
    session.undo()
    assert session.design == begin


def test_a_finger_of_other_tables_is_taken_whole_and_saved(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(starter_text("mine", "both_ways"), encoding="utf-8")
    session = Session(path)
    session.engine = NoNumbers()
    design = session.design
    other = load_design("film_tees")
    found = other.model_copy(update={"design": design.design})
    session.begin_search()
    session.follow(Progress("end", found, VerdictView("a", "3-D", 1.0, ())))
    assert session.design.digest() == found.digest()
    session.save()
    assert session.document.changes() == 0
    assert parse_design(path.read_text("utf-8")).plates == found.plates


def test_a_search_writes_its_best_so_far_and_ends_with_it(monkeypatch, tmp_path):
    design = load_design("maeno2000")
    metrics = {"area_correlation": 0.9, "smallest_stick_change": 0.2, "shortfall": 1.0}
    better = best(**{"plates.material": "polyimide"})
    sensed = Outcome(
        digest="0", name="a", values={}, design={}, scene="", fidelity="3d", status="ok",
        metrics=metrics,
    )  # fmt: skip
    seen = []

    def find(design, freedom, journal, calls, most):
        calls.report("trial 4 of 7")
        calls.improved(Candidate(better, sensed))
        seen.append(pickle.loads((tmp_path / "progress.pkl").read_bytes()))
        space = replace(space_of(design, freedom), given_up=("body.core",))
        return Found(space, (), (), None, "goals exclude each other")

    monkeypatch.setattr(passing, "search_passing", find)
    end = passing.search(design, tmp_path, 7)
    assert seen[0].message == "trial 4 of 7"
    assert seen[0].best == end.best == better
    assert not end.confirmed
    assert [(each.sign, each.name) for each in end.view.verdicts] == [
        ("✓", "slip sensing"),
        ("✗", "gage signal"),
        ("·", "lifts"),
    ]
    assert end.conflict == "goals exclude each other"
    assert end.message.startswith("0 trials. No finger was found that passes with your body.core")


def test_a_search_that_was_stopped_is_no_failure():
    search = PassingSearch()
    search.stop()
    search.run(load_design("maeno2000"), 1)
    assert search.progress().message.startswith("stopped")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["maeno2000", "film_tees"])
def test_the_studio_judges_as_analyse_does(name, tmp_path, terminal):
    """One function: the same verdicts and fixes as the command's result has."""
    from fingerdesign.records.result import Result

    terminal("analyse", name, "--fidelity", "plane-strain", "--out", tmp_path)
    result = Result.from_json((tmp_path / name / "result.json").read_text("utf-8"))
    of_command, of_studio = verdict_view(result), judged(load_design(name), PLANE)
    assert of_studio.verdicts == of_command.verdicts
    assert of_studio.fixes == of_command.fixes
    assert len(of_studio.verdicts) == 4
