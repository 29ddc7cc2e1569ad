// Points of a plot that can be taken hold of: a button lies over each, for mouse, touch and arrow keys.
//
// plotly's points cannot be dragged. The server says where the handles of a plot are and which control they set
// (layouts/figures/handles.py); the value goes the same way as that of a slider.
(function () {
  "use strict";

  const QUIET = 700; // ms after the last arrow key until the handle is let go
  const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

  const plots = new Map(); // id of the plot: what the server said of its handles, and the buttons
  let grip = null; // what a hand holds: plot, index, all points as they were when it took hold, where it is now
  let setControl = () => {};

  const drawing = (id) => document.querySelector(`#${id} .js-plotly-plot`);

  function axes(id) {
    const gd = drawing(id);
    const layout = gd && gd._fullLayout;
    return layout && layout.xaxis && layout.xaxis._length ? [layout.xaxis, layout.yaxis] : null;
  }

  // All such plots have linear axes.
  function toPixels([xaxis, yaxis], [x, y]) {
    const across = (axis, value) => (value - axis.range[0]) / (axis.range[1] - axis.range[0]);
    return [xaxis._offset + across(xaxis, x) * xaxis._length, yaxis._offset + (1 - across(yaxis, y)) * yaxis._length];
  }

  function fromPixels([xaxis, yaxis], [px, py]) {
    const share = (axis, pixel) => Math.min(1, Math.max(0, (pixel - axis._offset) / axis._length));
    const value = (axis, at) => round(axis.range[0] + at * (axis.range[1] - axis.range[0]), axis);
    return [value(xaxis, share(xaxis, px)), value(yaxis, 1 - share(yaxis, py))];
  }

  // As many digits as pixels tell apart.
  function round(value, axis) {
    const pixel = Math.abs(axis.range[1] - axis.range[0]) / 2000;
    return Number(value.toFixed(Math.min(12, Math.max(0, Math.ceil(-Math.log10(pixel))))));
  }

  // ------------------------------------------------------------------ showing

  function makeButton(id, index) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", className: "handle", title: "Drag, or use the arrow keys" });
    button.setAttribute("aria-roledescription", "draggable point");
    Object.assign(button.dataset, { plot: id, index });
    return button;
  }

  function showHandles(handles, edit) {
    setControl = edit;
    for (const [id, spec] of Object.entries(handles)) {
      const graph = document.getElementById(id);
      if (!graph) continue;
      const frame = graph.parentElement;
      let shown = plots.get(id);
      if (!shown || shown.frame !== frame || shown.buttons.length !== spec.points.length) {
        if (shown) shown.buttons.forEach((button) => button.remove());
        shown = { frame, buttons: spec.points.map((_, index) => makeButton(id, index)) };
        frame.append(...shown.buttons);
        plots.set(id, shown);
        if (grip && grip.id === id) grip = null;
      }
      shown.spec = spec;
      shown.buttons.forEach((button, i) => {
        if (button.getAttribute("aria-label") !== spec.labels[i]) button.setAttribute("aria-label", spec.labels[i]);
        button.dataset.tone = spec.tones[i];
        button.dataset.control = spec.control;
      });
      placeHandles(id);
    }
  }

  function nearest(points, [x, y]) {
    const far = ([px, py]) => Math.hypot(px - x, py - y);
    return points.reduce((best, point, i) => (far(point) < far(points[best]) ? i : best), 0);
  }

  // Which point lies under which button: the held one stays with the hand, however the server orders them.
  function order(id, shown) {
    const indices = shown.spec.points.map((_, i) => i);
    if (!grip || grip.id !== id) return indices;
    const held = nearest(shown.spec.points, grip.at);
    const others = indices.filter((i) => i !== held);
    return indices.map((i) => (i === grip.index ? held : others.shift()));
  }

  function placeHandles(id) {
    const shown = plots.get(id);
    const both = axes(id);
    if (!shown || !both) return;
    const indices = order(id, shown);
    shown.buttons.forEach((button, i) => {
      const held = grip && grip.id === id && grip.index === i;
      const [x, y] = toPixels(both, held ? grip.at : shown.spec.points[indices[i]]);
      const [left, top] = both.map((axis) => axis._offset);
      const [width, height] = both.map((axis) => axis._length);
      const inside = x >= left - 1 && x <= left + width + 1 && y >= top - 1 && y <= top + height + 1;
      // What lies outside stands at the edge, where it can still be taken.
      const clamp = (value, low, size) => Math.min(low + size, Math.max(low, value));
      button.style.transform = `translate(${clamp(x, left, width)}px, ${clamp(y, top, height)}px)`;
      if (inside) delete button.dataset.outside;
      else button.dataset.outside = "yes";
    });
  }

  // ------------------------------------------------------------------ hands

  function take(button) {
    const { plot: id, index } = button.dataset;
    const shown = plots.get(id);
    if (grip && grip.id === id && grip.index === Number(index)) return;
    letGo();
    grip = {
      id,
      index: Number(index),
      // A held point keeps its digits until it is moved; the others are never touched.
      held: shown.spec.points.map((point) => [...point]),
      at: [...shown.spec.points[index]],
      timer: 0,
    };
    button.dataset.held = "yes";
  }

  const clampTo = ([low, high], value) => Math.min(Math.max(low, high), Math.max(Math.min(low, high), value));

  function move(to) {
    const { spec } = plots.get(grip.id);
    grip.at = to;
    const value =
      spec.control === "pole" ? [grip.index, ...to, ...grip.held.flat()].join(" ") : [spec.prefix, ...to].join(" ");
    setControl(spec.control, value, null, true);
    placeHandles(grip.id);
  }

  function letGo() {
    if (!grip) return;
    const { id, index, at } = grip;
    clearTimeout(grip.timer);
    grip = null;
    const shown = plots.get(id);
    if (!shown) return;
    const button = shown.buttons[index];
    delete button.dataset.held;
    placeHandles(id);
    // The focus stays with the point, whatever its number is now.
    const now = shown.buttons[nearest(shown.spec.points, at)];
    if (button === document.activeElement && now !== button) now.focus({ preventScroll: true });
  }

  const handleOf = (target) => (target instanceof Element ? target.closest(".handle") : null);

  document.addEventListener("pointerdown", (event) => {
    const button = handleOf(event.target);
    // A second finger has nothing to take while the first holds something.
    if (!button || event.button || (grip && grip.from)) return;
    event.preventDefault();
    button.focus({ preventScroll: true });
    button.setPointerCapture(event.pointerId);
    take(button);
    grip.pointer = event.pointerId;
    const box = button.getBoundingClientRect();
    // The point does not jump under a hand that takes it by its edge.
    grip.from = [event.clientX - (box.left + box.width / 2), event.clientY - (box.top + box.height / 2)];
  });

  document.addEventListener("pointermove", (event) => {
    if (!grip || event.pointerId !== grip.pointer || !axes(grip.id)) return;
    const box = drawing(grip.id).getBoundingClientRect();
    move(fromPixels(axes(grip.id), [event.clientX - box.left - grip.from[0], event.clientY - box.top - grip.from[1]]));
  });

  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    document.addEventListener(end, (event) => grip && event.pointerId === grip.pointer && letGo());
  }

  document.addEventListener("keydown", (event) => {
    const button = handleOf(event.target);
    const way = ARROWS[event.key];
    if (!button || !way || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    // A hand on the mouse comes first.
    if (grip && grip.from) return;
    take(button);
    const step = plots.get(grip.id).spec.step * (event.shiftKey ? 0.1 : 1);
    // What an arrow does not move keeps every digit.
    const both = axes(grip.id);
    const moved = (value, i) => clampTo(both[i].range, Number((value + way[i] * step).toFixed(12)));
    move(grip.at.map((value, i) => (way[i] ? moved(value, i) : value)));
    clearTimeout(grip.timer);
    grip.timer = setTimeout(letGo, QUIET);
  });

  document.addEventListener("focusout", (event) => {
    if (grip && !grip.from && handleOf(event.target)) letGo();
  });

  window.gainscope = Object.assign(window.gainscope || {}, {
    showHandles,
    placeHandles,
    letGo,
    isHeld: () => Boolean(grip),
  });
})();
