/* global momentOf */
// The page: a design, or a run. All that lasts is on the server's disk, so a page that is loaded again shows the same.
import { ask, Offline, part, perform, Refused } from "./ask.js";
import { drawCurve } from "./curve.js";
import { countHeld, goTo, makeNumber, makeSelect } from "./controls.js";
import { describe, Design } from "./design.js";
import { expectTime, learnTime } from "./expect.js";
import { Fields } from "./fields.js";
import { has, speak, translateDocument, weave } from "./messages.js";
import { colour, duration, find, grams, length, make, quote, save } from "./parts.js";
import { Side } from "./side.js";
import { Space, Turntable } from "./space.js";
import { describeHanging, describeTrim } from "./trim.js";
import { sayLine } from "./words.js";

translateDocument();

const KEPT = 0.9; // share of hits from which on a target is kept
const WORTH = 0.9; // of the 90 % miss of the baseline, from which on a shape matters little
const STYLES = { kept: "good", "kept if weighed": "fair", reached: "good", near: "fair", missed: "poor" };

let begin, fields, design; // what the server offers; the fields; the design that they show
let run = null; // {name, info, status}; null while a design is being made
let agent = null; // {key, data, number}
let checked = null; // the server's answer to the latest sound design
const paths = new Map(); // of evaluations of the run

const side = new Side(find("side"), {
  place: (point) => place(point),
  move: (name, point) => fields.targets.move(name, point),
  remove: (name) => fields.targets.remove(name),
  describe: (name) => fields.targets.describe(name),
  choose: (name) => { if (run) openAgent(name); },
  pick: (point) => pickAgent(point),
  say: (text) => say(text),
});
const space = new Space(find("space"));
const turntable = new Turntable(find("agent-view"), find("cut"));

const nameState = (state) => (has(`state.${state}`) ? speak(`state.${state}`) : state);
const nameVerdict = (verdict) => (has(`verdict.${verdict}`) ? speak(`verdict.${verdict}`) : verdict);
const say = (text) => { find("hint").textContent = text; };
const isOver = (status) => ["paused", "finished", "failed"].includes(status.state);
const address = (...parts) => ["api/runs", part(run.name), ...parts].join("/");

// ---- errors and the connection

function report(error) {
  if (error instanceof Offline) { offline(true); return; }
  if (!(error instanceof Refused)) throw error;
  showProblems(error.errors.map((line) => ({ line: line.line ?? line, wrong: true })));
}

function offline(on) {
  const banner = find("offline");
  if (on === !banner.hidden) return;
  banner.hidden = !on;
  banner.textContent = on ? speak("server.gone", { command: `driftform studio ${quote(begin?.folder ?? "runs")}` }) : "";
}

function showProblems(lines) {
  find("problems").replaceChildren(...lines.map(({ line, wrong }) => make("li", { class: wrong ? "wrong" : "" }, ...sayLine(line, { go: run ? null : goTo }))));
}

// Runs one question at a time, and always the latest; a question that comes meanwhile is asked afterwards.
function latest(work) {
  let busy = false, again = false;
  return async function act() {
    if (busy) { again = true; return; }
    busy = true;
    try {
      do { again = false; await work(); } while (again);
    } catch (error) { report(error); }
    busy = false;
  };
}

function delayed(work, time) {
  let timer;
  return (soon = false) => { clearTimeout(timer); timer = setTimeout(work, soon ? 0 : time); };
}

// ---- the design

const check = latest(async () => {
  if (run) return;
  const asked = design.document();
  const answer = await ask("api/check", asked);
  offline(false);
  if (run) return;
  showCommands(answer.text);
  mayStart = answer.errors.length === 0;
  showHeld();
  checked = answer.errors.length ? null : { ...answer, document: asked };
  if (answer.outline) {
    fields.targets.showPipe(answer.outline);
    // A target that was dragged on meanwhile stays where it is.
    side.show({ ...answer.outline, targets: fields.targets.listPlaces() });
    offerViews();
    find("views").dataset.drawn = "";
  }
  // After the rows of targets, which may have been made anew.
  showProblems(fields.showErrors(answer.errors).map(({ line }) => ({ line, wrong: true })));
  if (!checked) return;
  fields.flights.querySelector("input").placeholder = answer.evaluations;
  showExpected();
  examineSoon();
});

const examine = latest(async () => {
  // The design itself may have been changed meanwhile, and be wrong.
  const examined = checked;
  if (run || !examined) return;
  const { scene, warnings } = await ask("api/examine", examined.document);
  if (run || checked !== examined) return;
  side.profile = scene.profile;
  side.draw();
  space.show(scene, examined.outline);
  showProblems(warnings.map((line) => ({ line })));
});
const examineSoon = delayed(examine, 350);
const checkSoon = delayed(check, 60);
const change = (soon) => {
  side.showTargets(fields.targets.listPlaces());
  showIntro();
  showHeld();
  checkSoon(soon);
};
const place = (point) => side.focus(fields.targets.place(point));

let mayStart = false; // whether the server found nothing wrong with the design

// A field that holds what is no value keeps a search from being made of another one.
function showHeld() {
  const held = countHeld();
  find("start").disabled = !mayStart || held > 0;
  find("held").textContent = held ? speak("held", { count: held }) : "";
  find("undo").disabled = !design.canUndo && !held;
  find("redo").disabled = !design.canRedo;
}
document.addEventListener("held", () => { if (!run) showHeld(); });

