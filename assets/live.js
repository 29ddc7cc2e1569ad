// Moves the lines of a drawn plot without plotly: the new coordinates go straight into the existing SVG elements.
// A full redraw follows when the hand rests; until then zooming or hovering sees the previous data.
(function () {
  "use strict";

  // Our axes are linear or logarithmic: value to pixel, to a tenth.
  function scale(axis) {
    const [low, high] = axis.range.map(Number);
    const upwards = axis._id[0] === "y";
    const base = upwards ? axis._length : 0;
    const slope = ((upwards ? -1 : 1) * axis._length) / (high - low);
    const linear = axis.type === "log" ? Math.log10 : Number;
    return (value) => Math.round((base + slope * (linear(value) - low)) * 10) / 10;
  }

  const named = (layout, id) => layout[`${id[0]}axis${id.slice(1)}`];

  function outline(xs, ys, px, py) {
    let path = "";
    let pen = "M";
    for (let i = 0; i < xs.length; i++) {
      if (xs[i] !== xs[i] || ys[i] !== ys[i]) {
        pen = "M";
        continue;
      }
      path += pen + px(xs[i]) + "," + py(ys[i]);
      pen = "L";
    }
    return path || "M0,0";
  }

  function movePoints(points, xs, ys, px, py) {
    let next = 0;
    // A point that has no value now must not stay where it was.
    for (const point of points) point.style.display = "none";
    for (let i = 0; i < xs.length && next < points.length; i++) {
      if (xs[i] !== xs[i] || ys[i] !== ys[i]) continue;
      points[next].style.display = "";
      points[next++].setAttribute("transform", `translate(${px(xs[i])},${py(ys[i])})`);
    }
  }

  // `lines`: index of the trace, and its x and y as typed arrays, for every trace that moved.
  function drawLines(plot, lines) {
    if (!plot || !plot._fullLayout) return;
    for (const [index, xs, ys] of lines) {
      const trace = plot._fullData[index];
      if (!trace || !trace.xaxis) continue;
      const [px, py] = [trace.xaxis, trace.yaxis].map((id) => scale(named(plot._fullLayout, id)));
      const group = plot.querySelector(`.scatterlayer .trace${trace.uid}`);
      if (!group) continue;
      const strokes = group.querySelectorAll(".js-line, .js-fill");
      if (strokes.length) {
        const path = outline(xs, ys, px, py);
        const drawn = new Set();
        for (const stroke of strokes) {
          const kind = stroke.classList[0];
          // A line with gaps may have been drawn in several pieces; one is enough.
          stroke.setAttribute("d", drawn.has(kind) ? "M0,0" : path);
          drawn.add(kind);
        }
      }
      movePoints(group.querySelectorAll(".point"), xs, ys, px, py);
    }
  }

  window.gainscope = Object.assign(window.gainscope || {}, { drawLines });
})();
