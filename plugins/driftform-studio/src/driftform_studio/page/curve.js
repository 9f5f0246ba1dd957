// The best error so far of each target, by flights, on a logarithmic scale.
import { speak } from "./messages.js";
import { colour, draw } from "./parts.js";

export function drawCurve(svg, { targets, done: extent, budget }) {
  const [width, height] = [svg.clientWidth || 300, svg.clientHeight || 150];
  const [left, right, top, bottom] = [46, 10, 12, 22];
  const values = targets.flatMap((t) => t.curve).filter((v) => v !== null);
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.replaceChildren();
  if (!values.length) return;
  const low = Math.floor(Math.log10(Math.max(1e-3, Math.min(...values))));
  const high = Math.max(low + 1, Math.ceil(Math.log10(Math.max(1e-2, ...values))));
  const x = (flights) => left + (flights / Math.max(budget, extent)) * (width - left - right);
  const y = (error) => top + ((high - Math.log10(Math.max(10 ** low, error))) / (high - low)) * (height - top - bottom);
  for (let power = low; power <= high; power++)
    svg.append(draw("line", { x1: left, x2: width - right, y1: y(10 ** power), y2: y(10 ** power) }),
      draw("text", { x: left - 6, y: y(10 ** power) + 4, "text-anchor": "end" }, `${Number((10 ** power).toPrecision(1))} %`));
  svg.append(draw("text", { x: left, y: height - 5 }, "0"), draw("text", { x: width - right, y: height - 5, "text-anchor": "end" }, speak("curve.flights", { count: Math.max(budget, extent) })));
  targets.forEach(({ curve }, number) => {
    const points = curve.map((error, i) => (error === null ? null : [x(((i + 1) * extent) / curve.length), y(error)])).filter(Boolean);
    if (points.length) svg.append(draw("path", { d: "M" + points.map((p) => p.map((v) => v.toFixed(1)).join(" ")).join("L"), stroke: colour(number) }));
  });
}
