"""Lifts as a LeRobot data set, format v3.0: parquet and JSON by pyarrow, no torch.

    write_lifts(bench, 100.0, grid.batches(names), folder, journal, workers=2)

    data/chunk-000/file-000.parquet     a row a sample, a row group an episode
    meta/info.json, stats.json          features with their shapes and names; their statistics
    meta/tasks.parquet, meta/episodes/  the task; of each episode where it is, and what came of it

A frame is a sample of the hand and the move that follows it: the last sample has none, and is left
out. The format is that of huggingface/lerobot's lerobot/datasets (August 2026). Needs the extra
``lerobot`` (``pip install fingerdesign[lerobot]``).
"""

import json
from base64 import b64decode, b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.episode import Episode
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.records.base import json_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.runtime.extras import needs
from fingerdesign.runtime.journal import Journal
from fingerdesign.trials.bench import Bench
from fingerdesign.trials.grid import Cell
from fingerdesign.trials.stored import Report, in_processes, key_of

try:
    import pyarrow
    from pyarrow import parquet
except ImportError:  # Reported where a data set is written: the module can be imported without.
    pyarrow = None

CARD, VERSION = "README.md", "v3.0"
FOLDER = RecordFolder("new LeRobot data set", CARD, ())  # Nothing that is there is replaced.
KIND = "lifts for LeRobot"  # The kind of the journal of finished lifts.
TASK = "Lift an object of unknown friction and weight without slip and without crushing it."
FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_MOST_MB, _MOST_FILES = 100, 1000  # of a data file; of files in a chunk
_QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
_COUNTERS = ("frame_index", "episode_index", "index", "task_index")


@dataclass(frozen=True)
class Lift:
    """One episode: its frames by feature, each (n, values), and what its row of meta holds."""

    frames: dict[str, Array]
    about: dict[str, Any]

    def stored(self) -> dict[str, Any]:
        """It as a record of a journal: each feature's type, values of a frame, and numbers."""
        frames = {
            name: [values.dtype.str, values.shape[1], b64encode(values.tobytes()).decode("ascii")]
            for name, values in self.frames.items()
        }
        return {"frames": frames, "about": self.about}

    @classmethod
    def of_stored(cls, record: dict[str, Any]) -> Self:
        """The lift of a journal's record."""
        frames = {
            name: np.frombuffer(b64decode(coded), kind).reshape(-1, width)
            for name, (kind, width, coded) in record["frames"].items()
        }
        return cls(frames, record["about"])


def lifts_of(bench: Bench, cells: Sequence[Cell]) -> list[Lift]:
    """The episodes of one batch, without those that failed in the model."""
    found = []
    for cell, episode in bench.episodes(cells):
        if episode.result.outcome != "failed" and len(episode.samples) > 1:
            about = {"controller": cell.controller, "friction_coefficient": cell.friction}
            about |= {"object_mass_g": cell.mass_g, "noise_microstrain": cell.noise}
            about |= {"fault": cell.fault, "finger": cell.plant, "outcome": episode.result.outcome}
            about |= {"success": episode.result.success}
            found.append(Lift(_frames(episode), about))
    return found


def _frames(episode: Episode) -> dict[str, Array]:
    trace, samples = episode.trace, episode.samples
    hand = trace.shear if trace.rise is None else trace.shear + trace.rise
    forces = [(each.normal_force, each.tangential_force) for each in samples]
    places = np.column_stack([trace.approach, hand, [float(each.lifted) for each in samples]])
    state = np.hstack([np.array([each.readings for each in samples]), forces, places])
    done = np.arange(1, len(samples)) == len(samples) - 1
    success = done & episode.result.success
    return {
        "observation.state": np.float32(state[:-1]),
        "action": np.float32(np.column_stack([trace.dx, trace.dy])[1:]),
        "next.reward": success[:, None].astype(np.float32),
        "next.done": done[:, None],
        "next.success": success[:, None],
    }


