"""The netgen process that stays: the same answers, and what becomes of one that fails."""

import threading
from dataclasses import asdict

import numpy as np
import pytest

from fingerdesign.errors import MeshError
from fingerdesign.mesh.section.netgen import run_netgen, start_mesher
from fingerdesign.mesh.section.outline import BODY, Outline


def square(size, width=1.0):
    outline = Outline(size, 0.3)
    corners = [outline.point(x * width, y) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)):
        outline.curve([corners[a], corners[b]], BODY, 0, size)
    return asdict(outline)


def test_one_process_answers_again_and_again_and_alike():
    first, number = run_netgen(square(0.2), 30.0), start_mesher().pid
    run_netgen(square(0.1, 3.0), 30.0)
    again = run_netgen(square(0.2), 30.0)
    assert start_mesher().pid == number
    for one, two in zip(first, again, strict=True):
        assert np.array_equal(one, two)
    points, triangles, domains = first
    corners = points[triangles]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum()
    assert area == pytest.approx(1.0, rel=1e-12)
    assert set(domains.tolist()) == {BODY}


def test_a_bad_outline_fails_in_words_and_the_next_mesh_is_made():
    with pytest.raises(MeshError, match="it failed: KeyError"):
        run_netgen({"points": []}, 30.0)
    assert len(run_netgen(square(0.5), 30.0)[1]) > 0


def test_out_of_time_ends_the_process_and_the_next_mesh_is_made():
    old = start_mesher()
    with pytest.raises(MeshError, match=r"did not finish in 0\.2 s"):
        run_netgen(square(0.001), 0.2)
    assert not old.alive
    assert len(run_netgen(square(0.5), 30.0)[1]) > 0


def test_each_thread_has_its_own():
    found: list[tuple[int, int]] = []

    def work():
        triangles = run_netgen(square(0.2), 30.0)[1]
        found.append((start_mesher().pid, len(triangles)))

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found[0][0] != found[1][0]
    assert found[0][1] == found[1][1]
