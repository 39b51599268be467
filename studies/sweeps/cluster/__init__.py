"""Sweeps on a Dask cluster: its workers make the runs, and the caller keeps them."""
