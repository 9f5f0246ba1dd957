// The design in the making: a built-in scenario, and what of it was changed. It lives in its tab, and nowhere else.
import { has, speak } from "./messages.js";
import { round } from "./parts.js";

const KEPT = "driftform-design";
const PATIENCE = 15; // s of processor time, ten times what a flight among parts takes
const TABLES = ["pipe", "flow", "gusts", "fluid", "release", "contact", "flight", "robustness", "targets", "strategy", "simulator", "hydrodynamics", "builder", "grammar", "fitness"];
export const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
export const copy = (value) => JSON.parse(JSON.stringify(value));

export class Design {
  constructor(presets, kept = null) {
    this.presets = presets;
    this.base = kept?.base ?? presets[0].name;
    this.title = kept?.title ?? speak("design.title");
    this.changes = kept?.changes ?? { targets: {} };
    if (!kept) this.promise();
    // What it was, step by step. Changes of one gesture, such as the letters that are typed into a field, are one step.
    this.past = [{ text: this.write(), gesture: 0 }];
    this.now = 0;
    this.gesture = 1;
  }

  // What a tab had when it was closed or loaded again; nothing that does not belong to these scenarios.
  static restore(presets) {
    try {
      const kept = JSON.parse(sessionStorage.getItem(KEPT));
      return new Design(presets, presets.some(({ name }) => name === kept?.base) ? kept : null);
    } catch { return new Design(presets); }
  }

  // The design of a run: the differences of its study from the default scenario.
  static of(presets, document) {
    const design = new Design(presets, { base: presets[0].name, title: document.title ?? "", changes: {} });
    for (const table of TABLES)
      if (document[table] !== undefined && !same(document[table], design.preset[table])) design.changes[table] = copy(document[table]);
    design.changes.run = { evaluations: document.run.evaluations };
    return design;
  }

  get preset() { return this.presets.find(({ name }) => name === this.base).document; }

  // Whoever prints an agent needs the miss that most flights stay within.
  promise() {
    if (!this.preset.robustness.conditions) this.changes.robustness = { ...this.changes.robustness, conditions: 20 };
  }

  choose(base) {
    const { targets } = this.changes;
    this.base = base;
    this.changes = { targets: targets ?? {} };
    this.promise();
    this.keep();
  }

  value(table, key) { return this.changes[table]?.[key] ?? this.preset[table]?.[key]; }

  get targets() { return this.changes.targets ?? this.preset.targets; }

  set(table, key, value) {
    const values = { ...this.changes[table] };
    if (value === null || value === "") delete values[key];
    else values[key] = value;
    this.changes = { ...this.changes, [table]: values };
    if (!Object.keys(values).length && table !== "targets") delete this.changes[table];
    this.keep();
  }

  rename(title) {
    this.title = title;
    this.keep();
  }

  setTargets(targets) {
    this.changes = { ...this.changes, targets };
    this.keep();
  }

  setKind(kind) {
    // Another profile has other keys; the speed stays.
    this.changes = { ...this.changes, flow: { kind, speed: this.value("flow", "speed") } };
    this.keep();
  }

  write() { return JSON.stringify({ base: this.base, title: this.title, changes: this.changes }); }

  // Takes what it is now as the latest step.
  keep() {
    const text = this.write();
    const { past, gesture } = this;
    if (text !== past[this.now].text) {
      const isSame = this.now > 0 && past[this.now].gesture === gesture;
      past.splice(this.now + (isSame ? 0 : 1), Infinity, { text, gesture });
      if (isSame && past[this.now - 1].text === text) past.pop();
      this.now = past.length - 1;
    }
    sessionStorage.setItem(KEPT, text);
  }

  get canUndo() { return this.now > 0; }

  get canRedo() { return this.now + 1 < this.past.length; }

  // Goes back by a step, or forward again.
  go(step) {
    this.now += step;
    Object.assign(this, JSON.parse(this.past[this.now].text));
    this.gesture++;
    sessionStorage.setItem(KEPT, this.past[this.now].text);
  }

  // Forgets what the present gesture has changed.
  rewind() {
    if (!this.now || this.past[this.now].gesture !== this.gesture) return;
    const { gesture } = this;
    this.go(-1);
    this.past.pop();
    this.gesture = gesture;
  }

  // What the server makes a study file of. Where bends and junctions are, some flights come to rest in a corner, where they take
  // a minute of processor time: they are given up earlier.
  document() {
    const run = { ...(this.parts.length ? { evaluation_timeout: PATIENCE } : {}), ...this.changes.run };
    return { title: this.title, base: this.base, ...this.changes, ...(Object.keys(run).length ? { run } : {}) };
  }

  get segment() { return this.value("pipe", "segments")?.[0] ?? null; }

  // The parts of a pipe that is laid of parts; a straight one has none.
  get parts() { return this.segment ? [] : this.value("pipe", "parts") ?? []; }

  // A pipe in words: length of a straight one, bore at the inlet, and the angle by which it leads down there.
  get inlet() {
    const { segment } = this;
    const way = segment ? segment.end.map((v, i) => v - segment.start[i]) : this.value("pipe", "direction") ?? [1, 0, 0];
    const length = Math.hypot(...way);
    const radius = segment ? segment.radius : this.value("pipe", "radius");
    return { length: round(length, 1e-4), diameter: round(2 * radius, 1e-4), slope: round((-180 / Math.PI) * Math.asin(way[2] / length), 1e-3) };
  }

