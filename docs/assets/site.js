// Whoever uses the keyboard can scroll what is wider than the page, and tell the buttons that copy a block apart.
const WIDE = "pre > code, .md-typeset__scrollwrap, .md-typeset p:has(> img[src$='.svg'])";

function mend() {
  for (const box of document.querySelectorAll(WIDE)) {
    const wide = box.scrollWidth > box.clientWidth;
    // What is as it should be is not written again: each write leads here.
    if (wide !== box.hasAttribute("tabindex")) wide ? (box.tabIndex = 0) : box.removeAttribute("tabindex");
  }
  for (const [number, nav] of document.querySelectorAll(".md-code__nav").entries()) nav.setAttribute("aria-label", `Copy block ${number + 1}`);
}
// Once for all changes before the next picture: the theme makes hundreds, one by one, on a long page.
let due = 0;
function mendSoon() {
  due ||= requestAnimationFrame(() => { due = 0; mend(); });
}
mendSoon();
addEventListener("load", mendSoon);
addEventListener("resize", mendSoon);
// The theme takes the attribute away where no mouse is.
new MutationObserver(mendSoon).observe(document.body, { childList: true, subtree: true, attributeFilter: ["tabindex"] });
