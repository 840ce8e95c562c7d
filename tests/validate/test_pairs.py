"""Which two models each assumption is judged by, and what its row says of them: none is solved."""

from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

from fingerdesign import load_design, parse_scene, with_values
from fingerdesign.analysis.fidelity.models import Solved
from fingerdesign.analysis.fidelity.readings import QUANTITIES, Readings
from fingerdesign.errors import SolverError
from fingerdesign.validate import solves as solves_module
from fingerdesign.validate.assumptions import ASSUMPTIONS, NotTestable
from fingerdesign.validate.comparison import answer_of
from fingerdesign.validate.page import _cost_table, _errors_table, _greatest
from fingerdesign.validate.record import ComparisonData, Side, Spread, _cells
from fingerdesign.validate.run import _failure, _row
from fingerdesign.validate.solves import Solves

SCENE = parse_scene("path.increments_mm = [[0.1, 0.0], [0.1, 0.05]]")
ASIDE = parse_scene("path.increments_mm = [[0.1, 0.0, 0.1]]")
FINGER = load_design("maeno2000")
PAIRS = {each.key: each.pairs for each in ASSUMPTIONS}


def solved(name):
    two = np.array([1.0, 2.0])
    readings = Readings(two, two, two, 0.2 * two, np.ones((2, 1, 2)))
    cost = {"total": 3.0, "dofs": 9, "mesh": SimpleNamespace(dimension=3), "along": None}
    of = {"model": SimpleNamespace(name=name), "scene": SCENE, "steps": []}
    return SimpleNamespace(**of, **cost, readings=readings)


class Named:
    def __init__(self, design, scene=SCENE):
        self.design, self.scene, self.scale, self.changed = design, scene, 2.0, []
        self.in_single_increments = lambda model: solved(f"{model.model.name} by rows")
        self.finite = lambda model: answer_of(model, f"{model.model.name}, finite")
        self.warmer = lambda kelvin: answer_of(solved(f"{kelvin:g} K warmer"))

    def space(self, finer=1.0, values=None, plates=None):
        self.changed += [values] if values else []
        return solved(f"space {finer:g} {values or {}} {plates}")

    def section(self, scale=1.4, values=None, plates=None):
        return solved(f"section {scale:g} {plates}")


OWN = "space 1 {} None"
SPAN = {"plates.span_mm": None, "plates.span_offset_mm": 0.0, "plates.stagger_mm": 0.0}
SHEETS = with_values(FINGER, {"plates.model": "sheet", "mesh.mesher": "sweep"})
SHORT = with_values(FINGER, {"plates.span_mm": 4.0})
DEEP = [f"{one} solid by rows" for one in ("section 1.4", "space 1 {}")]
FROM_FILE = FINGER.model_copy(update={"mesh": FINGER.mesh.model_copy(update={"mesher": "file"})})
FINER = [("section 1.4 None", "section 0.7 None"), (OWN, "space 0.7 {} None")]


@pytest.mark.parametrize(
    ("key", "design", "expected"),
    [
        ("plane_strain", FINGER, [("plane strain", "3-D")]),
        ("plate_span", FINGER, [(OWN, "space 1 {'plates.span_mm': 5.0} None")]),
        ("plate_span", SHORT, [(f"space 1 {SPAN} None", OWN)]),
        ("poissons_ratio", FINGER, [(f"nu {nu} for 0.49", OWN) for nu in (0.45, 0.4999)]),
        ("youngs_modulus", FINGER, [(f"E {e} for 4.96 MPa", OWN) for e in (3.968, 5.952)]),
        ("relaxation", FINGER, [("0.75 times fresh rubber's", "rubber of 3.72 MPa")]),
        ("temperature", FINGER, [("10 K warmer", OWN)]),
        ("discretisation", FROM_FILE, FINER[:1]),
        ("sheets", SHORT, [("section 1.4 sheet", "section 1.4 None")]),
        ("sheets", FINGER, [("space 1 {} sheet", OWN)]),
        ("sheets", SHEETS, [("space 1 {} sheet", "space 1 {} solid")]),
        ("plates_left_out", SHEETS, [("space 1 {} none", "space 1 {} solid")]),
        ("discretisation", FINGER, FINER),
        ("small_strain", SHEETS, [(each, f"{each}, finite") for each in DEEP]),
    ],
)
def test_what_assumes_is_held_against_the_better_model(key, design, expected):
    found = PAIRS[key](Named(design), True)
    assert [(each.assumed.model, each.better.model) for each in found] == expected
    forces = [0.75, 1.5] if key == "relaxation" else [1.0, 2.0]
    assert found[0].assumed.normal_force_N == pytest.approx(forces)


def test_what_cannot_tell_says_why():
    values = {"plates.count": 0}, {"plates.model": "none"}
    bare, left_out = (with_values(FINGER, each) for each in values)
    gaged = ("gage_depth_average", "gage_point", "leads", "temperature")
    cases = [(key, bare, SCENE, "no plates") for key in (*gaged, "plate_span", "plates_left_out")]
    cases += [(key, FINGER, ASIDE, "three dim") for key in ("plane_strain", "small_strain")]
    cases += [(key, left_out, SCENE, "left out") for key in ("plate_span", "leads")]
    own = {"youngs_modulus_MPa": 7e4, "poissons_ratio": 0.3}
    cored = {"materials.own": own, "body.core.material": "own"}
    dome, cored = load_design("domed"), with_values(load_design("boned"), cored)
    cases.append(("temperature", cored, SCENE, "of the core is not given"))
    cases += [("temperature", SHEETS, SCENE, "solid pl"), ("plate_span", dome, SCENE, "straight")]
    for key, design, scene, why in cases:
        with pytest.raises(NotTestable, match=why):
            PAIRS[key](Named(design, scene), False)


