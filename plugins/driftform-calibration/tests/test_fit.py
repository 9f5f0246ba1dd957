"""Fits: the truth of films that are exact, intervals of those that are not, and what films cannot show."""

from dataclasses import replace

import numpy as np
import pytest
from made_films import EXACT, Filming, draw_world, film_flight, place_drop

from driftform.study import load_study
from driftform.water import Factors
from driftform_calibration.bench import Bench
from driftform_calibration.fit import fit_factors
from driftform_calibration.problem import Anchor, Problem, factor_of, parameter_of
from driftform_calibration.tracks import check_track

pytestmark = pytest.mark.long


WORLD = Factors(axial_drag=1.2, cross_drag=1.3, added_mass=0.9, hull_density=1.1, restitution=1.2)
FALLING = ("axial_drag", "cross_drag", "added_mass", "hull_density")


@pytest.fixture(scope="module")
def exact(film):
    """Of films with an exact ruler and a camera so far away that looking down does not matter."""
    return fit_factors([replace(f, scale_error=0.0, distance=1000.0) for f in film(WORLD, EXACT)])


@pytest.fixture(scope="module")
def noisy(film):
    return film(WORLD, Filming())


@pytest.fixture(scope="module")
def fit(noisy):
    return fit_factors(noisy)


@pytest.mark.parametrize("name", [*FALLING, "restitution"])
def test_exact_films_show_the_factors_of_their_world(exact, name):
    found = exact.estimates[name]
    assert found.known
    assert found.value == pytest.approx(getattr(WORLD, name), rel=0.01 if name in FALLING else 0.05)
    assert exact.residual < 2e-4
    assert exact.before > 0.01


def test_exact_points_of_an_unknown_camera_leave_its_scale_and_pitch_open(film):
    """The ruler is .5 % uncertain, and the camera may look down: both show as another drag, which intervals must hold."""
    found = fit_factors(film(WORLD, EXACT), FALLING)
    for name in FALLING:
        estimate = found.estimates[name]
        assert estimate.low < getattr(WORLD, name) < estimate.high
        assert 0.005 < (estimate.high - estimate.low) / 2 < 0.04


def test_a_release_from_higher_up_than_stated_does_not_change_the_restitution(film):
    """Before it touches the floor, a camera that was aimed lower shows the same."""
    films = []
    for stated in film(WORLD, EXACT):
        release = stated.bench.scenario.release
        x, y, z = release.position
        higher = release.model_copy(update={"position": (x, y, z + 0.008)})
        scenario = stated.bench.scenario.model_copy(update={"release": higher})
        seen = film_flight(replace(stated.bench, scenario=scenario), WORLD, np.random.default_rng(5), EXACT)
        films.append(replace(seen, bench=stated.bench, scale_error=0.0, distance=1000.0))
    found = fit_factors(films).estimates["restitution"]
    assert found.known
    assert found.value == pytest.approx(WORLD.restitution, rel=0.01)


def test_points_up_to_the_end_of_an_earlier_fit_are_not_new(noisy):
    ends = [float(f.track.t[k]) for k, f in enumerate(noisy)]
    anchor = Anchor([], np.zeros(0), np.zeros((0, 0)), ends)
    problem = Problem(noisy, FALLING, [0.002] * 3, anchor=anchor)
    for number, film in enumerate(noisy):
        new = problem.list_new(number)
        assert len(new) == problem.counts[number]
        # Two coordinates of each point.
        assert new.sum() == 2 * (len(film.track.t) - number - 1)


@pytest.mark.parametrize("name", FALLING)
def test_noisy_films_show_them_within_their_intervals(fit, name):
    found = fit.estimates[name]
    if not found.known:
        assert found.value == 1.0 and found.reason
        return
    width = found.high - found.low
    assert found.low - width / 2 < getattr(WORLD, name) < found.high + width / 2
    assert found.low < found.value < found.high


def test_the_noise_is_that_of_the_film_and_the_residual_is_noise(fit):
    assert fit.problem.noise == pytest.approx([0.002] * 3, rel=0.2)
    # Two coordinates of each point. After a bounce, what the fit leaves of its error grows.
    assert 0.8 < fit.residual / (0.002 * np.sqrt(2)) < 1.5


