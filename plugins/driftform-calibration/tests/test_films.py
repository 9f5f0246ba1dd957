"""What scales show of an agent before it is filmed."""

from dataclasses import replace

import pytest
from made_films import Filming

from driftform.agent import hull_mass
from driftform.design.opening import open_agent
from driftform.errors import InputError
from driftform.water import Factors
from driftform_calibration.bench import Bench
from driftform_calibration.films import SCALES, check_film, weigh_prior
from driftform_calibration.problem import Filmed
from driftform_calibration.tracks import Reading, read_track

WORD = "addF-tiltp-2-L-moveF-addF-tiltn-1-L-moveF-addB-tiltn-2-L-moveB"


@pytest.fixture(scope="module", params=[0.0, 0.8])
def bench(request):
    """An agent without ballast, and one whose ballast weighs more than its hull."""
    opened = open_agent(WORD, "tank", ["builder.tuning=ballast", "builder.core=glass-20mm"])
    morphology = opened.agent.morphology
    _, most = opened.pipeline.builder.find_tunings(morphology) or (0.0, 0.0)
    return Bench.of(opened.pipeline, replace(morphology, tuning=request.param * most))


@pytest.mark.parametrize("density", [0.9, 1.0, 1.2])
def test_the_weight_of_a_print_shows_the_density_of_its_hull(bench, density):
    mass = bench.agent(Factors(hull_density=density)).mass.mass
    value, deviation = weigh_prior(bench, mass)["hull_density"]
    assert 1 + value == pytest.approx(density, rel=1e-9)
    assert deviation * hull_mass(bench.body) == pytest.approx(SCALES * mass)


def test_a_print_that_weighs_no_more_than_what_is_in_it_was_weighed_without(bench):
    inside = bench.agent(Factors()).mass.mass - hull_mass(bench.body)
    with pytest.raises(InputError, match="in kg, with all that is in it; the agent was simulated with"):
        weigh_prior(bench, 0.99 * inside)


@pytest.mark.parametrize("slower", [1, 4])
def test_slow_motion_is_refused_with_its_factor_and_a_world_with_more_drag_is_none(slower, film, write_track, tmp_path):
    for world in (Factors(), Factors(cross_drag=1.5, axial_drag=0.7)):
        [made] = film(world, Filming(), (30.0,))
        track = replace(made.track, t=slower * made.track.t)
        path = write_track(tmp_path / "film.csv", replace(made, track=track))
        seen = read_track(path, made.bench.body, Reading())
        if slower == 1:
            assert check_film("film.csv", Filmed(made.bench, seen)).track.notes == ()
            continue
        with pytest.raises(InputError, match="if it is 4 times slow: give --fps"):
            check_film("film.csv", Filmed(made.bench, seen))
