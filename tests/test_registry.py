"""A kind from outside the package is one file and one registration: TOML and commands know it."""

import json
import math
import tomllib

import jsonschema
import pytest

from fingerdesign.errors import DesignError
from fingerdesign.runtime.references import allow_code, referred
from fingerdesign.runtime.registry import BODIES, CONTROLLERS, MESHERS, PLATE_LAYOUTS, SCENE_OBJECTS
from tests.support.plugins import installed

DESIGN = """
design.name = "toy"
[plates]
count = 5
[grip]
defaults = "fixed"
controller = "steady"
friction_coefficients = [0.8]
object_mass_g = 100.0
max_steps = 60
[grip.steady]
pull_mm = 0.004
[mesh]
mesher = "slices"
contact_size_mm = 1.0
plate_size_mm = 1.0
slices.number = 2
[mesh.section]
contact_size_mm = 0.2
plate_size_mm = 0.2
plate_end_size_mm = 0.1
"""
SCENE = """
[object]
shape = "bar"
bar_mm = 16.0
[path]
increments_mm = [[0.05, 0.0], [0.1, 0.0], [0.1, 0.02]]
"""
STUDY = """
[study]
name = "toys"
base = "toy.toml"
sampling = "grid"
[parameters]
"grip.steady.pull_mm" = [0.004]
"""
TAKING = """
from fingerdesign.runtime.registry import MESHERS, Kind
MESHERS.add(Kind(name="tetwild"))
"""
KNOWN = SCENE.replace('"bar"', '"cylinder"').replace("bar_mm = 16.0", "radius_mm = 8.0")


@pytest.fixture(scope="module")
def command(tmp_path_factory):
    """Runs commands where a package with the toys is installed: exit code, what they wrote."""
    folder = tmp_path_factory.mktemp("toys")
    (folder / "toy.toml").write_text(DESIGN)
    (folder / "bar.toml").write_text(SCENE)
    (folder / "cylinder.toml").write_text(KNOWN)
    with installed(folder, "toys = tests.support.toy_kinds") as worker:

        def run(*arguments):
            return worker.call("tests.support.calls:command", arguments, time_s=120.0)

        def pressed(scene):
            files = folder / "toy.toml", folder / scene
            return worker.call("tests.support.calls:increments", *files, time_s=120.0)

        def gripped(design):
            return worker.call("tests.support.calls:grips", folder / design, time_s=120.0)

        run.folder, run.pressed, run.gripped, run.worker = folder, pressed, gripped, worker
        yield run


@pytest.mark.slow
def test_files_of_a_plug_in_are_checked_its_object_pressed_and_its_controller_grips(command):
    code, written = command("check", "toy.toml", "--scene", "bar.toml")
    assert code == 0, written
    bar, cylinder = (command.pressed(f"{name}.toml") for name in ("bar", "cylinder"))
    assert bar == cylinder  # the same object under another name
    assert bar[-1].normal_force_N > 0.1
    (grip,) = command.gripped("toy.toml")
    assert (grip.controller, grip.lifted) == ("steady", True)


@pytest.mark.slow
def test_variants_of_a_study_are_computed_in_processes_that_know_the_plug_in(command):
    (command.folder / "study.toml").write_text(STUDY)
    code, written = command("sweep", "study.toml", "--out", "swept", "--workers", "1", "--json")
    assert code == 0, written
    assert '"status": "ok"' in written
    (command.folder / "study.toml").write_text(f"{STUDY}# of another day\n")
    _, written = command("sweep", "study.toml", "--out", "swept", "--workers", "1")
    assert "is of another study.toml, and is replaced" in written
    assert (
        "is replaced" not in command("sweep", "study.toml", "--out", "swept", "--workers", "1")[1]
    )


def test_what_is_sent_to_another_process_stays_what_it_is(command):
    files = command.folder / "toy.toml", command.folder / "bar.toml"
    here, there = command.worker.call("tests.support.calls:digests", *files, time_s=120.0)
    assert here == there


def test_a_mesher_of_a_plug_in_meshes(command):
    code, written = command("mesh", "toy.toml", "--out", "mesh", "--json", "--no-picture")
    assert code == 0, written
    assert '"mesher": "slices"' in written


def test_a_body_and_a_plate_layout_of_a_plug_in_are_meshed(command):
    sections = []
    for name, shape, follow in (("ours", "block", "level"), ("theirs", "slab", "fanned")):
        keys = f"body.shape = '{shape}'\nplates.count = 1\nplates.follow = '{follow}'\n"
        (command.folder / f"{name}.toml").write_text(f"design.name = '{name}'\n{keys}")
        words = ("--fidelity", "plane-strain", "--out", name, "--no-picture", "--quiet")
        code, written = command("mesh", f"{name}.toml", *words)
        assert code == 0, written
        report = json.loads((command.folder / name / "quality.json").read_text("utf-8"))
        sections.append({key: report[key] for key in ("elements", "volumes", "nodes")})
    assert sections[0] == sections[1]  # one plate, in the middle, is turned by nothing


