"""Checks of the meshes themselves: from closedness to the best orientation on the bed."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import ClassVar, TypeAlias

import numpy as np

from driftform.interfaces import Checker, ExportJob, PrintJob, Table, option
from driftform.types import Finding, FloatArray, State
from driftform_frusta.csg import MM
from driftform_frusta.hull import MM3_PER_M3, printed_volume
from driftform_frusta.strength import describe_strength
from driftform_frusta.triangles import Mesh
from driftform_kit.checks.overhangs import TURNS, Orientation, choose_orientation, list_orientations
from driftform_kit.checks.shells import Shell, Topology, analyse_topology, find_shells
from driftform_kit.checks.slenderness import ADHESION, BRIMS, PUSH, find_brim, measure_slenderness
from driftform_kit.checks.walls import REACH, find_thinnest_wall
from driftform_kit.reading import read_meshes

_MIN_SIZE, _MAX_SIZE = 5.0, 10_000.0
"""mm: a smaller part was written in metres, a larger one in micrometres."""

_TOUCH, _SHOWN = 1e-4, 3
"""Share of the smaller of two parts in which they overlap by the facets of their joints; pairs that are named."""

_LINES = 2
"""Least thickness of a watertight wall, in lines of the nozzle."""


Verdict: TypeAlias = tuple[State, str]
"""The state and the detail of a finding."""


class MeshOptions(Table):
    """The limits that pass."""

    tolerance: float = option(
        1e-4, "largest relative difference of volume from the closed form that passes", gt=0, lt=1
    )
    coarse: float = option(1e-2, "largest relative difference of volume that is only a warning", gt=0, lt=1)
    overhang: float = option(1e-5, "largest area that overhangs by more than 45 deg and passes", "m2", ge=0, le=1)
    push: float = option(
        PUSH, "force with which a nozzle pushes at the top of a part (PrusaSlicer's 10 gram-force)", "N", gt=0, le=100
    )
    catch: float = option(
        0.735, "force with which a nozzle catches on material that has curled up (75 gram-force)", "N", gt=0, le=100
    )
    stiffness: float = option(2e9, "modulus of elasticity of the material (ABS)", "Pa", ge=1e5, le=1e12)
    strength: float = option(33e6, "yield strength of the material (ABS)", "Pa", ge=1e4, le=1e10)
    adhesion: float = option(
        ADHESION, "stress at which the material comes off the bed (ABS; PLA 2e4, PETG 3e5)", "Pa", gt=0, le=1e9
    )


@dataclass(frozen=True, eq=False)
class AnalysedPart:
    """A part, its topology and its shells, which are empty if it is not closed or not oriented."""

    part: Mesh
    topology: Topology
    shells: tuple[Shell, ...]

    @property
    def sound(self) -> bool:
        """True if it is a solid: closed, and every shell faces as it should."""
        return bool(self.shells) and not any(shell.inside_out or shell.cut for shell in self.shells)

    @property
    def volume(self) -> float:
        """Volume of the material, mm3."""
        return sum(shell.volume for shell in self.shells)

    @property
    def outward(self) -> Mesh:
        """The mesh with all triangles turned to face outward; those of hollows come last."""
        turned = [shell.triangles[:, ::-1] if shell.inside_out else shell.triangles for shell in self.shells]
        return replace(self.part, triangles=np.concatenate(turned))


class MeshChecker(Checker[MeshOptions]):
    """Checks of the triangles: unit, closedness, shells, mass, walls, size and orientation. Needs no other program."""

    name = "mesh"
    Options: ClassVar[type[Table]] = MeshOptions

    def check(self, job: PrintJob) -> Iterator[Finding]:
        """Report unit, closedness, orientation of faces, shells, mass, walls, size, orientation on the bed, slenderness."""
        found = [[(part, analyse_topology(part.triangles)) for part in read_meshes(path)] for path in job.files]
        plates = [
            [AnalysedPart(part, t, find_shells(part, t) if t.closed and t.oriented else ()) for part, t in plate]
            for plate in found
        ]
        studied = [one for plate in plates for one in plate]
        parts = [one.part for one in studied]
        unit = _check_unit(parts)
        yield Finding("unit", *unit)
        count = sum(len(part.triangles) for part in parts)
        yield Finding("duplicate faces", *_judge(studied, _describe_copies, f"no copies among {count} triangles"))
        yield Finding("closed", *_judge(studied, _describe_edges, "every edge has two faces"))
        yield Finding("oriented", *_judge(studied, _describe_flipped, "neighbours face the same way"))
        yield Finding("shells", *_check_shells(studied, job))
        if any(len(plate) > 1 for plate in plates):
            yield Finding("overlap", *_check_overlap(plates))
        if unit[0] is State.FAIL:
            for check in ("mass", "wall", "bed", "standing", "slender"):
                yield Finding(check, State.SKIPPED, "correct the unit first")
            return
        yield Finding("mass", *self._check_mass(studied, job))
        yield Finding("wall", *_check_walls(studied, job))
        yield Finding("bed", *_check_bed(parts, job))
        for check, judge in (("standing", self._check_standing), ("slender", self._check_slenderness)):
            for one in studied:
                name = one.part.name if len(studied) > 1 else ""
                yield Finding(check, *judge(one, job, len(studied)), name)
        if job.export is not None and (facts := describe_strength(job.export.agent.body, job.export.scenario.fluid)):
            builder = job.export.document.get("environment", {}).get("builder", {})
            needed = builder.get("pressure", 0.0) * builder.get("safety", 1.0)
            more = f"; builder.pressure and safety ask for {needed / 1e5:g} bar" if facts["pressure"] < needed else ""
            yield Finding("pressure", State.FAIL if more else State.PASS, facts["summary"] + more)
        if job.export is not None and (trim := _check_trim(job.export)):
            yield Finding("trim", *trim)

    def _check_slenderness(self, one: AnalysedPart, job: PrintJob, count: int) -> Verdict:
        if not one.shells:
            return State.SKIPPED, "a mesh that is not closed has no sections"
        o = self.options
        mesh = one.outward
        # That another placement is better, or needs a brim, is a fault of 'standing'.
        best = choose_orientation(list_orientations(mesh), _bed_size(job))
        turned = replace(mesh, vertices=mesh.vertices @ TURNS[best.name].T)
        beam = measure_slenderness(turned, o.stiffness, o.strength, o.adhesion)
        if beam is None:
            return State.SKIPPED, "it is not taller than its first layer"
        bent, half_line = o.push * beam.bending, MM * job.printer.nozzle / 2
        message = (
            f"{best.name}: {beam.height:.1f} mm high on {beam.base:.1f} mm ({beam.height / beam.base:.1f} : 1), weakest "
            f"at {beam.neck_height:.1f} mm, {beam.neck:.1f} mm wide; at the top {o.push:.2g} N bend it by {bent:.2f} mm, "
            f"{_show_force(beam.lift_force)} lift it off the bed, {_show_force(beam.break_force)} break it"
        )
        faults = []
        if bent > half_line:
            cut = f"print it slowly, or in shorter parts ({'--bed' if count > 1 else '--kit, --bed'})"
            faults.append(f"it sways by more than half a line ({half_line:g} mm): {cut}")
        if beam.lift_force < o.push and (best.steady or faults):
            # Of two dangers the graver comes first: it is lifted off before it sways.
            brim = find_brim(turned, o.push, o.adhesion)
            faults.insert(
                0, f"a nozzle pushes with {o.push:.2g} N and lifts it off: print it with a brim of {brim:g} mm"
            )
        if beam.break_force < o.catch:
            faults.append(f"a nozzle that catches, with {o.catch:.2g} N, breaks it: make its wall thicker there")
        state = State.WARN if faults else State.PASS
        return state, ": ".join((message, *(["; ".join(faults)] if faults else [])))

    def _check_mass(self, studied: Sequence[AnalysedPart], job: PrintJob) -> Verdict:
        if not all(one.sound for one in studied):
            return State.SKIPPED, "a mesh that is not a solid has no volume"
        volume = sum(one.volume for one in studied)
        density = None if job.export is None else job.export.agent.body.hull_density
        amount = f"{volume / 1000:.4f} cm3"
        if density is not None:
            amount += f", {volume / MM3_PER_M3 * density * 1000:.3f} g at {density:g} kg/m3"
        if job.volume is None:
            return State.SKIPPED, f"{amount}; the agent is unknown: name it with --agent"
        difference = volume / (job.volume * MM3_PER_M3) - 1
        message = f"{amount}; {difference:+.1e} of the closed form"
        if abs(difference) <= self.options.tolerance:
            return State.PASS, message
        # The hull in one piece is one part: several are a kit, which has more material than the hull that it is compared with.
        if len(studied) > 1 and difference > 0 and job.export is not None and _is_whole(job):
            parts = f"of the hull in one piece, but these are {len(studied)} parts"
            return State.WARN, f"{message} {parts}: a kit? check it with --kit"
        if abs(difference) <= self.options.coarse:
            return State.WARN, f"{message}: a coarse mesh? export it with more segments"
        closed_form = f"the closed form has {job.volume * 1e6:.4f} cm3"
        return State.FAIL, f"{amount}, but {closed_form}: another agent, or another wall?"

    def _check_standing(self, one: AnalysedPart, job: PrintJob, count: int) -> Verdict:
        if not one.shells:
            return State.SKIPPED, "a mesh that is not closed has no underside"
        hollow = sum(len(shell.triangles) for shell in one.shells if shell.hollow)
        bed = _bed_size(job)
        found = list_orientations(one.outward, hollow)
        best, now = choose_orientation(found, bed), found[0]
        # The file of an agent in one piece has its aft end on the bed.
        upright = job.export is not None and count == 1
        words = {"as placed": "fore end up", "upside down": "fore end down"} if upright else {}
        shown = found[:-1] if np.isclose(found[-1].overhang, found[-2].overhang) else found
        message = f"contact and overhang in cm2: {', '.join(_describe_orientation(each, words) for each in shown)}"
        if best.name != now.name:
            return State.WARN, f"{message}; better {words.get(best.name, best.name)}"
        if not now.steady:
            brim = max(BRIMS[1], find_brim(one.outward, self.options.push, self.options.adhesion))
            return State.WARN, f"{message}; no orientation is better, print it with a brim of {brim:g} mm"
        support = "" if now.overhang <= self.options.overhang * MM**2 else ", with support"
        state = State.WARN if support else State.PASS
        return state, f"{message}; best {words.get(best.name, best.name)}{support}"


def _check_trim(export: ExportJob) -> Verdict | None:
    """Return by how much trim pockets change the net weight; ``None`` if none were asked for."""
    body, builder = export.agent.body, export.document.get("environment", {}).get("builder", {})
    if body.pockets:
        least, most = (1000 * weight for weight in body.trim_range(export.scenario.fluid.density))
        pockets = _count(len(body.pockets), "pocket")
        return State.PASS, f"putty in {pockets} changes the net weight by {least:+.2f} to {most:+.2f} g"
    if builder.get("pockets", {}).get("diameter"):
        return State.WARN, "no end has room for a trim pocket: the sealed print is trimmed on its outside"
    return None


def _show_force(newtons: float) -> str:
    return f"{newtons:.0f} N" if newtons >= 10 else f"{newtons:.2g} N"


def _bed_size(job: PrintJob) -> FloatArray:
    return MM * np.array(job.printer.bed)


def _describe_orientation(each: Orientation, words: Mapping[str, str]) -> str:
    inside = f" ({each.enclosed / 100:.1f} of it enclosed)" if each.enclosed >= 5 else ""
    return f"{words.get(each.name, each.name)} {each.contact / 100:.1f} and {each.overhang / 100:.1f}{inside}"


def _check_unit(parts: Sequence[Mesh]) -> Verdict:
    largest = max(float(np.ptp(part.bounds, axis=0).max()) for part in parts)
    if largest < _MIN_SIZE:
        return State.FAIL, f"{largest:.4g} mm at its largest: in metres? scale it by 1000, printers take mm"
    if largest > _MAX_SIZE:
        where = f"{largest / 1000:.4g} m at its largest"
        return State.FAIL, f"{where}: in micrometres, or a GLB in mm? scale it by 0.001"
    return State.PASS, f"mm: {largest:.2f} mm at its largest"


def _judge(studied: Sequence[AnalysedPart], find: Callable[[AnalysedPart], str], passed: str) -> Verdict:
    """Fail with the faults of the parts, each with the name of its part if there are several."""
    faults = [(one.part.name, fault) for one in studied if (fault := find(one))]
    if faults:
        return State.FAIL, "; ".join(f"{name}: {fault}" if len(studied) > 1 else fault for name, fault in faults)
    return State.PASS, passed


def _count(count: int, what: str, plural: str = "") -> str:
    return f"{count} {what if count == 1 else plural or what + 's'}"


def _describe_copies(one: AnalysedPart) -> str:
    return f"{_count(copies, 'triangle')} twice: remove the copies" if (copies := one.topology.copies) else ""


def _describe_edges(one: AnalysedPart) -> str:
    t = one.topology
    missing = f"{_count(t.open_edges, 'open edge')} round {_count(t.holes, 'hole')}: faces are missing"
    crowded = f"{_count(t.crowded_edges, 'edge')} of three faces or more"
    return ", ".join([missing] * bool(t.open_edges) + [crowded] * bool(t.crowded_edges))


def _describe_flipped(one: AnalysedPart) -> str:
    return f"{_count(flipped, 'face')} turned against the rest" if (flipped := one.topology.flipped) else ""


def _check_shells(studied: Sequence[AnalysedPart], job: PrintJob) -> Verdict:
    if not all(one.shells for one in studied):
        return State.SKIPPED, "a mesh that is not closed and oriented has no inside"
    outside = "an outside" if len(studied) == 1 else f"{len(studied)} outsides"
    hollows = sum(shell.hollow for one in studied for shell in one.shells)
    passed = f"{outside} and {_count(hollows, 'hollow')}, each facing the right way"
    turned = _judge(studied, lambda one: _describe_turned(one.shells), passed)
    if turned[0] is State.FAIL:
        return turned
    if job.export is not None and len(studied) == 1 and _is_whole(job):
        expected = 1 + bool(len(job.export.agent.body.cavity))
        count = len(studied[0].shells)
        if count != expected:
            return State.FAIL, f"{_count(count, 'shell')}, but the hull of the agent has {expected}"
    state, message = _judge(
        studied,
        lambda one: f"{n} pieces that do not touch" if (n := sum(not s.hollow for s in one.shells)) > 1 else "",
        passed,
    )
    return State.WARN if state is State.FAIL else state, message


def _check_overlap(plates: Sequence[Sequence[AnalysedPart]]) -> Verdict:
    """Check that no two parts of a file are in the same place; those of several files are not on one plate."""
    pairs = (
        f"{one.part.name} and {other.part.name} by {shared / 1000:.3g} cm3"
        for plate in plates
        for one, other in _list_neighbours([part for part in plate if part.sound])
        if (shared := float((one.part.to_manifold() ^ other.part.to_manifold()).volume()))
        > _TOUCH * min(one.volume, other.volume)
    )
    if faults := list(islice(pairs, _SHOWN)):
        return State.FAIL, f"parts take the same place: {', '.join(faults)}; arrange them again"
    return State.PASS, "no two parts take the same place"


def _list_neighbours(solids: Sequence[AnalysedPart]) -> Iterator[tuple[AnalysedPart, AnalysedPart]]:
    """Yield the pairs of solids whose boxes overlap."""
    bounds = np.array([one.part.bounds for one in solids]).reshape(-1, 2, 3)
    for number, (low, high) in enumerate(bounds):
        before = bounds[:number]
        for other in np.flatnonzero((before[:, 0] < high).all(axis=1) & (low < before[:, 1]).all(axis=1)).tolist():
            yield solids[other], solids[number]


def _is_whole(job: PrintJob) -> bool:
    """Return whether the files hold the agent's hull in one piece, and not a kit."""
    assert job.export is not None
    return job.volume is not None and bool(np.isclose(job.volume, printed_volume(job.export.agent.body)))


