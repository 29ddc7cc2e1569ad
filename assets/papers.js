// The Papers page in the browser: what comes into sight is computed, one part after the other, tables run by run.
(function () {
  "use strict";

  const AHEAD = "300px"; // what is nearer than this counts as in sight
  const LOST = 20000; // ms after which a part is asked for again
  const RETRY = 1000; // ms until then where the server cannot be reached
  let page = null;

  // Null while another document is put in its place, whose own beginning comes after.
  const root = () => document.querySelector(page ? `#papers[data-paper="${page.paper}"]` : "#papers");
  const place = (part) => root().querySelector(`[data-part="${part}"]`);
  const theme = () => document.documentElement.dataset.theme;

  function begin(data) {
    if (page) leave();
    page = { ...data, parts: new Map(), plots: new Set(), asked: null, watch: null, looked: false };
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

  // What is taken from the page is reported as out of sight.
  function look(entries) {
    if (!root() || !entries[0].target.isConnected) {
      leave();
      return;
    }
    for (const entry of entries) page.parts.get(entry.target.dataset.part).near = entry.isIntersecting;
    page.looked = true;
    next();
  }

  function leave() {
    page.watch.disconnect();
    for (const plot of page.plots) Plotly.purge(plot);
    page.plots.clear();
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
    page.asked = { part, theme: theme() };
    if (runsWanted(part)) progress(part, state);
    const query = new URLSearchParams({ theme: theme() });
    if (page.seeds) query.set("wanted", page.seeds);
    ask(page.asked, `/papers/${page.paper}/${part}.json?${query}`);
  }

  async function ask(asked, address) {
    let answer = null;
    let pause = RETRY;
    try {
      const response = await fetch(address, { signal: AbortSignal.timeout(LOST) });
      const refused = response.ok ? null : await gainscope.refusal(response);
      if (response.ok) answer = await response.json();
      else if (refused && !refused.again) answer = refused;
      else if (refused) pause = 1000 * refused.again;
    } catch (error) {
      // It is asked again.
    }
    if (!answer) await new Promise((resolve) => setTimeout(resolve, pause));
    if (!page || page.asked !== asked || !root()) return;
    root().toggleAttribute("data-lost", !answer);
    page.asked = null;
    if (answer) finish(asked, answer);
    next();
  }

  function finish({ part, theme }, answer) {
    const state = page.parts.get(part);
    if (answer.problem) {
      state.stopped = true;
      place(part).textContent = answer.problem.message;
    } else if (answer.cells) {
      for (const cell of answer.cells) fill(place(part).querySelector(`[data-cell="${cell.cell}"]`), cell);
      document.getElementById(part).querySelector(".reasons").replaceChildren(...answer.reasons.map(reason));
      state.runs = answer.runs;
      if (answer.runs === answer.wanted) state.shown = `runs ${answer.wanted}`;
    } else {
      state.shown = theme;
      if (answer.proof) {
        prove(place(part), answer.proof);
      } else {
        draw(place(part), answer.figure);
        document.getElementById(`${part}-rows`).replaceChildren(...answer.rows.map(told));
      }
    }
    if (runsWanted(part)) progress(part, state);
    count();
  }

  // Everything in sight is there; plotly draws a moment later.
  function rest() {
    if (!root() || page.asked) return;
    const drawn = [...root().querySelectorAll("[data-plot]")].every((plot) => plot._fullLayout && plot._fullLayout.meta);
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

  // σ_w is σ with a low w, as in layouts/text.py.
  function typeset(text) {
    const pieces = text.split(/(?<=[A-Za-zα-ωΛ])_([A-Za-z]+)/);
    return pieces.map((piece, index) => (index % 2 ? made("sub", {}, piece) : piece));
  }

  // The mark of a verdict is spelled out for who does not see it; that of an erratum leads there.
  function verdictMark({ verdict, mark, said }) {
    const link = verdict === "erratum" ? { href: `#${said.replace(" ", "-")}` } : {};
    const sign = made("span", { "aria-hidden": "true" }, mark);
    const words = made("span", { class: "visually-hidden" }, said);
    return made(link.href ? "a" : "span", { class: "verdict", "data-verdict": verdict, ...link }, sign, words);
  }

  function fill(element, { text, interval, why, ...verdict }) {
    const number = made("div", {}, `${text} `, verdictMark(verdict));
    element.replaceChildren(number, made("div", { class: "interval" }, interval));
    element.title = why;
  }

  function reason({ where, text, ...verdict }) {
    return made("li", {}, verdictMark(verdict), ...typeset(where ? ` ${where}. ${text}` : ` ${text}`));
  }

  // What a figure shows for who does not see it.
  function told([name, ...cells]) {
    return made("tr", {}, made("th", { scope: "row" }, name), ...cells.map((cell) => made("td", {}, cell)));
  }

  // plotly comes with Dash's first graph.
  async function draw(element, figure) {
    element.dataset.plot = "";
    while (!window.Plotly) await new Promise((resolve) => setTimeout(resolve, 50));
    if (!element.isConnected) return;
    page.plots.add(element);
    Plotly.react(element, figure.data, figure.layout, page.config);
  }

  function prove(element, { formula, lines, holds, label, figure }) {
    const rows = lines.map(([name, value]) => {
      return made("tr", {}, made("th", { scope: "row" }, ...typeset(name)), made("td", {}, ...typeset(value)));
    });
    const verdict = holds ? "The numbers prove it." : "The numbers do not prove it.";
    const parts = [
      made("p", { class: "proof-formula" }, ...typeset(formula)),
      made("table", {}, made("tbody", {}, ...rows)),
      made("p", { class: "proof-verdict", "data-tone": holds ? "good" : "bad" }, verdict),
    ];
    if (figure) parts.push(made("div", { class: "plot-frame", role: "figure", "aria-label": label }));
    for (const plot of element.querySelectorAll("[data-plot]")) {
      Plotly.purge(plot);
      page.plots.delete(plot);
    }
    element.replaceChildren(...parts);
    if (figure) draw(parts[3], figure);
  }

  function progress(part, state) {
    const card = document.getElementById(part);
    const done = state.shown === wanted(part);
    const of = done || state.stopped ? "" : ` of ${runsWanted(part)}`;
    card.querySelector(".progress").textContent = `${state.runs}${of} runs`;
    const button = card.querySelector("[data-stop]");
    button.hidden = done;
    button.textContent = state.stopped ? "Continue" : "Stop";
    card.querySelector("a[download]").search = state.runs ? `?seeds=${state.runs}` : "";
  }

  function count() {
    for (const place of root().querySelectorAll("[data-count]")) {
      place.textContent = root().querySelectorAll(`td [data-verdict="${place.dataset.count}"]`).length;
    }
    const due = [...page.parts].some((entry) => entry[0] in page.tables && isDue(entry));
    document.getElementById("papers-verdicts").dataset.complete = due ? "no" : "yes";
  }

  // ------------------------------------------------------------------ what a hand does

  document.addEventListener("change", (event) => {
    if (!page || !root() || event.target.id !== "papers-seeds") return;
    page.seeds = Number(event.target.value) || null;
    for (const [part, state] of page.parts) {
      if (runsWanted(part)) Object.assign(state, { runs: 0, shown: null, stopped: false });
    }
    const query = new URLSearchParams(location.search);
    if (page.seeds) query.set("seeds", page.seeds);
    else query.delete("seeds");
    history.replaceState(history.state, "", `?${query}${location.hash}`);
    next();
  });

  document.addEventListener("click", (event) => {
    if (!page || !root() || !(event.target instanceof Element) || !root().contains(event.target)) return;
    const button = event.target.closest("[data-stop]");
    if (button) {
      const state = page.parts.get(button.dataset.stop);
      state.stopped = !state.stopped;
      progress(button.dataset.stop, state);
      count();
      next();
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

  // A hash that is no text leads nowhere.
  function hashName() {
    try {
      return decodeURIComponent(location.hash.slice(1));
    } catch (error) {
      return "";
    }
  }

  // An erratum is opened by what leads to it.
  function showPlace() {
    const target = root() && location.hash ? document.getElementById(hashName()) : null;
    if (!target || !root().contains(target)) return;
    if (target.tagName === "DETAILS") target.open = true;
    target.scrollIntoView();
  }

  window.addEventListener("hashchange", () => page && showPlace());
  document.addEventListener("themechange", () => page && next());

  window.dash_clientside = Object.assign({}, window.dash_clientside, { papers: { begin } });
})();
