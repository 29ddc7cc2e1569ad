// The Tune page beside its study: where the present filter stands in the plot, and cells that can be taken.
(function () {
  "use strict";

  const PLOT = "tune-plot";
  let present = null; // the parameter that is varied, and its value of the present filter

  // The line at the present value is a shape of the plot. While a slider moves, what is drawn of it is shifted; plotly
  // redraws it once the hand rests.
  function movePresent(plot, live) {
    const meta = plot && plot.layout && plot.layout.meta;
    if (!present || !meta || meta.parameter !== present.parameter) return;
    const { value } = present;
    const shape = plot.layout.shapes[meta.present];
    const drawn = plot.querySelector(`.shape-group[data-index="${meta.present}"]`);
    if (live && drawn && shape.visible && value !== null) {
      const { xaxis } = plot._fullLayout;
      const [from, to] = [shape.x0, value].map((x) => xaxis.l2p(xaxis.d2l(x)));
      drawn.setAttribute("transform", `translate(${to - from})`);
      return;
    }
    if (drawn) drawn.removeAttribute("transform");
    if (shape.visible === (value !== null) && (value === null || shape.x0 === value)) return;
    const at = `shapes[${meta.present}]`;
    const place = value === null ? {} : { [`${at}.x0`]: value, [`${at}.x1`]: value };
    window.Plotly.relayout(plot, { [`${at}.visible`]: value !== null, ...place });
  }

  // A cell that was clicked is offered.
  function offerCell(plot, point) {
    const { plane } = plot.layout.meta || {};
    // What answers another question than the page's offers nothing.
    if (!plane || point.fullData.type !== "heatmap" || plot.closest("[data-stale]")) return;
    const [x, y] = [point.x, point.y].map((value) => Number(value.toPrecision(5)));
    const [across, up] = ["xaxis", "yaxis"].map((axis) => plot.layout[axis].title.text);
    const button = document.getElementById("tune-cell");
    button.textContent = `Use the cell at ${across} ${Number(x.toPrecision(3))}, ${up} ${Number(y.toPrecision(3))}`;
    button.dataset.controls = JSON.stringify({ point: `${plane.join("-")} ${x} ${y}` });
    button.dataset.plane = plane;
    button.hidden = false;
  }

  document.addEventListener("deskreport", ({ detail }) => {
    if (detail.page !== "tune") return;
    present = detail.answer.present;
    // Where nobody knows the truth there is nothing to switch back to; the note above the study says so.
    const knowing = document.getElementById("tune-without_truth");
    if (knowing) {
      knowing.disabled = detail.answer.blind;
      const told = "tune-without_truth-about tune-without_truth-error";
      knowing.setAttribute("aria-describedby", detail.answer.blind ? `tune-data-note ${told}` : told);
    }
    movePresent(document.querySelector(`#${PLOT} .js-plotly-plot`), "lines" in detail.answer);
  });

  document.addEventListener("studydrawn", ({ detail: { id, plot } }) => {
    if (id !== PLOT) return;
    if (!plot.dataset.watched) {
      plot.dataset.watched = "yes";
      plot.on("plotly_afterplot", () => gainscope.placeHandles(PLOT));
      plot.on("plotly_click", (event) => offerCell(plot, event.points[0]));
    }
    // A cell of another plane is none of this one.
    const button = document.getElementById("tune-cell");
    if (String(plot.layout.meta.plane) !== button.dataset.plane) button.hidden = true;
    gainscope.placeHandles(PLOT);
    movePresent(plot, false);
  });
})();
