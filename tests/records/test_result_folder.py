"""Several writers of one result folder, and renaming that fails half-way."""

import json
import multiprocessing
from pathlib import Path

import pytest

from fingerdesign.records.base import ResultError
from fingerdesign.records.folder import RESULTS


def write(target, text):
    with RESULTS.written(target) as folder:
        (folder / "result.json").write_text(json.dumps(text), encoding="utf-8")


def write_often(target):
    for number in range(100):
        write(target, str(number))


def test_writers_of_one_folder_take_turns(tmp_path):
    context = multiprocessing.get_context("spawn")
    writers = [context.Process(target=write_often, args=(tmp_path / "a",)) for _ in range(3)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert [writer.exitcode for writer in writers] == [0, 0, 0]
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert json.loads((tmp_path / "a" / "result.json").read_text("utf-8")) == "99"


def failing(monkeypatch, names, error):
    rename = Path.rename

    def refuse(self, target):
        if any(name in self.name for name in names):
            raise error
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", refuse)


def test_an_interruption_between_the_renamings_puts_the_older_result_back(tmp_path, monkeypatch):
    write(tmp_path / "a", "older")
    failing(monkeypatch, [".partial-"], KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        write(tmp_path / "a", "new")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert json.loads((tmp_path / "a" / "result.json").read_text("utf-8")) == "older"


def test_an_older_result_that_cannot_be_put_back_is_kept(tmp_path, monkeypatch):
    write(tmp_path / "a", "older")
    failing(monkeypatch, [".partial-", ".older-"], OSError("no"))
    with pytest.raises(ResultError, match="the older result is in"):
        write(tmp_path / "a", "new")
    (kept,) = tmp_path.iterdir()
    assert json.loads((kept / "result.json").read_text("utf-8")) == "older"


def test_a_folder_that_cannot_be_listed_is_a_result_error(tmp_path, monkeypatch):
    def refuse(self):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "iterdir", refuse)
    with pytest.raises(ResultError, match="cannot look into"):
        RESULTS.refuse_foreign(tmp_path)


def test_a_file_system_without_locks_loses_no_work(tmp_path, monkeypatch):
    fcntl = pytest.importorskip("fcntl")

    def refuse(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr(fcntl, "flock", refuse)
    write(tmp_path / "a", "new")
    assert (tmp_path / "a" / "result.json").is_file()
