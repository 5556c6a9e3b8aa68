// Sets each equation that Markdown marked, by the KaTeX beside this file.
document.addEventListener("DOMContentLoaded", () => {
  for (const equation of document.querySelectorAll(".arithmatex")) {
    const text = equation.textContent.trim().replace(/^\\\[|\\\]$/g, "");
    katex.render(text, equation, { displayMode: true, throwOnError: false });
  }
  mend();
  new MutationObserver(mend).observe(document.body, { childList: true, subtree: true });
  addEventListener("resize", mend);
});

// What the theme leaves out for those who do not use a mouse, or listen: wide tables, equations and
// pictures can be scrolled by keys, and parts of a contents list or of a block of code are no landmarks.
function mend() {
  for (const one of document.querySelectorAll(".md-typeset__scrollwrap, .arithmatex, .katex-display, article p"))
    if (one.scrollWidth > one.clientWidth) one.tabIndex = 0;
  for (const one of document.querySelectorAll("nav.md-code__nav, .md-nav--secondary nav.md-nav")) {
    one.removeAttribute("aria-label");
    one.setAttribute("role", "none");
  }
}
