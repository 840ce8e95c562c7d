"""What a case makes of its design: the gage array that the rule hears, halves, refusals by kind."""

import numpy as np
import pytest

from fingerdesign import parse_scene
from fingerdesign.analysis.analysis import _at_side
from fingerdesign.analysis.case import Case, gage_array
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.summary import _why_whole
from fingerdesign.checks.load import parse_design
from fingerdesign.design.schema import Design, StepFile
from fingerdesign.errors import DesignError
from fingerdesign.pipeline import run

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


def test_half_only_where_design_and_scene_mirror():
    aside = parse_scene("[path]\nincrements_mm = [[0.1, 0.0, 0.02]]")
    assert Case(design_of(), SCENE).symmetric
    assert not Case(design_of(), aside).symmetric
    assert not Case(design_of(plates={"stagger_mm": 1.0, "span_mm": 4.0}), SCENE).symmetric


def test_two_rows_are_read_and_one_is_sampled():
    """All gages are in the increments; slip study and grips see the array alone, and say so."""
    rows = [{"count": 3, "cover_mm": 4.5, "angle_deg": 0.0, "pitch_mm": 3.0}]
    design = design_of(plates={"rows": rows}, grip={"friction_coefficients": [0.5]})
    analysis = run(Case(design, fidelity="plane-strain", fields=False))
    assert len(analysis.result.increments[0].gages) == 7
    assert all(len(study.gage_x_mm) == 4 for study in analysis.slip_studies)
    assert all(trace.gage_readings.shape[1] == 4 for trace in analysis.grip_traces)
    assert any("plates 0 to 3" in reason for reason in analysis.result.model.reasons)


def test_what_a_section_cannot_show_is_refused_by_key():
    along_z = Case(design_of(plates={"along": "z"}), SCENE, "plane-strain")
    with pytest.raises(DesignError) as caught:
        refuse(along_z, SCENE)
    assert [fault.key for fault in caught.value.faults] == ["plates.along"]


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


def test_sheets_without_room_are_refused_before_meshing():
    """Two plates end to end, 0.1 mm apart: as sheets in a section each needs more to itself."""
    plates = {"count": 2, "length_mm": 2.0, "pitch_mm": 2.1, "angle_deg": 0.0, "model": "sheet"}
    flat = {"shape": "block"}
    for fidelity in ("plane-strain", "3d"):
        close = design_of(body=flat, plates=plates, mesh={"mesher": "extrude"})
        with pytest.raises(DesignError, match=r"plates\.model = sheet.*plate 0 has 0\.05 mm"):
            refuse(Case(close, SCENE, fidelity), SCENE)
        apart = design_of(body=flat, plates=plates | {"pitch_mm": 2.5}, mesh={"mesher": "extrude"})
        refuse(Case(apart, SCENE, fidelity), SCENE)


def test_the_reason_for_a_whole_model_is_the_first_that_holds():
    design = parse_design('design.name = "a"')
    assert _why_whole(Case(design)) == "so the mesh in mesh.file is"
    sideways = parse_scene("path.increments_mm = [[0.1, 0.0, 0.1]]")
    assert _why_whole(Case(design, sideways)) == "object or path does not mirror in z = 0"
    shifted = parse_design('design.name = "a"\nplates.span_mm = 4.0\nplates.span_offset_mm = 1.0')
    assert _why_whole(Case(shifted, sideways)) == "the plates do not mirror in z = 0"
    step = StepFile(file="a.step", mirrors_in_z=False)
    body = shifted.body.model_copy(update={"shape": "step", "step": step})
    own = shifted.model_copy(update={"body": body})
    assert _why_whole(Case(own)) == "body.step.mirrors_in_z is false"
