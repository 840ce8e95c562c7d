"""Recordings of others: known slips are found, wrong files refused, exponents recovered."""

import io
import json
import os
import re
import zipfile

import numpy as np
import pytest
from fingerdesign_cli.main import main

from fingerdesign.errors import DesignError
from fingerdesign.trials.recorded import detect, eflesh, friction, pillars, recording, sets, uskin

RATE, EDGE_S, GROSS_S = 100.0, 2.0, 3.5


def recorded_pull(slips=True, noise=0.0, seed=0):
    """A pull at 1 N/s on a row of 9 taxels: those at the edge stay behind from EDGE_S on, inwards,
    until at GROSS_S all have slipped. Returns time, taxels and labels."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, 5.0, 1.0 / RATE)
    load = np.clip(time - 0.5, 0.0, None)
    place = np.abs(np.arange(9) - 4.0) / 4.0
    stops = EDGE_S + (GROSS_S - EDGE_S) * (1.0 - place) if slips else np.full(9, np.inf)
    shear = np.minimum(load[:, None], np.maximum(stops - 0.5, 0.0))
    taxels = np.zeros((len(time), 9, 3))
    taxels[:, :, 0], taxels[:, :, 2] = shear, 1.0
    taxels += noise * random.standard_normal(taxels.shape)
    slip = np.where(time >= GROSS_S, 2, np.where(time >= EDGE_S, 1, 0)) * int(slips)
    return time, taxels, slip


def as_recording(name="pull", slips=True, noise=0.0, seed=0):
    time, taxels, slip = recorded_pull(slips, noise, seed)
    return recording.Recording(name, time, (taxels,), slips, slip)


def as_csv(time, taxels, slip):
    names = [f"{axis}_{k + 1}" for k in range(taxels.shape[1]) for axis in "xyz"]
    table = np.column_stack([time, taxels.reshape(len(time), -1), slip])
    rows = [",".join(f"{value:.6g}" for value in row) for row in table]
    return "\n".join([",".join(["time_s", *names, "slip"]), *rows]) + "\n"


def test_the_stick_share_is_the_share_of_taxels_that_follow():
    share = 1.0 - detect.slipping(as_recording())
    time = as_recording().time
    assert share[time < EDGE_S] == pytest.approx(1.0)
    # At 2.8 s taxels stop at 2, 2.375 and 2.75 s from either end: six of nine.
    assert share[np.searchsorted(time, 2.8)] == pytest.approx(3 / 9, abs=1 / 9)
    assert share[time > GROSS_S].max() <= 1 / 9 + 1e-9
    assert (np.diff(share) <= 1e-9).all()


@pytest.mark.parametrize("scale", [1.0, 1e4])
def test_the_unit_and_the_direction_of_a_sensor_do_not_matter(scale):
    time, taxels, slip = recorded_pull(noise=1e-3)
    turned = scale * taxels[:, :, [1, 0, 2]] * [1.0, -1.0, 1.0] + 7.0 * scale
    found = [
        detect.slipping(recording.Recording("", time, (each,), True, slip))
        for each in (taxels, turned)
    ]
    np.testing.assert_array_equal(*found)


def test_known_slips_are_found_early_and_steady_pulls_are_not():
    every = [as_recording(slips=k % 2 == 0, noise=1e-3, seed=k) for k in range(10)]
    found = {each.name: detect.score(each, every) for each in detect.OURS}
    share = found["stick share"]
    assert (share.found.rate, share.false.rate, share.early.rate) == (1.0, 0.0, 1.0)
    assert share.rank == 1.0
    assert 0.0 < share.lead_s < GROSS_S - EDGE_S
    assert share.right.of == 5 * (2 + 1) + 5 * 4
    # A load that rises all the time says nothing: the rival alarms in every window.
    rival = found["change of load"]
    assert (rival.found.rate, rival.false.rate) == (1.0, 1.0)


def test_an_alarm_after_the_slip_finds_it_late():
    each = as_recording()
    late = detect.Detector("late", lambda e: (e.time > GROSS_S + 0.045).astype(float), 0.5, "")
    found = detect.score(late, [each])
    assert (found.found.rate, found.early.rate) == (1.0, 0.0)
    assert found.lead_s == pytest.approx(-0.05)
    after = detect.Detector("after", lambda e: (e.time > GROSS_S + 0.2).astype(float), 0.5, "")
    assert detect.score(after, [each]).found.rate == 0.0


def test_noise_alone_never_alarms():
    time, taxels, _ = recorded_pull()
    noise = np.random.default_rng(1).standard_normal(taxels.shape)
    still = recording.Recording("", time, (noise,), False, np.zeros(len(time), dtype=int))
    for each in detect.OURS:
        assert (each.scores(still) <= each.alarm).all()


def test_a_recording_labelled_as_a_whole_is_one_window():
    whole = [
        recording.Recording("", e.time, e.fingers, e.slips)
        for e in (as_recording(), as_recording(slips=False))
    ]
    found = detect.score(detect.OURS[0], whole)
    assert (found.right.count, found.right.of, found.early, found.lead_s) == (2, 2, None, None)


def test_of_one_kind_alone_nothing_is_ranked():
    assert detect.score(detect.OURS[0], [as_recording(slips=False)]).rank is None


def test_a_csv_file_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "pull.csv"
    path.write_text(as_csv(*recorded_pull()), "utf-8")
    found = recording.read_csv(path)
    _, taxels, slip = recorded_pull()
    np.testing.assert_allclose(found.fingers[0], taxels, atol=1e-5)
    np.testing.assert_array_equal(found.slip, slip)
    assert (found.onset, found.slips) == (GROSS_S, True)


def test_every_fault_of_a_csv_file_is_reported_at_once(tmp_path):
    lines = as_csv(*recorded_pull()).splitlines()
    rows = [line.split(",") for line in lines]
    rows[4][1], rows[7][5], rows[9][-1], rows[11][0] = "x", "nan", "3", "0"
    path = tmp_path / "wrong.csv"
    path.write_text("\n".join(map(",".join, rows)), "utf-8")
    with pytest.raises(DesignError) as found:
        recording.read_csv(path)
    assert [each.key for each in found.value.faults] == [
        "row 5, column x_1",
        "row 8, column y_2",
        "row 10, column slip",
        "row 12, column time_s",
    ]
    assert str(path) in str(found.value)
    assert "must be 0, 1 or 2; 0 is no slip, 1 incipient, 2 gross" in str(found.value)


def test_every_wrong_column_is_named(tmp_path):
    text = as_csv(*recorded_pull()).replace("x_2,", "X_2,", 1).replace("slip", "label", 1)
    path = tmp_path / "wrong.csv"
    path.write_text(text, "utf-8")
    with pytest.raises(DesignError) as found:
        recording.read_csv(path)
    assert [(each.value, each.bound) for each in found.value.faults] == [
        ("'X_2'", "'x_2'"),
        ("'label'", "'slip'"),
    ]


def test_without_labels_the_fault_says_what_can_still_be_judged(tmp_path):
    lines = as_csv(*recorded_pull(slips=False)).splitlines()
    path = tmp_path / "bare.csv"
    path.write_text("\n".join(line.rpartition(",")[0] for line in lines), "utf-8")
    with pytest.raises(DesignError) as found:
        recording.read_csv(path)
    (fault,) = found.value.faults
    assert (fault.key, fault.value, fault.bound) == ("row 1, column 29", "''", "'slip'")
    assert "write 0 throughout, and false alarms are judged" in fault.remedy
    path.write_text("\n".join(lines), "utf-8")
    (score, *_) = sets.judge_recorded(tmp_path).sets[0].scores
    assert (score.false.of > 0, score.found.of) == (True, 0)


@pytest.mark.parametrize(
    ("change", "bound"),
    [
        (lambda t, s: (1e3 * t, s), "3 and more in the first 0.2 s"),
        (lambda t, s: (1e-3 * t, s), "3 and more in the first 0.2 s"),
        (lambda t, s: (t, 0 * s + 2), "0 in the first 0.2 s"),
    ],
)
def test_a_wrong_unit_of_time_and_a_label_at_rest_are_refused(change, bound, tmp_path):
    time, taxels, slip = recorded_pull()
    time, slip = change(time, slip)
    path = tmp_path / "wrong.csv"
    path.write_text(as_csv(time, taxels, slip), "utf-8")
    with pytest.raises(DesignError, match=bound):
        recording.read_csv(path)


def test_hdf5_files_are_read_and_refused_as_csv_files_are(tmp_path):
    h5py = pytest.importorskip("h5py", reason="pip install 'fingerdesign[recorded]'")
    time, taxels, slip = recorded_pull()
    path = tmp_path / "pulls.h5"
    with h5py.File(path, "w") as file:
        for name in ("a", "b"):
            group = file.create_group(name)
            group["time_s"], group["taxels"], group["slip"] = time, taxels, slip
    first, second = recording.read_hdf5(path)
    assert (first.name, second.name, second.onset) == ("a", "b", GROSS_S)
    np.testing.assert_array_equal(first.fingers[0], taxels)
    assert sets.judge_recorded(tmp_path).unread == ()
    with h5py.File(path, "a") as file:
        file["a/taxels"][3, 1, 2] = np.nan
        file["a/slip"][5] = 7
        del file["b/slip"]
    with pytest.raises(DesignError) as found:
        recording.read_hdf5(path)
    keys = [each.key for each in found.value.faults]
    assert keys == ["a[3], column z_2", "a[5], column slip", "b"]
    path.write_bytes(b"none")
    with pytest.raises(DesignError, match="must be an HDF5 file of numbers"):
        recording.read_hdf5(path)


def test_without_h5py_the_remedy_is_one_line(tmp_path, not_installed, capsys):
    not_installed("h5py")
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "pulls.h5").write_bytes(b"\x89HDF")
    assert main(["study", "--recorded", str(tmp_path / "in"), "--out", str(tmp_path)]) == 1
    wanted = "failed: this needs the extra recorded (missing: h5py): "
    assert wanted in capsys.readouterr().err


def tensor(samples):
    """A .pt file as torch writes it, without its pickle, which is not read."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("seq_0/data/0", np.asarray(samples, "<f4").tobytes())
    return stream.getvalue()