@pytest.mark.parametrize(
    ("line", "fault", "remedy"),
    [
        ("body.shape = 'slap'", "body.shape = 'slap'", "did you mean 'slab'?"),
        ("body.shape = 'arc'\nbody.rise_mm = 1", "body.rise_mm = 1", "remove it"),
        ("plates.follow = 'faned'", "plates.follow = 'faned'", "did you mean 'fanned'?"),
        ("grip.controller = 'steddy'", "grip.controller = 'steddy'", "did you mean 'steady'?"),
        ("grip.steady.pull = 1", "grip.steady.pull", "did you mean grip.steady.pull_mm?"),
        ("grip.steady.pull_mm = 2", "grip.steady.pull_mm = 2", "decrease it"),
        ("grip.stedy.pull_mm = 2", "grip.stedy", "did you mean grip.steady?"),
        ("mesh.mesher = 'slice'", "mesh.mesher = 'slice'", "did you mean 'slices'?"),
        ("body.shape = 'revolved'\nmesh.mesher = 'slices'", "mesh.mesher", "'tetwild'"),
    ],
)
def test_what_no_plug_in_knows_is_refused_with_the_nearest(command, line, fault, remedy):
    (command.folder / "wrong.toml").write_text(f"design.name = 'wrong'\nplates.count = 0\n{line}\n")
    code, written = command("check", "wrong.toml")
    assert code == 2
    assert fault in written
    assert remedy in written


@pytest.mark.parametrize(
    ("scene", "remedy"),
    [
        (SCENE.replace('"bar"', '"baar"'), "did you mean 'bar'?"),
        (SCENE.replace("16.0", "16.0\nradius_mm = 3"), "object.radius_mm = 3"),
        (KNOWN.replace("radius_mm = 8.0", "radius_mm = 8.0\nbar_mm = 3.0"), "left out for a cyl"),
        (SCENE.replace("16.0", "-1.0"), "object.bar_mm"),
    ],
)
def test_keys_of_another_object_are_refused(command, scene, remedy):
    (command.folder / "wrong_scene.toml").write_text(scene)
    code, written = command("check", "toy.toml", "--scene", "wrong_scene.toml")
    assert code == 2
    assert remedy in written


def test_new_files_and_their_schemas_tell_of_plug_ins(command):
    for scene, name in ((("--all",), "a.toml"), (("--scene",), "b.toml")):
        assert command("new", name, *scene, "--force")[0] == 0
    design, scene = ((command.folder / name).read_text("utf-8") for name in ("a.toml", "b.toml"))
    assert "# [grip.steady] " in design
    unwrapped = " ".join(design.replace("\n# ", " ").split())
    assert "of plug-ins: steady" in unwrapped
    assert "of plug-ins: slices" in unwrapped
    used = scene.replace('"plane"', '"bar"').replace("# bar_mm", "bar_mm")
    for kind, text in (("design", DESIGN), ("scene", used)):
        schema = json.loads((command.folder / f"{kind}.schema.json").read_text("utf-8"))
        jsonschema.validate(tomllib.loads(text), schema)


@pytest.mark.slow
def test_a_plug_in_that_cannot_be_loaded_is_one_sentence(tmp_path):
    (tmp_path / "taking.py").write_text(TAKING)
    (tmp_path / "leaving.py").write_text("raise SystemExit(0)\n")
    points = "gone = not_there\nleaving = leaving\ntaking = taking"
    check = "tests.support.calls:command", ("check", "sensitive")
    with installed(tmp_path, points) as worker:
        first, again = (worker.call(*check, time_s=120.0) for _ in range(2))
    *lines, rest = first[1].split("\n", 3)
    for line, name, why in zip(
        lines,
        ("gone", "leaving", "taking"),
        ("ModuleNotFoundError", "SystemExit: 0", "already is a mesher called 'tetwild'"),
        strict=True,
    ):
        assert line.startswith(f"the plug-in {name} (")
        assert why in line
    assert (first[0], again) == (0, (0, rest))


@pytest.mark.parametrize("registry", [CONTROLLERS, SCENE_OBJECTS, BODIES, PLATE_LAYOUTS, MESHERS])
def test_names_that_are_listed_are_those_that_register(registry):
    listed = registry.shipped_names()
    loaded = tuple(kind.name for kind in registry.kinds())
    assert loaded == listed == registry.names()
    assert registry.find(listed[0], "key").name == listed[0]
    with pytest.raises(DesignError, match=f"did you mean {listed[0]}"):
        registry.find(listed[0][:-1], "key")


@pytest.mark.usefixtures("nothing_allowed")
def test_permissions_add_up():
    """Each of two references may be followed; a third one, and all of a module, may not."""
    allow_code("math:pi")
    allow_code("math:e")
    assert (referred("math:pi", "a.b"), referred("math:e", "a.b")) == (math.pi, math.e)
    with pytest.raises(DesignError, match="--allow-code"):
        referred("math:tau", "a.b")
