// Tables: a click on a heading sorts, a button copies them as tab-separated text.
const value = (cell) => {
  const text = cell.textContent.trim().replaceAll(",", "").replace("−", "-");
  const number = parseFloat(text.replace(/^[<>±▼▲\s]+/, ""));
  return /^[<>±▼▲\s]*-?\d/.test(text) ? number : text === "–" || text === "" ? Infinity : text;
};
const compare = (a, b) => (typeof a === typeof b ? (a < b ? -1 : a > b ? 1 : 0) : typeof a === "number" ? -1 : 1);
for (const table of document.querySelectorAll(".scroll table")) {
  const body = table.tBodies[0];
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, i) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach((one) => one.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const rows = [...body.rows].sort((a, b) => compare(value(a.cells[i]), value(b.cells[i])) * (down ? -1 : 1));
      body.append(...rows);
    });
  });
  const copy = document.createElement("button");
  copy.type = "button";
  copy.className = "copy";
  copy.textContent = "Copy";
  copy.addEventListener("click", async () => {
    const lines = [...table.rows].map((row) => [...row.cells].map((cell) => cell.textContent.trim().replaceAll("\u200b", "")).join("\t"));
    await navigator.clipboard.writeText(lines.join("\n"));
    copy.textContent = "Copied";
    setTimeout(() => (copy.textContent = "Copy"), 1500);
  });
  table.caption.prepend(copy);
}
document.querySelector(".above")?.addEventListener("click", (event) => {
  if (event.target.closest("a")) event.currentTarget.querySelector("details").open = false;
});