def _describe_turned(shells: Sequence[Shell]) -> str:
    if any(shell.cut for shell in shells):
        return "shells intersect"
    wrong = [shell for shell in shells if shell.inside_out]
    if not wrong:
        return ""
    if len(wrong) == len(shells):
        return "everything is inside out: its volume is negative; turn all faces"
    hollows = sum(shell.hollow for shell in wrong)
    message = [f"{_count(hollows, 'hollow')} inside out: printed as material, not as air"] if hollows else []
    if len(wrong) > hollows:
        message.append(f"{_count(len(wrong) - hollows, 'outside')} inside out")
    return ", ".join(message)


def _check_walls(studied: Sequence[AnalysedPart], job: PrintJob) -> Verdict:
    if not all(one.shells for one in studied):
        return State.SKIPPED, "a mesh that is not closed and oriented has no wall to measure"
    nozzle = MM * job.printer.nozzle
    found = [(wall, one.part.name) for one in studied if (wall := find_thinnest_wall(one.outward)) is not None]
    if not found:
        return State.PASS, f"no wall thinner than {REACH:g} mm"
    (thin, (x, y, z)), name = min(found)
    where = f"{name}, " if len(studied) > 1 else ""
    message = f"{thin:.3f} mm at its thinnest ({where}x {x:.1f}, y {y:.1f}, z {z:.1f})"
    if thin < nozzle:
        return State.FAIL, f"{message}: less than the nozzle's {nozzle:g} mm"
    if thin < _LINES * nozzle:
        return State.WARN, f"{message}: less than {_LINES} lines of the {nozzle:g} mm nozzle; it may leak"
    return State.PASS, f"{message}: {thin / nozzle:.1f} lines of {nozzle:g} mm"


