"""One file, one table: run methods on clips and write what came out as run records."""
