"""``export --to mjcf`` and ``--to urdf``: masses by hand, and what MuJoCo makes of them."""

import json
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from fingerdesign import load_design
from fingerdesign.errors import DesignError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.volume import outline_volume, plate_volume
from fingerdesign.robots.describe import _roll_pitch_yaw, _site, describe, mjcf, urdf
from fingerdesign.robots.rigid import RigidBody, densities, rigid_body, triangles_of

WITHOUT = "pip install 'fingerdesign[mujoco]' brings it"


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    """A block with plates: its folder, its description, its design."""
    folder, design = tmp_path_factory.mktemp("block"), load_design("block")
    return folder, describe(design, folder), design


def test_a_box_has_its_mass_centre_and_inertia():
    corners = np.array([[x, y, z] for x in (0, 2) for y in (0, 3) for z in (0, 5)], float)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    found = rigid_body([(corners[np.array(triangles)] + [1.0, 7.0, -2.0], 2.0)])
    mass = 2.0 * 30e-6
    assert found.mass == pytest.approx(mass, rel=1e-12)
    assert found.centre == pytest.approx(np.array([2.0, 8.5, 0.5]) * 1e-3, rel=1e-12)
    sides = np.array([2.0, 3.0, 5.0]) ** 2
    exact = np.diag(mass / 12.0 * (sides.sum() - sides)) * 1e-6
    assert np.abs(found.inertia - exact).max() < 1e-12 * np.abs(exact).max() + 1e-20


def test_each_part_has_the_density_of_its_material_unless_another_is_given():
    design, usual = load_design("boned"), {"plates": 7.85, "body": 1.1, "core": 2.7}
    assert densities(design, {}) == usual
    for part in usual:
        material = getattr(design, "plates" if part == "plates" else "body").material
        material = design.body.core.material if part == "core" else material
        assert densities(design, {material: 3.5}) == usual | {part: 3.5}


def test_mass_is_rubber_and_plates_apart(block):
    _, found, design = block
    metal = sum(plate_volume(frame) for frame in plate_frames(design))
    rubber = outline_volume(design.body) - metal
    grams = 1e-3 * (rubber * 1.1 + metal * 8.86)
    assert 1e3 * found.rigid.mass == pytest.approx(grams, rel=1e-3)  # chords of rounded edges


def test_the_hull_holds_the_finger(block):
    folder, found, _ = block
    corners = triangles_of(folder / "collision.stl")
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    points = triangles_of(folder / "body.stl").reshape(-1, 3)
    out = (points[:, None] - corners[None, :, 0]) * normals
    assert out.sum(axis=2).max() < 1e-5  # single precision
    assert found.crest == pytest.approx(1e-3 * points[:, 1].max(), abs=1e-8)


