"""A contact of few nodes is meshed finer, or the error names a remedy: never one node."""

from types import SimpleNamespace

import numpy as np
import pytest

from fingerdesign import analyse, parse_design, parse_scene, with_values
from fingerdesign.analysis.case import Case
from fingerdesign.analysis.enough import LEAST_NODES, _candidates, finer
from fingerdesign.analysis.fidelity.choice import Choice
from fingerdesign.contact.problem import Motion
from fingerdesign.errors import SolverError
from fingerdesign.layout.zone import Zone
from tests.support.reduced import reduced_model

DESIGN = parse_design(
    """
    design.name = "coarse"
    plates.count = 0
    mesh.mesher = "sweep"
    mesh.layers = 2
    mesh.contact_size_mm = 1.0
    mesh.section.contact_size_mm = 0.3
    """
)
TINY = 'object = {shape = "cylinder", radius_mm = 0.3}\n'


def solved(text, fidelity="plane-strain", design=DESIGN):
    found = analyse(design, parse_scene(text), fidelity)
    return found, max(row.stick_nodes + row.slip_nodes for row in found.increments)


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        TINY + "path.increments_mm = [[0.003, 0.0]]",
        "object.tilt_deg = 4.0\npath.increments_mm = [[0.002, 0.0]]",  # 1.4 mm off the crest
        'path.control = "force"\npath.increments_N = [[0.02, 0.0]]',
    ],
)
def test_a_small_contact_is_meshed_finer_and_its_force_is_that_of_a_fine_mesh(text):
    """Within 3 %: of about 20 nodes in contact one more or less is 5 % of its width, of which the
    force depends less."""
    found, most = solved(text)
    assert most >= LEAST_NODES
    fine = with_values(DESIGN, {"mesh.section.contact_size_mm": 0.004})
    known, _ = solved(text, design=fine)
    one, other = (each.increments[-1] for each in (found, known))
    assert one.approach_mm == pytest.approx(other.approach_mm, rel=0.03)
    assert one.normal_force_N == pytest.approx(other.normal_force_N, rel=0.03)
    assert any("meshed finer" in reason for reason in found.model.reasons)
    assert found.parameters["mesh.section.contact_size_mm"] == 0.3  # as it was given


@pytest.mark.slow
def test_swept_too():
    _, most = solved(TINY + "path.increments_mm = [[0.01, 0.0]]", "3d")
    assert most >= LEAST_NODES


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("path.control = 'force'\npath.increments_N = [[1e-6, 0.0]]", "press harder"),
        ("object.tilt_deg = 20\npath.increments_mm = [[1e-6, 0.0]]", "press harder"),
    ],
)
def test_what_cannot_be_meshed_fine_enough_is_refused_with_the_remedy(text, remedy):
    with pytest.raises(SolverError, match=rf"nodes at most.*{remedy}"):
        solved(text)


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 13))]
)
def test_extremes_at_random_have_enough_nodes_or_an_error(seed):
    """Tilt to 20 degrees, radii from 0.05 to 20 mm, from micrometres on, bodies of any size."""
    rng = np.random.default_rng(seed)
    scale = 10.0 ** rng.uniform(-0.7, 1.0)
    sizes = {"width_mm": 20.0, "base_height_mm": 10.0, "arc_radius_mm": 20.0, "depth_mm": 10.0}
    values = {f"body.{key}": scale * size for key, size in sizes.items()}
    meshed = {"contact_size_mm": 0.3, "far_size_mm": 1.0}
    values |= {f"mesh.section.{key}": scale * size for key, size in meshed.items()}
    design = with_values(DESIGN, values)
    deep = 10.0 ** rng.uniform(-5.0, -0.5)
    rigid = f"tilt_deg = {rng.uniform(-20.0, 20.0)}"
    if rng.random() < 0.5:
        rigid = f"shape = 'cylinder', radius_mm = {10.0 ** rng.uniform(-1.3, 1.3)}"
    friction = 10.0 ** rng.uniform(-2.0, 1.0)
    text = f"object = {{{rigid}, friction_coefficient = {friction}}}\n"
    remedied, most = "", 0
    try:
        _, most = solved(text + f"path.increments_mm = [[{deep}, 0.0]]", design=design)
    except SolverError as error:
        remedied = str(error)
    assert most >= LEAST_NODES or "press harder" in remedied