def refuse(rate_Hz: float) -> None:
    """Refuse before work: MissingExtra without pyarrow, DesignError for a rate that the format,
    which has whole frames a second, cannot hold."""
    needs("lerobot", "pyarrow")
    if rate_Hz != round(rate_Hz):
        bound = "a whole number for a LeRobot data set: its frames a second are whole"
        raise DesignError([Fault("grip.hardware.sample_rate_Hz", rate_Hz, bound, "set it to one")])


def features(gages: int) -> dict[str, dict[str, Any]]:
    """Types, shapes and names as info.json has them; mm, N, microstrain."""
    state = [f"gage_{k + 1}" for k in range(gages)]
    state += ["normal_force", "tangential_force", "closing", "hand", "lifted"]

    def one(kind: str, names: list[str] | None = None) -> dict[str, Any]:
        return {"dtype": kind, "shape": [len(names or [0])], "names": names}

    return {
        "observation.state": one("float32", state),
        "action": one("float32", ["dx", "dy"]),
        "next.reward": one("float32"),
        "next.done": one("bool"),
        "next.success": one("bool"),
        "timestamp": one("float32"),
        **{name: one("int64") for name in _COUNTERS},
    }


def write_lifts(
    bench: Bench,
    rate_Hz: float,
    batches: Sequence[Sequence[Cell]],
    folder: Path,
    journal: Journal,
    workers: int = 1,
    report: Report = lambda message, fraction: None,
) -> dict[str, Any]:
    """Run all cells that the journal does not hold, and write the lifts of all in the order of
    their cells; return what info.json holds, and ``left_out``: the number of lifts that came to no
    end (a bench or a solver failed).

    Raises DesignError as :func:`refuse` and for a damaged journal, SolverError where a process died
    or no lift came to its end.
    """
    refuse(rate_Hz)
    left = [cells for cells in batches if _key(cells) not in journal]
    every = sum(map(len, batches))
    done = every - sum(map(len, left))
    for cells, lifts in in_processes(lifts_of, bench, left, workers):
        journal.add({_key(cells): [lift.stored() for lift in lifts]})
        done += len(cells)
        report(f"lifting: {done} of {every} lifts", done / every)
    writer = _Writer(folder, rate_Hz)
    for cells in batches:
        try:
            lifts = [Lift.of_stored(record) for record in journal.get(_key(cells))]
        except (LookupError, TypeError, ValueError) as error:
            raise journal.foreign() from error
        for lift in lifts:
            writer.add(lift)
    return writer.close() | {"left_out": every - len(writer.rows)}


def _key(cells: Sequence[Cell]) -> str:
    """The key of a batch in a journal."""
    return " ".join(key_of(cell, "") for cell in cells)


