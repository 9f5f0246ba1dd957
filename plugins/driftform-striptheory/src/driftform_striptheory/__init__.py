"""driftform plugin: the analytic added mass of the paper."""

from driftform import hookimpl


@hookimpl
def driftform_hydrodynamics() -> type:
    """Return the strip theory of the paper, equations 1 to 10."""
    from driftform_striptheory.coefficients import StripTheory

    return StripTheory