  setInlet(changed) {
    const { length, diameter, slope } = { ...this.inlet, ...changed };
    const { segment } = this;
    const way = segment ? segment.end.map((v, i) => v - segment.start[i]) : this.value("pipe", "direction") ?? [1, 0, 0];
    const level = Math.hypot(way[0], way[1]);
    const ahead = level > 1e-9 ? [way[0] / level, way[1] / level] : [1, 0];
    const angle = (slope * Math.PI) / 180;
    const to = [ahead[0] * Math.cos(angle), ahead[1] * Math.cos(angle), -Math.sin(angle)];
    const radius = round(diameter / 2, 1e-6);
    if (segment) this.set("pipe", "segments", [{ start: segment.start, end: segment.start.map((v, i) => round(v + length * to[i], 1e-6)), radius }]);
    else this.setPipe({ ...this.changes.pipe, radius, direction: to.map((v) => round(v, 1e-9)) });
  }

  setPipe(pipe) {
    this.changes = { ...this.changes, pipe };
    this.keep();
  }

  // Lays a pipe of parts; one that is a single straight becomes a segment again, and one without parts is not a pipe.
  setParts(parts) {
    const { segment, inlet } = this;
    const start = segment?.start ?? this.value("pipe", "start") ?? [0, 0, 0];
    const way = segment ? segment.end.map((v, i) => (v - segment.start[i]) / inlet.length) : this.value("pipe", "direction") ?? [1, 0, 0];
    const radius = round(inlet.diameter / 2, 1e-6);
    if (parts.length === 1 && parts[0].kind === "straight" && !this.preset.pipe.parts?.length) {
      const size = Math.hypot(...way);
      this.setPipe({ segments: [{ start, end: start.map((v, i) => round(v + (parts[0].length * way[i]) / size, 1e-6)), radius }] });
      return;
    }
    nameOutlets(parts);
    this.setPipe({ segments: [], radius, start, direction: way.map((v) => round(v, 1e-9)), parts });
  }
}

export const isJunction = ({ kind }) => kind === "tee" || kind === "wye";

// A pipe with branches has several outlets, and each needs a name.
function nameOutlets(parts) {
  const ends = [];
  const visit = (chain) => {
    // A chain that is longer or shorter than before ends in the same outlet.
    const end = chain.at(-1), name = chain.findLast(({ outlet }) => outlet)?.outlet;
    for (const part of chain) {
      delete part.outlet;
      if (part === end) { ends.push(part); if (name) part.outlet = name; }
      if (isJunction(part)) visit(part.branch);
    }
  };
  visit(parts);
  if (ends.length === 1) { delete ends[0].outlet; return; }
  const used = new Set();
  for (const end of ends) if (used.has(end.outlet)) delete end.outlet; else used.add(end.outlet);
  for (const end of ends.filter(({ outlet }) => !outlet)) {
    end.outlet = [..."ABCDEFGHIJKLMNOPQRSTUVWXYZ"].find((letter) => !used.has(letter)) ?? `outlet ${used.size}`;
    used.add(end.outlet);
  }
}

// The name of each part: its own, or its kind with a number, as driftform names them.
export function nameParts(parts, names = new Map(), counts = {}) {
  for (const part of parts) {
    counts[part.kind] = (counts[part.kind] ?? 0) + 1;
    names.set(part, part.name || `${part.kind} ${counts[part.kind]}`);
    if (isJunction(part)) nameParts(part.branch, names, counts);
  }
  return names;
}

// Parts without names and outlets that are not given.
export function dropEmpty(parts) {
  for (const part of parts) {
    for (const key of ["name", "outlet"]) if (!part[key]) delete part[key];
    if (part.branch) dropEmpty(part.branch);
  }
  return parts;
}

// What a new part begins with: sizes of the bore that it continues.
export function newPart(kind, radius) {
  const size = (factor) => Number((factor * radius).toPrecision(2));
  switch (kind) {
    case "bend": return { kind, radius: size(3), angle_deg: 90, roll_deg: 180 };
    case "reducer": return { kind, length: size(2), radius: size(0.7) };
    case "tee": return { kind, branch_radius: size(0.5), share: 0.3, roll_deg: 180, branch: [newPart("straight", radius)] };
    case "wye": return { kind, branch_radius: size(0.5), share: 0.3, angle_deg: 60, roll_deg: 180, branch: [newPart("straight", radius)] };
    default: return { kind, length: size(4) };
  }
}

export const nameFlow = (kind) => (has(`flow.${kind}`) ? speak(`flow.${kind}`) : kind);
export const WATERS = { fresh: [999.1, 1.14e-6], sea: [1024, 1.05e-6] };

// A study in a few words: what a run was made of.
export function describe(document) {
  const { pipe, flow, fluid, targets, run, simulator, strategy } = document;
  const [first] = pipe.segments ?? [];
  const width = (radius) => Number((2 * radius).toPrecision(4));
  const size = (s) => Number(Math.hypot(...s.end.map((v, i) => v - s.start[i])).toPrecision(4));
  const known = Object.keys(WATERS).find((name) => same(WATERS[name], [fluid.density, fluid.viscosity]));
  const shape = first ? speak("fact.straight", { length: size(first), width: width(first.radius) }) : pipe.parts?.length ? speak("fact.parted", { count: pipe.parts.length, width: width(pipe.radius) }) : speak("fact.open");
  return [
    [speak("fact.pipe"), shape],
    [speak("fact.current"), `${flow.speed} m/s, ${nameFlow(flow.kind).replace(/ \(.*/, "")}`],
    [speak("fact.water"), known ? speak(`water.${known}`) : `${fluid.density} kg/m³`], [speak("fact.targets"), `${Object.keys(targets).length}`],
    [speak("fact.search"), `${strategy?.use ?? ""}, ${simulator.use}`], [speak("fact.seed"), `${run.seed}`],
  ];
}
