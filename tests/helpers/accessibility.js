const done = arguments[0], drawn = () => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve, 50)));
const settled = () => Promise.allSettled(
  document.getAnimations().filter((a) => a instanceof CSSTransition).map((a) => a.finished));
const search = () => axe.run(document, { resultTypes: ["violations"] });
drawn().then(drawn).then(settled).then(search).then(({ violations }) => done(violations.flatMap(
  ({ id, nodes }) => nodes.map(({ target, html }) => `${id} at ${target.join(" ")}: ${html.slice(0, 100)}`))));
