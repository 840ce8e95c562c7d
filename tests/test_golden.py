"""What commands print and write, against records in ``tests/golden`` (tests/support/golden.py).

A record finds that something changed, not that it is right: what is right is tested elsewhere, of
one idea each. Fingers are shipped ones on coarse meshes, so that all their features are drawn,
checked, solved and shown. Other tests, which make a folder anyway, compare theirs by ``golden``.
"""

import contextlib
import json
from dataclasses import fields, is_dataclass

import pytest
import tomlkit
from cadquery import Workplane, exporters
from fingerdesign_cli.main import main

from fingerdesign import load_design
from fingerdesign.checks.load import with_values
from fingerdesign.design.shipped import file_text
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.plan.refusals import MoldRefused
from fingerdesign.mold.plan.remedies import remedied
from tests.support.any_outcomes import any_outcomes

COARSE = {
    **{"mesher": "sweep", "layers": 2, "contact_size_mm": 1.0, "plate_size_mm": 1.5},
    **{"far_size_mm": 5.0, "gradation": 0.9},
}
SECTION = {
    **{"contact_size_mm": 0.25, "plate_size_mm": 0.3, "plate_end_size_mm": 0.12},
    **{"far_size_mm": 2.5, "gradation": 0.6},
}
STRAIGHT = ("block", "feeler", "homogeneous", "maeno2000", "narrow", "tees", "wide")
OTHER = ("boned", "domed", "both_ways", "film_rows", "pin")
WRONG = {
    "keys.toml": "[body]\nwidht_mm = 3.0\narc_radius_mm = 2.0\n[plates]\ncount = 99\n",
    "torn.toml": "[body\n",
    "gages.toml": '[design]\nname = "gages"\n[gages]\nlength_mm = 3.0\nz_mm = 9.0\n'
    'kind = "none such"\n[plates]\nlength_mm = 2.0\ncover_mm = 0.1\n',
    "mold.toml": '[design]\nname = "mold"\n[mold]\nwire_mm = 3.0\nwall_mm = 0.1\nbase_mm = 0.2\n'
    "[mold.comb]\nslot_mm = 0.01\n",
    "grip.toml": '[design]\nname = "grip"\n[grip]\nobject_mass_g = 90000.0\n'
    "friction_coefficients = [0.001, 3.0]\n[grip.hardware]\ndead_gages = [1, 2, 77]\n",
    "scene.toml": '[object]\nshape = "cylinder"\nradius_mm = -1.0\n[path]\nincrements_mm = []\n',
}
LAWS = {
    "capped": "shear_limit_MPa = 0.05",
    "shear_strength": 'shear_strength_MPa = 0.03\nshape = "cylinder"\nradius_mm = 40.0',
    "power": "friction_exponent = 0.3\nreference_pressure_MPa = 0.1\ntilt_deg = 2.0",
}


def coarse(name, folder, **tables):
    """A shipped finger on a coarse mesh, with keys changed; the name of its file."""
    design = tomlkit.parse(file_text(name))
    design["design"]["name"] = f"g_{name}"
    if name in STRAIGHT:
        design["mesh"] = {**COARSE, "section": SECTION}
    for table, values in tables.items():
        design.setdefault(table, {}).update(values)
    path = folder / f"{name}.toml"
    path.write_text(tomlkit.dumps(design), "utf-8")
    return path.name


def plain(thing):
    """Of objects their fields, down to numbers, texts and lists."""
    if is_dataclass(thing) and not isinstance(thing, type):
        return {each.name: plain(getattr(thing, each.name)) for each in fields(thing)}
    if isinstance(thing, dict):
        return {str(key): plain(each) for key, each in thing.items()}
    return [plain(each) for each in thing] if isinstance(thing, list | tuple) else thing


@pytest.fixture
def calls(tmp_path, in_tmp_path, capsys):
    """``calls(line, ...)``: run command lines in the test's folder; what they printed."""

    def run(*lines):
        texts = []
        for line in lines:
            code = main(line.split())
            out, err = capsys.readouterr()
            with contextlib.suppress(ValueError):
                out = json.loads(out)
            texts += [f"$ {line}: exit code {code}", out, err]
        return texts

    return run


def test_lists(golden, calls):
    lists = ("designs", "scenes", "studies", "materials", "metrics", "controllers", "atlas")
    golden("lists", *calls(*(f"list {each}" for each in lists), "list gages", "list gages --json"))


@pytest.mark.slow
def test_checks(golden, calls, tmp_path):
    names = [coarse(each, tmp_path) for each in (*STRAIGHT, *OTHER)]
    lines = [f"check {each} {more}" for each in names for more in ("--details", "--scene edge")]
    golden("checks", *calls(*lines, f"check {' '.join(names)} --json"))


