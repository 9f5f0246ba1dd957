"""Coefficients of two explicit Runge-Kutta pairs and a Rosenbrock method.

Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I (2nd ed., 1993): DOPRI5 of Dormand and Prince, table
5.2 of section II.5, and DOP853 with its two error estimates, section II.10 and the authors' program. Rang and Angermann,
BIT Numerical Mathematics 45 (2005), 761: ROS34PW2.
"""

from typing import NamedTuple

import numpy as np

from driftform.types import FloatArray


class RungeKuttaPair(NamedTuple):
    """An explicit Runge-Kutta method of s stages, whose last evaluation is the first of the next step.

    Attributes:
        a, b, c: the coefficients: stages (s, s), weights (s,), times (s,).
        error, second: weights of the error estimate, with the slope at the end, (s + 1,), and of the second estimate
            that DOP853 divides by (Hairer's 3rd-order estimate); empty for a method without it.
        power: order of the error estimate: the error of a step is proportional to h to this power.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    error: FloatArray
    second: FloatArray
    power: float


class RosenbrockPair(NamedTuple):
    """A Rosenbrock method of s stages for y' = f(t, y), in the form that needs no product with the Jacobian J::

        (1 / (gamma h) - J) u_k = f(t + c_k h, y + sum of a_kl u_l) + sum of solved_kl u_l / h

    The result is y + sum of b_k u_k.

    Attributes:
        a, solved, gamma, c, b: the coefficients: (s, s), (s, s), a number, (s,), (s,).
        error: weights of the error estimate, (s,).
        power: see :class:`RungeKuttaPair`.
    """

    a: FloatArray
    solved: FloatArray
    gamma: float
    c: FloatArray
    b: FloatArray
    error: FloatArray
    power: float


def _lower_triangle(*rows: tuple[float, ...]) -> FloatArray:
    """Return the square matrix whose rows, from the second on, begin with these numbers."""
    matrix = np.zeros((len(rows) + 1, len(rows) + 1))
    for i, row in enumerate(rows, start=1):
        matrix[i, : len(row)] = row
    return matrix


DOPRI5 = RungeKuttaPair(
    a=_lower_triangle(
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    ),
    b=np.array([35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84]),
    c=np.array([0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1]),
    error=np.array([-71 / 57600, 0, 71 / 16695, -71 / 1920, 17253 / 339200, -22 / 525, 1 / 40]),
    second=np.empty(0),
    power=5.0,
)

# fmt: off
# Rows as in the book, which a formatter would print a number a line.
DOP853 = RungeKuttaPair(
    a=_lower_triangle(
        (0.05260015195876773,),
        (0.0197250569845379, 0.0591751709536137),
        (0.02958758547680685, 0.0, 0.08876275643042054),
        (0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792),
        (0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242),
        (0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125),
        (0.03709200011850479, 0.0, 0.0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402,
         0.008273789163814023),
        (0.6241109587160757, 0.0, 0.0, -3.3608926294469414, -0.868219346841726, 27.59209969944671,
         20.154067550477894, -43.48988418106996),
        (0.47766253643826434, 0.0, 0.0, -2.4881146199716677, -0.590290826836843, 21.230051448181193,
         15.279233632882423, -33.28821096898486, -0.020331201708508627),
        (-0.9371424300859873, 0.0, 0.0, 5.186372428844064, 1.0914373489967295, -8.149787010746927,
         -18.52006565999696, 22.739487099350505, 2.4936055526796523, -3.0467644718982196),
        (2.273310147516538, 0.0, 0.0, -10.53449546673725, -2.0008720582248625, -17.9589318631188,
         27.94888452941996, -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636),
    ),
    b=np.array([0.054293734116568765, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003,
        -5.801203960010585, 0.3111643669578199, -0.1521609496625161, 0.20136540080403034,
        0.04471061572777259]),
    c=np.array([0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726,
        0.3333333333333333, 0.25, 0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571, 1.0]),
    error=np.array([0.01312004499419488, 0.0, 0.0, 0.0, 0.0, -1.2251564463762044, -0.4957589496572502,
        1.6643771824549864, -0.35032884874997366, 0.3341791187130175, 0.08192320648511571,
        -0.022355307863886294, 0.0]),
    second=np.array([-0.18980075407240762, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003,
        -5.801203960010585, -0.4226823213237919, -0.1521609496625161, 0.20136540080403034,
        0.02265179219836082, 0.0]),
    power=8.0,
)
# fmt: on

ROS34PW2 = RosenbrockPair(
    a=_lower_triangle(
        (2.0,), (1.4192173174557647, -0.2592322116729697), (4.18476048231916, -0.28519201735549593, 2.294280360279042)
    ),
    solved=_lower_triangle(
        (-4.588560720558084,),
        (-4.18476048231916, 0.28519201735549593),
        (-6.368179200128359, -6.795620944466837, 2.8700986043310563),
    ),
    gamma=0.435866521508459,
    c=np.array([0.0, 0.871733043016918, 0.7315799577888524, 1.0]),
    b=np.array([4.1847604823191595, -0.28519201735549565, 2.2942803602790414, 1.0]),
    error=np.array([0.2777499476479681, -1.4032398951759992, 1.7726301276675507, 0.5]),
    power=3.0,
)
