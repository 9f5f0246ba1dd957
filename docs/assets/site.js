// Whoever uses the keyboard can scroll what is wider than the page, and tell the buttons that copy a block apart.
const WIDE = "pre > code, .md-typeset__scrollwrap, .md-typeset p:has(> img[src$='.svg'])";

function mend() {
  for (const box of document.querySelectorAll(WIDE))
    if (box.scrollWidth > box.clientWidth) box.tabIndex = 0;
    else box.removeAttribute("tabindex");
  for (const [number, nav] of document.querySelectorAll(".md-code__nav").entries()) nav.setAttribute("aria-label", `Copy block ${number + 1}`);
}
mend();
addEventListener("load", mend);
addEventListener("resize", mend);
new MutationObserver(mend).observe(document.body, { childList: true, subtree: true });
