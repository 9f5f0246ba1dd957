// What the core says of a study, in the words of the page: keys become the names of fields, and lead to them.
import { listMessages, rewordLine, speak } from "./messages.js";
import { make } from "./parts.js";

export const LABELS = listMessages("label.");

const TABLES = "pipe|flow|gusts|fluid|release|contact|flight|robustness|calibration|builder|simulator|hydrodynamics|strategy|run|targets|fitness|grammar";
const KEY = new RegExp(`\\b((?:${TABLES})(?:\\.[\\w-]+(?:\\[\\d+\\])?)+)(?: = ('[^']*'|\\[[^\\]]*\\]|[^\\s:,;)]*[^\\s:,;).]))?`, "g");

const labelOf = (key) => LABELS[key] ?? (key.startsWith("targets.") ? key.slice(8) : LABELS[key.replace(/\.\w+$/, "")] ?? key.split(".").at(-1).replaceAll("_", " "));

// Returns the line as nodes. At the field of a `key`, its name is left out; `go` leads to the field of a key, if there are any.
export function sayLine(line, { key = "", go = null } = {}) {
  let words = rewordLine(line);
  if (key) words = words.replace(new RegExp(`^${key.replace(/[.[\]]/g, "\\$&")}( = (\\[[^\\]]*\\]|[^:]*?))?(: | (?=lies|is |are |has ))`), "");
  const nodes = [];
  let last = 0;
  for (const match of words.matchAll(KEY)) {
    const [whole, found, value] = match;
    nodes.push(words.slice(last, match.index));
    const label = labelOf(found);
    nodes.push(go && found in LABELS ? make("button", { type: "button", class: "link", onclick: () => go(found) }, label) : found.startsWith("targets.") ? label : `“${label}”`);
    if (value && value !== "true" && !found.startsWith("targets.")) nodes.push(speak("value.of", { value: value.replaceAll("'", "") }));
    last = match.index + whole.length;
  }
  nodes.push(words.slice(last));
  if (typeof nodes[0] === "string") nodes[0] = nodes[0].replace(/^[a-z]/, (letter) => letter.toUpperCase());
  return nodes.filter((node) => node !== "");
}