// Whoever begins is told what this is.
function showIntro() { find("intro").hidden = run !== null || fields.targets.list.length > 0; }

// How long a search of the design takes, told before it begins.
function showExpected() {
  const { document: study, evaluations, outline } = checked;
  const { seconds, needsSolving } = expectTime({ isParted: design.parts.length > 0, evaluations, targets: Object.keys(study.targets ?? design.targets).length, robustness: { ...design.preset.robustness, ...design.changes.robustness }, axes: outline.axes });
  const cores = navigator.hardwareConcurrency;
  find("expect").replaceChildren([speak("search.expect", { time: duration(seconds), cores }), speak("search.expect.compile"), ...(needsSolving ? [speak("search.expect.tee")] : [])].join(" "));
  find("expect").hidden = false;
  return seconds;
}

// Takes back what a field holds, or else the latest step.
function undo(step) {
  if (run) return;
  const held = document.activeElement?.matches("[data-held]") ? document.activeElement : step < 0 ? document.querySelector("form [data-held]") : null;
  if (held) { held.takeBack(); return; }
  if (!(step < 0 ? design.canUndo : design.canRedo)) return;
  design.go(step);
  fields.show(design);
  change(true);
}
find("undo").addEventListener("click", () => undo(-1));
find("redo").addEventListener("click", () => undo(1));
document.addEventListener("keydown", (event) => {
  if (run || !(event.ctrlKey || event.metaKey) || event.altKey || find("runs").open) return;
  const key = event.key.toLowerCase();
  if (key !== "z" && key !== "y") return;
  event.preventDefault();
  undo(key === "y" || event.shiftKey ? 1 : -1);
});

function openDesign(next) {
  const wasRun = run !== null;
  run = null;
  design = next;
  design.keep();
  paths.clear();
  side.flights.clear();
  space.flights.clear();
  side.reach = side.profile = null;
  side.mode = "edit";
  closeAgent();
  document.body.className = "design";
  fields.show(design);
  for (const id of ["undo", "redo"]) find(id).hidden = false;
  showIntro();
  for (const id of ["pause", "resume", "more", "change", "progress", "promise", "reach-choice", "summary", "expect"]) find(id).hidden = true;
  find("start").hidden = false;
  mayStart = false;
  showHeld();
  find("reach").checked = false;
  find("legend").hidden = true;
  find("place").textContent = "";
  document.title = "driftform studio";
  say("");
  if (wasRun || location.hash) history.pushState(null, "", location.pathname);
  checkSoon(true);
}

find("add-target").addEventListener("click", () => {
  place(side.middle);
});
find("example-targets").addEventListener("click", () => {
  design.setTargets({ ...design.preset.targets });
  fields.targets.show();
  change(true);
});
find("start").addEventListener("click", async () => {
  if (!fields.targets.askForOne()) return;
  const button = find("start");
  button.disabled = true;
  find("start-wait").hidden = false;
  const begun = { at: Date.now(), seconds: checked && showExpected(), isParted: design.parts.length > 0 };
  try {
    const { run: name } = await ask("api/runs", { draft: design.document(), name: design.title });
    await openRun(name);
    run.begun = begun;
  } catch (error) {
    report(error);
  }
  find("start-wait").hidden = true;
  if (!run) button.disabled = false;
});

// ---- a run

async function openRun(name, key = null) {
  const info = await ask(`api/runs/${part(name)}`);
  run = { name, info, status: null };
  paths.clear();
  side.flights.clear();
  space.flights.clear();
  side.reach = null;
  side.mode = "look";
  closeAgent();
  checked = null;
  document.body.className = "run";
  for (const id of ["undo", "redo", "intro", "expect"]) find(id).hidden = true;
  find("held").textContent = "";
  find("summary").replaceChildren(...describe(info.document).map(([name, value]) => make("div", {}, make("dt", {}, name), make("dd", {}, value))));
  find("summary").hidden = false;
  find("start").hidden = true;
  find("change").hidden = false;
  find("reach-choice").hidden = !info.outline.axes.length;
  find("reach").checked = false;
  find("legend").hidden = true;
  find("place").textContent = [name, info.title].filter(Boolean).join(" · ");
  document.title = `${name} · driftform studio`;
  showProblems([]);
  say("");
  side.profile = info.scene.profile;
  side.show(info.outline);
  offerViews();
  find("views").dataset.drawn = "";
  space.show(info.scene, info.outline);
  showCommands(info.text);
  const wanted = `#run=${part(name)}`;
  if (!location.hash.startsWith(wanted)) history.pushState(null, "", wanted);
  await watch();
  if (key) await openAgent(key);
}

// Reads how far the search is, and again after a while if it goes on.
let timer;
const watch = latest(async () => {
  clearTimeout(timer);
  if (!run) return;
  const watched = run;
  let wait = document.hidden ? 4000 : 700;
  try {
    const status = await ask(address("status"));
    offline(false);
    if (watched !== run) return;
    await showStatus(status);
    if (isOver(status)) wait = 4000;
  } catch (error) {
    if (!(error instanceof Offline)) throw error;
    offline(true);
  } finally {
    if (watched === run) timer = setTimeout(watch, wait);
  }
});
document.addEventListener("visibilitychange", () => { if (run && !document.hidden) watch(); });

