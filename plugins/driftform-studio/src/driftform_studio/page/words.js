// What the core says of a study, in the words of the page: keys become the names of fields, and lead to them.
import { make } from "./parts.js";

export const LABELS = {
  "flow.speed": "Mean speed", "flow.kind": "Profile", "flow.roughness": "Wall roughness", "flow.exponent": "Exponent n", "flow.upstream": "Pipe before the inlet",
  "flow.swirl": "Secondary flow of bends", "flow.acceleration": "Acceleration", "flow.reference": "Mean speed in the file", "flow.file": "File of the current", "gusts.always": "Gusts in every flight",
  "fluid.density": "Density", "fluid.viscosity": "Viscosity", "fluid.gravity": "Gravity", "fluid.water_level": "Water level", "fluid.name": "Kind",
  "pipe.radius": "Inlet diameter", "pipe.direction": "Inlet slope, down", "pipe.parts": "Parts", "pipe.segments": "Length", "pipe.segments[0].radius": "Inner diameter",
  "release.position": "Release", "release.yaw_deg": "Yaw", "release.pitch_deg": "Pitch", "release.frame": "Release",
  "contact.friction": "Friction on the wall", "flight.horizon": "Longest flight", "robustness.position": "Spread of the release", "robustness.conditions": "Disturbed flights", "robustness.within": "Near enough",
  "builder.core": "Core", "builder.core_radius": "Diameter of the core", "builder.core_mass": "Mass of the core", "builder.core_cog": "Balance from nose", "builder.material": "Material", "builder.hull_density": "Density of the print", "builder.wall": "Wall", "builder.kit": "Printer", "builder.kit.bed": "Printer", "builder.kit.nozzle": "Nozzle",
  "simulator.use": "Simulator", "run.evaluations": "Flights", "run.seed": "Seed", targets: "Targets", title: "Name",
};

const TABLES = "pipe|flow|gusts|fluid|release|contact|flight|robustness|calibration|builder|simulator|hydrodynamics|strategy|run|targets|fitness|grammar";
const KEY = new RegExp(`\\b((?:${TABLES})(?:\\.[\\w-]+(?:\\[\\d+\\])?)+)(?: = ('[^']*'|\\[[^\\]]*\\]|[^\\s:,;)]*[^\\s:,;).]))?`, "g");

// Sentences that speak of files and commands, and what the page has in their place.
const SENTENCES = [
  [/^[\w. -]*\.toml(:\d+)?: /, ""],
  [/and evolve for (the measured value|that density) with --set ([\w.]+)/, "and search again with it ($2)"],
  [/'driftform trim' corrects its mass with ballast/, "“Weigh and trim” finds the ballast that corrects it"],
  [/^this is the uncertainty of the drag model: /, ""],
  [/film some drops, and run 'driftform calibrate'/, "film some drops, and fit the model to them"],
  [/'driftform drop' plans those that tell most/, "a plan of drops names those that tell most"],
  [/\bat = ([\d.e+-]+) is beyond the end of '([^']*)', which is/, "$1 m into $2 is beyond its end: it is"],
  [/\boff_wall = ([\d.e+-]+) is beyond the axis: the bore has a radius of ([\d.e+-]+) m there/, "$1 m off the wall is beyond the axis, which is $2 m off the wall there"],
  [/\(leave ([\w.]+) out\)/, "(empty the field $1 for a full pipe)"],
  [/ \(see 'driftform plugins'\)/, ""],
  [/ \(it is relative to the inlet: see release\.frame\)/, ""],
  [/flow\.kind = '(\w+)'/g, "the profile “$1”"],
  [/\bset ([\w.]+) to\b/g, "set $1 to"],
  [/\s*\(gusts\.always = true\)/, " (gusts.always)"],
  [/hydrodynamics\.drag is 'none'; set it to 'strips'/, "drag is switched off; switch it on"],
  [/\b(\w+)_deg\b(?!.*\[)/g, (word, name, at, line) => (line[at - 1] === "." ? word : name)],
  [/: add \[\[pipe\.parts\]\]/, ""],
];

const labelOf = (key) => LABELS[key] ?? (key.startsWith("targets.") ? key.slice(8) : LABELS[key.replace(/\.\w+$/, "")] ?? key.split(".").at(-1).replaceAll("_", " "));

// Returns the line as nodes. At the field of a `key`, its name is left out; `go` leads to the field of a key, if there are any.
export function sayLine(line, { key = "", go = null } = {}) {
  let words = line;
  for (const [pattern, replacement] of SENTENCES) words = words.replace(pattern, replacement);
  if (key) words = words.replace(new RegExp(`^${key.replace(/[.[\]]/g, "\\$&")}( = (\\[[^\\]]*\\]|[^:]*?))?(: | (?=lies|is |are |has ))`), "");
  const nodes = [];
  let last = 0;
  for (const match of words.matchAll(KEY)) {
    const [whole, found, value] = match;
    nodes.push(words.slice(last, match.index));
    const label = labelOf(found);
    nodes.push(go && found in LABELS ? make("button", { type: "button", class: "link", onclick: () => go(found) }, label) : found.startsWith("targets.") ? label : `“${label}”`);
    if (value && value !== "true" && !found.startsWith("targets.")) nodes.push(` of ${value.replaceAll("'", "")}`);
    last = match.index + whole.length;
  }
  nodes.push(words.slice(last));
  if (typeof nodes[0] === "string") nodes[0] = nodes[0].replace(/^[a-z]/, (letter) => letter.toUpperCase());
  return nodes.filter((node) => node !== "");
}
