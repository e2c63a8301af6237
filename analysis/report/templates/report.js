"use strict";
// Sorts a table by the column whose head is pressed: numbers by value, the rest as text, what is undefined last.
function valueOf(row, index) {
  const text = row.cells[index].textContent.trim();
  const plain = text.replaceAll(",", "").replace("\u2212", "-");
  const found = plain.match(/^<?(-?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)(?=$|[\s%\[])/i);
  return { text, number: found ? Number(found[1]) : NaN, missing: text === "-" || text === "" };
}

function compare(a, b) {
  if (!Number.isNaN(a.number) && !Number.isNaN(b.number)) return a.number - b.number;
  return a.text.localeCompare(b.text, "en", { numeric: true });
}

function sortBy(table, head, index) {
  const falling = head.getAttribute("aria-sort") === "ascending";
  const rows = Array.from(table.tBodies[0].rows, (row) => ({ row, value: valueOf(row, index) }));
  rows.sort((a, b) => {
    if (a.value.missing !== b.value.missing) return a.value.missing ? 1 : -1;
    return falling ? compare(b.value, a.value) : compare(a.value, b.value);
  });
  table.tBodies[0].append(...rows.map((one) => one.row));
  for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", falling ? "descending" : "ascending");
}

for (const table of document.querySelectorAll("table")) {
  if (table.tBodies[0].rows.length < 2) continue;
  Array.from(table.tHead.rows[0].cells).forEach((head, index) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    button.addEventListener("click", () => sortBy(table, head, index));
    head.replaceChildren(button);
  });
}