async function showStatus(status) {
  const before = run.status;
  run.status = status;
  const over = isOver(status);
  find("pause").hidden = !status.canPause || status.state === "pausing";
  find("resume").hidden = !["paused", "failed"].includes(status.state);
  find("more").hidden = status.state !== "finished";
  find("more").textContent = speak("search.on", { count: status.budget });
  showProgress(status);
  showProblems([
    ...status.failure.split("\n").filter(Boolean).map((line) => ({ line, wrong: true })),
    ...(over || status.canPause || status.state === "starting" || status.state === "pausing" ? [] : [{ line: speak("search.terminal") }]),
    ...(status.failed ? [{ line: speak("search.failed", { failed: status.failed, done: status.done, reason: status.commonestFailure }) }] : []),
  ]);
  if (JSON.stringify(status.targets) !== JSON.stringify(before?.targets) || status.state !== before?.state) {
    drawCurve(find("curve"), status);
    showPromises(status);
    await showFlights(status);
  }
  if (before && !isOver(before) && over) {
    say(status.state === "finished" ? speak("search.ended") : "");
    if (status.state === "finished" && run.begun?.seconds) learnTime(run.begun.isParted, run.begun.seconds, (Date.now() - run.begun.at) / 1000);
    if (agent) openAgent(agent.key);
  }
}

function showProgress({ state, done, budget, disturbed, rate, compiling }) {
  find("progress").hidden = false;
  const bar = find("progress-bar");
  const flying = state === "writing the best agents";
  if (flying && disturbed[0] < disturbed[1]) [bar.max, bar.value] = [disturbed[1], disturbed[0]];
  else if (compiling.length && !isOver({ state })) [bar.max, bar.value] = [compiling[1], Math.min(compiling[0], 0.97 * compiling[1])];
  else if (state === "starting" || flying || !(done || isOver({ state }))) bar.removeAttribute("value");
  else [bar.max, bar.value] = [budget, done];
  const words = [speak("progress.state", { state: nameState(state), done, budget })];
  if (flying) words.push(disturbed[1] ? speak("progress.disturbed.of", { done: disturbed[0], total: disturbed[1] }) : speak("progress.disturbed", { count: disturbed[0] }));
  else if (compiling.length && !isOver({ state })) words.push(speak(compiling[2] ? "progress.compiling" : "progress.compiling.each", { time: duration(compiling[1]) }));
  else if (state === "running" && !done) words.push(speak("progress.first"));
  else if (rate) words.push(speak("progress.rate", { rate: rate.toPrecision(2) }), speak("progress.left", { time: duration((budget - done) / rate) }));
  find("progress-text").textContent = words.join(", ");
  bar.setAttribute("aria-valuetext", words.join(", "));
  find("curve").toggleAttribute("hidden", !done);
}

const metres = (value) => make("td", { class: "wide" }, value == null ? "–" : length(value));
const share = (value, isDoubtful) => make("td", { class: isDoubtful ? "fair" : "" }, value == null ? "–" : `${Math.round(100 * value)} %`);

// Whether the baseline, a plain body that is tuned in the same way, does as well as the shape.
const isAsGood = (robust) => robust?.baseline?.p90 != null && robust.weighed?.p90 >= WORTH * robust.baseline.p90;

// What the table says of the baseline beside the verdict on the shape.
function judgeBaseline(robust) {
  if (robust?.baseline?.hit == null) return [];
  const verdict = nameVerdict(robust.baseline.hit >= KEPT ? "kept" : "missed");
  return [make("small", { class: isAsGood(robust) ? "fair" : "" }, isAsGood(robust) ? speak("promise.baseline.same") : speak("promise.baseline.verdict", { verdict }))];
}

// The agents of the run that were picked on its map, or came as a file.
function showPicks() {
  find("picks").hidden = !run.info.picks.length;
  find("picks").replaceChildren(make("span", {}, speak("promise.picks")), ...run.info.picks.map((key) => make("button", { type: "button", "data-pick": key, onclick: () => openAgent(key) }, key.replaceAll("_", ", "))));
}

