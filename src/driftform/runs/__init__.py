"""Runs on disk: search, store, finalists, best agents, tables."""
