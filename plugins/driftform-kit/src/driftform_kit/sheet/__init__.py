"""The assembly sheet of a kit: one page with its parts to scale, the order of assembly, and what to weigh."""