function showPromises({ state, targets }) {
  find("promise").hidden = !targets.some((t) => t.evaluation !== null);
  showPicks();
  find("promise").hidden &&= !run.info.picks.length;
  const promised = targets.some((t) => t.p90 !== undefined && t.p90 !== null);
  find("promise-hint").textContent = promised
    ? speak("promise.hint") : speak(run.info.conditions ? "promise.sofar" : "promise.none");
  const rows = targets.map((t, number) => {
    const dot = make("i", { class: "dot" });
    dot.style.background = colour(number);
    const name = make("td", {}, make("span", { class: "name" }, dot, t.name));
    if (t.evaluation === null) return make("tr", {}, name, make("td", { colspan: 9 }, speak("promise.unflown")));
    const seen = agent?.key === t.name;
    return make("tr", { class: seen ? "chosen" : "" }, name,
      ...promised ? [share(t.robust?.hit), metres(t.p90), share(t.robust?.weighed?.hit), metres(t.robust?.weighed?.p90), share(t.robust?.baseline?.hit, isAsGood(t.robust)), metres(t.robust?.baseline?.p90)] : [make("td", {}, t.nominal == null ? "–" : length(t.nominal))],
      make("td", { class: `at ${STYLES[t.verdict] ?? ""}` }, nameVerdict(t.verdict), ...judgeBaseline(t.robust)),
      make("td", {}, make("button", { type: "button", "aria-pressed": String(seen), "aria-label": speak("promise.show", { name: t.name }), onclick: () => openAgent(t.name) }, speak("promise.open"))));
  });
  const focused = document.activeElement?.closest?.("#promises button")?.getAttribute("aria-label");
  find("promises").replaceChildren(
    make("thead", {}, make("tr", {}, ...["target", ...promised ? ["hit", "p90", "weighed", "p90", "baseline", "p90"] : ["nominal"]].map((key) => make("th", { scope: "col", class: key === "p90" ? "wide" : "" }, speak(`promise.${key}`))), make("th", { scope: "col", class: "at" }, speak("promise.verdict")), make("th", { scope: "col" }, make("span", { class: "seen-by-none" }, speak("promise.agent"))))),
    make("tbody", {}, ...rows),
  );
  if (focused) for (const button of find("promises").querySelectorAll("button")) if (button.getAttribute("aria-label") === focused) button.focus();
}

async function showFlights({ targets }) {
  const watched = run;
  const flights = new Map();
  for (const [number, { name, evaluation }] of targets.entries()) {
    if (evaluation === null) continue;
    if (!paths.has(evaluation)) paths.set(evaluation, (await ask(address("flights", evaluation))).path);
    flights.set(name, { path: paths.get(evaluation), number });
  }
  if (watched !== run) return;
  // Paths of agents that are not the best any more would fill the memory of a long search.
  const used = new Set(targets.map(({ evaluation }) => evaluation));
  for (const key of paths.keys()) if (!used.has(key)) paths.delete(key);
  side.flights = flights;
  side.draw();
  space.showFlights(flights);
}

const act = (name, document) => async () => {
  try { await ask(address(name), document?.() ?? {}); } catch (error) { report(error); }
  await watch();
};
find("pause").addEventListener("click", act("pause"));
find("resume").addEventListener("click", act("resume"));
find("more").addEventListener("click", act("resume", () => ({ more: run.status.budget })));
find("change").addEventListener("click", () => openDesign(Design.of(begin.presets, run.info.document)));
find("new").addEventListener("click", () => openDesign(new Design(begin.presets)));

// ---- the reach map

find("reach").addEventListener("change", async () => {
  side.reach = null;
  find("legend").hidden = true;
  side.mode = "look";
  if (find("reach").checked) {
    const asked = run;
    say(speak("map.mapping"));
    try {
      const reach = await perform(address("reach"), {}, (text) => say(speak("map.progress", { text })));
      if (asked !== run || !find("reach").checked) return;
      side.reach = reach;
      side.mode = "pick";
      const { words, text } = side.legend();
      find("legend").replaceChildren(make("span", {}, speak("map.legend")), ...words.map(([fillColour, word]) => {
        const swatch = make("i");
        swatch.style.background = fillColour;
        return make("span", {}, swatch, word);
      }), make("span", {}, make("i", { class: "none" }), speak("map.none")));
      find("legend").hidden = false;
      say(speak("map.pick", { text }));
    } catch (error) { say(""); report(error); }
  } else say("");
  side.draw();
});

async function pickAgent(point) {
  const where = point.map((v) => v.toFixed(2)).join(", ");
  say(speak("pick.looking", { where }));
  try {
    const { key, distance, evaluation } = await perform(address("pick"), { point }, (text) => say(speak("pick.progress", { where, text })));
    say(speak("pick.found", { evaluation, where, distance: length(distance) }));
    if (!run.info.picks.includes(key)) run.info.picks = [...run.info.picks, key].sort();
    await openAgent(key);
  } catch (error) { say(""); report(error); }
}

// ---- an agent

function closeAgent() {
  stop();
  agent = null;
  side.chosen = side.flown = null;
  space.showAgent(null);
  find("agent").hidden = find("transport").hidden = true;
}

async function openAgent(key) {
  const asked = run;
  if (!run?.status) return;
  if (run.status.targets.some((t) => t.name === key)) say("");
  if (!run.status.targets.some((t) => t.name === key && t.evaluation === null)) {
    const wait = find("agent-wait");
    find("agent").hidden = false;
    wait.hidden = false;
    wait.className = "wait busy";
    wait.textContent = speak("agent.building");
    if (agent?.key !== key) find("h-agent").textContent = speak("agent.for", { name: key });
    try {
      const data = await perform(address("agents", part(key)), {}, (text) => { wait.textContent = speak("agent.building.progress", { text }); });
      if (asked !== run) return;
      showAgent(key, data);
      wait.hidden = true;
    } catch (error) {
      wait.className = "wait";
      if (!(error instanceof Refused)) { report(error); return; }
      wait.replaceChildren(make("span", { class: "error" }, error.message));
    }
  }
}