def _check_bed(parts: Sequence[Mesh], job: PrintJob) -> Verdict:
    bed = _bed_size(job)
    room = " x ".join(f"{side:g}" for side in bed)
    faults = []
    for part in parts:
        placed, *others = list_orientations(part)
        if placed.fits(bed):
            continue
        size = " x ".join(f"{side:.1f}" for side in placed.size)
        name = f"{part.name}: " if len(parts) > 1 else ""
        other = next((each.name for each in others if each.fits(bed)), None)
        step = f"it would fit {other}" if other else "split it: export it with --kit"
        faults.append(f"{name}{size} mm is too {'tall' if placed.size[2] > bed[2] else 'wide'} for {room} mm; {step}")
    if faults:
        return State.FAIL, "; ".join(faults)
    lowest = np.min([part.bounds[0] for part in parts], axis=0)
    highest = np.max([part.bounds[1] for part in parts], axis=0)
    plate = sorted((highest - lowest)[:2])
    if len(parts) > 1 and (np.array(plate) > sorted(bed[:2])).any():
        taken = f"together they take {plate[1]:.0f} x {plate[0]:.0f} mm"
        return State.WARN, f"each part fits {room} mm, {taken}: arrange them again"
    size = " x ".join(f"{side:.1f}" for side in (highest - lowest))
    return State.PASS, f"{size} mm fits {room} mm"
