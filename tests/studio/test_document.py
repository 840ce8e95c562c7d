"""The TOML file behind the sliders: what is unsaved, saved with its comments, changed by others."""

from pathlib import Path

import pytest

from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.design.starter import starter_text
from fingerdesign.errors import DesignError
from fingerdesign.studio.document import Document, edited_text, with_keys
from fingerdesign.studio.sliders import sliders_of


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(starter_text("mine", "maeno2000"), encoding="utf-8")
    return path


def test_save_keeps_comments_and_everything_else(file):
    before = file.read_text("utf-8")
    document = Document.of(file)
    document.put({"plates.angle_deg": 30.0, "body.width_mm": 22.0})
    assert document.unsaved == {"plates.angle_deg": 30.0}  # the width is the file's own
    assert document.save() == file
    lines = zip(before.splitlines(), file.read_text("utf-8").splitlines(), strict=True)
    changed = [(old, new) for old, new in lines if old != new]
    assert changed == [("angle_deg = 45.0", "angle_deg = 30.0")]
    assert document.unsaved == {}


def test_a_new_key_joins_its_table():
    text = "[design]\nname = 'a'  # mine\n\n[plates]\ncount = 3\n"
    found = with_keys(text, {"plates.angle_deg": 20.0, "body.width_mm": 21.0})
    assert found.startswith("[design]\nname = 'a'  # mine\n")
    assert "count = 3\nangle_deg = 20.0\n" in found
    assert "[body]\nwidth_mm = 21.0" in found


def test_a_comment_on_a_changed_value_gives_way_to_the_former_value(tmp_path):
    text = starter_text("mine", "block")
    before = parse_design(text)
    assert "# all of the pad touches at once" in text
    after = with_values(before, {"grip.max_approach_mm": 0.25})
    found = edited_text(text, before, after, tmp_path)
    assert "max_approach_mm = 0.25    # was 0.2\n" in found
    assert "# keys left out are those of maeno2000" in found


def test_a_key_that_is_set_is_no_longer_assumed():
    text = 'assumed = [\n  "body.width_mm",  # from a picture\n  "body.depth_mm",\n]\n'
    found = with_keys(text + "[body]\nwidth_mm = 20.0\n", {"body.width_mm": 21.0})
    assert found == 'assumed = [\n  "body.depth_mm",\n]\n[body]\nwidth_mm = 21.0\n'


def test_what_an_editor_writes_is_taken_over_and_wins(file):
    document = Document.of(file)
    document.put({"plates.angle_deg": 30.0, "plates.cover_mm": 0.8})
    assert not document.changed()
    file.write_text(with_keys(file.read_text("utf-8"), {"plates.angle_deg": 60.0}), "utf-8")
    assert document.changed()
    assert document.unsaved == {"plates.cover_mm": 0.8}
    assert document.design().plates.angle_deg == 60.0
    assert not document.changed()


def test_a_faulty_file_leaves_the_last_sound_text(file):
    document = Document.of(file)
    sound = file.read_text("utf-8")
    file.write_text("[plates]\ncount = -1\n", encoding="utf-8")
    with pytest.raises(DesignError, match="count"):
        document.changed()
    assert document.design().plates.count == 15
    file.write_text(sound + "# more\n", encoding="utf-8")
    assert document.changed()


def test_a_shipped_design_is_saved_as_a_file_of_ones_own(tmp_path, in_tmp_path):
    document = Document.of(None)
    document.put({"plates.angle_deg": 30.0})
    assert document.save() == Path("maeno2000.toml")
    assert Document.of(Path("maeno2000.toml")).design().plates.angle_deg == 30.0
    again = Document.of(Path("sensitive"))
    (tmp_path / "sensitive.toml").write_text("mine", encoding="utf-8")
    with pytest.raises(DesignError, match="a new file"):
        again.save()


def test_sliders_of_every_kind_stay_within_their_ends():
    for name in ("maeno2000", "domed", "pin", "block", "homogeneous"):
        sliders = sliders_of(Document.of(Path(name)).design())
        assert [each.key for each in sliders[:3]] == ["approach", "shear", "friction"]
        assert all(each.allowed(each.value) == each.value for each in sliders)
        assert all(each.low < each.high and each.step > 0 for each in sliders if not each.options)
    assert not any(each.key.startswith("plates.") for each in sliders)  # it has none


def test_a_file_that_may_not_be_written_is_not_replaced(file):
    document = Document.of(file)
    document.put({"plates.angle_deg": 30.0})
    file.chmod(0o444)
    before = file.read_text("utf-8")
    with pytest.raises(DesignError, match="writable"):
        document.save()
    assert file.read_text("utf-8") == before


@pytest.mark.parametrize("text", ["x=", "a=" + "[" * 100_000, "plates = 3"])
def test_a_file_that_broke_meanwhile_is_not_saved_over(file, text):
    document = Document.of(file)
    document.put({"plates.angle_deg": 30.0})
    file.write_text(text, "utf-8")
    with pytest.raises(DesignError):
        document.save()
    assert file.read_text("utf-8") == text
    assert document.unsaved == {"plates.angle_deg": 30.0}
    assert document.design().plates.angle_deg == 30.0


def test_a_file_that_is_gone_is_reported_and_saved_again(file):
    document = Document.of(file)
    file.unlink()
    with pytest.raises(DesignError, match="Save writes it again"):
        document.changed()
    assert document.save() == file
    assert not document.changed()
    file.unlink()
    file.mkdir()
    with pytest.raises(DesignError, match="move that away"):
        document.changed()


def test_a_material_with_a_dot_in_its_name_has_no_slider():
    text = 'design.name = "a"\nbody.material = "a.b"\n[materials."a.b"]\n'
    design = parse_design(f"{text}youngs_modulus_MPa = 4.0\npoissons_ratio = 0.49\n")
    assert not [each.key for each in sliders_of(design) if each.key.startswith("materials")]
