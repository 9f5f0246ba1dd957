"use strict";
// Draws a body of revolution and its flight with WebGL, without a library. World: x downstream, z up; lengths in m.

const ROUND = 48;

const shaders = {
  vertex: `
    attribute vec3 place, normal;
    uniform mat4 camera, pose;
    varying vec3 shown, facing, there;
    void main() {
      shown = place;
      facing = mat3(pose) * normal;
      there = (pose * vec4(place, 1.0)).xyz;
      gl_Position = camera * vec4(there, 1.0);
    }`,
  fragment: `
    precision mediump float;
    uniform vec4 colour;
    uniform vec3 eye;
    uniform float cut, lit;
    varying vec3 shown, facing, there;
    void main() {
      if (cut > 0.5 && shown.y < 0.0) discard;
      vec3 view = normalize(eye - there);
      vec3 n = normalize(facing);
      // Both sides of a wall are lit.
      if (dot(n, view) < 0.0) n = -n;
      float light = 0.55 + 0.45 * max(0.0, dot(n, normalize(view + vec3(0.0, 0.0, 1.2))))
        + 0.12 * pow(max(0.0, dot(n, view)), 8.0);
      gl_FragColor = vec4(mix(colour.rgb, min(vec3(1.0), colour.rgb * light), lit), colour.a);
    }`,
};

// Vectors and matrices; matrices are column-major, as in WebGL.
const sub = (a, b) => a.map((v, i) => v - b[i]);
const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
const scale = (a, f) => a.map((v) => v * f);
const unit = (a) => scale(a, 1 / (Math.hypot(...a) || 1));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

function product(a, b) {
  const c = new Array(16).fill(0);
  for (let i = 0; i < 4; i++)
    for (let j = 0; j < 4; j++) for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}

function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  const d = near - far;
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / d, -1, 0, 0, (2 * far * near) / d, 0];
}

function lookAt(eye, centre) {
  const back = unit(sub(eye, centre));
  const right = unit(cross([0, 0, 1], back));
  const up = cross(back, right);
  return [
    right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
    -dot(right, eye), -dot(up, eye), -dot(back, eye), 1,
  ];
}

// The pose of a body: rotated by the quaternion (w, x, y, z), body to world, magnified by size, moved to place.
function poseMatrix([w, x, y, z], place, size) {
  const s = size;
  return [
    s * (1 - 2 * (y * y + z * z)), s * 2 * (x * y + w * z), s * 2 * (x * z - w * y), 0,
    s * 2 * (x * y - w * z), s * (1 - 2 * (x * x + z * z)), s * 2 * (y * z + w * x), 0,
    s * 2 * (x * z + w * y), s * 2 * (y * z - w * x), s * (1 - 2 * (x * x + y * y)), 0,
    ...place, 1,
  ];
}

// Meshes: {places, normals} of triangles, or {places} of lines.
function revolve(profile, inward) {
  const places = [], normals = [];
  for (let i = 0; i + 1 < profile.length; i++) {
    const [[x0, r0], [x1, r1]] = [profile[i], profile[i + 1]];
    const slant = Math.hypot(x1 - x0, r1 - r0);
    if (slant < 1e-9) continue;
    const [nx, nr] = [-(r1 - r0) / slant, (x1 - x0) / slant];
    for (let k = 0; k < ROUND; k++) {
      const corner = (j) => [Math.cos((2 * Math.PI * j) / ROUND), Math.sin((2 * Math.PI * j) / ROUND)];
      const [[c0, s0], [c1, s1]] = [corner(k), corner(k + 1)];
      const at = (x, r, c, s) => [x, r * c, r * s];
      const out = (c, s) => scale([nx, nr * c, nr * s], inward ? -1 : 1);
      const quad = [
        [at(x0, r0, c0, s0), out(c0, s0)], [at(x1, r1, c0, s0), out(c0, s0)], [at(x1, r1, c1, s1), out(c1, s1)],
        [at(x0, r0, c0, s0), out(c0, s0)], [at(x1, r1, c1, s1), out(c1, s1)], [at(x0, r0, c1, s1), out(c1, s1)],
      ];
      for (const [p, n] of quad) { places.push(...p); normals.push(...n); }
    }
  }
  return { places, normals };
}

