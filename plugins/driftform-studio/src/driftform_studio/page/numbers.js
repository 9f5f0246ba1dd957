// Numbers as people type them: with a point or a comma, and with the unit of the field or another one of its kind.

const LENGTHS = { m: 1, cm: 0.01, mm: 0.001, km: 1000, um: 1e-6, "µm": 1e-6 };
const MASSES = { kg: 1, g: 0.001 };
const scaleOf = (unit, given) => [LENGTHS, MASSES].filter((kind) => unit in kind && given in kind).map((kind) => kind[given] / kind[unit])[0];

// Returns {value}, or {fault} in words; `value` is null for an empty field that has a default.
export function readNumber(text, { unit = "", bounds = {}, whole = false, optional = false } = {}) {
  const typed = text.trim().replaceAll("−", "-");
  if (!typed) return optional ? { value: null } : { fault: "Enter a number" };
  const [, digits, given] = typed.match(/^([+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:e[+-]?\d+)?)\s*([^\d\s,.]*)$/i) ?? [];
  if (digits === undefined) return { fault: "This is not a number; write it as 0.5" };
  if (/^[+-]?[1-9]\d{0,2},\d{3}$/.test(digits)) return { fault: `Is it ${digits.replace(",", "")} or ${digits.replace(",", ".")}? Write it without the comma` };
  const factor = !given || given === unit ? 1 : scaleOf(unit, given);
  if (!factor) return { fault: unit ? `The field is in ${unit}, not in ${given}` : "Enter a number without a unit" };
  const value = Number((Number(digits.replace(",", ".")) * factor).toPrecision(12));
  const { low, above, high, below } = bounds;
  const say = (limit) => `${limit}${unit && unit !== "°" ? " " : ""}${unit}`;
  if (whole && !Number.isInteger(value)) return { fault: "Enter a whole number" };
  if (value < low) return { fault: `At least ${say(low)}` };
  if (value <= above) return { fault: `More than ${say(above)}` };
  if (value > high || value >= below || !Number.isFinite(value)) return { fault: value > high || high !== undefined ? `At most ${say(high)}` : `Less than ${say(below ?? "infinity")}` };
  return { value };
}

// The bounds of an option, of text such as "> 0, ≤ 100".
export function readBounds(text) {
  const names = { "≥": "low", ">": "above", "≤": "high", "<": "below" };
  return Object.fromEntries([...(text ?? "").matchAll(/([≥>≤<]) ([\d.e+-]+)/g)].map(([, sign, limit]) => [names[sign], Number(limit)]));
}
