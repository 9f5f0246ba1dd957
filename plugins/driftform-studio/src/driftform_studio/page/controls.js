// The fields of the forms. A field holds its text until that is a valid value; only then is anything changed by it.
import { speak } from "./messages.js";
import { find, make } from "./parts.js";
import { readBounds, readNumber } from "./numbers.js";

const PATIENCE = 700; // ms for which a number that is being typed may be wrong without a word

const slug = (text) => text.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "-");

// A label with its control. `keys` are those of the study that it answers for; the first one names it, together with the label.
export function makeField(label, control, keys, { wide = false, named = label, title } = {}) {
  control.id = `f-${slug(`${keys.split(" ")[0]} ${named}`)}`;
  control.dataset.errors = keys;
  if (named !== label) control.setAttribute("aria-label", named);
  if (title) control.title = title;
  return make("div", { class: wide ? "field wide" : "field" }, make("label", { for: control.id }, label), control);
}

// Says what is wrong at a control, or nothing; `kind` is the source: the field itself or the server.
export function sayFault(control, kind, ...words) {
  const box = control.closest(".field, .target, .part") ?? control;
  box.querySelector(`:scope > .error.${kind}`)?.remove();
  control.removeAttribute("aria-invalid");
  control.removeAttribute("aria-describedby");
  if (!words.length) return;
  const id = `${kind}-${control.id || slug(box.dataset.errors ?? "")}`;
  box.append(make("p", { class: `error ${kind}`, id, role: "alert" }, ...words));
  if (!control.matches("input, select")) return;
  control.setAttribute("aria-invalid", "true");
  control.setAttribute("aria-describedby", id);
}

// `options`: unit, keys, bounds (as the core describes them), whole, placeholder (then it may be empty), title, named; `act`
// takes a valid value, null for an empty field.
export function makeNumber(label, value, act, { unit = "", keys, bounds = "", whole = false, placeholder, ...options }) {
  const rules = { unit, bounds: typeof bounds === "string" ? readBounds(bounds) : bounds, whole, optional: placeholder !== undefined };
  // What it held when it was left, and whether something else was taken over since.
  let sound = { text: `${value ?? ""}`, value: value ?? null };
  let isChanged = false;
  let timer;
  const input = make("input", { type: "text", inputmode: "decimal", autocomplete: "off", spellcheck: "false", value: sound.text, placeholder });
  const tell = () => input.dispatchEvent(new Event("held", { bubbles: true }));
  const look = (isOver) => {
    clearTimeout(timer);
    const { value: found, fault } = readNumber(input.value, rules);
    input.toggleAttribute("data-held", fault !== undefined);
    if (fault === undefined) {
      sayFault(input, "own");
      if (isOver && found !== null) input.value = `${found}`;
      return found;
    }
    // A number that is being typed may have passed through others, such as 1 on the way to 1e9.
    if (isChanged) act(sound.value);
    isChanged = false;
    if (isOver) sayFault(input, "own", `${fault}.`);
    else timer = setTimeout(() => input.isConnected && look(true), PATIENCE);
    return undefined;
  };
  input.addEventListener("input", () => {
    const found = look(false);
    if (found !== undefined) { isChanged = true; act(found); }
    tell();
  });
  input.addEventListener("blur", () => {
    if (!input.isConnected) return;
    const found = look(true);
    if (found !== undefined) sound = { text: input.value, value: found };
    isChanged = false;
  });
  input.takeBack = () => { input.value = sound.text; look(true); tell(); };
  // Shows a value that was changed elsewhere, such as by dragging.
  input.show = (fresh) => {
    if (input === document.activeElement || "held" in input.dataset) return;
    sound = { text: `${fresh}`, value: fresh === "" ? null : fresh };
    input.value = sound.text;
  };
  return makeField(unit ? `${label} (${unit})` : label, input, keys, { named: options.named ?? label, ...options });
}

export function makeText(label, value, act, { keys, largest = 80, isFaulty = () => "", late = false, ...options }) {
  let sound = value;
  const input = make("input", { type: "text", value, maxlength: largest, autocomplete: "off" });
  input.addEventListener(late ? "change" : "input", () => {
    const fault = isFaulty(input.value.trim());
    input.toggleAttribute("data-held", fault !== "");
    sayFault(input, "own", ...(fault ? [`${fault}.`] : []));
    input.dispatchEvent(new Event("held", { bubbles: true }));
    if (fault) return;
    sound = input.value;
    act(late ? input.value.trim() : input.value);
  });
  input.takeBack = () => { input.value = sound; input.removeAttribute("data-held"); sayFault(input, "own"); input.dispatchEvent(new Event("held", { bubbles: true })); };
  return makeField(label, input, keys, options);
}

export function makeSelect(label, choices, value, act, { keys, ...options }) {
  const select = make("select", { onchange: (event) => act(event.target.value) }, ...choices.map(([name, text]) => make("option", { value: name, selected: name === value }, text)));
  return makeField(label, select, keys, options);
}

// Fields that few need.
export const makeMore = (fields, id, title = speak("more")) => (fields.length ? [make("details", { class: "wide", id }, make("summary", {}, title), make("div", { class: "fields" }, ...fields))] : []);

// How many fields hold what is no value.
export const countHeld = () => document.querySelectorAll("form [data-held]").length;

// Leads to the field that answers for a key; false if there is none.
export function goTo(key) {
  const answers = [...document.querySelectorAll("form [data-errors]")].filter((field) => field.dataset.errors.split(" ").includes(key));
  const field = answers.find((e) => e.matches("input, select")) ?? answers[0];
  if (!field) return false;
  for (let box = field.closest("details"); box; box = box.parentElement.closest("details")) box.open = true;
  (field.matches("input, select") ? field : field.querySelector("input, select, button"))?.focus();
  field.scrollIntoView({ block: "center" });
  return true;
}

export const remember = () => ({ focus: document.activeElement?.id, open: [...document.querySelectorAll("form details[open]")].map(({ id }) => id).filter(Boolean) });

// Shows the forms as they were before their fields were made anew.
export function recall({ focus, open }) {
  for (const id of open) find(id)?.setAttribute("open", "");
  if (focus?.startsWith("f-")) find(focus)?.focus({ preventScroll: true });
}