SCENE = parse_scene("path.increments_mm = [[0.1, 0.0]]")
KINDS = {2: "plane-strain", 3: "3d"}


def made_finer(closed, dim=2, approach=0.1, attempt=1, mesher="sweep", summary=None):
    """Of nodes at x = 0, 1, 2 (z = 1.5 x in 3-D) that touch, a row of ``closed`` an increment."""
    x = np.arange(len(closed[0]), dtype=float)
    points = np.column_stack([x, x, 1.5 * x][:dim])
    model = reduced_model(points, np.eye(points.size), areas=0.16 * (1.0 + x), depth=1.6)
    given = {"motion": Motion(approach, 0.0)}
    found = [SimpleNamespace(status=np.array(row), **given) for row in closed]
    steps = [SimpleNamespace(increment=each) for each in found]
    mesh = DESIGN.mesh.model_copy(update={"mesher": mesher})
    design = DESIGN.model_copy(update={"mesh": mesh})
    chosen = Choice(Case(design, SCENE, KINDS[dim]), None, Zone(5.0, 7.0), [], summary)
    return finer(chosen, SCENE, SimpleNamespace(model=model), steps, attempt)


def test_edges_are_so_much_finer_as_nodes_lack_and_the_zone_is_what_they_reach():
    """By nodes 1 and 2, two at most at a time, their edges 0.2 and 0.3 mm, in space the roots of
    0.32 and 0.48: the median times 2 / 20; and two edges beyond the farther one."""
    closed = [[0, 1, 0], [0, 1, 1], [0, 0, 0]]
    case, zone = made_finer(closed)
    assert case.design.mesh.section.contact_size_mm == pytest.approx(0.025)
    assert (case.design.mesh.contact_size_mm, zone.half_width) == pytest.approx((1.0, 2.5))
    edge = np.median(np.sqrt([0.32, 0.48]))
    for mesher, share in (("sweep", 0.1), ("tetwild", 0.1**0.5)):
        case, zone = made_finer(closed, 3, mesher=mesher)
        assert case.design.mesh.contact_size_mm == pytest.approx(share * edge)
        assert (zone.half_width, zone.half_depth) == pytest.approx((2 + 2 * edge, 3 + 2 * edge))
    case, zone = made_finer([[0, 0, 0]])  # The first touch is at the crest, x = 0: as of one node.
    assert case.design.mesh.section.contact_size_mm == pytest.approx(0.1 / 16.0)
    assert zone.half_width == pytest.approx(0.2)


def test_what_holds_enough_nodes_stays_and_what_is_not_made_finer_here_is_refused():
    assert made_finer([[0] * 12, [1] * LEAST_NODES + [0] * 4]) is None
    assert made_finer([[1, 0]], approach=0.0) is None
    assert made_finer([[1] * (LEAST_NODES - 1)]) is not None
    file = {"dim": 3, "mesher": "file"}
    refused = {"too many": {"attempt": 4}, "a fidelity": {"summary": "s"}, "file's mesh": file}
    for words, changes in refused.items():
        with pytest.raises(SolverError, match=words):
            made_finer([[0, 1, 1]], **changes)


def test_candidates_are_counted_across_and_along_z():
    z = np.array([0.0, 1.0, 1.0 + 1e-9, 3.0])
    for dim, layered, along in ((2, True, 1), (3, True, 3), (3, False, 6)):
        model = SimpleNamespace(points=np.column_stack([z, z, z][:dim]))
        problem = SimpleNamespace(model=model)
        assert _candidates(problem, Zone(5.0), 0.5, layered) == 20.0 * along
