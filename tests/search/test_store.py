"""Outcomes on disk: what is put is got, whole; what is invalid is absent; failures and --retry."""

import json
import os
import stat
from dataclasses import replace

import pytest

from fingerdesign.records.outcome import Failure, Outcome
from fingerdesign.search.run.run import Store, StoreError

DIGEST = "ab" + "0" * 62


def outcome(**changes):
    reported = {
        "digest": DIGEST,
        "name": "a\nname\u2028 of 'any' sort",
        "values": {"plates.count": 9},
        "design": {"design": {"name": "x"}},
        "scene": "fundamental",
        "fidelity": "plane-strain",
        "status": "ok",
        "metrics": {"cost": 1.5, "stick_error": None},
    }
    return Outcome(**(reported | changes))


def failed(kind):
    return outcome(status="failed", failure=Failure(kind, "why"))


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "store")


def test_what_is_put_is_got(store):
    assert store.get(DIGEST) is None
    store.put(outcome())
    assert store.get(DIGEST) == outcome()
    store.put(outcome(name="later"))
    assert store.get(DIGEST).name == "later"
    assert [path.name for path in store.folder.rglob("*.*")] == [f"{DIGEST}.txt"]


def test_any_cut_or_changed_byte_is_found(store):
    store.put(outcome())
    (path,) = store.folder.rglob("*.txt")
    whole = path.read_bytes()
    for length in (0, 1, 64, 65, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        assert store.get(DIGEST) is None
    for place in (0, 64, 70, len(whole) // 2, len(whole) - 1):
        changed = bytearray(whole)
        changed[place] ^= 1
        path.write_bytes(bytes(changed))
        assert store.get(DIGEST) is None
    path.write_bytes(whole + b" ")
    assert store.get(DIGEST) is None
    path.write_bytes(whole)
    assert store.get(DIGEST) == outcome()


def test_an_outcome_under_another_digest_is_none(store):
    store.put(outcome())
    (path,) = store.folder.rglob("*.txt")
    other = "ab" + "1" * 62
    path.rename(path.with_name(f"{other}.txt"))
    assert store.get(other) is None


def test_an_older_format_is_none(store, monkeypatch):
    store.put(replace(outcome(), schema_version=0))
    assert store.get(DIGEST) is None
    monkeypatch.setattr(Outcome, "to_json", lambda self: json.dumps({"digest": DIGEST}))
    store.put(outcome())
    assert store.get(DIGEST) is None


@pytest.mark.parametrize("kind", ["crashed", "timeout", "memory", "failed"])
def test_what_may_fare_better_is_tried_again(store, kind):
    store.put(failed(kind))
    assert store.get(DIGEST) == failed(kind)
    assert store.get(DIGEST, retry=True) is None


def test_a_refusal_stays(store):
    store.put(failed("refused"))
    assert store.get(DIGEST, retry=True) == failed("refused")


def test_no_room_or_right_is_an_error_and_leaves_nothing(store, monkeypatch):
    def full(number):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(StoreError, match="No space left on device"):
        store.put(outcome())
    assert [path for path in store.folder.rglob("*") if path.is_file()] == []
    monkeypatch.undo()
    store.folder.joinpath("ab").rmdir()
    store.folder.joinpath("ab").write_text("in the way")
    with pytest.raises(StoreError, match="cannot be kept"):
        store.put(outcome())


@pytest.mark.parametrize("digest", ["", "../../etc/passwd", "AB" * 32, "ab" * 31, f"{DIGEST}/x"])
def test_only_digests_name_files(store, digest):
    with pytest.raises(ValueError, match="is no digest"):
        store.get(digest)
    with pytest.raises(ValueError, match="is no digest"):
        store.put(outcome(digest=digest))
    assert not store.folder.exists()


def test_what_a_killed_driver_left_is_cleared_away(store):
    store.put(outcome())
    old, new = (store.folder / "ab" / name for name in (".0123456789ab", ".ba9876543210"))
    for path in (old, new):
        path.write_text("half")
    os.utime(old, (0, 0))
    store.clear()
    assert not old.exists()
    assert new.exists()  # another driver may be writing it
    assert store.get(DIGEST) == outcome()
    assert stat.S_ISDIR(store.folder.stat().st_mode)


def test_a_folder_in_the_place_of_a_file_is_moved_away(store):
    (store.folder / "ab" / f"{DIGEST}.txt" / "kept").mkdir(parents=True)
    assert store.get(DIGEST) is None
    store.put(outcome())
    assert store.get(DIGEST) == outcome()
    assert len(list(store.folder.rglob("kept"))) == 1
