"""Answers of a condensed body, stored by content: the same body is never condensed twice.

Displacement fields are stored with their loads: a field is linear in its load, so a load that
stored ones make up needs no factors.

A body is identified by its mesh, fixed dofs, contact facets, functionals and *relative* moduli: one
factor on all moduli divides compliance and readouts, and changes nothing else. Friction, object,
path and controller are no part of it.
"""

import hashlib
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.runtime.cache import GARBLED, Cache, code_digest
from fingerdesign.version import __version__

# A model of 480 nodes in 3-D takes 8 MB, one of a section 0.2 MB.
MOST_MODELS, MOST_MB = 1000, 1000.0
MOST_FIELDS = 16  # of a model; two of the shipped finger in 3-D take 2 MB
_SAME_LOAD = 1e-11  # A load of which stored ones leave less than this part is made up of them.
_MOST_TIMES = 10.0  # Larger coefficients of stored fields would lose a digit and more.
_DIGITS = 12  # Digits of relative moduli: the rounding of the common factor is no difference.
# The arrays that are inversely proportional to the moduli.
_DIVIDED = ("compliance", "readouts", "between")
Answers = dict[str, Array]


def key_of(words: str, moduli: Array, parts: Iterable[Array | sp.csr_matrix | None]) -> str:
    """SHA-256 (hexadecimal) of all that answers depend on: relative moduli, arrays, words."""
    code = code_digest(Path(__file__).parent)
    content = hashlib.sha256(f"{code} {__version__} {words}".encode())
    values, place = np.unique(moduli, return_inverse=True)
    rounded = np.array([float(f"{value:.{_DIGITS}g}") for value in values])[place]
    arrays: list[NDArray[Any] | None] = [rounded]
    for part in parts:
        if isinstance(part, sp.csr_matrix):
            arrays += [part.data, part.indices, part.indptr]
        else:
            arrays.append(part)
    for array in arrays:
        whole = np.ascontiguousarray(np.empty(0) if array is None else array)
        content.update(f"{array is None} {whole.dtype} {whole.shape}".encode())
        content.update(whole.tobytes())
    return content.hexdigest()


def load_answers(key: str, modulus: float) -> tuple[Answers, int] | None:
    """Load the answers stored under a key and the number of equations; None if there are none.

    modulus: MPa, to which moduli are relative.
    """
    found = _stored("models").arrays(f"{key}.npz")
    if found is None:
        return None
    data, about = found
    try:
        size = data["readouts"].shape[1]
        lower = np.zeros((size, size))
        lower[np.tri(size, dtype=bool)] = data.pop("compliance")
        data["compliance"] = lower + np.tril(lower, -1).T
        factor = about["modulus"] / modulus
        for name in _DIVIDED:
            data[name] = factor * data[name]
        return data, int(about["dofs"])
    except GARBLED:
        return None


def store_answers(key: str, modulus: float, answers: Answers, dofs: int) -> bool:
    """Store answers under a key; False where the folder cannot be written (the work goes on)."""
    compliance = answers["compliance"]
    arrays = answers | {"compliance": compliance[np.tri(len(compliance), dtype=bool)]}
    about = {"modulus": modulus, "dofs": dofs}
    return _stored("models").put_arrays(f"{key}.npz", arrays, about, packed=False)


def has_fields(key: str) -> bool:
    """True if fields of the model with this key are stored."""
    return bool(key) and _stored("fields").path(f"{key}.npz").is_file()


def load_fields(key: str, modulus: float, forces: Array) -> Array | None:
    """Make the nodal displacements (k, n dim) under contact forces (k, m dim) of stored ones. None
    where the stored loads do not make up these."""
    found = _stored("fields").arrays(f"{key}.npz")
    if found is None:
        return None
    data, about = found
    try:
        loads, fields = data["loads"], data["fields"] * (about["modulus"] / modulus)
        share = np.linalg.lstsq(loads.T, forces.T, rcond=None)[0].T
        left = np.linalg.norm(share @ loads - forces, axis=1)
        if (left > _SAME_LOAD * np.linalg.norm(forces, axis=1)).any():
            return None
        return None if np.abs(share).max(initial=0.0) > _MOST_TIMES else share @ fields
    except (*GARBLED, np.linalg.LinAlgError):
        return None


def store_fields(key: str, modulus: float, forces: Array, fields: Array) -> bool:
    """Store fields (k, n dim) with their forces, before those of earlier calls; of all the first
    MOST_FIELDS. False where the folder cannot be written."""
    arrays = {"loads": forces, "fields": fields}
    if (older := _stored("fields").arrays(f"{key}.npz")) is not None:
        data, about = older
        with suppress(*GARBLED):
            scaled = data["fields"] * (about["modulus"] / modulus)
            arrays = {
                "loads": np.vstack([forces, data["loads"]])[:MOST_FIELDS],
                "fields": np.vstack([fields, scaled])[:MOST_FIELDS],
            }
    return _stored("fields").put_arrays(f"{key}.npz", arrays, {"modulus": modulus}, packed=False)


def _stored(kind: str) -> Cache:
    """The cache of answers ("models") or of fields ("fields")."""
    return Cache(kind, MOST_MODELS, most_MB=MOST_MB)