function showAgent(key, data) {
  const again = agent?.key === key && agent.data.evaluation === data.evaluation;
  const { number } = data;
  const magnified = Math.max(1, Math.round((10 * space.scene.size) / data.longest) / 10);
  agent = { key, data, number, magnified };
  const dot = make("i", { class: "dot" });
  dot.style.background = colour(number);
  find("h-agent").replaceChildren(dot, data.target ? speak("agent.for", { name: data.target }) : /^[-\d._e]+$/.test(key) ? speak("agent.passes", { where: data.point.map((v) => v.toFixed(2)).join(", ") }) : speak("agent.named", { name: key }));
  find("agent-shown").hidden = find("transport").hidden = false;
  showPromise(data);
  const { facts } = data;
  const ballast = facts.mass - facts.hull - facts.core - facts.putty;
  find("agent-facts").replaceChildren(...[
    ["length", length(facts.length)], ["diameter", length(facts.diameter)], ["modules", `${facts.modules}`],
    ["mass", grams(facts.mass)], ["printed", grams(facts.hull)], ["core", grams(facts.core)],
    ...(ballast > 5e-5 ? [["ballast", grams(ballast)]] : []), ["water", speak(facts.buoyancy >= 0 ? "facts.rises" : "facts.sinks", { force: Math.abs(1000 * facts.buoyancy).toFixed(0) })],
    ...(facts.trim ? [["putty", grams(facts.putty)], ["pockets", (([low, high]) => speak("facts.range", { low, high }))(facts.trim.map((mass) => `${mass > 0 ? "+" : ""}${(1000 * mass).toFixed(1)} g`))]] : []),
    ...(facts.pressure ? [["pressure", facts.pressure]] : []),
  ].map(([name, value]) => make("div", {}, make("dt", {}, speak(`facts.${name}`)), make("dd", {}, value))));
  showTakes(key);
  if (!again) showWeighing(facts);
  find("drawing").open = false;
  find("section").removeAttribute("src");
  turntable.show(data, number);
  side.chosen = data.target ?? "";
  if (!again) {
    const { t } = data.flight;
    // The flight is shown at its closest approach.
    find("time").value = Math.round((1000 * data.closest) / (t.at(-1) || 1));
  }
  showMoment();
  showPromises(run.status);
  showCommands(run.info.text);
  history.replaceState(null, "", `#run=${part(run.name)}&agent=${part(key)}`);
}

function showPromise({ promise, effects, limits, target }) {
  const number = (key, value, main) => make("div", { class: main ? "main" : "" }, make("dt", {}, speak(`miss.${key}`)), make("dd", {}, value));
  const { nominal, p90, flights, failed } = promise;
  const { hit, weighed, baseline } = run.status.targets.find(({ name }) => name === target)?.robust ?? {};
  const percent = (value) => `${Math.round(100 * value)} %`;
  find("agent-promise").replaceChildren(
    number("nominal", length(nominal)),
    ...(hit === undefined ? [number("median", flights ? length(promise.median) : "–")] : [number("hit", percent(hit))]),
    number("p90", flights ? length(p90) : "–", true),
    ...(weighed ? [number("weighed.hit", percent(weighed.hit)), number("weighed.p90", length(weighed.p90), true)] : []),
    ...(baseline ? [number("baseline.hit", percent(baseline.hit)), number("baseline.p90", length(baseline.p90))] : []),
  );
  find("agent-limits").replaceChildren(...[...limits, ...(failed ? [speak("miss.failed", { failed, flights })] : [])].map((line) => make("li", {}, line)));
  for (const line of find("agent-limits").children) line.replaceChildren(...sayLine(line.textContent));
  const box = find("agent-effects");
  box.replaceChildren();
  if (effects.length) {
    const longest = Math.max(...effects.map((e) => e.deviation)) || 1;
    box.append(make("h3", {}, speak("effects")), make("dl", { class: "effects" }, ...effects.flatMap(({ name, deviation, advice }, i) => {
      const bar = make("i", { title: sayLine(advice).join("") });
      bar.style.width = `${(100 * deviation) / longest}%`;
      return [make("div", {}, make("dt", {}, name), make("dd", { class: i === effects.length - 1 ? "bar rest" : "bar" }, bar), make("dd", {}, length(deviation)))];
    })));
    const first = effects.find((e) => !e.advice.startsWith("nothing"));
    if (first && first.deviation > 0) box.append(make("p", { class: "hint" }, ...weave("effects.advice", { advice: sayLine(first.advice).map((node) => node.replace?.(/^[A-Z](?=[a-z])/, (letter) => letter.toLowerCase()) ?? node) })));
  }
  find("disturb").hidden = flights > 0;
  find("disturb").textContent = speak(target ? "agent.disturb" : "agent.disturb.point");
}

find("disturb").addEventListener("click", async () => {
  const { key, data } = agent;
  const button = find("disturb");
  const wait = find("agent-wait");
  button.disabled = true;
  wait.hidden = false;
  wait.className = "wait busy";
  wait.textContent = speak("flying.wait");
  try {
    const found = await perform(address("agents", part(key), "disturb"), {}, (text) => { wait.textContent = speak("flying.progress", { text }); });
    if (agent?.key === key) {
      data.promise = { nominal: data.promise.nominal, ...found.promise };
      data.effects = found.effects;
      showPromise(data);
    }
    wait.hidden = true;
  } catch (error) {
    wait.className = "wait";
    wait.textContent = error.message;
  }
  button.disabled = false;
});

