// The forms of a design: pipe, current, water, release, agent and search. `changed` is called after each change.
import { give } from "./ask.js";
import { goTo, makeField, makeMore, makeNumber, makeSelect, makeText, recall, remember, sayFault } from "./controls.js";
import { copy, dropEmpty, isJunction, KINDS, nameParts, newPart, same, WATERS } from "./design.js";
import { find, make, round } from "./parts.js";
import { readBounds } from "./numbers.js";
import { Targets } from "./targets.js";
import { LABELS, sayLine } from "./words.js";

const PART_LABELS = {
  length: "Length", radius: "Radius of its axis", angle_deg: "Angle", roll_deg: "Roll, 180 is down", branch_radius: "Branch diameter", share: "Share of the water", fillet: "Rounding", name: "Name", outlet: "Outlet",
};
// What most studies set comes first; the rest is below "More".
const FIRST = ["speed", "roughness", "exponent"];
const rankOfFlow = (option) => (FIRST.indexOf(option) + FIRST.length + 1) % (FIRST.length + 1);

// What makers of printers state of the largest part, m.
const PRINTERS = {
  "Prusa MK4S": [0.25, 0.21, 0.22], "Bambu Lab X1C, P1S": [0.256, 0.256, 0.256], "Bambu Lab A1 mini": [0.18, 0.18, 0.18], "Creality Ender-3 V3 SE": [0.22, 0.22, 0.25],
};
const USUAL_BED = [0.25, 0.21, 0.21];
const SIMULATORS = { native: "native (compiled, fastest)", exudyn: "Exudyn (a multibody program, as a check)" };
const TWICE = (text) => Object.fromEntries(Object.entries(readBounds(text)).map(([name, limit]) => [name, 2 * limit]));
const nameOf = (path) => path.split(/[\\/]/).at(-1);
const millimetres = (value, places = 4) => Number((1000 * value).toFixed(places));

export class Fields {
  constructor(begin, changed) {
    this.begin = begin;
    this.changed = changed;
    this.design = null;
    this.targets = new Targets(this);
    for (const form of document.forms) form.addEventListener("submit", (event) => event.preventDefault());
    find("preset").append(...begin.presets.map(({ name, title }) => make("option", { value: name }, title)));
    find("preset").addEventListener("change", (event) => { this.design.choose(event.target.value); this.renew(); });
    // A field that holds what is no value has changed nothing.
    document.addEventListener("held", (event) => { if (this.design && "held" in event.target.dataset) this.design.rewind(); });
    // What begins with a new touch or key is a step of its own to be undone.
    for (const kind of ["pointerdown", "focusin"]) document.addEventListener(kind, () => { if (this.design) this.design.gesture++; });
    document.addEventListener("keydown", (event) => { if (this.design && !event.target.matches?.("input[type=text]")) this.design.gesture++; });
  }

  show(design) {
    if (design !== this.design) this.awaitsCapsule = false; // whether a capsule was chosen whose file is still missing
    this.design = design;
    const before = remember();
    find("preset").value = design.base;
    this.showPipe();
    this.showFlow();
    this.showFluid();
    this.showRelease();
    this.showAgent();
    this.showSearch();
    this.targets.show(true);
    recall(before);
  }

  // Shows all fields after a change that concerns several of them.
  renew() {
    this.show(this.design);
    this.changed(true);
  }

  // Where an option of the study is shown as a number.
  option(table, option, { label = LABELS[`${table}.${option}`], keys = `${table}.${option}`, ...options } = {}) {
    const { design } = this;
    const { unit, bounds, help } = this.begin.tables[table].find((row) => row.option === option);
    return makeNumber(label, design.value(table, option), (value) => { design.set(table, option, value); this.changed(); }, { unit: unit.replace("m3", "m³").replace("m2", "m²").replace("deg", "°"), bounds, keys, title: help, ...options });
  }

