"""The native backend keeps every promise of a simulator, alone and in threads."""

from closed_forms import ClosedForms

from driftform.motion.solver.error import Accuracy
from driftform_native.simulator import NativeOptions, NativeSimulator


class TestNative(ClosedForms):
    drift = 3e-5

    def plugin(self):
        return NativeSimulator(NativeOptions())


class TestNativeWithATightTolerance(ClosedForms):
    drift = 3e-7
    accuracy = 1e-6
    agreement = 1e-6

    def plugin(self):
        return NativeSimulator(NativeOptions(tolerance=1e-9, max_step=0.005))


class TestNativeInThreads(ClosedForms):
    drift = 3e-5

    def plugin(self):
        return NativeSimulator(NativeOptions(threads=2))


def test_it_is_as_accurate_by_default_as_the_integrator_is():
    options, integrator = NativeOptions(), Accuracy()
    assert options.accuracy == integrator.position
    assert (options.tolerance, options.tightest) == (integrator.tolerance, integrator.tightest)
    assert (options.max_step, options.step_limit) == (integrator.max_step, integrator.step_limit)
