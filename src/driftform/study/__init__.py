"""Studies: files and options, merged and checked, with every default filled in."""

from driftform.study.study import DEFAULT, SELECTED, Document, RunOptions, Study, load_study

__all__ = ["DEFAULT", "SELECTED", "Document", "RunOptions", "Study", "load_study"]