  showPipe() {
    const { design } = this;
    const { segment } = design;
    const parts = dropEmpty(copy(design.parts));
    const isParted = parts.length > 0;
    this.names = nameParts(parts);
    find("pipe-parts").replaceChildren();
    document.body.classList.toggle("parted", isParted);
    if (!segment && !isParted) { find("pipe-fields").replaceChildren(make("p", { class: "hint wide" }, "Open water: no pipe.")); return; }
    const field = (label, unit, key, keys, bounds) => makeNumber(label, design.inlet[key], (value) => { design.setInlet({ [key]: value }); this.changed(); }, { unit, keys, bounds });
    find("pipe-fields").replaceChildren(
      ...(segment ? [field("Length", "m", "length", "pipe.segments[0].end pipe.segments[0] pipe.segments pipe", this.begin.parts.straight.find(({ option }) => option === "length").bounds)] : []),
      field(segment ? "Inner diameter" : "Inlet diameter", "m", "diameter", "pipe.segments[0].radius pipe.radius", TWICE(this.begin.tables.pipe.find(({ option }) => option === "radius").bounds)),
      field(segment ? "Slope, down" : "Inlet slope, down", "°", "slope", "pipe.segments[0].start pipe.direction", { low: -90, high: 90 }),
      this.option("fluid", "water_level", { placeholder: "full" }),
    );
    if (segment) parts.push({ kind: "straight", length: design.inlet.length });
    const act = (again) => {
      // The length of a straight pipe may have changed since its rows were made.
      if (design.segment) parts[0].length = design.inlet.length;
      design.setParts(parts);
      if (again) { const before = remember(); this.showPipe(); recall(before); }
      this.changed(again);
    };
    find("pipe-parts").append(this.makeChain(parts, "pipe.parts", () => design.inlet.diameter / 2, act, segment !== null));
  }

  // The parts of a run or of a branch, one box each, after a bore of a `radius`; `act` keeps what was changed, and shows
  // the boxes again if asked to.
  makeChain(parts, key, radius, act, bare) {
    const rows = bare ? [] : parts.map((part, i) => this.makePart(parts, i, `${key}[${i}]`, radius, act));
    const label = key === "pipe.parts" ? "Add a part to the pipe" : "Add a part to the branch";
    const add = make("select", { "aria-label": label, onchange: (event) => {
      // A bore that a reducer has changed goes on with its new radius.
      const bore = parts.findLast(({ kind }) => kind === "reducer")?.radius ?? radius();
      parts.push(newPart(event.target.value, bore));
      act(true);
      goTo(`${key}[${parts.length - 1}]`);
    } }, make("option", { value: "" }, `${label} …`), ...Object.keys(this.begin.parts).map((kind) => make("option", { value: kind }, kind)));
    return make("div", { class: "chain" }, ...rows, make("div", { class: "field" }, add));
  }

  makePart(parts, i, key, radius, act) {
    const part = parts[i];
    const isEnd = i === parts.length - 1;
    const title = this.names.get(part);
    const move = (to) => () => { parts.splice(to, 0, ...parts.splice(i, 1)); act(true); };
    const fields = [], rare = [];
    for (const { option, type, unit, bounds, help, default: usual } of this.begin.parts[part.kind]) {
      if (option === "kind" || option === "branch" || (option === "outlet" && !(isEnd && part.outlet))) continue;
      // Bores are stated as diameters everywhere; the radius of a bend is not that of a bore.
      const isBore = option === "branch_radius" || (option === "radius" && part.kind === "reducer");
      const label = option === "radius" && isBore ? "Diameter at its end" : PART_LABELS[option] ?? option;
      const options = { keys: `${key}.${option}`, title: help.replace("radius", isBore ? "diameter" : "radius"), named: `${label} of ${title}` };
      const set = (value) => { if (value === null || value === "") delete part[option]; else part[option] = isBore ? round(value / 2, 1e-6) : value; act(false); };
      const value = part[option] ?? (usual === "None" ? "" : Number(usual));
      const field = type === "str"
        ? makeText(label, part[option] ?? "", set, { ...options, largest: 40, late: true })
        : makeNumber(label, isBore && value !== "" ? round(2 * value, 1e-6) : value, set, { ...options, unit: unit === "deg" ? "°" : unit, bounds: isBore ? TWICE(bounds) : bounds, ...(usual === "None" ? { placeholder: "usual" } : {}) });
      (["name", "fillet"].includes(option) ? rare : fields).push(field);
    }
    const button = (text, words, work, disabled = false) => make("button", { type: "button", class: "square", "aria-label": `${words} ${title}`, disabled, onclick: work }, text);
    return make("fieldset", { class: isJunction(part) ? "part junction" : "part", "data-errors": key },
      make("legend", {}, title),
      make("div", { class: "bar" }, button("↑", "Move up", move(i - 1), i === 0), button("↓", "Move down", move(i + 1), isEnd), button("×", "Remove", () => { parts.splice(i, 1); act(true); }, parts.length === 1)),
      make("div", { class: "fields" }, ...fields),
      ...makeMore(rare, `more-${key}`),
      ...(isJunction(part) ? [make("h4", {}, "Branch"), this.makeChain(part.branch, `${key}.branch`, () => part.branch_radius, act, false)] : []));
  }

