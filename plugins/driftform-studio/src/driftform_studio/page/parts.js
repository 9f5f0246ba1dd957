// Small helpers of the page: elements, numbers and lengths in words.
import { speak } from "./messages.js";

export const find = (id) => document.getElementById(id);

// Makes an element. Texts are always text: names come from the files of others.
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  return fill(element, attributes, children);
}

export function draw(tag, attributes = {}, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function fill(element, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (key === "value") element.value = value;
    else if (value === true) element.setAttribute(key, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
}

export const round = (value, step) => Number((Math.round(value / step) * step).toFixed(6));
export const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

// A length as people say it.
export function length(metres) {
  if (metres === null || metres === undefined) return speak("length.unknown");
  if (metres < 0.0095) return `${(1000 * metres).toFixed(1)} mm`;
  return metres < 1 ? `${(1000 * metres).toFixed(0)} mm` : `${metres.toFixed(2)} m`;
}

export const grams = (kilograms) => `${(1000 * kilograms).toFixed(1)} g`;

export function duration(seconds) {
  if (seconds < 90) return `${Math.max(1, Math.round(seconds))} s`;
  return seconds < 5400 ? `${Math.round(seconds / 60)} min` : `${(seconds / 3600).toFixed(1)} h`;
}

// Gives a text to be kept as a file.
export function save(name, text) {
  const link = make("a", { href: URL.createObjectURL(new Blob([text], { type: "application/octet-stream" })), download: name });
  link.click();
  URL.revokeObjectURL(link.href);
}

// The colour of the target of a number; those of pictures of the core, readable on dark too.
export const colour = (number) => `var(--s${number % 10})`;
export const hexColour = (number) => getComputedStyle(document.documentElement).getPropertyValue(`--s${number % 10}`).trim();

export const quote = (word) => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", `'"'"'`)}'`);
