"""Keys, types and bounds of a design, one by one; its digest; its grip."""

import numpy as np
import pytest

from fingerdesign.checks.load import load_design, parse_design, with_values, without_plates
from fingerdesign.design.digest import LATER, content_digest
from fingerdesign.design.former import FIRST_NAMES
from fingerdesign.design.grip import GRAVITY, Grip, Tug, WeightChange, pull_at
from fingerdesign.design.io import dump_design
from fingerdesign.errors import DesignError
from fingerdesign.layout.frames import Hole, PlateFrame
from fingerdesign.layout.layers import layered
from fingerdesign.layout.rows import mirrors_in_z, plate_frames
from fingerdesign.materials import gent_youngs_modulus
from tests.support.faults import faults_of as faults

NAME = 'design.name = "a"\n'
LIFT = '[grip]\nplant = "lift"\nhold_steps = 50\nobject_mass_g = 200.0\n'
CHANGE = "[[grip.weight_changes]]\nobject_mass_g = 100.0\nstep_after_lift = "


@pytest.mark.parametrize(
    ("lines", "key"),
    [
        ("body.width_mm = true", "body.width_mm"),
        ('body.width_mm = "20"', "body.width_mm"),
        ("body.width_mm = nan", "body.width_mm"),
        ("body.width_mm = 1e300", "body.width_mm"),
        (f"body.width_mm = 1{'0' * 400}", "body.width_mm"),
        ("plates.count = 15.0", "plates.count"),
        ("plates.count = 100000", "plates.count"),
        ("plates.placement = [[0, 10]]", "plates.placement[0]"),
        ("plates.placement = [[0, nan, 1]]", "plates.placement[0][1]"),
        ('gages.face = "uper"', "gages.face"),
        ("materials.silicone.poissons_ratio = 0.5", "materials.silicone.poissons_ratio"),
        ("materials.silicone.youngs_modulus_MPa = 0", "materials.silicone.youngs_modulus_MPa"),
        ("materials.silicone = 3", "materials.silicone"),
        ('body.material = "silicon"', "body.material"),
        ("grip.friction_coefficients = []", "grip.friction_coefficients"),
        ("grip.friction_coefficients = [0.3, 0]", "grip.friction_coefficients[1]"),
        ('mesh.mesher = "gmsh"', "mesh.mesher"),
        ("assumed = [3]", "assumed[0]"),
        ("materials = 3", "materials"),
        # Keys that change nothing.
        ('body.shape = "block"\nbody.arc_radius_mm = 30', "body.arc_radius_mm"),
        ('body.shape = "revolved"\nbody.depth_mm = 30', "body.depth_mm"),
        ('body.shape = "step"', "body.step.file"),
        ('body.step.file = "a.step"', "body.step.file"),
        ('body.edge = "chamfer"', "body.edge"),
        ("plates.hole_pitch_mm = 3", "plates.hole_pitch_mm"),
        ("plates.placement = [[0, 8, 0]]\nplates.rows = [{}]", "plates.rows"),
        ("plates.count = 400\nplates.rows = [{count = 101}]", "plates.rows"),
        ("plates.placement = [[0, 8, 0], [501, 8, 0]]", "plates.placement[1]"),
        ("plates.placement = [[0, 8, 180.5]]", "plates.placement[0]"),
        ("plates.placement = [[0, 8, 0, -501]]", "plates.placement[0]"),
        ('plates.placement = [[0, 8, 0]]\nplates.follow = "bent"', "plates.follow"),
        ("plates.placement = [[0, 8, 0]]\nplates.offset_mm = 1", "plates.offset_mm"),
        ('body.core.material = "oak"', "body.core.material"),
        (
            LIFT + "[[grip.tugs]]\nstep_after_lift = 51\nextra_force_N = 1.0",
            "grip.tugs[0].step_after_lift",
        ),
        (f"{LIFT}{CHANGE}51", "grip.weight_changes[0].step_after_lift"),
        (f"{LIFT}{CHANGE}5\n{CHANGE}5", "grip.weight_changes[1].step_after_lift"),
        *[
            ("[grip]\n" + text, key)
            for text, key in [
                ("hold_steps = 5", "grip.hold_steps"),
                ("[[grip.tugs]]\nstep_after_lift = 1\nextra_force_N = 1.0", "grip.tugs[0]"),
                ('plant = "hand"', "grip.plant"),
                ("inertia = true", "grip.inertia"),
                ("warming_K = 5.0", "grip.warming_K"),
                ('plant = "lift"\nwarming_K = -150.0', "grip.warming_K"),
                ('plant = "lift"\nwarming_K = 5.0\n[plates]\nmodel = "sheet"', "grip.warming_K"),
                (
                    'plant = "lift"\nwarming_K = 5.0\n[body]\nmaterial = "own"\n[materials.own]\n'
                    "youngs_modulus_MPa = 2.0\npoissons_ratio = 0.49",
                    "grip.warming_K",
                ),
                ("rubber_memory = [[0.1, 1.0]]", "grip.rubber_memory"),
                ('plant = "lift"\nrubber_memory = [[0.5, 1.0], [0.5, 2.0]]', "grip.rubber_memory"),
                ('plant = "lift"\nrubber_memory = [[0.5, 0.0]]', "grip.rubber_memory[0][1]"),
                ('plant = "lift"\nrubber_memory = [[-0.5, 1.0]]', "grip.rubber_memory[0][0]"),
                ("[grip.hardware]\nactuator_lag_s = 6.0", "grip.hardware.actuator_lag_s"),
                (
                    'plant = "lift"\nrubber_memory = [[0.1, 1]]\nrelaxation_per_minute = 0.1',
                    "grip.relaxation_per_minute",
                ),
                ('opposite = "bare"', "grip.opposite"),
                ('plant = "lift"\nopposite = "like"', "grip.opposite"),
                (
                    "[grip.hardware]\ngage_noise_microstrain = -0.5",
                    "grip.hardware.gage_noise_microstrain",
                ),
                ("[grip.hardware]\nsample_rate_Hz = 0", "grip.hardware.sample_rate_Hz"),
                ("[grip.hardware]\ndelay_samples = 1.5", "grip.hardware.delay_samples"),
                ("[grip.hardware]\nstage_step_mm = 0.0021", "grip.hardware.stage_step_mm"),
                ("[grip.hardware]\ndead_gages = [15]", "grip.hardware.dead_gages"),
                ("[grip.hardware]\ndead_gages = [3, 3]", "grip.hardware.dead_gages"),
                ("[grip.hardware]\ndying_gages = [15]", "grip.hardware.dying_gages"),
                (
                    "[grip.hardware]\ndead_gages = [3]\ndying_gages = [3]",
                    "grip.hardware.dying_gages",
                ),
                (f"[grip.hardware]\ndead_gages = {list(range(14))}", "grip.hardware.dead_gages"),
                (  # 10 dead of 15: 3 more may die, one of the 4 would leave a single gage
                    "[grip.hardware]\ndead_gages = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]\n"
                    "dying_gages = [10, 11, 12, 13]",
                    "grip.hardware.dying_gages",
                ),
                ("preload_mm = 0.2\nmax_approach_mm = 0.2", "grip.preload_mm"),
                ("preload_mm = 0.5\nmax_approach_mm = 0.3", "grip.preload_mm"),
                ("max_approach_mm = 12.0", "grip.max_approach_mm"),
                ("approach_step_mm = 1.0", "grip.approach_step_mm"),
                ("approach_step_mm = 1e-6", "grip.approach_step_mm"),
                ("[grip.hardware]\nnoise = 1.0", "grip.hardware.noise"),
            ]
        ],
    ],
)
def test_each_fault_is_blamed_on_its_key(lines, key):
    assert set(faults(NAME + lines)) == {key}


