// The targets of a design, and its release: each a place in the pipe by name, coordinates, or an outlet.
import { makeNumber, makeSelect, makeText, recall, remember, sayFault } from "./controls.js";
import { same } from "./design.js";
import { speak } from "./messages.js";
import { describePlace, placeOfPoint, pointFromInlet, pointOfPlace } from "./places.js";
import { find, make, round } from "./parts.js";

const isPlace = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

export class Targets {
  constructor(fields) {
    this.fields = fields;
    this.axes = []; // of the pipe, as the server has laid it
    this.outlets = new Map(); // places of targets that are outlets
  }

  get design() { return this.fields.design; }

  get list() { return Object.entries(this.design.targets); }

  set(targets) { this.design.setTargets(targets); this.fields.changed(); }

  // The point of a target; null while it is unknown.
  pointOf(name) {
    const target = this.design.targets[name];
    if (typeof target === "string") return this.outlets.get(name) ?? null;
    return isPlace(target) ? pointOfPlace(this.axes, target) : target;
  }

  // The targets that have a place, as the side view draws them.
  listPlaces() {
    return this.list.map(([name]) => ({ name, position: this.pointOf(name) })).filter(({ position }) => position?.every((v) => Number.isFinite(v)));
  }

  describe(name) {
    const target = this.design.targets[name];
    if (typeof target === "string") return speak("target.outlet", { outlet: target });
    const place = isPlace(target) ? target : placeOfPoint(this.axes, target);
    return place ? describePlace(place) : `x ${target[0]}, y ${target[1]}, z ${target[2]} m`;
  }

  // Whether there is a target; asks for one if there is none.
  askForOne() {
    const isEmpty = this.list.length === 0;
    sayFault(find("targets-error"), "own", ...(isEmpty ? [speak("target.missing")] : []));
    return !isEmpty;
  }

  // Shows a row for each target; only what changed is made anew, so that a field keeps its cursor.
  show(anew = false) {
    const box = find("targets");
    const rows = [...box.querySelectorAll(".target")];
    const kind = ([name, target]) => [name, typeof target === "string" ? target : isPlace(target) ? "place" : "point"];
    const parts = [...new Set(this.axes.map(({ part }) => part))].join();
    if (anew || !same(rows.map((row) => [row.dataset.name, row.dataset.kind]), this.list.map(kind)) || box.dataset.parts !== parts) {
      const before = remember();
      box.dataset.parts = parts;
      box.replaceChildren(...this.list.map((entry, number) => this.makeRow(...kind(entry), number)));
      recall(before);
    }
    if (this.list.length) this.askForOne();
    for (const row of box.querySelectorAll(".target")) {
      const { name } = row.dataset;
      row.dataset.point = this.pointOf(name)?.map((v) => round(v, 1e-4)).join(",") ?? "";
      row.querySelector(".where").textContent = this.describe(name);
      for (const input of row.querySelectorAll("input[data-option]")) input.show(this.design.targets[name]?.[input.dataset.option] ?? "");
    }
  }

  makeRow(name, kind, number) {
    const dot = make("i", { class: "dot" });
    dot.style.background = `var(--s${number % 10})`;
    const title = makeText(speak("target.name"), name, (fresh) => this.rename(name, fresh), {
      keys: `targets.${name}.name`, named: speak("target.name.of", { name }), largest: 60, late: true,
      isFaulty: (text) => (!text ? speak("target.nameless") : text !== name && text in this.design.targets ? speak("target.taken") : ""),
    });
    title.querySelector("label").className = "seen-by-none";
    const where = make("span", { class: "where" });
    const row = make("div", { class: "target", "data-name": name, "data-kind": kind, "data-errors": `targets.${name}` }, dot, title,
      make("button", { type: "button", class: "square", "aria-label": speak("remove", { name }), onclick: () => this.remove(name) }, "×"));
    if (kind !== "place" && kind !== "point") { row.append(make("p", { class: "note" }, where)); return row; }
    const set = (value) => { this.set({ ...this.design.targets, [name]: value }); this.show(); };
    row.append(make("details", { id: `place-${name}` }, make("summary", {}, where), make("div", { class: kind === "place" ? "fields" : "fields three" }, ...(kind === "place"
      ? this.makePlace(() => this.design.targets[name], set, `targets.${name}`, name)
      : ["x", "y", "z"].map((axis, i) => this.tag(makeNumber(axis, this.design.targets[name][i], (v) => { const point = [...this.design.targets[name]]; point[i] = v; set(point); }, { unit: "m", keys: `targets.${name}.${axis}`, named: speak("target.axis.of", { axis, name }), bounds: { low: -1e5, high: 1e5 } }), i)))),
    this.makeTurn(name, kind, set)));
    return row;
  }

  // Between coordinates and a place by name.
  makeTurn(name, kind, set) {
    const turn = () => {
      const point = this.pointOf(name);
      const found = kind === "place" ? point : point && placeOfPoint(this.axes, point);
      if (found) set(kind === "place" ? found.map((v) => round(v, 1e-4)) : found);
    };
    return make("button", { type: "button", class: "link", onclick: turn }, speak(kind === "place" ? "target.coordinates" : "target.place"));
  }

  tag(field, option) { field.querySelector("input").dataset.option = option; return field; }

