"""Labelled recordings -> clips and labels; knows no network."""