def test_names_are_required_and_those_that_are_no_folder_refused():
    assert faults("body.width_mm = 20")["design.name"].bound == "given"
    for name in ("", ".a", "a/b", "a\\b", "..", "a b", "é", "x" * 65, "a."):
        assert "letters" in faults(f"design.name = {name!r}")["design.name"].bound


def test_a_revolved_body_is_as_deep_as_wide_and_a_dome_needs_its_radius():
    design = parse_design(NAME + 'body.shape = "revolved"\nplates.count = 0\nbody.width_mm = 12')
    assert design.body.depth_mm == 12.0
    assert with_values(design, {"body.shape": "arc"}).body.depth_mm == 12.0
    assert parse_design(dump_design(design)) == design
    assert faults(NAME + 'body.shape = "dome"')["body.dome_radius_mm"].value == "(absent)"
    assert "body.dome_radius_mm" in faults(NAME + "body.dome_radius_mm = 25")
    sound = parse_design(NAME + 'body.shape = "dome"\nbody.dome_radius_mm = 25')
    assert not sound.extruded
    assert mirrors_in_z(sound)


def test_a_plate_with_a_hole_on_one_side_alone_does_not_mirror():
    one, other = (Hole(0.2, w, 0.1) for w in (1.0, -1.0))
    for holes, mirrors in (((), True), ((one, other), True), ((one,), False)):
        plate = PlateFrame(0, 0.0, 5.0, 45.0, 1.0, 0.1, -5.0, 5.0, holes=holes)
        assert plate.mirrors_in_z is mirrors


