"use strict";
/* The records of one run, loaded in chunks around the present step. If the run still grows, new records are loaded. */
(function (foundry) {
  const KEPT_CHUNKS = 8, KEPT_DECISIONS = 24;
  const POLL_MS = 700;
  const LOST_MS = 5000;

  /** A small cache: a few values by key, the most recently used last. */
  class Recent {
    constructor(size) { this.size = size; this.entries = new Map(); }
    get(key) {
      const value = this.entries.get(key);
      if (value !== undefined) { this.entries.delete(key); this.entries.set(key, value); }
      return value;
    }
    set(key, value) {
      this.entries.delete(key);
      this.entries.set(key, value);
      while (this.entries.size > this.size) this.entries.delete(this.entries.keys().next().value);
    }
  }

  class RunData {
    constructor(sweep, id) {
      this.sweep = sweep;
      this.id = id;
      this.address = `run/${sweep}/${id}`;
      this.listeners = [];
      this.readers = [];
      this.analysis = {events: [], why: "Loading the events…", score: null};
      this.forget();
      this.progress = {done: 0, status: "waiting"};
    }

    /** Forget all loaded records. Requests that are still in progress belong to the forgotten records. */
    forget() {
      this.chunks = new Recent(KEPT_CHUNKS);
      this.decisionChunks = new Recent(KEPT_DECISIONS);
      this.textChunks = new Recent(KEPT_CHUNKS);
      this.loading = new Map();
      this.marks = {};
      this.marked = 0;
    }

    async open() {
      this.progress = await foundry.source.json(`${this.address}/progress`);
      this.about = await foundry.source.json(`${this.address}/about`);
      this.form = await foundry.formOf(this.about);
      return this;
    }

    get done() { return this.progress.done; }
    get ended() { return this.progress.status === "complete" || this.progress.status === "failed"; }
    get written() { return foundry.source.live && (this.progress.status === "running" || this.progress.status === "waiting"); }
    get name() { return `${this.about.model} · ${this.about.prompt} · seed ${this.about.seed}`; }

    onGrowth(listener) { this.listeners.push(listener); }

    /** Call a listener when the results of the analysis are loaded. */
    onAnalysis(listener) { this.readers.push(listener); }

    async loadAnalysis() {
      const {events, why, score} = await this.once("analysis");
      this.analysis = {why, score, events: events.map(([step, agent, event, text]) => ({step, agent, event, text}))};
      this.readers.forEach((listener) => listener());
    }

    /** Return the options of a player for events: the events of the chosen agent, and the events of no single agent. */
    happening(chosen) {
      const isOf = (event) => chosen() === null || event.agent === null || event.agent === chosen();
      return {events: () => this.analysis.events.filter(isOf), why: () => this.analysis.why};
    }

    /** Load once; requests in the meantime share the result. */
    once(address) {
      const {loading} = this;
      if (!loading.has(address)) {
        const promise = foundry.source.json(`${this.address}/${address}`).finally(() => loading.delete(address));
        loading.set(address, promise);
      }
      return loading.get(address);
    }

    numberOf(step, size) { return Math.floor((Math.max(1, step) - 1) / size); }

    isWhole(chunk, number, size) { return chunk.last >= Math.min((number + 1) * size, this.done); }

    /** Return the chunk with a step if it is loaded. Otherwise return null and load it. */
    chunkAt(step) {
      const number = this.numberOf(step, this.about.steps_per_chunk);
      const chunk = this.chunks.get(number);
      if (!chunk || !this.isWhole(chunk, number, this.about.steps_per_chunk)) this.load(step).catch(() => null);
      return chunk && step >= chunk.first && step <= chunk.last ? chunk : null;
    }

    /** Load the chunk of a step. */
    async load(step) {
      const number = this.numberOf(step, this.about.steps_per_chunk);
      const {chunks} = this, known = chunks.get(number);
      if (known && this.isWhole(known, number, this.about.steps_per_chunk)) return known;
      const block = await this.once(`frames/${number}`);
      const chunk = this.form.chunk(block, this.about);
      chunks.set(number, chunk);
      return chunk;
    }

    prefetch(step) {
      const next = step + this.about.steps_per_chunk / 2;
      if (next <= this.done) this.chunkAt(Math.floor(next));
    }

    /** Return the address of a moment. */
    momentOf(step, agent) { return `#/${this.address}?step=${step}&agent=${agent}`; }

    /** Return an agent's decision at a step: records, calls and received messages; also its messages and records since step `since`. */
    async decision(step, agent) {
      const size = this.about.decisions_per_chunk, number = this.numberOf(step, size), numbers = number ? [number - 1, number] : [number];
      const chunks = await Promise.all(numbers.map((index) => this.chunkOf(this.decisionChunks, `decisions/${index}/${agent}`, index, size)));
      const steps = chunks.flatMap((block) => block.steps), received = chunks.flatMap((block) => block.received), chunk = chunks.at(-1);
      return {
        momentOf: (...moment) => this.momentOf(...moment),
        record: chunk.steps.find((row) => row.step === step) || null,
        records: chunk.steps.filter((row) => row.step === step),
        calls: chunk.calls.filter((call) => call.step === step),
        received: received.filter(([at]) => at === step),
        since: chunks[0].first,
        before: received.filter(([at]) => at < step),
        earlier: steps.filter((row) => row.step < step),
        damaged: chunk.damaged,
      };
    }

    track(agent) { return this.once(`track/${agent}`); }

    texts(number) { return this.chunkOf(this.textChunks, `texts/${number}`, number, this.about.steps_per_chunk); }

    /** Return the messages of agents at a step, by agent. */
    async said(step) {
      const {texts} = await this.texts(this.numberOf(step, this.about.steps_per_chunk));
      return new Map(texts.filter(([at]) => at === step).map(([, agent, text]) => [agent, text]));
    }

    /** Return a chunk from memory, or load it. An incomplete chunk is loaded again. */
    async chunkOf(chunks, address, number, size) {
      const known = chunks.get(address);
      if (known && this.isWhole(known, number, size)) return known;
      const chunk = await this.once(address);
      chunks.set(address, chunk);
      return chunk;
    }

    /** Load the missing marks of steps, block by block. */
    async loadMarks(onBlock) {
      const size = this.about.marks_per_block;
      const {marks} = this;
      while (this.marked < this.done) {
        const block = await this.once(`marks/${Math.floor(this.marked / size)}`);
        if (this.marks !== marks) return;
        for (const [name, values] of Object.entries(block.marks)) {
          marks[name] = (marks[name] || []).slice(0, block.first - 1).concat(values);
        }
        if (block.last <= this.marked) return;
        this.marked = block.last;
        onBlock();
      }
    }

    /** Load the progress repeatedly, until the run has ended or `stopped` returns true. */
    follow(stopped) {
      const look = async () => {
        if (stopped()) return;
        const lost = this.lost;
        try {
          await this.look();
          this.lost = null;
        } catch (error) {
          this.lost = error;
        }
        if (Boolean(lost) !== Boolean(this.lost)) this.listeners.forEach((listener) => listener());
        if (!this.ended) setTimeout(look, this.lost ? LOST_MS : POLL_MS);
      };
      if (foundry.source.live && !this.ended) setTimeout(look, POLL_MS);
    }

    async look() {
      const before = this.progress, now = await foundry.source.json(`${this.address}/progress`);
      if (before.beginning !== now.beginning) {
        this.about = await foundry.source.json(`${this.address}/about`);
        this.forget();
      }
      this.progress = now;
      if (["beginning", "done", "status"].some((key) => before[key] !== now[key])) {
        this.listeners.forEach((listener) => listener());
      }
    }
  }

  foundry.RunData = RunData;
})(window.Foundry);