  showFlow() {
    const { design } = this;
    const kind = design.value("flow", "kind");
    const known = Object.fromEntries(this.begin.flows[kind].map(({ option, default: usual }) => [option, usual]));
    const rows = this.begin.flows[kind].filter(({ option, type }) => ["float", "int"].includes(type) && option !== "seed").sort((a, b) => rankOfFlow(a.option) - rankOfFlow(b.option));
    const fields = rows.map(({ option, unit, bounds, help }) => {
      // A key that only another profile has in the base is not this one's.
      const value = design.changes.flow?.[option] ?? (design.preset.flow.kind === kind ? design.preset.flow[option] : Number(known[option]));
      return makeNumber(LABELS[`flow.${option}`] ?? option, value, (v) => { design.set("flow", option, v); this.changed(); }, { unit, bounds, keys: `flow.${option}`, title: help });
    });
    // The speed, and what else matters of a profile in practice.
    const more = fields.splice(kind === "uniform" ? 1 : 2);
    const gusts = makeSelect(LABELS["gusts.always"], [["", "in disturbed flights"], ["true", "in every flight"]], design.value("gusts", "always") ? "true" : "", (word) => { design.set("gusts", "always", word === "true"); this.changed(); }, { keys: "gusts.always gusts" });
    find("flow-fields").replaceChildren(
      makeSelect("Profile", Object.keys(this.begin.flows).map((name) => [name, KINDS[name] ?? name]), kind, (name) => { design.setKind(name); this.renew(); }, { keys: "flow.kind flow", wide: true }),
      ...fields, ...(kind === "grid" ? [this.makeCurrent()] : []), ...makeMore(kind === "uniform" ? more : [...more, gusts], "more-flow"),
    );
  }

  // A field for a file, which becomes part of the design: `take` keeps what the server answers.
  makeFile(key, label, accept, hint, take) {
    const note = make("p", { class: "hint" }, hint);
    const input = make("input", { type: "file", accept, onchange: async () => {
      const [file] = input.files;
      if (!file) return;
      const { design } = this;
      note.textContent = `Reading ${file.name} …`;
      try {
        const answer = await give(file, key);
        if (design === this.design) { take(answer); this.renew(); }
      } catch (error) { note.textContent = hint; sayFault(input, "own", error.message); }
    } });
    const field = makeField(label, input, key, { wide: true });
    field.append(note);
    return field;
  }

  makeCurrent() {
    const kept = this.design.value("flow", "file");
    return this.makeFile("flow.file", LABELS["flow.file"], ".csv,.nc,.vtk,.vtu", kept ? `In use: ${nameOf(kept)}` : "Velocities on a grid: .csv, .nc, .vtk or .vtu.", ({ file }) => this.design.set("flow", "file", file));
  }

  // A capsule is what the agent carries: its profile is a file.
  makeCapsule(builder, setCore) {
    const { awaitsCapsule } = this;
    const kept = awaitsCapsule ? "" : builder.core === "custom" ? "In use: the profile of the run. " : `In use: ${nameOf(builder.core)}. `;
    const field = this.makeFile("builder.core", "Profile of the capsule", ".csv", `${kept}A table of columns x_mm,r_mm: distance from the nose, which is fore, and radius.`, ({ file, length }) => {
      this.awaitsCapsule = false;
      // Until its balance is known: in its middle.
      setCore({ core: file, core_mass: Number(builder.core_mass.toPrecision(4)), core_cog: round(length / 2, 1e-5) });
    });
    const input = field.querySelector("input");
    input.toggleAttribute("data-held", awaitsCapsule);
    input.takeBack = () => { this.awaitsCapsule = false; this.renew(); };
    if (awaitsCapsule) sayFault(input, "own", "Give the file, or choose another core.");
    return field;
  }

