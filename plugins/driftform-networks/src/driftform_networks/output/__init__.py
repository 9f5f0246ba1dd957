"""What the commands print and write: lines, tables, maps, reports."""