function radiusAt(profile, x) {
  for (let i = 0; i + 1 < profile.length; i++) {
    const [[x0, r0], [x1, r1]] = [profile[i], profile[i + 1]];
    if (x0 <= x && x <= x1 && x1 > x0) return r0 + ((r1 - r0) * (x - x0)) / (x1 - x0);
  }
  return 0;
}

// The section of the hull's material in the plane y = 0, above and below the axis.
function section(outer, cavity) {
  const nudge = 1e-7;
  const stations = [...new Set([...outer, ...cavity].flatMap(([x]) => [x - nudge, x + nudge]))].sort((a, b) => a - b);
  const places = [], normals = [];
  for (let i = 0; i + 1 < stations.length; i++) {
    const [x0, x1] = [stations[i], stations[i + 1]];
    const [a0, a1, b0, b1] = [radiusAt(outer, x0), radiusAt(outer, x1), radiusAt(cavity, x0), radiusAt(cavity, x1)];
    if (a0 <= 0 && a1 <= 0) continue;
    for (const side of [1, -1]) {
      const corners = [[x0, b0], [x1, b1], [x1, a1], [x0, b0], [x1, a1], [x0, a0]];
      for (const [x, r] of corners) { places.push(x, 0, side * r); normals.push(0, -1, 0); }
    }
  }
  return { places, normals };
}

const shapeOfCore = (core) => (typeof core === "number" ? ball(core) : revolve(core, false));

function ball(radius) {
  const half = [...Array(17)].map((_, i) => {
    const angle = Math.PI * (1 - i / 16);
    return [radius * Math.cos(angle), radius * Math.sin(angle)];
  });
  return revolve(half, false);
}

function rings(profile, stations) {
  const places = [];
  for (const x of stations) {
    const r = 1.001 * radiusAt(profile, x);
    for (let k = 0; k < ROUND; k++)
      for (const j of [k, k + 1]) {
        const angle = (2 * Math.PI * j) / ROUND;
        places.push(x, r * Math.cos(angle), r * Math.sin(angle));
      }
  }
  return { places };
}

