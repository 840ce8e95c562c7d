"""Recorded traces: read as they are, every fault named by row and column."""

import os
import re

import numpy as np
import pytest

from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.trace import parse_trace, read_trace, trace_of
from fingerdesign.errors import DesignError

NAMES = ["time_s", "dx_mm", "dy_mm", "normal_force_N", "tangential_force_N"]
SAMPLES = 12


def table(gages=3):
    """A grip of 12 samples at 100 Hz: 0.01 mm closing and 0.3 N each, shear from the fifth on."""
    k = np.arange(1, SAMPLES + 1)
    dx = np.where(k > 4, 0.002, 0.0)
    tangential = 20.0 * np.cumsum(dx)
    strain = 10.0 * np.outer(0.3 * k, np.arange(1, gages + 1))
    return np.column_stack([0.01 * k, dx, np.full(SAMPLES, 0.01), 0.3 * k, tangential, strain])


def names_of(gages):
    return [*NAMES, *(f"gage_{k + 1}" for k in range(gages))]


def text(cells=None, names=None, gages=3):
    cells = table(gages) if cells is None else cells
    names = names_of(gages) if names is None else names
    lines = [",".join(names)]
    lines += [",".join(c if isinstance(c, str) else f"{c:.10g}" for c in row) for row in cells]
    return "\n".join(lines) + "\n"


def changed(row, name, value):
    """The trace's text with one cell changed; rows as in the file."""
    cells = [list(line) for line in table()]
    cells[row - 2][names_of(3).index(name)] = value
    return text(cells)


def scaled(name, factor):
    cells = table()
    cells[:, [each.startswith(name) for each in names_of(3)]] *= factor
    return text(cells)


def faults(trace, gages=None):
    with pytest.raises(DesignError) as caught:
        parse_trace(trace, gages, "grip.csv")
    return [str(fault) for fault in caught.value.faults]


def test_a_trace_is_read_sample_by_sample(tmp_path):
    path = tmp_path / "grip.csv"
    path.write_text(text(), "utf-8")
    trace, expected = read_trace(path, gages=3), table()
    assert len(trace) == SAMPLES
    assert trace.readings == pytest.approx(expected[:, 5:])
    assert trace.normal_force == pytest.approx(expected[:, 3])
    assert trace.tangential_force == pytest.approx(expected[:, 4])
    assert trace.lifted is None


def test_columns_may_stand_in_any_order_and_the_hand_may_see_the_lift():
    order = ["lifted", "gage_2", "normal_force_N", "time_s", "gage_1", "dx_mm", "dy_mm"]
    order.append("tangential_force_N")
    cells = table(2)
    source = dict(zip([*NAMES, "gage_1", "gage_2"], cells.T, strict=True))
    source["lifted"] = (np.arange(SAMPLES) > 8).astype(float)
    trace = parse_trace(text(np.column_stack([source[name] for name in order]), order))
    assert np.allclose(trace.readings, cells[:, 5:])
    assert trace.lifted.tolist() == [False] * 9 + [True] * 3
    # Ten gages and more stand by their numbers.
    assert (np.diff(parse_trace(text(gages=12), 12).readings, axis=1) > 0.0).all()


@pytest.mark.parametrize(
    ("trace", "gages", "place"),
    [
        (changed(5, "gage_2", "nan"), None, "row 5, column gage_2 = nan"),
        (changed(5, "normal_force_N", "inf"), None, "row 5, column normal_force_N = inf"),
        (changed(6, "dx_mm", ""), None, "row 6, column dx_mm = empty"),
        (changed(6, "gage_1", "1_2"), None, "row 6, column gage_1 = '1_2'"),
        (changed(6, "gage_1", "12 ue"), None, "row 6, column gage_1 = '12 ue'"),
        (changed(7, "time_s", 0.067), None, "row 7, column time_s = 0.067"),
        (changed(7, "time_s", 0.05), None, "row 7, column time_s = 0.05"),
        (changed(8, "dy_mm", 10.0), None, "row 8, column dy_mm = 10: must be at most 5"),
        (changed(8, "normal_force_N", -3.0), None, "row 8, column normal_force_N = -3"),
        (changed(8, "tangential_force_N", 30.0), None, "row 8, column tangential_force_N = 30"),
        (changed(8, "tangential_force_N", -30.0), None, "row 8, column tangential_force_N = -30"),
        (changed(8, "normal_force_N", -2e3), None, "row 8, column normal_force_N = -2000: .* 1000"),
        (changed(9, "gage_3", -3e5), None, "row 9, column gage_3 = -300000: must be at most 20000"),
        (changed(9, "gage_3", 3e5), None, "row 9, column gage_3 = 300000: must be at most 20000"),
        (text(gages=1), None, "row 1, column gage_2 = 1 gages: must be at least 2"),
        (text(gages=0), None, "row 1, column gage_1 = 0 gages"),
        (text(gages=3), 15, "row 1, column gage_4 = 3 gages: must be at least 15"),
        (text(gages=3), 2, "row 1, column gage_3 = 3 gages: must be 2"),
        (text(names=[*NAMES, "gage_1", "gage_2", "gage_4"]), None, "row 1, column gage_4"),
        (text(names=[*NAMES, "gage_1", "gage_2", "gage_2"]), None, "row 1, column 8"),
        (text().replace("force_N", "force_mN", 1), None, "row 1, column 4 .*mean normal_force_N"),
        (text().replace("time_s", "time_ms"), None, "row 1, column time_s = absent"),
        (text().replace(",", ";"), None, "row 1 = columns apart by ';'"),
    ],
)
def test_a_wrong_cell_unit_or_header_is_named_by_row_and_column(trace, gages, place):
    assert any(re.match(place, fault) for fault in faults(trace, gages)), faults(trace, gages)


