"""Where bodies go at a junction that is made by hand: closed forms of the streamtubes, and flights that are given."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from driftform_networks.flights.bodies import open_traveller
from driftform_networks.flights.bore import BANDS, MIXED, find_band, sample_band, smallest_share, spread_points
from driftform_networks.flights.junctions import Junction, divide_bodies
from driftform_networks.passages.routing import TEE


@pytest.fixture(scope="module")
def sphere():
    """A sphere of 60 mm."""
    return open_traveller("sphere:60mm")


def make_tee(share=0.3, bore=0.3, side=0.3, exit_share=0.0, stores=False, offtake=0.02):
    """A run that goes straight on, and a branch to the right that takes ``share`` of the water."""
    return Junction(
        bore,
        np.array([bore or 0.3, side]),
        np.array([1 - share, share]),
        exit_share,
        np.array([[0.0, 0.0], [1.0, 0.0]]),
        np.array([0.0, math.pi / 2]),
        stores,
        1,
        offtake,
    )


def cut_segment(height):
    """Share of a disc of radius 1 beyond a line at the distance ``height`` from its centre."""
    return (math.acos(height) - height * math.sqrt(1 - height**2)) / math.pi


@pytest.mark.parametrize("share", [0.2, 0.4])
@pytest.mark.parametrize("bore", [0.3, 0.15])
def test_a_body_that_is_anywhere_enters_the_branch_with_the_water_that_carries_it(sphere, share, bore):
    """Water within a radius of the wall carries a body too, whose centre lies on the circle that it can reach."""
    room = 1 - 0.06 / bore
    height = brentq(lambda h: cut_segment(h) - share, 0, 1)
    expected = room**2 * cut_segment(height / room) + (1 - room**2) * math.acos(height / room) / math.pi
    table = divide_bodies(sphere, make_tee(share, bore), None)
    assert table.choice[:, 1] == pytest.approx(np.full(BANDS, expected), abs=4e-3)
    assert table.choice[:, 0] == pytest.approx(1 - table.choice[:, 1])
    # It arrives in any band.
    assert table.arrival == pytest.approx(np.broadcast_to(MIXED, (BANDS, 2, BANDS)))
    assert not table.leaves.any()


@pytest.mark.parametrize("size", [0.1, 0.5, 0.9, 1.0])
def test_a_branch_whose_water_no_centre_reaches_takes_no_sphere(size):
    assert smallest_share(size) == pytest.approx(cut_segment(1 - size))
    points = spread_points(1.0, 90, 720)
    assert smallest_share(size) == pytest.approx((points[:, 0] > 1 - size).mean(), abs=2e-3)


@pytest.mark.parametrize("band", range(BANDS))
def test_points_of_a_band_lie_in_it_and_fill_it_evenly(band):
    points = sample_band(band, 0.8, np.random.default_rng(band).random((4000, 2)))
    assert (find_band(points, 0.8) == band).all()
    # The area within a distance grows with its square, from none or a ninth of the disc to all of it.
    part = (np.linalg.norm(points, axis=1) / 0.8) ** 2
    low, high = (0, 1 / 9) if band == 0 else (1 / 9, 1)
    assert part.mean() == pytest.approx((low + high) / 2, abs=0.02)
    assert part.std() == pytest.approx((high - low) / np.sqrt(12), abs=0.01)


def test_a_link_without_a_bore_has_the_room_of_the_widest_outlet(sphere):
    pump, pipe = (divide_bodies(sphere, make_tee(bore=bore), None) for bore in (0.0, 0.3))
    assert pump.choice == pytest.approx(pipe.choice)


def test_bodies_of_a_band_divide_as_counted(sphere):
    """Of four in band 3, one lies where the water goes on."""
    points = np.array([[3, 0.8, 0.0], [3, 0.75, 0.0], [3, 0.7, 0.1], [3, -0.2, 0.0], [7, -0.8, 0.0]])
    table = divide_bodies(sphere, make_tee(), points)
    assert table.choice[3] == pytest.approx([0.25, 0.75])
    assert table.choice[7] == pytest.approx([1.0, 0.0])
    anywhere = divide_bodies(sphere, make_tee(), None).choice[0]
    assert table.choice[0] == pytest.approx(anywhere)
    nowhere = divide_bodies(sphere, make_tee(), np.zeros((0, 3)))
    assert nowhere.choice == pytest.approx(np.tile(anywhere, (BANDS, 1)))


def test_a_single_outlet_takes_all(sphere):
    one = Junction(0.3, np.array([0.3]), np.ones(1), 0.0, np.zeros((1, 2)), np.zeros(1), False, 1, 0.02)
    assert divide_bodies(sphere, one, None).choice == pytest.approx(np.ones((BANDS, 1)))


def test_a_branch_that_is_too_narrow_holds_the_bodies_that_its_water_carries(sphere):
    open_one, narrow = (divide_bodies(sphere, make_tee(side=side), None) for side in (0.3, 0.05))
    assert narrow.choice[:, 0] == pytest.approx(open_one.choice[:, 0])
    assert not narrow.choice[:, 1].any()
    assert narrow.obstacle == "too wide: 60 mm in a bore of 50 mm"
    assert open_one.obstacle == ""


@pytest.mark.parametrize(("service", "leaves"), [(0.06, 0.0), (0.061, 0.4)])
def test_the_demand_takes_its_share_of_bodies_that_fit_service_pipes(sphere, service, leaves):
    table = divide_bodies(sphere, make_tee(exit_share=0.4, offtake=service), None)
    assert table.leaves == pytest.approx(np.full(BANDS, leaves))
    assert table.choice.sum(axis=1) == pytest.approx(np.full(BANDS, 1 - leaves))


def test_all_bodies_leave_into_a_tank(sphere):
    table = divide_bodies(sphere, make_tee(stores=True), None)
    assert table.leaves == pytest.approx(np.ones(BANDS))
    assert not table.choice.any()


@pytest.mark.parametrize(("service", "leaves"), [(0.02, 0.0), (0.08, 1.0)])
def test_a_dead_end_lets_a_body_out_that_fits(sphere, service, leaves):
    none = np.zeros(0)
    end = Junction(0.3, none, none, 1.0, np.zeros((0, 2)), none, False, 1, service)
    table = divide_bodies(sphere, end, None)
    assert table.leaves == pytest.approx(np.full(BANDS, leaves))
    assert table.obstacle == f"at a dead end: too wide for the {1000 * service:.0f} mm that its demand takes"


def test_flights_give_the_outlet_and_the_band_in_it(sphere):
    """From each band 0.5 arrive in band 2 of the run, 0.125 in band 4 of it, 0.25 in band 6 of the branch; an eighth is held."""
    onward = np.zeros((BANDS, 2, BANDS))
    onward[:, 0, 2], onward[:, 0, 4], onward[:, 1, 6] = 0.5, 0.125, 0.25
    onward[8, 1] = 0.0
    points = np.array([[1, 0.0, 0.75]])
    table = divide_bodies(sphere, make_tee(exit_share=0.2, offtake=0.08), points, onward, TEE)
    assert table.choice[0] == pytest.approx([0.8 * 0.625, 0.8 * 0.25])
    assert table.arrival[0, 0, [2, 4]] == pytest.approx([0.8, 0.2])
    assert table.arrival[0, 1, 6] == pytest.approx(1.0)
    # Where no flight went, a body would keep its band.
    assert table.choice[8, 1] == 0.0
    assert table.arrival[8, 1] == pytest.approx(np.eye(BANDS)[8])
    assert table.obstacle == "held in a tee: where the flow divides"
    assert divide_bodies(sphere, make_tee(side=0.05), points, onward).obstacle.startswith("too wide")