function showTakes(key) {
  const made = (kind, label) => make("button", { type: "button", "data-kind": kind, onclick: (event) => takeMade(event.target, kind, label) }, label);
  find("takes").replaceChildren(
    make("button", { type: "button", class: "primary", "data-kind": "kit", onclick: (event) => takeMade(event.target, "kit", speak("take.kit")) }, speak("take.kit")),
    made("stl", speak("take.stl")), made("3mf", speak("take.3mf")),
    make("button", { type: "button", "data-kind": "agent", onclick: () => save(`${agent.data.name}.json`, agent.data.file) }, speak("take.agent")),
    make("button", { type: "button", "data-kind": "study", onclick: () => save(`${run.name}.toml`, run.info.text) }, speak("take.study")),
    make("button", { type: "button", "data-kind": "report", onclick: (event) => takeReport(event.target) }, speak("take.report")),
  );
  find("take-wait").textContent = "";
}

async function takeWith(button, label, work) {
  const wait = find("take-wait");
  button.disabled = true;
  wait.className = "wait busy";
  wait.textContent = speak("take.writing", { label });
  try { wait.replaceChildren(...await work((text) => { wait.textContent = speak("take.progress", { label, text }); })); } catch (error) {
    wait.replaceChildren(make("span", { class: "error" }, error.message));
    if (error instanceof Offline) offline(true);
  }
  wait.className = "wait";
  button.disabled = false;
}

const takeMade = (button, kind, label, ballast) => takeWith(button, label, async (show) => {
  const { made, file, sheet } = await perform(address("agents", part(agent.key), "make", kind), { ballast }, show);
  const link = make("a", { href: `take/made/${made}/${part(file)}`, download: file }, file);
  link.click();
  return [speak("take.done", { label }), link, sheet ? speak(sheet === "pdf" ? "take.sheet" : "take.sheet.svg") : ""];
});

const takeReport = (button) => takeWith(button, speak("take.report"), async (show) => {
  const { bytes } = await perform(address("report"), {}, show);
  const link = make("a", { href: `take/${part(run.name)}/report.html`, target: "_blank", rel: "noopener" }, speak("take.report.open"));
  return [speak("take.report.done", { size: (bytes / 1e6).toFixed(1), path: `${run.info.path}/report.html` }), link];
});

// ---- weighing

let weight = null; // of the print, g
let filling = ""; // what the ballast is of; empty for that of the design
let hung = {};

// The name of a ballast by its density, kg/m³.
function nameFilling(density) {
  const name = Object.keys(begin.ballast).find((known) => Math.abs(begin.ballast[known] - density) <= 0.01 * density);
  return name && has(`filling.${name}`) ? speak(`filling.${name}`) : name ?? `${Math.round(density)} kg/m³`;
}

function showWeighing({ hull, core }) {
  weight = null;
  find("weigh").hidden = run.info.document.builder?.use !== "frusta";
  find("weigh-field").replaceChildren(makeNumber(speak("weigh.field"), undefined, (grams) => { weight = grams; }, { unit: "g", keys: "weight", bounds: { above: 0, high: 1e6 }, placeholder: (1000 * (hull + core)).toFixed(1) }));
  filling = "";
  find("weigh-ballast").replaceChildren(makeSelect(speak("weigh.ballast"), [["", speak("weigh.usual")], ...Object.entries(begin.ballast).map(([name, density]) => [name, speak("weigh.density", { name: nameFilling(density), density: (density / 1000).toFixed(2) })])], "", (name) => { filling = name; }, { keys: "ballast" }));
  find("trimmed").replaceChildren();
  find("trim-wait").textContent = "";
  hung = { grams: null, celsius: null };
  const usual = run.info.document.fluid?.celsius ?? 20;
  find("hang-field").replaceChildren(makeNumber(speak("hang.field"), undefined, (grams) => { hung.grams = grams; }, { unit: speak("hang.unit"), keys: "hung" }));
  find("hang-celsius").replaceChildren(makeNumber(speak("hang.water"), undefined, (celsius) => { hung.celsius = celsius; }, { unit: "°C", keys: "celsius", bounds: { low: -10, high: 100 }, placeholder: String(usual) }));
  find("hanging").replaceChildren();
  find("hang-wait").textContent = "";
}

