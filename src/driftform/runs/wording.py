"""The result of a run for a target in words and in the cells of tables: those of the fitness in use.

A result is what an agent file holds of it. If the agent was flown under disturbed conditions, its verdict is the share of
these flights that hit the target; without, it is what the fitness says of the undisturbed flight.
"""

from collections.abc import Mapping
from math import isfinite
from statistics import median
from typing import Any

from driftform.interfaces import Fitness
from driftform.types import Verdict

KEPT = 0.9
"""Minimum share of flights that hit, for a target to be kept."""

WORTH = 0.1
"""Part by which the 90 % miss must be below that of the baseline, for the shape to matter."""

SCATTER = 0.25
"""Part by which the 90 % miss of the baseline must be below that of an agent, for it to be better: that of 40 flights scatters so."""

Result = Mapping[str, Any]
"""``result`` of an agent file: fitness (%), nominal miss (m), and what was promised as ``robust``."""


def is_promised(result: Result) -> bool:
    """Return whether the agent was flown under fresh disturbed conditions."""
    return "flights" in result.get("robust", {})


def is_kept(promise: Mapping[str, Any]) -> bool:
    """Return whether enough flights of a promise hit the target."""
    return (promise.get("hit") or 0.0) >= KEPT


def name_verdict(fitness: Fitness[Any], result: Result) -> str:
    """Return the verdict: kept, kept if weighed, or missed; without promises what the fitness says."""
    if not is_promised(result):
        return str(fitness.judge(result["fitness"]))
    if is_kept(result["robust"]):
        return "kept"
    return "kept if weighed" if is_kept(result["robust"]["weighed"]) else "missed"


def describe_result(fitness: Fitness[Any], result: Result) -> str:
    """Return how well a target is kept, in one line; without promises the measure of the fitness."""
    if not is_promised(result):
        return fitness.describe(result["fitness"])
    robust = result["robust"]
    within = "" if fitness.share else f" (9 of 10 within {format_miss(robust['p90'])} mm)"
    return f"hit by {_format_share(robust['hit'])} % of {robust['flights']} flights{within}"


def list_headings(fitness: Fitness[Any], promised: bool = False) -> tuple[str, ...]:
    """Return the headings of the columns of :func:`list_cells`."""
    plain = ("fitness %",) if fitness.heading == Fitness.heading else ("fitness %", fitness.heading)
    if not promised:
        return plain
    if fitness.share:
        return (*plain, fitness.share, "weighed %", "baseline %")
    return ("within mm", "hit %", "90 % mm", "weighed %", "90 % mm", "baseline %", "90 % mm")


def list_cells(fitness: Fitness[Any], result: Result, promised: bool = False) -> tuple[str, ...]:
    """Return the cells of a result: its fitness (%) and its measure, or how well it keeps the target."""
    value = result["fitness"]
    plain = (f"{value:.3f}", f"{fitness.measure(value):.3f}")[: len(list_headings(fitness))]
    if not promised:
        return plain
    robust = result.get("robust", {})
    each = [robust, robust.get("weighed", {}), robust.get("baseline", {})]
    if fitness.share:
        return (*plain, *(_format_share(promise.get("hit")) for promise in each))
    cells = (cell for one in each for cell in (_format_share(one.get("hit")), format_miss(one.get("p90"))))
    return (format_miss(result.get("within")), *cells)


def summarise(fitness: Fitness[Any], results: Mapping[str, Result]) -> str:
    """Return how many targets are kept, by print, weighed print and baseline; without promises how many are reached, and the worst one."""
    promises = [result["robust"] for result in results.values() if is_promised(result)]
    count = len(results)
    if len(promises) < count:
        reached = sum(fitness.judge(result["fitness"]) == Verdict.REACHED for result in results.values())
        subject = f"{reached} of {count} targets are"
        if count == 1:
            subject = "The target is" if reached else "The target is not"
        worst = min(results, key=lambda target: results[target]["fitness"])
        measure = f"{fitness.heading} at worst {fitness.measure(results[worst]['fitness']):.2f} ({worst})"
        return f"{subject} reached: {fitness.goal}; {measure}"
    weighed = sum(is_kept(promise["weighed"]) for promise in promises)
    printed, baseline = sum(map(is_kept, promises)), sum(is_kept(promise.get("baseline", {})) for promise in promises)
    targets = "target is" if count == 1 else "targets are"
    return (
        f"{weighed} of {count} {targets} kept if the print is weighed, {printed} as printed, {baseline} by the baseline"
    )


