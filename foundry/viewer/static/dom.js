"use strict";
/* Makes elements. Text becomes text nodes and nothing else, so that what a model wrote can never become markup. */
window.Foundry = window.Foundry || {};

(function (foundry) {
  const UNSEEN = /[\u0000-\u0008\u000b\u000c\u000e-\u001f\u007f-\u009f\u200e\u200f\u202a-\u202e\u2066-\u2069]/g;

  /** Return text with control characters spelt out: they are evidence, and those that turn texts around can deceive. */
  function visible(text) {
    return String(text).replace(UNSEEN, (sign) => `[U+${sign.charCodeAt(0).toString(16).toUpperCase().padStart(4, "0")}]`);
  }

  const PIECE = 256;
  const UNBROKEN = new RegExp(`\\S{${PIECE}}`, "g");

  /** Append text; a long word may break at every piece, since finding its breaks takes time with the square of its length. */
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
    if (Array.isArray(child)) child.forEach((one) => append(element, one));
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

  /** Return a dotted name that may be broken behind dots and underscores. */
  function breakable(name) { return name.split(/(?<=[._])/).map((part, index) => [index ? h("wbr") : null, part]); }

  /** Replace what an element holds. The keyboard's focus stays on what has the same name afterwards. */
  function fill(element, ...children) {
    const focused = document.activeElement, lost = focused !== element && element.contains(focused);
    element.replaceChildren();
    append(element, children);
    if (lost) refocus(element, focused);
    return element;
  }

  function refocus(element, before) {
    const name = (one) => one.getAttribute("aria-label") || one.dataset.sort || one.textContent;
    const same = [...element.querySelectorAll(before.tagName)].find((one) => name(one) === name(before) && !one.disabled);
    if (same) same.focus({preventScroll: true});
  }

  /** Say something to those who listen to the page instead of looking at it. */
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

  /** Empty a canvas for so many CSS pixels, sharp on this screen; returns what draws on it in CSS pixels. */
  function penOf(canvas, width, height) {
    const scale = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
    const pen = canvas.getContext("2d");
    pen.scale(scale, scale);
    return pen;
  }

  /** A word that says how something stands, with a sign, so that colour is never alone. */
  const SIGNS = {
    complete: "✓", failed: "✕", running: "▶", unfinished: "◌", waiting: "…",
    chosen: "✓", repaired: "◆", unreadable: "▼", empty: "▼", truncated: "▼",
  };

  function badge(word) {
    return h("span", {class: `badge is-${word}`}, h("span", {"aria-hidden": "true"}, SIGNS[word] || "•", " "), word);
  }

  /** Texts that are higher than their box can be reached, and then scrolled, by the keyboard; others are no stop on its way. */
  const boxes = new ResizeObserver((changes) => {
    for (const {target} of changes) {
      if (target.scrollHeight > target.clientHeight) target.tabIndex = 0; else target.removeAttribute("tabindex");
    }
  });

  const SHEET = 8192;

  /** Return a long text in sheets that end where lines do: those alone that are in sight are laid out. */
  function sheets(text) {
    const found = [];
    for (let from = 0, to = 0; from < text.length; from = to) {
      to = text.indexOf("\n", from + SHEET) + 1 || text.length;
      found.push(h("div", {class: "sheet"}, text.slice(from, to)));
    }
    return found;
  }

  /** What a model or a person wrote: kept apart from the page's own text, whatever its direction. */
  function quote(text, className = "") {
    const element = h("pre", {class: `quote ${className}`, dir: "auto"}, text === "" ? "(empty)" : text.length > SHEET ? sheets(text) : text);
    boxes.observe(element);
    return element;
  }

  /** A list of keys that can be unfolded: what is pressed, and what it does. */
  function keys(list) {
    return h("details", {class: "keys"}, h("summary", {}, "keys"), h("dl", {}, list.map(([key, what]) => [h("dt", {}, h("kbd", {}, key)), h("dd", {}, what)])));
  }

  /** Return whether a key is not the page's: somebody writes or chooses something, or the browser is meant. */
  function isTyping(event) {
    const field = event.target.closest("input:not([type=checkbox]):not([type=range]), select, textarea");
    return Boolean(field) || event.ctrlKey || event.metaKey || event.altKey;
  }

  /** Return things by what a function says of them, in the order of the first of each. */
  function grouped(things, of) {
    const found = new Map();
    for (const one of things) {
      const key = of(one);
      if (!found.has(key)) found.set(key, []);
      found.get(key).push(one);
    }
    return found;
  }

  foundry.dom = {h, s, fill, breakable, announce, number, color, penOf, badge, quote, keys, isTyping, visible, grouped};
})(window.Foundry);
