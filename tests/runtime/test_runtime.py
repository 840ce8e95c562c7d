"""Files whole or not at all, locks, cached arrays and texts, journals, and pools of processes."""

import os
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing

import numpy as np
import pytest

from fingerdesign.errors import DesignError, GeometryError
from fingerdesign.runtime import files, machine
from fingerdesign.runtime.cache import Cache, CacheError
from fingerdesign.runtime.isolate import ProcessError
from fingerdesign.runtime.journal import Journal, JournalError, held
from fingerdesign.runtime.machine import largest_memory_MB, processor_seconds
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.progress import ForecastProgress
from tests.support import calls


def test_a_file_is_whole_or_not_at_all(tmp_path):
    path = tmp_path / "a.txt"
    assert files.write_whole(path, "one\n", durable=True).read_bytes() == b"one\n"
    with pytest.raises(UnicodeEncodeError):
        files.write_whole(path, "\ud800")
    with pytest.raises(FileNotFoundError), files.whole_file(path) as aside:
        (aside / "in a file").write_text("two")
    assert path.read_text() == "one\n"
    with pytest.raises(OSError, match="No such file"), files.whole_file(path):
        pass  # nothing was written
    assert [each.name for each in tmp_path.iterdir()] == ["a.txt"]


def test_a_file_takes_no_pipes_place_and_follows_no_link(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(tmp_path / "pipe")
    for name in ("pipe", "link", "."):
        with pytest.raises(OSError, match="not a regular file"):
            files.write_whole(tmp_path / name, "x")
    assert (tmp_path / "pipe").is_fifo()
    (tmp_path / "real").write_text("somebody's")
    (tmp_path / "to").symlink_to(tmp_path / "real")
    files.write_whole(tmp_path / "to", "x")
    assert (tmp_path / "to").read_text() == "x"
    assert (tmp_path / "real").read_text() == "somebody's"


def test_a_full_disk_is_named(tmp_path, full_disk):
    journal = Journal(tmp_path / "j.sqlite", "a trial", "d")
    journal.add({"a": 1})
    journal._base.execute("pragma max_page_count = 4")
    with pytest.raises(JournalError, match=r"j\.sqlite cannot be written: .* full; free space"):
        journal.add({"b": "x" * 100_000})
    with pytest.raises(OSError, match=r"No space left on device: '.*/page\.html'"):
        files.write_whole(tmp_path / "page.html", "x", durable=True)
    assert not list(tmp_path.glob("*page*"))


def test_a_folder_takes_an_older_ones_place(tmp_path):
    target = tmp_path / "out"
    for text in ("one", "two"):
        with files.whole_folder(target) as aside:
            (aside / "a.txt").write_text(text)
            files.take_place(aside, target)
    assert (target / "a.txt").read_text() == "two"
    with pytest.raises(FileNotFoundError):
        files.take_place(tmp_path / "nothing", target)
    assert (target / "a.txt").read_text() == "two"  # put back
    assert [each.name for each in tmp_path.iterdir()] == ["out"]


KILLED = """
import os, pathlib, signal, sys
from fingerdesign.runtime.files import whole_folder
with whole_folder(pathlib.Path(sys.argv[1])) as aside:
    (aside / "a.txt").write_text("half")
    print("made", flush=True)
    sys.stdin.read()
    os.kill(os.getpid(), signal.SIGKILL)
"""


def partial_folders(target):
    return [each for each in target.parent.iterdir() if ".partial-" in each.name]


def test_the_next_run_of_a_name_removes_what_a_killed_one_left_and_nothing_else(tmp_path):
    target = tmp_path / "out"
    others = [tmp_path / ".out.partial-mine", tmp_path / ".other.partial-01234567"]
    for each in others:
        each.mkdir()
    command = [sys.executable, "-c", KILLED, str(target)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"made\n"
        for each in partial_folders(target):  # no longer fresh
            os.utime(each, (0.0, 0.0))
        with files.whole_folder(target):  # the other one is still at work
            assert len(partial_folders(target)) == 4
        process.communicate()
    assert process.returncode == -signal.SIGKILL
    assert len(partial_folders(target)) == 3
    older = tmp_path / ".out.older-01234567"
    older.mkdir()
    os.utime(older, (0.0, 0.0))
    with files.whole_folder(target) as aside:
        assert sorted(partial_folders(target)) == sorted([aside, *others])
        assert older.exists()  # the only result that is left
        files.take_place(aside, target)
    files.sweep_abandoned(target)
    assert not older.exists()


@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o702])
@pytest.mark.parametrize("place", ["", "trial", "native"])
def test_a_cache_that_others_can_write_is_refused(mode, place, own_cache, tmp_path):
    folder = tmp_path / place
    folder.mkdir(exist_ok=True)
    folder.chmod(mode)
    try:
        with pytest.raises(CacheError, match="FINGERDESIGN_CACHE to a folder of yours"):
            Cache("native" if place == "native" else "trial")
    finally:
        folder.chmod(0o700)
    assert Cache("trial").put("a.bin", b"x").is_file()


