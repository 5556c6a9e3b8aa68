// Sets each equation that Markdown marked, by the KaTeX beside this file.
document.addEventListener("DOMContentLoaded", () => {
  for (const equation of document.querySelectorAll(".arithmatex")) {
    const text = equation.textContent.trim().replace(/^\\\[|\\\]$/g, "");
    katex.render(text, equation, { displayMode: true, throwOnError: false });
  }
});