def test_refusals(golden, calls, tmp_path):
    for name, text in WRONG.items():
        (tmp_path / name).write_text(text, "utf-8")
    (tmp_path / "study.toml").write_text(
        '[study]\nname = "few"\nbase = "maeno2000"\ncount = 0\n[parameters]\n"body.ark" = [1]\n'
        '"plates.count" = { low = 9, high = 3 }\n[[objectives]]\nmetric = "coast"\n'
    )
    every = [f"check {each}" for each in WRONG if each != "scene.toml"]
    shown = calls(
        *every,
        "check keys.toml gages.toml grip.toml --json",
        "check maeno2000 --scene scene.toml",
        "sweep study.toml --out out",
        "grip maeno2000 --out out --controller papre",
        "analyse maeno2001 --out out",
        "compare . --out out.html",
        "identify maeno2000 keys.toml --out out",
    )
    golden("refusals", *shown)


def test_starters(golden, calls, tmp_path):
    shown = calls(
        "new mine.toml",
        "new whole.toml --all",
        "new short.toml --short",
        "new heavy.toml --lift 500g --gages film",
        "new ball.toml --scene --from ball",
        "new some.toml --study",
        "view mine.toml --out out",
        "check mine.toml short.toml heavy.toml whole.toml --json",
    )
    golden("starters", *shown, tmp_path)


@pytest.mark.parametrize("name", ["boned", "both_ways", "film_rows"])
def test_drawings(golden, calls, tmp_path, name):
    golden(f"drawing_{name}", *calls(f"view {coarse(name, tmp_path)} --out out --json"), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["feeler", "homogeneous", "tees"])
def test_plane_strain(golden, calls, tmp_path, name):
    page = "--page" if name in ("feeler", "homogeneous") else "--no-page"
    line = f"analyse {coarse(name, tmp_path)} --fidelity plane-strain --out out --details {page}"
    golden(f"plane_strain_{name}", *calls(line, f"view out/g_{name} --json"), tmp_path / "out")


@pytest.mark.slow
def test_three_dimensions(golden, calls, tmp_path):
    """A whole finger, not half of one: its gages are off the middle."""
    tables = {"gages": {"face": "lower", "z_mm": 1.0}, "grip": {"friction_coefficients": [0.3]}}
    path = coarse("tees", tmp_path, plates={"count": 3, "span_mm": 6.0}, **tables)
    shown = calls(f"analyse {path} --out out --no-cad", "view out/g_tees --details")
    golden("space", *shown, tmp_path / "out")


@pytest.mark.slow
def test_scenes(golden, calls, tmp_path):
    path = coarse("tees", tmp_path, plates={"count": 5}, gages={"face": "upper"})
    scenes = ("ball", "pull", "slope")
    lines = [f"analyse {path} --scene {s} --fidelity plane-strain --out {s}" for s in scenes]
    folders = [tmp_path / each for each in scenes if each != "ball"]
    golden("scenes", *calls(*lines), *folders)


@pytest.mark.slow
def test_laws_of_friction(golden, calls, tmp_path):
    path = coarse("tees", tmp_path, plates={"count": 5}, gages={"face": "lower"})
    rows = "[path]\nincrements_mm = [[0.1, 0.0], [0.1, 0.05], [0.15, 0.02]]\n"
    points = "[readout]\npoints_mm = [[0.5, 6.0, 0.0]]\n"
    for law, keys in LAWS.items():
        text = f'[object]\nfriction_law = "{law}"\n{keys}\n{rows}{points}'
        (tmp_path / f"{law}.toml").write_text(text, "utf-8")
    each = "--fidelity plane-strain --out"
    lines = [f"analyse {path} --scene {law}.toml {each} {law}" for law in LAWS]
    golden("laws", *calls(*lines), *(tmp_path / law / "g_tees" / "history.csv" for law in LAWS))