class _Writer:
    """Files of one data set: ``add`` each episode, then ``close``."""

    def __init__(self, folder: Path, rate_Hz: float) -> None:
        self._folder, self._rate = folder, rate_Hz
        self.rows: list[dict[str, Any]] = []
        self._columns: dict[str, list[Array]] = {}
        self._frames = self._file = 0
        self._bytes = _MOST_MB * 2**20
        self._data: Any = None

    def add(self, lift: Lift) -> None:
        """Write one episode as a row group."""
        count, number = len(lift.frames["action"]), len(self.rows)
        own: dict[str, Any] = dict(lift.frames)
        own["timestamp"] = (np.arange(count) / self._rate)[:, None].astype(np.float32)
        place = np.arange(count, dtype=np.int64)[:, None]
        counters = place, np.full_like(place, number), place + self._frames, np.zeros_like(place)
        own |= dict(zip(_COUNTERS, counters, strict=True))
        table = pyarrow.table({name: _column(values) for name, values in own.items()})
        if self._bytes + table.nbytes > _MOST_MB * 2**20:
            self._next_file(table.schema)
        self._data.write_table(table)
        self._bytes += table.nbytes
        ends = {"dataset_from_index": self._frames, "dataset_to_index": self._frames + count}
        chunk, file = divmod(self._file - 1, _MOST_FILES)
        row = {"episode_index": number, "tasks": [TASK], "length": count, **lift.about, **ends}
        row |= {"data/chunk_index": chunk, "data/file_index": file}
        row |= {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0}
        for name, values in own.items():
            self._columns.setdefault(name, []).append(values)
            row |= {f"stats/{name}/{key}": each for key, each in _statistics(values).items()}
        self.rows.append(row)
        self._frames += count

    def _next_file(self, schema: Any) -> None:
        if self._data is not None:
            self._data.close()
        chunk, file = divmod(self._file, _MOST_FILES)
        path = self._folder / "data" / FILE.format(chunk_index=chunk, file_index=file)
        path.parent.mkdir(parents=True, exist_ok=True)
        self._data, self._bytes = parquet.ParquetWriter(path, schema), 0
        self._file += 1

    def close(self) -> dict[str, Any]:
        """Write what is known of all."""
        if self._data is None:
            raise SolverError("no lift came to its end: no data set was written")
        self._data.close()
        meta, gages = self._folder / "meta", self._columns["observation.state"][0].shape[1] - 5
        episodes = meta / "episodes" / FILE.format(chunk_index=0, file_index=0)
        episodes.parent.mkdir(parents=True)
        parquet.write_table(pyarrow.Table.from_pylist(self.rows), episodes)
        parquet.write_table(_tasks(), meta / "tasks.parquet")
        columns = self._columns.items()
        stats = {name: _statistics(np.concatenate(values)) for name, values in columns}
        info = {
            "codebase_version": VERSION,
            "robot_type": "fingerdesign",
            "total_episodes": len(self.rows),
            "total_frames": self._frames,
            "total_tasks": 1,
            "chunks_size": _MOST_FILES,
            "data_files_size_in_mb": _MOST_MB,
            "video_files_size_in_mb": 2 * _MOST_MB,
            "fps": round(self._rate),
            "splits": {"train": f"0:{len(self.rows)}"},
            "data_path": f"data/{FILE}",
            "video_path": None,
            "features": features(gages),
        }
        (meta / "stats.json").write_text(json_text(stats), encoding="utf-8")
        (meta / "info.json").write_text(json_text(info), encoding="utf-8")
        held = sum(row["success"] for row in self.rows)
        card = f"---\ntask_categories: [robotics]\ntags: [LeRobot, tactile]\n---\n{TASK}\n"
        lifts = f"{len(self.rows)} simulated lifts by fingerdesign, {held} of them successes.\n"
        (self._folder / CARD).write_text(card + lifts, encoding="utf-8")
        return info


def _column(values: Array) -> Any:
    """Rows (n, k) as a column of lists of k; of one value, as a column of it."""
    flat = pyarrow.array(values.ravel())
    many = values.shape[1] > 1
    return pyarrow.FixedSizeListArray.from_arrays(flat, values.shape[1]) if many else flat


def _statistics(values: Array) -> dict[str, list[Any]]:
    """Least, greatest, mean, deviation, number and quantiles of each column."""
    numbers = values.astype(float)
    found = {"min": numbers.min(axis=0), "max": numbers.max(axis=0), "mean": numbers.mean(axis=0)}
    found |= {"std": numbers.std(axis=0), "count": np.array([len(values)])}
    quantiles = np.quantile(numbers, list(_QUANTILES.values()), axis=0)
    found |= dict(zip(_QUANTILES, quantiles, strict=True))
    return {name: each.tolist() for name, each in found.items()}


def _tasks() -> Any:
    """The task by its words: an index of pandas, as the format has it."""
    kinds = {"task_index": ("int64", "int64"), "task": ("unicode", "object")}
    columns = [
        {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": own, "metadata": None}
        for name, (kind, own) in kinds.items()
    ]
    about = {"index_columns": ["task"], "column_indexes": [], "columns": columns}
    table = pyarrow.table({"task_index": [0], "task": [TASK]})
    return table.replace_schema_metadata({"pandas": json.dumps(about)})
