"""Runs on disk: directory, store, agent files, tables, and what the flights of a run reach."""