def eflesh_folder(folder, pulls=2):
    """The layout of eFlesh: tugs that slip, then hands at rest."""
    folder.mkdir(parents=True)
    for k in range(2 * pulls):
        _, taxels, _ = recorded_pull(slips=k < pulls, noise=1e-3, seed=k)
        both = np.tile(taxels[:300, 2:7], (1, 2, 1)) * (1.0 if k < pulls else 1e-6)
        (folder / f"seq_{k}.pt").write_bytes(tensor(100.0 * both.reshape(300, 30)))
    (folder / "labels").write_text("1\n" * pulls + "0\n" * pulls, "utf-8")


def test_eflesh_is_read_by_its_two_sensors(tmp_path):
    eflesh_folder(tmp_path / "data")
    found = eflesh.read_eflesh(tmp_path / "data")
    assert [each.slips for each in found] == [True, True, False, False]
    assert [each.shape for each in found[0].fingers] == [(300, 5, 3), (300, 5, 3)]
    (tmp_path / "data" / "seq_1.pt").write_bytes(tensor(np.zeros((4, 30))))
    (tmp_path / "data" / "seq_2.pt").unlink()
    (tmp_path / "data" / "labels").write_text("1\n1\n2\n", "utf-8")
    with pytest.raises(DesignError) as wrong:
        eflesh.read_eflesh(tmp_path / "data")
    assert [each.key for each in wrong.value.faults] == ["sequence", "labels, line 3", "sequence"]