def test_wrong_points_count_little(noisy, fit):
    spoilt = []
    for film in noisy:
        points = film.track.points.copy()
        points[:, 5::12] += 0.05
        spoilt.append(replace(film, track=replace(film.track, points=points)))
    found = fit_factors(spoilt)
    for name in FALLING:
        plain, other = fit.estimates[name], found.estimates[name]
        if plain.known and other.known:
            assert abs(other.value - plain.value) < plain.high - plain.low


def test_heights_alone_do_not_show_how_an_agent_turns(film):
    [level] = film(replace(Factors(), cross_drag=1.3), EXACT, (0.0,), 2.0)
    heights = replace(level, track=replace(level.track, points=level.track.points * [np.nan, 1.0]))
    found = fit_factors([heights], ["cross_drag"])
    assert found.known == ()
    assert found.estimates["cross_drag"].reason.startswith("1.csv needs both coordinates")
    assert found.estimates["axial_drag"].reason == "not asked for"


def lose_frames(film, frames):
    """Return a film without some frames, whose others are numbered without a gap."""
    kept = np.delete(np.arange(len(film.track.t)), frames)
    short = replace(film.track, t=film.track.t[: len(kept)], points=film.track.points[:, kept])
    return replace(film, track=check_track("1.csv", short))


@pytest.mark.parametrize("frame", [20, 60])
def test_a_lost_frame_shows_in_what_the_fit_leaves(film, frame):
    first, *others = film(WORLD, Filming(), depth=2.0)
    found = fit_factors([lose_frames(first, [frame]), *others], FALLING)
    assert found.known == ()
    assert found.estimates["cross_drag"].reason.startswith(f"1.csv lost frames, the first at t = {frame / 60:.3f} s")


def test_what_films_cannot_show_is_named_and_left_at_1(film):
    deep = film(WORLD, Filming(longest=0.3), (0.0,), 3.0)
    found = fit_factors(deep)
    assert found.estimates["restitution"].reason == "no track touches a wall"
    for estimate in found.estimates.values():
        assert estimate.known or (estimate.value == 1.0 and estimate.low is None and estimate.reason)
    only = fit_factors(deep, ["hull_density"])
    assert only.estimates["cross_drag"].reason == "not asked for"


def test_a_calibrated_study_flies_as_the_world_did(design, film, exact):
    [shown] = film(WORLD, EXACT, (0.0,))
    table = exact.calibration(design.name)
    pipeline = replace(design.pipeline, scenario=shown.bench.scenario.model_copy(update={"calibration": table}))
    calibrated = pipeline.realise(design.agent.morphology)
    there = shown.bench.agent(table.factors)
    assert calibrated.mass.mass == pytest.approx(there.mass.mass)
    assert calibrated.coefficients.added_mass == pytest.approx(there.coefficients.added_mass)
    assert calibrated.mass.mass == pytest.approx(shown.bench.agent(WORLD).mass.mass, rel=0.01)
    # A second calibration is of the model, not of the calibrated model.
    again = Bench.of(pipeline, design.agent.morphology)
    assert again.scenario.calibration.is_empty
    assert again.coefficients.added_mass == pytest.approx(shown.bench.coefficients.added_mass)


def test_a_release_that_was_placed_too_early_is_found_anew_with_what_the_other_films_show():
    """The hull is far lighter than the model's, and one film of three first fits with a release half a second early."""
    rng = np.random.default_rng((23, 148))
    pipeline = load_study("tank", run={"seed": 0}).make_pipeline()
    morphology = pipeline.express(pipeline.grammar.random(rng))
    benches = [place_drop(pipeline, morphology, pitch) for pitch in (-45.0, 0.0, 45.0)]
    world = draw_world(benches[0], rng)
    found = fit_factors([film_flight(bench, world, rng) for bench in benches])
    assert found.residual < 1.5 * np.sqrt(2) * Filming().noise
    for name in FALLING:
        estimate = found.estimates[name]
        assert estimate.low <= getattr(world, name) <= estimate.high


@pytest.mark.parametrize("name", Factors.names)
@pytest.mark.parametrize("factor", [0.5, 1.0, 2.5])
def test_factors_and_their_parameters_are_inverse(name, factor):
    assert factor_of(name, parameter_of(name, factor)) == pytest.approx(factor)
