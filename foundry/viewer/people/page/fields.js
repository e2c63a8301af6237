"use strict";
/* Turns the schema of a reply into fields, and the content of the fields into the reply. */
(function (foundry) {
  const {h} = foundry.dom;
  const KEYS = "123456789abcdefghijklmnopqrstuvwxyz";
  const LONG = 4;

  /** Return the fields of a schema: one per key of an object, or a single field without a name. */
  function fieldsOf(schema) {
    if (!schema) return [{name: null, type: "string", required: true}];
    if (schema.type !== "object") return [{name: null, required: true, ...schema}];
    const required = new Set(schema.required || []);
    return Object.entries(schema.properties || {}).map(([name, part]) => ({...part, name, required: required.has(name)}));
  }

  function isChosen(field) { return Array.isArray(field.enum); }
  function isNumber(field) { return field.type === "integer" || field.type === "number"; }

  /** The fields of one question as elements, in the order in which a person must decide them. */
  class Fields {
    constructor(schema, changed) {
      this.all = fieldsOf(schema);
      this.byKey = new Map();
      const rank = (field) => (isChosen(field) ? 0 : isNumber(field) ? 1 : 2);
      const sorted = [...this.all].sort((field, other) => rank(field) - rank(other));
      this.elements = sorted.map((field) => (isChosen(field) ? this.choices(field) : this.written(field)));
      this.elements.forEach((element) => element.addEventListener("input", changed));
    }

    choices(field) {
      const options = field.enum.map((value, index) => {
        const key = KEYS[this.byKey.size];
        const input = h("input", {type: "radio", name: field.name || "answer", value: String(index)});
        if (key) this.byKey.set(key, input);
        return h("label", {class: "choice"}, input, key ? h("kbd", {}, key) : null, String(value));
      });
      field.read = () => {
        const place = options.findIndex((label) => label.querySelector("input").checked);
        return place < 0 ? undefined : field.enum[place];
      };
      return h("fieldset", {}, field.name ? h("legend", {}, this.label(field)) : null, options);
    }

    written(field) {
      const about = {"aria-label": field.name || "Your answer", maxlength: field.maxLength};
      const input = isNumber(field)
        ? h("input", {type: "number", step: field.type === "integer" ? 1 : "any", min: field.minimum, max: field.maximum, ...about})
        : h("textarea", {rows: field.name ? 2 : LONG, dir: "auto", ...about});
      field.read = () => {
        if (!isNumber(field)) return input.value.trim() === "" && !field.required ? undefined : input.value;
        return input.value === "" ? undefined : Number(input.value);
      };
      return h("label", {class: "written"}, field.name ? this.label(field) : "Your answer", input);
    }

    label(field) {
      if (isWritten(field)) return `${field.name} (optional)`;
      return field.required ? field.name : `${field.name} (if it applies)`;
    }

    /** Return the reply as text. */
    text() {
      if (this.all[0].name === null) return String(this.all[0].read() ?? "");
      const pairs = this.all.map((field) => [field.name, field.read()]).filter(([, value]) => value !== undefined);
      return JSON.stringify(Object.fromEntries(pairs));
    }

    /** Return the name of the first required field without a value, or null. */
    missing() {
      const open = this.all.find((field) => field.required && !isWritten(field) && field.read() === undefined);
      return open ? open.name || "an answer" : null;
    }

    /**
     * Return the names of empty fields that may apply, and a text that is equal if the same fields are empty for the
     * same choice.
     */
    open() {
      const names = this.all.filter((field) => !field.required && !isWritten(field) && field.read() === undefined).map((field) => field.name);
      const beside = this.all.filter((field) => field.required && isChosen(field)).map((field) => field.read());
      return {names, beside: JSON.stringify([names, beside])};
    }

    /** Return whether all fields are empty. */
    isEmpty() { return this.all.every((field) => [undefined, ""].includes(field.read())); }

    /** Choose an option by its key. The same key again removes the choice. */
    press(key) {
      const input = this.byKey.get(key);
      if (!input) return false;
      input.checked = !input.checked;
      input.focus();
      input.dispatchEvent(new Event("input", {bubbles: true}));
      return true;
    }
  }

  function isWritten(field) { return !isChosen(field) && !isNumber(field); }

  foundry.Fields = Fields;
})(window.Foundry);
