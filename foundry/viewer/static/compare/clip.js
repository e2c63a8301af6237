"use strict";
/* Films a range of steps as the page shows them, encoded by the browser itself, so that an exported page can do it too. */
(function (foundry) {
  const {h, announce} = foundry.dom;
  const KINDS = [["webm", "video/webm;codecs=vp9"], ["webm", "video/webm"], ["mp4", "video/mp4"]];
  const PICTURES_A_SECOND = 30, BITS_A_SECOND = 6e6, STILL_MS = 400;

  class Clip {
    /** @param moment draws the pictures, `picture(said, canvas)`, and names the file; @param clock is played */
    constructor(moment, clock) {
      Object.assign(this, {moment, clock, recorder: null});
      const number = (label, value) => h("input", {type: "number", min: "1", value, "aria-label": label});
      this.from = number("Film from step", "1");
      this.to = number("Film to step", "20");
      this.speed = h("select", {"aria-label": "Steps per second of the film"}, foundry.SPEEDS.map((one) => h("option", {value: String(one), selected: one === 2}, `${one} steps/s`)));
      this.button = h("button", {type: "button", onclick: () => (this.recorder ? this.clock.pause() : this.record())}, "record");
      this.state = h("span", {class: "note", role: "status"});
      this.element = h("details", {class: "clip"}, h("summary", {}, "film"),
        h("div", {class: "choices"}, h("label", {}, "from step ", this.from), h("label", {}, "to ", this.to), this.speed, this.button, this.state));
      clock.onChange(() => { if (this.recorder) this.goOn(); });
    }

    /** Play the chosen steps from their beginning, and take what is shown. */
    async record() {
      const {clock} = this, within = (input) => Math.max(1, Math.min(Math.floor(Number(input.value)) || 1, clock.steps));
      const from = within(this.from), to = Math.max(from, within(this.to)), kind = KINDS.find(([, type]) => window.MediaRecorder && MediaRecorder.isTypeSupported(type));
      [this.from.value, this.to.value] = [from, to];
      if (!kind || !clock.steps) { announce(this.state.textContent = kind ? "There is no step to film yet." : "This browser records no films."); return; }
      this.button.disabled = true;
      try {
        const said = await this.moment.said(from, to);
        await this.arrive(from);
        await this.begin(kind, {from, to, said});
      } catch (error) {
        announce(this.state.textContent = `No film can be taken here: ${error.message}`);
      }
      this.button.disabled = false;
    }

    /** Go to a step and wait until its records are there. */
    async arrive(step) {
      this.clock.pause();
      this.clock.seek(step);
      while (!this.clock.isReady(step)) await new Promise(requestAnimationFrame);
      this.clock.seek(step);
    }

    /** Record the first moment for a while, as long as the encoder may take to start, and then what is played. */
    async begin([ending, type], range) {
      const {clock} = this, parts = [], canvas = this.moment.picture(range.said), speed = clock.speed;
      const recorder = new MediaRecorder(canvas.captureStream(PICTURES_A_SECOND), {mimeType: type, videoBitsPerSecond: BITS_A_SECOND});
      recorder.ondataavailable = ({data}) => parts.push(data);
      recorder.onstop = () => {
        foundry.download.blob(new Blob(parts, {type}), this.moment.name(ending, `${range.from}-${clock.step}`));
        this.state.textContent = "";
      };
      this.end = () => {
        this.recorder = null;
        clock.pause();
        clock.seek(Math.min(clock.position, range.to));
        clock.speed = speed;
        this.button.textContent = "record";
        setTimeout(() => recorder.stop(), STILL_MS);
      };
      recorder.start();
      await new Promise((resolve) => { setTimeout(resolve, STILL_MS); });
      this.moment.picture(range.said, canvas);
      await new Promise((resolve) => { setTimeout(resolve, STILL_MS); });
      Object.assign(this, {recorder, canvas, range});
      this.button.textContent = "stop";
      clock.speed = Number(this.speed.value);
      clock.play();
    }

    /** Take what the clock shows now; end behind the last step, or when somebody pauses. */
    goOn() {
      const {clock, range} = this;
      if (clock.position < range.to + 1) this.moment.picture(range.said, this.canvas);
      this.state.textContent = `step ${Math.min(clock.step, range.to)} of ${range.from} to ${range.to}; keep this page in sight`;
      if (clock.position >= range.to + 1 || !clock.playing) this.end();
    }
  }

  foundry.Clip = Clip;
})(window.Foundry);