  showFluid() {
    const { design } = this;
    const [density, viscosity] = ["density", "viscosity"].map((key) => design.value("fluid", key));
    const named = Object.entries(WATERS).find(([, pair]) => same(pair, [density, viscosity]))?.[0] ?? "Other";
    find("fluid-fields").replaceChildren(
      makeSelect("Kind", [...Object.keys(WATERS), "Other"].map((name) => [name, name]), named, (name) => {
        const pair = WATERS[name];
        // Other water begins with that of the base, and shows its numbers.
        design.set("fluid", "density", pair?.[0] ?? 1000);
        design.set("fluid", "viscosity", pair?.[1] ?? 1e-6);
        this.renew();
      }, { keys: "fluid.name fluid", wide: true }),
      ...(named === "Other" ? [this.option("fluid", "density"), this.option("fluid", "viscosity")] : []),
      ...makeMore([this.option("fluid", "gravity"), this.option("contact", "friction"), this.option("flight", "horizon")], "more-fluid"),
    );
  }

  showRelease() {
    find("release-fields").replaceChildren(...this.targets.makeRelease(), ...makeMore([this.option("release", "pitch_deg"), this.option("release", "yaw_deg"), this.option("robustness", "position", { unit: "m" })], "more-release"));
  }

  showAgent() {
    const { design } = this;
    const builder = { ...design.preset.builder, ...design.changes.builder };
    find("move-agent").hidden = builder.use !== "frusta";
    if (builder.use !== "frusta") return;
    const set = (key, value) => { design.set("builder", key, value); this.changed(); };
    const number = (label, key, value, scale, bounds, unit, title) => makeNumber(label, Number((value * scale).toPrecision(8)), (v) => set(key, Number((v / scale).toPrecision(8))), { unit, keys: `builder.${key}`, bounds, title });
    const cores = this.begin.cores.map(({ name, radius, mass }) => [name, `${name.replace(/-(\d+)mm$/, ", $1 mm")} (${millimetres(mass, 1)} g)`.replace("-", " ").replace(/^./, (letter) => letter.toUpperCase()), radius]);
    const setCore = (values) => { for (const [key, value] of Object.entries({ core_radius: null, core_mass: null, core_cog: null, core_profile: null, ...values })) design.set("builder", key, value); };
    const isCapsule = this.awaitsCapsule || typeof builder.core_cog === "number";
    const own = isCapsule ? [this.makeCapsule(builder, setCore), ...(this.awaitsCapsule ? [] : [
      number("Mass of the core", "core_mass", builder.core_mass, 1000, { above: 0, high: 1e6 }, "g", "of the capsule with all that is in it"),
      number(LABELS["builder.core_cog"], "core_cog", builder.core_cog, 1000, { low: 0, high: 1e6 }, "mm", "distance of the capsule's centre of gravity from its nose"),
    ])] : builder.core === "custom" ? [
      number("Diameter of the core", "core_radius", builder.core_radius, 2000, { above: 0, high: 2000 }, "mm"),
      number("Mass of the core", "core_mass", builder.core_mass, 1000, { above: 0, high: 1e6 }, "g"),
    ] : [];
    const kit = builder.kit ?? {};
    const bed = kit.bed ?? USUAL_BED;
    const printer = Object.entries(PRINTERS).find(([, size]) => same(size, bed))?.[0] ?? (same(bed, USUAL_BED) ? "usual" : "Own");
    const setBed = (size) => set("kit", { ...kit, bed: size });
    find("agent-fields").replaceChildren(
      makeSelect("Core", [...cores.map(([name, text]) => [name, text]), ["custom", "Own ball, of a size and mass"], ["capsule", "Own capsule, a file of its profile"]], isCapsule ? "capsule" : builder.core, (name) => {
        const known = this.begin.cores.find((core) => core.name === builder.core) ?? { radius: builder.core_radius, mass: builder.core_mass };
        this.awaitsCapsule = name === "capsule";
        // An own core begins as the one before it.
        if (name === "custom") setCore({ core: name, core_radius: known.radius, core_mass: Number(known.mass.toPrecision(4)) });
        else if (!this.awaitsCapsule) setCore({ core: name });
        this.renew();
      }, { keys: "builder.core builder", wide: true, title: "the heavy ball inside, or what the agent carries" }),
      ...own,
      makeSelect("Material", [...Object.entries(this.begin.materials).map(([name, density]) => [name, `${name} (${density} kg/m³)`]), ["custom", "Other"]], builder.material, (name) => {
        design.set("builder", "material", name);
        design.set("builder", "hull_density", name === "custom" ? builder.hull_density : null);
        this.renew();
      }, { keys: "builder.material", wide: true }),
      ...(builder.material === "custom" ? [number("Density of the print", "hull_density", builder.hull_density, 1, { low: 100, high: 10000 }, "kg/m³", "of the printed material: ABS has 1050")] : []),
      number("Wall", "wall", builder.wall, 1000, { low: 0.4, high: 50 }, "mm", "thickness of the printed wall"),
      makeSelect("Printer", [["usual", "Usual bed, 250 x 210 x 210 mm"], ...Object.entries(PRINTERS).map(([name, size]) => [name, `${name}: ${size.map((v) => millimetres(v)).join(" x ")} mm`]), ["Own", "Own"]], printer, (name) => {
        setBed(name === "usual" ? USUAL_BED : PRINTERS[name] ?? [0.3, 0.3, 0.3]);
        this.renew();
      }, { keys: "builder.kit.bed builder.kit", wide: true, title: "longer parts are cut at a joint" }),
      ...(printer === "Own" ? ["Width", "Depth", "Height"].map((label, i) => makeNumber(`${label} of the bed`, millimetres(bed[i]), (v) => setBed(bed.map((size, k) => (k === i ? v / 1000 : size))), { unit: "mm", bounds: { low: 10, high: 5000 }, keys: `builder.kit.bed[${i}]` })) : []),
      makeNumber("Nozzle", millimetres(kit.nozzle ?? 0.0004), (v) => set("kit", { ...kit, nozzle: v / 1000 }), { unit: "mm", bounds: { above: 0, high: 5 }, keys: "builder.kit.nozzle" }),
    );
  }

