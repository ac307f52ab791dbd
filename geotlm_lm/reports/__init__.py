"""Run records -> tables and README blocks; text in, text out, nothing is measured here."""