def test_every_other_plate_of_a_staggered_row_is_half_of_it_to_either_side():
    text = (
        "plates.count = 4\nplates.span_mm = 6\nplates.stagger_mm = 1.0\nplates.span_offset_mm = 0.2"
    )
    middles = [frame.middle for frame in plate_frames(parse_design(NAME + text))]
    assert middles == pytest.approx([0.7, -0.3, 0.7, -0.3])


def test_rows_take_what_they_do_not_say_from_the_table():
    text = "plates.rows = [{ cover_mm = 5.0 }, { along = 'z', count = 3, cover_mm = 8 }]"
    plates = parse_design(NAME + text).plates
    assert plates.number == 15 + 15 + 3
    assert parse_design(NAME + "plates.rows = [{ cover_mm = 5.0, count = 0 }]").plates.number == 15
    first, second, third = plates.all_rows
    assert (first.cover_mm, second.cover_mm, third.cover_mm) == (2.0, 5.0, 8.0)
    assert (second.pitch_mm, third.along, second.along) == (1.0, "z", "x")


def test_materials_are_completed_changed_and_new():
    design = parse_design(NAME + "materials.silicone.poissons_ratio = 0.3")
    material = design.material_of("body")
    assert (material.youngs_modulus_MPa, material.poissons_ratio) == (4.96, 0.3)
    assert "Maeno" not in material.source  # what is changed has another source
    assert parse_design(NAME + "materials.silicone.poissons_ratio = 0.49") == parse_design(NAME)
    mine = "materials.mine = {youngs_modulus_MPa = 1, poissons_ratio = 0.45}"
    design = parse_design(f'{NAME}body.material = "mine"\n{mine}')
    assert design.material_of("body").youngs_modulus_MPa == 1.0
    assert "silicone" not in design.materials


@pytest.mark.parametrize(
    ("lines", "extruded", "in_layers"),
    [
        ("", True, True),
        ("plates.span_mm = 10.0", True, True),
        ("plates.span_mm = 8.0", False, True),
        ("plates.span_mm = 8.0\nplates.count = 0", True, True),
        ("plates.span_mm = 5.0\nplates.stagger_mm = 2.0", False, True),
        ("plates.hole_diameter_mm = 0.5", False, False),
        ('body.shape = "dome"\nbody.dome_radius_mm = 25', False, False),
        ("body.core = { height_mm = 2.0, depth_mm = 6.0 }", False, True),
    ],
)
def test_extruded_and_layered(lines, extruded, in_layers):
    """One section tells all; or, swept through layers, it can at least be meshed so."""
    design = parse_design(NAME + lines)
    assert (design.extruded, layered(design)) == (extruded, in_layers)


