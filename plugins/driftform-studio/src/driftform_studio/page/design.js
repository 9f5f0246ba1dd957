// The design in the making: a built-in scenario, and what of it was changed. It lives in its tab, and nowhere else.
import { find, make, round } from "./parts.js";

const KEPT = "driftform-design";
const TABLES = ["pipe", "flow", "gusts", "fluid", "release", "contact", "flight", "robustness", "targets", "strategy", "simulator", "hydrodynamics", "builder", "grammar", "fitness"];
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
const copy = (value) => JSON.parse(JSON.stringify(value));

export class Design {
  constructor(presets, kept = null) {
    this.presets = presets;
    this.base = kept?.base ?? presets[0].name;
    this.title = kept?.title ?? "My pipe";
    this.changes = kept?.changes ?? { targets: {} };
    if (!kept) this.promise();
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

  setTargets(targets) {
    this.changes = { ...this.changes, targets };
    this.keep();
  }

  setKind(kind) {
    // Another profile has other keys; the speed stays.
    this.changes = { ...this.changes, flow: { kind, speed: this.value("flow", "speed") } };
    this.keep();
  }

  keep() {
    sessionStorage.setItem(KEPT, JSON.stringify({ base: this.base, title: this.title, changes: this.changes }));
  }

  // What the server makes a study file of.
  document() { return { title: this.title, base: this.base, ...this.changes }; }

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

const isJunction = ({ kind }) => kind === "tee" || kind === "wye";

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

// Parts without names and outlets that are not given.
function dropEmpty(parts) {
  for (const part of parts) {
    for (const key of ["name", "outlet"]) if (!part[key]) delete part[key];
    if (part.branch) dropEmpty(part.branch);
  }
  return parts;
}

// What a new part begins with: sizes of the bore that it continues.
function newPart(kind, radius) {
  const size = (factor) => Number((factor * radius).toPrecision(2));
  switch (kind) {
    case "bend": return { kind, radius: size(3), angle_deg: 90, roll_deg: 180 };
    case "reducer": return { kind, length: size(2), radius: size(0.7) };
    case "tee": return { kind, branch_radius: size(0.5), share: 0.3, roll_deg: 180, branch: [newPart("straight", radius)] };
    case "wye": return { kind, branch_radius: size(0.5), share: 0.3, angle_deg: 60, roll_deg: 180, branch: [newPart("straight", radius)] };
    default: return { kind, length: size(4) };
  }
}

const KINDS = {
  uniform: "Uniform (no wall friction)", power_law: "Power law", developed: "Developed (laminar or logarithmic)", log_law: "Logarithmic law (real pipe)", developing: "Developing from the inlet", turbulent: "Logarithmic law with gusts",
};
const PART_LABELS = {
  length: "Length", radius: "Radius", angle_deg: "Angle", roll_deg: "Roll, 180 is down", branch_radius: "Branch radius", share: "Share of the water", fillet: "Rounding", name: "Name", outlet: "Outlet",
};
// What most studies set comes first; the rest is below "More".
const FIRST = ["speed", "roughness", "exponent"];
const rankOfFlow = (option) => (FIRST.indexOf(option) + FIRST.length + 1) % (FIRST.length + 1);
const LABELS = { speed: "Mean speed", roughness: "Wall roughness", exponent: "Exponent n", upstream: "Pipe before the inlet", swirl: "Secondary flow of bends", acceleration: "Acceleration" };
const WATERS = { "Fresh, 15 °C": [999.1, 1.14e-6], "Sea, 20 °C": [1024, 1.05e-6] };

// A study in a few words: what a run was made of.
export function describe(document) {
  const { pipe, flow, fluid, targets, run, simulator, strategy } = document;
  const [first] = pipe.segments ?? [];
  const wide = (radius) => `${Number((2 * radius).toPrecision(4))} m wide`;
  const size = (s) => Number(Math.hypot(...s.end.map((v, i) => v - s.start[i])).toPrecision(4));
  const water = Object.entries(WATERS).find(([, pair]) => same(pair, [fluid.density, fluid.viscosity]))?.[0] ?? `${fluid.density} kg/m³`;
  return [
    ["pipe", first ? `${size(first)} m long, ${wide(first.radius)}` : pipe.parts?.length ? `${pipe.parts.length} parts, ${wide(pipe.radius)}` : "open water"],
    ["current", `${flow.speed} m/s, ${(KINDS[flow.kind] ?? flow.kind).toLowerCase().replace(/ \(.*/, "")}`],
    ["water", water], ["targets", `${Object.keys(targets).length}`],
    ["search", `${strategy?.use ?? ""}, ${simulator.use}`], ["seed", `${run.seed}`],
  ];
}

// The fields of a design. `changed` is called after each change; `errors` are the keys that a field answers for.
export class Fields {
  constructor(begin, changed) {
    this.begin = begin;
    this.changed = changed;
    this.design = null;
    for (const form of document.forms) form.addEventListener("submit", (event) => event.preventDefault());
    find("preset").append(...begin.presets.map(({ name, title }) => make("option", { value: name }, title)));
    find("preset").addEventListener("change", (event) => { this.design.choose(event.target.value); this.show(this.design); this.changed(true); });
  }

  number(label, unit, value, errors, act, attributes = {}) {
    const input = make("input", {
      type: "number", step: "any", value: value ?? "", "data-errors": errors, ...attributes,
      // A field that is being emptied is not an error yet.
      oninput: (event) => { const text = event.target.value; if (text !== "" || attributes.placeholder) { act(text === "" ? null : Number(text)); this.changed(); } },
    });
    return make("label", { class: "field" }, label, ...(unit ? [` (${unit})`] : []), input);
  }

  select(label, options, value, errors, act, wide = true) {
    const input = make("select", { "data-errors": errors, onchange: (event) => { act(event.target.value); this.changed(true); } },
      ...options.map(([name, text]) => make("option", { value: name, selected: name === value }, text)));
    return make("label", { class: wide ? "field wide" : "field" }, label, " ", input);
  }

  show(design) {
    this.design = design;
    find("preset").value = design.base;
    this.showPipe();
    this.showFlow();
    this.showFluid();
    this.showSearch();
    this.showTargets();
  }

  showPipe() {
    const { design } = this;
    const { segment } = design;
    const parts = dropEmpty(copy(design.parts));
    find("pipe-parts").replaceChildren();
    if (!segment && !parts.length) { find("pipe-fields").replaceChildren(make("p", { class: "hint wide" }, "Open water: no pipe.")); return; }
    const field = (label, unit, key, errors) => this.number(label, unit, design.inlet[key], errors, (value) => design.setInlet({ [key]: value }));
    find("pipe-fields").replaceChildren(
      ...(segment ? [field("Length", "m", "length", "pipe.segments[0].end pipe.segments[0] pipe.segments pipe")] : []),
      field(segment ? "Inner diameter" : "Inlet diameter", "m", "diameter", "pipe.segments[0].radius pipe.radius"),
      field(segment ? "Slope, down" : "Inlet slope, down", "°", "slope", "pipe.segments[0].start pipe.direction"),
      this.number("Water level", "m", design.value("fluid", "water_level"), "fluid.water_level", (value) => design.set("fluid", "water_level", value), { placeholder: "full" }),
    );
    if (segment) parts.push({ kind: "straight", length: design.inlet.length });
    const act = (again) => {
      // The length of a straight pipe may have changed since its rows were made.
      if (design.segment) parts[0].length = design.inlet.length;
      design.setParts(parts);
      if (again) this.showPipe();
      this.changed(again);
    };
    find("pipe-parts").append(this.makeChain(parts, "pipe.parts", () => design.inlet.diameter / 2, act, segment !== null));
  }

  // The parts of a run or of a branch, one row each, after a bore of a `radius`; `act` keeps what was changed, and shows
  // the rows again if asked to.
  makeChain(parts, key, radius, act, bare) {
    const rows = bare ? [] : parts.map((part, i) => this.makePart(parts, i, `${key}[${i}]`, radius, act));
    const label = key === "pipe.parts" ? "Add a part to the pipe" : "Add a part to the branch";
    const add = make("select", { "aria-label": label, onchange: (event) => {
      // A bore that a reducer has changed goes on with its new radius.
      const bore = parts.findLast(({ kind }) => kind === "reducer")?.radius ?? radius();
      parts.push(newPart(event.target.value, bore));
      act(true);
      [...document.querySelectorAll(".part")].find((row) => row.dataset.errors === `${key}[${parts.length - 1}]`)?.querySelector("input")?.focus();
    } }, make("option", { value: "" }, `${label} …`), ...Object.keys(this.begin.parts).map((kind) => make("option", { value: kind }, kind)));
    return make("div", { class: "chain" }, ...rows, make("div", { class: "field" }, add));
  }

  makePart(parts, i, key, radius, act) {
    const part = parts[i];
    const isEnd = i === parts.length - 1;
    const title = `${part.name || part.kind} ${part.name ? "" : i + 1}`.trim();
    const move = (to) => () => { parts.splice(to, 0, ...parts.splice(i, 1)); act(true); };
    const fields = [], rare = [];
    for (const { option, type, unit, help, default: usual } of this.begin.parts[part.kind]) {
      if (option === "kind" || option === "branch" || (option === "outlet" && !(isEnd && part.outlet))) continue;
      const label = PART_LABELS[option] ?? option;
      const attributes = { title: help, "aria-label": `${label} of ${title}`, "data-errors": `${key}.${option}` };
      const set = (value) => { if (value === null || value === "") delete part[option]; else part[option] = value; act(false); };
      const isText = type === "str";
      const field = isText
        ? make("label", { class: "field" }, label, make("input", { type: "text", maxlength: 40, value: part[option] ?? "", ...attributes, onchange: (event) => set(event.target.value.trim()) }))
        : this.number(label, unit === "deg" ? "°" : unit, part[option] ?? (usual === "None" ? "" : usual), `${key}.${option}`, (value) => set(value), { ...attributes, ...(usual === "None" ? { placeholder: "usual" } : {}) });
      (["name", "fillet"].includes(option) ? rare : fields).push(field);
    }
    const button = (text, words, work, disabled = false) => make("button", { type: "button", class: "square", "aria-label": `${words} ${title}`, disabled, onclick: work }, text);
    return make("fieldset", { class: "part", "data-errors": key },
      make("legend", {}, title),
      make("div", { class: "bar" }, button("↑", "Move up", move(i - 1), i === 0), button("↓", "Move down", move(i + 1), isEnd), button("×", "Remove", () => { parts.splice(i, 1); act(true); }, parts.length === 1)),
      make("div", { class: "fields" }, ...fields),
      ...(rare.length ? [make("details", {}, make("summary", {}, "More"), make("div", { class: "fields" }, ...rare))] : []),
      ...(isJunction(part) ? [make("h4", {}, "Branch"), this.makeChain(part.branch, `${key}.branch`, () => part.branch_radius, act, false)] : []));
  }

  showFlow() {
    const { design } = this;
    const kind = design.value("flow", "kind");
    const known = Object.fromEntries(this.begin.flows[kind].map(({ option, default: usual }) => [option, usual]));
    const rows = this.begin.flows[kind].filter(({ option, type }) => ["float", "int"].includes(type) && option !== "seed").sort((a, b) => rankOfFlow(a.option) - rankOfFlow(b.option));
    const fields = rows.map(({ option, unit, help }) => {
      // A key that only another profile has in the base is not this one's.
      const value = design.changes.flow?.[option] ?? (design.preset.flow.kind === kind ? design.preset.flow[option] : Number(known[option]));
      return this.number(LABELS[option] ?? option, unit, value, `flow.${option}`, (v) => design.set("flow", option, v), { title: help });
    });
    // The speed, and what else matters of a profile in practice.
    const more = fields.splice(kind === "uniform" ? 1 : 2);
    find("flow-fields").replaceChildren(
      this.select("Profile", Object.keys(this.begin.flows).map((name) => [name, KINDS[name] ?? name]), kind, "flow.kind flow", (name) => { design.setKind(name); this.showFlow(); }),
      ...fields, ...(more.length ? [make("details", { class: "wide" }, make("summary", {}, "More"), make("div", { class: "fields" }, ...more))] : []),
    );
  }

  showFluid() {
    const { design } = this;
    const [density, viscosity] = ["density", "viscosity"].map((key) => design.value("fluid", key));
    const named = Object.entries(WATERS).find(([, pair]) => same(pair, [density, viscosity]))?.[0] ?? "Other";
    find("fluid-fields").replaceChildren(
      this.select("Kind", [...Object.keys(WATERS), "Other"].map((name) => [name, name]), named, "fluid", (name) => {
        const pair = WATERS[name];
        // Other water begins with that of the base, and shows its numbers.
        design.set("fluid", "density", pair?.[0] ?? 1000);
        design.set("fluid", "viscosity", pair?.[1] ?? 1e-6);
        this.showFluid();
      }),
      ...(named === "Other" ? [
        this.number("Density", "kg/m³", density, "fluid.density", (v) => design.set("fluid", "density", v)),
        this.number("Viscosity", "m²/s", viscosity, "fluid.viscosity", (v) => design.set("fluid", "viscosity", v)),
      ] : []),
    );
  }

  showSearch() {
    const { design } = this;
    const simulator = design.value("simulator", "use");
    const simulators = [...new Set(["exudyn", "native", simulator])].map((name) => [name, name === "native" ? "native (fastest)" : name]);
    const name = make("input", { type: "text", value: design.title, maxlength: 80, "data-errors": "title", oninput: (event) => { design.title = event.target.value; design.keep(); this.changed(); } });
    this.flights = this.number("Flights", "", design.changes.run?.evaluations, "run.evaluations run", (v) => design.set("run", "evaluations", v), { placeholder: "50 per target", min: 1, step: 1 });
    find("search-fields").replaceChildren(
      make("label", { class: "field wide" }, "Name", name),
      this.flights,
      this.number("Disturbed flights", "", design.value("robustness", "conditions"), "robustness.conditions robustness", (v) => design.set("robustness", "conditions", v), { min: 0, step: 1, title: "of each finalist, by which the best is chosen; 0 for a search without a promise" }),
      this.select("Simulator", simulators, simulator, "simulator.use simulator", (use) => design.set("simulator", "use", use), false),
      this.number("Seed", "", design.changes.run?.seed, "run.seed", (v) => design.set("run", "seed", v), { placeholder: "drawn", min: 0, step: 1 }),
    );
  }

  // A row for each target; only what changed is made anew, so that a field keeps its cursor.
  showTargets() {
    const { targets } = this.design;
    const list = find("targets");
    const names = Object.keys(targets);
    const rows = [...list.querySelectorAll(".target:not(.head)")];
    if (!same(rows.map((row) => [row.dataset.name, row.dataset.outlet]), names.map((name) => [name, this.outletOf(name)]))) {
      const head = make("div", { class: "target head", "aria-hidden": "true" }, ...["", "name", "x m", "y m", "z m", ""].map((text) => make("span", {}, text)));
      list.replaceChildren(...(names.length ? [head] : []), ...names.map((name, number) => this.makeTarget(name, number)));
      return;
    }
    rows.forEach((row) => [...row.querySelectorAll("input[type=number]")].forEach((input, i) => {
      const value = this.pointOf(row.dataset.name)[i];
      if (input !== document.activeElement && (input.value === "" || Number(input.value) !== value)) input.value = value;
    }));
  }

  makeTarget(name, number) {
    const { design } = this;
    const dot = make("i", { class: "dot" });
    dot.style.background = `var(--s${number % 10})`;
    const rename = (event) => {
      const fresh = event.target.value.trim();
      if (!fresh || fresh === name || fresh in design.targets) { event.target.value = name; return; }
      design.setTargets(Object.fromEntries(Object.entries(design.targets).map(([key, point]) => [key === name ? fresh : key, point])));
      this.showTargets();
      this.changed(true);
    };
    const coordinate = (axis, i) => make("input", {
      type: "number", step: "0.01", value: this.pointOf(name)[i], "aria-label": `${axis} of ${name}, m`,
      oninput: (event) => {
        if (event.target.value === "") return;
        const point = [...this.pointOf(name)];
        point[i] = Number(event.target.value);
        design.setTargets({ ...design.targets, [name]: point });
        this.changed();
      },
    });
    const outlet = this.outletOf(name);
    return make("div", { class: "target", "data-name": name, "data-outlet": outlet, "data-errors": `targets.${name}` }, dot,
      make("input", { type: "text", value: name, maxlength: 60, "aria-label": `Name of target ${name}`, onchange: rename }),
      ...["x", "y", "z"].map(coordinate),
      make("button", { type: "button", class: "square", "aria-label": `Remove ${name}`, onclick: () => this.remove(name) }, "×"),
      ...(outlet ? [make("span", { class: "note" }, `outlet ${outlet}: moves with the pipe`)] : []));
  }

  outletOf(name) { return typeof this.design.targets[name] === "string" ? this.design.targets[name] : ""; }

  // The place of a target; that of an outlet is known once the pipe is laid.
  pointOf(name) {
    const target = this.design.targets[name];
    return typeof target === "string" ? this.places?.get(name) ?? ["", "", ""] : target;
  }

  // The targets that have a place, as the side view draws them.
  listPlaces() {
    return Object.keys(this.design.targets).map((name) => ({ name, position: this.pointOf(name) })).filter(({ position }) => position.every((v) => Number.isFinite(v)));
  }

  // What the laid pipe offers: the places of targets that are outlets, and a button for each outlet.
  showOutlets({ outlets, targets }) {
    this.places = new Map(targets.map(({ name, position }) => [name, position.map((v) => round(v, 1e-4))]));
    const names = outlets.map((name) => name || "outlet");
    const box = find("outlets");
    if (!same([...box.children].map((button) => button.dataset.outlet), names)) box.replaceChildren(...names.map((name) => make("button", {
      type: "button", "data-outlet": name, onclick: () => this.placeOutlet(name),
    }, names.length > 1 ? `Add outlet ${name}` : "Add the outlet")));
    this.showTargets();
  }

  placeOutlet(outlet) {
    const stem = outlet.replace(/[^\p{L}\p{N}_-]+/gu, "-").replace(/^outlet-?/, "") || "out";
    const { targets } = this.design;
    let name = stem.length < 3 && stem !== "out" ? `outlet-${stem}` : stem;
    for (let number = 2; name in targets; number++) name = `${stem}-${number}`;
    this.design.setTargets({ ...targets, [name]: outlet });
    this.showTargets();
    this.changed(true);
  }

  place(point) {
    const { targets } = this.design;
    let number = Object.keys(targets).length + 1;
    while (`T${number}` in targets) number++;
    this.design.setTargets({ ...targets, [`T${number}`]: point });
    this.showTargets();
    this.changed(true);
    return `T${number}`;
  }

  move(name, point) {
    this.design.setTargets({ ...this.design.targets, [name]: point });
    this.showTargets();
    this.changed();
  }

  remove(name) {
    const { [name]: _, ...rest } = this.design.targets;
    this.design.setTargets(rest);
    this.showTargets();
    this.changed(true);
  }

  // Shows each error at the field that answers for its key, and returns the others.
  showErrors(errors) {
    for (const old of document.querySelectorAll("form .error")) if (old.id !== "targets-error") old.remove();
    for (const old of document.querySelectorAll("[aria-invalid]")) { old.removeAttribute("aria-invalid"); old.removeAttribute("aria-describedby"); }
    find("targets-error").hidden = true;
    const fields = [...document.querySelectorAll("[data-errors]")].map((field) => ({ field, keys: field.dataset.errors.split(" ") }));
    return errors.filter(({ line, key }, number) => {
      if (key === "targets") { find("targets-error").textContent = line; find("targets-error").hidden = false; return false; }
      const answers = (name) => fields.find(({ field, keys }) => keys.includes(name) || field.dataset.errors === name);
      let found = key && answers(key);
      // An error of a part without a field of its own is shown at the part.
      for (let outer = key; !found && outer.startsWith("pipe.parts"); ) { outer = outer.replace(/(\.[^.[\]]+|\[\d+\])$/, ""); found = answers(outer); }
      if (!found) return true;
      const { field } = found;
      const id = `error-${number}`;
      (field.matches("input, select") ? field.closest("label") : field).append(make("p", { class: "error", id, role: "alert" }, line));
      for (const input of field.matches("input, select") ? [field] : field.matches(".target") ? field.querySelectorAll("input") : []) {
        input.setAttribute("aria-invalid", "true");
        input.setAttribute("aria-describedby", id);
      }
      field.closest("details")?.setAttribute("open", "");
      return false;
    });
  }
}
