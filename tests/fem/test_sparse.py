"""Large matrices that are joined: values, order and stored zeros."""

import numpy as np
import pytest
import scipy.sparse as sp

from fingerdesign.fem.sparse import merged


def random_upper(rng, size):
    """An upper triangle with a stored zero on its diagonal."""
    matrix = sp.triu(sp.random_array((size, size), density=0.2, rng=rng)).tocsr()
    matrix = (matrix + sp.identity(size)).tocsr()
    matrix.data[0] = 0.0
    return matrix


@pytest.mark.parametrize("seed", range(5))
def test_the_sum_is_exact_sorted_and_keeps_stored_zeros(seed):
    rng = np.random.default_rng(seed)
    large, size = random_upper(rng, 30), 40
    place = np.sort(rng.choice(size, 30, replace=False)).astype(np.int32)
    others = np.setdiff1d(np.arange(size), place)
    added = np.zeros((size, size))
    added[:, others] = rng.uniform(1.0, 2.0, (size, len(others)))
    found = merged(large, sp.csr_matrix(added), place)
    known = added.copy()
    known[np.ix_(place, place)] += large.toarray()
    assert np.array_equal(found.toarray(), known)
    assert found.nnz == large.nnz + np.count_nonzero(added)
    assert all(
        (np.diff(found.indices[begin:end]) > 0).all()
        for begin, end in zip(found.indptr[:-1], found.indptr[1:], strict=True)
    )


def test_without_a_place_the_large_one_comes_first():
    large = random_upper(np.random.default_rng(0), 8)
    border = np.zeros((11, 11))
    border[:8, 8:], border[8:, 8:] = 1.0, -np.eye(3)
    found = merged(large, sp.csr_matrix(border))
    assert np.array_equal(found.toarray()[:8, :8], large.toarray())
    assert np.array_equal(found.toarray()[:, 8:], border[:, 8:])
