"""The only place where weights change: backbone, DGR and probe, language, calibration."""
