"use strict";
/* Input for a picture that the user can move and zoom: mouse, wheel, one finger, two fingers, arrow keys. */
(function (foundry) {
  const STILL_PX = 5, WHEEL = 1.15, ARROW_PX = 40;
  const ARROWS = {ArrowLeft: [ARROW_PX, 0], ArrowRight: [-ARROW_PX, 0], ArrowUp: [0, ARROW_PX], ArrowDown: [0, -ARROW_PX]};

  const middle = (points) => [0, 1].map((axis) => points.reduce((sum, point) => sum + point[axis], 0) / points.length);
  const apart = ([first, second]) => (second ? Math.hypot(first[0] - second[0], first[1] - second[1]) : 0);

  /**
   * @param hands.zoomAt called with a factor and the point, in pixels, that keeps its position
   * @param hands.shift called with the distance by which the picture moves to the right and down, in pixels
   * @param hands.pick called with the point that was clicked or tapped
   * @param hands.isWhole returns whether the whole picture is visible. Then one finger and the arrow keys scroll the page
   */
  foundry.gestures = (canvas, {zoomAt, shift, pick, isWhole}) => {
    const down = new Map();
    let dragged = false, before = null;

    /** Remember the positions of the fingers as the start of a gesture. */
    function grip() {
      const points = [...down.values()];
      before = points.length ? {at: middle(points), apart: apart(points)} : null;
    }

    function moved(isTouched) {
      const points = [...down.values()], at = middle(points), wide = apart(points), by = at.map((pixel, axis) => pixel - before.at[axis]);
      if (!dragged && points.length < 2 && Math.abs(by[0]) + Math.abs(by[1]) < STILL_PX) return;
      dragged = true;
      if (isTouched && points.length < 2 && isWhole()) return;
      shift(...by);
      if (before.apart && wide) zoomAt(wide / before.apart, ...at);
      grip();
    }

    function lifted(event) {
      if (!down.delete(event.pointerId)) return;
      if (event.type === "pointerup" && !down.size && !dragged) pick(event.offsetX, event.offsetY);
      grip();
    }

    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoomAt(event.deltaY < 0 ? WHEEL : 1 / WHEEL, event.offsetX, event.offsetY);
    }, {passive: false});
    canvas.addEventListener("pointerdown", (event) => {
      if (!down.size) dragged = false;
      down.set(event.pointerId, [event.offsetX, event.offsetY]);
      canvas.setPointerCapture(event.pointerId);
      grip();
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!down.has(event.pointerId)) return;
      down.set(event.pointerId, [event.offsetX, event.offsetY]);
      moved(event.pointerType === "touch");
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, lifted);
    canvas.addEventListener("mousedown", (event) => event.preventDefault()); // the keyboard focus does not change
    canvas.addEventListener("keydown", (event) => {
      const arrow = ARROWS[event.key];
      if (!arrow || isWhole() || event.shiftKey || event.ctrlKey || event.metaKey || event.altKey) return;
      shift(...arrow);
      event.preventDefault();
      event.stopPropagation();
    });
  };
})(window.Foundry);
