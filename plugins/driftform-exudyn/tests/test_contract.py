from closed_forms import ClosedForms

from driftform_exudyn.simulator import ExudynOptions, ExudynSimulator


class TestExudyn(ClosedForms):
    # Attained: energy and impulse of free motions to 2.5e-6, the libration to 1.2e-3 of its speeds.

    def plugin(self):
        return ExudynSimulator(ExudynOptions())


class TestExudynWithATightTolerance(ClosedForms):
    # Attained: 2.4e-9, and 2.4e-7; 1.6e-6 m in the stiff contact of a body that rests against a wall.
    drift = 1e-8
    accuracy = 1e-6
    agreement = 2e-6

    def plugin(self):
        return ExudynSimulator(ExudynOptions(tolerance=1e-9))
