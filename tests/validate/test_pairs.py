"""Which two models each assumption is judged by, and what its row says of them: none is solved."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fingerdesign import load_design, parse_scene, with_values
from fingerdesign.analysis.fidelity.readings import QUANTITIES, Readings
from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.problem import Motion
from fingerdesign.errors import SolverError
from fingerdesign.validate.assumptions import ASSUMPTIONS, NotTestable
from fingerdesign.validate.comparison import answer_of, compare
from fingerdesign.validate.page import _cost_table, _errors_table
from fingerdesign.validate.record import ComparisonData, Side, Spread, _cells
from fingerdesign.validate.run import _chosen, _failure, _row
from fingerdesign.validate.solves import Reader, Solves, _warm

SCENE = parse_scene("path.increments_mm = [[0.1, 0.0], [0.1, 0.05]]")
ASIDE = parse_scene("path.increments_mm = [[0.1, 0.0, 0.1]]")
FINGER = load_design("maeno2000")
PAIRS = {each.key: each.pairs for each in ASSUMPTIONS}


def solved(name, force=1.0):
    """A model of this name that answers two rows."""
    two = np.array([1.0, 2.0])
    readings = Readings(force * two, two, two, 0.2 * two, np.ones((2, 1, 2)))
    cost = {"total": 3.0, "dofs": 9, "mesh": SimpleNamespace(dimension=3), "along": None}
    model = SimpleNamespace(name=name)
    return SimpleNamespace(model=model, readings=readings, steps=[], scene=SCENE, **cost)


class Named:
    """Stands in for the solves: models have what was requested of them for a name."""

    def __init__(self, design, scene=SCENE):
        self.design, self.scene, self.scale = design, scene, 2.0

    def space(self, finer=1.0, values=None, plates=None):
        return solved(f"space {finer:g} {values or {}} {plates}")

    def section(self, scale=1.4, values=None, plates=None):
        return solved(f"section {scale:g} {plates}")

    def in_single_increments(self, model):
        return solved(f"{model.model.name} by rows")

    def finite(self, model):
        return answer_of(model, f"{model.model.name}, finite")

    def warmer(self, kelvin):
        return answer_of(solved(f"{kelvin:g} K warmer"))

    def reader(self):
        own = self.space()
        return SimpleNamespace(solved=own, own=own.readings, read=self.read)

    def read(self, gages):
        self.gage = (gages.length_mm, gages.width_mm, gages.z_mm)
        return self.space().readings


OWN = "space 1 {} None"
SPAN = {"plates.span_mm": None, "plates.span_offset_mm": 0.0, "plates.stagger_mm": 0.0}
SHEETS = with_values(FINGER, {"plates.model": "sheet", "mesh.mesher": "sweep"})
SHORT = with_values(FINGER, {"plates.span_mm": 4.0})
SOFT = with_values(FINGER, {"materials.silicone.poissons_ratio": 0.45})
DEEP = [f"{one} solid by rows" for one in ("section 1.4", "space 1 {}")]


@pytest.mark.parametrize(
    ("key", "design", "expected"),
    [
        ("plane_strain", FINGER, [("plane strain", "3-D")]),
        ("plate_span", FINGER, [(OWN, "space 1 {'plates.span_mm': 5.0} None")]),
        ("plate_span", SHORT, [(f"space 1 {SPAN} None", OWN)]),
        ("poissons_ratio", FINGER, [(f"nu {nu} for 0.49", OWN) for nu in (0.45, 0.4999)]),
        ("poissons_ratio", SOFT, [("nu 0.4999 for 0.45", OWN)]),
        ("youngs_modulus", FINGER, [(f"E {e} for 4.96 MPa", OWN) for e in (3.968, 5.952)]),
        ("relaxation", FINGER, [("0.75 times fresh rubber's", "rubber of 3.72 MPa")]),
        ("temperature", FINGER, [("10 K warmer", OWN)]),
        ("sheets", FINGER, [("space 1 {} sheet", OWN)]),
        ("sheets", SHEETS, [("space 1 {} sheet", "space 1 {} solid")]),
        ("plates_left_out", SHEETS, [("space 1 {} none", "space 1 {} solid")]),
        (*("discretisation", FINGER), [("section 1.4 None", "section 0.7 None"), (OWN, OWN)]),
        ("small_strain", SHEETS, [(each, f"{each}, finite") for each in DEEP]),
        ("gage_point", FINGER, [("a point", "mean over 0.5 x 1 mm")]),
    ],
)
def test_what_assumes_is_held_against_the_better_model(key, design, expected):
    expected = [(a, b.replace(" 1 ", " 0.7 ") if a == b else b) for a, b in expected]
    found = PAIRS[key](Named(design), True)
    assert [(each.assumed.model, each.better.model) for each in found] == expected


def test_gages_are_read_wider_and_smaller_and_relaxed_forces_are_scaled():
    aside = with_values(FINGER, {"gages.z_mm": 1.0})
    for key, read in (("gage_depth_average", (0.5, 10.0, 0.0)), ("gage_point", (0.025, 0.05, 1.0))):
        named = Named(aside)
        PAIRS[key](named, False)
        assert named.gage == pytest.approx(read)
    (relaxed,) = PAIRS["relaxation"](named, False)
    assert relaxed.assumed.normal_force_N == pytest.approx([0.75, 1.5])
    assert [len(PAIRS["small_strain"](Named(FINGER), deep)) for deep in (False, True)] == [1, 2]
    assert len(PAIRS["small_strain"](Named(FINGER, ASIDE), True)) == 1


def test_what_cannot_tell_says_why():
    bare = with_values(FINGER, {"plates.count": 0})
    gaged = ("gage_depth_average", "gage_point", "leads", "temperature")
    no_plates = (*gaged, "plate_span", "sheets", "plates_left_out")
    cases = [(key, bare, SCENE, "no plates") for key in no_plates]
    cases += [(key, FINGER, ASIDE, "three dim") for key in ("plane_strain", "small_strain")]
    cases.append(("temperature", SHEETS, SCENE, "solid plates"))
    left_out = with_values(FINGER, {"plates.model": "none"})
    cases += [(key, left_out, SCENE, "left out") for key in ("plate_span", "leads")]
    cases.append(("plate_span", load_design("domed"), SCENE, "straight bodies"))
    for key, design, scene, why in cases:
        with pytest.raises(NotTestable, match=why):
            PAIRS[key](Named(design, scene), False)


def side(k):
    every = {name: Spread(0.1 * k, 0.01 * k) for name in QUANTITIES}
    return Side(10 - k, k, f"note {k}", every, (0.1 * k, 0.2))


def comparison(k, seconds, better, **changes):
    one, other = (replace(answer_of(solved("a")).data(), seconds=s) for s in (seconds, better))
    given = {"equal_motion": side(k), "equal_force": side(k + 1), "missing": ("why",)} | changes
    return ComparisonData(f"{k}", one, other, **given)


def row_of(kind, *comparisons):
    of, failed = replace(ASSUMPTIONS[0], kind=kind, pairs=lambda *_: list(comparisons)), []
    row = _row(of, Named(FINGER), False, failed)
    assert bool(failed) != row.tested
    return row


def test_a_row_has_the_cost_of_the_dearest_comparison_and_the_worst_of_all():
    both = comparison(1, 2.0, 30.0), comparison(3, 7.0, 20.0)
    row, value = row_of("model", *both), row_of("value", *both)
    motion = row.equal_motion
    assert (motion.rows, motion.rows_left_out, motion.note) == (7, 3, "note 1; note 3")
    assert motion.gages == pytest.approx((0.3, 0.2))
    numbers = ("40.00 (4.00)",) * 3 + ("0.400 (0.040)", "40.00 (4.00)", "6", "4")
    assert _errors_table([row], "equal_force").rows[0][2:] == numbers
    cells = [_cells(row, at)[-5:-1] for at in ("equal_motion", "equal_force")]
    assert cells == [pytest.approx([0.1 * k, 0.01 * k, 10 - k, k]) for k in (3, 4)]
    costs = [each[4:] for each in _cost_table([row, value]).rows]
    assert costs == [("2.00", "30.00", "15.0"), ("30.00", "–", "–")]
    half = row_of("model", comparison(1, 1.0, 1.0, equal_motion=None))
    assert half.tested
    assert _errors_table([half], "equal_motion").rows[0][2:] == ("–",) * 7
    none = row_of("model", comparison(1, 1.0, 1.0, equal_motion=None, equal_force=None))
    assert none.reason == "why"
    assert _failure([none], [none]).endswith("Plane strain: why")
    assert _failure([none, row], [none]) is None
    assert [each.key for each in _chosen(["leads", "sheets"])] == ["sheets", "leads"]
    assert _chosen([]) == ASSUMPTIONS


class Counted(Solves):
    """Solves whose models are what they were asked for; sections fail."""

    def _solve(self, of):
        if of.dimension != "3-D":
            raise SolverError("no section")
        return solved(of)


def test_each_model_is_solved_once_and_one_that_failed_is_not_tried_again():
    solves = Counted(FINGER, SCENE, (told := []).append)
    solves.scale = 2.0
    ways = [{}, {"finer": 0.7}, {"values": {"plates.count": 3}}, {"plates": "sheet"}]
    found = [solves.space(**way) for way in ways]
    assert all(solves.space(**way) is one for way, one in zip(ways, found, strict=True))
    assert [each.model.name.scale for each in found] == pytest.approx([2.0, 1.4, 2.0, 2.0])
    for _ in range(2):
        with pytest.raises(SolverError, match="no section"):
            solves.section()
    assert len(told) == 5


def test_a_long_path_is_read_in_even_rows_and_a_warm_one_is_warm_all_along():
    built = SimpleNamespace(displacement_fields=lambda forces: forces)
    steps = [SimpleNamespace(increment=SimpleNamespace(force=np.full(2, k))) for k in range(127)]
    reader = Reader(SimpleNamespace(built=built, steps=steps))
    assert reader.rows == reader._fields[:, 0].tolist() == list(range(0, 127, 2))
    assert _warm(ASIDE.path, 5.0) == [Motion(0.1, 0.0, 0.1, load=5.0)]
    (force,) = _warm(parse_scene(FORCES).path, 5.0)[:1]
    assert force == Forces(1.0, 0.1, Motion(0.0, 0.0, load=5.0))


FORCES = 'path = {control = "force", increments_N = [[1.0, 0.1], [2.0, 0.2]], substeps = 3}'


def test_a_path_of_forces_is_followed_by_the_better_model_s_motions():
    paths, motions = [], (Motion(0.1, 0.0), Motion(0.2, 0.1))

    def along(scene):
        paths.append(scene.path)
        return solved("").readings

    truth = replace(answer_of(solved("truth")), motions=motions)
    found = replace(answer_of(solved("found", 1.5)), motions=motions[::-1], along=along)
    compared = compare("x", found, truth, parse_scene(FORCES))
    (path,) = paths
    assert (path.increments_mm, path.substeps) == (((0.1, 0.0), (0.2, 0.1)), 3)
    assert compared.equal_motion.errors["normal_force"].greatest == 0.0
    assert compared.equal_force.errors["normal_force"] is None