  showSearch() {
    const { design } = this;
    const simulator = design.value("simulator", "use");
    const simulators = [...new Set([...Object.keys(SIMULATORS), simulator])].map((name) => [name, SIMULATORS[name] ?? name]);
    const count = (label, table, key, options) => makeNumber(label, design.changes[table]?.[key] ?? (table === "run" ? undefined : design.value(table, key)), (v) => { design.set(table, key, v); this.changed(); }, { keys: `${table}.${key} ${table}`, whole: true, ...options });
    const within = design.value("robustness", "within");
    this.flights = count("Flights", "run", "evaluations", { placeholder: "50 per target", bounds: { low: 1, high: 1e7 } });
    find("search-fields").replaceChildren(
      makeText("Name", design.title, (text) => { design.rename(text); this.changed(); }, { keys: "title", wide: true }),
      this.flights,
      count("Disturbed flights", "robustness", "conditions", { bounds: { low: 0, high: 10000 }, title: "of each finalist, by which the best is chosen; 0 for a search without a promise" }),
      ...(within === null || within === undefined || typeof within === "number" ? [makeNumber("Near enough", within, (v) => { design.set("robustness", "within", v); this.changed(); }, { unit: "m", keys: "robustness.within", bounds: { above: 0, high: 1000 }, placeholder: "5 % of the pipe", title: "a flight that passes a target within this hits it" })] : []),
      ...makeMore([
        makeSelect("Simulator", simulators, simulator, (use) => { design.set("simulator", "use", use); this.changed(true); }, { keys: "simulator.use simulator", wide: true }),
        count("Seed", "run", "seed", { placeholder: "drawn", bounds: { low: 0, high: 2 ** 53 } }),
      ], "more-search"),
    );
  }

  // Shows each error at the field that answers for its key, and returns the others.
  showErrors(errors) {
    for (const old of document.querySelectorAll("form .error.said")) {
      const control = old.parentElement.querySelector(`[aria-describedby="${old.id}"]`);
      if (control) sayFault(control, "said"); else old.remove();
    }
    const fields = [...document.querySelectorAll("form [data-errors]")].map((field) => ({ field, keys: field.dataset.errors.split(" ") }));
    return errors.filter(({ line, key }) => {
      const answers = (name) => fields.find(({ keys }) => keys.includes(name))?.field;
      let field = key && answers(key);
      // An error of a part without a field of its own is shown at the part.
      for (let outer = key; !field && outer.startsWith("pipe.parts"); ) { outer = outer.replace(/(\.[^.[\]]+|\[\d+\])$/, ""); field = answers(outer); }
      if (!field) return true;
      sayFault(field, "said", ...sayLine(line, { key, go: goTo }), ...this.targets.offerRemedy(line, key));
      for (let box = field.closest("details"); box; box = box.parentElement.closest("details")) box.open = true;
      return false;
    });
  }
}