  // The fields of a place that `get` returns; `set` keeps another one.
  makePlace(get, set, key, of) {
    const names = [...new Set(this.axes.map(({ part }) => part))];
    const { part, branch } = get();
    const choices = [...new Set([...names, part])].flatMap((name) => [[name, name], ...(this.axes.some((a) => a.part === name && a.branch) ? [[`${name}\n`, speak("place.in.branch", { part: name })]] : [])]);
    const number = (label, option, unit, bounds, more = {}) => this.tag(makeNumber(label, get()[option], (v) => {
      const { [option]: _, ...rest } = get();
      set(v === null ? rest : { ...rest, [option]: v });
    }, { unit, bounds, keys: `${key}.${option}`, named: speak("field.of", { label, name: of }), ...more }), option);
    return [
      makeSelect(speak("place.part"), choices, branch ? `${part}\n` : part, (word) => {
        const { branch: _, ...rest } = get();
        set({ ...rest, part: word.trim(), ...(word.endsWith("\n") ? { branch: true } : {}) });
      }, { keys: `${key}.part`, named: speak("field.of", { label: speak("place.part"), name: of }) }),
      number(speak("place.at.way"), "at", "m", { low: 0, high: 1e5 }),
      number(speak("place.hour"), "clock", "h", { low: 0, high: 12 }, { placeholder: "12" }),
      number(speak("place.gap"), "off_wall", "m", { low: 0, high: 100 }, { placeholder: speak("place.onaxis") }),
    ];
  }

  get releasePlace() {
    const value = this.design.value("release", "position");
    if (isPlace(value)) return value;
    const point = this.design.value("release", "frame") === "world" ? value : pointFromInlet(this.axes, value);
    return placeOfPoint(this.axes, point) ?? { part: this.axes[0].part, at: 0 };
  }

  // The fields of the release, which is a place as targets are.
  makeRelease() {
    if (!this.axes.length) return [];
    const set = (place) => { this.design.set("release", "position", place); this.showRelease(); this.fields.changed(); };
    return [make("p", { class: "hint wide", id: "release-place" }), ...this.makePlace(() => this.releasePlace, set, "release.position", speak("release.the"))];
  }

  showRelease() {
    if (!this.axes.length) return;
    const place = this.releasePlace;
    if (find("release-place")) find("release-place").textContent = speak("release.place", { place: describePlace(place) });
    for (const input of document.querySelectorAll("#release-fields input[data-option]")) input.show(place[input.dataset.option] ?? "");
  }

  // What the laid pipe offers: its parts, the places of targets that are outlets, and a button for each outlet.
  showPipe({ axes, outlets, targets }) {
    const partsOf = (list) => list.map(({ part, branch }) => [part, branch]);
    const isOther = !same(partsOf(this.axes), partsOf(axes)) || !find("release-place");
    this.axes = axes;
    this.outlets = new Map(targets.map(({ name, position }) => [name, position.map((v) => round(v, 1e-4))]));
    const names = outlets.map((name) => name || "outlet");
    const box = find("outlets");
    if (!same([...box.children].map((button) => button.dataset.outlet), names)) box.replaceChildren(...names.map((name) => make("button", {
      type: "button", "data-outlet": name, onclick: () => this.placeOutlet(name),
    }, names.length > 1 ? speak("target.outlet.add", { name }) : speak("target.outlet.only"))));
    if (isOther) { const state = remember(); this.fields.showRelease(); recall(state); }
    this.showRelease();
    this.show();
  }

  placeOutlet(outlet) {
    const stem = outlet.replace(/[^\p{L}\p{N}_-]+/gu, "-").replace(/^outlet-?/, "") || "out";
    let name = stem.length < 3 && stem !== "out" ? `outlet-${stem}` : stem;
    for (let number = 2; name in this.design.targets; number++) name = `${stem}-${number}`;
    this.set({ ...this.design.targets, [name]: outlet });
    this.show();
  }

  // Adds a target at a point, and returns its name.
  place(point) {
    let number = this.list.length + 1;
    while (`T${number}` in this.design.targets) number++;
    this.set({ ...this.design.targets, [`T${number}`]: placeOfPoint(this.axes, point) ?? point });
    this.show();
    return `T${number}`;
  }

  move(name, point) {
    const place = Array.isArray(this.design.targets[name]) ? null : placeOfPoint(this.axes, point);
    this.set({ ...this.design.targets, [name]: place ?? point });
    this.show();
  }

  remove(name) {
    const { [name]: _, ...rest } = this.design.targets;
    this.set(rest);
    this.show();
  }

  rename(name, fresh) {
    if (fresh === name) return;
    this.set(Object.fromEntries(this.list.map(([key, target]) => [key === name ? fresh : key, target])));
    this.show();
  }

  // What can be done at once about an error of a target.
  offerRemedy(line, key) {
    const name = key.replace(/^targets\./, "");
    const target = this.design.targets[name];
    const nearest = line.match(/nearest point inside is \[([^\]]*)\]/)?.[1].split(",").map(Number);
    const end = line.match(/which is ([\d.e+-]+) m long/)?.[1];
    if (target === undefined || !(nearest || (end && isPlace(target)))) return [];
    const act = () => { if (nearest) this.move(name, nearest); else { this.set({ ...this.design.targets, [name]: { ...target, at: Number(end) } }); this.show(); } };
    return [" ", make("button", { type: "button", class: "link", onclick: act }, speak(nearest ? "target.move.there" : "target.move.end"))];
  }
}
