"use strict";
/* Shows one moment of a probe: the observation, the prompt, and the answers of each model, before and after an edit. */
(function (foundry) {
  const {h, fill, quote} = foundry.dom;
  const drawing = foundry.perceived = {};

  /** Return a value as a text. Numbers have at most six digits. */
  function worded(value) {
    if (typeof value === "number") return String(Number(value.toPrecision(6)));
    return typeof value === "string" ? value : value !== null && typeof value === "object" ? "none" : String(value);
  }

  /** Return all values of an observation with their paths, as in ["fires[0].x", 3]. Empty lists and objects count as values. */
  function lines(value, path = "") {
    if (value !== null && typeof value === "object" && Object.keys(value).length) {
      return Object.entries(value).flatMap(([key, inner]) => lines(inner, Array.isArray(value) ? `${path}[${key}]` : path ? `${path}.${key}` : key));
    }
    return [[path, value]];
  }

  class MomentView {
    /** @param looks the colour and mark of each model of the probe */
    constructor(sweep, probe, looks) {
      this.address = `probe/${sweep}`;
      this.probe = probe;
      this.looks = looks;
      this.urls = [];
      this.element = h("section", {class: "moment", "aria-label": "The moment"});
    }

    dispose() { this.turn = -1; this.free(); }

    free() { this.urls.splice(0).forEach((url) => URL.revokeObjectURL(url)); }

    say(text) { this.turn = (this.turn || 0) + 1; fill(this.element, h("p", {class: "note"}, text)); }

    /** Show a moment before and after an edit, or, for edit 0, without an edit. */
    async show(moment, {edit, format, gist}) {
      const mine = this.turn = (this.turn || 0) + 1;
      try {
        const seen = await foundry.source.json(`${this.address}/moment/${moment.index}`);
        if (seen.script) await foundry.script(seen.script);
        if (mine !== this.turn) return;
        this.free();
        fill(this.element, this.head(moment, gist), this.pictures(moment, seen, edit), this.changes(seen, edit),
          this.answers(seen, edit, format), this.prompts(seen, edit, format));
      } catch (error) {
        if (mine === this.turn) fill(this.element, h("p", {class: "warning", role: "alert"}, error.message));
      }
    }

    head(moment, gist) {
      return h("header", {}, h("h2", {}, `Agent ${moment.agent} at step ${moment.step}: ${moment.kind}`, h("small", {}, ` seed ${moment.seed} · ${moment.run}`)),
        h("p", {class: "gist"}, gist));
    }

    label(edit) { return edit ? `with edit ${this.probe.edits[edit].name}` : "without an edit"; }

    shown(seen, edit) { return [...new Set([0, edit])].map((index) => seen.perceived.find((mine) => mine.edit === index)).filter(Boolean); }

    pictures(moment, seen, edit) {
      if (seen.why) return h("p", {class: "warning"}, `The observation of the agent cannot be shown: ${seen.why}`);
      const draw = drawing[seen.form];
      const panel = (perceived) => {
        const label = `The observation of agent ${moment.agent} ${this.label(perceived.edit)}`;
        const parts = draw && !perceived.images ? [draw(perceived.observation, label)]
          : Array.from({length: perceived.images || 1}, (_, image) => this.picture(moment, perceived, image, label));
        return h("figure", {}, parts, h("figcaption", {}, this.label(perceived.edit)));
      };
      const drawn = this.shown(seen, edit);
      return h("div", {class: "before-after"}, (draw || drawn.some((mine) => mine.images) ? drawn : drawn.slice(0, 1)).map(panel));
    }

    picture(moment, perceived, image, label) {
      const alt = perceived.images ? label : "The world in this moment", element = h("img", {alt});
      foundry.source.bytes(`${this.address}/picture/${moment.index}/${perceived.edit}/${image}`).then((bytes) => {
        const url = URL.createObjectURL(new Blob([bytes]));
        this.urls.push(url);
        element.src = url;
      }).catch((error) => element.replaceWith(h("p", {class: "note"}, error.message)));
      return element;
    }

    /** Return a table of the values that an edit changes in the observation, or of all values without an edit. */
    changes(seen, edit) {
      const [before, after] = this.shown(seen, edit).map((view) => new Map(lines(view.observation)));
      if (!before) return null;
      const every = [...new Set([...before.keys(), ...(after || before).keys()])], isOuter = (path) => every.some((key) => key.startsWith(`${path}[`) || key.startsWith(`${path}.`));
      const rows = after ? every.filter((path) => !isOuter(path) && JSON.stringify(before.get(path)) !== JSON.stringify(after.get(path))) : every;
      if (after && !rows.length) return h("p", {class: "note"}, "The edit changes only the images.");
      const cell = (map, path) => (map.has(path) ? h("td", {}, h("bdi", {}, worded(map.get(path)))) : h("td", {class: "nothing"}, "absent"));
      const heads = after ? ["observation", this.label(0), this.label(edit)] : ["observation", "value"];
      const table = h("div", {class: "table-box", tabindex: "0", role: "region", "aria-label": "The observation"}, h("table", {class: "runs"},
        h("thead", {}, h("tr", {}, heads.map((name) => h("th", {scope: "col"}, name)))),
        h("tbody", {}, rows.map((path) => h("tr", {}, h("th", {scope: "row"}, path), cell(before, path), after ? cell(after, path) : null)))));
      const isDrawn = drawing[seen.form] || seen.perceived[0].images;
      return h("details", {open: Boolean(after) || !isDrawn}, h("summary", {}, after ? `What the edit changes (${rows.length})` : "The whole observation"), table);
    }

    answers(seen, edit, format) {
      const here = new Set(seen.answers.filter((row) => row.format === format && [0, edit].includes(row.edit)).flatMap((row) => [...row.replies.map(({choice}) => choice), ...Object.keys(row.expected)]));
      const total = (choice) => this.probe.totals.get(choice) || 0, choices = [...here].sort((a, b) => total(b) - total(a) || (a < b ? -1 : 1));
      const columns = this.probe.models.map((name, model) => {
        const of = (which) => seen.answers.find((row) => row.model === model && row.edit === which && row.format === format);
        const sides = [...new Set([0, edit])].map((which) => [which, of(which)]).filter(([, answer]) => answer);
        return h("section", {class: "column"}, h("h3", {}, foundry.looks.mark(this.looks[model]), " ", name),
          sides.length ? sides.map(([which, answer]) => this.answered(answer, choices, {edit: which, named: sides.length > 1})) : h("p", {class: "note"}, "This model was not asked in this moment."));
      });
      return h("div", {class: "columns"}, columns);
    }

    answered({model, replies, expected}, choices, {edit, named}) {
      const isTold = Object.keys(expected).length > 0; // the probabilities of one reply replace the counts of replies
      const counts = new Map(), texts = new Map();
      for (const reply of replies) {
        counts.set(reply.choice, (counts.get(reply.choice) || 0) + 1);
        const key = JSON.stringify([reply.choice, reply.text, reply.thinking]), known = texts.get(key);
        if (known) known.times += 1; else texts.set(key, {...reply, times: 1});
      }
      return h("div", {class: "answered"}, named ? h("h4", {}, this.label(edit)) : null,
        h("ul", {class: "choices"}, choices.map((choice) => {
          const bar = h("i", {class: "bar"}, h("b")), count = counts.get(choice) || 0;
          const share = isTold ? expected[choice] || 0 : count / replies.length;
          Object.assign(bar.firstChild.style, {width: `${100 * share}%`, background: this.looks[model].paint});
          return h("li", {}, h("bdi", {}, choice), bar, h("span", {}, isTold ? `probability ${(100 * share).toFixed(0)} %` : `${count} of ${replies.length}`));
        })),
        h("details", {open: !named}, h("summary", {}, texts.size === 1 ? "reply" : `replies (${texts.size} different)`),
          [...texts.values()].sort((a, b) => b.times - a.times).map((reply) => [h("p", {class: "role"}, `${reply.choice}${reply.times > 1 ? `, ${reply.times} times` : ""}${reply.ending && reply.ending !== "stop" ? `, finish reason: ${reply.ending}` : ""}`),
            reply.text === null ? h("p", {class: "note"}, "This reply is not in the log.") : quote(reply.text, "reply"),
            reply.thinking ? h("details", {}, h("summary", {}, "thinking"), quote(reply.thinking)) : null])));
    }

    /** The prompts, before and after the edit. Models with the same prompt share one entry. */
    prompts(seen, edit, format) {
      const wanted = seen.answers.filter((row) => row.format === format && [0, edit].includes(row.edit) && row.prompt !== null);
      const columns = new Map();
      for (const row of wanted) {
        const key = `${row.edit}/${row.prompt}`;
        columns.set(key, {edit: row.edit, prompt: row.prompt, models: [...((columns.get(key) || {}).models || []), this.probe.models[row.model]]});
      }
      const sorted = [...columns.values()].sort((a, b) => a.edit - b.edit || a.prompt - b.prompt);
      return [h("h3", {}, sorted.length > 1 ? "Prompts" : "Prompt"), h("div", {class: "columns"}, sorted.map((column) => h("section", {class: "column"},
        sorted.length > 1 ? h("h4", {}, `${this.label(column.edit)}${column.models.length < this.probe.models.length ? `, to ${column.models.join(", ")}` : ""}`) : null,
        seen.prompts[column.prompt].map((message) => [h("p", {class: "role"}, message.role), quote(message.content, "prompt")]))))];
    }
  }

  foundry.MomentView = MomentView;
})(window.Foundry);