def comparison(k, seconds, better, **changes):
    one, other = (replace(answer_of(solved("a")).data(), seconds=s) for s in (seconds, better))
    every = [dict.fromkeys(QUANTITIES, Spread(0.1 * n, 0.01 * n)) for n in (k, k + 1)]
    sides = [Side(10 - n, n, f"note {n}", every[n - k], (0.1 * n, 0.2)) for n in (k, k + 1)]
    given = {"equal_motion": sides[0], "equal_force": sides[1], "missing": ("why",)}
    return ComparisonData(f"{k}", one, other, **given | changes)


def row_of(kind, *comparisons):
    of, failed = replace(ASSUMPTIONS[0], kind=kind, pairs=lambda *_: list(comparisons)), []
    row = _row(of, Named(FINGER), False, failed)
    assert bool(failed) != row.tested
    return row


def test_a_row_has_the_cost_of_the_dearest_comparison_and_the_worst_of_all():
    both = comparison(1, 2.0, 30.0), comparison(3, 7.0, 20.0)
    row, value = row_of("model", *both), row_of("value", *both)
    assert row.equal_motion.note == "note 1; note 3"
    assert row.equal_motion.gages == pytest.approx((0.3, 0.2))
    numbers = ("40.00 (4.00)",) * 3 + ("0.400 (0.040)", "40.00 (4.00)", "6", "4")
    assert _errors_table([row], "equal_force").rows[0][2:] == numbers
    assert _greatest(row, ("equal_motion", "equal_force"), ["gage"]) == pytest.approx(0.4)
    cells = [_cells(row, at)[-5:-1] for at in ("equal_motion", "equal_force")]
    assert cells == [pytest.approx([0.1 * k, 0.01 * k, 10 - k, k]) for k in (3, 4)]
    costs = [each[4:] for each in _cost_table([row, value]).rows]
    assert costs == [("2.00", "30.00", "15.0"), ("30.00", "–", "–")]
    half = row_of("model", comparison(1, 1.0, 1.0, equal_motion=None))
    none = row_of("model", comparison(1, 1.0, 1.0, equal_motion=None, equal_force=None))
    assert (half.tested, none.reason) == (True, "why")
    assert _failure([none], [none]).endswith("Plane strain: why")
    assert _failure([none, row], [none]) is None


def test_each_model_is_solved_once():
    solves = Solves(FINGER, SCENE, (told := []).append)
    solves.scale, solves._solve = 2.0, solved
    ways = [{}, {"finer": 0.7}, {"values": {"plates.count": 3}}, {"plates": "sheet"}]
    found = [solves.space(**way).model.name.scale for way in 2 * ways]
    assert (found, len(told)) == (2 * [2.0, pytest.approx(1.4), 2.0, 2.0], 4)


def test_what_varies_is_the_bodys_own_value_and_none_that_it_has():
    modulus, ratio = (
        f"materials.silicone.{key}" for key in ("youngs_modulus_MPa", "poissons_ratio")
    )
    likely = with_values(FINGER, {ratio: 0.45})
    cases = [("relaxation", FINGER, modulus, [3.72]), ("poissons_ratio", likely, ratio, [0.4999])]
    for key, design, name, values in (*cases, ("youngs_modulus", FINGER, modulus, [3.968, 5.952])):
        PAIRS[key](named := Named(design), False)
        assert named.changed == [{name: pytest.approx(each)} for each in values], key


def test_gages_are_read_as_a_point_and_over_the_least_span():
    rows = [{"count": 2, "cover_mm": 4.0, "span_mm": 6.0}]
    named, read = Named(with_values(FINGER, {"gages.z_mm": 1.0, "plates.rows": rows})), []
    one, own = solved("space"), named.design.gages
    named.reader = lambda: SimpleNamespace(
        solved=one, own=one.readings, read=lambda gages: read.append(gages) or one.readings.times(2)
    )
    for key in ("gage_point", "gage_depth_average"):
        (pair,) = PAIRS[key](named, False)
        assert pair.assumed.gages_microstrain == [[2.0], [2.0]]
        assert pair.better.gages_microstrain == [[1.0], [1.0]]
    point, wide = ((each.length_mm, each.width_mm, each.z_mm) for each in read)
    assert point == (0.05 * own.length_mm, 0.05 * own.width_mm, 1.0)
    assert wide == (own.length_mm, 6.0, 0.0)


def test_a_model_that_failed_fails_again_unsolved():
    solves, error = Solves(FINGER, SCENE, (told := []).append), SolverError("no equilibrium")
    for _ in range(2):
        with pytest.raises(SolverError, match="no equilibrium"):
            solves._kept("a", "solving", Mock(side_effect=error))
    assert len(told) == 1


def test_a_row_takes_one_increment_where_the_scene_leaves_it_open(half_plane, calls_of):
    steps = calls_of(solves_module, "follow_path")
    for own, substeps in (("", 1), ("path.substeps = 3", 3)):
        scene = parse_scene(f"path.increments_mm = [[0.05, 0.0]]\n{own}")
        one = Solved(FINGER, scene, *[None] * 4, half_plane, None, [], 0, 0)
        found = Solves(FINGER, scene).in_single_increments(one)
        assert steps[-1][0][1].path.substeps == found.scene.path.substeps == substeps