BASE = parse_design(NAME)


def test_formatting_order_and_written_defaults_do_not_matter():
    for text in (
        '# a comment\n\n[design]\nname="a"   # another\n',
        'design.name = "a"\nbody.width_mm = 20',
        'design.name = "a"\nbody.width_mm = 2.0e1\nbody.depth_mm = 10.0',
        '[plates]\ncount = 15\n[body]\nshape = "arc"\n[design]\nname = "a"',
        'design.name = "a"\ngages.z_mm = -0.0',
        'design.name = "a"\nmaterials.silicone.youngs_modulus_MPa = 4.96',
    ):
        assert parse_design(text).digest() == BASE.digest()


@pytest.mark.parametrize(
    "line",
    [
        "body.width_mm = 20.0000001",
        "body.depth_mm = 10.000000000000002",
        "plates.count = 14",
        'gages.face = "upper"',
        'gages.grid = "tee"',
        "gages.gage_factor = 2.1",
        "grip.hardware.gage_noise_microvolt_per_V = 0.5",
        "plates.span_mm = 8.0",
        "materials.silicone.poissons_ratio = 0.48",
        "mesh.layers = 9",
        "grip.seed = 1",
        "grip.friction_coefficients = [0.5, 0.3, 0.8]",
    ],
)
def test_any_value_matters(line):
    assert parse_design('design.name = "a"\n' + line).digest() != BASE.digest()


def test_keys_that_came_later_leave_digests_as_they_were():
    """At their defaults, written down or not; the pins below hold what digests were before."""
    tables, values = [BASE.model_dump(mode="json")], {}
    while tables:
        values |= (table := tables.pop())
        tables += [each for each in table.values() if isinstance(each, dict)]
    values = {FIRST_NAMES.get(key, key): value for key, value in values.items()}
    assert {key: values[key] for key in LATER} == LATER
    assert parse_design('design.name = "a"\ngages.grid = "axial"').digest() == BASE.digest()


def changed(table, path=""):
    """Dotted keys of numbers, switches and absent values, each with a copy that has another."""
    for name, info in type(table).model_fields.items():
        key, value, other = path + name, getattr(table, name), None
        if hasattr(value, "model_fields_set"):
            yield from (
                (k, table.model_copy(update={name: v})) for k, v in changed(value, f"{key}.")
            )
        elif isinstance(value, int | float):
            other = not value if isinstance(value, bool) else value + 1
        elif value is None and name != "file":
            shown = (each for each in info.examples or () if not isinstance(each, list))
            other = next((type(each)() for each in shown), None)  # 0 is not absent
        if other is not None:
            yield key, table.model_copy(update={name: other})


def test_every_key_but_how_it_is_cast_is_part_of_the_digest():
    base = parse_design(NAME + "body.core.width_mm = 4.0\ngages.leads.number = 4")
    found = dict(changed(base))
    assert len(found) > 100
    same = {key for key, other in found.items() if content_digest(other) == content_digest(base)}
    assert same == {key for key in found if key.startswith("mold.")}


def test_what_pulls_at_the_object_is_its_weight_by_then_and_the_tugs_that_last():
    tugs = [Tug(step_after_lift=2, extra_force_N=1.0, duration_steps=3)]
    tugs += [Tug(step_after_lift=4, extra_force_N=-0.5)]
    changes = [
        WeightChange(step_after_lift=k, object_mass_g=m) for k, m in ((4, 100.0), (2, 300.0))
    ]
    masses, extra = np.array([200.0, 300.0, 300.0, 100.0, 100.0]), [0.0, 1.0, 1.0, 0.5, 0.0]
    found = [pull_at(step, 200.0, tugs, changes) for step in range(1, 6)]
    assert found == pytest.approx(1e-3 * GRAVITY * masses + extra)
    grip = Grip(tugs=tuple(tugs), weight_changes=tuple(changes))
    assert grip.most_pull(200.0) == max(found[1:4])
    tugs[1] = Tug(step_after_lift=2, extra_force_N=-0.5)  # ends while the other lasts
    assert Grip(tugs=tuple(tugs)).most_pull(200.0) == pytest.approx(2e-1 * GRAVITY + 1.0)
    assert Grip().most_pull(200.0) is None


