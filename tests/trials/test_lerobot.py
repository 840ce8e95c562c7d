"""Lifts as a LeRobot data set: read back by the format's rules, and by its own loader."""

import contextlib
import io
import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fingerdesign_cli.main import main

from fingerdesign.control.signals import Sample
from fingerdesign.trials import lerobot, study
from fingerdesign.trials.lerobot import _frames
from tests.support.session import never_called

ROOT = Path(__file__).parents[2]
parquet = pytest.importorskip("pyarrow.parquet", reason="pip install 'fingerdesign[lerobot]'")
GIVEN = [
    "--controller",
    "paper",
    "--controller",
    "fixed_force",
    "--noise",
    "0.5",
    "--mass-g",
    "200",
    "--no-tug",
]
DEFAULT = ["timestamp", "frame_index", "episode_index", "index", "task_index"]
LOADS = """
import json, sys
from lerobot.datasets.lerobot_dataset import LeRobotDataset
found = LeRobotDataset("fingerdesign/lifts", root=sys.argv[1])
last = found[len(found) - 1].items()
last = {name: getattr(each, "tolist", lambda: each)() for name, each in last}
print(json.dumps([len(found), found.num_episodes, found.fps, last]))
"""


@pytest.fixture(scope="module")
def data_set(tmp_path_factory):
    """Four lifts of the section of film_tees; its folder and what is printed."""
    folder = tmp_path_factory.mktemp("lerobot") / "lifts"
    frictions = ("--friction", "0.3", "--friction", "0.6")
    more = ("--workers", "1", "--to", "lerobot", str(folder))
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert main(["study", "film_tees", "--json", *GIVEN, *frictions, *more]) == 0
    return folder, json.loads(printed.getvalue())


class Read:
    """The files as the format's documentation has them."""

    def __init__(self, folder):
        self.info = json.loads((folder / "meta/info.json").read_text())
        self.stats = json.loads((folder / "meta/stats.json").read_text())
        place = {"chunk_index": 0, "file_index": 0}
        self.data = parquet.read_table(folder / self.info["data_path"].format(**place))
        self.tasks = parquet.read_table(folder / "meta/tasks.parquet")
        path = folder / "meta/episodes/chunk-000/file-000.parquet"
        self.episodes = parquet.read_table(path).to_pylist()
        self.groups = parquet.ParquetFile(folder / self.info["data_path"].format(**place))

    def values(self, name):
        return np.array(self.data[name].to_pylist())


def test_it_is_what_the_format_says(data_set):
    read = Read(data_set[0])
    info, frames = read.info, read.data.num_rows
    assert (info["codebase_version"], info["fps"], info["total_tasks"]) == ("v3.0", 100, 1)
    assert data_set[1] == {"design": "film_tees", "episodes": 4, "frames": frames, "left_out": 0}
    assert info["splits"] == {"train": "0:4"}
    assert list(info["features"])[-5:] == DEFAULT
    assert set(info["features"]) == set(read.data.column_names) == set(read.stats)
    for name, about in info["features"].items():
        values = read.values(name)
        assert list(values.reshape(frames, -1).shape[1:]) == about["shape"]
        kind = read.data.schema.field(name).type
        kind = getattr(kind, "value_type", kind)
        assert kind.to_pandas_dtype() == np.dtype(about["dtype"]).type
        assert len(about["names"] or [0]) == about["shape"][0]
        numbers = values.reshape(frames, -1).astype(float)
        assert read.stats[name]["mean"] == pytest.approx(numbers.mean(axis=0))
        assert read.stats[name]["q50"] == pytest.approx(np.median(numbers, axis=0))
        assert read.stats[name]["count"] == [frames]
    index = json.loads(read.tasks.schema.metadata[b"pandas"])["index_columns"]
    assert (index, read.tasks["task_index"].to_pylist()) == (["task"], [0])


def test_each_episode_is_one_lift(data_set):
    """A row group of its own; its moves lead from each sample to the next."""
    read = Read(data_set[0])
    begins = [each["dataset_from_index"] for each in read.episodes]
    ends = [each["dataset_to_index"] for each in read.episodes]
    assert [0, *ends[:-1]] == begins
    assert read.groups.num_row_groups == 4
    assert (read.values("index") == np.arange(ends[-1])).all()
    names = read.info["features"]["observation.state"]["names"]
    state, moves = read.values("observation.state"), read.values("action")
    for each, begin, end in zip(read.episodes, begins, ends, strict=True):
        own = slice(begin, end)
        assert (
            each["length"]
            == end - begin
            == read.groups.metadata.row_group(each["episode_index"]).num_rows
        )
        assert read.values("timestamp")[own] == pytest.approx(np.arange(end - begin) / 100)
        assert read.values("next.done")[own].tolist() == [False] * (end - begin - 1) + [True]
        assert bool(read.values("next.success")[end - 1]) == each["success"]
        closing = state[own, names.index("closing")]
        assert np.diff(closing) == pytest.approx(moves[own, 1][:-1], abs=1e-6)
        assert np.ptp(state[own, names.index("gage_1")]) > 0.0
    assert {each["controller"] for each in read.episodes} == {"paper", "fixed_force"}
    assert {each["success"] for each in read.episodes} <= {True, False}