@pytest.mark.parametrize("group", [54321, 1])  # of no name; of another's name and no members
def test_a_folder_that_another_group_can_write_is_not_private(group, tmp_path):
    try:
        os.chown(tmp_path, -1, group)
    except PermissionError:
        pytest.skip("only the administrator gives a folder to another group")
    tmp_path.chmod(0o770)
    assert files.writable_by_others([tmp_path]) == tmp_path
    tmp_path.chmod(0o750)
    assert files.writable_by_others([tmp_path]) != tmp_path


def test_a_folder_below_one_that_others_can_write_is_refused_unless_they_cannot_rename_it(
    tmp_path, cache_in
):
    shared = tmp_path / "shared"
    shared.mkdir()
    cache_in(shared / "mine")
    shared.chmod(0o777)
    with pytest.raises(CacheError, match="shared"):
        Cache("trial")
    shared.chmod(0o1777)  # as /tmp
    path = Cache("trial").put("a.bin", b"x")
    assert {each.stat().st_mode & 0o777 for each in (path.parent, shared / "mine")} == {0o700}
    path.parent.chmod(0o777)
    with pytest.raises(CacheError, match="trial"):
        Cache("trial")


def test_anothers_folder_is_no_cache(own_cache, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "getuid", lambda: tmp_path.stat().st_uid + 1)
    if tmp_path.stat().st_uid:
        with pytest.raises(CacheError):
            Cache("trial")
    else:  # the administrator's is everybody's
        assert Cache("trial").folder == tmp_path / "trial"


def test_a_lock_is_held_by_one_and_goes(tmp_path):
    path = tmp_path / ".lock"
    with (
        files.locked(path),
        pytest.raises(files.BusyError, match="held"),
        files.locked(path, wait=False),
    ):
        pass
    assert not path.exists()
    with files.locked(path, wait=False):
        assert path.exists()


@pytest.fixture
def cache(own_cache):
    return Cache("trial", most=3)


def test_arrays_and_texts_come_back_or_are_absent_where_they_are_garbled(cache):
    assert cache.arrays("a.npz") is None
    assert cache.text("a.txt") is None
    assert cache.put_arrays("a.npz", {"x": np.arange(300)}, {"about": "it"})
    arrays, about = cache.arrays("a.npz")
    assert (arrays["x"].tolist(), about) == ([*range(300)], {"about": "it"})
    cache.put_text("a.txt", "line\nöther", durable=True)
    assert cache.text("a.txt") == "line\nöther"
    assert cache.text("a.txt", younger_than_s=60.0) == "line\nöther"
    os.utime(cache.path("a.txt"), (0, 0))
    assert cache.text("a.txt", younger_than_s=60.0) is None
    for name, read in (("a.npz", cache.arrays), ("a.txt", cache.text)):
        whole = cache.path(name).read_bytes()
        for share in (0.99, 0.3, 0.0):
            cache.path(name).write_bytes(whole[: int(share * len(whole))])
            assert read(name) is None


def test_the_longest_unused_go_first_and_leavings_in_time(cache):
    for number in range(5):
        path = cache.put(f"{number}.bin", b"x")
        os.utime(path, (number, number))
    assert sorted(path.name for path in cache.folder.iterdir()) == ["2.bin", "3.bin", "4.bin"]
    large = Cache("trial", most=3, most_MB=2.5e-6)  # two and a half bytes
    large.put("5.bin", b"xx")
    assert sorted(path.name for path in cache.folder.iterdir()) == ["5.bin"]
    cache.put("4.bin", b"x")
    cache.put_arrays("a.npz", {}, 1)
    os.utime(cache.path("a.npz"), (5, 5))
    assert cache.arrays("a.npz") == ({}, 1)
    assert cache.path("a.npz").stat().st_mtime > 5.0  # what is read is used
    old, new = cache.folder / ".old", cache.folder / ".new"
    old.write_text("")
    new.write_text("")
    os.utime(old, (0, 0))
    cache.clear()
    assert (old.exists(), new.exists()) == (False, True)


