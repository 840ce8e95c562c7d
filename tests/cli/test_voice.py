"""One voice: an option of a name means the same in every command, and what writes has a place;
what is nearly typed is named; shells complete names; view reads every folder that is written."""

import json

import click
import numpy as np
import pytest
from click.shell_completion import BashComplete
from fingerdesign_cli.main import cli
from fingerdesign_cli.options import SHELVES
from fingerdesign_cli.terminal import _verdict_lines

from fingerdesign.analysis.page.section import enlarged_shapes
from fingerdesign.analysis.page.sketch import facts
from fingerdesign.checks.load import load_design
from fingerdesign.design.shipped import shipped_names
from fingerdesign.layout.row_keys import plate_rows
from fingerdesign.records.verdict import Verdict


def leaves(group, name=""):
    """Every command by its words, the groups that work by themselves too."""
    for key, each in group.commands.items():
        words = f"{name} {key}".strip()
        if not isinstance(each, click.Group) or each.invoke_without_command:
            yield words, each
        if isinstance(each, click.Group):
            yield from leaves(each, words)


def options(name):
    """Every command with its option of a name."""
    found = {}
    for words, command in leaves(cli):
        for option in command.params:
            if name in option.opts:
                found[words] = option
    return found


@pytest.mark.parametrize("name", ["--json", "--quiet", "--open", "--workers"])
def test_an_option_is_the_same_everywhere(name):
    found = options(name)
    facts = {
        words: (o.help, o.is_flag, o.multiple, o.default, str(o.type), o.opts, o.show_default)
        for words, o in found.items()
    }
    assert len(facts) > 5
    assert len({str(fact) for fact in facts.values()}) == 1, facts


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        (["optimize"], "optimise"),
        (["analyze"], "analyse"),
        (["mould"], "mold"),
        (["bench", "stabilty"], "stability"),
        (["analyse", "narrow", "--fidelty", "3d"], "--fidelity"),
        (["check", "narow"], "narrow"),
        (["check", "fngers"], "fingers"),
        (["mesh", "narrow", "--scene", "slop"], "slope"),
    ],
)
def test_what_is_nearly_typed_is_named(typed, meant, terminal):
    reported = terminal(*typed, code=2).err
    assert meant in reported.lower().split("mean")[-1]


@pytest.mark.parametrize(
    ("words", "completed"),
    [
        ("fingerdesign opt", {"optimise"}),
        ("fingerdesign check sl", {"slope"}),
        ("fingerdesign sweep fin", {"fingers"}),
        ("fingerdesign analyse narrow --scene tw", {"twist"}),
        ("fingerdesign grip sensitive --controller reg", {"regulator"}),
        ("fingerdesign list ma", {"materials"}),
    ],
)
def test_shells_complete_commands_and_shipped_names(words, completed):
    program, *before, typed = words.split()
    complete = BashComplete(cli, {}, program, "_FINGERDESIGN_COMPLETE")
    found = complete.get_completions(before, typed)
    assert {each.value for each in found if each.type == "plain"} == completed


def test_every_list_fits_80_columns_and_is_there_for_scripts(terminal):
    assert set(terminal("list").out.split()) >= set(SHELVES)
    every = terminal("list", *SHELVES).out
    assert set(every.split()) >= {"silicone", "maeno2000", "slope", "stick_error"}
    assert max(map(len, every.splitlines())) <= 80
    shown = json.loads(terminal("list", "--json").out)
    assert tuple(shown) == SHELVES
    assert [each["name"] for each in shown["designs"]] == list(shipped_names())
    assert all(each["why"] for kind in ("designs", "scenes", "studies") for each in shown[kind])


@pytest.mark.parametrize("option", ["--study", "--scene", "--short"])
def test_each_new_file_passes_check(option, tmp_path, terminal):
    path = tmp_path / "mine.toml"
    terminal("new", path, option, "-q")
    assert "mine" in terminal("check", path).out
    if option == "--short":
        lines = [line.split(" = ") for line in path.read_text().splitlines()]
        assert len([line for line in lines if len(line) > 1 and line[0].isidentifier()]) == 15
    assert "give one" in terminal("new", tmp_path / "b.toml", "--study", "--short", code=2).err


