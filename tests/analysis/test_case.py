"""What a case makes of its design: the gage array that the rule hears, halves, refusals by kind."""

import numpy as np
import pytest

from fingerdesign.analysis.analysis import CAVEATS, _at_side, of_choices
from fingerdesign.analysis.case import Case, gage_array
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.checks.load import parse_design
from fingerdesign.design.io import parse_scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.pipeline import run
from fingerdesign.report.page import paragraphs

ACROSS = {"along": "z", "count": 5, "cover_mm": 5.0}
DEEP = {"count": 3, "cover_mm": 5.0}
SCENE = parse_scene("[path]\nincrements_mm = [[0.1, 0.0], [0.15, 0.05]]")


def design_of(**tables):
    small = {"body": {"width_mm": 12.0, "base_height_mm": 8.0, "arc_radius_mm": 10.0}}
    small |= {"plates": {"count": 4}, "design": {"name": "case"}}
    small["mesh"] = {"section": {"contact_size_mm": 0.2, "plate_size_mm": 0.3}}
    small["mesh"]["section"] |= {"plate_end_size_mm": 0.1, "far_size_mm": 1.5}
    made = {k: small.get(k, {}) | tables.get(k, {}) for k in {*small, *tables}}
    if made["body"].get("shape") == "block":
        del made["body"]["arc_radius_mm"]
    return Design.model_validate(made)


@pytest.mark.parametrize(
    ("plates", "chosen"),
    [
        ({}, (0, 1, 2, 3)),
        ({"rows": [ACROSS]}, (0, 1, 2, 3)),
        ({"rows": [DEEP]}, (0, 1, 2, 3)),
        ({"rows": [DEEP | {"count": 6}]}, (4, 5, 6, 7, 8, 9)),
        ({"along": "z"}, ()),
        ({"along": "z", "rows": [DEEP | {"along": "x"}]}, (4, 5, 6)),
        ({"placement": [[-1.0, 7.0, 0.0], [1.0, 7.0, 0.0]]}, (0, 1)),
        ({"count": 0}, ()),
    ],
)
def test_the_rule_samples_one_row_along_x(plates, chosen):
    assert gage_array(design_of(plates=plates)) == chosen


def test_a_hand_needs_two_gages_and_a_finger_with_one_is_analysed_without():
    assert Case(design_of(plates={"count": 2})).runs_grips
    lone = Case(design_of(plates={"count": 1}), fidelity="plane-strain", fields=False)
    assert not lone.runs_grips
    result = run(lone).result
    assert (result.status, result.grips, result.slip_studies) == ("ok", (), ())
    assert [each.name for each in verdict_view(result).verdicts] == ["contact", "gage signal"]


def test_half_only_where_design_and_scene_mirror():
    aside = parse_scene("[path]\nincrements_mm = [[0.1, 0.0, 0.02]]")
    assert Case(design_of(), SCENE).symmetric
    assert not Case(design_of(), aside).symmetric
    assert not Case(design_of(grip={"plant": "lift", "off_centre_mm": 1.0}), SCENE).symmetric
    assert not Case(design_of(plates={"stagger_mm": 1.0, "span_mm": 4.0}), SCENE).symmetric


@pytest.mark.slow
def test_two_rows_are_read_and_one_is_sampled():
    """All gages are in the increments; slip study and grips see the array alone, and say so."""
    rows = [{"count": 3, "cover_mm": 4.5, "angle_deg": 0.0, "pitch_mm": 3.0}]
    design = design_of(plates={"rows": rows}, grip={"friction_coefficients": [0.5]})
    analysis = run(Case(design, fidelity="plane-strain", fields=False))
    assert len(analysis.result.increments[0].gages) == 7
    assert all(len(study.gage_x_mm) == 4 for study in analysis.slip_studies)
    assert all(trace.gage_readings.shape[1] == 4 for trace in analysis.grip_traces)
    assert any("plates 0 to 3" in reason for reason in analysis.result.model.reasons)