def test_angles_of_urdf_give_the_axes_back():
    for roll, pitch, yaw in ((0.3, -0.7, 2.0), (0.4, np.pi / 2, 0.0), (-1.0, 0.2, -3.0)):
        (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
        x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
        y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
        assert _roll_pitch_yaw(z @ y @ x) == pytest.approx([roll, pitch, yaw], abs=1e-12)


def test_a_urdf_names_files_that_are_there(block):
    folder, found, _ = block
    root = ElementTree.fromstring(urdf(found))
    assert all((folder / mesh.get("filename")).is_file() for mesh in root.iter("mesh"))
    assert len(root.findall("joint")) == len(found.sites) == 11
    for site, joint in zip(found.sites, root.iter("joint"), strict=True):
        place = np.array(joint.find("origin").get("xyz").split(), dtype=float)
        assert place == pytest.approx(site.centre, abs=1e-9)
        turned = np.array(joint.find("origin").get("rpy").split(), dtype=float)
        assert turned == pytest.approx(_roll_pitch_yaw(site.axes), abs=1e-8)
    roles = [(each.tag, each.get("name")) for each in root.find("link")[1:]]
    assert roles == [("visual", "body"), ("visual", "plates"), ("collision", "collision")]
    assert {each.get("scale") for each in root.iter("mesh")} == {"0.001 0.001 0.001"}


def test_mass_centre_and_each_moment_of_inertia_stand_in_their_places(block):
    _, found, _ = block
    inertia = 1e-6 * np.array([[9.0, 1.0, 2.0], [1.0, 8.0, 3.0], [2.0, 3.0, 7.0]])
    own = replace(found, rigid=RigidBody(0.25, np.array([0.1, 0.2, 0.3]), inertia))
    root = ElementTree.fromstring(urdf(own)).find("link/inertial")
    assert (root.find("mass").get("value"), root.find("origin").get("xyz")) == (
        "0.25",
        "0.1 0.2 0.3",
    )
    each = {name: round(1e6 * float(v)) for name, v in root.find("inertia").attrib.items()}
    assert each == {"ixx": 9, "iyy": 8, "izz": 7, "ixy": 1, "ixz": 2, "iyz": 3}
    inertial = ElementTree.fromstring(mjcf(own)).find(".//inertial")
    assert (inertial.get("mass"), inertial.get("pos")) == ("0.25", "0.1 0.2 0.3")
    full = 1e6 * np.array(inertial.get("fullinertia").split(), dtype=float)
    assert full == pytest.approx([9.0, 8.0, 7.0, 1.0, 2.0, 3.0])  # MuJoCo's order


def test_export_writes_the_finger_or_says_what_is_wrong(tmp_path, terminal):
    given = ["export", "feeler", "--to", "urdf", "--out", tmp_path]
    printed = json.loads(terminal(*given, "--json").out)
    assert set(printed["files"]) == {path.name for path in (tmp_path / "feeler").iterdir()}
    heavier = terminal(*given, "--density", "silicone", "2.2", "--json").out
    assert json.loads(heavier)["mass_g"] > 1.7 * printed["mass_g"]
    twice = [*("--density", "silicone", "1"), *("--density", "silicone", "2")]
    wrong = terminal(*given, *twice, "--density", "gold", "19", code=2).err.splitlines()
    assert [each[:22] for each in wrong] == ["--density = silicone: ", "--density = gold: must"]
    for wrong in ("nan", "0", "-1", "31"):
        assert "--density" in terminal(*given, "--density", "silicone", wrong, code=2).err
    flexed = [*given[:3], "mjcf", "--out", tmp_path / "new", "--flex"]
    assert all("--flex" in terminal(*flexed, wrong, code=2).err for wrong in ("nan", "0", "21"))
    assert not (tmp_path / "new").exists()
    assert "c and fmu alone" in terminal(*given, "--noise", "1", code=2).err
    assert "mjcf alone" in terminal(*given, "--flex", "2", code=2).err
    other = terminal(*given[:3], "mjcf", *given[4:], code=2).err
    assert "finger.urdf" in other  # another kind of folder is not replaced


@pytest.mark.parametrize("wrong", [np.nan, np.inf, 0.0, -1.0])
def test_a_number_that_is_no_density_or_size_is_refused(wrong, tmp_path):
    design = load_design("block")
    with pytest.raises(DesignError, match="--density silicone = "):
        describe(design, tmp_path, {"silicone": wrong})
    with pytest.raises(DesignError, match="--flex = "):
        describe(design, tmp_path, None, wrong)
    assert list(tmp_path.iterdir()) == []


def test_a_site_is_where_the_gage_is_along_z(block):
    frame = plate_frames(block[2])[0]
    off = _site(frame, 1.5).centre - _site(frame, 0.0).centre
    assert sorted(np.abs(off).tolist()) == pytest.approx([0.0, 0.0, 1.5e-3])


def test_mujoco_reads_masses_and_sites(block):
    mujoco = pytest.importorskip("mujoco", reason=WITHOUT)
    folder, found, _ = block
    (folder / "finger.xml").write_text(mjcf(found))
    model = mujoco.MjModel.from_xml_path(str(folder / "finger.xml"))
    body = model.body("block")
    assert body.mass[0] == pytest.approx(found.rigid.mass)
    assert body.ipos == pytest.approx(found.rigid.centre)
    principal = np.sort(np.linalg.eigvalsh(found.rigid.inertia))
    assert np.sort(body.inertia) == pytest.approx(principal, rel=1e-6)
    assert model.site("block_gage_4").pos == pytest.approx(found.sites[3].centre)
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, model.site("block_gage_4").quat)
    assert axes.reshape(3, 3) == pytest.approx(found.sites[3].axes, abs=1e-8)
    meets = {part: model.geom(f"block_{part}").contype[0] for part in found.meshes}
    assert meets == {"body": 0, "plates": 0, "collision": 1}


def test_a_flex_sags_as_the_rubber_does(tmp_path):
    """Of a column on its base: rho g h^2 / 2 E, less what the glued base holds back; no mass is
    lost, and MuJoCo says nothing in 500 steps."""
    mujoco = pytest.importorskip("mujoco", reason=WITHOUT)
    design, warned = load_design("block"), []
    found = describe(design, tmp_path, None, 2.0)
    (tmp_path / "finger.xml").write_text(mjcf(found))
    assert not (tmp_path / "body.stl").exists()
    mujoco.set_mju_user_warning(warned.append)
    try:
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "finger.xml"))
        assert sum(model.body_mass) == pytest.approx(found.mass)
        model.opt.gravity[:] = 0.0, -9.81, 0.0
        data = mujoco.MjData(model)
        for _ in range(500):
            mujoco.mj_step(model, data)
    finally:
        mujoco.set_mju_user_warning(None)
    assert warned == []
    column = 1100.0 * 9.81 * found.crest**2 / 2.0 / found.flex.youngs_modulus
    assert 0.5 * column < -data.qpos.min() < column


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "flex_mm"),
    [
        # Each body, a core, plates both ways and none; flexes of a core and of a round body.
        *((name, None) for name in ("block", "boned", "both_ways", "film_tees", "homogeneous")),
        *(("domed", None), ("pin", None), ("domed", 3.0), ("boned", 2.0)),
    ],
)
def test_shipped_fingers_load_in_mujoco_without_a_warning(name, flex_mm, tmp_path):
    mujoco = pytest.importorskip("mujoco", reason=WITHOUT)
    warned = []
    mujoco.set_mju_user_warning(warned.append)
    try:
        found = describe(load_design(name), tmp_path, None, flex_mm)
        texts = {"finger.xml": mjcf(found)}
        texts |= {"finger.urdf": urdf(found)} if flex_mm is None else {}
        for file, text in texts.items():
            (tmp_path / file).write_text(text)
            model = mujoco.MjModel.from_xml_path(str(tmp_path / file))
            mujoco.mj_step(model, mujoco.MjData(model))
    finally:
        mujoco.set_mju_user_warning(None)
    assert warned == []
