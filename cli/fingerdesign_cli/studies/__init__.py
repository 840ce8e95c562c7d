"""Commands of studies: variants, sweeps, searches, comparisons."""