def test_a_frame_is_a_sample_and_the_move_behind_it():
    row, success = np.array([1.0, 2.0, 3.0]), SimpleNamespace(success=np.bool_(True))
    trace = SimpleNamespace(approach=row, shear=10 * row, rise=0.5 * row, dx=3 * row, dy=-row)
    samples = [Sample(np.array([7.0, 8.0]), 5.0 * k, 0.1 * k, k == 3) for k in (1, 2, 3)]
    found = _frames(SimpleNamespace(trace=trace, samples=samples, result=success))
    states = [[7.0, 8.0, 5.0 * k, 0.1 * k, k, 10.5 * k, 0.0] for k in (1, 2)]
    assert found["observation.state"] == pytest.approx(np.array(states))
    assert found["action"].tolist() == [[6.0, -2.0], [9.0, -3.0]]


def test_its_own_loader_reads_it(data_set):
    """LeRobot pins other versions than ours: LEROBOT_PYTHON names another interpreter with it."""
    python = os.environ.get("LEROBOT_PYTHON", sys.executable)
    if subprocess.run([python, "-c", "import lerobot"], capture_output=True).returncode:
        pytest.skip("lerobot is not installed: set LEROBOT_PYTHON to a Python that has it")
    offline = os.environ | {"HF_HUB_OFFLINE": "1", "PYTHONPATH": ""}
    command = [python, "-c", LOADS, data_set[0]]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=offline)
    frames, episodes, rate, last = json.loads(done.stdout.splitlines()[-1])
    read = Read(data_set[0])
    assert (frames, episodes, rate) == (read.data.num_rows, 4, 100)
    assert last["action"] == pytest.approx(read.values("action")[-1])
    assert last["task"] == read.tasks["task"][0].as_py()
    assert last["next.done"]


def test_an_interrupted_one_goes_on_and_is_the_same(data_set, tmp_path, terminal, calls_of):
    """Of four lifts the second is interrupted; the first is not lifted again."""
    folder = tmp_path / "lifts"
    frictions = ("--friction", "0.3", "--friction", "0.6")
    given = ("study", "film_tees", *GIVEN, *frictions, "--workers", "1", "--to", "lerobot", folder)
    lifted = lerobot.lifts_of
    with pytest.MonkeyPatch.context() as patch:
        batches = iter([lifted])
        patch.setattr(lerobot, "lifts_of", lambda *given: next(batches, interrupt)(*given))
        assert "run the same command to go on" in terminal(*given, code=130).err
    assert not folder.exists()
    again = calls_of(lerobot, "lifts_of")
    terminal(*given)
    assert len(again) == 3
    assert [each.name for each in tmp_path.iterdir()] == ["lifts"]
    name = "data/chunk-000/file-000.parquet"
    assert parquet.read_table(folder / name).equals(parquet.read_table(data_set[0] / name))


def interrupt(*given):
    raise KeyboardInterrupt


def test_what_cannot_be_a_data_set_is_refused(tmp_path, terminal):
    (tmp_path / "data").mkdir()
    base = ["study", "film_tees", *GIVEN, "--to", "lerobot"]
    (tmp_path / "file").touch()
    for wrong in (tmp_path, tmp_path / "file", tmp_path / "file" / "below"):
        printed = terminal(*base, wrong, code=2).err
        assert f"--to = {wrong}: must be a folder" in printed
        assert "choose another" in printed
    assert "--tune" in terminal(*base, tmp_path / "new", "--tune", code=2).err
    assert "--out" in terminal(*base, tmp_path / "new", "--out", tmp_path / "out", code=2).err
    other = ["study", "gripbench", "--to", "lerobot", tmp_path / "new"]
    assert "only judges" in terminal(*other, code=2).err
    assert not (tmp_path / "new").exists()


def test_what_is_missing_or_not_whole_is_refused_before_meshing(not_installed, tmp_path, terminal):
    text = (ROOT / "designs/film_tees.toml").read_text()
    (tmp_path / "slow.toml").write_text(
        text.replace("[grip.hardware]", "[grip.hardware]\nsample_rate_Hz = 250.5")
    )
    asked = ("study", tmp_path / "slow.toml", "--to", "lerobot", tmp_path / "new")
    with never_called(study, "_grip_bench"):
        printed = terminal(*asked, code=2).err
        assert "grip.hardware.sample_rate_Hz = 250.5: must be a whole number" in printed
        not_installed("pyarrow")
        assert 'pip install "fingerdesign[lerobot]"' in terminal(*asked, code=1).err
    assert not (tmp_path / "new").exists()
