// The pipe and the agent in three dimensions: the viewer of the report, fed with what the page knows.
/* global View, ball, bore, colourOf, cross, dot, driftIn, hex, momentOf, moveOffWall, poseMatrix, revolve, rings, scale, section, shapeOfCore, sub, surfaceMesh, tube, unit */
import { find, hexColour, make } from "./parts.js";

function meshesOf(agent) {
  const path = agent.flight.position;
  return {
    outer: revolve(agent.outer, false), cavity: revolve(agent.cavity, true), core: shapeOfCore(agent.core), section: section(agent.outer, agent.cavity),
    joints: rings(agent.outer, agent.joints), flown: revolve(agent.outer, false), tube: (radius) => tube(path, radius),
  };
}

// The bores of parts as rings, and eight lines along each.
function boresOf(axes) {
  const places = [];
  for (const { points, radii } of axes) {
    const directions = points.map((_, i) => unit(sub(points[Math.min(points.length - 1, i + 1)], points[Math.max(0, i - 1)])));
    let aside = unit(cross(directions[0], Math.abs(directions[0][2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
    const frames = directions.map((direction) => {
      // The frame of a point is that of the one before it, turned no more than the axis turns.
      aside = unit(sub(aside, scale(direction, dot(aside, direction))));
      return [aside, cross(aside, direction)];
    });
    const at = (i, share, angle) => points[i].map((v, k) => {
      const j = Math.min(points.length - 1, i + 1);
      const mix = (a, b) => a + share * (b - a);
      const radius = mix(radii[i], radii[j]);
      return mix(v, points[j][k]) + radius * (Math.cos(angle) * frames[i][0][k] + Math.sin(angle) * frames[i][1][k]);
    });
    const ring = (i, share) => { for (let k = 0; k < 48; k++) for (const j of [k, k + 1]) places.push(...at(i, share, (Math.PI * j) / 24)); };
    let since = Infinity;
    for (let i = 0; i + 1 < points.length; i++) {
      const length = Math.hypot(...sub(points[i + 1], points[i]));
      const count = Math.max(1, Math.round(length / radii[i]));
      for (let n = 0; n < count; n++) if ((since += length / count) >= 0.6 * radii[i]) { ring(i, n / count); since = 0; }
      for (let k = 0; k < 8; k++) places.push(...at(i, 0, (Math.PI * k) / 4), ...at(i + 1, 0, (Math.PI * k) / 4));
    }
    ring(points.length - 1, 0);
  }
  return { places };
}

// A scene without a straight pipe has the extent of its parts.
function measure(scene, axes) {
  if (scene.pipe.length || !axes.length) return scene;
  const points = axes.flatMap(({ points: p }) => p);
  const [low, high] = [Math.min, Math.max].map((most) => [0, 1, 2].map((i) => most(...points.map((p) => p[i]))));
  const size = Math.max(...axes.flatMap(({ radii }) => radii));
  const corner = (end, sign) => [0, 1].map((i) => end[i] + sign * size);
  // The view is wider than it is high, and what is near looks larger.
  const [dx, dy, dz] = sub(high, low);
  const length = Math.max(Math.hypot(dx, dy), 2.6 * (dz + 2 * size)) + 0.8 * dy;
  return { ...scene, centre: low.map((v, i) => (v + high[i]) / 2), length, size, extent: [corner(low, -1), corner(high, 1)] };
}

// The pipe, its current, targets and flights.
export class Space {
  constructor(canvas) {
    this.canvas = canvas;
    this.scene = this.flown = null;
    this.flights = new Map();
    this.names = [];
    this.current = { places: [] };
    this.view = null;
    this.follow = false;
  }

  show(shown, { axes }) {
    const scene = measure(shown, axes);
    this.scene = scene;
    this.pipe = scene.pipe.length ? bore(scene.pipe) : boresOf(axes);
    this.drifting = driftIn(scene);
    this.surface = scene.water === null ? null : surfaceMesh(scene);
    find("names").replaceChildren();
    this.names = scene.targets.map(({ name, position }, number) => ({
      name, position, number, mesh: ball(1), label: find("names").appendChild(make("span", {}, name)),
    }));
    this.draw();
  }

  showFlights(flights) {
    for (const [name, { path, number }] of flights) {
      const known = this.flights.get(name);
      if (known?.path !== path) this.flights.set(name, { path, number, mesh: null });
    }
    for (const name of [...this.flights.keys()]) if (!flights.has(name)) this.flights.delete(name);
    this.draw();
  }

  showAgent(flown) {
    if (flown && flown.agent !== this.flown?.agent) {
      this.meshes = meshesOf(flown.agent);
      this.path = this.thread = null;
    }
    this.flown = flown;
    this.draw();
  }

  draw() {
    if (!this.scene || !this.canvas.clientWidth) return;
    this.view ??= new View(this.canvas, () => this.items(), { yaw: 0.28, pitch: 0.22, distance: 1.27 });
    this.view.draw();
  }

  items() {
    const { scene, flown } = this;
    const near = this.follow && flown;
    const items = [];
    const thin = 0.009 * scene.size;
    let [centre, size] = [scene.centre, scene.length];
    if (flown) {
      const { agent, time, number } = flown;
      const { place, attitude } = momentOf(agent.flight, time);
      const magnified = near ? 1 : flown.size;
      const drawn = magnified === 1 ? place : moveOffWall(agent.outer, attitude, place, magnified, scene.pipe);
      if (near) this.thread ??= this.meshes.tube(0.01 * agent.longest);
      else this.path ??= this.meshes.tube(1.3 * thin);
      items.push({ mesh: near ? this.thread : this.path, colour: hex(hexColour(number)) },
        { mesh: this.meshes.flown, pose: poseMatrix(attitude, drawn, magnified), colour: hex(hexColour(number)) });
      if (near) [centre, size] = [place, 5 * agent.longest];
    } else for (const flight of this.flights.values()) {
      flight.mesh ??= tube(flight.path, thin);
      items.push({ mesh: flight.mesh, colour: hex(hexColour(flight.number)) });
    }
    const dot = near ? 0.06 * flown.agent.longest : 0.045 * scene.size;
    for (const { name, position, number, mesh, label } of this.names) {
      const own = !flown || flown.agent.target === name;
      label.className = own ? "own" : "";
      items.push({ mesh, pose: poseMatrix([1, 0, 0, 0], position, dot), colour: own ? hex(hexColour(number)) : colourOf("--other") });
    }
    items.push({ mesh: this.pipe, colour: colourOf("--line", 0.4) });
    this.current.places = this.drifting(flown ? flown.time : 0);
    items.push({ mesh: this.current, colour: colourOf("--water", 0.6) });
    if (this.surface) items.push({ mesh: this.surface, colour: colourOf("--water", 0.3) });
    return { items, names: this.names, centre, size };
  }
}

// One agent, to turn and to cut open.
export class Turntable {
  constructor(canvas, cut) {
    this.canvas = canvas;
    this.cut = cut;
    this.agent = this.view = null;
  }

  show(agent, number) {
    this.agent = agent;
    this.number = number;
    this.meshes = meshesOf(agent);
    this.draw();
  }

  draw() {
    if (!this.agent || !this.canvas.clientWidth) return;
    this.view ??= new View(this.canvas, () => this.items(), { yaw: 0.45, pitch: 0.35, distance: 1.25 });
    this.view.draw();
  }

  items() {
    const { agent, cut, meshes: { outer, cavity, core, section: faces, joints } } = this;
    const [first, last] = [agent.outer[0][0], agent.outer.at(-1)[0]];
    const items = [
      { mesh: core, colour: colourOf("--core") }, { mesh: outer, colour: hex(hexColour(this.number)), cut: cut.checked },
      { mesh: joints, colour: colourOf("--line", 0.35), cut: cut.checked },
    ];
    if (cut.checked) items.push({ mesh: cavity, colour: colourOf("--inside"), cut: true }, { mesh: faces, colour: colourOf("--material") });
    return { items, centre: [(first + last) / 2, 0, 0], size: last - first };
  }
}