def test_a_cache_that_cannot_be_written_says_so(tmp_path, cache):
    (tmp_path / "trial").write_text("mine")
    assert not cache.put_arrays("a.npz", {}, {})
    with pytest.raises(OSError, match="trial"):
        cache.put("a.bin", b"")


def test_a_journal_keeps_records_in_their_order(tmp_path):
    path = tmp_path / "in" / "j.sqlite"
    with Journal(path, "a trial", "d") as journal:
        assert not path.exists()
        journal.add({"b": [1, 2.5, None], "a": {"x": "ö"}})
        journal.add({"c": 9.0})
        journal.add({"c": 0.1})
        assert "a" in journal
    again = Journal(path, "a trial", "d")
    assert list(again) == [("b", [1, 2.5, None]), ("a", {"x": "ö"}), ("c", 0.1)]
    assert (again.get("c"), again.get("d"), len(again)) == (0.1, None, 3)
    with closing(sqlite3.connect(path)) as base, base:
        base.execute("alter table records add column note")  # another tool's; it does no harm
    again.add({"d": 2})
    again.close()
    assert Journal(path, "a trial", "d").get("d") == 2


def test_somebodys_file_is_left_alone(tmp_path):
    path = tmp_path / "j.sqlite"
    Journal(path, "a trial", "d").add({"a": 1})
    for kind, identity, words in (
        ("a trial", "e", "of this design"),
        ("else", "d", "a journal of"),
    ):
        with pytest.raises(DesignError, match=words):
            Journal(path, kind, identity)
    assert len(Journal(path, "a trial", None)) == 1
    path.unlink()
    with closing(sqlite3.connect(path)) as base, base:
        base.execute("create table mine (x)")
    for content in (path.read_bytes(), b"notes", path.read_bytes()[:1000]):
        path.write_bytes(content)
        with pytest.raises(DesignError, match="a journal of a trial"):
            Journal(path, "a trial", "d")
        assert path.read_bytes() == content
    path.write_bytes(b"")  # ended before its first record
    assert len(Journal(path, "a trial", "d")) == 0


@pytest.mark.parametrize(
    "change",
    [
        "delete from about where key = 'identity'",
        f"update records set record = '{'[' * 100_000}'",
        """update records set record = '{"x": 1e400}'""",
        "update about set value = '0' where key = 'format'",
        "update records set record = '[NaN]'",
        f"update records set record = '1{'0' * 400}'",
    ],
)
def test_a_journal_that_is_not_whole_is_refused(tmp_path, change):
    path = tmp_path / "j.sqlite"
    Journal(path, "a trial", "d").add({"a": 1})
    with closing(sqlite3.connect(path)) as base, base:
        base.execute(change)
    with pytest.raises(DesignError, match="must be a journal of a trial; move it away"):
        Journal(path, "a trial", "d")


def test_a_journal_in_use_is_busy_and_a_pipe_is_none(tmp_path, monkeypatch):
    monkeypatch.setattr("fingerdesign.runtime.journal._WAIT_S", 0.01)
    path = tmp_path / "j.sqlite"
    Journal(path, "a trial", "d").add({"a": 1})
    with closing(sqlite3.connect(path)) as base:
        base.execute("begin exclusive")
        with pytest.raises(JournalError, match="in use by another process"):
            Journal(path, "a trial", "d")
    assert len(Journal(path, "a trial", "d")) == 1
    with held(path), pytest.raises(JournalError, match="written by another process"), held(path):
        pass
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(DesignError, match="a journal of"):
        Journal(path, "a trial", "d")


def test_a_killed_writer_leaves_whole_records(tmp_path):
    path = tmp_path / "j.sqlite"
    code = (
        "import pathlib, sys\n"
        "from fingerdesign.runtime.journal import Journal\n"
        "journal, k = Journal(pathlib.Path(sys.argv[1]), 'a trial', 'd'), 0\n"
        "while True:\n"
        "    journal.add({f'{k} {j}': 'x' * 2000 for j in range(50)})\n"
        "    k += 1\n"
    )
    process = subprocess.Popen([sys.executable, "-c", code, str(path)])
    end = time.monotonic() + 20.0
    while (not path.exists() or path.stat().st_size < 500_000) and time.monotonic() < end:
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    found = dict(Journal(path, "a trial", "d"))
    assert len(found) >= 50
    assert len(found) % 50 == 0  # all that were added at once, or none
    Journal(path, "a trial", "d").add({"more": 1})


