"""The estimator's network as ONNX, for whatever runs such files on a hand.

    Path("estimator.onnx").write_bytes(onnx_file(estimator))

One network, that for the estimator's noise, in single precision:

    features (n, f)  ->  least(greatest((features - center) / scale, -5), 5)  ->  layers
                     ->  stick_ratio_and_used (n, 2), both within 0 and 1; doubt (n, 1)

with 0 in place of what is not a number: features of a gage that is dead. What the features are,
numpy says (estimator.py), or C (c_code.py); the regulator, which moves and remembers, is no network
and leaves as C alone.
"""

from typing import Any

import numpy as np

from fingerdesign.control.estimator import OUTLIER, GripEstimator, feature_count
from fingerdesign.errors import DesignError, Fault

ONNX_FILE = "estimator.onnx"
_OPSET, _IR = 17, 8  # of 2022: what small runtimes read
_INPUT, _OUTPUT, _DOUBT = "features", "stick_ratio_and_used", "doubt"


def onnx_file(estimator: GripEstimator) -> bytes:
    """The file's content. Raises DesignError where onnx is not installed."""
    try:
        from onnx import checker, numpy_helper, parser
    except ImportError as error:
        remedy = "pip install 'fingerdesign[onnx]'"
        raise DesignError(
            [Fault("onnx", "not installed", "there to write its files", remedy)]
        ) from (error)
    band, count = estimator.band, feature_count(estimator.gages)
    constants: dict[str, Any] = {"center": band.center, "scale": band.scale, "zero": 0, "one": 1}
    constants |= {"least": -OUTLIER, "greatest": OUTLIER}
    nodes = [f"off = Sub({_INPUT}, center)", "scaled = Div(off, scale)"]
    nodes += ["unknown = IsNaN(scaled)", "known = Where(unknown, zero, scaled)"]
    nodes.append("rows_0 = Clip(known, least, greatest)")
    for k, each in enumerate(band.layers):
        constants |= {f"weight_{k}": each.weight, f"bias_{k}": each.bias}
        nodes.append(f"product_{k} = MatMul(rows_{k}, weight_{k})")
        nodes.append(f"sum_{k} = Add(product_{k}, bias_{k})")
        nodes.append(f"rows_{k + 1} = Relu(sum_{k})")
    nodes[-1] = f"both, {_DOUBT} = Split <axis = 1> (sum_{len(band.layers) - 1}, parts)"
    nodes.append(f"{_OUTPUT} = Clip(both, zero, one)")
    model = parser.parse_model(
        f'<ir_version: {_IR}, opset_import: ["" : {_OPSET}]> estimator '
        f"(float[n, {count}] {_INPUT}) => (float[n, 2] {_OUTPUT}, float[n, 1] {_DOUBT}) "
        f"{{ {' '.join(nodes)} }}"
    )
    model.doc_string = f"{estimator.design}, {estimator.noise:g} microstrain"
    model.graph.initializer.extend(
        numpy_helper.from_array(np.asarray(value, dtype=np.float32), name)
        for name, value in constants.items()
    )
    model.graph.initializer.append(numpy_helper.from_array(np.array([2, 1]), "parts"))
    checker.check_model(model, full_check=True)
    return bytes(model.SerializeToString())