def describe_worth(fitness: Fitness[Any], results: Mapping[str, Result]) -> list[str]:
    """Return for which targets the baseline is better, and for which the shape matters little, and why: a text for each.

    Compares the 90 % miss, or the share of flights that do not hit if the fitness promises a share.
    """
    unmoved, better = [], []
    for name, result in results.items():
        if is_promised(result):
            robust = result["robust"]
            weighed, baseline = (_find_loss(fitness, robust.get(each, {})) for each in ("weighed", "baseline"))
            if None in (weighed, baseline):
                continue
            if baseline < (1 - SCATTER) * weighed and robust["baseline"]["hit"] >= robust["weighed"]["hit"]:
                better.append(f"{name} ('{robust['baseline']['genome']}')" if "genome" in robust["baseline"] else name)
            elif weighed >= (1 - WORTH) * baseline:
                unmoved.append(name)
    texts = []
    if better:
        texts.append(f"the baseline is better for {', '.join(better)}: take it, or let the search run for longer")
    if unmoved:
        does = "does nearly as well" if fitness.share else "keeps nearly the same 90 % miss"
        plain = [name for name in unmoved if results[name].get("plain")]
        chosen = f"; it was chosen for {', '.join(plain)}" if plain else ""
        texts.append(
            f"the shape matters little for {', '.join(unmoved)}: a plain body of the right weight {does}, because the "
            f"water carries it there, and gusts decide the rest{chosen}"
        )
    return texts


def describe_doubt(fitness: Fitness[Any], results: Mapping[str, Result]) -> str:
    """Return how much of the 90 % misses of weighed prints is due to the doubt about gusts; an empty text if there is none.

    It is negative where flights in known gusts miss by more.
    """
    weighed = {name: result["robust"]["weighed"] for name, result in results.items() if is_promised(result)}
    pairs = {name: (each["p90"], each.get("p90_known_gusts")) for name, each in weighed.items()}
    shares = {name: 1 - known / p90 for name, (p90, known) in pairs.items() if p90 and known is not None}
    if not shares or fitness.share:
        return ""
    most = max(shares, key=lambda name: shares[name])
    return (
        f"what is not known of gusts, their strength, memory and crossing, makes {100 * median(shares.values()):.0f} % of the "
        f"90 % misses of weighed prints in the median, {100 * shares[most]:.0f} % at most ({most})"
    )


def _find_loss(fitness: Fitness[Any], promise: Mapping[str, Any]) -> Any:
    if not fitness.share:
        return promise.get("p90")
    return None if promise.get("hit") is None else 1 - promise["hit"]


def explain_columns(fitness: Fitness[Any], flights: int) -> str:
    """Return what the columns of a promise mean, in one line; ``flights`` is how many there were of each kind."""
    hit = f"have {fitness.goal}" if fitness.share else "pass within the first column"
    rest = "" if fitness.share else "; 90 %: the miss that 9 of 10 of them stay within"
    return (
        f"kept: {100 * KEPT:.0f} % hit, or more; hit: the share of {flights} flights under fresh disturbed conditions that {hit}{rest}; as printed, weighed in water and trimmed, "
        "and the baseline: a plain sphere, or a capsule, made, weighed and tuned for the target in the same way"
    )


def _format_share(share: float | None) -> str:
    return "-" if share is None else f"{100 * share:.0f}"


def format_miss(metres: float | None) -> str:
    """Return a miss in mm; a dash if too many flights failed for one, or none was flown."""
    return "-" if metres is None or not isfinite(metres) else f"{1000 * metres:.0f}"
