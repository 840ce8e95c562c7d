"""Files under a kept mesh's name that are no mesh: nothing is kept, and nothing crashes."""

import io
import json

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.mesh.cache import keep_mesh, load_mesh
from fingerdesign.mesh.section.extrude import extrude

DESIGN = parse_design(
    'design.name = "kept"\nplates.count = 0\nmesh.contact_size_mm = 2.0\nmesh.layers = 1'
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path))
    return tmp_path / "meshes"


def npz(**arrays):
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def npy(array):
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def about(**changes):
    return np.array(
        json.dumps({"facets": ["base"], "mesher": "x", "symmetric": True, "notes": {}} | changes)
    )


GOOD = {
    "points": np.zeros((3, 3)),
    "cells": np.zeros((1, 10), dtype=int),
    "regions": np.zeros(1, dtype=int),
    "facets_base": np.zeros((1, 6), dtype=int),
}


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"garbage",
        npy(np.zeros(3)),
        npz(**GOOD, about=np.array("[]")),
        npz(**GOOD, about=about(facets=3)),
        npz(**{**GOOD, "cells": np.full((1, 10), 99)}, about=about()),
        npz(**{**GOOD, "points": np.zeros((0, 3))}, about=about()),
        npz(**{**GOOD, "points": np.full((3, 3), np.nan)}, about=about()),
    ],
    ids=["empty", "text", "an array", "list", "facets", "numbers", "no points", "nan"],
)
def test_garbage_is_nothing_kept(folder, content):
    folder.mkdir()
    (folder / "key.npz").write_bytes(content)
    assert load_mesh("key") is None


def test_a_mesh_comes_back_as_it_was(folder):
    mesh = extrude(DESIGN, 2.0)
    assert keep_mesh("key", mesh)
    again = load_mesh("key")
    assert np.array_equal(again.points, mesh.points)
    assert np.array_equal(again.cells, mesh.cells)


def test_a_folder_that_cannot_be_written_costs_nothing_but_the_keeping(tmp_path, monkeypatch):
    in_the_way = tmp_path / "file"
    in_the_way.write_text("mine")
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(in_the_way))
    assert not keep_mesh("key", extrude(DESIGN, 2.0))
    assert load_mesh("key") is None
