"""Neutral bodies that a pipe's flow carries."""

from carried import Carrying
from rolling import BORE, carry, last_speed, make_pipe

from driftform.testing.bodies import cylinder_body, spheroid_body


def measure():
    """Return rows of what is compared, measured and found."""
    rows, pipe = [], make_pipe(1.0, BORE, 3.0, velocity=(1.0, 0.0, 0.0))
    for shape, ratios in (("sphere", (0.1, 0.2, 0.31, 0.5, 0.69)), ("cylinder", (0.1, 0.2, 0.31, 0.5, 0.69, 0.89))):
        for ratio in ratios:
            r = ratio * BORE / 2
            body = spheroid_body(r, r, edges=100) if shape == "sphere" else cylinder_body(8 * r, r)
            rows.append((f"{shape}, d/D {ratio}", "1.05 to 1.5", last_speed(carry(body, 1.0, pipe), 0.5)))
    for ratio in (0.31, 0.69):
        r = ratio * BORE / 2
        carrying = Carrying(spheroid_body(r, r), BORE / 2, 1.0, (100,))
        [found] = carrying.observe(60)
        rows.append((f"sphere in gusts, d/D {ratio}", "1.05 to 1.5", found.speed * carrying.even_speed()))
    return rows
