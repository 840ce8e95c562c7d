"""The ladder on made-up answers: what it tries, skips, takes, and says."""

from dataclasses import dataclass

import numpy as np
import pytest

from fingerdesign import parse_design, parse_scene
from fingerdesign.analysis.fidelity.ladder import ORDERS, climb
from fingerdesign.analysis.fidelity.models import Model
from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.analysis.fidelity.rungs import (
    SPACE_SCALES,
    can_be_section,
    can_extrude,
    layers,
    rung,
    scene_sizes,
)
from fingerdesign.errors import DesignError
from fingerdesign.layout.gaps import layered

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
        scale = model.sizes.contact / scene_sizes(design, scene, 1.0).contact
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
    truth = (
        0.01 * (found.chosen.model.sizes.contact / scene_sizes(DESIGN, SCENE, 1).contact) ** ORDER
    )
    assert found.estimate.worst == pytest.approx(truth, rel=0.05)
    assert found.seconds == len(law.tried)
    assert "never taken" in found.tried[1].why  # the formulas'
    assert "29 % here (F_n), 2 % asked: given up" in found.tried[2].why


def test_sizes_that_cannot_do_are_skipped():
    law = Law(0.02, 0.3)
    climb(DESIGN, SCENE, 0.01, law)
    space = [scale for dimension, scale in law.tried if dimension == "3-D"]
    assert space == [4.0, 2.8, 0.7]


def test_the_end_of_the_ladder_is_said():
    found = climb(DESIGN, SCENE, 0.001, Law(0.5, 0.3))
    assert not found.reached
    assert found.chosen.model.dimension == "3-D"
    assert "not enough" in found.tried[-1].why


def test_no_model_beyond_the_limit_of_equations_is_tried():
    law = Law(0.5, 0.3)
    found = climb(DESIGN, SCENE, 0.001, law, most_dofs=1500)
    assert not found.reached
    assert min(scale for _, scale in law.tried) == 1.0


@pytest.mark.parametrize("tolerance", [0.0, -1.0, 2.0, float("nan")])
def test_a_tolerance_out_of_range_is_refused(tolerance):
    with pytest.raises(DesignError, match="--tolerance"):
        climb(DESIGN, SCENE, tolerance, Law(0.1, 0.1))


def test_a_scene_beside_the_section_is_not_tried_in_plane_strain():
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
    assert scene_sizes(DESIGN, deep, 1.0).contact > 1.5 * scene_sizes(DESIGN, SCENE, 1.0).contact
    sizes = scene_sizes(PLATED, SCENE, 1.0)
    assert sizes.end < sizes.plate <= sizes.far
    assert scene_sizes(PLATED, SCENE, 2.0).end == pytest.approx(2.0 * sizes.end)
    wide = parse_design('design.name = "w"\nplates.count = 0\nbody.depth_mm = 60.0')
    assert layers(wide, 1.0) > layers(DESIGN, 1.0) >= 2
    assert [rung(PLATED, SCENE, "3-D", s).plates for s in SPACE_SCALES[:2]] == ["sheet", None]
    assert rung(PLATED, SCENE, "3-D", 1.0).mesher == "extrude"


def test_parts_that_end_at_nearly_one_height_are_not_swept_through_layers():
    keys = (
        'design.name = "n"\nbody.base_height_mm = 8.0\nplates.count = 1\nplates.span_mm = 2.0\n'
        "body.core = {{ width_mm = 4.0, height_mm = 1.0, depth_mm = {} }}"
    )
    near = parse_design(keys.format(2.002))
    assert layered(near)
    assert not can_extrude(near)
    assert can_extrude(parse_design(keys.format(4.0)))
    assert rung(near, SCENE, "3-D", 1.0).mesher == near.mesh.mesher


def test_a_scene_that_hardly_touches_has_sizes_of_the_finger():
    nothing = parse_scene("[object]\n[path]\nincrements_mm = [[1e-9, 0.0]]")
    assert scene_sizes(DESIGN, nothing, 1.0).contact > 1e-3 * DESIGN.body.width_mm


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
    assert found.chosen.model.sizes.contact < 2.5 * scene_sizes(DESIGN, SCENE, 1.0).contact


def test_an_end_before_the_tolerance_says_why():
    found = climb(DESIGN, SCENE, 0.001, Law(0.5, 0.3), most_dofs=500)
    assert "over the ladder's 500" in found.why_ended
    assert "no finer size" in climb(DESIGN, SCENE, 0.001, Law(0.5, 0.3)).why_ended
