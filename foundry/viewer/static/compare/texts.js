"use strict";
/* What each of the compared runs was asked, thought, answered and remembered at a step, with the words that differ marked. */
(function (foundry) {
  const {h, fill, quote} = foundry.dom, {difference, sections, SAME, GONE} = foundry.words;
  const OF_A_DECISION = ["memory", "reasoning", "message_reasoning", "message", "reply"];
  const LONG = 60;

  /** Return a name that no key has yet: what comes again is numbered. */
  function numbered(name, keys) {
    let key = name;
    for (let again = 2; keys.has(key); again += 1) key = `${name} (${again})`;
    return key;
  }

  /** Return the texts of a decision by name: of its calls, then those of its record that are not a call's own. */
  function textsOf({records, calls}) {
    const found = new Map(), questions = new Set(), add = (name, text) => { if (text) found.set(numbered(name, found), text); };
    for (const call of calls) {
      const question = numbered(call.kind, questions);
      questions.add(question);
      (call.messages || []).forEach((one) => add(`${question}: prompt (${one.role})`, one.content));
      add(`${question}: thinking`, call.thinking);
      add(`${question}: reply`, call.text);
    }
    const asked = new Set(found.values());
    for (const record of records) {
      for (const [key, value] of Object.entries(record)) {
        if (typeof value !== "string" || asked.has(value) || !(OF_A_DECISION.includes(key) || (value.length > LONG && /\s/.test(value)))) continue;
        add(records.length > 1 && record.kind ? `${record.kind}: ${key}` : key, value);
      }
    }
    return found;
  }

  /** Return a text's sections by heading; a heading that comes again is told from the first. */
  function byHeading(text) {
    const found = new Map();
    for (const [heading, body] of sections(text)) found.set(numbered(heading, found), body);
    return found;
  }

  function marked(parts) {
    return h("pre", {class: "quote marked", dir: "auto"}, parts.map(([kind, text]) => (kind === SAME ? h("span", {}, text)
      : h(kind === GONE ? "del" : "ins", {}, text))));
  }

  function columns(names, texts) {
    return h("div", {class: "columns"}, texts.map((text, index) => h("div", {class: "told-by"}, h("p", {class: "role"}, names[index]),
      text === undefined ? h("p", {class: "note"}, "It has none.") : index === 0 || texts[0] === undefined ? quote(text) : marked(difference(texts[0], text)))));
  }

  class Texts {
    /** @param names what the runs are called */
    constructor(names) {
      this.all = names;
      this.opened = new Map();
      this.element = h("section", {class: "texts", "aria-label": "Texts, word by word"});
    }

    /** Show the decisions of all runs at one step; those that have none are named, and the first of the others is what these are held against. */
    show(decisions) {
      const has = ({records, calls}) => records.length > 0 || calls.length > 0, missing = this.all.filter((_, index) => !has(decisions[index]));
      this.names = this.all.filter((_, index) => has(decisions[index]));
      const texts = decisions.filter(has).map(textsOf), all = [...new Set(texts.flatMap((one) => [...one.keys()]))];
      fill(this.element, all.length ? [h("h3", {}, "Texts, word by word"), h("p", {class: "note"}, this.names.length > 1
        ? [`Held against ${this.names[0]}: `, h("del", {}, "only there"), ", ", h("ins", {}, "only here"), "."] : null,
      missing.length ? ` No decision of this step: ${missing.join(", ")}.` : null)] : null,
      all.map((name) => this.text(name, texts.map((one) => one.get(name)))));
    }

    clear() { fill(this.element); }

    text(name, texts) {
      const parts = texts.map((text) => (text === undefined ? new Map() : byHeading(text))), headings = [...new Set(parts.flatMap((one) => [...one.keys()]))];
      const inside = () => (headings.length < 2 ? columns(this.names, texts)
        : headings.map((heading) => this.section(name, heading, parts.map((one) => one.get(heading)))));
      return this.fold(name, name, new Set(texts).size > 1, inside);
    }

    section(name, heading, texts) {
      return this.fold(`${name}/${heading}`, heading || "before the first heading", new Set(texts).size > 1, () => columns(this.names, texts));
    }

    /** Return a fold, open where the texts differ unless somebody said otherwise; what it holds is made when it is opened. */
    fold(key, title, differs, inside) {
      const box = h("div"), element = h("details", {class: "call", "data-text": key},
        h("summary", {}, h("b", {}, h("bdi", {}, title)), differs ? " · differs" : " · the same in all"), box);
      const make = () => { if (!box.firstChild) fill(box, inside()); };
      element.open = this.opened.get(key) ?? differs;
      if (element.open) make();
      element.firstChild.addEventListener("click", () => {
        this.opened.set(key, !element.open);
        make();
      });
      return element;
    }
  }

  foundry.Texts = Texts;
})(window.Foundry);
