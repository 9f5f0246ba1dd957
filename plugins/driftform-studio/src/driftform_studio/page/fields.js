// The forms of a design: pipe, current, water, release, agent and search. `changed` is called after each change.
import { give } from "./ask.js";
import { goTo, makeField, makeMore, makeNumber, makeSelect, makeText, recall, remember, sayFault } from "./controls.js";
import { copy, dropEmpty, isJunction, nameFlow, nameParts, newPart, same, WATERS } from "./design.js";
import { has, listMessages, speak } from "./messages.js";
import { find, make, round } from "./parts.js";
import { readBounds } from "./numbers.js";
import { canForget, forgetPrinter, keepPrinter, listPrinters } from "./printers.js";
import { Targets } from "./targets.js";
import { LABELS, sayLine } from "./words.js";

// What most studies set comes first; the rest is below "More".
const FIRST = ["speed", "roughness", "exponent"];
const rankOfFlow = (option) => (FIRST.indexOf(option) + FIRST.length + 1) % (FIRST.length + 1);

// Sand roughness of walls, m. Moody, Trans. ASME 66 (1944), fig. 1: drawn tubing, commercial steel, asphalted cast iron,
// galvanised iron, cast iron, and concrete from the smoothest to the roughest; rusted iron: Idelchik, Handbook of Hydraulic
// Resistance, table 2-1 (1 to 1.5 mm).
const WALLS = { smooth: 1.5e-6, steel: 4.6e-5, coated: 1.2e-4, galvanised: 1.5e-4, iron: 2.6e-4, cement: 3e-4, old: 1.5e-3, concrete: 3e-3 };
// Exponents n of u = U (1 - r/R)^(1/n), by Reynolds numbers of 4e3, 1e5 and 3e6 (Nikuradse 1932, in Schlichting, chapter XX).
const SHAPES = [6, 7, 10];
const USUAL_BED = [0.25, 0.21, 0.21];
const MORE_VISCOUS = 1e6; // mm²/s in a m²/s
const scaleBounds = (text, factor) => Object.fromEntries(Object.entries(readBounds(text)).map(([name, limit]) => [name, factor * limit]));
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
    // Whether a capsule was chosen whose file is still missing, and a printer whose bed is typed.
    if (design !== this.design) this.awaitsCapsule = this.isOwnPrinter = false;
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
  option(table, option, { label = LABELS[`${table}.${option}`], keys = `${table}.${option}`, scale = 1, ...options } = {}) {
    const { design } = this;
    const { unit, bounds, help } = this.begin.tables[table].find((row) => row.option === option);
    const value = design.value(table, option);
    return makeNumber(label, scale === 1 ? value : Number((value * scale).toPrecision(8)), (v) => { design.set(table, option, v === null ? v : Number((v / scale).toPrecision(8))); this.changed(); }, { unit: unit.replace("m3", "m³").replace("m2", "m²").replace("s2", "s²").replace("deg", "°"), bounds, keys, title: help, ...options });
  }

  showPipe() {
    const { design } = this;
    const { segment } = design;
    const parts = dropEmpty(copy(design.parts));
    const isParted = parts.length > 0;
    this.names = nameParts(parts);
    find("pipe-parts").replaceChildren();
    document.body.classList.toggle("parted", isParted);
    if (!segment && !isParted) { find("pipe-fields").replaceChildren(make("p", { class: "hint wide" }, speak("pipe.open"))); return; }
    const field = (label, unit, key, keys, bounds) => makeNumber(label, design.inlet[key], (value) => { design.setInlet({ [key]: value }); this.changed(); }, { unit, keys, bounds });
    find("pipe-fields").replaceChildren(
      ...(segment ? [field(LABELS["pipe.segments"], "m", "length", "pipe.segments[0].end pipe.segments[0] pipe.segments pipe", this.begin.parts.straight.find(({ option }) => option === "length").bounds)] : []),
      field(LABELS[segment ? "pipe.segments[0].radius" : "pipe.radius"], "m", "diameter", "pipe.segments[0].radius pipe.radius", scaleBounds(this.begin.tables.pipe.find(({ option }) => option === "radius").bounds, 2)),
      field(segment ? speak("pipe.slope") : LABELS["pipe.direction"], "°", "slope", "pipe.segments[0].start pipe.direction", { low: -90, high: 90 }),
      this.option("fluid", "water_level", { placeholder: speak("pipe.full") }),
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
    const label = speak(key === "pipe.parts" ? "parts.add" : "parts.add.branch");
    const add = make("select", { "aria-label": label, onchange: (event) => {
      // A bore that a reducer has changed goes on with its new radius.
      const bore = parts.findLast(({ kind }) => kind === "reducer")?.radius ?? radius();
      parts.push(newPart(event.target.value, bore));
      act(true);
      goTo(`${key}[${parts.length - 1}]`);
    } }, make("option", { value: "" }, speak("parts.choose", { label })), ...Object.keys(this.begin.parts).map((kind) => make("option", { value: kind }, has(`kind.${kind}`) ? speak(`kind.${kind}`) : kind)));
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
      const label = option === "radius" && isBore ? speak("part.end") : has(`part.${option}`) ? speak(`part.${option}`) : option;
      const options = { keys: `${key}.${option}`, title: help.replace("radius", isBore ? "diameter" : "radius"), named: speak("field.of", { label, name: title }) };
      const set = (value) => { if (value === null || value === "") delete part[option]; else part[option] = isBore ? round(value / 2, 1e-6) : value; act(false); };
      const value = part[option] ?? (usual === "None" ? "" : Number(usual));
      const field = type === "str"
        ? makeText(label, part[option] ?? "", set, { ...options, largest: 40, late: true })
        : makeNumber(label, isBore && value !== "" ? round(2 * value, 1e-6) : value, set, { ...options, unit: unit === "deg" ? "°" : unit, bounds: isBore ? scaleBounds(bounds, 2) : bounds, ...(usual === "None" ? { placeholder: speak("part.usual") } : {}) });
      (["name", "fillet"].includes(option) ? rare : fields).push(field);
    }
    const button = (text, words, work, disabled = false) => make("button", { type: "button", class: "square", "aria-label": words, disabled, onclick: work }, text);
    return make("fieldset", { class: isJunction(part) ? "part junction" : "part", "data-errors": key },
      make("legend", {}, title),
      make("div", { class: "bar" }, button("↑", speak("part.up", { name: title }), move(i - 1), i === 0), button("↓", speak("part.down", { name: title }), move(i + 1), isEnd), button("×", speak("remove", { name: title }), () => { parts.splice(i, 1); act(true); }, parts.length === 1)),
      make("div", { class: "fields" }, ...fields),
      ...makeMore(rare, `more-${key}`),
      ...(isJunction(part) ? [make("h4", {}, speak("branch")), this.makeChain(part.branch, `${key}.branch`, () => part.branch_radius, act, false)] : []));
  }

  showFlow() {
    const { design } = this;
    const kind = design.value("flow", "kind");
    const known = Object.fromEntries(this.begin.flows[kind].map(({ option, default: usual }) => [option, usual]));
    const rows = this.begin.flows[kind].filter(({ option, type }) => ["float", "int"].includes(type) && option !== "seed").sort((a, b) => rankOfFlow(a.option) - rankOfFlow(b.option));
    const fields = rows.flatMap(({ option, unit, bounds, help }) => {
      // A key that only another profile has in the base is not this one's.
      const value = design.changes.flow?.[option] ?? (design.preset.flow.kind === kind ? design.preset.flow[option] : Number(known[option]));
      const set = (v) => { design.set("flow", option, v); this.changed(); };
      // Roughness is stated in millimetres by everybody.
      const scale = option === "roughness" ? 1000 : 1;
      const show = (v) => Number((v * scale).toPrecision(8));
      const field = makeNumber(LABELS[`flow.${option}`] ?? option, show(value), (v) => { const found = Number((v / scale).toPrecision(8)); set(found); named?.querySelector("select").show(found); }, { unit: scale === 1 ? unit : "mm", bounds: scaleBounds(bounds, scale), keys: `flow.${option}`, title: help });
      const named = this.makeNamed(option, value, (v) => { set(v); field.querySelector("input").show(show(v)); });
      return named ? [[named, field]] : [[field]];
    });
    // The speed, and what else matters of a profile in practice.
    const more = fields.splice(kind === "uniform" ? 1 : 2).flat();
    const gusts = makeSelect(LABELS["gusts.always"], [["", speak("flow.gusts")], ["true", speak("flow.gusts.always")]], design.value("gusts", "always") ? "true" : "", (word) => { design.set("gusts", "always", word === "true"); this.changed(); }, { keys: "gusts.always gusts" });
    find("flow-fields").replaceChildren(
      makeSelect(LABELS["flow.kind"], Object.keys(this.begin.flows).map((name) => [name, nameFlow(name)]), kind, (name) => { design.setKind(name); this.renew(); }, { keys: "flow.kind flow", wide: true }),
      ...fields.flat(), ...(kind === "grid" ? [this.makeCurrent()] : []), ...makeMore(kind === "uniform" ? more : [...more, gusts], "more-flow"),
    );
  }

  // A choice by name of a number that few know, null for others: what a wall is made of, or how flat a profile is.
  makeNamed(option, value, act) {
    if (!["roughness", "exponent"].includes(option)) return null;
    const choices = option === "roughness" ? Object.entries(WALLS).map(([name, size]) => [`${size}`, speak(`wall.of.${name}`)]) : SHAPES.map((n) => [`${n}`, speak(`shape.${n}`)]);
    const known = (v) => choices.find(([text]) => Number(text) === v)?.[0] ?? "";
    const field = makeSelect(speak(option === "roughness" ? "flow.wall" : "flow.shape"), [...choices, ["", speak("flow.measured")]], known(value), (text) => { if (text) act(Number(text)); }, { keys: `flow.${option}.named`, wide: true });
    field.querySelector("select").show = (v) => { field.querySelector("select").value = known(v); };
    return field;
  }

  // A field for a file, which becomes part of the design: `take` keeps what the server answers.
  makeFile(key, label, accept, hint, take) {
    const note = make("p", { class: "hint" }, hint);
    const input = make("input", { type: "file", accept, onchange: async () => {
      const [file] = input.files;
      if (!file) return;
      const { design } = this;
      note.textContent = speak("file.reading", { file: file.name });
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
    return this.makeFile("flow.file", LABELS["flow.file"], ".csv,.nc,.vtk,.vtu", kept ? speak("file.used", { file: nameOf(kept) }) : speak("flow.file.hint"), ({ file }) => this.design.set("flow", "file", file));
  }

  // A capsule is what the agent carries: its profile is a file.
  makeCapsule(builder, setCore) {
    const { awaitsCapsule } = this;
    const kept = awaitsCapsule ? "" : builder.core === "custom" ? speak("capsule.of.run") : speak("capsule.used", { file: nameOf(builder.core) });
    const field = this.makeFile("builder.core", speak("capsule.profile"), ".csv", speak("capsule.hint", { used: kept }), ({ file, length }) => {
      this.awaitsCapsule = false;
      // Until its balance is known: in its middle.
      setCore({ core: file, core_mass: Number(builder.core_mass.toPrecision(4)), core_cog: round(length / 2, 1e-5) });
    });
    const input = field.querySelector("input");
    input.toggleAttribute("data-held", awaitsCapsule);
    input.takeBack = () => { this.awaitsCapsule = false; this.renew(); };
    if (awaitsCapsule) sayFault(input, "own", speak("capsule.missing"));
    return field;
  }

  showFluid() {
    const { design } = this;
    const [density, viscosity] = ["density", "viscosity"].map((key) => design.value("fluid", key));
    const named = Object.entries(WATERS).find(([, pair]) => same(pair, [density, viscosity]))?.[0] ?? "other";
    find("fluid-fields").replaceChildren(
      makeSelect(LABELS["fluid.name"], [...Object.keys(WATERS), "other"].map((name) => [name, speak(`water.${name}`)]), named, (name) => {
        const pair = WATERS[name];
        // Other water begins with that of the base, and shows its numbers.
        design.set("fluid", "density", pair?.[0] ?? 1000);
        design.set("fluid", "viscosity", pair?.[1] ?? 1e-6);
        this.renew();
      }, { keys: "fluid.name fluid", wide: true }),
      ...(named === "other" ? [this.option("fluid", "density"), this.option("fluid", "viscosity", { unit: "mm²/s", scale: MORE_VISCOUS, bounds: { above: 0, high: MORE_VISCOUS } })] : []),
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
    const cores = this.begin.cores.map(({ name, mass }) => {
      const [, ball, size] = name.match(/^(.*)-(\d+)mm$/);
      return [name, speak("core.of", { material: has(`ball.${ball}`) ? speak(`ball.${ball}`) : ball, size, mass: millimetres(mass, 1) })];
    });
    const setCore = (values) => { for (const [key, value] of Object.entries({ core_radius: null, core_mass: null, core_cog: null, core_profile: null, ...values })) design.set("builder", key, value); };
    const isCapsule = this.awaitsCapsule || typeof builder.core_cog === "number";
    const own = isCapsule ? [this.makeCapsule(builder, setCore), ...(this.awaitsCapsule ? [] : [
      number(LABELS["builder.core_mass"], "core_mass", builder.core_mass, 1000, { above: 0, high: 1e6 }, "g", speak("capsule.mass.help")),
      number(LABELS["builder.core_cog"], "core_cog", builder.core_cog, 1000, { low: 0, high: 1e6 }, "mm", speak("capsule.cog.help")),
    ])] : builder.core === "custom" ? [
      number(LABELS["builder.core_radius"], "core_radius", builder.core_radius, 2000, { above: 0, high: 2000 }, "mm"),
      number(LABELS["builder.core_mass"], "core_mass", builder.core_mass, 1000, { above: 0, high: 1e6 }, "g"),
    ] : [];
    const kit = builder.kit ?? {};
    const bed = kit.bed ?? USUAL_BED;
    const printers = listPrinters();
    const printer = this.isOwnPrinter ? "Own" : Object.entries(printers).find(([, size]) => same(size, bed))?.[0] ?? (same(bed, USUAL_BED) ? "usual" : "Own");
    // What it is now: the fields are not made anew while one of them is typed.
    const setKit = (key, value) => set("kit", { ...design.value("builder", "kit"), [key]: value });
    const setBed = (size) => setKit("bed", size);
    const ballast = { ...design.preset.builder.ballast, ...builder.ballast };
    find("agent-fields").replaceChildren(
      makeSelect(LABELS["builder.core"], [...cores, ["custom", speak("core.ball")], ["capsule", speak("core.capsule")]], isCapsule ? "capsule" : builder.core, (name) => {
        const known = this.begin.cores.find((core) => core.name === builder.core) ?? { radius: builder.core_radius, mass: builder.core_mass };
        this.awaitsCapsule = name === "capsule";
        // An own core begins as the one before it.
        if (name === "custom") setCore({ core: name, core_radius: known.radius, core_mass: Number(known.mass.toPrecision(4)) });
        else if (!this.awaitsCapsule) setCore({ core: name });
        this.renew();
      }, { keys: "builder.core builder", wide: true, title: speak("core.help") }),
      ...own,
      makeSelect(LABELS["builder.material"], [...Object.entries(this.begin.materials).map(([name, density]) => [name, speak("material.of", { name, density })]), ["custom", speak("material.other")]], builder.material, (name) => {
        design.set("builder", "material", name);
        design.set("builder", "hull_density", name === "custom" ? builder.hull_density : null);
        this.renew();
      }, { keys: "builder.material", wide: true }),
      ...(builder.material === "custom" ? [number(LABELS["builder.hull_density"], "hull_density", builder.hull_density, 1, { low: 100, high: 10000 }, "kg/m³", speak("material.density.help"))] : []),
      number(LABELS["builder.wall"], "wall", builder.wall, 1000, { low: 0.4, high: 50 }, "mm", speak("builder.wall.help")),
      ...(builder.tuning === "none" ? [] : [makeSelect(LABELS["builder.ballast"], Object.entries(listMessages("ballast.")), ballast.material, (material) => set("ballast", { ...ballast, material }), { keys: "builder.ballast.material builder.ballast", wide: true, title: speak("builder.ballast.help") })]),
      makeSelect(LABELS["builder.kit"], [["usual", speak("printer.usual")], ...Object.entries(printers).map(([name, size]) => [name, speak("printer.of", { name, size: size.map((v) => millimetres(v)).join(" x ") })]), ["Own", speak("printer.own")]], printer, (name) => {
        this.isOwnPrinter = name === "Own";
        setBed(name === "usual" ? USUAL_BED : printers[name] ?? [0.3, 0.3, 0.3]);
        this.renew();
      }, { keys: "builder.kit.bed builder.kit", wide: true, title: speak("printer.help") }),
      ...(canForget(printer) ? [make("button", { type: "button", class: "quiet", onclick: () => { forgetPrinter(printer); this.renew(); } }, speak("printer.forget"))] : []),
      ...(printer === "Own" ? [...["width", "depth", "height"].map((side, i) => makeNumber(speak(`printer.${side}`), millimetres(bed[i]), (v) => setBed((design.value("builder", "kit")?.bed ?? bed).map((size, k) => (k === i ? v / 1000 : size))), { unit: "mm", bounds: { low: 10, high: 5000 }, keys: `builder.kit.bed[${i}]` })), this.makeKeeper()] : []),
      makeNumber(LABELS["builder.kit.nozzle"], millimetres(kit.nozzle ?? 0.0004), (v) => setKit("nozzle", v / 1000), { unit: "mm", bounds: { above: 0, high: 5 }, keys: "builder.kit.nozzle" }),
    );
  }

  // A name for the own printer, under which this browser keeps its bed.
  makeKeeper() {
    let name = "";
    const field = makeText(speak("printer.name"), name, (text) => { name = text; }, { keys: "printer.name", largest: 40 });
    const keep = () => {
      const { bed } = this.design.value("builder", "kit");
      sayFault(field.querySelector("input"), "own", ...(name.trim() ? [] : [speak("printer.nameless")]));
      if (!name.trim()) return;
      keepPrinter(name.trim(), bed);
      this.isOwnPrinter = false;
      this.renew();
    };
    return make("div", { class: "wide keeper" }, field, make("button", { type: "button", onclick: keep }, speak("printer.keep")));
  }

  showSearch() {
    const { design } = this;
    const simulator = design.value("simulator", "use");
    const simulators = [...new Set([...Object.keys(listMessages("simulator.")), simulator])].map((name) => [name, has(`simulator.${name}`) ? speak(`simulator.${name}`) : name]);
    const count = (label, table, key, options) => makeNumber(label, design.changes[table]?.[key] ?? (table === "run" ? undefined : design.value(table, key)), (v) => { design.set(table, key, v); this.changed(); }, { keys: `${table}.${key} ${table}`, whole: true, ...options });
    const within = design.value("robustness", "within");
    this.flights = count(LABELS["run.evaluations"], "run", "evaluations", { placeholder: speak("search.usual"), bounds: { low: 1, high: 1e7 } });
    find("search-fields").replaceChildren(
      makeText(LABELS.title, design.title, (text) => { design.rename(text); this.changed(); }, { keys: "title", wide: true }),
      this.flights,
      count(LABELS["robustness.conditions"], "robustness", "conditions", { bounds: { low: 0, high: 10000 }, title: speak("search.disturbed.help") }),
      ...(within === null || within === undefined || typeof within === "number" ? [makeNumber(LABELS["robustness.within"], within, (v) => { design.set("robustness", "within", v); this.changed(); }, { unit: "m", keys: "robustness.within", bounds: { above: 0, high: 1000 }, placeholder: speak("search.near"), title: speak("search.near.help") })] : []),
      ...makeMore([
        makeSelect(LABELS["simulator.use"], simulators, simulator, (use) => { design.set("simulator", "use", use); this.changed(true); }, { keys: "simulator.use simulator", wide: true }),
        count(LABELS["run.seed"], "run", "seed", { placeholder: speak("search.drawn"), bounds: { low: 0, high: 2 ** 53 } }),
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
