"""The bench of cells: both answer alike, errors are relative and against the other cell."""

import dataclasses

import pytest
from fingerdesign_bench.accuracy import hexahedra
from fingerdesign_bench.accuracy.hexahedra import (
    FINGER,
    LINES,
    Hexahedra,
    HexPoint,
    write_hexahedra,
)

from fingerdesign.checks.load import parse_design


def test_both_cells_give_nearly_the_same_answer():
    """Very coarse ones, both mixed: within a few percent, though little but the body is shared."""
    design = parse_design(FINGER)
    tets = hexahedra._tetrahedra(design, 1.6, True)
    hexes = hexahedra._hexahedra(design, 3.0, True)
    assert (tets.line, hexes.line) == (LINES[1], LINES[3])
    assert hexes.forces[-1] == pytest.approx(tets.forces[-1], rel=0.03)
    assert hexes.stick == pytest.approx(tets.stick, abs=0.2)
    most = max(abs(value) for value in tets.gages[1])
    assert hexes.gages[1] == pytest.approx(tets.gages[1], abs=0.3 * most)


def point(line, dofs, error):
    forces = ((1.0 + error, 0.0), (2.0, 0.5))
    gages = ((3.0, -1.0), (2.0, 1.0 + error))
    return HexPoint(
        line, 1.0, dofs, 9, 1e-3 * dofs, 0.1, 0.2, forces, (0.5, 0.7 - 0.1 * error), gages
    )


@pytest.fixture
def measured():
    """Errors that fall with the square of the equations; both references exact."""
    points = [point(line, n, 1e6 / n**2) for line in LINES for n in (1000, 2000, 4000)]
    points += [point(LINES[1], 9000, 0.0), point(LINES[3], 9000, 0.0)]
    return Hexahedra(points, {})


def test_errors_are_against_the_other_cell(measured):
    first = measured.points[0]
    assert measured.reference(LINES[0]).line == LINES[3]
    assert measured.reference(LINES[2]).line == LINES[1]
    assert measured.errors(first) == pytest.approx((1.0, 0.1, 0.5))
    assert measured.band() == (0.0, 0.0, 0.0)


def test_the_cost_of_an_accuracy_is_read_off_the_line(measured):
    assert measured.cost_at(LINES[0], 0.25, 0) == pytest.approx(2.0)
    flat = Hexahedra(
        [dataclasses.replace(p, forces=((2.0, 0.0), (2.0, 0.5))) for p in measured.points[:3]], {}
    )
    flat.points += [point(LINES[3], 9000, 0.0)]
    assert flat.cost_at(LINES[0], 0.25, 0) is None


def test_numbers_and_chart_are_written(measured, tmp_path):
    from fingerdesign_bench.machine import machine

    measured.machine = machine()
    paths = write_hexahedra(measured, tmp_path / "new" / "folder")
    assert [path.name for path in paths] == ["hexahedra.json", "hexahedra.png"]
    assert all(path.stat().st_size > 500 for path in paths)