@pytest.mark.parametrize(
    ("name", "factor", "column"),
    [
        ("gage", 1e-6, "gage_3"),  # plain strain
        ("normal", 1e3, "normal_force_N"),  # millinewtons
        ("normal", 1e3 / 9.80665, "normal_force_N"),  # grams
        ("normal", -1.0, "normal_force_N"),  # pressing counted negative
        ("tangential", 1e3, "tangential_force_N"),
        ("dy", 1e3, "dy_mm"),  # micrometres
        ("dy", 1e-3, "normal_force_N"),  # metres: forces beyond any finger's
        ("dy", 400.0, "normal_force_N"),  # micrometres, few: no force for so much
        ("time", 1e3, "time_s"),  # milliseconds
        ("time", 1e6, "time_s"),
    ],
)
def test_another_unit_is_named_by_row_and_column(name, factor, column):
    found = faults(scaled(name, factor))
    assert any(re.match(rf"row \d+, column {column} = ", fault) for fault in found), found


def test_a_long_way_to_the_object_is_none_of_its_closing():
    air = np.column_stack([np.zeros((SAMPLES, 2)), np.full(SAMPLES, 3.0), np.zeros((SAMPLES, 5))])
    cells = np.concatenate([air, table()])
    cells[:, 0] = 0.01 * np.arange(len(cells))
    assert len(parse_trace(text(cells))) == 2 * SAMPLES
    cells[:, 2] = np.repeat([0.1, 4.0], SAMPLES)
    (fault,) = faults(text(cells))
    assert fault.startswith(f"row {2 * SAMPLES + 1}, column normal_force_N")  # the deepest


def test_a_way_there_and_back_is_no_travel():
    cells = table()
    cells[:, 1] = 4.9 * (-1.0) ** np.arange(SAMPLES)
    assert len(parse_trace(text(cells))) == SAMPLES
    cells[:, 1] = 4.9
    assert faults(text(cells))[0].startswith("row 12, column dx_mm")  # 11 of them pass 50 mm


def test_what_is_no_trace_is_refused(tmp_path):
    for wrong in ("", "time_s\n", text().splitlines()[0], '"open,\n' + text()):
        with pytest.raises(DesignError, match="trace"):
            parse_trace(wrong)
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x81")
    os.mkfifo(tmp_path / "pipe.csv")
    for name, words in (
        ("absent.csv", "readable CSV"),
        ("binary.csv", "UTF-8"),
        ("pipe.csv", "an ordinary file"),
        ("a\0b.csv", "zero byte"),
    ):
        with pytest.raises(DesignError, match=words):
            read_trace(tmp_path / name)


def test_a_recorded_simulation_reads_as_the_plant_was(half_plane, tmp_path):
    """Written from a plant, read back: the same samples."""
    plant = CondensedPlant(half_plane, "both")
    moves = [(0.002 if k > 4 else 0.0, 0.01) for k in range(10)]
    samples = [plant.move(*move) for move in moves]
    path = tmp_path / "simulated.csv"
    path.write_text(trace_of(samples, moves, 50.0).to_csv(), "utf-8")
    trace = read_trace(path, 11)
    assert trace.time == pytest.approx(np.arange(1, 11) / 50.0)
    assert trace.readings == pytest.approx(np.array([s.readings for s in samples]), 1e-7, 1e-12)
    assert trace.normal_force == pytest.approx([s.normal_force for s in samples])
    assert trace.dx.sum() == pytest.approx(plant.truth().shear)
    assert trace_of(samples, moves, 50.0).rows.tolist() == trace.rows.tolist()


def test_lost_samples_rows_cut_short_and_decimal_commas_are_named_up_to_a_number():
    lines = text().splitlines()
    (fault,) = faults("\n".join([*lines[:7], *lines[8:]]))
    assert fault.startswith("row 8, column time_s")
    assert "missing" in fault
    lines[4] = "0,04" + lines[4][lines[4].index(",") :]
    lines[6] = lines[6].rsplit(",", 1)[0]
    found = faults("\n".join(lines))
    assert found[0].startswith("row 5, column gage_3 = 9 cells in the row: must be 8")
    assert found[1].startswith("row 7, column gage_3 = 7 cells in the row")
    found = faults(text([["nan"] * 8 for _ in range(SAMPLES)]))
    assert len(found) == 21
    assert "76 more faults" in found[-1]


@pytest.mark.parametrize("mark", [";", "\t"])
def test_other_marks_between_columns_are_one_fault(mark):
    (fault,) = faults(text().replace(",", mark).replace(".", ","))
    assert fault == (
        f"row 1 = columns apart by {mark!r}: must be by ','; "
        "write commas between columns, and points in decimals"
    )


def test_a_decimal_comma_is_named():
    (fault,) = faults(changed(5, "gage_2", '"2,5"'))
    assert fault.endswith("decimals take a point")
