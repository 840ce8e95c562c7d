"""The estimator's network as ONNX, for whatever runs such files on a hand.

    Path("estimator.onnx").write_bytes(onnx_file(estimator))

One network, that for the estimator's noise, in single precision:

    features (n, f)  ->  least(greatest((features - center) / scale, -5), 5)  ->  layers
                     ->  stick_ratio_and_used (n, 2), both within 0 and 1

What the features are, numpy says (estimator.py), or C (c_code.py); the regulator, which moves and
remembers, is no network and leaves as C alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.estimator import OUTLIER, GripEstimator, feature_count
from fingerdesign.errors import DesignError, Fault

if TYPE_CHECKING:
    from numpy.typing import NDArray

ONNX_FILE = "estimator.onnx"
_OPSET, _IR = 17, 8  # of 2022: what small runtimes read
_INPUT, _OUTPUT = "features", "stick_ratio_and_used"


def onnx_file(estimator: GripEstimator) -> bytes:
    """The file's content. Raises DesignError where onnx is not installed."""
    try:
        from onnx import TensorProto, checker, helper, numpy_helper
    except ImportError as error:
        remedy = "pip install 'fingerdesign[onnx]'"
        raise DesignError(
            [Fault("onnx", "not installed", "there to write its files", remedy)]
        ) from (error)
    graph = _Graph()
    band = estimator.band
    rows = graph.add("Sub", _INPUT, graph.constant(band.center))
    rows = graph.add("Div", rows, graph.constant(band.scale))
    rows = graph.clipped(rows, -OUTLIER, OUTLIER)
    for k, each in enumerate(band.layers):
        rows = graph.add("MatMul", rows, graph.constant(each.weight))
        rows = graph.add("Add", rows, graph.constant(each.bias))
        rows = graph.add("Relu", rows) if k + 1 < len(band.layers) else rows
    graph.clipped(rows, 0.0, 1.0, _OUTPUT)

    def of_columns(name: str, columns: int) -> Any:
        return helper.make_tensor_value_info(name, TensorProto.FLOAT, ["n", columns])

    model = helper.make_model(
        helper.make_graph(
            [helper.make_node(kind, inputs, [output]) for kind, inputs, output in graph.nodes],
            "estimator",
            [of_columns(_INPUT, feature_count(estimator.gages))],
            [of_columns(_OUTPUT, 2)],
            [numpy_helper.from_array(value, name) for name, value in graph.constants.items()],
        ),
        opset_imports=[helper.make_opsetid("", _OPSET)],
        ir_version=_IR,
        doc_string=f"{estimator.design}, {estimator.noise:g} microstrain",
    )
    checker.check_model(model, full_check=True)
    return bytes(model.SerializeToString())


class _Graph:
    """Nodes (operation, inputs, output) in their order, and constants in single precision."""

    def __init__(self) -> None:
        self.nodes: list[tuple[str, list[str], str]] = []
        self.constants: dict[str, NDArray[np.float32]] = {}

    def constant(self, value: Array | float) -> str:
        name = f"constant_{len(self.constants)}"
        self.constants[name] = np.asarray(value, dtype=np.float32)
        return name

    def add(self, kind: str, *inputs: str, output: str | None = None) -> str:
        output = output or f"values_{len(self.nodes)}"
        self.nodes.append((kind, list(inputs), output))
        return output

    def clipped(self, rows: str, low: float, high: float, output: str | None = None) -> str:
        return self.add("Clip", rows, self.constant(low), self.constant(high), output=output)