def test_the_authors_classifier_is_taken_from_its_pickle_without_running_it(tmp_path):
    import pickle

    weights, intercept = np.array([[1.0, 0.0, 2.0]]), np.array([-0.5])
    path = tmp_path / eflesh.CLASSIFIER
    path.write_bytes(pickle.dumps({"coef_": weights, "intercept_": intercept}, protocol=4))
    found = eflesh.authors_detector(path)
    still = recording.Recording("", np.arange(300) / 100.0, (np.zeros((300, 5, 3)),) * 2, False)
    assert found.scores(still) == pytest.approx([-0.5])
    path.write_bytes(pickle.dumps({"coef_": weights[:, :2], "intercept_": intercept}, protocol=4))
    with pytest.raises(DesignError, match="must be of 3 features"):
        eflesh.authors_detector(path)


LIFT_S = 0.5


def test_the_authors_test_is_a_fifth_of_the_set_and_always_the_same():
    every = [as_recording(str(k)) for k in range(10)] * 13 + [
        as_recording(str(k)) for k in range(7)
    ]
    first, second = (eflesh.authors_test(every) for _ in range(2))
    assert len(every) == eflesh.ALL
    assert len(first) == 28
    assert [id(each) for each in first] == [id(each) for each in second]


def uskin_folder(folder, slips=True, lifts=True):
    """The layout of the uSkin set. The closing hand pushes the object by 8 mm; it lifts from LIFT_S
    on, and the marker moves by 5 mm at GROSS_S."""
    folder.mkdir(parents=True)
    time, taxels, _ = recorded_pull(slips)
    names = [f"txl{k + 1}_{axis}" for k in range(16) for axis in "xyz"]
    counts = 4e4 + 1e3 * np.concatenate([taxels, taxels[:, :7]], axis=1).reshape(len(time), -1)
    place = np.zeros((len(time), 3))
    place[:, 1] = 0.005 * (time >= GROSS_S) * slips
    place[:10, 0] = 0.008
    place[-20:] = 10.0
    hand = np.zeros((len(time), 3))
    hand[:, 2] = 0.11 * np.clip(time - LIFT_S, 0.0, None) * lifts
    files = dict.fromkeys(uskin.SENSORS, (names, counts))
    files["marker.csv"] = ([f"marker1_position_{axis}" for axis in "xyz"], place)
    files["robot_state.csv"] = ([f"ee_state_position_{axis}" for axis in "xyz"], hand)
    files["meta_data.csv"] = (["frequency_hz"], np.array([[RATE]]))
    for name, (header, table) in files.items():
        rows = [",".join(map(str, row)) for row in table.tolist()]
        (folder / name).write_text("\n".join([",".join(header), *rows]), "utf-8")


