"use strict";
/* Shows one question after the other and sends the answer that the person gives. */
(function (foundry) {
  const {h, fill, announce} = foundry.dom;
  const main = document.getElementById("main"), bar = document.getElementById("standing");
  const HEADING = /^\s*(?:=+\s*(.+?)\s*=+|#{1,4}\s+(.+?))\s*$/;
  const leftOpen = new Set();  // answers that a person confirmed after a warning, so that the page does not warn again in the same case
  let shown = null;

  async function post(what, value = {}) {
    const reply = await fetch(what, {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(value)});
    if (!reply.ok) throw new Error((await reply.json()).error);
  }

  /** Return a prompt as elements. A heading becomes an element with this tag; other lines stay as they are. */
  function read(text, tag) {
    const parts = [];
    let lines = [];
    const close = () => {
      const said = lines.join("\n").replace(/^\n+|\n+$/g, "");
      if (said) parts.push(h("pre", {class: "said", dir: "auto"}, said));
      lines = [];
    };
    for (const line of text.split("\n")) {
      const heading = HEADING.exec(line);
      if (!heading) { lines.push(line); continue; }
      close();
      parts.push(h(tag, {}, heading[1] || heading[2]));
    }
    close();
    return parts;
  }

  function picture(data) {
    const type = data.startsWith("/9j/") ? "jpeg" : "png";
    return h("img", {src: `data:image/${type};base64,${data}`, alt: "What you see"});
  }

  function prompt(question) {
    const several = question.messages.length > 1;
    return question.messages.map((message) => [
      several ? h("h2", {}, message.role) : null, message.images.map(picture), read(message.content, several ? "h3" : "h2"),
    ]);
  }

  class Question {
    constructor(question) {
      this.number = question.number;
      this.sending = this.asked = false;
      this.fields = new foundry.Fields(question.schema, () => this.preview());
      this.raw = h("textarea", {rows: 3, dir: "auto", "aria-label": "The reply as text", oninput: () => this.preview()});
      this.said = h("p", {class: "preview", "aria-live": "polite"});
      this.problem = h("p", {class: "warning", role: "alert", hidden: true});
      this.form = h("form", {class: "answer", onsubmit: (event) => this.send(event), novalidate: true},
        this.fields.elements,
        question.schema?.type === "object" ? h("details", {}, h("summary", {}, "Write the reply as text instead"), this.raw) : null,
        this.said, this.problem,
        h("div", {class: "controls"},
          h("button", {class: "button", type: "submit"}, "Send ", h("kbd", {}, "Enter")),
          h("button", {type: "button", onclick: () => this.undo()}, "Clear ", h("kbd", {}, "Esc"))));
      this.element = h("div", {class: "asked-now"},
        h("article", {class: "prompt", tabindex: "0"}, h("h1", {class: "unseen"}, `Question to ${question.person}`), prompt(question)), this.form);
      this.preview();
    }

    text() { return this.raw.value.trim() ? this.raw.value : this.fields.text(); }

    isEmpty() { return !this.raw.value.trim() && this.fields.isEmpty(); }

    preview() {
      this.asked = false;
      this.tell("");
      fill(this.said, this.isEmpty() ? "You have not chosen anything yet." : ["You answer: ", h("code", {dir: "auto"}, this.text())]);
    }

    tell(text) { fill(this.problem, text); this.problem.hidden = !text; }

    undo() {
      this.form.reset();
      this.preview();
      main.focus({preventScroll: true});
    }

    async send(event) {
      event.preventDefault();
      if (this.sending) return;
      const missing = this.raw.value.trim() ? null : this.fields.missing();
      const invalid = this.raw.value.trim() ? null : this.form.querySelector("input:invalid");
      if (missing) { this.tell(`Please choose: ${missing}.`); return; }
      if (invalid) { this.tell(invalid.validationMessage); return; }
      const open = this.raw.value.trim() ? {names: []} : this.fields.open();
      const doubt = this.isEmpty() ? "The answer is empty." : open.names.length && !leftOpen.has(open.beside) ? `These fields are empty: ${open.names.join(", ")}.` : null;
      if (doubt && !this.asked) { this.asked = true; this.tell(`${doubt} Press Enter again to send it anyway.`); return; }
      this.sending = true;
      try { await post("answer", {number: this.number, text: this.text()}); leftOpen.add(open.beside); }
      catch (error) { this.tell(error.message); this.sending = false; }
    }
  }

  function agree(now) {
    const button = h("button", {class: "button", type: "button"}, "I agree, begin ", h("kbd", {}, "Enter"));
    button.addEventListener("click", async () => { button.disabled = true; await post("agree"); run(0); });
    fill(main, h("section", {class: "consent"}, h("h1", {}, "Before you begin"), now.told.split("\n").map((line) => h("p", {}, line)), button));
    button.focus();
  }

  /**
   * Return the progress: the number of answers and of questions that wait. If only one question waits at a time, the
   * finished share of the session stands instead, as the command reports it.
   */
  function progress({question, answered, waiting, far}) {
    const share = waiting > 1 ? answered / (answered + waiting) : far;
    const left = waiting > 1 ? `, ${waiting} left` : far === null ? "" : `, ${Math.floor(100 * far)} % of the session done`;
    return [`${question ? `${question.person}: ` : ""}${answered} answered${left} `,
      share === null ? null : h("progress", {max: 1, value: share, "aria-label": "Progress"})];
  }

  function show(now) {
    const {question, over} = now;
    fill(bar, progress(now));
    document.getElementById("leave").hidden = over;
    if (over) {
      shown = null;
      fill(main, h("section", {class: "consent"}, h("h1", {}, "That is all for now"), h("p", {}, "Thank you. Your answers are saved. You can close this page.")));
    } else if (!question) {
      shown = null;
      fill(main, h("p", {class: "note"}, "Please wait. The next question will appear here."));
    } else if (!shown || shown.number !== question.number) {
      shown = new Question(question);
      fill(main, shown.element);
      window.scrollTo(0, 0);
      const first = shown.fields.byKey.size ? main : shown.form.querySelector("input, textarea");
      first.focus({preventScroll: true});
      announce(`Question ${question.number}`);
    }
  }

  async function run(after) {
    for (;;) {
      const now = await (await fetch(`now?after=${after}`)).json();
      if (!now.agreed && !now.over) { agree(now); return; }
      show(now);
      if (now.over) return;
      after = now.version;
    }
  }

  function start() {
    run(0).catch(() => {
      shown = null;
      fill(main, h("p", {class: "warning", role: "alert"}, "The command that served this page has ended. Your sent answers are saved. To continue, start the command again."));
    });
  }

  function isTyping(target) { return target.tagName === "TEXTAREA" || (target.tagName === "INPUT" && target.type !== "radio"); }

  document.addEventListener("keydown", (event) => {
    if (!shown || event.ctrlKey || event.metaKey || event.altKey || event.isComposing) return;
    if (event.key === "Escape") { shown.undo(); event.preventDefault(); return; }
    const inAnother = event.target.closest("button, summary, a");
    if (event.key === "Enter" && !event.shiftKey && !inAnother) { event.preventDefault(); if (!event.repeat) shown.form.requestSubmit(); return; }
    if (!isTyping(event.target) && !event.repeat && shown.fields.press(event.key)) event.preventDefault();
  });
  document.getElementById("leave").addEventListener("click", () => post("leave").catch(() => {}));
  start();
})(window.Foundry);
