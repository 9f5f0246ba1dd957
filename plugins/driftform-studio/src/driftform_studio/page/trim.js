// What makes a weighed print fly as simulated: ballast in words, and what the miss becomes.
import { speak } from "./messages.js";
import { grams, length, make } from "./parts.js";

const NEGLIGIBLE = 5e-5; // kg: half the last digit of a kitchen scale

const millimetres = (metres) => (1000 * metres).toFixed(1);

function describeSpot(x, aft) {
  const side = Math.abs(x) < 5e-5 ? speak("spot.middle") : speak(x > 0 ? "spot.fore" : "spot.aft", { mm: millimetres(Math.abs(x)) });
  return speak("spot", { side, mm: millimetres(x - aft) });
}

function describePiece({ mass, x, diameter, ring }, aft, material) {
  if (diameter) return speak("piece.ball", { material, mm: millimetres(diameter), mass: grams(mass), spot: describeSpot(x, aft) });
  return speak("piece.ring", { mass: grams(mass), mm: millimetres(ring), spot: describeSpot(x, aft) });
}

// `material` is that of the ballast; `takeKit` is called with the seats of a kit that holds it.
export function describeTrim({ ballast_mass: ballast, pieces, held, unheld, buoyancy, aft_end: aft, simulated_mass: simulated, printed_mass: printed, misses }, material, takeKit) {
  const lines = [];
  const say = (key, ...rest) => lines.push(make("p", {}, make("b", {}, speak(key, { mass: grams(Math.abs(ballast)) })), ...rest));
  if (Math.abs(ballast) < NEGLIGIBLE) say("trim.none", speak("trim.none.why"));
  else if (ballast < 0)
    say("trim.heavy", speak("trim.heavy.remedy", { percent: (100 * buoyancy.hull_excess).toFixed(1), volume: (1e6 * buoyancy.volume).toFixed(1), spot: describeSpot(buoyancy.x, aft) }));
  else if (pieces.length) {
    say("trim.ballast", pieces.map((piece) => describePiece(piece, aft, material)).join("; "), ".");
    if (held.length) {
      const parts = [...new Set(held.map(({ part }) => part))].join(speak("trim.and"));
      lines.push(make("p", {}, speak("trim.seat", { parts }), make("button", { type: "button", "data-kind": "trimmed", onclick: (event) => takeKit(event.target, held.map((ball) => [ball.x, ball.diameter].map((v) => Number(v.toFixed(5))))) }, speak("trim.kit"))));
    } else lines.push(make("p", { class: "hint" }, speak("trim.put"), unheld ? speak("trim.seatless") : ""));
  } else say("trim.noroom", speak("trim.noroom.remedy"));
  const rows = [["trim.simulated", simulated, misses.simulated], ["trim.weighed", printed, misses.untrimmed], [ballast < 0 ? "trim.foamed" : "trim.ballasted", printed + Math.max(ballast, 0), misses.trimmed]].filter(([, , miss]) => miss !== undefined);
  lines.push(make("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": speak("trim.table") }, make("table", {},
    make("thead", {}, make("tr", {}, ...["trim.flight", "trim.weight", "trim.miss"].map((key) => make("th", { scope: "col" }, speak(key))))),
    make("tbody", {}, ...rows.map(([key, mass, miss]) => make("tr", {}, make("th", { scope: "row" }, speak(key)), make("td", {}, grams(mass)), make("td", {}, length(miss))))))));
  return lines;
}

export function describeHanging({ lines, misses: { simulated, untrimmed, trimmed } }) {
  const rows = [["trim.simulated", simulated], ["trim.hung", untrimmed], ["trim.puttied", trimmed]].filter(([, miss]) => miss !== undefined);
  return [...lines.map((line) => make("p", {}, line)), make("p", { class: "hint" }, rows.map(([key, miss]) => speak("hang.miss", { case: speak(key), miss: length(miss) })).join(" "))];
}