def test_uskin_slips_where_the_marker_moves_in_the_hand_after_the_lift(tmp_path):
    uskin_folder(tmp_path / "a")
    found = uskin.read_uskin(tmp_path / "a")
    begin = LIFT_S + 0.01 - 0.21
    assert found.onset == pytest.approx(GROSS_S - begin)
    # The marker is lost at the end.
    assert found.fingers[0].shape == (480 - round(RATE * begin), 16, 3)
    uskin_folder(tmp_path / "b", slips=False)
    assert not uskin.read_uskin(tmp_path / "b").slips
    text = (tmp_path / "b" / "marker.csv").read_text("utf-8").replace("0.0,0.0,0.0", "10,10,10")
    (tmp_path / "b" / "marker.csv").write_text(text, "utf-8")
    assert uskin.read_uskin(tmp_path / "b") is None
    uskin_folder(tmp_path / "c", lifts=False)
    assert uskin.read_uskin(tmp_path / "c") is None
    (tmp_path / "a" / "meta_data.csv").write_text("rate\n5\n", "utf-8")
    with pytest.raises(DesignError, match="row 1 = frequency_hz"):
        uskin.read_uskin(tmp_path / "a")


def test_an_exponent_is_recovered_with_its_interval():
    random = np.random.default_rng(0)
    force = np.exp(random.uniform(0.0, 3.0, 200))
    level = random.integers(0, 4, 200)
    friction_ = (0.2 + 0.1 * level) * force**-0.3 * np.exp(0.05 * random.standard_normal(200))
    found = friction.exponent(force, friction_, np.arange(200).tolist(), level.tolist())
    assert found.value == pytest.approx(0.3, abs=0.01)
    assert found.low < 0.3 < found.high
    assert found.high - found.low < 0.03
    with pytest.raises(ValueError, match="needs 3"):
        friction.exponent(force, friction_, [0] * 200)


def test_an_exponents_interval_is_students_over_the_groups():
    """log mu off the line by 0.1, -0.2 and 0.1 at log F = -1, 0 and 1: sqrt(3 / 2 (0.1^2 + 0.1^2))
    / 2, times 12.7062 for one degree of freedom."""
    found = friction.exponent(np.exp([-1.0, 0.0, 1.0]), np.exp([0.3, -0.2, -0.1]), [0, 1, 2])
    assert (found.value, found.count, found.groups) == (pytest.approx(0.2), 3, 3)
    reach = 12.7062 * np.sqrt(0.03) / 2.0
    assert (found.low, found.high) == pytest.approx((0.2 - reach, 0.2 + reach), rel=1e-5)
    twice = friction.exponent(
        np.exp([-1.0, 0.0, 1.0] * 2), np.exp([0.3, -0.2, -0.1] * 2), [0, 1, 2] * 2
    )
    assert (twice.low, twice.count, twice.groups) == (pytest.approx(found.low), 6, 3)