def test_check_names_faults_of_studies_and_scenes_together(tmp_path, terminal):
    study, scene = tmp_path / "study.toml", tmp_path / "scene.toml"
    study.write_text(
        '[study]\nname = "s"\nbase = "maeno2000"\nsampling = "grid"\nscenes = ["slop"]\n'
        '[parameters]\n"plates.cuont" = [5]\n'
    )
    scene.write_text("[object]\nfriction_coefficient = -1\n[path]\nincrements_mm = []\n")
    reported = terminal("check", study, scene, "narrow", code=2).err
    for words in ("did you mean plates.count", "did you mean slope", "friction_coefficient"):
        assert words in reported
    (sound,) = json.loads(terminal("check", "fingers", "--json").out)
    assert (sound["kind"], sound["variants"], sound["sound"]) == ("study", 200, True)


def test_the_drawing_names_what_its_lines_do_not_show():
    own = "bent with the surface, every second one 2 aside, holes 0.6 every 2"
    assert own in " ".join(facts(load_design("boned")))


def test_a_long_name_takes_no_room_from_the_count():
    friction, stick = "friction μ 0.25 0.5 0.9", "smallest stick change seen 0.059"
    lifts = Verdict("pass", "lifts 150–400 g", friction, "no gross slip", "9 of 9 lifts")
    gages = Verdict("fail", "gage signal", stick, "target ≤ 0.10", "at 150 g")
    lines = _verdict_lines((lifts, gages))
    assert all(len(line) <= 80 and "..." not in line for line in lines)
    assert lines[0].endswith("no gross slip  9 of 9 lifts")


# The record that a command writes, as short as it can be.
FOLDERS = json.loads("""{
"identification.json": {"design": "a", "trace": "press.csv", "values": [{"name": "share_1",
"value": 0.1, "unit": "", "told": false}], "warnings": [], "next_motion": {"words": "hold still"}},
"mold_report.json": {"design": "a", "process": {"name": "sla"}, "failure": null, "checks":
[{"ok": false, "sentence": "a wall is too thin"}], "warnings": [], "placement": null, "parts": []},
"tuning.json": {"controllers": {"x": {"default": {"success_rate": 0.5}, "best":
{"success_rate": 0.4}}}, "design": "a"},
"training.json": {"noises_microstrain": [0.5], "stick_errors": [0.3],
"friction_utilisation_errors": [0.2], "samples": 3, "judged_fingers": 0},
"calibration.json": {"design": "a", "fidelity": "3d", "fit": {"before_microstrain": 20.0,
"after_microstrain": 0.8}, "latents": [{"determined": true}], "warnings": ["lean"], "dead_gages":
[3]},
"validate.json": {"design": "a", "scene": "s", "failure": null, "assumptions":
[{"title": "plane strain", "verdict": "drop", "advice": "use 3-D"}]},
"observability.json": {"design": "a", "noise_microstrain": 0.5, "stick_error": 0.3,
"target_stick_error": 0.05, "too_quiet": true, "worth_of_gages": 0.1, "gages_that_suffice": 2,
"gages": [1, 2, 3], "advice": "softer plates"},
"generate.json": {"name": "a", "variants": 3, "invalid": 1, "cad_failed": 0},
"paper.json": {"design": "a", "claims": [{"title": "t", "where": "4", "verdict": "no",
"measured": "0.2"}]},
"quality.json": {"mesher": "tetwild", "dimension": 3, "elements": 9, "dofs": 30,
"min_dihedral_deg": 1.0, "inverted_elements": 0, "body_volume_error": 1e-06, "remarks": []},
"control.json": {"criteria": {"good_amplifier_microstrain": 0.5}, "controllers":
[{"controller": "x", "by_noise": [{"noise_microstrain": 0.5, "success": {"rate": 0.2},
"dropped": 1, "crushed": 0, "not_lifted": 3, "margin_at_lift": null}]}], "design": "a", "model":
{"fidelity": "3d"}, "grips": 5, "warnings": []},
"unlike.json": {"plants": 3, "design": "a", "fidelity": "3d", "summaries": {"all": {"x":
{"success": {"rate": 0.2}}}}}
}""")
_HALF = {"count": 1, "of": 2, "rate": 0.5, "low": 0.1, "high": 0.9}
_SCORE = {"detector": "x", "ours": True, "note": "", "rank": 0.4, "early": None, "lead_s": None}
_SCORE |= dict.fromkeys(("right", "found", "false"), _HALF)
_SET = {"name": "b", "source": "", "published": "", "recordings": 2, "slips": 1, "unknown": 0}
_SETS = [_SET | {"scores": [_SCORE]}]
FOLDERS["recorded.json"] = {"folder": "a", "sets": _SETS, "friction": None, "unread": []}
FOLDERS["lesson.json"] = FOLDERS["training.json"] | {"used_errors": [0.2]}  # As once written.
del FOLDERS["lesson.json"]["friction_utilisation_errors"]


