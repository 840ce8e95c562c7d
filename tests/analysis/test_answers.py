"""What was analysed before: taken as it was, drawn on demand, never taken for something else."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from fingerdesign_cli.main import main

from fingerdesign import load_design, with_values
from fingerdesign.analysis import answers
from fingerdesign.analysis.analysis import parameters
from fingerdesign.analysis.answers import ARRAYS, CAD, DESIGN, PAGE, cached_answer
from fingerdesign.analysis.case import Case, result_digest
from fingerdesign.analysis.folder import _analysed_design, complete
from fingerdesign.analysis.page import page
from fingerdesign.analysis.page.page import report_html
from fingerdesign.design.io import dump_design
from fingerdesign.design.scene import SceneObject
from fingerdesign.pipeline import analyse_into, run
from fingerdesign.records.base import ResultError
from fingerdesign.records.result import MeshSummary, ModelSummary, Result
from tests.support.result_folders import write_result_folder

COARSE = {
    "mesh.section.contact_size_mm": 0.15,
    "mesh.section.plate_size_mm": 0.3,
    "mesh.section.plate_end_size_mm": 0.1,
    "mesh.section.far_size_mm": 2.0,
    "grip.friction_coefficients": [0.5],
    "grip.max_steps": 30,
}


@pytest.fixture
def case():
    return Case(with_values(load_design("narrow"), COARSE), None, "plane-strain")


def contents(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.mark.slow
def test_an_answer_is_taken_as_it_was_and_drawn_on_demand(
    case, tmp_path, own_cache, capsys, monkeypatch
):
    worked = analyse_into(case, tmp_path / "a")
    first = contents(tmp_path / "a/narrow")
    assert {"result.json", ARRAYS, DESIGN} < set(first)
    assert not {PAGE, CAD} & set(first)
    assert analyse_into(case, tmp_path / "b") == worked
    assert contents(tmp_path / "b/narrow") == first
    whole = run(case)
    timed = {"timings_s": worked.timings_s, "peak_memory_MB": worked.peak_memory_MB}
    for name, value in timed.items():
        object.__setattr__(whole.result, name, value)
    assert main(["view", str(tmp_path / "a/narrow"), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown[0]["report"] is None
    monkeypatch.setattr(page, "perf_counter", lambda: 0.0)  # the page tells its own time
    assert main(["view", str(tmp_path / "a/narrow")]) == 0
    drawn = (tmp_path / "a/narrow" / PAGE).read_text("utf-8")
    # The page from the folder is the one that the analysis itself would have made.
    assert drawn == report_html(whole)
    drawn = re.sub(r"<[^>]*>", "", drawn)
    for verdict in shown[0]["verdicts"]:  # page and terminal show the same
        assert verdict["count"] in drawn
    analyse_into(case, tmp_path / "c", cad=True)
    assert {CAD, "finger.stl"} < set(contents(tmp_path / "c/narrow"))
    assert CAD in set(contents_of_cached(case, tmp_path / "d"))
    analyse_into(case, tmp_path / "e", page=False, cad=False)
    assert not {CAD, "finger.stl", PAGE} & set(contents(tmp_path / "e/narrow"))


def contents_of_cached(case, out):
    assert cached_answer(case, out, cad=True) is not None
    return contents(out / case.design.design.name)


@pytest.mark.slow
def test_no_answer_is_taken_for_another_or_when_it_is_garbled(case, tmp_path, own_cache):
    first = analyse_into(case, tmp_path)
    softer = with_values(case.design, {"materials.silicone.youngs_modulus_MPa": 1.0})
    for other in (
        Case(softer, None, "plane-strain"),
        Case(case.design, case.path_scene, "plane-strain"),
        Case(case.design, None, "3d"),
        Case(case.design, None, "auto", tolerance=0.5),
        *(
            replace(case, **{name: not getattr(case, name)})
            for name in ("grips", "fields", "studied", "for_page", "mesh_error")
        ),
    ):
        assert cached_answer(other, tmp_path / "other") is None
    (cached,) = (tmp_path / "answers").iterdir()
    cached.write_bytes(cached.read_bytes()[:-200])
    assert cached_answer(case, tmp_path) is None
    assert analyse_into(case, tmp_path).increments == first.increments
    before = cached.stat().st_mtime_ns
    analyse_into(case, tmp_path, fresh=True)
    assert cached.stat().st_mtime_ns > before


@pytest.mark.slow
def test_arrays_and_designs_that_were_changed_are_refused(case, tmp_path, own_cache, capsys):
    analyse_into(case, tmp_path)
    folder = tmp_path / "narrow"
    text = (folder / DESIGN).read_text("utf-8")
    (tmp_path / "copy.toml").write_text(text, "utf-8")
    command = ["analyse", str(tmp_path / "copy.toml"), "--out", str(tmp_path)]
    assert main([*command, "--fidelity", "plane-strain"]) == 0
    assert "has design.name 'narrow': it replaces" in capsys.readouterr().err
    (folder / DESIGN).write_text(text.replace("width_mm = 10.0", "width_mm = 10.5", 1), "utf-8")
    assert (folder / DESIGN).read_text("utf-8") != text
    with pytest.raises(ResultError, match=r"body\.width_mm is 10\.5"):
        complete(folder, page=False, cad=True)
    arrays = np.load(folder / ARRAYS)
    about = json.loads(str(arrays["about"]))
    for junk in (b"", b"PK\3\4", {"kind": "Path", "values": {}}, [1], {"pairs": [["mesh", 3]]}):
        if isinstance(junk, bytes):
            (folder / ARRAYS).write_bytes(junk)
        else:
            np.savez(folder / ARRAYS, about=np.array(json.dumps(junk)))
        assert main(["view", str(folder)]) in (1, 2)
        assert "narrow" in capsys.readouterr().err
        assert not (folder / PAGE).exists()
    assert about["pairs"]
    names = {"contact.points", "mesh.points", "slip_studies.0.stick_ratio", "grip_traces.0.hold"}
    assert names < set(arrays)


def test_an_answer_s_key_holds_all_that_decides_its_numbers(case):
    scene, rough = case.path_scene, SceneObject(friction_coefficient=0.9)
    softer = with_values(case.design, {"materials.silicone.youngs_modulus_MPa": 1.0})
    flags = ("grips", "fields", "studied", "for_page", "mesh_error")
    other = {name: not getattr(case, name) for name in flags}
    other |= {"design": softer, "scene": scene, "scene_name": "b", "surface": rough}
    auto = replace(case, fidelity="auto", tolerance=0.01)
    assert {*other, "fidelity", "tolerance", "go_on", "estimator"} == {*vars(case)}
    cases = [case, auto, replace(auto, tolerance=0.02), replace(case, fidelity="3d")]
    cases += [replace(case, **{name: value}) for name, value in other.items()]
    cases.append(replace(case, design=with_values(case.design, {"design.name": "named"})))
    assert len({answers._key(each) for each in cases}) == len(cases)
    assert answers._key(replace(case, go_on=True, tolerance=0.5)) == answers._key(case)
    assert answers._key(replace(case, estimator=object())) is None
    digests = {result_digest(case.design, scene, each) for each in ("3d", "finite")}
    digests.add(result_digest(softer, scene, "3d"))
    digests.add(result_digest(case.design, scene.model_copy(update={"object": rough}), "3d"))
    assert len(digests) == 4


def made_folder(folder, case, **texts):
    model, mesh = ModelSummary(2, "P2", 1, 1, False), MeshSummary("a", 1, 30.0, 0.0, None)
    given = {"mesh": mesh, "parameters": parameters(case.design, case.path_scene)}
    result = Result("narrow", "s", "0", {}, "3d", model=model, **given)
    return result, write_result_folder(folder, result, texts=texts)


def test_a_cached_answer_is_given_with_the_products_requested_alone(case, tmp_path, own_cache):
    drawn, deep = {PAGE, CAD, "finger.stl"}, replace(case, fidelity="finite")
    result, folder = made_folder(tmp_path / "made", case, **dict.fromkeys(drawn, "a"))
    answers.cache_answer(case, folder, Result("narrow", "s", "0", {}, "3d", "failed", "it broke"))
    assert not answers.is_cached(case)
    for each in (case, deep):
        answers.cache_answer(each, folder, result)
    solids = drawn - {PAGE}
    asked = [(case, None, None, set()), (case, True, None, {PAGE}), (case, None, True, solids)]
    asked += [(deep, None, None, drawn), (deep, False, None, solids)]
    for of, with_page, cad, given in asked:
        assert cached_answer(of, tmp_path, with_page, cad) == result
        assert {path.name for path in (tmp_path / "narrow").iterdir()} & drawn == given
        assert answers.missing(of, tmp_path, with_page, cad) == (False, False)
        assert answers.missing(of, tmp_path, True, True) == (PAGE not in given, CAD not in given)


def test_cad_is_drawn_of_the_design_that_was_analysed_alone(case, tmp_path):
    text = dump_design(case.design)
    _, folder = made_folder(tmp_path / "made", case, **{DESIGN: text, CAD: ""})
    assert _analysed_design(folder) == case.design
    changed = text.replace("width_mm = 10.0", "width_mm = 10.5", 1)
    (folder / DESIGN).write_text(changed, encoding="utf-8")
    complete(folder, page=False, cad=True)  # It is there.
    (folder / CAD).unlink()
    with pytest.raises(ResultError, match=r"body\.width_mm is 10\.5 there and was 10"):
        complete(folder, page=False, cad=True)