def test_scores_that_are_equal_rank_at_a_half_and_the_last_other_load_is_found_however_far():
    every = [as_recording(), as_recording(slips=False)]
    same = detect.Detector("same", lambda each: np.zeros(len(each.time)), 0.5, "")
    found = detect.score(same, every)
    assert (found.rank, found.found.rate, found.early.rate, found.lead_s) == (0.5, 0.0, 0.0, None)
    load = np.repeat([[0.0, 0.0], [3.0, 4.0]], [300, 300], axis=0)
    assert detect._last_apart(load, 5.0) == 299
    assert detect._last_apart(load, 5.1) is None
    assert detect._last_apart(load[:320], 5.0) == 299


def test_laws_foretell_lifts_of_constant_shear_strength():
    """W = F^(2/3): the third law is right about every lift, Coulomb's about those far off."""
    weights = [1.0, 2.0, 3.0, 4.0]
    outcome = {0.8: "failed", 1.0: "slipped slowly", 1.2: "held"}
    near = {w: 1.0 if w == 1.0 else 0.999 for w in weights}  # no lift is at the limit itself
    lifts = [
        pillars.Lift(w, f * near[w] * w**1.5, name) for w in weights for f, name in outcome.items()
    ]
    single = [
        pillars.Pillar("1.0", str(k), f, 0.5 * f**0.9) for k, f in enumerate([1.0, 2.0, 3.0, 4.0])
    ]
    data = pillars.PillarData(tuple(lifts), tuple(lifts), tuple(single))
    found = friction.judge_friction(data)
    assert found.whole.value == pytest.approx(1.0 / 3.0, abs=1e-3)
    assert found.single.value == pytest.approx(0.1)
    coulomb, _, constant = found.foretold
    assert constant.slips_at_N == pytest.approx(found.slow_N, rel=2e-3)
    assert constant.right.rate == 1.0
    assert coulomb.right.count < constant.right.count


def cell(address, value, fill):
    return f'<c r="{address}" s="{fill}"><v>{value}</v></c>'


def workbook(path, doctype=""):
    """A workbook of the thesis's layout: W = F^(2/3) on the first sheet."""
    space = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
    first = [cell("Z10", "", 1), cell("Z11", "", 2), cell("Z12", "", 3)]
    for k, row in enumerate(range(5, 54, 12)):
        force = (9.80665e-3 * (250 + 125 * k)) ** 1.5
        for column, factor, fill in (("O", 0.8, 3), ("P", 1.0, 2), ("Q", 1.2, 1)):
            first.append(cell(f"{column}{row}", factor * force, fill))
        first.append(cell(f"N{row}", 1.3 * force, 0))
    third = [
        cell(f"{column}{row}", value, 0)
        for row in range(4, 9)
        for column, value in (("F", row), ("G", 0.4 * row**0.8), ("AG", row), ("AH", row / 3))
    ]
    fills = "".join(f'<xf fillId="{k}"/>' for k in range(4))
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("xl/sharedStrings.xml", f"{doctype}<sst {space}/>")
        archive.writestr("xl/styles.xml", f"<s {space}><cellXfs>{fills}</cellXfs></s>")
        for number, cells in ((1, first), (3, third)):
            rows = f"<row>{''.join(cells)}</row>"
            sheet = f"<worksheet {space}><sheetData>{rows}</sheetData></worksheet>"
            archive.writestr(f"xl/worksheets/sheet{number}.xml", sheet)


def test_a_workbook_is_read_by_the_colours_of_its_legend(tmp_path):
    path = tmp_path / "EXPERIMENTAL_DATA_1.xlsx"
    workbook(path)
    found = pillars.read_pillars(path)
    assert [each.outcome for each in found.lifts[:3]] == ["failed", "slipped slowly", "held"]
    assert len(found.lifts) == 15
    assert len(found.own) == 5
    assert {each.name for each in found.pillars} == {"1.1", "2.0"}
    assert friction.judge_friction(found).whole.value == pytest.approx(1.0 / 3.0)
    workbook(path, "<!DOCTYPE a>")
    with pytest.raises(DesignError, match="the thesis's workbook"):
        pillars.read_pillars(path)
    path.write_bytes(b"none")
    with pytest.raises(DesignError, match="not a zip file"):
        pillars.read_pillars(path)


