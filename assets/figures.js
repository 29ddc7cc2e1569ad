// The figure of a frame is saved as it is seen: SVG for papers, PNG in twice as many points for everything else.
(function () {
  "use strict";

  let stem = "gainscope"; // what the files of this target begin with

  document.addEventListener("deskreport", ({ detail }) => (stem = detail.answer.stem));

  const slug = (text) => text.replace(/[^A-Za-z0-9]+/g, "-").replace(/^-|-$/g, "").toLowerCase();

  document.addEventListener("click", (event) => {
    const target = event.target instanceof Element ? event.target : null;
    const button = target?.closest("[data-save]");
    // One is open at a time, and none after a click elsewhere.
    for (const menu of document.querySelectorAll(".save[open]")) if (!menu.contains(target)) menu.open = false;
    if (!button) return;
    const plot = button.closest(".plot-frame").querySelector(".js-plotly-plot");
    const format = button.dataset.save;
    button.closest(".save").open = false;
    button.closest(".save").firstElementChild.focus();
    if (!plot || !plot._fullLayout) return;
    const filename = `${stem}-${slug(button.closest(".card").querySelector("h2, h3").textContent)}`;
    window.Plotly.downloadImage(plot, {
      format,
      filename,
      width: plot.offsetWidth,
      height: plot.offsetHeight,
      scale: format === "png" ? 2 : 1,
    });
  });

  document.addEventListener("keydown", (event) => {
    const menu = event.key === "Escape" && event.target instanceof Element ? event.target.closest(".save[open]") : null;
    if (!menu) return;
    menu.open = false;
    menu.firstElementChild.focus();
  });
})();
