// Numbers as people type them: with a point or a comma, and with the unit of the field or another one of its kind.
import { speak } from "./messages.js";

const LENGTHS = { m: 1, cm: 0.01, mm: 0.001, km: 1000, um: 1e-6, "µm": 1e-6 };
const MASSES = { kg: 1, g: 0.001 };
const scaleOf = (unit, given) => [LENGTHS, MASSES].filter((kind) => unit in kind && given in kind).map((kind) => kind[given] / kind[unit])[0];

// Returns {value}, or {fault} in words; `value` is null for an empty field that has a default.
export function readNumber(text, { unit = "", bounds = {}, whole = false, optional = false } = {}) {
  const typed = text.trim().replaceAll("−", "-");
  if (!typed) return optional ? { value: null } : { fault: speak("number.enter") };
  const [, digits, given] = typed.match(/^([+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:e[+-]?\d+)?)\s*([^\d\s,.]*)$/i) ?? [];
  if (digits === undefined) return { fault: speak("number.not") };
  if (/^[+-]?[1-9]\d{0,2},\d{3}$/.test(digits)) return { fault: speak("number.comma", { one: digits.replace(",", ""), other: digits.replace(",", ".") }) };
  const factor = !given || given === unit ? 1 : scaleOf(unit, given);
  if (!factor) return { fault: unit ? speak("number.unit", { unit, given }) : speak("number.unitless") };
  const value = Number((Number(digits.replace(",", ".")) * factor).toPrecision(12));
  const { low, above, high, below } = bounds;
  const say = (key, limit) => ({ fault: speak(key, { limit: `${limit}${unit && unit !== "°" ? " " : ""}${unit}` }) });
  if (whole && !Number.isInteger(value)) return { fault: speak("number.whole") };
  if (value < low) return say("number.least", low);
  if (value <= above) return say("number.more", above);
  if (value > high || value >= below || !Number.isFinite(value)) return high !== undefined ? say("number.most", high) : say("number.less", below ?? speak("number.infinity"));
  return { value };
}

// The bounds of an option, of text such as "> 0, ≤ 100".
export function readBounds(text) {
  const names = { "≥": "low", ">": "above", "≤": "high", "<": "below" };
  return Object.fromEntries([...(text ?? "").matchAll(/([≥>≤<]) ([\d.e+-]+)/g)].map(([, sign, limit]) => [names[sign], Number(limit)]));
}