@pytest.fixture
def every_set(tmp_path):
    """A folder with a set of each layout, and a pointer of Git LFS."""
    folder = tmp_path / "sets"
    eflesh_folder(folder / "eflesh" / "data")
    for k in range(3):
        uskin_folder(folder / "uskin" / str(k), slips=k > 0)
        own = recorded_pull(slips=k > 0, noise=1e-3, seed=k)
        (folder / f"own_{k}.csv").write_text(as_csv(*own), "utf-8")
    workbook(folder / "EXPERIMENTAL_DATA_1.xlsx")
    (folder / "large.h5").write_bytes(b"version https://git-lfs.github.com/spec/v1\noid 1\n")
    return folder


@pytest.mark.slow
def test_one_command_judges_every_set(every_set, tmp_path, capsys):
    assert main(["study", "--recorded", str(every_set), "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    data = json.loads((tmp_path / "recorded" / "recorded.json").read_text("utf-8"))
    assert [each["name"] for each in data["sets"]] == ["eFlesh", "uSkin", "plain format"]
    assert data["unread"] == ["large.h5: a pointer of Git LFS: git lfs pull fetches it"]
    page = (tmp_path / "recorded" / "recorded.html").read_text("utf-8")
    for each in data["sets"]:
        assert each["name"] in shown
        for score in each["scores"]:
            assert score["detector"] in shown
            assert score["detector"] in page
    assert "large.h5" in page
    assert "n = 0.33" in shown
    assert max(map(len, shown.splitlines()[:-1])) <= 80  # the last one is a path
    assert "early by: the median time before it" in page


def test_faults_of_all_files_are_reported_together(every_set, tmp_path, capsys):
    (every_set / "own_0.csv").write_text("time_s,x_1\n0,1\n1,2\n", "utf-8")
    (every_set / "eflesh" / "data" / "seq_1.pt").unlink()
    assert main(["study", "--recorded", str(every_set), "--out", str(tmp_path)]) == 2
    shown = capsys.readouterr().err
    assert "own_0.csv: row 1, column 3 = ''" in shown
    assert "seq_1.pt" in shown
    assert not (tmp_path / "recorded").exists()


def test_a_folder_without_recordings_is_refused(tmp_path):
    with pytest.raises(DesignError, match=r"recorded\.md"):
        sets.judge_recorded(tmp_path)
    (tmp_path / "a.h5").write_bytes(b"version https://git-lfs.github.com/spec/v1\n")
    with pytest.raises(DesignError, match="git lfs pull"):
        sets.judge_recorded(tmp_path)


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ("", "Missing argument 'DESIGN'"),
        ("--recorded none", "--recorded"),
        ("--recorded . maeno2000", "leave out DESIGN"),
        ("--recorded . --plants 3", "leave out plants"),
        ("--recorded . --tune", "leave out tune"),
    ],
)
def test_wrong_use_of_the_command_is_refused(given, wanted, terminal, in_tmp_path):
    assert wanted in terminal("study", *given.split(), code=2).err


def read_changed(folder, change):
    """Read a recording of which ``change`` makes other times, taxels and labels."""
    path = folder / "changed.csv"
    path.write_text(as_csv(*change(*recorded_pull(noise=1e-3))), "utf-8")
    return recording.read_csv(path)


@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        (lambda t, x, s: (t, 0 * x + 1, s), "columns x and y = 1 at first: must be changing"),
        (lambda t, x, s: (t, x * [0, 0, 1], s), "must be changing by 1e-9 to 1e100"),
        (lambda t, x, s: (t, 1e300 * x, s), "must be changing by 1e-9 to 1e100"),
        (lambda t, x, s: (t, 1e-15 * x, s), "must be changing by 1e-9 to 1e100"),
        (
            lambda t, x, s: (t + 5.0 * (t > 2.995), x, s),
            "row 302, column time_s = 8: must be after",
        ),
        (lambda t, x, s: (t[:110], x[:110], s[:110]), "at least 1.2 s long without a gross slip"),
    ],
)
def test_what_would_be_judged_as_a_number_of_nothing_is_refused(change, wanted, tmp_path):
    with pytest.raises(DesignError, match=wanted):
        read_changed(tmp_path, change)


def test_a_recording_too_long_to_be_judged_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(recording, "_MANY", 500)
    with pytest.raises(DesignError, match="of fewer than 500 samples; cut it"):
        read_changed(tmp_path, lambda *each: each)


