// The Papers page in the browser: what comes into sight is computed, one part after the other, tables run by run.
(function () {
  "use strict";

  const AHEAD = "300px"; // what is nearer than this counts as in sight
  const LOST = 20000; // ms after which a request is sent again
  let page = null;
  let seq = 0; // of all documents: an answer about the one before is none about this one

  const root = () => document.getElementById("papers");
  const place = (part) => root().querySelector(`[data-part="${part}"]`);
  const theme = () => document.documentElement.dataset.theme;

  function begin(data) {
    if (page) stop();
    page = { ...data, parts: new Map(), asked: null, lost: 0, watch: null, looked: false };
    page.watch = new IntersectionObserver(look, { rootMargin: AHEAD });
    for (const element of root().querySelectorAll("[data-part]")) {
      page.parts.set(element.dataset.part, { near: false, shown: null, runs: 0, stopped: false });
      page.watch.observe(element);
    }
    gainscope.markPage();
    showPlace();
    next();
    return data.paper;
  }

  function stop() {
    page.watch.disconnect();
    clearTimeout(page.lost);
  }

  function look(entries) {
    for (const entry of entries) page.parts.get(entry.target.dataset.part).near = entry.isIntersecting;
    page.looked = true;
    next();
  }

  // ------------------------------------------------------------------ one request in flight

  // Of a table the number of runs decides what it shows, of all others the theme.
  const runsWanted = (part) => (page.tables[part] ? page.seeds || page.tables[part] : 0);
  const wanted = (part) => (part in page.tables ? `runs ${runsWanted(part)}` : theme());
  const isDue = ([part, state]) => state.shown !== wanted(part) && !state.stopped;

  function next() {
    if (!page || !root() || !page.looked || page.asked) return;
    const due = [...page.parts].filter(isDue);
    const near = due.filter(([, state]) => state.near);
    if (!near.length) rest();
    // Tables are counted, in sight or not.
    const [part, state] = near[0] || due.find(([name]) => name in page.tables) || [];
    if (!part) return;
    if (near.length) root().dataset.state = "busy";
    page.asked = { seq: ++seq, part, theme: theme() };
    if (runsWanted(part)) progress(part, state);
    page.lost = setTimeout(() => {
      page.asked = null;
      next();
    }, LOST);
    const request = { seq, paper: page.paper, part, theme: theme(), runs: state.runs || null, wanted: page.seeds };
    dash_clientside.set_props("papers-request", { data: request });
  }

  function finish(answer) {
    if (!page || !page.asked || !answer || answer.seq !== page.asked.seq) return dash_clientside.no_update;
    const { part } = page.asked;
    const state = page.parts.get(part);
    clearTimeout(page.lost);
    for (const cell of answer.cells || []) fill(place(part).querySelector(`[data-cell="${cell.cell}"]`), cell);
    if (answer.error) {
      state.stopped = true;
      place(part).textContent = answer.error;
    } else if (answer.runs === undefined) {
      state.shown = page.asked.theme;
    } else {
      state.runs = answer.runs;
      if (answer.runs === answer.wanted) state.shown = `runs ${answer.wanted}`;
    }
    page.asked = null;
    if (runsWanted(part)) progress(part, state);
    // Once Dash has put the answer in its place.
    setTimeout(() => {
      if (root()) count();
      next();
    });
    return answer.seq;
  }

  // Everything in sight is there; plotly draws a moment later.
  function rest() {
    if (!root() || page.asked) return;
    const drawn = [...root().querySelectorAll(".dash-graph")].every((graph) => {
      const plot = graph.querySelector(".js-plotly-plot");
      return plot && plot._fullLayout && plot._fullLayout.meta;
    });
    if (drawn) root().dataset.state = "settled";
    else requestAnimationFrame(() => page && rest());
  }

  // ------------------------------------------------------------------ what is said

  function made(tag, attributes, ...inside) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    element.append(...inside);
    return element;
  }

  // The mark of a verdict is spelled out for who does not see it; that of an erratum leads there.
  function fill(element, { text, interval, verdict, mark, said, erratum, why }) {
    const link = erratum === null ? {} : { href: `#erratum-${erratum}` };
    const attributes = { class: "verdict", "data-verdict": verdict, ...link };
    const sign = made("span", { "aria-hidden": "true" }, mark);
    const words = made("span", { class: "visually-hidden" }, said);
    const verdictMark = made(erratum === null ? "span" : "a", attributes, sign, words);
    element.replaceChildren(made("div", {}, `${text} `, verdictMark), made("div", { class: "interval" }, interval));
    element.title = why;
  }

  function progress(part, state) {
    const card = document.getElementById(part);
    const all = runsWanted(part);
    const done = state.shown === wanted(part);
    card.querySelector(".progress").textContent = done || state.stopped ? `${state.runs} runs` : `${state.runs} of ${all} runs`;
    card.querySelector(".stop").hidden = done || state.stopped;
  }

  function count() {
    let all = true;
    for (const place of root().querySelectorAll("[data-count]")) {
      const found = root().querySelectorAll(`td [data-verdict="${place.dataset.count}"]`).length;
      place.textContent = found;
    }
    for (const entry of page.parts) if (entry[0] in page.tables && isDue(entry)) all = false;
    document.getElementById("papers-verdicts").dataset.complete = all ? "yes" : "no";
  }

  // ------------------------------------------------------------------ what a hand does

  document.addEventListener("change", (event) => {
    if (!page || !root() || event.target.id !== "papers-seeds") return;
    page.seeds = Number(event.target.value) || null;
    for (const [part, state] of page.parts) if (runsWanted(part)) Object.assign(state, { runs: 0, shown: null, stopped: false });
    const query = new URLSearchParams(location.search);
    if (page.seeds) query.set("seeds", page.seeds);
    else query.delete("seeds");
    history.replaceState(history.state, "", `?${query}${location.hash}`);
    for (const link of root().querySelectorAll("a[download]")) link.search = page.seeds ? `?seeds=${page.seeds}` : "";
    next();
  });

  document.addEventListener("click", (event) => {
    if (!page || !root() || !(event.target instanceof Element) || !root().contains(event.target)) return;
    const button = event.target.closest("[data-stop]");
    if (button) {
      const state = page.parts.get(button.dataset.stop);
      state.stopped = true;
      progress(button.dataset.stop, state);
      count();
    }
    const link = event.target.closest("a.copy");
    if (link) copy(link);
    // The address may be there already.
    const anchor = event.target.closest('a[href^="#"]');
    if (anchor) setTimeout(showPlace);
  });

  async function copy(link) {
    const label = link.textContent;
    if (label !== "Link") return;
    try {
      await navigator.clipboard.writeText(link.href);
      link.textContent = "Copied";
    } catch (error) {
      link.textContent = "In the address bar";
    }
    setTimeout(() => (link.textContent = label), 1500);
  }

  // An erratum is opened by what leads to it.
  function showPlace() {
    const target = root() && location.hash ? document.getElementById(decodeURIComponent(location.hash.slice(1))) : null;
    if (!target || !root().contains(target)) return;
    if (target.tagName === "DETAILS") target.open = true;
    target.scrollIntoView();
  }

  window.addEventListener("hashchange", () => page && showPlace());
  document.addEventListener("themechange", () => page && next());

  window.dash_clientside = Object.assign({}, window.dash_clientside, { papers: { begin, finish } });
})();