// The core speaks of an option in kg.
const sayWeight = (error) => [error.message.replace(/^--printed-mass [\d.e-]+: should be more than the core's ([\d.e-]+) kg.*/s, (_, core) => speak("weigh.light", { core: grams(Number(core)) }))
  .replace(/^--printed-mass [\d.e-]+: is in kg.*/s, speak("weigh.grams"))];

// A form that asks for work on the agent: its parts by id, and what is asked, shown and said of an error.
function answer(form, { button, wait, shown, words, ask, show, say }) {
  find(form).addEventListener("submit", async () => {
    const { key, data } = agent;
    const line = find(wait);
    if (find(form).querySelector("[data-held]")) return;
    find(button).disabled = true;
    line.className = "wait busy";
    line.textContent = words;
    find(shown).replaceChildren();
    try {
      const found = await perform(address("agents", part(key), button), ask(data), (text) => { line.textContent = speak("work.progress", { words, text }); });
      if (agent?.key === key) find(shown).replaceChildren(...show(found));
      line.textContent = "";
    } catch (error) {
      line.replaceChildren(make("span", { class: "error" }, ...say(error)));
      if (error instanceof Offline) offline(true);
    }
    line.className = "wait";
    find(button).disabled = false;
  });
}

answer("weigh", {
  button: "trim", wait: "trim-wait", shown: "trimmed", words: speak("weigh.placing"),
  // An empty field is a print that weighs what was simulated.
  ask: ({ facts }) => ({ grams: weight ?? 1000 * (facts.hull + facts.core), ...(filling ? { ballast: filling } : {}) }),
  show: (found) => describeTrim(found, nameFilling(found.ballast_density), (button, seats) => takeMade(button, "kit", speak("take.seated"), { ballast: seats, ballast_density: found.ballast_density })),
  say: sayWeight,
});

answer("weigh-in-water", {
  button: "hang", wait: "hang-wait", shown: "hanging", words: speak("flying"),
  ask: () => hung,
  show: describeHanging,
  say: (error) => [error.message.replace(/^--[a-z-]+ [\d.e+-]+: /, "")],
});

find("drawing").addEventListener("toggle", () => {
  if (find("drawing").open && agent) find("section").src = `take/${part(run.name)}/agents/${part(agent.key)}/section.svg`;
});

// ---- its flight

let playing = null;

function timeOf() {
  const { t } = agent.data.flight;
  return (find("time").value / 1000) * t.at(-1);
}

function showMoment() {
  if (!agent) return;
  const { data, number, magnified } = agent;
  const time = timeOf();
  const flown = { agent: data, time, number, size: find("follow").checked ? 1 : magnified };
  space.follow = find("follow").checked;
  const spatial = !find("space-stage").hidden;
  if (spatial) space.showAgent(flown); else space.flown = null;
  side.flown = flown;
  if (side.drawnFor !== data || side.drawnIn !== side.view) {
    side.drawnFor = data;
    side.drawnIn = side.view;
    // The path of a picked agent is that of its flight.
    if (!data.target) side.flights.set("", { path: data.flight.position, number });
    else side.flights.delete("");
    if (!spatial) side.draw();
  }
  if (!spatial) {
    if (find("follow").checked) followSide(time); else side.drawBody();
  }
  const { place } = momentOf(data.flight, time);
  const gap = Math.hypot(...place.map((v, i) => v - data.point[i]));
  const scale = find("follow").checked ? speak("moment.true") : speak("moment.magnified", { times: magnified });
  const text = speak("moment", { time: time.toFixed(2), x: place[0].toFixed(2), z: place[2].toFixed(2).replace("-", "−"), gap: length(gap), target: data.target ?? speak("moment.point") });
  find("moment").textContent = speak("moment.scaled", { text, scale });
  find("time").setAttribute("aria-valuetext", text);
}

function followSide(time) {
  const { place } = momentOf(agent.data.flight, time);
  [side.view.x, side.view.y] = side.flat(place);
  side.view.scale = Math.min(side.width / (5 * agent.data.longest), side.height / (3 * agent.data.longest));
  side.draw();
}

function stop() { playing = null; find("play").textContent = speak("flight.play"); }

function step(now) {
  if (playing === null || !agent) return;
  const slider = find("time");
  const next = Number(slider.dataset.at) + ((now - playing) / agent.data.flight.t.at(-1));
  playing = now;
  slider.dataset.at = slider.value = next;
  showMoment();
  if (next >= 1000) stop(); else requestAnimationFrame(step);
}

find("play").addEventListener("click", () => {
  if (playing !== null) { stop(); return; }
  const slider = find("time");
  if (Number(slider.value) >= 1000) slider.value = 0;
  slider.dataset.at = slider.value;
  playing = performance.now();
  find("play").textContent = speak("flight.pause");
  requestAnimationFrame(step);
});
find("time").addEventListener("input", () => { find("time").dataset.at = find("time").value; showMoment(); });
find("follow").addEventListener("change", () => { if (!find("follow").checked) side.fit(); showMoment(); });
find("cut").addEventListener("change", () => turntable.draw());
for (const [id, turn] of [["in", (v) => v.zoom(0.8)], ["out", (v) => v.zoom(1.25)], ["home", (v) => v.reset()]])
  find(`agent-${id}`).addEventListener("click", () => turntable.view && turn(turntable.view));

// ---- views

function showView(name) {
  const spatial = name === "space";
  find("side").toggleAttribute("hidden", spatial);
  find("space-stage").hidden = !spatial;
  find("show-side").setAttribute("aria-pressed", String(name === "side"));
  find("show-above").setAttribute("aria-pressed", String(name === "above"));
  if (!spatial) side.turn(name === "above");
  find("show-space").setAttribute("aria-pressed", String(spatial));
  find("reach-choice").hidden = spatial || !run?.info.outline.axes.length;
  find("legend").hidden = spatial || !side.reach;
  if (spatial) { space.draw(); showMoment(); } else { side.draw(); showMoment(); }
}
find("show-side").addEventListener("click", () => showView("side"));
find("show-above").addEventListener("click", () => showView("above"));

// A pipe that leaves the plane of the side view is shown from above, too.
function offerViews() {
  find("show-above").hidden = !side.isSpatial;
  if (!side.isSpatial && side.fromAbove) showView("side");
}
find("show-space").addEventListener("click", () => showView("space"));
const zoom = (factor) => { if (find("space-stage").hidden) side.zoom(factor); else space.view?.zoom(1 / factor); };
find("zoom-in").addEventListener("click", () => zoom(1.4));
find("zoom-out").addEventListener("click", () => zoom(1 / 1.4));
find("zoom-fit").addEventListener("click", () => { if (find("space-stage").hidden) side.fit(); else space.view?.reset(); });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { side.draw(); space.draw(); turntable.draw(); });
new ResizeObserver(() => { if (run?.status) drawCurve(find("curve"), run.status); }).observe(find("curve"));

