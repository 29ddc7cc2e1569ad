// The list of compared filters: swatches, names, buttons. What the server says of them comes with every answer of the
// desk (layouts/pages/compare/answers.py); rows and their places are on the page from the start.
(function () {
  "use strict";

  const PAGE = "compare";
  const SVG = "http://www.w3.org/2000/svg";
  const MARKERS = {
    circle: "M-4,0a4,4 0 1,0 8,0a4,4 0 1,0 -8,0Z",
    square: "M-4,-4H4V4H-4Z",
    diamond: "M0,-5.5L5.5,0L0,5.5L-5.5,0Z",
    "triangle-up": "M0,-5L5,4H-5Z",
    cross: "M-2,-5.5H2V-2H5.5V2H2V5.5H-2V2H-5.5V-2H-2Z",
    x: "M0,-2.5L3,-5.5L5.5,-3L2.5,0L5.5,3L3,5.5L0,2.5L-3,5.5L-5.5,3L-2.5,0L-5.5,-3L-3,-5.5Z",
  };

  let shown = new Map(); // the filters by slot, as the server has them

  const all = (selector) => document.querySelectorAll(`#${PAGE} ${selector}`);
  const row = (slot) => document.getElementById(`${PAGE}-filter-${slot}`);

  // A line as the plots draw it, with the marker of its slot.
  function swatch(place) {
    const { dash, marker } = place.dataset;
    const svg = document.createElementNS(SVG, "svg");
    svg.setAttribute("viewBox", "0 0 40 12");
    svg.setAttribute("aria-hidden", "true");
    const line = document.createElementNS(SVG, "path");
    line.setAttribute("d", "M0,6H40");
    line.setAttribute("stroke-dasharray", (dash || "").replaceAll("px", ""));
    svg.append(line);
    if (marker) {
      const point = document.createElementNS(SVG, "path");
      point.setAttribute("d", MARKERS[marker]);
      point.setAttribute("transform", "translate(20,6)");
      point.classList.add("point");
      svg.append(point);
    }
    return svg;
  }

  document.addEventListener("deskbegin", ({ detail }) => {
    if (detail.page !== PAGE) return;
    for (const place of all(".swatch")) if (!place.firstChild) place.append(swatch(place));
    for (const place of all(".filter-name[data-slot]")) {
      if (place.firstChild) continue;
      const name = Object.assign(document.createElement("input"), { type: "text", maxLength: 40, autocomplete: "off" });
      name.setAttribute("aria-label", `Name of pin ${place.dataset.slot}`);
      place.append(name);
    }
  });

  document.addEventListener("deskreport", ({ detail }) => {
    if (detail.page !== PAGE) return;
    shown = new Map(detail.answer.filters.map((filter) => [String(filter.slot), filter]));
    showFilters();
    showCells();
  });

  document.addEventListener("studyshown", ({ detail }) => detail.page === PAGE && showCells());

  // Columns and cells of the filters that there are. What was found of another filter is seen under none.
  function showCells() {
    for (const part of all("[data-of-slot]")) part.hidden = !shown.has(part.dataset.ofSlot);
    for (const cell of all("[data-filter]")) {
      cell.toggleAttribute("data-other", shown.get(cell.dataset.ofSlot)?.key !== cell.dataset.filter);
    }
  }

  function showFilters() {
    document.getElementById(`${PAGE}-empty`).hidden = shown.size > 1;
    for (const [slot, filter] of shown) {
      const place = row(slot);
      const name = place.querySelector("input[type=text]");
      if (name && (name !== document.activeElement || name.value === name.dataset.shown)) {
        name.value = name.dataset.shown = filter.name;
      }
      write(place.querySelector(".filter-own-name"), filter.name);
      write(place.querySelector(".filter-gains"), filter.gains);
      write(place.querySelector(".filter-design"), filter.design);
      write(place.querySelector(".filter-problem"), filter.problem);
      place.querySelector("input[type=radio]").checked = filter.reference;
      for (const heading of all(`[data-heading="${slot}"]`)) write(heading, filter.name);
    }
  }

  function write(target, text) {
    if (target && target.textContent !== text) target.textContent = text;
  }

  // ------------------------------------------------------------------ hands

  document.addEventListener("click", (event) => {
    const button = event.target instanceof Element ? event.target.closest(`#${PAGE} button[data-pinning]`) : null;
    if (!button) return;
    const { pinning, slot } = button.dataset;
    gainscope.desk.pinning(pinning, ...(slot ? [Number(slot)] : []));
    // A row that goes must not take the focus with it.
    if (pinning === "remove") document.getElementById(`${PAGE}-pin`).focus();
  });

  const named = (target) => (target instanceof Element ? target.closest(`#${PAGE} .filter-name[data-slot]`) : null);

  document.addEventListener("change", ({ target }) => {
    const place = named(target);
    if (!place) return;
    // What the server makes of it is shown.
    target.dataset.shown = target.value;
    gainscope.desk.pinning("rename", Number(place.dataset.slot), target.value);
  });

  document.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && named(event.target)) event.target.blur();
  });
})();