def test_a_load_that_was_held_for_long_is_compared_with_the_one_before():
    load = np.zeros((5000, 2))
    load[:7, 0] = 1.0
    assert detect._last_apart(load, 0.5) == 6
    assert detect._last_apart(load[7:], 0.5) is None


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-8"])
def test_a_csv_file_from_a_spreadsheet_is_not_passed_over(encoding, tmp_path):
    text = as_csv(*recorded_pull(noise=1e-3))
    (tmp_path / "first.csv").write_text(text, "utf-8")
    (tmp_path / "SECOND.CSV").write_text(text.replace("time_s", '"time_s"'), encoding)
    assert sets.judge_recorded(tmp_path).sets[0].recordings == 2


@pytest.mark.parametrize(
    ("name", "encoding", "wanted"),
    [("time", "utf-8", "'time': must be 'time_s'"), ("time_s", "utf-16", "it is not UTF-8 text")],
)
def test_a_wrong_first_column_is_named_and_not_passed_over(name, encoding, wanted, tmp_path):
    text = as_csv(*recorded_pull(noise=1e-3))
    (tmp_path / "first.csv").write_text(text, "utf-8")
    (tmp_path / "second.csv").write_text(text.replace("time_s", name), encoding)
    with pytest.raises(DesignError, match=wanted):
        sets.judge_recorded(tmp_path)


def test_names_that_are_no_text_are_shown_and_do_not_end_the_work(tmp_path):
    folder = tmp_path / "b\udcff"
    try:
        folder.mkdir()
    except (OSError, UnicodeError):
        pytest.skip("this disk has no such names")
    (folder / "a.csv").write_text(as_csv(*recorded_pull(noise=1e-3)), "utf-8")
    (folder / "\udcfe<script>.h5").write_bytes(b"version https://git-lfs.github.com/spec/v1\n")
    assert main(["study", "--recorded", str(folder), "--out", str(tmp_path)]) == 0
    page = (tmp_path / "recorded" / "recorded.html").read_text("utf-8")
    assert "\ufffd&lt;script&gt;.h5" in page


@pytest.mark.parametrize("kind", ["link", "loop", "group", "empty", "complex", "huge", "damaged"])
def test_hdf5_files_of_other_content_are_refused(kind, tmp_path):
    h5py = pytest.importorskip("h5py", reason="pip install 'fingerdesign[recorded]'")
    path = tmp_path / "pulls.h5"
    with h5py.File(path, "w") as file:
        file["a/time_s"], file["a/taxels"], file["a/slip"] = recorded_pull()
        if kind in ("link", "loop"):
            file["b"] = h5py.SoftLink("/none" if kind == "link" else "/b")
        elif kind != "damaged":
            del file["a/taxels"]
        if kind == "group":
            file.create_group("a/taxels")
        elif kind == "empty":
            del file["a/time_s"], file["a/slip"]
            file["a/time_s"], file["a/taxels"], file["a/slip"] = [], np.empty((0, 9, 3)), []
        elif kind == "complex":
            file["a/taxels"] = 1j + recorded_pull()[1]
        elif kind == "huge":
            file.create_dataset("a/taxels", (500, 10**9, 3), "f8", chunks=(1, 1000, 3))
    if kind == "damaged":
        content = bytearray(path.read_bytes())
        for place in range(len(content) - 3):
            if content[place : place + 4] in (b"HEAP", b"SNOD"):
                content[place : place + 4] = b"none"
        path.write_bytes(content)
    with pytest.raises(DesignError):
        recording.read_hdf5(path)


def test_a_set_of_eflesh_is_whole_and_its_signals_change(tmp_path):
    eflesh_folder(tmp_path / "data")
    (tmp_path / "data" / "seq_2.pt").write_bytes(tensor(np.ones((300, 30))))
    (tmp_path / "data" / "labels").write_text("1\n1\n0\n", "utf-8")
    with pytest.raises(DesignError) as wrong:
        eflesh.read_eflesh(tmp_path / "data")
    assert wrong.value.faults[0].bound == "4, one a sequence"
    assert "too short, still" in str(wrong.value)


def test_archives_that_are_damaged_in_any_way_of_packing_are_refused(tmp_path):
    eflesh_folder(tmp_path / "data")
    path = tmp_path / "data" / "seq_1.pt"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("seq_1/data/0", np.random.default_rng(0).bytes(36000))
    content = bytearray(path.read_bytes())
    content[60:90] = b"\xff" * 30
    path.write_bytes(content)
    with pytest.raises(DesignError, match=r"seq_1\.pt: must be a tensor"):
        eflesh.read_eflesh(tmp_path / "data")


