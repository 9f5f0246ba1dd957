// Questions to the server. Addresses are relative to that of the page, whose first part is the token.

import { speak } from "./messages.js";
import { find } from "./parts.js";

export class Refused extends Error {
  constructor(errors) { super(errors.map((error) => error.line ?? error).join("\n")); this.errors = errors; }
}

export class Offline extends Error {}

export const part = encodeURIComponent;
const pause = (time) => new Promise((resolve) => setTimeout(resolve, time));

// Whoever waits for longer than this is shown that something goes on, ms.
const PATIENCE = 700;
let waiting = 0;

// Answers with the server's document; a document of ours makes it a POST.
export async function ask(address, document) {
  let response, answer;
  let isSlow = false;
  const timer = setTimeout(() => { isSlow = true; waiting++; find("busy").hidden = false; }, PATIENCE);
  try {
    response = await fetch(address, document === undefined ? {} : {
      method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(document),
    });
    answer = response.headers.get("content-type") === "application/json" ? await response.json() : { errors: [await response.text()] };
  } catch { throw new Offline(speak("server.offline")); } finally {
    clearTimeout(timer);
    if (isSlow) find("busy").hidden = --waiting === 0;
  }
  if (!response.ok) throw new Refused(answer.errors);
  return answer;
}

// Gives a file to the server, which keeps it for designs; `key` is what of a study it is for.
export async function give(file, key) {
  const content = await new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(reader.result.split(",")[1] ?? "");
    reader.onerror = () => reject(new Refused([speak("file.unreadable", { file: file.name })]));
    reader.readAsDataURL(file);
  });
  return ask("api/files", { name: file.name, content, key });
}

// Has the server do what takes a while; `show` is told how far it is.
export async function perform(address, document, show) {
  const { task } = await ask(address, document);
  for (let wait = 60; ; wait = Math.min(400, 1.3 * wait)) {
    await pause(wait);
    const { what, done, total, is_over: isOver, errors, result } = await ask(`api/tasks/${task}`);
    if (errors.length) throw new Refused(errors);
    if (isOver) return result;
    if (total) show(speak("task.progress", { done, total, what }));
  }
}
