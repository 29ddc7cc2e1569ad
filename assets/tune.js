// The Tune page beside its study: where the present filter stands in the plot, and cells that can be taken.
(function () {
  "use strict";

  const PLOT = "tune-plot";
  let present = null; // the parameter that is varied, and its value of the present filter

  // The line at the present value is a shape; plotly draws those alone where nothing else changes.
  function movePresent(plot) {
    const meta = plot && plot.layout && plot.layout.meta;
    if (!present || !meta || meta.parameter !== present.parameter) return;
    const { value } = present;
    const shape = plot.layout.shapes[meta.present];
    if (shape.visible === (value !== null) && (value === null || shape.x0 === value)) return;
    const at = `shapes[${meta.present}]`;
    const place = value === null ? {} : { [`${at}.x0`]: value, [`${at}.x1`]: value };
    window.Plotly.relayout(plot, { [`${at}.visible`]: value !== null, ...place });
  }

  // A cell that was clicked is offered.
  function offerCell(plot, point) {
    const { plane } = plot.layout.meta || {};
    if (!plane || point.fullData.type !== "heatmap") return;
    const [x, y] = [point.x, point.y].map((value) => Number(value.toPrecision(5)));
    const [across, up] = ["xaxis", "yaxis"].map((axis) => plot.layout[axis].title.text);
    const button = document.getElementById("tune-cell");
    button.textContent = `Use the cell at ${across} ${Number(x.toPrecision(3))}, ${up} ${Number(y.toPrecision(3))}`;
    button.dataset.controls = JSON.stringify({ point: `${plane.join("-")} ${x} ${y}` });
    button.hidden = false;
  }

  document.addEventListener("deskreport", ({ detail }) => {
    if (detail.page !== "tune") return;
    present = detail.answer.present;
    movePresent(document.querySelector(`#${PLOT} .js-plotly-plot`));
  });

  document.addEventListener("studydrawn", ({ detail: { id, plot } }) => {
    if (id !== PLOT) return;
    if (!plot.dataset.watched) {
      plot.dataset.watched = "yes";
      plot.on("plotly_afterplot", () => gainscope.placeHandles(PLOT));
      plot.on("plotly_click", (event) => offerCell(plot, event.points[0]));
    }
    if (!plot.layout.meta.plane) document.getElementById("tune-cell").hidden = true;
    gainscope.placeHandles(PLOT);
    movePresent(plot);
  });
})();
