const channel = (v) => (v /= 255, v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
const parse = (text) => (text.match(/[\d.]+/g) ?? [0, 0, 0, 0]).map(Number);
const ratio = (a, b) => { const [x, y] = [light(a), light(b)].sort((p, q) => q - p); return (x + 0.05) / (y + 0.05); };
const behind = (e) => {
  for (; e; e = e.parentElement) {
    const [r, g, b, a = 1] = parse(getComputedStyle(e).backgroundColor);
    if (a > 0.5) return [r, g, b];
  }
  return [255, 255, 255];
};
const found = [];
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
for (let node = walker.nextNode(); node; node = walker.nextNode()) {
  const e = node.parentElement, style = getComputedStyle(e);
  if (!node.textContent.trim() || !e.getClientRects().length || style.visibility === "hidden" || e.closest("script, style, defs")) continue;
  const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
  const inSvg = e.namespaceURI.endsWith("svg");
  const bore = document.querySelector("#side .bore");
  const backs = inSvg ? [behind(e.closest("svg").parentElement), ...(bore ? [parse(getComputedStyle(bore).fill)] : [])] : [behind(e)];
  const value = Math.min(...backs.map((back) => ratio(parse(inSvg ? style.fill : style.color), back)));
  if (value < (large ? 3 : 4.5)) found.push(`${value.toFixed(2)} ${e.tagName} ${e.id || e.className.baseVal || e.className} '${node.textContent.trim().slice(0, 30)}'`);
}
for (const input of document.querySelectorAll("input:not([type=range]):not([type=checkbox]), select")) {
  if (!input.getClientRects().length) continue;
  const style = getComputedStyle(input), edge = ratio(parse(style.borderTopColor), behind(input.parentElement));
  if (ratio(parse(style.color), parse(style.backgroundColor)) < 4.5) found.push(`text of ${input.outerHTML}`);
  if (edge < 3) found.push(`edge of ${input.outerHTML}: ${edge.toFixed(2)}`);
}
return [...new Set(found)];