@pytest.mark.slow
def test_a_body_and_a_mesh_of_another_program(golden, calls, tmp_path):
    box = Workplane("XY").box(16.0, 12.0, 10.0).faces(">Y").edges("|Z").fillet(3.0)
    exporters.export(box, str(tmp_path / "own.step"))
    step = coarse("block", tmp_path, plates={"count": 3, "cover_mm": 3.0})
    text = (tmp_path / step).read_text("utf-8")
    body = text[text.index("[body]") : text.index("[plates]")]
    own = '[body]\nshape = "step"\nstep = { file = "own.step" }\nmaterial = "silicone"\n\n'
    (tmp_path / "own.toml").write_text(text[: text.index("[mesh]")].replace(body, own), "utf-8")
    given = {"mesher": "file", "file": "cells/mesh.msh"}
    shown = calls(
        "check own.toml --details",
        "view own.toml --out out",
        f"mesh {step} --out cells --format msh --scene pull --no-picture",
    )
    again = coarse("block", tmp_path, plates={"count": 3, "cover_mm": 3.0}, mesh=given)
    line = f"analyse {again} --scene pull --out read --no-cad --no-page"
    golden("other_programs", *shown, *calls(f"check {again} --details", line), tmp_path / "out")


@pytest.mark.slow
def test_grips(golden, calls, tmp_path):
    hardware = {
        **{"gage_noise_microstrain": 0.5, "delay_samples": 2, "backlash_mm": 0.01},
        **{"gain_spread": 0.05, "force_noise_N": 0.02, "stage_step_mm": 0.001, "dead_gages": [3]},
        **{"drift_microstrain_per_s": 0.5, "gage_cross_talk": 0.02, "actuator_lag_s": 0.02},
    }
    grip = {
        **{"hardware": hardware, "hold_steps": 20, "rubber_memory": [[0.1, 0.5]], "plant": "lift"},
        **{"kinetic_share": 0.8, "warming_K": 5.0, "inertia": True, "off_centre_mm": 0.0},
        "tugs": [{"step_after_lift": 4, "extra_force_N": 1.0, "duration_steps": 3}],
        "weight_changes": [{"step_after_lift": 10, "object_mass_g": 600.0}],
    }
    path = coarse("feeler", tmp_path, grip=grip)
    controllers = ("paper", "fixed_force", "fixed_ratio", "reactive", "oracle_1.2")
    lines = [f"grip {path} --controller {c} --out {c} --friction 0.4" for c in controllers]
    golden("grips", *calls(*lines), *(tmp_path / each for each in controllers))


@pytest.mark.slow
def test_meshes(golden, calls, tmp_path):
    solid = coarse("block", tmp_path, plates={"count": 3})
    formats = "--format vtu --format msh --format inp --format mdpa --no-picture"
    flat = f"mesh {coarse('maeno2000', tmp_path)} --fidelity plane-strain --out flat {formats}"
    shown = calls(flat, f"mesh {solid} --out solid {formats} --json")
    golden("meshes", *shown, tmp_path / "flat", tmp_path / "solid")


def test_comparisons(golden, calls, tmp_path):
    made = any_outcomes(7, seed=3, failed=0.3, deep=True)
    lines = "".join(each.to_json() + "\n" for each in made)
    (tmp_path / "few").mkdir()
    (tmp_path / "few" / "outcomes.jsonl").write_text(lines, "utf-8")
    shown = calls("compare few --out c.html --csv c.csv", "compare few --out c.html --json")
    golden("comparisons", *shown, tmp_path / "c.html", tmp_path / "c.csv")


@pytest.mark.slow
def test_assumptions(golden, calls, tmp_path):
    path = coarse("maeno2000", tmp_path, plates={"count": 5})
    names = ("gage_point", "relaxation")
    only = " ".join(f"--only {each}" for each in names)
    *_, data, _ = calls(f"validate {path} --out out {only} --json")
    data["assumptions"] = sorted(data["assumptions"], key=lambda each: each["assumption"])
    golden("assumptions", data)


@pytest.mark.parametrize("name", ["feeler", "boned", "domed", "pin"])
@pytest.mark.parametrize("process", ["fdm", "machined"])
def test_plans_of_molds(golden, name, process):
    design = with_values(load_design(name), {"mold.process": process})
    try:
        found = plan_mold(design)
    except MoldRefused as refused:
        found = remedied(design, refused)
    plan = vars(found) if isinstance(found, MoldPlan) else {"refused": str(found)}
    parts = {key: each for key, each in plan.items() if key != "design"}
    golden(f"mold_{name}_{process}", plain(parts))


@pytest.mark.slow
def test_tolerances(golden, calls, tmp_path):
    path = coarse("tees", tmp_path, plates={"count": 5})
    golden("tolerances", *calls(f"tolerance {path} --out out"), tmp_path / "out")


@pytest.mark.slow
def test_robots(golden, calls, tmp_path):
    path = coarse("block", tmp_path, plates={"count": 3}, gages={"z_mm": 1.5, "face": "upper"})
    lines = [f"export {path} --to {each} --out {each}" for each in ("mjcf", "urdf")]
    golden("robots", *calls(*lines), tmp_path / "mjcf", tmp_path / "urdf")
