"""Sparse matrices joined with few copies: a stiffness in 3-D has 10 million entries."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray


def merged(
    large: sp.csr_matrix, added: sp.csr_matrix, place: NDArray[np.int32] | None = None
) -> sp.csr_matrix:
    """The sum of two matrices without a common place, indices sorted; stored zeros stay.

    place (n,): rows and columns of ``large`` among those of ``added``, rising; None: the first.
    """
    place = np.arange(large.shape[0], dtype=np.int32) if place is None else place
    before, more = np.zeros(added.shape[0], dtype=np.int64), np.diff(added.indptr)
    before[place] = np.diff(large.indptr)
    pointer = np.concatenate([[0], np.cumsum(before + more)])
    # Each row has the entries of the large one, in their order, then the others.
    new = np.arange(added.nnz) + np.repeat(pointer[:-1] + before - added.indptr[:-1], more)
    old = np.ones(pointer[-1], dtype=bool)
    old[new] = False
    data, columns = np.empty(len(old)), np.empty(len(old), dtype=np.int32)
    data[old], data[new] = large.data, added.data
    columns[old], columns[new] = place[large.indices], added.indices
    matrix = sp.csr_matrix((data, columns, pointer), shape=added.shape)
    matrix.sort_indices()
    return matrix
