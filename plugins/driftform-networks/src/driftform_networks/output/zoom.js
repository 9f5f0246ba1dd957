// Maps zoom with the wheel or + and -, move with the mouse or the arrow keys, and return with a double click or 0.
for (const svg of document.querySelectorAll(".map svg")) {
  const whole = svg.getAttribute("viewBox").split(" ").map(Number);
  let [x, y, w, h] = whole, held = null;
  const show = () => svg.setAttribute("viewBox", [x, y, w, h].join(" "));
  const zoom = (factor, px, py) => {
    const next = Math.min(Math.max(w * factor, whole[2] / 200), whole[2]) / w;
    x += (w - w * next) * px; y += (h - h * next) * py; w *= next; h *= next;
    // What is near keeps its size on the screen, as on a road map.
    const size = Math.sqrt(w / whole[2]);
    svg.querySelectorAll(".link").forEach(line => {
      line.dataset.width ??= line.getAttribute("stroke-width");
      line.setAttribute("stroke-width", line.dataset.width * size);
    });
    svg.querySelectorAll("text").forEach(text => {
      text.dataset.size ??= text.getAttribute("font-size");
      text.setAttribute("font-size", text.dataset.size * size);
    });
    show();
  };
  const move = (dx, dy) => { x += dx * w; y += dy * h; show(); };
  const place = event => {
    const box = svg.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };
  svg.addEventListener("wheel", event => {
    event.preventDefault();
    zoom(event.deltaY > 0 ? 1.25 : 0.8, ...place(event));
  }, { passive: false });
  svg.addEventListener("pointerdown", event => { held = place(event); svg.setPointerCapture(event.pointerId); });
  svg.addEventListener("pointermove", event => {
    if (!held) return;
    const now = place(event);
    move(held[0] - now[0], held[1] - now[1]);
    held = now;
  });
  svg.addEventListener("pointerup", () => { held = null; });
  const back = () => { [x, y, w, h] = whole; zoom(1, 0, 0); };
  svg.addEventListener("dblclick", back);
  svg.parentElement.addEventListener("keydown", event => {
    const keys = {
      "+": () => zoom(0.8, 0.5, 0.5), "-": () => zoom(1.25, 0.5, 0.5), "0": back,
      ArrowLeft: () => move(-0.1, 0), ArrowRight: () => move(0.1, 0), ArrowUp: () => move(0, -0.1), ArrowDown: () => move(0, 0.1),
    };
    if (keys[event.key]) { keys[event.key](); event.preventDefault(); }
  });
}
