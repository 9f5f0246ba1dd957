// What makes a weighed print fly as simulated: ballast in words, and what the miss becomes.
import { grams, length, make } from "./parts.js";

const NEGLIGIBLE = 5e-5; // kg: half the last digit of a kitchen scale

function describeSpot(x, aft) {
  const side = Math.abs(x) < 5e-5 ? "at the middle of the core" : `${(1000 * Math.abs(x)).toFixed(1)} mm ${x > 0 ? "in front of" : "behind"} the middle of the core`;
  return `${side}, ${(1000 * (x - aft)).toFixed(1)} mm from the aft end`;
}

function describePiece({ mass, x, diameter, ring, start, end }, aft) {
  if (diameter) return `a steel ball of ${(1000 * diameter).toFixed(1)} mm (${grams(mass)}) ${describeSpot(x, aft)}`;
  if (ring) return `${grams(mass)} of epoxy putty as a ring on the wall, ${(1000 * ring).toFixed(1)} mm wide and thick, ${describeSpot(x, aft)}`;
  return `${grams(mass)} of steel that fills the bore from ${describeSpot(start, aft)}, to ${describeSpot(end, aft)}`;
}

// `takeKit` is called with the seats of a kit that holds the ballast.
export function describeTrim({ ballast_mass: ballast, pieces, held, unheld, buoyancy, aft_end: aft, simulated_mass: simulated, printed_mass: printed, misses }, takeKit) {
  const lines = [];
  if (Math.abs(ballast) < NEGLIGIBLE) lines.push(make("p", {}, make("b", {}, "No ballast: "), "it weighs what was simulated."));
  else if (ballast < 0)
    lines.push(make("p", {}, make("b", {}, `${grams(-ballast)} too heavy. `), `Print the hull ${(100 * buoyancy.hull_excess).toFixed(1)} % lighter (less infill or flow), or glue ${(1e6 * buoyancy.volume).toFixed(1)} cm³ of foam on it, ${describeSpot(buoyancy.x, aft)}.`));
  else if (pieces.length) {
    lines.push(make("p", {}, make("b", {}, `${grams(ballast)} of ballast: `), pieces.map((piece) => describePiece(piece, aft)).join("; "), "."));
    if (held.length) {
      const parts = [...new Set(held.map(({ part }) => part))].join(" and the ");
      lines.push(make("p", {}, `The ${parts} can have a seat that holds it. `, make("button", { type: "button", "data-kind": "trimmed", onclick: (event) => takeKit(event.target, held.map((ball) => [ball.x, ball.diameter].map((v) => Number(v.toFixed(5))))) }, "3MF kit with this seat")));
    } else lines.push(make("p", { class: "hint" }, `Put it in through the joint at the core, before the core, and weigh again.${unheld ? " No seat can be printed for it." : ""}`));
  } else lines.push(make("p", {}, make("b", {}, `${grams(ballast)} of ballast, `), "and no room for it inside where it can be put. Print it heavier, with more perimeters, and weigh again."));
  const rows = [["as simulated", simulated, misses.simulated], ["as weighed", printed, misses.untrimmed], [ballast < 0 ? "with the foam" : "with the ballast", printed + Math.max(ballast, 0), misses.trimmed]].filter(([, , miss]) => miss !== undefined);
  lines.push(make("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "What the miss becomes" }, make("table", {},
    make("thead", {}, make("tr", {}, ...["undisturbed flight", "weight", "miss"].map((text) => make("th", { scope: "col" }, text)))),
    make("tbody", {}, ...rows.map(([words, mass, miss]) => make("tr", {}, make("th", { scope: "row" }, words), make("td", {}, grams(mass)), make("td", {}, length(miss))))))));
  return lines;
}

export function describeHanging({ lines, misses: { simulated, untrimmed, trimmed } }) {
  const rows = [["as simulated", simulated], ["as it weighs now", untrimmed], ["with the putty", trimmed]].filter(([, miss]) => miss !== undefined);
  return [...lines.map((line) => make("p", {}, line)), make("p", { class: "hint" }, rows.map(([words, miss]) => `Undisturbed, ${words}, it misses by ${length(miss)}.`).join(" "))];
}
