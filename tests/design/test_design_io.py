"""Files in and out: every fault at once, readable; nothing crashes; what is written reads back."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fingerdesign.checks.load import judge_data, load_design, parse_design, with_values
from fingerdesign.design.faults import known_keys
from fingerdesign.design.io import dump_design, parse_scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import kind_of, load_scene
from fingerdesign.errors import DesignError, FormerKeyWarning
from fingerdesign.runtime.registry import allow_code
from tests.support.faults import faults_of as faults

NAME = 'design.name = "a"\n'


def test_every_fault_of_the_keys_at_once():
    found = faults(
        'design.name = "a/b"\nfoo = 1\n[body]\narc_radius_mm = 9\n'
        "[gages]\nlength_mm = 3\n[plates]\nsppan_mm = 3\n[mesh]\nlayers = 0\n[grip]\nseed = 0.5\n"
    )
    assert set(found) == {"design.name", "foo", "plates.sppan_mm", "mesh.layers", "grip.seed"}


def test_every_fault_of_the_geometry_at_once():
    found = faults(
        'design.name = "a"\nassumed = ["body.with_mm"]\nbody.arc_radius_mm = 9\n'
        "gages.length_mm = 3\nmesh.section.contact_size_mm = 3\ngrip.preload_mm = 5\n"
        "plates.thickness_mm = 1\nplates.length_mm = 2.5"
    )
    keys = {"assumed[0]", "body.arc_radius_mm", "gages.length_mm", "mesh.section.contact_size_mm"}
    assert set(found) == keys | {"grip.preload_mm", "plates.length_mm"}
    placed = "plates.pitch_mm = 0.05\nplates.span_mm = 9.9\nbody.core.width_mm = 19.9"
    assert set(faults(NAME + placed)) == {"body.core.width_mm", "plates.pitch_mm", "plates.span_mm"}


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ("body = {arc_radius_mm = 9, width_mm = -1}\nplates.count = 3", "body.width_mm"),
        ("plates.cover_mm = 12\nplates.count = -1", "plates.count"),
        ('body.material = "steel"\nplates.material = "wood"', "body.material plates.material"),
        ("body.widht_mm = 3\nplates.pitch_mm = 0.05", "body.widht_mm"),
        # A rule between tables is checked although a value in one is faulty.
        ('body.width_mm = -1\nbody.material = "steel"', "body.width_mm body.material"),
        (
            'body.width_mm = -1\ngages.kind = "gauge"\nmold = {gage = "no", process = "no"}',
            "body.width_mm gages.kind mold.process mold.gage",
        ),
        # Every rule of a table whose values are sound.
        (
            'body = {shape = "block", edge = "chamfer", arc_radius_mm = 15, dome_radius_mm = 20}',
            "body.edge body.arc_radius_mm body.dome_radius_mm",
        ),
        (
            'plates = {placement = [[0, 8, 45]], along = "z", offset_mm = 1, hole_pitch_mm = 3}',
            "plates.along plates.offset_mm plates.hole_pitch_mm",
        ),
        ('body.shape = "dome"\nbody.dome_radus_mm = 25', "body.dome_radus_mm"),
        ('body.shape = "dome"\nbody.dome_radius_mm = -25', "body.dome_radius_mm"),
        ('body.shape = "dom"\nbody.dome_radius_mm = 25', "body.shape"),
        (
            'body.material = "mine"\nmaterials.mine.poissons_ratio = 0.3\nplates.cover_mm = 12',
            "materials.mine.youngs_modulus_MPa",
        ),
        ("body = 3\nplates.length_mm = 0.3\ngages.length_mm = 0.2", "body"),
        ("plates.placement = 5\ngages.width_mm = 30", "plates.placement"),
        ("grip.friction_coefficients = [0.0]", "grip.friction_coefficients[0]"),
        ("mesh.far_size_mm = -1\nmesh.contact_size_mm = 40", "mesh.far_size_mm"),
    ],
)
def test_faulty_keys_come_before_the_geometry(lines, expected):
    assert set(faults(NAME + lines)) == set(expected.split())


PLACED = NAME + "plates.placement = [[-1.0, 10.5, 45.0], [1.0, 10.5, 45.0]]\n"


@pytest.mark.parametrize(
    ("line", "key", "nearest"),
    [
        ("body.widht_mm = 3", "body.widht_mm", "body.width_mm"),
        ("body.pitch_mm = 3", "body.pitch_mm", "plates.pitch_mm"),
        ("body.materials = 3", "body.materials", "body.material?"),
        ("plate.count = 3", "plate", "plates"),
        ("mesh.section.contact_size = 3", "mesh.section.contact_size", "contact_size_mm"),
        ("materials.silicone.poisson = 3", "materials.silicone.poisson", "poissons_ratio"),
    ],
)
def test_unknown_key_names_the_nearest(line, key, nearest):
    assert nearest in faults(NAME + line)[key].remedy


def test_a_dotted_key_in_a_table_names_its_own_table():
    with pytest.raises(DesignError, match=r"put `material` under \[plates\]"):
        parse_design('design.name = "a"\n[gages]\nface = "upper"\nplates.material = "abs"')
    with pytest.raises(DesignError, match=r"put `material`, `count` under \[plates\]"):
        parse_design('design.name = "a"\n[gages]\nplates.material = "abs"\nplates.count = 3')
    with pytest.raises(DesignError, match=r"`plates.` under \[plates\]"):
        parse_design('plates.material = "abs"\n[plates]\ncount = 3')


def test_assumed_keys_exist_and_stand_before_the_first_table():
    found = faults('[design]\nname = "a"\nassumed = ["body.width_mm"]')
    assert "before the first [table]" in found["design.assumed"].remedy
    found = faults('assumed = ["body.width_mm", "body.widht_mm"]\n' + NAME)
    assert found["assumed[1]"].remedy == "did you mean 'body.width_mm'?"
    assert len(found) == 1


def test_what_is_no_toml_is_a_fault():
    nested, long = "a = " + "[" * 3000 + "]" * 3000, f"a = 1{'0' * 5000}"
    for text in ("x =", "[design", "a = 1\na = 2", long, nested, "a = 2024-13-45", "\x00"):
        assert "file" in faults(text)
    comma = faults("[body]\nwidth_mm = 20,0")["file"]
    assert comma.value == "line 2: width_mm = 20,0"
    assert "a point, not a comma" in comma.remedy


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("".join(f"k{i} = 1\n" for i in range(5001)), "5001 keys or more"),
        ("[[plates.rows]]\ncount = 1\n" * 5000, "5002 keys or more"),
        (f"{'a.' * 300}b = 1", "21 deep or more"),
        (f"[{'a.' * 300}b]", "21 deep or more"),
        ("a = " + "[" * 30 + "]" * 30, "21 deep or more"),
    ],
    ids=["keys", "tables", "dotted", "header", "arrays"],
)
def test_hostile_files_are_refused_before_anything_looks_at_them(text, value, tmp_path):
    assert faults(text)["file"].value == value
    file = tmp_path / "a.toml"
    file.write_text(text)
    assert kind_of(file) == "design"
    with pytest.raises(DesignError, match="at most 5000 keys, 20 tables or arrays deep"):
        parse_scene(text)


def test_files_that_can_and_cannot_be_read(tmp_path):
    binary, windows = tmp_path / "b.toml", tmp_path / "w.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    windows.write_bytes(b'\xef\xbb\xbf[design]\r\nname = "a"\r\n')
    assert load_design(windows).design.name == "a"
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(DesignError, match="ordinary file"):
        load_design(tmp_path / "pipe")
    for path in (tmp_path / "absent.toml", tmp_path, binary):
        for load in (load_design, load_scene):
            with pytest.raises(DesignError, match="readable TOML file"):
                load(path)


def test_with_values_is_checked_like_a_file():
    design = parse_design(NAME)
    assert with_values(design, {"plates.count": 3, "plates.span_mm": 8.0}).plates.count == 3
    assert with_values(design, {"plates.span_mm": None}) == design
    with pytest.raises(DesignError, match=r"plates\.cuont"):
        with_values(design, {"plates.cuont": 3})
    with pytest.raises(DesignError, match="arc_radius"):
        with_values(design, {"body.arc_radius_mm": 9.0})
    with pytest.raises(DesignError, match="is a value"):
        with_values(design, {"plates.count.x": 3})
    numbers = {"plates.count": np.int64(3), "plates.offset_mm": np.float64(0.1)}
    arrays = {"grip.friction_coefficients": np.array([0.3, 0.5]), "mesh.file": Path("none.msh")}
    assert with_values(design, numbers).plates.count == 3
    with pytest.raises(DesignError, match=r"^a: mesh\.file = .*none\.msh"):
        with_values(design, arrays)
    for wrong in (np.ma.masked, np.timedelta64(2, "ns")):
        with pytest.raises(DesignError, match="cover_mm"):
            with_values(design, {"plates.cover_mm": wrong})
    rows = with_values(design, {"plates.rows": [{"count": np.int64(3), "cover_mm": 4.0}]})
    assert rows.plates.rows[0].count == 3
    del arrays["mesh.file"]
    assert with_values(design, arrays).grip.friction_coefficients == (0.3, 0.5)
    softer = with_values(design, {"materials.silicone.youngs_modulus_MPa": 1.0})
    assert "Maeno" not in softer.material_of("body").source


NAMES = st.from_regex(r"[A-Za-z0-9_-]{1,20}", fullmatch=True)
SOUND = st.fixed_dictionaries(
    {
        "design": st.fixed_dictionaries({"name": NAMES}),
        "plates": st.fixed_dictionaries(
            {
                "count": st.integers(0, 9),
                "angle_deg": st.floats(20, 160),
                "length_mm": st.floats(1, 2),
                "cover_mm": st.floats(2, 4),
            }
        ),
        "gages": st.fixed_dictionaries({"length_mm": st.floats(0.1, 1), "z_mm": st.floats(-4, 4)}),
        "grip": st.fixed_dictionaries(
            {"friction_coefficients": st.lists(st.floats(0.01, 5), min_size=1, max_size=4)}
        ),
    }
)  # fmt: skip


@pytest.mark.slow
@settings(max_examples=15, derandomize=True, deadline=None)
@given(SOUND)
def test_what_is_written_reads_back(values):
    design = judge_data(values).sound("")
    again = parse_design(dump_design(design))
    assert again == design
    assert again.digest() == design.digest()


ANY = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**400), 10**400)
    | st.floats()
    | st.text(max_size=8)
    | st.dates(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner),
    max_leaves=6,
)

KEYS = [*known_keys(Design), "plates", "materials", "materials.x.source"]


@pytest.mark.slow
@settings(max_examples=150, derandomize=True, deadline=None)
@given(st.dictionaries(st.sampled_from(KEYS), ANY, min_size=1, max_size=4))
@example({"plates.alternate": None})
def test_no_value_of_any_kind_crashes(values):
    """Whatever stands in a file, it is a design or a list of one-line faults."""

    data = {"design": {"name": "a"}}
    for key, value in values.items():
        *tables, last = key.split(".")
        table = data
        for name in tables:
            inner = table.get(name)
            table[name] = table = inner if isinstance(inner, dict) else {}
        table[last] = value
    found = judge_data(data)
    assert (found.value is None) <= bool(found.faults)
    assert len(str(DesignError(found.faults, "f")).splitlines()) == len(found.faults)


@settings(max_examples=100, derandomize=True, deadline=None)
@given(ANY, ANY)
def test_no_scene_crashes(rows, points):
    from fingerdesign.design.io import judge_keys
    from fingerdesign.design.scene import Scene

    data = {"path": {"increments_mm": rows}, "readout": {"points_mm": points}}
    found = judge_keys(Scene, data)
    assert found.value is not None or all(str(fault) for fault in found.faults)
    assert (found.value is None) == bool(found.faults)


def test_names_that_windows_reserves_are_refused():
    for name in ("con", "NUL", "aux.1", "lpt9", "Com1.toml"):
        assert "Windows" in faults(f'design.name = "{name}"\n')["design.name"].bound
    for name in ("cone", "auxiliary", "com10", "a.con"):
        assert parse_design(f'design.name = "{name}"\n').design.name == name


def test_a_placement_stands_instead_of_the_regular_row():
    """count, pitch, cover and angle may stay in the file: the rows decide (CONTRACT)."""
    lines = "plates.count = 5\nplates.pitch_mm = 1.0\nplates.angle_deg = 45.0"
    design = parse_design(PLACED + lines)
    assert design.plates.number == 2
    assert parse_design(dump_design(design)) == design
    assert with_values(design, {"plates.length_mm": 1.5}).plates.number == 2


def test_a_former_key_is_read_under_its_present_name_with_a_note():
    text = 'design.name = "a"\n[grip.regulator]\ntaught_grips = 77\n'
    with pytest.warns(FormerKeyWarning, match=r"taught_grips is now .*training_grips"):
        design = parse_design(text)
    assert design.grip.regulator.training_grips == 77
    assert design == parse_design(text.replace("taught", "training"))
    with pytest.warns(FormerKeyWarning):
        changed = with_values(design, {"grip.regulator.taught_grips": 78})
    assert changed.grip.regulator.training_grips == 78
    with pytest.warns(FormerKeyWarning, match=r'mesher = "extrude" is now "sweep"'):
        assert parse_design(NAME + 'mesh.mesher = "extrude"').mesh.mesher == "sweep"


@pytest.mark.usefixtures("nothing_allowed", "importable")
def test_a_controllers_class_counts_by_the_content_of_its_file(tmp_path):
    """A changed class is another hand: no answer of the former one may be taken for its own."""
    file = tmp_path / "hand_of_a_digest.py"
    text = 'class Hand:\n    name = "mine"\n'
    text += "\n    def __init__(self, grip, own, held):\n        pass\n"
    text += "\n    def start(self, calibration, sample):\n        pass\n"
    file.write_text(f"{text}\n    def command(self, sample):\n        pass\n", "utf-8")
    reference = f"{file.stem}:Hand"
    allow_code(reference)
    design = parse_design(f'{NAME}grip.controller = "{reference}"\n')
    first = design.digest()
    assert design.digest() == first
    file.write_text(file.read_text("utf-8") + "        # changed\n", "utf-8")
    assert design.digest() != first
