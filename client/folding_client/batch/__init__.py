"""Many sequences at once: a run folder for each, in this process or on a Dask cluster."""