@pytest.mark.slow
def test_a_core_and_a_flat_top_are_analysed_in_plane_strain():
    """A bone under a rounded block: ends well, stiffer than without, says the edge in time."""
    body = {"shape": "block", "edge_radius_mm": 2.0}
    core = {"width_mm": 6.0, "height_mm": 3.0, "bottom_mm": 2.0}
    scene = parse_scene(
        '[path]\nincrements_mm = [[0.02, 0.0]]\n[object]\nshape = "cylinder"\nradius_mm = 15.0'
    )
    forces = []
    for more in ({}, {"core": core}):
        case = Case(design_of(body=body | more), scene, "plane-strain", fields=False)
        forces.append(run(case).result.increments[-1].normal_force_N)
    assert forces[1] > 1.02 * forces[0] > 0.0


def test_the_edge_of_a_turned_body_is_round():
    points = np.array([[6.0, 8.0, 0.0], [4.3, 8.0, 4.3], [4.0, 8.0, 4.0]])
    turned = design_of(body={"shape": "revolved", "depth_mm": 12.0})
    assert _at_side(turned, points).tolist() == [True, True, False]
    assert _at_side(design_of(), points).tolist() == [True, False, False]


def test_what_a_section_cannot_show_and_sheets_without_room_are_refused():
    """Two plates end to end, 0.1 mm apart: as sheets in a section each needs more to itself."""
    plates = {"count": 2, "length_mm": 2.0, "pitch_mm": 2.1, "angle_deg": 0.0, "model": "sheet"}
    with pytest.raises(DesignError) as caught:
        refuse(Case(design_of(plates={"along": "z"}), SCENE, "plane-strain"), SCENE)
    assert [fault.key for fault in caught.value.faults] == ["plates.along"]
    flat = {"shape": "block"}
    for fidelity in ("plane-strain", "3d"):
        close = design_of(body=flat, plates=plates, mesh={"mesher": "sweep"})
        with pytest.raises(DesignError, match=r"plates\.model = sheet.*plate 0 has 0\.05 mm"):
            refuse(Case(close, SCENE, fidelity), SCENE)
        apart = design_of(body=flat, plates=plates | {"pitch_mm": 2.5}, mesh={"mesher": "sweep"})
        refuse(Case(apart, SCENE, fidelity), SCENE)


MOTION = "path.increments_mm = [[0.1, 0.0]]"
FORCES = 'path.control = "force"\npath.increments_{} = [[1.0, 0.0]]'
DOME = 'body.shape = "dome"\nbody.dome_radius_mm = 20.0\nplates.count = 0'
SKETCH = "take --fidelity 3d"


@pytest.mark.parametrize(
    ("text", "scene", "fidelity", "words"),
    [
        ("", MOTION, "3d", ()),
        ("", MOTION, "plane-strain", ()),
        ('mesh.element = "P2"', MOTION, "3d", ()),
        ('mesh.element = "P1"\nmaterials.silicone.poissons_ratio = 0.3', MOTION, "3d", ()),
        ('plates.model = "none"\nplates.count = 0', MOTION, "3d", ()),
        ('mesh.element = "P1"', MOTION, "3d", ("lock at nu = 0.49: forces", "element at auto")),
        ('plates.model = "none"', MOTION, "3d", ("the readings are the rubber's own strains",)),
        # Rows of newtons under millimetres.
        ("", FORCES.format("mm"), "3d", ("path.increments_mm was read as newtons",)),
        ("", FORCES.format("N"), "3d", ()),
        # A section of a finger that changes along z.
        (
            'body.shape = "revolved"\nplates.count = 0',
            MOTION,
            "plane-strain",
            ("the turned body straight along the whole", SKETCH),
        ),
        (DOME, MOTION, "plane-strain", ("forces come out several times too large", SKETCH)),
        (DOME, MOTION, "3d", ()),
        ("plates.span_mm = 4.0", MOTION, "plane-strain", ("takes plates and core as", SKETCH)),
    ],
)
def test_what_a_key_does_is_stated_where_it_may_be_missed(text, scene, fidelity, words):
    scene = parse_scene(scene)
    case = Case(parse_design(f'design.name = "a"\n{text}'), scene, fidelity)
    found = of_choices(case, scene).items()
    stated = [paragraphs(CAVEATS, name, **values)[0] for name, values in found]
    assert len(stated) == bool(words)
    assert all(each in stated[0] for each in words)
