"""The ladder on made-up answers: what it tries, skips, takes, and says."""

from dataclasses import dataclass

import numpy as np
import pytest

from fingerdesign import parse_design, parse_scene
from fingerdesign.analysis.case import Case
from fingerdesign.analysis.fidelity.estimate import ORDERS, difference, discretisation, of_most
from fingerdesign.analysis.fidelity.ladder import climb
from fingerdesign.analysis.fidelity.models import Model
from fingerdesign.analysis.fidelity.readings import Readings, errors
from fingerdesign.analysis.fidelity.rungs import (
    SPACE_SCALES,
    can_be_section,
    can_extrude,
    layers,
    rung,
    scene_sizes,
)
from fingerdesign.analysis.forecast.counts import count_model
from fingerdesign.checks.load import with_values
from fingerdesign.layout.layers import layered
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.make import mesh_finger, mesher_name

DESIGN = parse_design('design.name = "made_up"\nplates.count = 0')
SCENE = parse_scene("[object]\n[path]\nincrements_mm = [[0.1, 0.0], [0.1, 0.05]]")
PLATED = parse_design('design.name = "plated"\nplates.count = 2')


@dataclass
class Answer:
    model: Model
    readings: Readings
    dofs: int = 1000
    contact_nodes: int = 10
    total: float = 1.0


ORDER = ORDERS["normal_force"]


class Law:
    """Answers that are off by ``error`` scale^ORDER; plane strain by ``price`` besides."""

    def __init__(self, error, price, dofs=1000):
        self.error, self.price, self.dofs = error, price, dofs
        self.tried: list[tuple[str, float]] = []

    def __call__(self, design, scene, model):
        scale = model.sizes.contact_size_mm / scene_sizes(design, scene, 1.0).contact_size_mm
        flat = model.dimension == "plane strain"
        self.tried.append((model.dimension, round(scale, 3)))
        force = np.array([1.0, 2.0]) * (1.0 + self.error * scale**ORDER + self.price * flat)
        none = np.zeros(2)
        readings = Readings(force, none, none, none, np.empty((2, 0, 2)))
        return Answer(model, readings, round(self.dofs * scale**-2.5))


def test_plane_strain_is_taken_where_it_does():
    law = Law(1e-4, 0.01)
    found = climb(DESIGN, SCENE, 0.05, law)
    assert found.reached
    assert found.chosen.model.dimension == "plane strain"
    assert found.estimate.worst == pytest.approx(0.01, rel=0.2)
    assert found.tried[-1].why.startswith("enough: F_n within")
    assert sum(dimension == "3-D" for dimension, _ in law.tried) == 1


def test_space_is_climbed_where_plane_strain_does_not_do():
    law = Law(0.01, 0.3)
    found = climb(DESIGN, SCENE, 0.02, law)
    assert found.reached
    assert found.chosen.model.dimension == "3-D"
    scale = found.chosen.model.sizes.contact_size_mm / scene_sizes(DESIGN, SCENE, 1).contact_size_mm
    assert found.estimate.worst == pytest.approx(0.01 * scale**ORDER, rel=0.05)
    assert found.seconds == len(law.tried)
    assert "29 % here (F_n), target 2 %: given up" in found.tried[1].why
    law = Law(0.02, 0.3)
    climb(DESIGN, SCENE, 0.01, law)  # sizes that cannot do are skipped
    assert [scale for dimension, scale in law.tried if dimension == "3-D"] == [4.0, 2.8, 0.7]


@pytest.mark.parametrize(
    ("most", "finest", "words"),
    [(350_000, 0.7, "no finer size"), (1500, 1.0, "ladder's 1500"), (500, 1.4, "ladder's 500")],
)
def test_the_end_of_the_ladder_says_why(most, finest, words):
    law = Law(0.5, 0.3)
    found = climb(DESIGN, SCENE, 0.001, law, most_dofs=most)
    assert not found.reached
    assert found.chosen.model.dimension == "3-D"
    assert "not enough" in found.tried[-1].why
    assert words in found.why_ended
    assert min(scale for _, scale in law.tried) == finest


def test_a_scene_outside_the_section_is_not_tried_in_plane_strain():
    ball = parse_scene(
        '[object]\nshape = "sphere"\nradius_mm = 9.0\n[path]\nincrements_mm = [[0.1, 0.0]]'
    )
    domed = parse_design(
        'design.name = "d"\nbody.shape = "dome"\nbody.dome_radius_mm = 12.0\nplates.count = 0'
    )
    assert can_be_section(DESIGN, SCENE)
    assert not can_be_section(DESIGN, ball)
    assert not can_be_section(domed, SCENE)
    law = Law(0.01, 0.0)
    climb(DESIGN, ball, 0.05, law)
    assert {dimension for dimension, _ in law.tried} == {"3-D"}