// A tube along a path: WebGL lines have a fixed width.
function tube(path, radius) {
  const places = [], normals = [];
  const sides = 6;
  for (let i = 0; i + 1 < path.length; i++) {
    const along = unit(sub(path[i + 1], path[i]));
    const aside = unit(cross(along, Math.abs(along[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
    const other = cross(along, aside);
    const around = (k) => {
      const angle = (2 * Math.PI * k) / sides;
      return aside.map((v, j) => v * Math.cos(angle) + other[j] * Math.sin(angle));
    };
    for (let k = 0; k < sides; k++) {
      const [n0, n1] = [around(k), around(k + 1)];
      const corner = (p, n) => p.map((v, j) => v + radius * n[j]);
      const quad = [
        [path[i], n0], [path[i + 1], n0], [path[i + 1], n1], [path[i], n0], [path[i + 1], n1], [path[i], n1],
      ];
      for (const [p, n] of quad) { places.push(...corner(p, n)); normals.push(...n); }
    }
  }
  return { places, normals };
}

// The bore of a pipe as lines: rings, and straight lines along it.
function bore(segments) {
  const places = [];
  for (const { start, end, radius } of segments) {
    const axis = sub(end, start);
    const length = Math.hypot(...axis);
    const along = unit(axis);
    const aside = unit(cross(along, Math.abs(along[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
    const up = cross(aside, along);
    const at = (x, angle) =>
      start.map((v, j) => v + x * along[j] + radius * (Math.cos(angle) * aside[j] + Math.sin(angle) * up[j]));
    const count = Math.max(1, Math.round(length / radius));
    for (let i = 0; i <= count; i++)
      for (let k = 0; k < ROUND; k++)
        for (const j of [k, k + 1]) places.push(...at((length * i) / count, (2 * Math.PI * j) / ROUND));
    for (let k = 0; k < 8; k++) for (const x of [0, length]) places.push(...at(x, (2 * Math.PI * k) / 8));
  }
  return { places };
}

// Where a magnified body is drawn: at its place, moved off the wall as far as it would pierce it.
function moveOffWall(profile, attitude, place, size, segments) {
  let moved = place;
  for (let pass = 0; pass < 8; pass++) {
    const pose = poseMatrix(attitude, moved, size);
    let [deepest, push] = [1e-4, null];
    for (const { start, end, radius } of segments) {
      const axis = unit(sub(end, start));
      const length = Math.hypot(...sub(end, start));
      for (const [x, r] of profile)
        for (let k = 0; k < 16; k++) {
          const [y, z] = [r * Math.cos((Math.PI * k) / 8), r * Math.sin((Math.PI * k) / 8)];
          const off = [0, 1, 2].map((i) => pose[i] * x + pose[4 + i] * y + pose[8 + i] * z + pose[12 + i] - start[i]);
          const along = dot(off, axis);
          if (along < 0 || along > length) continue;
          const across = sub(off, scale(axis, along));
          const excess = Math.hypot(...across) - radius;
          if (excess > deepest) [deepest, push] = [excess, scale(unit(across), -excess)];
        }
    }
    if (!push) break;
    moved = moved.map((v, i) => v + push[i]);
  }
  return moved;
}

// The current as arrows that drift with it, as long as it is fast there: [places of lines at a time].
function drift(segments) {
  let seed = 1;
  // The same arrows in every browser: the generator of Park and Miller (1988).
  const random = () => (seed = (16807 * seed) % 2147483647) / 2147483647;
  const fastest = Math.max(...segments.flatMap(({ speeds }) => speeds.map(Math.abs)), 1e-9);
  const arrows = segments.flatMap(({ start, end, radius, speeds }) => {
    const length = Math.hypot(...sub(end, start));
    const axis = unit(sub(end, start));
    const aside = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
    const up = cross(aside, axis);
    return [...Array(Math.min(600, Math.max(60, Math.round((30 * length) / radius))))].map(() => {
      const share = 0.97 * Math.sqrt(random());
      const [cell, angle] = [Math.min(speeds.length - 2, Math.floor(share * (speeds.length - 1))), 2 * Math.PI * random()];
      const speed = speeds[cell] + (share * (speeds.length - 1) - cell) * (speeds[cell + 1] - speeds[cell]);
      const out = aside.map((v, i) => Math.cos(angle) * v + Math.sin(angle) * up[i]);
      const root = start.map((v, i) => v + share * radius * out[i]);
      return { root, axis, out, length, speed, shaft: (0.22 * radius * speed) / fastest, barb: 0.035 * radius, at: random() * length };
    });
  });
  return (time) => arrows.flatMap(({ root, axis, out, length, speed, shaft, barb, at }) => {
    const x = (((at + speed * time) % length) + length) % length;
    const point = (along, across) => root.map((v, i) => v + along * axis[i] + across * out[i]);
    const back = x - Math.sign(shaft) * barb;
    const tip = point(x, 0);
    return [...point(x - shaft, 0), ...tip, ...point(back, 0.5 * barb), ...tip, ...point(back, -0.5 * barb), ...tip];
  });
}

// The current in a pipe with parts as arrows that drift along paths of the water: [places of lines at a time]. A path is a list of
// [time, x, y, z]; arrows begin on it as often as water goes there, so that they are as dense everywhere.
function driftAlong(streams, radius) {
  const rate = (path) => Math.hypot(...[1, 2, 3].map((i) => path[1][i] - path[0][i])) / (path[1][0] - path[0][0]);
  const paths = streams.map((path) => ({ path, rate: rate(path), duration: path[path.length - 1][0] }));
  const fastest = Math.max(...paths.flatMap(({ path }) => path.slice(1).map((b, i) => Math.hypot(b[1] - path[i][1], b[2] - path[i][2], b[3] - path[i][3]) / (b[0] - path[i][0]))), 1e-9);
  const mean = paths.reduce((sum, { rate: r }) => sum + r, 0) / Math.max(1, paths.length);
  const total = paths.reduce((sum, { rate: r, duration }) => sum + (r * duration) / mean, 0);
  // One arrow for each half of a radius of the way of a path, but no more than a screen can draw in a moment.
  const apart = Math.max(radius / (2 * mean), total / 600);
  const arrows = paths.flatMap(({ path, rate: r, duration }, k) => {
    const every = (apart * mean) / Math.max(r, 1e-9);
    const count = Math.max(1, Math.round(duration / every));
    // The golden ratio spreads the beginnings of the paths over time.
    return [...Array(count)].map((_, n) => ({ path, duration, at: ((n + ((0.618 * k) % 1)) * duration) / count }));
  });
  const place = (path, time) => {
    let [low, high] = [0, path.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (path[middle][0] <= time) low = middle; else high = middle;
    }
    const share = Math.min(1, (time - path[low][0]) / (path[high][0] - path[low][0]));
    return [1, 2, 3].map((i) => path[low][i] + share * (path[high][i] - path[low][i]));
  };
  const shaft = (0.22 * radius) / fastest;
  const barb = 0.035 * radius;
  return (time) => arrows.flatMap(({ path, duration, at }) => {
    const now = (((at + time) % duration) + duration) % duration;
    const tip = place(path, now);
    const root = place(path, Math.max(0, now - shaft));
    const way = unit(sub(tip, root));
    const out = unit(cross(way, Math.abs(way[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
    const side = (across) => tip.map((v, i) => v - barb * way[i] + across * out[i]);
    return [...root, ...tip, ...side(0.5 * barb), ...tip, ...side(-0.5 * barb), ...tip];
  });
}

// What drifts in a scene: nothing in open water.
function driftIn({ pipe, streams, size }) {
  if (pipe.length) return drift(pipe);
  return streams.length ? driftAlong(streams, size) : () => [];
}

// A picture on a canvas that rotates and zooms; `scene` returns the items to draw.
class View {
  constructor(canvas, scene, camera) {
    this.canvas = canvas;
    this.scene = scene;
    this.home = camera;
    this.camera = { ...camera };
    this.gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
    if (!this.gl) {
      canvas.replaceWith(Object.assign(document.createElement("p"), {
        className: "missing", textContent: "This browser does not support 3-D graphics (WebGL); the rest of this page works.",
      }));
      return;
    }
    this.program = this.compile();
    this.listen();
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  compile() {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, shaders.vertex], [gl.FRAGMENT_SHADER, shaders.fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "place");
    gl.bindAttribLocation(program, 1, "normal");
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    return program;
  }

  upload(mesh) {
    const gl = this.gl;
    if (mesh.uploaded === mesh.places) return mesh;
    const load = (values, buffer) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(values), gl.STATIC_DRAW);
      return buffer;
    };
    const [places, normals] = mesh.buffers ?? [gl.createBuffer(), mesh.normals && gl.createBuffer()];
    mesh.buffers = [load(mesh.places, places), mesh.normals && load(mesh.normals, normals)];
    mesh.uploaded = mesh.places;
    return mesh;
  }

  listen() {
    const canvas = this.canvas;
    let held = null;
    canvas.addEventListener("pointerdown", (event) => {
      held = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      this.turn((event.clientX - held[0]) * 0.01, (event.clientY - held[1]) * 0.01);
      held = [event.clientX, event.clientY];
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (held = null));
    canvas.addEventListener("wheel", (event) => {
      // The wheel scrolls the page unless the canvas has the focus.
      if (document.activeElement !== canvas) return;
      event.preventDefault();
      this.zoom(Math.exp(event.deltaY * 0.001));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const act = {
        ArrowLeft: () => this.turn(-0.1, 0), ArrowRight: () => this.turn(0.1, 0),
        ArrowUp: () => this.turn(0, -0.1), ArrowDown: () => this.turn(0, 0.1),
        "+": () => this.zoom(0.9), "=": () => this.zoom(0.9), "-": () => this.zoom(1 / 0.9), Home: () => this.reset(),
      }[event.key];
      if (act) { event.preventDefault(); act(); }
    });
  }

  turn(yaw, pitch) {
    this.camera.yaw -= yaw;
    this.camera.pitch = Math.min(1.5, Math.max(-1.5, this.camera.pitch + pitch));
    this.draw();
  }

  zoom(factor) {
    this.camera.distance = Math.min(4, Math.max(0.15, (this.camera.distance / this.home.distance) * factor)) * this.home.distance;
    this.draw();
  }

  reset() {
    this.camera = { ...this.home };
    this.draw();
  }

  draw() {
    const gl = this.gl;
    if (!gl) return;
    const dense = Math.min(2, window.devicePixelRatio || 1);
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight].map((v) => Math.max(1, Math.round(v * dense)));
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    const { items, centre, size, names = [] } = this.scene();
    const { yaw, pitch, distance } = this.camera;
    const angle = 0.5;
    // The scene is as wide as the picture; in a very wide picture its height limits it.
    const far = (distance * size) / (2 * Math.tan(angle / 2) * Math.min(width / height, 3));
    const eye = centre.map((v, i) => v + far * [Math.sin(yaw) * Math.cos(pitch), -Math.cos(yaw) * Math.cos(pitch), Math.sin(pitch)][i]);
    const camera = product(perspective(angle, width / height, 0.02 * far, 4 * far + 4 * size), lookAt(eye, centre));
    for (const { label, position } of names) {
      const [x, y, , w] = [0, 1, 2, 3].map((i) => [...position, 1].reduce((sum, v, j) => sum + v * camera[4 * j + i], 0));
      label.hidden = w <= 0;
      const [across, down] = [(0.5 + x / w / 2) * width / dense, (0.5 - y / w / 2) * height / dense - 9];
      const room = width / dense - label.offsetWidth - 10;
      const right = across > room && across < width / dense ? across - label.offsetWidth - 10 : across + 10;
      label.style.transform = `translate(${right.toFixed(1)}px, ${down.toFixed(1)}px)`;
    }
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.program);
    const uniform = (name) => gl.getUniformLocation(this.program, name);
    gl.uniformMatrix4fv(uniform("camera"), false, camera);
    gl.uniform3fv(uniform("eye"), eye);
    for (const { mesh, pose = identity, colour, cut = false } of items) {
      if (!mesh.places.length) continue;
      const { buffers } = this.upload(mesh);
      gl.uniformMatrix4fv(uniform("pose"), false, pose);
      gl.uniform4fv(uniform("colour"), colour);
      gl.uniform1f(uniform("cut"), cut ? 1 : 0);
      gl.uniform1f(uniform("lit"), buffers[1] ? 1 : 0);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[0]);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
      if (buffers[1]) {
        gl.bindBuffer(gl.ARRAY_BUFFER, buffers[1]);
        gl.enableVertexAttribArray(1);
        gl.vertexAttribPointer(1, 3, gl.FLOAT, false, 0, 0);
      } else {
        gl.disableVertexAttribArray(1);
        gl.vertexAttrib3f(1, 0, 0, 1);
      }
      gl.drawArrays(buffers[1] ? gl.TRIANGLES : gl.LINES, 0, mesh.places.length / 3);
    }
  }
}

function colourOf(name, alpha = 1) {
  const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255).concat(alpha);
}

// The place and the attitude of a flight at a time.
function momentOf({ t, position, quaternion }, time) {
  let i = t.findIndex((value) => value >= time);
  i = Math.min(Math.max(i < 0 ? t.length - 1 : i, 1), t.length - 1);
  if (t.length < 2) return { time: 0, place: position[0], attitude: quaternion[0] };
  const u = (time - t[i - 1]) / (t[i] - t[i - 1] || 1);
  const place = position[i].map((v, j) => position[i - 1][j] + u * (v - position[i - 1][j]));
  const sign = dot(quaternion[i], quaternion[i - 1]) < 0 ? -1 : 1;
  const attitude = unit(quaternion[i].map((v, j) => quaternion[i - 1][j] * (1 - u) + sign * u * v));
  return { time, place, attitude };
}

const hex = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255).concat(1);

function start() {
  const data = JSON.parse(document.getElementById("data").textContent);
  const find = (id) => document.getElementById(id);
  const slider = find("time");
  let chosen = 0;
  const [cut, follow] = [find("cut"), find("follow")];
  const meshes = new Map();

  // The meshes of an agent are made when it is first shown.
  const meshesOfAgent = () => {
    if (!meshes.has(chosen)) {
      const agent = data.agents[chosen];
      const path = agent.flight.position;
      meshes.set(chosen, {
        outer: revolve(agent.outer, false), cavity: revolve(agent.cavity, true), core: shapeOfCore(agent.core),
        section: section(agent.outer, agent.cavity), joints: rings(agent.outer, agent.joints),
        flown: revolve(agent.outer, false), tube: tube(path, 0.012 * data.size), thread: tube(path, 0.01 * data.longest),
      });
    }
    return meshes.get(chosen);
  };

  const atTime = () => {
    const { flight } = data.agents[chosen];
    return momentOf(flight, (slider.value / slider.max) * flight.t[flight.t.length - 1]);
  };

  const agentScene = () => {
    const agent = data.agents[chosen];
    const { outer, cavity, core, section: faces, joints } = meshesOfAgent();
    const [first, last] = [agent.outer[0][0], agent.outer[agent.outer.length - 1][0]];
    const items = [
      { mesh: core, colour: colourOf("--core") },
      { mesh: outer, colour: hex(agent.colour), cut: cut.checked },
      { mesh: joints, colour: colourOf("--line", 0.35), cut: cut.checked },
    ];
    if (cut.checked)
      items.push({ mesh: cavity, colour: colourOf("--inside"), cut: true }, { mesh: faces, colour: colourOf("--material") });
    return { items, centre: [(first + last) / 2, 0, 0], size: last - first };
  };

  const pipe = bore([...data.pipe, ...data.chords]);
  const drifting = driftIn(data);
  const current = { places: [] };
  const marks = data.targets.map(({ name, position }) => {
    const label = find("names").appendChild(Object.assign(document.createElement("span"), { textContent: name }));
    return { name, position, label, mesh: ball(1) };
  });
  const surface = data.water === null ? null : surfaceMesh(data);
  const flightScene = () => {
    const { flown, tube: path, thread } = meshesOfAgent();
    const { time, place, attitude } = atTime();
    const agent = data.agents[chosen];
    // Close by, all is to scale; in the whole pipe the agent would be a speck.
    const near = follow.checked;
    const size = near ? 1 : data.magnification;
    const drawn = near ? place : moveOffWall(agent.outer, attitude, place, size, data.pipe);
    const dot = near ? 0.06 * data.longest : 0.045 * data.size;
    current.places = drifting(time);
    for (const { name, label } of marks) label.className = agent.targets.includes(name) ? "own" : "";
    const items = [
      { mesh: near ? thread : path, colour: hex(agent.colour) },
      { mesh: flown, pose: poseMatrix(attitude, drawn, size), colour: hex(agent.colour) },
      ...marks.map(({ name, position, mesh }) => ({
        mesh, pose: poseMatrix([1, 0, 0, 0], position, dot),
        colour: agent.targets.includes(name) ? colourOf("--target") : colourOf("--other"),
      })),
      { mesh: pipe, colour: colourOf("--line", 0.4) },
      { mesh: current, colour: colourOf("--water", 0.7) },
    ];
    if (surface) items.push({ mesh: surface, colour: colourOf("--water", 0.3) });
    return { items, names: marks, centre: near ? place : data.centre, size: near ? 5 * data.longest : data.length };
  };

  const agentView = new View(find("agent-view"), agentScene, { yaw: 0.45, pitch: 0.35, distance: 1.25 });
  const flightView = new View(find("flight-view"), flightScene, { yaw: 0.28, pitch: 0.22, distance: 1.18 });

  const showMoment = () => {
    const { time, place, attitude: [w, x, y, z] } = atTime();
    const agent = data.agents[chosen];
    const gaps = marks.filter(({ name }) => agent.targets.includes(name)).map(({ name, position }) => {
      const gap = Math.hypot(...sub(place, position));
      return `${gap < 1 ? `${(1000 * gap).toFixed(0)} mm` : `${gap.toFixed(2)} m`} from ${name}`;
    });
    const nose = (180 / Math.PI) * Math.asin(Math.max(-1, Math.min(1, 2 * (x * z - w * y))));
    const text = `${time.toFixed(2)} s: x ${place[0].toFixed(2)} m, z ${place[2].toFixed(2)} m, nose ${Math.abs(nose).toFixed(0)}° ` +
      `${nose < 0 ? "down" : "up"}, ${gaps.join(", ")}`;
    find("moment").textContent = text;
    slider.setAttribute("aria-valuetext", text);
  };
  const drawFlight = () => { showMoment(); flightView.draw(); };
  const showScale = () => {
    find("flight-scale").textContent = follow.checked ? "to scale" :
      `with the agent magnified ${data.magnification} times and moved off the wall`;
    drawFlight();
  };

  const choose = (number) => {
    chosen = number;
    find("agent-name").textContent = data.agents[chosen].targets.join(", ");
    for (const figure of document.querySelectorAll("[data-section]"))
      figure.hidden = Number(figure.dataset.section) !== chosen;
    for (const button of document.querySelectorAll("[data-agent]"))
      button.setAttribute("aria-pressed", String(Number(button.dataset.agent) === chosen));
    // Start at the closest approach.
    const { t } = data.agents[chosen].flight;
    slider.value = Math.round((slider.max * data.agents[chosen].closest) / (t[t.length - 1] || 1));
    agentView.draw();
    drawFlight();
  };
  for (const button of document.querySelectorAll("[data-agent]"))
    button.addEventListener("click", () => choose(Number(button.dataset.agent)));
  slider.addEventListener("input", drawFlight);
  cut.addEventListener("change", () => agentView.draw());
  follow.addEventListener("change", showScale);
  for (const [id, view] of [["agent", agentView], ["flight", flightView]])
    for (const [name, act] of [["in", () => view.zoom(0.8)], ["out", () => view.zoom(1.25)], ["home", () => view.reset()]])
      find(`${id}-${name}`).addEventListener("click", act);

  const play = find("play");
  let playing = null;
  const stop = () => { playing = null; play.textContent = "Play"; };
  const step = (now) => {
    if (playing === null) return;
    const { t } = data.agents[chosen].flight;
    const next = Number(slider.value) + ((now - playing) / 1000 / t[t.length - 1]) * slider.max;
    playing = now;
    slider.value = next;
    drawFlight();
    if (next >= slider.max) stop();
    else requestAnimationFrame(step);
  };
  play.addEventListener("click", () => {
    if (playing !== null) { stop(); return; }
    if (Number(slider.value) >= slider.max) slider.value = 0;
    playing = performance.now();
    play.textContent = "Pause";
    requestAnimationFrame(step);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { agentView.draw(); flightView.draw(); });
  showScale();
  choose(0);
}

// The free surface, over the bounding box of the pipe.
function surfaceMesh(data) {
  const [[x0, y0], [x1, y1]] = data.extent;
  const corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y0], [x1, y1], [x0, y1]];
  return { places: corners.flatMap(([x, y]) => [x, y, data.water]), normals: corners.flatMap(() => [0, 0, 1]) };
}

// A page without data, such as that of the studio, calls what it needs itself.
document.addEventListener("DOMContentLoaded", () => { if (document.getElementById("data")) start(); });
