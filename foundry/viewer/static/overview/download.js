"use strict";
/* Saves the visible rows and columns as a CSV file. */
(function (foundry) {
  const {h} = foundry.dom;

  /** Return a text with an apostrophe if a spreadsheet would run it as a formula; numbers do not change. */
  function cell(text) { return /^'*[=+\-@\t\r][^]/.test(text) && Number.isNaN(Number(text)) ? `'${text}` : text; }

  function quoted(value) {
    const text = cell(value === null || value === undefined ? "" : String(value));
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  }

  /** Return rows as CSV after RFC 4180, numbers in full. */
  function csv(columns, rows) {
    const lines = [columns.map((column) => column.key), ...rows.map((row) => columns.map((column) => column.value(row)))];
    return lines.map((line) => `${line.map(quoted).join(",")}\r\n`).join("");
  }

  function saveBlob(blob, name) {
    const address = URL.createObjectURL(blob);
    h("a", {href: address, download: name}).click();
    setTimeout(() => URL.revokeObjectURL(address), 10000);
  }

  /** Return a mask of runs as URL-safe base64: one bit per run, set if the run is among the rows; the highest bit of a byte is first. */
  function mask(rows, runs) {
    const bytes = new Uint8Array(Math.ceil(runs / 8));
    rows.forEach(({index}) => { bytes[index >> 3] |= 128 >> (index & 7); });
    return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join("")).replaceAll("+", "-").replaceAll("/", "_");
  }

  foundry.download = {
    textOf: csv,
    mask,
    csv: (sweep, columns, rows) => saveBlob(new Blob([csv(columns, rows)], {type: "text/csv"}), `${sweep}.csv`),
  };
})(window.Foundry);