// ---- the same in a terminal

function showCommands(text) {
  const folder = begin.folder;
  let lines;
  if (run) {
    const path = quote(run.info.path);
    lines = [`driftform resume ${path}`, `driftform watch ${path}`, `driftform report ${path}`];
    if (agent?.data.target) lines.push(`driftform export ${quote(`${run.info.path}:${agent.key}`)} --kit --format 3mf --out parts`);
    else if (agent) lines.push(`driftform pick ${path} ${agent.data.point.join(" ")}`, `driftform export ${quote(`${run.info.path}/picks/${agent.key}/agent.json`)} --kit --format 3mf --out parts`);
    lines = [`driftform evolve ${quote(`${run.name}.toml`)} --out ${quote(`${run.info.path}-again`)}   # ${run.name}.toml: ${speak("terminal.below")}`, ...lines];
    find("study-name").textContent = `${run.name}.toml`;
  } else {
    const stem = design.title.replace(/[^\p{L}\p{N}_-]+/gu, "-").replace(/^-+|-+$/g, "").toLowerCase() || "pipe";
    lines = [`driftform evolve ${quote(`${stem}.toml`)} --out ${quote(`${folder}/${stem}-1`)}   # ${stem}.toml: ${speak("terminal.below")}`];
    find("study-name").textContent = `${stem}.toml`;
  }
  find("command").textContent = lines.join("\n");
  find("study").textContent = text;
}
for (const button of document.querySelectorAll("[data-copy]"))
  button.addEventListener("click", async () => {
    const text = find(button.dataset.copy);
    try {
      await navigator.clipboard.writeText(text.textContent);
      button.textContent = speak("copy.done");
    } catch {
      // A browser may forbid it; what is selected can be copied by hand.
      getSelection().selectAllChildren(text);
      button.textContent = speak("copy.selected");
    }
    setTimeout(() => { button.textContent = speak("copy"); }, 1500);
  });

find("save-study").addEventListener("click", () => save(find("study-name").textContent, find("study").textContent));

// ---- files of designs and agents

find("open-file").addEventListener("click", () => find("file").click());
find("file").addEventListener("change", async () => {
  const [file] = find("file").files;
  find("file").value = "";
  if (file) await openFile(file);
});

// Opens a study file as a design, and the file of an agent as a run with this agent.
async function openFile(file) {
  try {
    if (!/\.(toml|json)$/i.test(file.name)) throw new Refused([speak("design.kind", { file: file.name })]);
    const { draft, run: name } = await ask("api/designs", { name: file.name, text: await file.text() });
    if (name) { await openRun(name, name); return; }
    const { base, title, ...changes } = draft;
    openDesign(new Design(begin.presets, { base, title: title ?? "", changes }));
    say(speak("design.opened", { file: file.name }));
  } catch (error) {
    if (error instanceof Refused) say(sayLine(error.message).join(""));
    report(error);
  }
}

// ---- the runs

find("open-runs").addEventListener("click", async () => {
  try {
    const { runs, folder } = await ask("api/runs");
    find("folder").textContent = folder;
    find("run-list").replaceChildren(...runs.map((row) => make("li", {}, make("button", {
      type: "button", disabled: row.state === "damaged",
      onclick: () => { find("runs").close(); openRun(row.name).catch(report); },
    }, make("b", {}, row.name), make("span", { class: row.state === "finished" ? "good" : "" }, nameState(row.state)),
      make("small", {}, row.problem ?? [row.title, speak("runs.targets", { count: row.targets })].filter(Boolean).join(", ")),
      make("small", {}, row.problem ? "" : speak("runs.flights", { done: row.done, budget: row.budget }))))));
    if (!runs.length) find("run-list").append(make("li", { class: "hint" }, speak("runs.none")));
    find("runs").showModal();
  } catch (error) { report(error); }
});
find("close-runs").addEventListener("click", () => find("runs").close());

// ---- begin

function wanted() {
  const hash = new URLSearchParams(location.hash.slice(1));
  return { name: hash.get("run"), key: hash.get("agent") };
}

async function open() {
  const { name, key } = wanted();
  if (!name) { openDesign(Design.restore(begin.presets)); return; }
  if (run?.name === name) return;
  try { await openRun(name, key); } catch (error) {
    if (error instanceof Offline) throw error;
    openDesign(Design.restore(begin.presets));
    report(error);
  }
}
addEventListener("popstate", () => open().catch(report));

for (let wait = 300; ; wait = Math.min(3000, 2 * wait)) {
  try {
    begin = await ask("api/begin");
    break;
  } catch (error) {
    offline(true);
    await new Promise((resolve) => setTimeout(resolve, wait));
  }
}
offline(false);
fields = new Fields(begin, change);
await open().catch(report);
