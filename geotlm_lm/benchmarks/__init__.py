"""Error, run time and stability, measured: four benches over one harness."""