def test_a_pool_answers_in_order_and_as_it_comes_and_goes_on_after_failures():
    with Pool(2, shared=(10,), time_s=20.0) as pool:
        assert list(pool.in_order(calls.added, [(1,), (2,), (3,)])) == [11, 12, 13]
        done = pool.as_done(lambda n: pool.call(calls.added, n), range(9))
        assert sorted(done) == [*range(10, 19)]
    with Pool(1, time_s=20.0) as pool:
        with pytest.raises(GeometryError):
            pool.call(calls.refuse, "geometry")
        with pytest.raises(ProcessError, match="SIGKILL"):
            next(pool.in_order(calls.end, [(9,)]))
        assert pool.call(calls.added, 1, 2) == 3


def test_a_pool_that_is_killed_ends_at_once(tmp_path):
    start = time.monotonic()
    with Pool(2) as pool:
        waiting = pool.as_done(lambda n: pool.call(calls.sleep, 60.0 if n else 0.0), [0, 1, 2, 3])
        assert next(waiting) == 0.0
        pool.kill()
        with pytest.raises(ProcessError):
            list(waiting)
    assert time.monotonic() - start < 30.0


BUSY = (
    "import sys, time\n"
    "while time.process_time() < 0.4: pass\n"
    "print('done', flush=True); sys.stdin.read()"
)


def test_a_child_that_lives_counts_and_once():
    before = processor_seconds()
    child = subprocess.Popen(
        [sys.executable, "-c", BUSY], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert child.stdout.readline()
    living = processor_seconds() - before
    assert 0.35 < living < 1.0
    time.sleep(0.3)  # waiting costs nothing
    child.communicate()
    assert abs(processor_seconds() - before - living) < 0.2


def test_a_process_is_not_charged_with_what_its_parent_had():
    own = np.ones(50_000_000)  # 400 MB; the system hands the peak on to what is started
    code = "from fingerdesign.runtime.machine import largest_memory_MB; print(largest_memory_MB())"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert largest_memory_MB() > 8e-6 * len(own)
    assert 5.0 < float(found.stdout) < 300.0


def test_a_control_group_lessens_cores_and_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(machine, "_CGROUP", tmp_path)
    whole = machine.usable_cores()
    (tmp_path / "cpu.max").write_text(f"{whole * 100000 + 100000} 100000\n")
    assert machine.usable_cores() == whole
    (tmp_path / "cpu.max").write_text("140000 100000\n")  # rounded
    assert machine.usable_cores() == 1
    (tmp_path / "memory.max").write_text(str(50 * 2**20))
    (tmp_path / "memory.current").write_text(str(20 * 2**20))
    assert machine.available_memory_MB() == 30.0
    for name in ("memory", "cpu"):  # as kernels of former years have them
        (tmp_path / f"{name}.max").unlink()
        (tmp_path / name).mkdir()
    for quota, cores in (("-1", None), ("250000", 2.5)):
        (tmp_path / "cpu/cpu.cfs_quota_us").write_text(quota)
        (tmp_path / "cpu/cpu.cfs_period_us").write_text("100000")
        assert machine._quota() == cores
    (tmp_path / "memory/memory.usage_in_bytes").write_text(str(2**20))
    (tmp_path / "memory/memory.limit_in_bytes").write_text(str(11 * 2**20))
    assert machine.available_memory_MB() == 10.0
    (tmp_path / "cpu.max").write_text("max 100000")
    assert machine._quota() is None


def test_the_fraction_of_a_forecast_is_of_the_stages_that_ended():
    shown, done = [], {}
    progress = ForecastProgress(lambda *told: shown.append(told), {"mesh": 3.0, "solve": 9.0}, done)
    progress("meshing")
    done["mesh"] = 99.0  # it took longer: the rest is as forecast
    progress("solving")
    ForecastProgress(progress.show, {}, {})("waiting")
    assert shown == [("meshing", 0.0, 12.0), ("solving", 0.25, 9.0), ("waiting", None, 0)]
