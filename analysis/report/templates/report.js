"use strict";
// Sorts a table by the column whose head is clicked: numbers by value, other cells as text, undefined values last.
function valueOf(row, index) {
  const text = row.cells[index].textContent.trim();
  const plain = text.replaceAll(",", "").replace("\u2212", "-");
  const match = plain.match(/^<?(-?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)(?=$|[\s%\[])/i);
  return { text, number: match ? Number(match[1]) : NaN, missing: text === "-" || text === "" };
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
  table.tBodies[0].append(...rows.map((pair) => pair.row));
  for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", falling ? "descending" : "ascending");
}

// Saves a figure as PNG with 300 dots per inch, or prints only this figure; a browser can print it to PDF.
function size(card) {
  const drawn = card.querySelector("svg");
  return drawn ? [parseFloat(drawn.getAttribute("width")), parseFloat(drawn.getAttribute("height"))] : [card.naturalWidth * 72 / 300, card.naturalHeight * 72 / 300];
}

function savePng(card, name) {
  const picture = new Image(), drawn = card.querySelector("svg"), [width, height] = size(card);
  picture.onload = () => {
    const canvas = document.createElement("canvas");
    canvas.width = Math.round(width * 300 / 72);
    canvas.height = Math.round(height * 300 / 72);
    const pen = canvas.getContext("2d");
    pen.fillStyle = "white";
    pen.fillRect(0, 0, canvas.width, canvas.height);
    pen.drawImage(picture, 0, 0, canvas.width, canvas.height);
    const link = document.createElement("a");
    link.download = `${name}.png`;
    link.href = canvas.toDataURL("image/png");
    link.click();
  };
  picture.src = drawn ? `data:image/svg+xml;charset=utf-8,${encodeURIComponent(new XMLSerializer().serializeToString(drawn))}` : card.src;
}

function printAlone(figure) {
  const page = document.createElement("style"), [width, height] = size(figure.querySelector(".card"));
  page.textContent = `@page { size: ${width + 8}pt ${height + 16}pt; margin: 4pt; }`;
  document.head.append(page);
  document.body.classList.add("alone");
  figure.classList.add("printed");
  window.print();
  document.body.classList.remove("alone");
  figure.classList.remove("printed");
  page.remove();
}

for (const files of document.querySelectorAll(".files")) {
  const figure = files.closest("figure");
  for (const [text, press] of [["PDF", () => printAlone(figure)], ["PNG", () => savePng(figure.querySelector(".card"), files.dataset.name)]]) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = text;
    button.addEventListener("click", press);
    files.append(button);
  }
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

// If the viewer serves the report, it can also compare the runs of an example moment.
const served = location.protocol.startsWith("http") && location.pathname.match(/^(.*\/)files\/([^/]+)\/[^/]+$/);
for (const way of served ? document.querySelectorAll("a.compared") : []) {
  way.href = `${served[1]}#/compare/${served[2]}/${way.dataset.runs}`;
  way.hidden = false;
}
