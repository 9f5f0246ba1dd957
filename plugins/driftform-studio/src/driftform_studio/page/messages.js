// What the page says, in the language of the browser: catalogue.js has all of it in two languages.
import catalogue from "./catalogue.js";

export const language = navigator.languages.map((tag) => tag.split("-")[0].toLowerCase()).find((tag) => tag in catalogue) ?? "en";
const messages = catalogue[language];

// The message of a key, with values for its {names}; of "one|several" the form is that of the value `count`.
export function speak(key, values = {}) {
  const forms = messages[key].split("|");
  return (forms[values.count === 1 ? 0 : forms.length - 1]).replace(/\{(\w+)\}/g, (_, name) => values[name]);
}

// The same as a list of texts and nodes, for values that are nodes.
export const weave = (key, values) => messages[key].split(/\{(\w+)\}/).flatMap((text, i) => (i % 2 ? values[text] : text ? [text] : []));

// A line of the core, which is English in any language, without its files and commands.
export const rewordLine = (line) => catalogue.core.reduce((words, [pattern, flags, text]) => words.replace(new RegExp(pattern, flags), text.replace("{weigh}", messages.weigh)), line);

export const has = (key) => key in messages;

// The messages whose keys begin so, by what follows.
export const listMessages = (start) => Object.fromEntries(Object.entries(messages).filter(([key]) => key.startsWith(start)).map(([key, text]) => [key.slice(start.length), text]));

// Writes the messages that elements of the document ask for: their text, or an attribute.
export function translateDocument() {
  document.documentElement.lang = language;
  for (const [data, write] of [
    ["say", (element, text) => { element.textContent = text; }],
    ...[["sayLabel", "aria-label"], ["sayTitle", "title"], ["sayAlt", "alt"]].map(([data, name]) => [data, (element, text) => element.setAttribute(name, text)]),
  ])
    for (const element of document.querySelectorAll(`[data-${data.replace(/[A-Z]/, (letter) => `-${letter.toLowerCase()}`)}]`)) write(element, speak(element.dataset[data]));
}
