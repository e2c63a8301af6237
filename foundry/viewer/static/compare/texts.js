"use strict";
/* Shows the texts of compared runs at a step that differ, with the differing words marked. */
(function (foundry) {
  const {h, fill, quote} = foundry.dom, {difference, sections, SAME, GONE, NEW} = foundry.words;
  const OF_A_DECISION = ["memory", "reasoning", "message_reasoning", "message", "reply"];
  const LONG = 60, REPLY = /: reply/;

  /** Return a name that is not yet a key; a repeated name gets a number. */
  function numbered(name, keys) {
    let key = name;
    for (let again = 2; keys.has(key); again += 1) key = `${name} (${again})`;
    return key;
  }

  /** Return the texts of a decision by name: the texts of its calls, then other texts in its record. */
  function textsOf({records, calls}) {
    const texts = new Map(), questions = new Set(), add = (name, text) => { if (text) texts.set(numbered(name, texts), text); };
    for (const call of calls) {
      const question = numbered(call.kind, questions);
      questions.add(question);
      (call.messages || []).forEach((message) => add(`${question}: prompt (${message.role})`, message.content));
      add(`${question}: thinking`, call.thinking);
      add(`${question}: reply`, call.text);
    }
    const asked = new Set(texts.values());
    for (const record of records) {
      for (const [key, value] of Object.entries(record)) {
        if (typeof value !== "string" || asked.has(value) || !(OF_A_DECISION.includes(key) || (value.length > LONG && /\s/.test(value)))) continue;
        add(records.length > 1 && record.kind ? `${record.kind}: ${key}` : key, value);
      }
    }
    return texts;
  }

  /** Return the sections of a text by heading; a repeated heading gets a number. */
  function byHeading(text) {
    const bodies = new Map();
    for (const [heading, body] of sections(text)) bodies.set(numbered(heading, bodies), body);
    return bodies;
  }

  /** Return one of two texts, with the words marked that are missing in the other text. */
  function marked(parts, own) {
    return h("pre", {class: "quote marked", dir: "auto"}, parts.filter(([kind]) => kind === SAME || kind === own)
      .map(([kind, text]) => (kind === SAME ? h("span", {}, text) : h("mark", {}, text))));
  }

  /** Return a text, with the words marked that the first text lacks. In the first of two texts, mark the words that the second lacks. */
  function held(texts, index) {
    const [first] = texts, other = index ? first : texts.length === 2 ? texts[1] : undefined;
    if (other === undefined) return quote(texts[index]);
    return index ? marked(difference(first, texts[index]), NEW) : marked(difference(first, other), GONE);
  }

  function columns(names, texts) {
    return h("div", {class: "columns"}, texts.map((text, index) => h("div", {class: "told-by"}, h("p", {class: "role"}, h("bdi", {}, names[index])),
      text === undefined ? h("p", {class: "note"}, "This run has no such text.") : held(texts, index))));
  }

  class Texts {
    /** @param names the names of the runs */
    constructor(names) {
      this.all = names;
      this.opened = new Set();
      this.replies = h("section", {class: "replies", "aria-label": "Replies"});
      this.element = h("section", {class: "texts", "aria-label": "Other texts that differ"});
    }

    /**
     * Show the decisions of all runs at a step. Runs without a decision are named. The texts of the first other run are compared with the texts of the rest.
     * @param kind the kind of question whose replies are shown on top; null for all kinds
     */
    show(decisions, kind) {
      const has = ({records, calls}) => records.length > 0 || calls.length > 0, missing = this.all.filter((_, index) => !has(decisions[index]));
      this.names = this.all.filter((_, index) => has(decisions[index]));
      const texts = decisions.filter(has).map(textsOf), all = [...new Set(texts.flatMap((text) => [...text.keys()]))];
      const of = (name) => texts.map((text) => text.get(name)), isReply = (name) => REPLY.test(name) && (kind === null || name.startsWith(`${kind}:`));
      const replies = all.filter(isReply), others = all.filter((name) => !isReply(name) && new Set(of(name)).size > 1);
      fill(this.replies, missing.length ? h("p", {class: "note"}, `No decision at this step: ${missing.join(", ")}.`) : null,
        replies.map((name) => h("div", {"data-text": name}, replies.length > 1 ? h("p", {class: "role"}, h("bdi", {}, name)) : null, columns(this.names, of(name)))));
      fill(this.element, others.length ? h("h2", {}, "Other differences at this step") : null, others.map((name) => this.text(name, of(name))));
    }

    clear() { fill(this.replies); fill(this.element); }

    text(name, texts) {
      const parts = texts.map((text) => (text === undefined ? new Map() : byHeading(text))), headings = [...new Set(parts.flatMap((part) => [...part.keys()]))];
      const of = (heading) => parts.map((part) => part.get(heading)), differing = headings.filter((heading) => new Set(of(heading)).size > 1);
      return this.fold(name, () => (headings.length < 2 ? columns(this.names, texts)
        : differing.map((heading) => [h("h3", {}, h("bdi", {}, heading || "before the first heading")), columns(this.names, of(heading))])));
    }

    /**
     * Return a folded section that stays open from step to step once the user has opened it. Its content is made when it
     * opens.
     */
    fold(name, inside) {
      const box = h("div"), element = h("details", {class: "call", "data-text": name}, h("summary", {}, h("b", {}, h("bdi", {}, name))), box);
      element.open = this.opened.has(name);
      if (element.open) fill(box, inside());
      element.firstChild.addEventListener("click", () => {
        if (element.open) this.opened.delete(name); else this.opened.add(name);
        if (!box.firstChild) fill(box, inside());
      });
      return element;
    }
  }

  foundry.Texts = Texts;
})(window.Foundry);