def test_sizes_follow_the_scene():
    deep = parse_scene("[object]\n[path]\nincrements_mm = [[0.4, 0.0]]")
    assert (
        scene_sizes(DESIGN, deep, 1.0).contact_size_mm
        > 1.5 * scene_sizes(DESIGN, SCENE, 1.0).contact_size_mm
    )
    nothing = parse_scene("[object]\n[path]\nincrements_mm = [[1e-9, 0.0]]")
    assert scene_sizes(DESIGN, nothing, 1.0).contact_size_mm > 1e-3 * DESIGN.body.width_mm
    sizes = scene_sizes(PLATED, SCENE, 1.0)
    assert sizes.plate_end_size_mm < sizes.plate_size_mm <= sizes.far_size_mm
    twice = scene_sizes(PLATED, SCENE, 2.0).plate_end_size_mm
    assert twice == pytest.approx(2.0 * sizes.plate_end_size_mm)
    wide = parse_design('design.name = "w"\nplates.count = 0\nbody.depth_mm = 60.0')
    assert layers(wide, 1.0) > layers(DESIGN, 1.0) >= 2
    assert [rung(PLATED, SCENE, "3-D", s).plates for s in SPACE_SCALES[:2]] == ["sheet", None]
    assert rung(PLATED, SCENE, "3-D", 1.0).mesher == "sweep"


def test_parts_that_end_at_nearly_one_height_are_not_swept_through_layers():
    keys = (
        'design.name = "n"\nbody.base_height_mm = 8.0\nplates.count = 1\nplates.span_mm = 2.0\n'
        "body.core = {{ width_mm = 4.0, height_mm = 1.0, depth_mm = {} }}"
    )
    near = parse_design(keys.format(2.002))
    assert layered(near)
    assert not can_extrude(near)
    far = parse_design(keys.format(4.0))
    assert can_extrude(far)
    auto = [with_values(each, {"mesh.mesher": "auto"}) for each in (near, far)]
    assert [mesher_name(each) for each in auto] == ["tetwild", "sweep"]
    counts = [
        count_model(Case(each, SCENE), Zone(2.0))
        for each in (auto[1], with_values(far, {"mesh.mesher": "sweep"}))
    ]
    assert counts[0] == counts[1]
    assert mesh_finger(auto[1], Zone(2.0)).mesher == "sweep"
    assert rung(near, SCENE, "3-D", 1.0).mesher == near.mesh.mesher


def test_a_size_that_refines_nothing_judges_nothing():
    class Stuck(Law):
        """Sizes from 4 to 2.8 give the same mesh."""

        def __call__(self, design, scene, model):
            found = super().__call__(design, scene, model)
            if self.tried[-1][1] > 2.5:
                found.dofs, found.readings = 100, self.first
            return found

        first = Readings(np.array([1.5, 3.0]), *[np.zeros(2)] * 3, np.empty((2, 0, 2)))

    found = climb(DESIGN, SCENE, 0.05, Stuck(0.01, 3.0))
    words = [each.why for each in found.tried if each.dimension == 3]
    assert words[1].startswith("hardly finer")
    assert found.tried[0].dofs == 100
    assert (
        found.chosen.model.sizes.contact_size_mm
        < 2.5 * scene_sizes(DESIGN, SCENE, 1.0).contact_size_mm
    )


def readings(normal=(1.0, 2.0), tangential=(0.0, 1.0), stick=(1.0, 0.5), gages=None, face="both"):
    both = np.array([[[10.0, -10.0], [4.0, 6.0]], [[20.0, 0.0], [1.0, 1.0]]])
    return Readings(
        np.array(normal),
        np.array(tangential),
        np.array([1.0, 2.0]),
        np.array(stick),
        both if gages is None else np.array(gages),
        face,
    )


def test_errors_are_relative_to_what_the_contract_says():
    found = readings(normal=(1.1, 2.1), tangential=(0.01, 1.02), stick=(0.9, 0.52))
    off = errors(found, readings())
    np.testing.assert_allclose(off["normal_force"], [0.1, 0.05])
    np.testing.assert_allclose(off["tangential_force"], [0.01, 0.02])  # of the readings's largest
    np.testing.assert_allclose(off["stick_ratio"], [0.1, 0.02])  # absolute
    np.testing.assert_allclose(off["gage"], 0.0)
    gages = readings(gages=readings().gages + 1.0)
    np.testing.assert_allclose(errors(gages, readings())["gage"], [[0.2, 0.2], [0.1, 0.1]])
    with pytest.raises(ValueError, match="2 and 1 rows"):
        errors(readings(), readings().part(slice(1)))
    bare = readings(gages=np.empty((2, 0, 2)))
    assert errors(bare, bare)["gage"].size == 0
    assert difference(bare, bare).worst == 0.0
    for face, read in (
        ("both", [[0.0, 5.0], [10.0, 1.0]]),
        ("upper", [[10.0, 4.0], [20.0, 1.0]]),
        ("lower", [[-10.0, 6.0], [0.0, 1.0]]),
    ):
        np.testing.assert_allclose(readings(face=face).reading, read)


def test_richardson_finds_the_error_of_a_power_law_of_most_readings():
    exact = readings()
    coarse = readings(normal=(1.0 + 2.0 ** ORDERS["normal_force"] * 0.01, 2.0))
    fine = readings(normal=(1.01, 2.0))
    estimate = discretisation(fine, coarse, 2.0).by_quantity["normal_force"]
    truth = difference(fine, exact).by_quantity["normal_force"]
    assert estimate == pytest.approx(truth, rel=0.02)  # relative to the fine answer, not the exact
    with pytest.raises(ValueError, match="ratio"):
        discretisation(fine, coarse, 1.0)
    assert of_most(np.r_[np.zeros(99), 1.0]) == of_most(np.empty(0)) == 0.0
    assert of_most(np.linspace(0.0, 1.0, 101)) == pytest.approx(0.95)
