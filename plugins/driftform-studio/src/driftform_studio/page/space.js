// The pipe and the agent in three dimensions: the viewer of the report, fed with what the page knows.
/* global View, ball, bore, colourOf, drift, hex, identity, momentOf, moveOffWall, poseMatrix, revolve, rings, section, surfaceMesh, tube */
import { find, hexColour, make } from "./parts.js";

function meshesOf(agent) {
  const path = agent.flight.position;
  return {
    outer: revolve(agent.outer, false), cavity: revolve(agent.cavity, true), core: ball(agent.core), section: section(agent.outer, agent.cavity),
    joints: rings(agent.outer, agent.joints), flown: revolve(agent.outer, false), tube: (radius) => tube(path, radius),
  };
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

  show(scene) {
    this.scene = scene;
    this.pipe = bore(scene.pipe);
    this.drifting = scene.pipe.length ? drift(scene.pipe) : () => [];
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
    this.view ??= new View(this.canvas, () => this.items(), { yaw: 0.28, pitch: 0.22, distance: 1.18 });
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