@pytest.mark.parametrize("record", FOLDERS)
def test_view_says_what_is_bad_in_each_kind_of_folder(record, tmp_path, terminal):
    folder = tmp_path / "out" / "a"
    folder.mkdir(parents=True)
    (folder / record).write_text(json.dumps(FOLDERS[record]))
    for place in (folder, folder.parent):
        shown = terminal("view", place).out
        assert "✗" in shown
        assert max(len(line) for line in shown.splitlines() if "report:" not in line) <= 80
        (data,) = json.loads(terminal("view", place, "--json").out)
        assert (data["record"], bool(data["bad"])) == (record, True)


@pytest.mark.parametrize(
    ("dimension", "angle", "inverted", "bad"),
    [(2, 1.0, 0, False), (2, 1.0, 3, True), (3, 1.0, 0, True), (3, 40.0, 3, True), (3, 40.0, 0, 0)],
)
def test_a_mesh_is_bad_by_its_angles_in_space_and_its_inverted_elements(
    dimension, angle, inverted, bad, tmp_path, terminal
):
    own = {"dimension": dimension, "min_dihedral_deg": angle, "inverted_elements": inverted}
    (tmp_path / "quality.json").write_text(json.dumps(FOLDERS["quality.json"] | own))
    (data,) = json.loads(terminal("view", tmp_path, "--json").out)
    assert bool(data["bad"]) == bool(bad)


def test_a_record_that_holds_nothing_is_refused(tmp_path, terminal):
    (tmp_path / "unlike.json").write_text(json.dumps(FOLDERS["unlike.json"] | {"summaries": {}}))
    assert "run its command again" in terminal("view", tmp_path, code=2).err


@pytest.mark.parametrize(
    "record", ["finger.xml", "finger.urdf", "regulator.c", "regulator.fmu", "plant.fmu"]
)
def test_view_names_the_files_of_an_export(record, tmp_path, terminal):
    for name in (record, "with.stl"):
        (tmp_path / name).write_bytes(b"\xff")
    (data,) = json.loads(terminal("view", tmp_path, "--json").out)
    assert data["what"].endswith(f"of {tmp_path.name}, by export")
    assert data["facts"] == [f"files: {', '.join(sorted((record, 'with.stl')))}"]


@pytest.mark.parametrize("name", ["maeno2000", "both_ways"])
def test_a_sketch_names_its_dimensions(name, tmp_path, terminal):
    terminal("view", name, "--out", tmp_path)
    assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    svg = (tmp_path / f"{name}.svg").read_text("utf-8")
    assert svg.startswith("<svg ")
    assert all(words in svg for words in ("width ", "depth ", "crest ", "cover "))


def test_an_enlarged_plate_carries_its_gages_between_whole_neighbours():
    design = load_design("film_tees")
    shapes = list(enlarged_shapes(design, plate_rows(design)[0]))
    by_look = {look: [each for each in shapes if each.look == look] for look in ("other", "gage")}
    (body,) = (each.points for each in shapes if each.look == "body")
    for each in by_look["other"]:
        assert (body.min(axis=0) < each.points.min(axis=0)).all()
        assert (each.points.max(axis=0) < body.max(axis=0)).all()
    assert len(by_look["other"]) == 2
    upper, lower = (each.points for each in by_look["gage"])
    between = float(np.linalg.norm(upper - lower, axis=1).max())
    assert between == pytest.approx(design.plates.thickness_mm, abs=0.02)


def test_a_former_name_works_and_reports_the_new_one(tmp_path, terminal):
    shown = terminal("sketch", "homogeneous", "--out", tmp_path)
    assert shown.err == "`sketch` is now `fingerdesign view`\n"
    svg = (tmp_path / "homogeneous.svg").read_text("utf-8")
    assert "width " in svg
    assert "cover " not in svg
    help_text = terminal("--help").out
    assert "  sketch " not in help_text
    order = ("Design:", "Analyse:", "Choose:", "Cast:", "Control:", "Reference:")
    places = [help_text.index(heading) for heading in order]
    assert places == sorted(places)


def test_the_help_of_grip_says_how_long_a_training_takes(terminal):
    assert "is trained first: up to half an hour" in " ".join(
        terminal("grip", "--help").out.split()
    )
