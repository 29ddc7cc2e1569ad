// A page's study in the browser: asked for when the page has settled, shown as it comes (layouts/studies.py).
(function () {
  "use strict";

  const RECONNECT = 2000; // ms until a lost connection is tried again
  let study = null;
  let lastSeq = 0;

  const card = () => document.querySelector(`#${study.page} [data-study]`);
  const part = (name) => document.getElementById(`${study.page}-study-${name}`);
  const theme = () => document.documentElement.dataset.theme;

  // ------------------------------------------------------------------ asking

  document.addEventListener("deskbegin", ({ detail }) => {
    leave();
    if (!document.querySelector(`#${detail.page} [data-study]`)) return;
    study = {
      page: detail.page,
      socket: null,
      seq: 0,
      query: null, // what the page shows
      asked: "", // the theme and what was asked for, of the newest question
      askedQuery: null,
      shownQuery: null, // what the study that is shown was asked with
      errors: [],
      share: 0, // of its work that is done
      step: "", // that a screen reader was told of last
      figures: new Set(),
    };
    connect();
  });

  document.addEventListener("desksettled", ({ detail }) => {
    if (!study || detail.page !== study.page) return;
    study.query = detail.link;
    markStale();
    want();
  });

  // While an entry is refused the page does not settle.
  document.addEventListener("themechange", () => study && study.query !== null && card() && want());

  function want() {
    if (`${theme()}|${study.query}` === study.asked) return;
    // What was stopped stays stopped until something else is asked for.
    ask(["stopped", "over"].includes(card().dataset.study) && study.query === study.askedQuery ? "look" : "");
  }

  function connect() {
    const mine = study;
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const base = JSON.parse(document.getElementById("_dash-config").textContent).requests_pathname_prefix;
    const socket = new WebSocket(`${scheme}//${location.host}${base}${mine.page}/study`);
    socket.onopen = () => {
      if (mine !== study) return;
      mine.socket = socket;
      // A server that was started anew computes the same again; what is there already stays.
      const wanted = `${theme()}|${mine.query}`;
      const there = ["stopped", "over", "done", "failed"].includes(card().dataset.study) && mine.asked === wanted;
      if (mine.query !== null && !there) ask();
    };
    socket.onmessage = (event) => event.data.text().then((text) => mine === study && hear(JSON.parse(text)));
    socket.onclose = () => {
      mine.socket = null;
      if (mine !== study) return;
      if (!card()) return;
      if (["asked", "running", "queued"].includes(card().dataset.study)) say("lost", "The server does not answer; trying again.");
      setTimeout(() => mine === study && card() && connect(), RECONNECT);
    };
    mine.close = () => socket.close();
  }

  // What is wanted: to "stop", to "look" at what was stopped, else the study.
  function ask(wish) {
    if (!study.socket) return;
    study.seq = ++lastSeq;
    if (wish !== "stop") study.asked = `${theme()}|${study.query}`;
    if (!wish) {
      study.askedQuery = study.query;
      study.share = 0;
      card().dataset.study = "asked";
    }
    const question = { seq: study.seq, query: study.query, theme: theme() };
    study.socket.send(JSON.stringify(wish ? { ...question, [wish]: true } : question));
  }

  function leave() {
    if (!study) return;
    const left = study;
    study = null;
    for (const plot of left.figures) window.Plotly.purge(plot);
    left.close();
  }

  // ------------------------------------------------------------------ hearing

  function hear(message) {
    if (!card()) {
      leave();
      return;
    }
    if (message.problem) {
      say("failed", `The server does not answer: ${message.problem.message}.`);
      return;
    }
    if (message.seq !== study.seq) return;
    if (message.state === "again") {
      ask();
      return;
    }
    showErrors(message.errors || {});
    // Of what has only begun there may be nothing to show.
    const content = Object.keys(message.content || {}).length ? message.content : null;
    if (content) study.shownQuery = study.askedQuery;
    markStale();
    if (message.of) study.share = message.done / message.of;
    part("bar").value = message.state === "done" ? 1 : study.share;
    say(message.state, words(message));
    if (content) show(content);
  }

  // What answers another question than the page's keeps its place until there is a part of the answer; until then it
  // looks it and cannot be taken. Its buttons keep the focus.
  const isStale = () => study.shownQuery !== null && study.shownQuery !== study.query;

  function markStale() {
    card().toggleAttribute("data-stale", isStale());
    for (const button of card().querySelectorAll(".study-results button")) {
      if (isStale()) button.setAttribute("aria-disabled", "true");
      else button.removeAttribute("aria-disabled");
    }
  }

  function words({ state, place, seconds, remaining, minutes }) {
    const percent = `${Math.floor(100 * study.share)} %`;
    switch (state) {
      case "queued":
        return `Other studies are running; place ${place} in the queue.`;
      case "running":
        return remaining === null ? "Begun." : `${percent}, about ${duration(remaining)} left.`;
      case "done":
        return seconds ? `Done in ${duration(seconds)}.` : "Done.";
      case "stopped":
        return study.share ? `Stopped at ${percent}.` : "Stopped.";
      case "over":
        return `Ended at ${percent}: a study may take ${minutes} minutes here.`;
      case "waiting":
        return "Too many studies are waiting; try again later.";
      case "failed":
        return "The study failed; the server's log says why.";
      default:
        return "";
    }
  }

  function duration(seconds) {
    if (seconds < 1) return `${Math.max(0.1, seconds).toFixed(1)} s`;
    if (seconds < 100) return `${Math.round(seconds)} s`;
    return `${Math.round(seconds / 60)} min`;
  }

  function say(state, told) {
    card().dataset.study = state;
    // What is refused says so beside its field.
    const text = isStale() && state !== "refused" ? `${told} Shown: the answer to the question before.` : told;
    const line = part("text");
    if (line.textContent !== text) line.textContent = text;
    // While it runs a screen reader is told of quarters.
    const step = state === "running" ? Math.floor(4 * study.share) : text;
    if (step && step !== study.step) part("said").textContent = text;
    study.step = step;
    const going = state === "running" || state === "queued";
    const button = part("stop");
    button.textContent = going ? "Stop" : "Run again";
    button.hidden = !going && !["stopped", "over", "waiting", "failed"].includes(state);
  }

  function showErrors(errors) {
    for (const name of study.errors) place(name, "");
    study.errors = Object.keys(errors);
    const homeless = study.errors.filter((name) => !place(name, errors[name]));
    part("error").textContent = homeless.map((name) => errors[name]).join(" ");
  }

  // Whether the page has a field of that name in sight, beside which the message stands.
  function place(name, message) {
    const line = document.getElementById(`${study.page}-${name}-error`);
    if (!line || line.closest("[hidden]")) return false;
    line.textContent = message;
    const field = document.getElementById(`${study.page}-${name}`);
    if (field) field.setAttribute("aria-invalid", message ? "true" : "false");
    return true;
  }

  // ------------------------------------------------------------------ showing

  function show({ figures, texts, rows, columns, offers }) {
    for (const [id, figure] of Object.entries(figures || {})) draw(id, figure);
    for (const [name, text] of Object.entries(texts || {})) gainscope.desk.text(name, text);
    if (rows) gainscope.desk.showRows(rows, columns);
    for (const [name, offer] of Object.entries(offers || {})) {
      const button = document.getElementById(`${study.page}-${name}`);
      if (!button) continue;
      button.hidden = !offer;
      if (!offer) continue;
      button.dataset.controls = JSON.stringify(offer.controls);
      if (button.textContent !== offer.text) button.textContent = offer.text;
    }
    document.dispatchEvent(new CustomEvent("studyshown", { detail: { page: study.page } }));
  }

  // plotly comes with Dash's first graph. The plot is inside the element that is named, as in a graph of Dash.
  async function draw(id, figure) {
    const mine = study;
    while (!window.Plotly) await new Promise((resolve) => setTimeout(resolve, 50));
    const frame = document.getElementById(id);
    if (mine !== study || !frame) return;
    if (!frame.firstElementChild) frame.append(document.createElement("div"));
    const plot = frame.firstElementChild;
    mine.figures.add(plot);
    await window.Plotly.react(plot, figure.data, figure.layout, CONFIG);
    document.dispatchEvent(new CustomEvent("studydrawn", { detail: { page: mine.page, id, plot } }));
  }

  const CONFIG = {
    displaylogo: false,
    responsive: true,
    scrollZoom: false,
    // As in layouts/components.py.
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d", "sendChartToCloud"],
    plotlyServerURL: "",
  };

  // ------------------------------------------------------------------ hands

  document.addEventListener("click", (event) => {
    const button = study && event.target instanceof Element ? event.target.closest("button") : null;
    if (!button || !card()) return;
    if (button.id === `${study.page}-study-stop`) {
      const going = ["running", "queued"].includes(card().dataset.study);
      ask(going ? "stop" : "");
    } else if (button.dataset.controls && button.closest(`#${study.page}`) && !button.matches("[aria-disabled]")) {
      gainscope.desk.editAll(JSON.parse(button.dataset.controls));
    }
  });
})();
