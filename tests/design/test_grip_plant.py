"""The ``[grip]`` tables of plant and hardware: what is accepted, and each fault by its key."""

import pytest

from fingerdesign import load_design, parse_design
from fingerdesign.checks.load import without_plates
from fingerdesign.checks.starter import shipped_path
from fingerdesign.control.plants.rig import Hardware
from fingerdesign.errors import DesignError

LIFT = """
design.name = "a"
[grip]
plant = "lift"
hold_steps = 50
object_mass_g = 200.0
"""


def test_a_lift_with_all_that_can_happen_to_it():
    grip = parse_design(
        LIFT
        + """
[[grip.tugs]]
step_after_lift = 10
extra_force_N = 1.0
duration_steps = 5
[[grip.tugs]]
step_after_lift = 30
extra_force_N = -1.9
[[grip.weight_changes]]
step_after_lift = 40
object_mass_g = 300.0
[grip.hardware]
gage_noise_microstrain = 0.5
dead_gages = [3, 4]
delay_samples = 2
"""
    ).grip
    assert [tug.duration_steps for tug in grip.tugs] == [5, 1]
    assert grip.weight_changes[0].object_mass_g == 300.0
    hardware = Hardware(**grip.hardware.model_dump())
    assert (hardware.dead_gages, hardware.delay_samples) == ((3, 4), 2)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("hold_steps = 5", "grip.hold_steps"),
        ("[[grip.tugs]]\nstep_after_lift = 1\nextra_force_N = 1.0", "grip.tugs[0]"),
        ('plant = "hand"', "grip.plant"),
        ('opposite = "bare"', "grip.opposite"),
        ('plant = "lift"\nopposite = "like"', "grip.opposite"),
        ("[grip.hardware]\ngage_noise_microstrain = -0.5", "grip.hardware.gage_noise_microstrain"),
        ("[grip.hardware]\nsample_rate_Hz = 0", "grip.hardware.sample_rate_Hz"),
        ("[grip.hardware]\ndelay_samples = 1.5", "grip.hardware.delay_samples"),
        ("[grip.hardware]\nstage_step_mm = 0.0021", "grip.hardware.stage_step_mm"),
        ("[grip.hardware]\ndead_gages = [15]", "grip.hardware.dead_gages"),
        ("[grip.hardware]\ndead_gages = [3, 3]", "grip.hardware.dead_gages"),
        (f"[grip.hardware]\ndead_gages = {list(range(14))}", "grip.hardware.dead_gages"),
        ("preload_mm = 0.2\nmax_approach_mm = 0.2", "grip.preload_mm"),
        ("preload_mm = 0.5\nmax_approach_mm = 0.3", "grip.preload_mm"),
        ("max_approach_mm = 12.0", "grip.max_approach_mm"),
        ("approach_step_mm = 1.0", "grip.approach_step_mm"),
        ("approach_step_mm = 1e-6", "grip.approach_step_mm"),
        ("[grip.hardware]\nnoise = 1.0", "grip.hardware.noise"),
    ],
)
def test_each_fault_is_blamed_on_its_key(text, key):
    with pytest.raises(DesignError) as caught:
        parse_design(f'design.name = "a"\n[grip]\n{text}')
    assert [fault.key for fault in caught.value.faults] == [key]


def test_what_begins_after_the_end_is_refused():
    for table, value in (("tugs", "extra_force_N"), ("weight_changes", "object_mass_g")):
        with pytest.raises(DesignError, match=rf"grip.{table}\[0\].step_after_lift"):
            parse_design(f"{LIFT}[[grip.{table}]]\nstep_after_lift = 51\n{value} = 1.0")


def test_a_tug_out_of_the_fingers_is_refused_and_the_bound_is_one_that_passes():
    tug = "[[grip.tugs]]\nstep_after_lift = 2\nduration_steps = 20\nextra_force_N = "
    lighter = "\n[[grip.weight_changes]]\nstep_after_lift = 15\nobject_mass_g = 100.0\n"
    with pytest.raises(DesignError, match=r"tugs\[0\].extra_force_N.*0.981 N"):
        parse_design(LIFT + tug + "-1.5" + lighter)
    parse_design(LIFT + tug + "-0.98" + lighter)
    parse_design(LIFT + tug + "-1.5")


def test_a_shipped_finger_without_its_plates_is_sound():
    for name in ("sensitive", "both_ways", "boned"):
        design = load_design(shipped_path(name))
        bare = without_plates(design)
        assert (bare.plates.number, bare.body, bare.mesh) == (0, design.body, design.mesh)


def test_a_weight_that_changes_twice_at_once_is_refused():
    change = "[[grip.weight_changes]]\nstep_after_lift = 5\nobject_mass_g = "
    with pytest.raises(DesignError, match=r"weight_changes\[1\].step_after_lift"):
        parse_design(f"{LIFT}{change}100.0\n{change}300.0\n")
