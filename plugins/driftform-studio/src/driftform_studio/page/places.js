// Places in the pipe by name: so far into a part, in the direction of an hour, so far off the wall.
import { has, speak } from "./messages.js";
import { length, round } from "./parts.js";

const sub = (a, b) => a.map((v, i) => v - b[i]);
const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
const plus = (a, b, f = 1) => a.map((v, i) => v + f * b[i]);

// Left and up, seen downstream; as in driftform.
function uprightAxes(way) {
  const level = Math.hypot(way[0], way[1]);
  if (level < 1e-9) return { left: [0, -1, 0], up: [-Math.sign(way[2]), 0, 0] };
  const left = [-way[1] / level, way[0] / level, 0];
  return { left, up: [-way[2] * left[1], way[2] * left[0], way[0] * left[1] - way[1] * left[0]] };
}

// The stretches of an axis: where each begins, its direction and size, how far along it is, and its radii.
function* stretchesOf({ points, radii }) {
  let along = 0;
  for (let i = 0; i + 1 < points.length; i++) {
    const way = sub(points[i + 1], points[i]);
    const size = Math.hypot(...way);
    if (size < 1e-9) continue;
    yield { start: points[i], way: way.map((v) => v / size), size, along, radii: [radii[i], radii[i + 1]] };
    along += size;
  }
}

// The point of a place, as it is drawn until the server has answered; null if there is no such part.
export function pointOfPlace(axes, { part, at = 0, clock = 12, off_wall: offWall, branch = false }) {
  const axis = axes.find((a) => a.part === part && a.branch === branch);
  if (!axis) return null;
  let found = null;
  for (const stretch of stretchesOf(axis)) if (!found || at >= stretch.along) found = stretch;
  const { start, way, size, along, radii } = found;
  const centre = plus(start, way, Math.min(at - along, size));
  if (offWall === undefined) return centre.map((v) => round(v, 1e-6));
  const { left, up } = uprightAxes(way);
  const radius = radii[0] + (Math.min(at - along, size) / size) * (radii[1] - radii[0]);
  const turn = (clock * Math.PI) / 6;
  return plus(plus(centre, up, Math.cos(turn) * (radius - offWall)), left, -Math.sin(turn) * (radius - offWall)).map((v) => round(v, 1e-6));
}

// The point at coordinates downstream, to the left and upward from the middle of the inlet.
export function pointFromInlet(axes, [x, y, z]) {
  const [{ start, way }] = stretchesOf(axes[0]);
  const { left, up } = uprightAxes(way);
  return plus(plus(plus(start, way, x), left, y), up, z);
}

// The place of a point, in the part whose wall is farthest away; null outside of the pipe.
export function placeOfPoint(axes, point) {
  let best = null;
  for (const axis of axes)
    for (const { start, way, size, along, radii } of stretchesOf(axis)) {
      const off = sub(point, start);
      const ahead = Math.min(Math.max(dot(off, way), 0), size);
      const across = plus(off, way, -ahead);
      const radius = radii[0] + (ahead / size) * (radii[1] - radii[0]);
      const gap = radius - Math.hypot(...across);
      if (gap > -2e-3 && (!best || gap > best.gap)) best = { axis, at: along + ahead, across, radius, gap, way };
    }
  if (!best) return null;
  const place = { part: best.axis.part, at: round(best.at, 1e-4) };
  if (best.axis.branch) place.branch = true;
  if (best.radius - best.gap > 5e-5) {
    const { left, up } = uprightAxes(best.way);
    const hour = (Math.atan2(-dot(best.across, left), dot(best.across, up)) * 6) / Math.PI;
    place.clock = round(hour <= 1e-9 ? hour + 12 : hour, 1e-3);
    place.off_wall = Math.max(0, round(best.gap, 1e-4));
  }
  return place;
}

export function describePlace({ part, at = 0, clock = 12, off_wall: offWall, branch = false }) {
  const way = speak(branch ? "place.branch" : "place.way", { way: Number(at.toFixed(3)), part });
  if (offWall === undefined) return speak("place.axis", { way });
  const wall = has(`wall.${clock}`) ? speak(`wall.${clock}`) : speak("wall.other", { hour: Number(clock.toFixed(1)) });
  return offWall < 2e-3 ? speak("place.at", { way, wall }) : speak("place.off", { way, gap: length(offWall), wall });
}
