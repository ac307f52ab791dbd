"""Error, run time, stability and closed loops, measured: five benches over one harness."""
