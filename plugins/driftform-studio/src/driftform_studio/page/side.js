// The pipe from the side, to scale: where targets are placed, flights are drawn, and agents are picked.
/* global poseMatrix, momentOf, moveOffWall */
import { speak } from "./messages.js";
import { clamp, colour, draw, length, round } from "./parts.js";

const REACH = 11; // px within which a target snaps
const EMPTY = { axes: [], openings: [], targets: [], release: [0, 0, 0], current: [1, 0, 0], water: null };

const sub = (a, b) => a.map((v, i) => v - b[i]);
const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
const plus = (a, b, f = 1) => a.map((v, i) => v + f * b[i]);

export class Side {
  constructor(svg, acts) {
    this.svg = svg;
    this.acts = acts; // place(point), move(name, point), remove(name), describe(name), pick(point), choose(name), say(text)
    this.outline = EMPTY;
    this.bores = []; // the axes of the parts of the pipe in the plane of the view, with both edges
    this.flights = new Map(); // of targets: {path, number}
    this.mode = "look"; // "edit", "pick" or "look"
    this.chosen = this.reach = this.flown = this.profile = null; // chosen: a target, or "" for a picked agent
    this.view = null;
    this.listen();
    this.fromAbove = false;
    this.width = 0;
    new ResizeObserver(() => { if (Math.abs(svg.clientWidth - this.width) > 1) this.fit(); }).observe(svg);
  }

  // The horizontal direction of the inlet runs to the right; z upward from the side, and what lies on the left hand from above.
  get right() {
    const [dx, dy] = this.outline.current;
    const level = Math.hypot(dx, dy);
    return level > 1e-9 ? [dx / level, dy / level, 0] : [1, 0, 0];
  }

  get up() {
    const [x, y] = this.right;
    return this.fromAbove ? [-y, x, 0] : [0, 0, 1];
  }

  flat(point) { return [dot(point, this.right), dot(point, this.up)]; }

  // How far a point is from the plane of the view.
  depth([x, y, z]) {
    const [right, up] = [this.right, this.up];
    return x * (right[1] * up[2] - right[2] * up[1]) + y * (right[2] * up[0] - right[0] * up[2]) + z * (right[0] * up[1] - right[1] * up[0]);
  }

  // Looks from the side, or from above.
  turn(fromAbove) {
    if (fromAbove === this.fromAbove) return;
    this.fromAbove = fromAbove;
    this.svg.setAttribute("aria-label", speak(fromAbove ? "above.picture" : "side.picture"));
    this.bores = this.outline.axes.map((axis) => this.flatten(axis));
    this.fit();
  }

  // Whether the view from the side does not show all of the pipe.
  get isSpatial() {
    const [x, y] = this.right;
    const beside = this.outline.axes.flatMap(({ points }) => points.map((p) => p[0] * y - p[1] * x));
    return Math.max(...beside) - Math.min(...beside) > 1e-6;
  }

  // The point of the world that is seen at a point, as deep as another point.
  world([across, up], depth) {
    const found = plus(depth, this.right, across - dot(depth, this.right));
    return plus(found, this.up, up - dot(found, this.up)).map((v) => round(v, 1e-4));
  }