BEFORE_MOLDS = {
    "boned": "846e716a7173780e2bb6fc6b9dc8b0a2d25a1d3507aefe81a9f15b5f8b41808e",
    "both_ways": "f71af5e435be2e70935603ecc9c2fcb9c09f7a86e3ec0d44aac6e62add53fe7e",
    "domed": "4e3955bf9e15822e822429e639449bd348c4713dc92617dabab5d06ed4b485f6",
    "maeno2000": "7aa1683a43b9b915d8fe1a3cda1523bdb13b4bb21f78900336f0c78836a9b7a2",
    "sensitive": "fdb9cfea7c47baf58f4f3ceffe46c0b8a4ed17016dbba98523592cdf1ab8f864",
}


@pytest.mark.parametrize(("name", "digest"), BEFORE_MOLDS.items())
def test_how_a_finger_is_cast_is_not_in_the_digest(name, digest):
    """A design's results outlive its ``[mold]``: digests are what they were before there was one.

    A shipped design or a default that is changed on purpose moves its digest: then pin it anew.
    """
    design = load_design(name)
    assert with_values(design, {"mold": {}}).digest() == digest
    assert with_values(design, {"mold.process": "fdm", "mold.wall_mm": 9.0}).digest() == digest
    cables = {"grip.hardware.dead_gages": [2], "grip.hardware.dying_gages": [3]}
    bare = without_plates(with_values(design, cables if design.plates.number > 3 else {}))  # sound
    assert (bare.plates.number, bare.body, bare.mesh) == (0, design.body, design.mesh)


def test_a_tug_out_of_the_fingers_is_refused_and_the_bound_is_one_that_passes():
    tug = "[[grip.tugs]]\nstep_after_lift = 2\nduration_steps = 20\nextra_force_N = "
    lighter = "\n[[grip.weight_changes]]\nstep_after_lift = 15\nobject_mass_g = 100.0\n"
    with pytest.raises(DesignError, match=r"tugs\[0\].extra_force_N.*0.981 N"):
        parse_design(NAME + LIFT + tug + "-1.5" + lighter)
    parse_design(NAME + LIFT + tug + "-0.98" + lighter)
    parse_design(NAME + LIFT + tug + "-1.5")


def test_a_hardness_stands_for_a_modulus():
    text = 'design.name = "a"\nbody.material = "mine"\n[materials.mine]\nshore_a = 30\n'
    rubber = parse_design(text).material_of("body")
    assert rubber.youngs_modulus_MPa == pytest.approx(gent_youngs_modulus(30.0), rel=1e-3)
    both = parse_design(text + "youngs_modulus_MPa = 0.5\npoissons_ratio = 0.4\n").material_of(
        "body"
    )
    assert both.youngs_modulus_MPa == 0.5
    design, key = parse_design(text), "materials.mine.shore_a"
    changed = with_values(design, {key: 60}).material_of("body")
    assert changed.youngs_modulus_MPa == pytest.approx(gent_youngs_modulus(60.0), rel=1e-3)
    own = {"materials.mine.youngs_modulus_MPa": 2.0, key: 60}
    assert with_values(design, own).material_of("body").youngs_modulus_MPa == 2.0
    for wrong in ('"hard"', "300", "true"):
        with pytest.raises(DesignError, match=r"materials\.mine"):
            parse_design(text.replace("30", wrong))
