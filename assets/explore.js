// The Explore page in the browser: native inputs, one request in flight, the newest waits.
//
// The server holds the rules. This script sends every control as it stands with the names of those a hand has moved,
// and puts the answer back: controls, messages, readouts, link. Plots are updated by Dash.
(function () {
  "use strict";

  const STEPS = 1000;
  const PATIENCE = 3000; // ms after which a change no longer waits for the answer to the one before
  const LOST = 10000; // ms after which a request is sent again
  const RECONNECT = 3000; // ms until a lost connection is tried again
  const REST = 250; // ms without a change after which the plots are redrawn in full
  const SETTLED = 700; // ms without a change after which the numbers are read out
  const PAGE = "explore";

  // Plots by how often they follow a moving slider.
  const ALWAYS = ["explore-path", "explore-close-up"];
  const OTHERS = ["explore-error", "explore-time", "explore-stability"];

  const NUMBERS = "explore-numbers";

  let page = null;
  let latest = null; // the newest socket

  // ------------------------------------------------------------------ elements

  const element = (name) => document.getElementById(`${PAGE}-${name}`);

  function hydrate(root) {
    for (const place of root.querySelectorAll("[data-input]")) {
      if (place.firstChild) continue;
      const { input, id, control, label } = place.dataset;
      const made = document.createElement("input");
      made.id = id;
      made.dataset.control = control;
      made.setAttribute("aria-label", label);
      made.setAttribute("aria-describedby", `${PAGE}-${control}-error`);
      if (input === "slider") {
        Object.assign(made, { type: "range", min: 0, max: STEPS, step: 1 });
      } else {
        Object.assign(made, { type: "text", inputMode: "decimal", autocomplete: "off", spellcheck: false });
      }
      place.append(made);
    }
  }

  // ------------------------------------------------------------------ slider travel

  function span(name) {
    const known = page.sliders[name];
    if (!known) return { low: 1, high: page.samples || 2, curve: 1 };
    const factor = known.factors ? known.factors[page.values.written] || 1 : 1;
    return { low: known.low, high: known.high / factor, curve: known.curve };
  }

  function travelToValue(name, travel) {
    const { low, high, curve } = span(name);
    if (name === "at") return Math.round(low + (high - low) * travel);
    if (curve === "log") return Number((low * (high / low) ** travel).toPrecision(4));
    const value = low + (high - low) * travel ** curve;
    // As many digits as one step of the slider tells apart.
    const step = Math.max(((high - low) * curve * travel ** (curve - 1)) / STEPS, (high - low) * STEPS ** -curve);
    return Number(value.toFixed(Math.min(15, Math.max(0, Math.ceil(-Math.log10(step)) + 1))));
  }

  function valueToTravel(name, value) {
    const { low, high, curve } = span(name);
    const clamped = Math.min(high, Math.max(low, value));
    if (curve === "log") return Math.log(clamped / low) / Math.log(high / low);
    return ((clamped - low) / (high - low)) ** (1 / curve);
  }

  // ------------------------------------------------------------------ showing

  function boxText(value) {
    if (typeof value !== "number") return value === null || value === undefined ? "" : String(value);
    return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(5)));
  }

  function show(name, from) {
    const value = page.values[name];
    const field = element(name);
    const slider = element(`${name}-slider`);
    const typing = field && field.type === "text" && field === document.activeElement && field.value !== field.dataset.shown;
    if (field && field !== from && !typing) {
      field.value = boxText(value);
      field.dataset.shown = field.value;
      if (field.type === "text" && typeof value === "number") field.title = String(value);
    }
    const number = Number(value);
    if (slider && value !== "" && Number.isFinite(number)) {
      if (slider !== from) slider.value = Math.round(valueToTravel(name, number) * STEPS);
      slider.setAttribute("aria-valuetext", boxText(number));
      slider.style.setProperty("--travel", `${slider.value / (STEPS / 100)}%`);
    }
  }

  function text(name, content) {
    const target = element(name);
    if (target && target.textContent !== content) target.textContent = content;
  }

  function showErrors(errors) {
    const messages = JSON.stringify(errors);
    if (messages === page.messages) return "";
    page.messages = messages;
    for (const line of document.querySelectorAll("#explore .field-error")) {
      const name = line.id.slice(PAGE.length + 1, -"-error".length);
      const message = errors[name] || "";
      if (line.textContent !== message) line.textContent = message;
      const field = element(name);
      if (field) field.setAttribute("aria-invalid", message ? "true" : "false");
    }
    const placed = (name) => element(`${name}-error`);
    const others = Object.keys(errors).filter((name) => !placed(name));
    return others.map((name) => errors[name]).join(" ");
  }

  function showCards(cards) {
    for (const card of document.querySelectorAll("#explore [data-metric]")) {
      const [value, change, tone] = cards[card.dataset.metric];
      const [, shown, line] = card.children;
      if (shown.textContent !== value) shown.textContent = value;
      if (line.textContent !== change) line.textContent = change;
      if (line.dataset.tone !== tone) line.dataset.tone = tone;
    }
  }

  function showOwners(owned) {
    const words = { computed: "from the design", unused: "not used", free: "" };
    for (const [name, state] of Object.entries(owned)) {
      element(`${name}-row`).dataset.state = state;
      text(`${name}-owner`, words[state]);
    }
  }

  function showOffers(offers) {
    for (const [name, allowed] of Object.entries(offers)) {
      for (const option of element(name).options) {
        option.disabled = option.hidden = !allowed.includes(option.value);
      }
    }
  }

  // ------------------------------------------------------------------ talking to the server

  // `live` changes come many to the second, from a slider that moves.
  function edit(name, value, from, live) {
    if (name !== page.touched) text("note", "");
    page.touched = name;
    page.values[name] = value;
    // In the order of the hand: the server lets later changes win.
    page.changed.delete(name);
    page.changed.add(name);
    show(name, from);
    schedule(live);
  }

  function schedule(live) {
    page.editedAt = performance.now();
    page.live = page.waiting ? page.live && Boolean(live) : Boolean(live);
    document.getElementById("explore").dataset.state = "busy";
    if (page.busy && performance.now() - page.sentAt < PATIENCE) {
      page.waiting = true;
    } else {
      send();
    }
  }

  function send(want) {
    // What an unanswered request had to say is said again.
    page.changed = new Set([...[...page.flying].filter((name) => !page.changed.has(name)), ...page.changed]);
    page.flying = new Set(page.changed);
    page.busy = true;
    page.waiting = false;
    page.sentAt = performance.now();
    page.seq += 1;
    const live = page.live && !want && page.socket;
    const data = {
      seq: page.seq,
      controls: { ...page.values },
      changed: [...page.changed],
      pin: page.pin,
      drawn: page.drawn,
      want: want || (live ? liveShare() : null),
      theme: document.documentElement.dataset.theme,
    };
    page.changed.clear();
    clearTimeout(page.watch);
    page.watch = setTimeout(sendAgain, LOST);
    page.askedLive = Boolean(live);
    if (live) page.socket.send(JSON.stringify(data));
    else dash_clientside.set_props("explore-request", { data });
  }

  function pin() {
    page.pinNext = false;
    page.pin = page.experiment;
    schedule();
  }

  function sendAgain() {
    if (!document.getElementById("explore")) return;
    text("note", "The server does not answer; trying again.");
    page.lost = true;
    page.live = false;
    send();
  }

  // While a slider moves: the path and its close-up every time, the other plots in turn.
  function liveShare() {
    page.turn = (page.turn + 1) % OTHERS.length;
    return [...ALWAYS, OTHERS[page.turn]];
  }

  // Past Dash's store, which costs the browser more than everything else together. Without it callbacks do the same.
  function connect() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}${location.pathname.replace(/\/$/, "")}/explore/live`);
    latest = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => (page.socket = socket);
    socket.onmessage = (event) => {
      const length = new DataView(event.data).getUint32(0, true);
      const answer = JSON.parse(new TextDecoder().decode(new Uint8Array(event.data, 4, length)));
      finish(answer, new Float32Array(event.data, 4 + length));
    };
    socket.onclose = () => {
      // Only the page's own socket is replaced: a page that was built anew has one of its own.
      if (socket !== latest || !document.getElementById("explore")) return;
      const asked = page.socket === socket && page.busy && page.askedLive;
      page.socket = null;
      if (asked) {
        page.busy = false;
        schedule();
      }
      setTimeout(() => socket === latest && connect(), RECONNECT);
    };
  }

  // Plots drawn by hand while a slider moved are redrawn by plotly, one at a time, once it rests.
  function settle() {
    clearTimeout(page.resting);
    if (page.busy || page.waiting || !document.getElementById("explore")) return;
    if (page.refused) {
      // Nothing can be drawn until the entry is mended.
      document.getElementById("explore").dataset.state = "settled";
      return;
    }
    if (!page.stale.size) {
      if (!isDrawn()) {
        page.resting = setTimeout(settle, 30);
        return;
      }
      writeLink();
      document.getElementById("explore").dataset.state = "settled";
      return;
    }
    const rest = page.editedAt + REST - performance.now();
    if (rest > 0) page.resting = setTimeout(settle, rest);
    else send([page.stale.values().next().value]);
  }

  function writeLink() {
    const query = page.link ? `?${page.link}` : "";
    if (location.search !== query) history.replaceState(history.state, "", query || location.pathname);
  }

  // Dash answers before plotly has drawn.
  function isDrawn() {
    return Object.entries(page.due).every(([plot, seq]) => {
      const drawn = document.querySelector(`#${plot} .js-plotly-plot`);
      return drawn && drawn._fullLayout && drawn._fullLayout.meta && drawn._fullLayout.meta.seq >= seq;
    });
  }

  function begin(data) {
    if (page) for (const timer of [page.watch, page.resting, page.reader]) clearTimeout(timer);
    page = {
      values: data.controls,
      sliders: data.sliders,
      samples: data.controls.samples,
      pin: data.pin,
      changed: new Set(),
      flying: new Set(),
      watch: 0,
      lost: false,
      refused: false,
      pinNext: false,
      busy: false,
      waiting: false,
      sentAt: 0,
      seq: 0,
      drawn: {},
      due: {},
      stale: new Set(),
      socket: null,
      live: false,
      turn: 0,
      outdated: [],
      editedAt: 0,
      resting: 0,
      experiment: null,
      link: null,
      reader: 0,
      touched: "",
    };
    hydrate(document.getElementById("explore"));
    for (const name of Object.keys(page.values)) show(name);
    text("note", data.notes.join(" "));
    if (page.socket === null) connect();
    send();
    return data.controls.scenario;
  }

  function finish(answer, numbers) {
    if (!page || !answer || answer.seq !== page.seq) return dash_clientside.no_update;
    page.busy = false;
    page.refused = !answer.ok;
    page.flying.clear();
    clearTimeout(page.watch);
    if (page.lost) text("note", "");
    page.lost = false;
    const rescaled = answer.ok && (answer.controls.written !== page.values.written || answer.samples !== page.samples);
    if (answer.ok) page.samples = answer.samples;
    for (const [name, value] of Object.entries(answer.controls)) {
      if (page.changed.has(name)) continue;
      const moved = page.values[name] !== value;
      page.values[name] = value;
      if (moved || rescaled) show(name, document.activeElement === element(`${name}-slider`) ? document.activeElement : null);
    }
    const elsewhere = showErrors(answer.errors);
    // A note stays until another control is touched.
    const note = [elsewhere, answer.note].filter(Boolean).join(" ");
    if (note) text("note", note);
    if (answer.ok) report(answer, numbers);
    if (!numbers && answer.ok) writeLink();
    const outdated = page.outdated.splice(0);
    if (page.pinNext && !page.waiting) pin();
    else if (outdated.length) send(outdated);
    else if (page.waiting) send();
    else page.resting = setTimeout(settle);
    return answer.seq;
  }

  function report(answer, numbers) {
    if (numbers) moveLines(answer, numbers);
    else for (const [plot, key] of Object.entries(answer.drawn)) {
      page.drawn[plot] = key;
      page.stale.delete(plot);
      if (plot !== NUMBERS) page.due[plot] = answer.seq;
    }
    Object.assign(document.getElementById("explore").dataset, { seq: answer.seq, gains: answer.gains.join(" ") });
    if (element("numbers-details").open && !(answer.drawn && NUMBERS in answer.drawn)) page.stale.add(NUMBERS);
    page.experiment = answer.experiment;
    text("status", answer.status);
    element("status").dataset.tone = answer.tone;
    text("formula", answer.formula);
    text("description", answer.description);
    text("slice", answer.slice);
    text("scale", answer.scale);
    text("at-text", answer.cursor);
    element("unpin").hidden = !answer.pinned;
    showCards(answer.cards);
    const menus = JSON.stringify([answer.owned, answer.offers]);
    if (menus !== page.menus) {
      page.menus = menus;
      showOwners(answer.owned);
      showOffers(answer.offers);
    }
    page.link = answer.link;
    clearTimeout(page.reader);
    page.reader = setTimeout(() => readOut(answer), SETTLED);
  }

  function moveLines(answer, numbers) {
    for (const plot of [...ALWAYS, ...OTHERS]) page.stale.add(plot);
    let at = 0;
    for (const [plot, traces] of Object.entries(answer.lines)) {
      const lines = traces.map(([index, length]) => {
        const line = [index, numbers.subarray(at, at + length), numbers.subarray(at + length, at + 2 * length)];
        at += 2 * length;
        return line;
      });
      gainscope.drawLines(document.querySelector(`#${plot} .js-plotly-plot`), lines);
    }
    for (const marker of document.querySelectorAll("#explore-stability .scatterlayer .point")) {
      marker.style.fill = `var(--${answer.tone})`;
    }
    // What has to be drawn anew (another target, another sample) does not wait for the hand to rest.
    page.outdated = answer.outdated;
  }

  function readOut(answer) {
    const titles = [...document.querySelectorAll("#explore [data-metric]")].map(
      (card) => `${card.querySelector(".metric-title").textContent} ${card.querySelector(".metric-value").textContent}`,
    );
    text("live", `${answer.status} ${titles.join(", ")}.`);
  }

  // ------------------------------------------------------------------ hands

  const onPage = (target) => page && target instanceof Element && target.closest("#explore");

  document.addEventListener("input", (event) => {
    const target = event.target;
    if (!onPage(target) || target.type !== "range") return;
    const name = target.dataset.control;
    edit(name, travelToValue(name, target.value / STEPS), target, true);
  });

  function commit(target) {
    const name = target.dataset.control;
    const entered = target.value.trim();
    if (entered === boxText(page.values[name])) return;
    edit(name, entered, target);
  }

  document.addEventListener("change", (event) => {
    const target = event.target;
    if (!onPage(target) || !target.dataset.control) return;
    if (target.tagName === "SELECT") edit(target.dataset.control, target.value, target);
    else if (target.type === "text") commit(target);
  });

  document.addEventListener("keydown", (event) => {
    const target = event.target;
    if (!onPage(target) || target.type !== "text") return;
    if (event.key === "Enter") {
      event.preventDefault();
      commit(target);
    } else if ((event.key === "ArrowUp" || event.key === "ArrowDown") && target.dataset.control) {
      event.preventDefault();
      nudge(target, event.key === "ArrowUp" ? 1 : -1);
    }
  });

  // One unit of the last digit that stands in the box.
  function nudge(target, direction) {
    const number = Number(target.value);
    if (target.value.trim() === "" || !Number.isFinite(number) || /e/i.test(target.value)) return;
    const digits = (target.value.split(".")[1] || "").length;
    target.value = (number + direction * 10 ** -digits).toFixed(digits);
    commit(target);
  }

  document.addEventListener("submit", (event) => {
    if (onPage(event.target)) event.preventDefault();
  });

  document.addEventListener("click", (event) => {
    const button = onPage(event.target) ? event.target.closest("button") : null;
    if (!button) return;
    if (button.id === "explore-pin" && page.experiment) {
      // What is on its way belongs to what is pinned.
      if (page.busy || page.waiting) page.pinNext = true;
      else pin();
    } else if (button.id === "explore-unpin") {
      page.pin = null;
      schedule();
    } else if (button.id === "explore-new-seed") {
      const seed = Number(page.values.seed);
      edit("seed", Number.isInteger(seed) ? seed + 1 : 1);
    }
  });

  // A details element does not let its toggle bubble.
  document.addEventListener(
    "toggle",
    (event) => {
      if (!page || event.target.id !== "explore-numbers-details" || !event.target.open) return;
      page.stale.add(NUMBERS);
      settle();
    },
    true,
  );

  document.addEventListener("themechange", () => page && schedule());

  // A click on a plot chooses the sample of the close-up.
  function watchClicks() {
    for (const id of ["explore-path", "explore-close-up", "explore-time", "explore-error"]) {
      const plot = document.querySelector(`#${id} .js-plotly-plot`);
      if (!plot || plot.dataset.watched || !plot.on) continue;
      plot.dataset.watched = "yes";
      plot.on("plotly_click", (event) => chooseSample(plot.layout.meta, event.points[0]));
    }
  }

  // Every plot says which sample its first point is, and how many samples lie from point to point and from marker to
  // marker.
  function chooseSample(meta, point) {
    const every = point.fullData.mode === "markers" ? meta.every_marker : meta.every;
    edit("at", meta.first + point.pointNumber * every + 1);
  }

  window.dash_clientside = Object.assign({}, window.dash_clientside, {
    explore: {
      begin,
      finish(answer) {
        const outcome = finish(answer);
        watchClicks();
        return outcome;
      },
    },
  });
})();
