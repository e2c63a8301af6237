"use strict";
/* Makes elements. A text always becomes a text node, so that a text of a model can never become markup. */
window.Foundry = window.Foundry || {};

(function (foundry) {
  const UNSEEN = /[\u0000-\u0008\u000b\u000c\u000e-\u001f\u007f-\u009f\u200e\u200f\u202a-\u202e\u2066-\u2069]/g;

  /**
   * Return text with visible names for control characters, because these are evidence, and some of them change the order
   * of a text.
   */
  function visible(text) {
    return String(text).replace(UNSEEN, (sign) => `[U+${sign.charCodeAt(0).toString(16).toUpperCase().padStart(4, "0")}]`);
  }

  const PIECE = 256;
  const UNBROKEN = new RegExp(`\\S{${PIECE}}`, "g");

  /**
   * Append text. A long word may break at every piece, because finding the best breaks takes time with the square of its
   * length.
   */
  function appendText(element, text) {
    text.replace(UNBROKEN, (piece) => `${piece}\u0000`).split("\u0000").forEach((part, index) => {
      if (index) element.appendChild(document.createElement("wbr"));
      element.appendChild(document.createTextNode(part));
    });
  }

  function setAttribute(element, name, value) {
    if (value === null || value === undefined || value === false) return;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "value" || name === "checked" || name === "disabled" || name === "selected") element[name] = value;
    else element.setAttribute(name, value === true ? "" : String(value));
  }

  function append(element, child) {
    if (child === null || child === undefined || child === false) return;
    if (Array.isArray(child)) child.forEach((item) => append(element, item));
    else if (child instanceof Node) element.appendChild(child);
    else appendText(element, visible(child));
  }

  /** Return an element: h("p", {class: "note"}, "text", otherElement). */
  function h(tag, attributes, ...children) {
    return furnished(document.createElement(tag), attributes, children);
  }

  /** Return an element of a drawing: s("circle", {r: 4}). */
  function s(tag, attributes, ...children) {
    return furnished(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
  }

  function furnished(element, attributes, children) {
    for (const [name, value] of Object.entries(attributes || {})) setAttribute(element, name, value);
    append(element, children);
    return element;
  }

  /** Return a dotted name that may break after dots and underscores. */
  function breakable(name) { return name.split(/(?<=[._])/).map((part, index) => [index ? h("wbr") : null, part]); }

  /** Replace the content of an element. If the focused element goes, the new element with the same name gets the focus. */
  function fill(element, ...children) {
    const focused = document.activeElement, lost = focused !== element && element.contains(focused);
    element.replaceChildren();
    append(element, children);
    if (lost) refocus(element, focused);
    return element;
  }

  function refocus(element, before) {
    const name = (node) => node.getAttribute("aria-label") || node.dataset.sort || node.textContent;
    const same = [...element.querySelectorAll(before.tagName)].find((node) => name(node) === name(before) && !node.disabled);
    if (same) same.focus({preventScroll: true});
  }

  /** Announce a text to users of screen readers. */
  function announce(text) {
    document.getElementById("announcer").textContent = text;
  }

  function number(value, digits = 3) {
    if (value === null || value === undefined) return "–";
    if (Number.isInteger(value)) return value.toLocaleString("en");
    return Math.abs(value) >= 1000 ? Math.round(value).toLocaleString("en") : String(Number(value.toPrecision(digits)));
  }

  function color(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  }

  /** Clear a canvas of this size in CSS pixels, and make it sharp on this screen; return a context that draws in CSS pixels. */
  function penOf(canvas, width, height) {
    const scale = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
    const pen = canvas.getContext("2d");
    pen.scale(scale, scale);
    return pen;
  }

  /** Return a function that draws in the next frame. A new size of the element, or light and dark colours, also let it draw. */
  function redrawn(element, draw) {
    let waiting = false;
    const redraw = () => {
      if (waiting) return;
      waiting = true;
      requestAnimationFrame(() => { waiting = false; draw(); });
    };
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
    new ResizeObserver(redraw).observe(element);
    return redraw;
  }

  /**
   * Draw a line through values, with a gap for each missing value. The ends of the line are extended by `stub` CSS pixels,
   * so that a single value can be seen.
   */
  function polyline(pen, values, x, y, stub) {
    const isThere = (at) => values[at] !== null && values[at] !== undefined;
    pen.beginPath();
    values.forEach((value, at) => {
      if (!isThere(at)) return;
      if (isThere(at - 1)) pen.lineTo(x(at), y(value)); else pen.moveTo(x(at) - stub, y(value));
      pen.lineTo(x(at) + (isThere(at + 1) ? 0 : stub), y(value));
    });
    pen.stroke();
  }

  /** Signs of the words for a status, so that these differ not only by colour. */
  const SIGNS = {
    complete: "✓", failed: "✕", running: "▶", unfinished: "◌", waiting: "…",
    chosen: "✓", repaired: "◆", unreadable: "▼", empty: "▼", truncated: "▼",
  };

  function badge(word) {
    return h("span", {class: `badge is-${word}`}, h("span", {"aria-hidden": "true"}, SIGNS[word] || "•", " "), word);
  }

  /** Let the keyboard reach and scroll texts that are higher than their box, and only those. */
  const boxes = new ResizeObserver((changes) => {
    for (const {target} of changes) {
      if (target.scrollHeight > target.clientHeight) target.tabIndex = 0; else target.removeAttribute("tabindex");
    }
  });

  const SHEET = 8192;

  /** Return a long text in pieces that end at line ends. The browser lays out only the visible pieces. */
  function sheets(text) {
    const pieces = [];
    for (let from = 0, to = 0; from < text.length; from = to) {
      to = text.indexOf("\n", from + SHEET) + 1 || text.length;
      pieces.push(h("div", {class: "sheet"}, text.slice(from, to)));
    }
    return pieces;
  }

  /** A text of a model or a person: isolated from the page's own text, whatever its direction. */
  function quote(text, className = "") {
    const element = h("pre", {class: `quote ${className}`, dir: "auto"}, text === "" ? "(empty)" : text.length > SHEET ? sheets(text) : text);
    boxes.observe(element);
    return element;
  }

  /** A list of keys and their effects, which the user can open. */
  function keys(list) {
    return h("details", {class: "keys"}, h("summary", {}, "keys"), h("dl", {}, list.map(([key, what]) => [h("dt", {}, h("kbd", {}, key)), h("dd", {}, what)])));
  }

  /** Return whether the page must ignore a key: the user types or chooses something, or the key is one of the browser's. */
  function isTyping(event) {
    const field = event.target.closest("input:not([type=checkbox]):not([type=range]), select, textarea");
    return Boolean(field) || event.ctrlKey || event.metaKey || event.altKey;
  }

  /** Group items by the value of a function, in the order of the first item of each group. */
  function grouped(things, of) {
    const groups = new Map();
    for (const thing of things) {
      const key = of(thing);
      if (!groups.has(key)) groups.set(key, []);
      groups.get(key).push(thing);
    }
    return groups;
  }

  foundry.dom = {h, s, fill, breakable, announce, number, color, penOf, redrawn, polyline, badge, quote, keys, isTyping, visible, grouped};
})(window.Foundry);