  get box() {
    const points = this.bores.flatMap(({ edges }) => edges.flat());
    if (!points.length) {
      points.push(this.flat(this.outline.release), ...this.outline.targets.map((t) => this.flat(t.position)));
      for (const { path } of this.flights.values()) points.push(...path.map((p) => this.flat(p)));
      points.push(plus(points[0], [1, 1]), plus(points[0], [-1, -1]));
    }
    const [xs, ys] = [0, 1].map((i) => points.map((p) => p[i]));
    return [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  }

  fit() {
    const [x0, x1, y0, y1] = this.box;
    this.width = this.svg.clientWidth;
    if (!this.width) return;
    const [left, right, top, bottom] = this.width < 480 ? [36, 12, 26, 34] : [46, 22, 26, 34];
    const tallest = Math.max(220, 0.5 * window.innerHeight);
    this.home = Math.min((this.width - left - right) / (x1 - x0), (tallest - top - bottom) / (y1 - y0));
    this.height = clamp(this.home * (y1 - y0) + top + bottom, 190, tallest);
    this.view = {
      scale: this.home,
      x: (x0 + x1) / 2 - (left - right) / 2 / this.home,
      y: (y0 + y1) / 2 - (bottom - top) / 2 / this.home,
    };
    this.svg.style.height = `${this.height}px`;
    this.draw();
  }

  zoom(factor, at = null) {
    if (!this.view) return;
    const before = at && this.point(at);
    this.view.scale = clamp(this.view.scale * factor, 0.5 * this.home, 400 * this.home);
    if (before) {
      const after = this.point(at);
      this.view.x += before[0] - after[0];
      this.view.y += before[1] - after[1];
    }
    this.draw();
  }

  screen([x, y]) {
    const { scale, x: cx, y: cy } = this.view;
    return [this.width / 2 + (x - cx) * scale, this.height / 2 - (y - cy) * scale];
  }

  point([px, py]) {
    const { scale, x, y } = this.view;
    return [x + (px - this.width / 2) / scale, y - (py - this.height / 2) / scale];
  }

  line(points, close = false) {
    return "M" + points.map((p) => this.screen(p).map((v) => v.toFixed(1)).join(" ")).join("L") + (close ? "Z" : "");
  }

  show(outline) {
    const before = JSON.stringify(this.outline.axes);
    this.outline = outline ?? EMPTY;
    this.bores = this.outline.axes.map((axis) => this.flatten(axis));
    if (!this.view || JSON.stringify(this.outline.axes) !== before) this.fit();
    else this.draw();
  }

  // Draws targets where they are now; the server, which checks them, answers a moment later.
  showTargets(targets) {
    if (JSON.stringify(targets) === JSON.stringify(this.outline.targets)) return;
    // What the hint says of a target may be no longer so.
    this.acts.say("");
    this.outline = { ...this.outline, targets };
    this.draw();
  }

  draw() {
    if (!this.view) return;
    const held = document.activeElement?.closest?.(".mark")?.dataset.name;
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
    this.svg.setAttribute("class", `${this.mode} ${this.reach ? "mapped" : ""} ${this.view.scale > 1.05 * this.home ? "zoomed" : ""}`);
    this.svg.replaceChildren(
      this.hatch(), ...this.drawWalls(), ...this.drawBore(), ...this.drawReach(), ...this.drawOpenings(), ...this.drawAxes(), ...this.drawCurrent(),
      ...this.drawFlights(), ...this.drawRelease(), ...this.drawTargets(),
    );
    if (this.mode === "edit" && !this.outline.targets.length && this.bores.length) this.svg.append(this.drawInvitation());
    this.moving = this.svg.appendChild(draw("g"));
    this.drawBody();
    if (held) this.focus(held);
  }

  focus(name) {
    for (const mark of this.svg.querySelectorAll(".mark")) if (mark.dataset.name === name) mark.focus({ preventScroll: true });
  }

  // An axis as it is seen: its points, and the edges of the bore at right angles to it. One that leads into the depth is seen as
  // the balls that roll through it.
  flatten({ points, radii }) {
    const [depth, ...others] = points.map((p) => this.depth(p));
    const isDeep = others.some((v) => Math.abs(v - depth) > 1e-6);
    const middle = points.map((p) => this.flat(p));
    const direction = (a, b) => { const size = Math.hypot(...sub(b, a)) || 1e-9; return sub(b, a).map((v) => v / size); };
    const last = middle.length - 1;
    const directions = middle.map((_, i) => direction(middle[Math.max(0, i - 1)], middle[Math.min(last, i + 1)]));
    // The chord at an end of a bend leads half a step beside its axis.
    if (last > 1) for (const [end, next] of [[0, 1], [last, last - 1]]) directions[end] = sub(plus(directions[end], directions[end]), directions[next]);
    const normals = directions.map(([x, y]) => { const size = Math.hypot(x, y) || 1e-9; return [-y / size, x / size]; });
    return { points, radii, middle, isDeep, edges: [1, -1].map((side) => middle.map((p, i) => plus(p, normals[i], side * radii[i]))) };
  }

  hatch() {
    return draw("defs", {}, draw("pattern", { id: "hatch", width: 7, height: 7, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
      draw("line", { x1: 0, y1: 0, x2: 0, y2: 7, stroke: "var(--frame)", "stroke-width": 1, opacity: 0.6 })));
  }

  // The bores cover the inner half of the walls, also where one part leads into another.
  drawWalls() { return this.drawBores("wall", 7); }

  drawBore() { return this.drawBores("bore", 0); }

  drawBores(kind, more) {
    return this.bores.flatMap(({ isDeep, middle, radii, edges: [upper, lower] }) => isDeep
      ? middle.slice(1).map((p, i) => draw("path", { class: `${kind} deep`, d: this.line([middle[i], p]), "stroke-width": (radii[i] + radii[i + 1]) * this.view.scale + more }))
      : [draw("path", { class: kind, d: this.line([...upper, ...[...lower].reverse()], true) })]);
  }

  drawOpenings() {
    const shapes = this.bores.map(({ middle }) => draw("path", { class: "axis", d: this.line(middle) }));
    for (const { centre, direction, radius } of this.outline.openings) {
      // Water comes and goes here: no wall.
      const [c, along] = [this.flat(centre), this.flat(direction)];
      const size = Math.hypot(...along);
      if (size < 1e-6) continue;
      const across = [-along[1] / size, along[0] / size];
      const outward = plus(c, along, 2.5 / this.view.scale / size);
      const ends = [1, -1].map((side) => plus(c, across, side * radius));
      shapes.push(
        draw("path", { class: "gap", d: this.line([1, -1].map((side) => plus(outward, across, side * radius))) }),
        draw("path", { class: "end", d: this.line(ends) }),
      );
    }
    const { water } = this.outline;
    if (water !== null && this.bores.length && !this.fromAbove) {
      const [x0, x1] = this.box;
      shapes.push(draw("path", { class: "surface", d: this.line([[x0, water], [x1, water]]) }));
    }
    return shapes;
  }

  drawAxes() {
    const [x0, x1, y0, y1] = this.box;
    const step = (least) => [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].find((s) => s * this.view.scale >= least) ?? 2000;
    const shapes = [];
    const [dx, dy] = [step(64), step(34)];
    const bottom = this.screen([0, y0])[1] + 6;
    for (let i = Math.ceil(x0 / dx - 1e-6); i * dx <= x1 + 1e-6; i++) {
      const x = this.screen([i * dx, 0])[0];
      if (x < 4 || x > this.width - 4) continue;
      shapes.push(draw("line", { class: "tick", x1: x, x2: x, y1: bottom, y2: bottom + 5 }),
        draw("text", { x, y: bottom + 18, "text-anchor": "middle" }, `${round(i * dx, 1e-3)}${(i + 1) * dx > x1 + 1e-6 ? " m" : ""}`));
    }
    const left = Math.max(30, this.screen([x0, 0])[0] - 6);
    for (let i = Math.ceil(y0 / dy - 1e-6); i * dy <= y1 + 1e-6; i++) {
      const y = this.screen([0, i * dy])[1];
      if (y < 4 || y > this.height - 4) continue;
      shapes.push(draw("line", { class: "tick", x1: left - 5, x2: left, y1: y, y2: y }),
        draw("text", { x: left - 8, y: y + 4, "text-anchor": "end" }, `${round(i * dy, 1e-3)}`.replace("-", "−")));
    }
    return shapes;
  }

  // The profile of the current at the inlet: an arrow is as long as the water goes there in a moment.
  drawCurrent() {
    const inlet = this.outline.openings[0];
    if (!inlet || !this.profile?.length || this.reach) return [];
    // The inlet's opening looks outward.
    const [a, along] = [this.flat(inlet.centre), this.flat(inlet.direction).map((v) => -v)];
    if (Math.hypot(...along) < 1e-6) return [];
    const across = [-along[1], along[0]];
    const { radius } = inlet;
    const [x0, x1, y0, y1] = this.box;
    const size = Math.max(x1 - x0, y1 - y0);
    const fastest = Math.max(...this.profile.map(Math.abs)) || 1;
    const longest = Math.min(0.11 * size, 1.1 * radius);
    const head = 5 / this.view.scale;
    const rows = radius * this.view.scale > 46 ? [-0.95, -0.8, -0.6, -0.4, -0.2, 0, 0.2, 0.4, 0.6, 0.8, 0.95] : [-0.8, -0.4, 0, 0.4, 0.8];
    const speed = (share) => {
      const place = Math.abs(share) * (this.profile.length - 1);
      const cell = Math.min(this.profile.length - 2, Math.floor(place));
      return this.profile[cell] + (place - cell) * (this.profile[cell + 1] - this.profile[cell]);
    };
    const tips = rows.map((share) => plus(plus(a, across, share * radius), along, (longest * speed(share)) / fastest));
    const shafts = rows.map((share, i) => this.line([plus(a, across, share * radius), plus(tips[i], along, -head)])).join("");
    const heads = tips.map((tip) => {
      const back = plus(tip, along, -1.6 * head);
      return this.line([tip, plus(back, across, 0.7 * head), plus(back, across, -0.7 * head)], true);
    }).join("");
    const [x, y] = this.screen(plus(plus(a, across, radius), along, 0.02 * size));
    const mean = Math.hypot(...this.outline.current);
    return [
      draw("path", { class: "current", d: shafts }), draw("path", { class: "current tip", d: heads }),
      draw("text", { class: "speed", x, y: y - 8 }, `${Number(mean.toPrecision(3))} m/s`),
    ];
  }

  drawInvitation() {
    const [x0, x1, y0, y1] = this.box;
    const [x, y] = this.screen([0.45 * x0 + 0.55 * x1, (y0 + y1) / 2]);
    return draw("text", { class: "invite", x, y: y - 12, "text-anchor": "middle" }, speak("side.invite"));
  }

  drawRelease() {
    const [cx, cy] = this.screen(this.flat(this.outline.release));
    return [draw("circle", { class: "release", cx, cy, r: 5 }, draw("title", {}, speak("release")))];
  }

  drawFlights() {
    return [...this.flights].map(([name, { path, number }]) => draw("path", {
      class: `flight ${(this.chosen ?? (this.reach ? "" : name)) === name ? "" : "dim"} ${this.chosen === name ? "own" : ""}`,
      d: this.line(path.map((p) => this.flat(p))), stroke: colour(number),
    }));
  }

  // Each name is at the first corner of its cross where it covers no other name or cross, px.
  drawTargets() {
    const { targets } = this.outline;
    const crosses = targets.map(({ position }) => this.screen(this.flat(position)));
    const taken = crosses.map(([x, y]) => [x - 7, y - 7, x + 7, y + 7]);
    return targets.map((target, number) => {
      const [x, y] = crosses[number], wide = 8 * target.name.length + 4;
      const corners = [[12, -7], [-12, -7], [12, 16], [-12, 16]].map(([dx, dy]) => {
        const left = x + dx - (dx < 0 ? wide : 0);
        return { dx, dy, box: [left, y + dy - 11, left + wide, y + dy + 3] };
      }).filter(({ box }) => box[0] > 0 && box[1] > 0 && box[2] < this.width && box[3] < this.height);
      const free = corners.find(({ box: [a, b, c, d] }) => taken.every(([e, f, g, h], i) => i === number || c < e || a > g || d < f || b > h));
      const corner = free ?? corners[0] ?? { dx: 12, dy: -7 };
      if (corner.box) taken.push(corner.box);
      return this.drawTarget(target, number, crosses[number], corner);
    });
  }

  drawTarget({ name, position }, number, [x, y], { dx, dy }) {
    const edit = this.mode === "edit";
    const cross = "M-6 -6L6 6M-6 6L6 -6";
    const where = edit ? this.acts.describe(name) : `x ${position[0].toFixed(2)} m, y ${position[1].toFixed(2)} m, z ${position[2].toFixed(2)} m`.replaceAll("-", "−");
    return draw("g", {
      class: "mark", transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})`, tabindex: 0, role: "button", "data-name": name,
      "aria-label": speak("side.target", { name, where }) + (edit ? speak("side.keys") : ""),
    },
      draw("circle", { class: "hit", r: 16 }), draw("circle", { class: "ring", r: 13 }),
      draw("path", { class: "halo", d: cross }), draw("path", { d: cross, stroke: colour(number) }),
      draw("text", { x: dx, y: dy, "text-anchor": dx < 0 ? "end" : "start" }, name));
  }

  // The cells of the map where they lie in the pipe; equal neighbours along it are one shape.
  drawReach() {
    if (!this.reach || this.fromAbove) return [];
    const { edges, columns, rows, classes, colours } = this.reach;
    const places = edges.map((column) => column?.map((edge) => edge.map((p) => this.flat(p))));
    const corner = (c, side, r) => {
      const [low, high] = places[c][side];
      return plus(low, sub(high, low), r / rows);
    };
    // Where the bore bends, every column of a shape has its own corners; a straight shape has four.
    const bent = !this.outline.pipe.length;
    const row = (c, end, r) => [corner(c, 0, r), ...(bent ? Array.from({ length: end - c }, (_, i) => corner(c + i, 1, r)) : [corner(end - 1, 1, r)])];
    const meet = (c) => Math.hypot(...sub(corner(c, 0, 0), corner(c - 1, 1, 0))) < 1e-3;
    const paths = new Map();
    for (let r = 0; r < rows; r++)
      for (let c = 0, end; c < columns; c = end) {
        const kind = classes[c * rows + r];
        for (end = c + 1; end < columns && classes[end * rows + r] === kind && (kind < -1 || meet(end)); end++);
        if (kind >= -1) paths.set(kind, (paths.get(kind) ?? "") + this.line([...row(c, end, r), ...row(c, end, r + 1).reverse()], true));
      }
    return [...paths].map(([kind, d]) => kind < 0 ? draw("path", { class: "hatched", d }) : draw("path", { class: "reached", d, fill: colours[kind], stroke: colours[kind], "stroke-width": 0.5 }));
  }

  // The agent of a flight at a time: its contour as seen from the side.
  drawBody() {
    if (!this.moving) return;
    this.moving.replaceChildren();
    if (!this.flown) return;
    const { agent, time, size, number } = this.flown;
    const { place, attitude } = momentOf(agent.flight, time);
    const drawn = size === 1 ? place : moveOffWall(agent.outer, attitude, place, size, this.outline.pipe);
    const pose = poseMatrix(attitude, drawn, size);
    const middle = agent.outer.map(([x]) => this.flat([0, 1, 2].map((i) => pose[i] * x + pose[12 + i])));
    const axis = this.flat([pose[0], pose[1], pose[2]]);
    const seen = Math.hypot(...axis) || 1e-9;
    const normal = [-axis[1] / seen, axis[0] / seen];
    const edge = (side) => agent.outer.map(([, r], i) => plus(middle[i], normal, side * r * size));
    this.moving.append(draw("path", { class: "body", d: this.line([...edge(1), ...edge(-1).reverse()], true), fill: colour(number) }));
  }

  // Where a target that is dragged to a point comes to lie, and what it has snapped to; null outside of the pipe.
  snap(flat) {
    const near = REACH / this.view.scale;
    const step = [0.001, 0.005, 0.01, 0.05, 0.1].findLast((s) => s * this.view.scale <= 4) ?? 0.001;
    let best = null;
    for (const { points, radii, middle } of this.bores)
      for (let i = 0; i + 1 < middle.length; i++) {
        const direction = sub(middle[i + 1], middle[i]);
        const size = Math.hypot(...direction);
        if (size < 1e-9) continue;
        const off = sub(flat, middle[i]);
        const share = clamp(dot(off, direction) / size ** 2, 0, 1);
        const foot = plus(middle[i], direction, share);
        const gap = Math.hypot(...sub(flat, foot));
        const radius = radii[i] + share * (radii[i + 1] - radii[i]);
        if (gap > radius + near || (best && gap - radius >= best.gap - best.radius)) continue;
        const depth = plus(points[i], sub(points[i + 1], points[i]), share);
        const normal = [-direction[1] / size, direction[0] / size];
        best = { gap, radius, foot, depth, normal, side: Math.sign(dot(sub(flat, foot), normal)) || 1, level: Math.abs(direction[1]) < 1e-9 && points.length === 2 };
      }
    if (!best) return null;
    const { radius, depth, normal, side, level } = best;
    let { foot, gap } = best;
    const words = [];
    // A wall that is not level is no round number: a millimetre inside is inside in any case.
    const wall = level ? radius : radius - 0.001;
    const outlet = this.outline.openings.slice(1).find(({ centre, radius: bore, direction }) => {
      const off = sub(flat, this.flat(centre));
      return Math.abs(dot(off, this.flat(direction))) < near && Math.hypot(...off) < bore + near;
    });
    if (gap > radius - near) { gap = wall; words.push(speak("snap.wall")); } else if (gap < near) { gap = 0; words.push(speak("snap.axis")); }
    if (outlet && Math.abs(dot(this.flat(outlet.direction), normal)) < 1e-6) {
      const direction = this.flat(outlet.direction);
      foot = plus(foot, direction, dot(sub(this.flat(outlet.centre), foot), direction) / dot(direction, direction));
      words.push(speak("snap.outlet"));
    } else if (level) foot = [clamp(round(foot[0], step), ...this.range(best)), foot[1]];
    let found = plus(foot, normal, side * gap);
    if (level && gap !== wall && gap !== 0) found = [found[0], clamp(round(found[1], step), foot[1] - wall, foot[1] + wall)];
    return { point: this.world(found, depth), words };
  }

  // From where to where a level part leads, of which a point is the foot.
  range({ foot }) {
    const { middle } = this.bores.find(({ middle: [a, b], points }) => points.length === 2 && Math.abs(a[1] - foot[1]) < 1e-9 && a[0] - 1e-9 <= foot[0] && foot[0] <= b[0] + 1e-9) ?? { middle: [[-Infinity], [Infinity]] };
    return [middle[0][0], middle[1][0]];
  }

  listen() {
    const { svg } = this;
    const where = (event) => {
      const box = svg.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    const fingers = new Map();
    let held = null;
    svg.addEventListener("pointerdown", (event) => {
      if (event.button || !this.view) return;
      fingers.set(event.pointerId, where(event));
      const mark = event.target.closest(".mark");
      held = { from: where(event), view: { ...this.view }, name: mark?.dataset.name ?? null, moved: false };
      svg.setPointerCapture(event.pointerId);
      if (mark) { event.preventDefault(); mark.focus({ preventScroll: true }); }
    });
    svg.addEventListener("pointermove", (event) => {
      if (!held || !fingers.has(event.pointerId)) return;
      const at = where(event);
      if (fingers.size === 2) {
        const spread = () => { const [a, b] = [...fingers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
        const before = spread();
        fingers.set(event.pointerId, at);
        held.moved = true;
        this.zoom(spread() / before, at);
        return;
      }
      fingers.set(event.pointerId, at);
      const [dx, dy] = sub(at, held.from);
      if (!held.moved && Math.hypot(dx, dy) < 4) return;
      held.moved = true;
      if (held.name && this.mode === "edit") {
        const found = this.snap(this.point(at));
        if (found) { this.acts.move(held.name, found.point); this.tell(held.name, found); }
      } else if (!held.name) {
        this.view.x = held.view.x - dx / this.view.scale;
        this.view.y = held.view.y + dy / this.view.scale;
        this.draw();
      }
    });
    const end = (event) => {
      fingers.delete(event.pointerId);
      if (!held || fingers.size) return;
      const { moved, name } = held;
      held = null;
      if (moved || event.type === "pointercancel") return;
      if (name) { this.acts.choose(name); return; }
      const found = this.snap(this.point(where(event)));
      if (!found) return;
      if (this.mode === "edit") this.acts.place(found.point);
      else if (this.mode === "pick") this.acts.pick(found.point.map((v) => round(v, 0.01)));
    };
    svg.addEventListener("pointerup", end);
    svg.addEventListener("pointercancel", end);
    svg.addEventListener("wheel", (event) => {
      // The wheel scrolls the page unless the picture has the focus.
      if (!event.ctrlKey && !svg.contains(document.activeElement)) return;
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * 0.0015), where(event));
    }, { passive: false });
    // Whoever comes by the keyboard is told what the keys do.
    svg.addEventListener("focus", () => { if (this.mode === "edit" && svg.matches(":focus-visible")) this.acts.say(speak("side.enter")); });
    svg.addEventListener("keydown", (event) => this.press(event));
  }

  tell(name, { point, words }) {
    const where = this.mode === "edit" ? this.acts.describe(name) : `${point.map((v) => v.toFixed(2)).join(", ")} m`;
    this.acts.say(`${name}: ${where}${words.length ? ` (${words.join(", ")})` : ""}`);
  }

  press(event) {
    const mark = event.target.closest(".mark");
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (mark && (event.key === "Enter" || event.key === " ")) { event.preventDefault(); this.acts.choose(mark.dataset.name); return; }
    if (mark && this.mode === "edit") {
      const { name } = mark.dataset;
      if (event.key === "Delete" || event.key === "Backspace") { event.preventDefault(); this.acts.remove(name); return; }
      if (arrow) {
        event.preventDefault();
        const { position } = this.outline.targets.find((t) => t.name === name);
        const step = event.shiftKey ? 0.1 : 0.01;
        const moved = plus(plus(position, this.right, step * arrow[0]), this.up, step * arrow[1]).map((v) => round(v, 1e-4));
        if (this.contains(moved)) { this.acts.move(name, moved); this.tell(name, { point: moved, words: [] }); }
        else this.acts.say(speak("side.here", { name }));
        return;
      }
    }
    if (mark) return;
    if (event.key === "Enter") { event.preventDefault(); this.actInMiddle(); return; }
    if (arrow) {
      event.preventDefault();
      this.view.x += (40 * arrow[0]) / this.view.scale;
      this.view.y += (40 * arrow[1]) / this.view.scale;
      this.draw();
    } else if (event.key === "+" || event.key === "=") this.zoom(1.25);
    else if (event.key === "-") this.zoom(0.8);
    else if (event.key === "Home") { event.preventDefault(); this.fit(); }
  }

  // What a click in the middle of the view does.
  actInMiddle() {
    const found = this.mode === "look" ? null : this.snap([this.view.x, this.view.y]);
    if (this.mode === "look") this.acts.say(speak("side.look"));
    else if (!found) this.acts.say(speak("side.outside"));
    else if (this.mode === "edit") this.acts.place(found.point);
    else this.acts.pick(found.point.map((v) => round(v, 0.01)));
  }

  // The middle of the longest axis, where a target may be.
  get middle() {
    const { axes } = this.outline;
    if (!axes.length) return [1, 0, 0];
    const span = ({ points }) => Math.hypot(...sub(points.at(-1), points[0]));
    const { points } = axes.reduce((a, b) => (span(b) > span(a) ? b : a));
    const [a, b] = points.length % 2 ? [points[(points.length - 1) / 2], points[(points.length - 1) / 2]] : [points[points.length / 2 - 1], points[points.length / 2]];
    return plus(a, sub(b, a), 0.5).map((v) => round(v, 1e-3));
  }

  contains(point) {
    return this.outline.axes.some(({ points, radii }) => points.slice(1).some((end, i) => {
      const direction = sub(end, points[i]);
      const size = Math.hypot(...direction);
      if (size < 1e-9) return false;
      const off = sub(point, points[i]);
      const along = dot(off, direction) / size;
      const radius = radii[i] + (along / size) * (radii[i + 1] - radii[i]);
      return along >= -1e-9 && along <= size + 1e-9 && Math.hypot(...plus(off, direction, -along / size)) <= radius + 1e-9;
    }));
  }

  // What the map's colours mean.
  legend() {
    const { colours, bounds, flights, reached, cells } = this.reach;
    const words = colours.map((c, i) => [c, i === 0 ? speak("map.below", { length: length(bounds[0]) }) : i < bounds.length ? speak("map.to", { length: length(bounds[i]) }) : speak("map.farther")]);
    return { words, text: speak("map.cells", { flights, reached, cells }) };
  }
}
