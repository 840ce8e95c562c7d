"""What is measured of the machine, and how long it is believed."""

import json
import os
import time
from dataclasses import asdict

from fingerdesign.runtime import machine
from fingerdesign.runtime.cache import Cache


def test_speed_and_cores_are_plausible():
    found = machine.measure_machine()
    assert 0.1 < found.one_core <= found.all_cores < 1e5
    assert 1 <= found.cores <= (os.cpu_count() or 1)


def test_memory_is_no_more_than_there_is():
    free = machine.available_memory_MB()
    if free is not None:
        pages = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        assert 0.0 < free <= pages / 2**20


def test_a_kept_speed_is_believed_for_a_day_and_no_garbage(tmp_path):
    kept, name = Cache("machines", folder=tmp_path / "deep"), "any"
    speed = machine.Machine(50.0, 90.0, machine.usable_cores())
    assert machine._read(kept, name) is None
    kept.put_text(name, json.dumps(asdict(speed)))
    assert machine._read(kept, name) == speed
    old = time.time() - 2 * 86_400
    os.utime(kept.path(name), (old, old))
    assert machine._read(kept, name) is None
    for text in ("", "{}", "[]", '{"one_core": -1, "all_cores": 2, "cores": 1}'):
        kept.put_text(name, text)
        assert machine._read(kept, name) is None


def test_a_control_group_lessens_cores_and_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(machine, "_CGROUP", tmp_path)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    assert machine.usable_cores() == 8
    (tmp_path / "cpu.max").write_text("300000 100000\n")
    assert machine.usable_cores() == 3
    (tmp_path / "memory.max").write_text(str(50 * 2**20))
    (tmp_path / "memory.current").write_text(str(20 * 2**20))
    assert machine.available_memory_MB() == 30.0
