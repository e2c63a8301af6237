// The 3D part of the viewer: a scene that the user can turn, with the agent, its path, its field of view and its target.
//
// window.FoundryScene.mount(element, {glb, episode, steps, camera, onCamera}) -> Promise<{seek(index), update(steps), resize(), dispose()}>
//   glb      ArrayBuffer of foundry/viewer/camera/scene_export.py, or null: only the path
//   episode  the record of episode.jsonl, or null
//   steps    the records of steps.jsonl
//   camera   the position of the viewer, as onCamera returned it before; null for the whole scene
//   onCamera called with this position as a text when the user turns or moves the scene
//   index    number of decisions so far: 0 is the first pose, k is the pose after steps[k - 1]
//
// All other files, including three.js, are loaded from this folder when the first view is mounted. The view works under a
// Content-Security-Policy without eval, inline styles and fetch() of blob: addresses.
"use strict";

window.FoundryScene = (() => {
  const HERE = document.currentScript.src;
  const FILES = ["../vendor/three.bundle.js", "scene3d_parts.js", "scene3d_view.js"];
  let loaded = null;

  function loadFile(name) {
    return new Promise((resolve, reject) => {
      const script = document.createElement("script");
      script.src = new URL(name, HERE);
      script.onload = resolve;
      script.onerror = () => reject(new Error(`${name} could not be loaded`));
      document.head.append(script);
    });
  }

  async function loadAll() {
    for (const name of FILES) await loadFile(name);
  }

  function hasWebGL() {
    const context = document.createElement("canvas").getContext("webgl2");
    context?.getExtension("WEBGL_lose_context")?.loseContext();
    return context !== null;
  }

  /** Shows a text instead of the scene. */
  function say(element, text) {
    const note = append(element, "p", { className: "scene3d-note", textContent: text });
    note.setAttribute("role", "status");
    const nothing = () => {};
    return { seek: nothing, update: nothing, resize: nothing, dispose: () => note.remove() };
  }

  /** Appends an element with these properties. Styles are set one by one, which the page's policy allows. */
  function append(parent, tag, properties = {}, style = {}) {
    const made = document.createElement(tag);
    Object.assign(made, properties);
    Object.assign(made.style, style);
    parent.append(made);
    return made;
  }

  function addCanvas(element, view) {
    const { canvas } = view;
    Object.assign(canvas.style, { position: "absolute", inset: "0", touchAction: "none", outlineOffset: "-2px" });
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute(
      "aria-label", "Scene in 3D. Drag or arrow keys: turn. Wheel, plus and minus: nearer and farther. Home: all of it.");
    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key === "Home") view.reset();
      else if (!view.turn(event.key)) return;
      event.preventDefault();
      event.stopPropagation();
    });
    element.append(canvas);
  }

  /** The controls above the scene: the height of the cut, transparent walls, and the choice of the view. */
  function addControls(element, view) {
    const bar = append(element, "div", { className: "scene3d-controls" }, {
      position: "absolute", left: "8px", top: "8px", maxWidth: "calc(100% - 16px)", display: "flex", gap: "4px 12px", flexWrap: "wrap",
      alignItems: "center", padding: "4px 8px", borderRadius: "6px", font: "13px system-ui, sans-serif",
      background: "var(--panel, #ffffff)", color: "var(--ink, #1c2430)",
    });
    const label = (text) => append(bar, "label", { textContent: text }, { display: "flex", gap: "6px", alignItems: "center" });
    if (view.surfaces) {
      const { height, cut } = view.heights();
      const range = append(label("Cut at "), "input", {
        type: "range", min: 0.02 * height, max: height, step: "any", value: cut, className: "scene3d-cut" });
      range.addEventListener("input", () => view.cutAt(Number(range.value)));
      view.cutAt(cut);
      const fade = append(label("See through"), "input", { type: "checkbox", className: "scene3d-fade" });
      fade.addEventListener("change", () => view.fade(fade.checked));
    }
    if (view.surfaces && view.eye) {
      const eye = append(label("Agent's eyes"), "input", { type: "checkbox", className: "scene3d-eye" });
      eye.addEventListener("change", () => view.lookThroughEye(eye.checked));
    }
    const all = append(bar, "button", { type: "button", textContent: "Whole scene", className: "scene3d-reset" });
    all.addEventListener("click", () => view.reset());
    return bar;
  }

  async function mount(element, { glb, episode, steps, camera, onCamera }) {
    if (!hasWebGL()) return say(element, "The scene cannot be shown: this browser offers no WebGL 2.");
    await (loaded ??= loadAll());
    const { View, read } = window.FoundrySceneView;
    if (getComputedStyle(element).position === "static") element.style.position = "relative";
    if (!element.clientHeight) element.style.height = "24rem";
    const view = new View(element, glb ? await read(glb) : null, episode);
    addCanvas(element, view);
    view.update(steps);
    const bar = addControls(element, view);
    view.resize();
    view.reset();
    view.place = camera;
    if (onCamera) view.controls.addEventListener("change", () => onCamera(view.place));
    const watcher = new ResizeObserver(() => view.resize());
    watcher.observe(element);
    return {
      seek: (index) => view.seek(index),
      update: (now) => view.update(now),
      resize: () => view.resize(),
      dispose() {
        watcher.disconnect();
        view.dispose();
        view.canvas.remove();
        bar.remove();
      },
    };
  }

  return { mount };
})();