class Runs:
    def __reduce__(self):
        return pytest.fail, ("the pickle was run",)


@pytest.mark.parametrize("weight", [np.nan, np.inf, 1e300, Runs()])
def test_a_classifier_of_no_numbers_is_refused_and_not_run(weight, tmp_path):
    import pickle

    path = tmp_path / eflesh.CLASSIFIER
    weights = weight if isinstance(weight, Runs) else np.array([[weight, 0.0, 2.0]])
    path.write_bytes(pickle.dumps({"coef_": weights, "intercept_": np.array([0.5])}, protocol=4))
    with pytest.raises(DesignError, match="must be of 3 features"):
        eflesh.authors_detector(path)


@pytest.mark.parametrize(
    ("sheet", "old", "new"),
    [
        (1, r'("P5" s="2"><v>)[\d.]+', r"\1nan"),
        (1, r'("P5" s="2"><v>)[\d.]+', r"\1 1e300"),
        (1, r'("P5" s="2"><v>)[\d.]+', r"\1-3"),
        (1, r'("P5" s="2"><v>)[\d.]+', r"\1 0"),
        (1, r'<c r="N5" s="0">.*?</c>', ""),
        (1, r'( s="2"><v>)[\d.]+', r"\1 3"),
        (3, "<row>.*</row>", ""),
        (3, r'<c r="[A-Z]+[5-8]".*?</c>', ""),
        (3, r"<v>[\d.]+</v>", "<v>4</v>"),
    ],
)
def test_a_workbook_of_no_forces_is_refused(sheet, old, new, tmp_path):
    path = tmp_path / "EXPERIMENTAL_DATA_1.xlsx"
    workbook(path)
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name).decode() for name in archive.namelist()}
    parts[f"xl/worksheets/sheet{sheet}.xml"] = re.sub(
        old, new, parts[f"xl/worksheets/sheet{sheet}.xml"]
    )
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in parts.items():
            archive.writestr(name, content)
    with pytest.raises(DesignError, match=r"EXPERIMENTAL_DATA_1\.xlsx: must be"):
        friction.read_friction(path)


def test_every_file_that_is_not_read_is_named_with_the_reason(tmp_path, monkeypatch, capsys):
    folder, text = tmp_path / "sets", as_csv(*recorded_pull(noise=1e-3))
    (folder / "inside").mkdir(parents=True)
    (folder / "good.csv").write_text(text, "utf-8")
    for k in range(11):
        (folder / "inside" / f"other_{k:02}.csv").write_text(text.replace("time_s", "t"), "utf-8")
    (folder / "sheet.xlsx").write_bytes(b"")
    (folder / "link").symlink_to(tmp_path)
    (folder / "closed").mkdir()
    opened = os.scandir

    def scandir(place):  # as for a user without the right; the superuser has it
        if str(place).endswith("closed"):
            raise PermissionError(13, "Permission denied", place)
        return opened(place)

    monkeypatch.setattr(os, "scandir", scandir)
    unread = sets.judge_recorded(folder).unread
    assert unread[0] == "link: links to folders are not followed"
    assert unread[1] == "closed: Permission denied"
    assert unread[2] == "inside/other_00.csv: its first column is not time_s"
    assert unread[-1] == "sheet.xlsx: of no known layout"
    assert main(["study", "--recorded", str(folder), "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "not read: link" in shown
    assert "4 more, in recorded.json" in shown


def test_of_two_workbooks_none_is_chosen_in_silence(tmp_path):
    for name in "12":
        workbook(tmp_path / f"EXPERIMENTAL_DATA_{name}.xlsx")
    with pytest.raises(DesignError, match=r"DATA_1\.xlsx, .*DATA_2\.xlsx: must be one such file"):
        sets.judge_recorded(tmp_path)


@pytest.mark.parametrize("option", ["--controller", "--estimator", "--program", "--workers"])
def test_options_of_hands_are_refused_where_recordings_are_judged(option, tmp_path, terminal):
    value = "2" if option == "--workers" else "regulator"
    assert option[2:] in terminal("study", "--recorded", tmp_path, option, value, code=2).err
