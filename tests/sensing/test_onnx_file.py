"""The estimator's network as ONNX: the bits of numpy in singles, read by onnx's own evaluator."""

import sys

import numpy as np
import pytest

from fingerdesign.control.estimator import feature_count
from fingerdesign.errors import DesignError
from fingerdesign.sensing.onnx_file import onnx_file
from tests.control.test_estimator import GAGES, estimator

S = np.float32


def in_singles(band, rows):
    values = np.clip((rows - S(band.center)) / S(band.scale), S(-5.0), S(5.0))
    values[np.isnan(values)] = S(0.0)
    for k, layer in enumerate(band.layers):
        values = values @ S(layer.weight) + S(layer.bias)
        values = values if k + 1 == len(band.layers) else np.maximum(values, S(0.0))
    return np.clip(values[:, :2], S(0.0), S(1.0)), values[:, 2:]


def test_its_bits_are_numpys_and_a_noise_has_its_own_network():
    reference = pytest.importorskip("onnx.reference")
    taught = estimator()
    rows = S(0.2 * np.random.default_rng(1).standard_normal((50, feature_count(GAGES))))
    rows[::7, 3] = np.nan  # of a gage that is dead
    session = reference.ReferenceEvaluator(onnx_file(taught))
    for found, expected in zip(
        session.run(None, {"features": rows}), in_singles(taught.band, rows), strict=True
    ):
        assert found.dtype == S
        assert np.array_equal(found.view(np.int32), expected.view(np.int32))
    found, expected = session.run(None, {"features": rows})[0], in_singles(taught.band, rows)[0]
    assert np.mean((expected > 0.0) & (expected < 1.0)) > 0.0
    double = np.clip(taught.band.evaluate(rows.astype(float))[:, :2], 0.0, 1.0)
    assert found == pytest.approx(double, abs=1e-4)
    assert onnx_file(taught.at_noise(0.5)) != onnx_file(taught.at_noise(5.0))


def test_without_onnx_the_remedy_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "onnx", None)
    with pytest.raises(DesignError, match="fingerdesign\\[onnx\\]"):
        onnx_file(estimator())
