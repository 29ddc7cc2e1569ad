// A page with plots and sliders in the browser: native inputs, one request in flight, the newest waits.
//
// The server holds the rules (layouts/desk.py). This script sends every control as it stands with the names of those a
// hand has moved, and puts the answer back: controls, messages, readouts, link. Plots are updated by Dash.
(function () {
  "use strict";

  const STEPS = 1000;
  const ON_THE_WAY = 5000; // ms that question and answer may take beside the time that the server allows itself
  const RECONNECT = 3000; // ms until a lost connection is tried again
  const REST = 250; // ms without a change after which the plots are redrawn in full
  const SLOW = 500; // ms without an answer after which the page says that it is being computed
  const SETTLED = 700; // ms without a change after which the numbers are read out
  const STEPS_BACK = 50;
  const TYPED = 200; // characters of an entry; longer ones are refused (layouts/questions.py)

  let page = null;
  let latest = null; // the newest socket
  let lastSeq = 0; // of all pages: an answer to the page before is none to this one
  const steps = { past: [], future: [], present: null, open: false }; // what the pages showed: link, controls, pins

  // ------------------------------------------------------------------ elements

  const root = () => (page ? document.getElementById(page.name) : null);
  const element = (name) => document.getElementById(`${page.name}-${name}`);
  const all = (selector) => document.querySelectorAll(`#${page.name} ${selector}`);
  const drawing = (plot) => document.querySelector(`#${plot} .js-plotly-plot`);

  // ms after which a request is sent again: whatever the server has to say it has said by then (layouts/shell.py).
  const lostAfter = () => 1000 * Number(document.querySelector(".app").dataset.answerSeconds) + ON_THE_WAY;

  function hydrate() {
    for (const place of all("[data-input]")) {
      if (place.firstChild) continue;
      const { input, id, control, label } = place.dataset;
      const made = document.createElement("input");
      made.id = id;
      made.dataset.control = control;
      made.setAttribute("aria-label", label);
      // As layouts/inputs.py has it of menus.
      const told = ["about", "error"].map((part) => `${page.name}-${control}-${part}`).filter((part) => document.getElementById(part));
      if (told.length) made.setAttribute("aria-describedby", told.join(" "));
      if (input === "slider") {
        Object.assign(made, { type: "range", min: 0, max: STEPS, step: 1 });
      } else if (input === "switch") {
        made.type = "checkbox";
        made.setAttribute("role", "switch");
        // Its label stands beside it.
        made.removeAttribute("aria-label");
      } else if (input === "radio") {
        Object.assign(made, { type: "radio", name: `${page.name}-${control}`, value: place.dataset.value });
        made.removeAttribute("aria-label");
      } else {
        Object.assign(made, { type: "text", autocomplete: "off", spellcheck: false, maxLength: TYPED });
        // A text to choose from a list, or a number.
        if (input === "list") made.setAttribute("list", `${id}-list`);
        else made.inputMode = "decimal";
      }
      place.append(made);
    }
  }

  // ------------------------------------------------------------------ slider travel

  function span(name) {
    const known = page.sliders[name];
    if (!known) return { low: 1, high: page.samples || 2, curve: 1, whole: true };
    const factor = known.factors ? known.factors[page.values.written] || 1 : 1;
    return { low: known.low, high: known.high / factor, curve: known.curve, whole: known.whole };
  }

  function travelToValue(name, travel) {
    const { low, high, curve, whole } = span(name);
    if (whole) return Math.round(low + (high - low) * travel ** curve);
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
    const value = page.values[name] ?? "";
    const field = element(name);
    const slider = element(`${name}-slider`);
    const typing = field && field.type === "text" && field === document.activeElement && field.value !== field.dataset.shown;
    if (field && field.type === "checkbox") {
      field.checked = value === "on";
    } else if (field && field !== from && !typing) {
      field.value = boxText(value);
      field.dataset.shown = field.value;
      if (field.type === "text" && typeof value === "number") field.title = String(value);
    }
    if (!field) for (const radio of all(`[name="${page.name}-${name}"]`)) radio.checked = radio.value === String(value);
    const number = Number(value);
    if (slider && value !== "" && Number.isFinite(number)) {
      // A step of the one over the samples is a sample.
      if (name === "at") slider.max = span(name).high - 1;
      if (slider !== from) slider.value = Math.round(valueToTravel(name, number) * slider.max);
      slider.setAttribute("aria-valuetext", boxText(number));
      slider.style.setProperty("--travel", `${(100 * slider.value) / slider.max}%`);
    }
  }

  function text(name, content) {
    const target = element(name);
    if (target && target.textContent !== content) target.textContent = content;
  }

  // The page's study has messages of its own, which stay; those that have no place in sight come back as a text.
  function showErrors(errors) {
    for (const name of new Set([...page.wrong, ...Object.keys(errors)])) {
      const message = errors[name] || "";
      text(`${name}-error`, message);
      const field = element(name);
      if (field) field.setAttribute("aria-invalid", message ? "true" : "false");
    }
    page.wrong = Object.keys(errors);
    const placed = (name) => element(`${name}-error`) && !element(`${name}-error`).closest("[hidden]");
    return page.wrong.filter((name) => !placed(name)).map((name) => errors[name]).join(" ");
  }

  function showCards(cards) {
    for (const card of all("[data-metric]")) {
      if (!(card.dataset.metric in cards)) continue;
      const [value, change, tone] = cards[card.dataset.metric];
      const [, shown, line] = card.children;
      if (shown.textContent !== value) shown.textContent = value;
      if (line.textContent !== change) line.textContent = change;
      if (line.dataset.tone !== tone) line.dataset.tone = tone;
    }
  }

  // Rows of a table whose place is on the page: a cell is a text, a text with its tone and perhaps a line below it, or a
  // button that sets controls. Where `columns` say it, every cell after the first bears the slot and the filter that it
  // is about.
  function showRows(tables, columns = {}) {
    for (const [name, rows] of Object.entries(tables)) {
      const body = element(name);
      const key = JSON.stringify([rows, columns[name]]);
      if (!body || body.dataset.shown === key) continue;
      body.dataset.shown = key;
      body.closest(".table-frame").hidden = !rows.length;
      const held = body.contains(document.activeElement) ? document.activeElement.getAttribute("aria-label") : null;
      body.replaceChildren(
        ...rows.map((cells) => {
          const row = document.createElement("tr");
          row.append(
            ...cells.map((content, i) => {
              const cell = document.createElement(i ? "td" : "th");
              if (!i) cell.scope = "row";
              else if (columns[name]) [cell.dataset.ofSlot, cell.dataset.filter] = columns[name][i - 1];
              if (content && content.controls) {
                cell.append(setter(content));
              } else {
                const [said, tone, below] = Array.isArray(content) ? content : [content, ""];
                [cell.textContent, cell.dataset.tone] = [said, tone];
                if (below) cell.append(Object.assign(document.createElement("div"), { className: "below", textContent: below }));
              }
              return cell;
            }),
          );
          return row;
        }),
      );
      // The button that had the focus is another one now.
      if (held) [...body.querySelectorAll("button")].find((button) => button.getAttribute("aria-label") === held)?.focus();
    }
  }

  function setter({ text: said, label, controls }) {
    const button = Object.assign(document.createElement("button"), { type: "button", className: "quiet" });
    button.textContent = said;
    button.setAttribute("aria-label", label);
    button.dataset.controls = JSON.stringify(controls);
    return button;
  }

  // A button that sets controls, such as the way back into the stable region.
  function showOffer(offer) {
    const button = element("offer");
    if (!button) return;
    page.offer = offer ? offer.controls : null;
    button.hidden = !offer;
    if (offer && button.textContent !== offer.text) button.textContent = offer.text;
  }

  function showOwners(owned) {
    const words = { computed: page.method ? "from the method" : "from the design", unused: "not used", free: "" };
    for (const [name, state] of Object.entries(owned)) {
      const row = element(`${name}-row`);
      if (!row) continue;
      row.dataset.state = state;
      text(`${name}-owner`, words[state]);
    }
  }

  // Fields that mean something beside certain others only.
  function showFields(fields) {
    for (const [name, shown] of Object.entries(fields)) {
      for (const field of all(`.field-${name}`)) field.hidden = !shown;
    }
  }

  // What only methods have is laid out with the first of them; plotly does not notice.
  function showMethod(method) {
    page.method = root().dataset.method = method;
    for (const plot of page.inTurn) {
      const drawn = drawing(plot);
      if (drawn && drawn.offsetParent && drawn._fullLayout && drawn._fullLayout.width !== drawn.offsetWidth) {
        window.Plotly.relayout(drawn, { autosize: true });
      }
    }
  }

  function showOffers(offers) {
    for (const [name, allowed] of Object.entries(offers)) {
      const menu = element(name);
      for (const option of menu ? menu.options : []) {
        option.disabled = option.hidden = !allowed.includes(option.value);
      }
    }
  }

  // ------------------------------------------------------------------ talking to the server

  // `live` changes come many to the second, from a slider that moves.
  function edit(name, value, from, live) {
    // What was held was held of the filter as it was.
    if (!["point", "pole"].includes(name)) gainscope.letGo();
    // Another choice in the same menu is another thing; a slider goes on with the same one.
    if (name !== page.touched || element(name)?.tagName === "SELECT") text("note", "");
    page.touched = name;
    // Whoever goes on without the recording that the link names has let it go.
    page.missing = "";
    page.values[name] = value;
    unsettle();
    // In the order of the hand: the server lets later changes win.
    page.changed.delete(name);
    page.changed.add(name);
    show(name, from);
    schedule(live);
  }

  function editAll(values) {
    for (const [name, value] of Object.entries(values)) edit(name, value);
  }

  function schedule(live) {
    page.editedAt = performance.now();
    page.live = page.waiting ? page.live && Boolean(live) : Boolean(live);
    root().dataset.state = "busy";
    // One question at a time, however long its answer takes: the server would compute them all.
    if (page.busy || performance.now() < page.notBefore) page.waiting = true;
    else send();
  }

  // A question asked `again` is still the same one: whichever answer comes first is taken.
  function send(want, again) {
    // What an unanswered request had to say is said again.
    page.changed = new Set([...[...page.flying].filter((name) => !page.changed.has(name)), ...page.changed]);
    page.flying = new Set(page.changed);
    page.acting.push(...page.actions.splice(0));
    page.busy = true;
    page.waiting = page.unseen = false;
    page.seq = ++lastSeq;
    if (!again) page.since = page.seq;
    const live = page.live && !want && page.socket;
    const data = {
      seq: page.seq,
      controls: { ...page.values },
      changed: [...page.changed],
      pins: page.pins,
      pinning: page.acting,
      drawn: page.drawn,
      link: live ? null : page.link,
      want: want || (live ? liveShare() : null),
      theme: document.documentElement.dataset.theme,
      scene: page.scene,
    };
    page.changed.clear();
    clearTimeout(page.watch);
    page.watch = setTimeout(sendAgain, lostAfter());
    clearTimeout(page.slow);
    page.slow = setTimeout(() => root() && (root().dataset.slow = "yes"), SLOW);
    page.askedLive = Boolean(live);
    if (live) page.socket.send(JSON.stringify(data));
    else dash_clientside.set_props(`${page.name}-request`, { data });
  }

  // What is done with pins is done by the server, in turn: see layouts/pinning.py.
  function pinning(...action) {
    text("note", "");
    page.actions.push(action);
    unsettle();
    schedule();
  }

  function sendAgain() {
    if (!root()) return;
    text("note", "The server does not answer; trying again.");
    page.lost = true;
    page.live = false;
    send(null, !page.changed.size && !page.actions.length);
  }

  // What was asked has no answer. Nothing is lost: what a hand has moved is said again with the next question.
  function unanswered({ message }, again) {
    page.busy = page.waiting = false;
    for (const timer of [page.watch, page.slow, page.resting]) clearTimeout(timer);
    delete root().dataset.slow;
    text("note", `The server does not answer: ${message}${again ? "; trying again" : ""}.`);
    page.lost = true;
    if (again) {
      page.waiting = true;
      page.notBefore = performance.now() + 1000 * again;
      page.watch = setTimeout(() => root() && send(), 1000 * again);
    } else {
      page.refused = true;
      page.travels = [];
      root().dataset.state = "settled";
      leave();
    }
  }

  document.addEventListener("callbackrefused", (event) => {
    const { asked, problem, again } = event.detail;
    const mine = root() && asked.inputs.find((input) => input.id === `${page.name}-request`);
    if (!mine) return;
    event.preventDefault();
    if (mine.value.seq === page.seq) unanswered(problem, again);
  });

  // While a slider moves: the path and its close-up every time, the other plots in turn.
  function liveShare() {
    const seen = page.inTurn.filter((plot) => document.getElementById(plot).offsetParent);
    page.turn = (page.turn + 1) % (seen.length || 1);
    return [...page.often, ...seen.slice(page.turn, page.turn + 1)];
  }

  // Past Dash's store, which costs the browser more than everything else together. Without it callbacks do the same.
  function connect(again) {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const { name } = page;
    // Dash knows the path that the application is served under.
    const base = JSON.parse(document.getElementById("_dash-config").textContent).requests_pathname_prefix;
    const socket = new WebSocket(`${scheme}//${location.host}${base}${name}/live`);
    if (latest) latest.close();
    latest = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      if (socket === latest) page.socket = socket;
      // A server that was started anew does not know what the scene shows.
      if (again && page.scene) schedule();
    };
    socket.onmessage = (event) => {
      const length = new DataView(event.data).getUint32(0, true);
      const answer = JSON.parse(new TextDecoder().decode(new Uint8Array(event.data, 4, length)));
      // One to what the server could not even read bears no number: it is about the question under way.
      if (!answer.problem) finish(answer, new Float32Array(event.data, 4 + length));
      else if (root() && (answer.seq ?? page.seq) === page.seq) unanswered(answer.problem, answer.again);
    };
    socket.onclose = () => {
      // Only the page's own socket is replaced: a page that was built anew has one of its own.
      if (socket !== latest || !root()) return;
      const asked = page.socket === socket && page.busy && page.askedLive;
      page.socket = null;
      if (asked) {
        page.busy = false;
        schedule();
      }
      setTimeout(() => socket === latest && root() && connect(true), RECONNECT);
    };
  }

  // Plots drawn by hand while a slider moved are redrawn by plotly once it rests: all with one question, since to run
  // the filter costs the server more than to draw.
  function settle() {
    clearTimeout(page.resting);
    if (page.busy || page.waiting || !root()) return;
    if (page.refused) {
      // Nothing can be drawn until the entry is mended.
      root().dataset.state = "settled";
      return;
    }
    if (!page.stale.size) {
      if (!isDrawn()) {
        page.resting = setTimeout(settle, 30);
        return;
      }
      watchPlots();
      writeLink();
      remember();
      root().dataset.state = "settled";
      document.dispatchEvent(new CustomEvent("desksettled", { detail: { page: page.name, link: page.link } }));
      return;
    }
    // A redraw under the hand would move the axes away from it.
    const rest = gainscope.isHeld() ? REST : page.editedAt + REST - performance.now();
    if (rest > 0) page.resting = setTimeout(settle, rest);
    else send([...page.stale]);
  }

  function writeLink() {
    // A link whose recording is missing works again once the file is there.
    const query = page.missing ? location.search : page.link ? `?${page.link}` : "";
    if (location.search !== query) history.replaceState(history.state, "", query || location.pathname);
    writePageLinks(query);
  }

  // The other pages with a filter show the same one.
  function writePageLinks(query) {
    for (const link of document.querySelectorAll(".page-link.carries")) {
      if (link.search !== query) dash_clientside.set_props(link.id, { href: link.pathname + query });
    }
  }

  // A change that is under way goes along to the next page.
  document.addEventListener(
    "click",
    (event) => {
      const link = event.target instanceof Element ? event.target.closest(".page-link") : null;
      if (!link || !root() || event.ctrlKey || event.metaKey || event.shiftKey) return;
      gainscope.letGo();
      if (page.leaving === "now" || page.refused) return;
      event.preventDefault();
      event.stopPropagation();
      page.leaving = link;
      leave();
    },
    true,
  );

  function leave() {
    if (!page.leaving || page.busy || page.waiting) return;
    const link = page.leaving;
    page.leaving = "now";
    if (page.link !== null) writeLink();
    // Once the link has its new address.
    setTimeout(() => link.click());
  }

  // Dash answers before plotly has drawn.
  function isDrawn() {
    return Object.entries(page.due).every(([plot, seq]) => {
      const drawn = drawing(plot);
      return drawn && drawn._fullLayout && drawn._fullLayout.meta && drawn._fullLayout.meta.seq >= seq;
    });
  }

  function begin(data) {
    if (page) for (const timer of [page.watch, page.slow, page.resting, page.reader]) clearTimeout(timer);
    page = {
      name: data.page,
      often: data.often,
      inTurn: data.inTurn,
      tables: data.tables,
      values: data.controls,
      sliders: data.sliders,
      samples: data.controls.samples,
      pins: data.pins,
      actions: [], // with pins, that have not been sent
      acting: [], // that have been, and are not answered
      changed: new Set(),
      flying: new Set(),
      wrong: [], // the controls whose messages stand on the page
      elsewhere: "", // messages of controls that the page does not show
      travels: [], // undo and redo that wait for an answer
      watch: 0,
      slow: 0,
      lost: false,
      refused: false,
      busy: false,
      waiting: false,
      notBefore: 0, // when the server wants to be asked again
      drawn: {},
      due: {},
      stale: new Set(),
      socket: null,
      live: false,
      turn: 0,
      outdated: [],
      editedAt: 0,
      resting: 0,
      link: null,
      reader: 0,
      touched: "",
      leaving: null,
      seq: 0,
      since: 0, // the first number under which the newest question has been asked
      offer: null,
      method: "",
      scene: "",
      unseen: false, // the scene has not been asked for yet
      missing: data.missing, // what the recording is known by that the link names and the server does not have
    };
    hydrate();
    for (const name of Object.keys(page.values)) show(name);
    text("note", data.notes.join(" "));
    showHistory();
    gainscope.markPage();
    document.dispatchEvent(new CustomEvent("deskbegin", { detail: { page: page.name, missing: data.missing } }));
    connect();
    send();
    return data.controls.scenario;
  }

  function finish(answer, numbers) {
    if (!page || !answer || answer.seq < page.since || answer.seq > page.seq) return dash_clientside.no_update;
    // What else may come has been asked for before this was answered.
    page.since = page.seq + 1;
    page.busy = false;
    page.refused = !answer.ok;
    page.flying.clear();
    clearTimeout(page.slow);
    if (root()) delete root().dataset.slow;
    page.acting = [];
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
    // What a hand dragged has become gains.
    for (const name of ["point", "pole"]) if (answer.ok && !page.changed.has(name)) delete page.values[name];
    const elsewhere = showErrors(answer.errors);
    if (page.elsewhere && !elsewhere) text("note", "");
    page.elsewhere = elsewhere;
    // A note stays until another control is touched.
    const note = [elsewhere, answer.note].filter(Boolean).join(" ");
    if (note) text("note", note);
    if (!numbers) takeDrawn(answer);
    if (answer.ok) report(answer, numbers);
    else document.dispatchEvent(new CustomEvent("deskrefused", { detail: { page: page.name, answer } }));
    if (!numbers && answer.ok) writeLink();
    const outdated = page.outdated.splice(0);
    if (outdated.length) send(outdated);
    else if (page.waiting) send();
    // The plots show already what the scene is to show.
    else if (page.unseen) send([]);
    else page.resting = setTimeout(settle);
    if (page.travels.length && !page.busy) travel(page.travels.shift());
    leave();
    return answer.seq;
  }

  // A refused entry leaves plots as they are, but in the theme of the page.
  function takeDrawn({ seq, drawn }) {
    for (const [plot, key] of Object.entries(drawn)) {
      page.drawn[plot] = key;
      page.stale.delete(plot);
      if (!page.tables.includes(plot)) page.due[plot] = seq;
    }
  }

  function report(answer, numbers) {
    if (numbers) moveLines(answer, numbers);
    for (const details of all("details[data-tables]")) {
      const place = details.dataset.tables;
      if (details.open && !(answer.drawn && place in answer.drawn)) page.stale.add(place);
    }
    Object.assign(root().dataset, { seq: answer.seq, gains: answer.gains.join(" ") });
    for (const [name, content] of Object.entries(answer.texts)) text(name, content);
    element("verdict").dataset.tone = answer.tone;
    page.pins = answer.pins;
    if (element("unpin")) element("unpin").hidden = !page.pins.length;
    showCards(answer.cards);
    showRows(answer.rows);
    showOffer(answer.offer);
    gainscope.showHandles(answer.handles, edit);
    if (page.method !== answer.method) showMethod(answer.method);
    const menus = JSON.stringify([answer.owned, answer.offers, answer.fields, answer.method]);
    if (menus !== page.menus) {
      page.menus = menus;
      showOwners(answer.owned);
      showOffers(answer.offers);
      showFields(answer.fields);
    }
    page.link = answer.link;
    document.dispatchEvent(new CustomEvent("deskreport", { detail: { page: page.name, answer } }));
    clearTimeout(page.reader);
    page.reader = setTimeout(() => readOut(answer), SETTLED);
  }

  function moveLines(answer, numbers) {
    for (const plot of [...page.often, ...page.inTurn]) page.stale.add(plot);
    let at = 0;
    for (const [plot, traces] of Object.entries(answer.lines)) {
      const lines = traces.map(([index, length]) => {
        const line = [index, numbers.subarray(at, at + length), numbers.subarray(at + length, at + 2 * length)];
        at += 2 * length;
        return line;
      });
      gainscope.drawLines(drawing(plot), lines);
    }
    // What has to be drawn anew (another target, another sample) does not wait for the hand to rest.
    page.outdated = answer.outdated;
  }

  function readOut(answer) {
    const seen = [...all("[data-metric]")].filter((card) => card.offsetParent);
    const titles = seen.map(
      (card) => `${card.querySelector(".metric-title").textContent} ${card.querySelector(".metric-value").textContent}`,
    );
    text("live", titles.length ? `${answer.texts.status} ${titles.join(", ")}.` : answer.texts.status);
  }

  // ------------------------------------------------------------------ hands

  const onPage = (target) => page && target instanceof Element && target.closest(`#${page.name}`);

  document.addEventListener("input", (event) => {
    const target = event.target;
    if (!onPage(target) || target.type !== "range") return;
    const name = target.dataset.control;
    edit(name, travelToValue(name, target.value / target.max), target, true);
  });

  function commit(target) {
    const name = target.dataset.control;
    const entered = target.value.trim();
    // From here on it is the page that takes it back.
    target.dataset.shown = target.value;
    if (entered === boxText(page.values[name])) return;
    edit(name, entered, target);
  }

  document.addEventListener("change", (event) => {
    const target = event.target;
    if (!onPage(target) || !target.dataset.control) return;
    if (target.tagName === "SELECT" || target.type === "radio") edit(target.dataset.control, target.value, target);
    else if (target.type === "checkbox") edit(target.dataset.control, target.checked ? "on" : "off", target);
    else if (target.type === "text") commit(target);
  });

  const ARROWS = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 };
  const PAGES = { PageUp: 1, PageDown: -1 };

  // A step of a slider may be less than one of a whole number; a page is a tenth of its way, and more than one.
  document.addEventListener("keydown", (event) => {
    const { target, key } = event;
    const name = onPage(target) && target.type === "range" ? target.dataset.control : null;
    if (!name || !(key in ARROWS || key in PAGES) || !span(name).whole) return;
    event.preventDefault();
    const { low, high } = span(name);
    const by = ARROWS[key] || PAGES[key] * Math.max(2, Math.round((high - low) / 10));
    edit(name, Math.min(high, Math.max(low, Number(page.values[name]) + by)), null, true);
  });

  document.addEventListener("keydown", (event) => {
    const target = event.target;
    if (!onPage(target) || target.type !== "text" || !target.dataset.control) return;
    if (event.key === "Enter") {
      event.preventDefault();
      commit(target);
    } else if (!target.list && (event.key === "ArrowUp" || event.key === "ArrowDown")) {
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
    if (button.id === `${page.name}-pin`) {
      pinning("add");
    } else if (button.id === `${page.name}-unpin` && page.pins.length) {
      pinning("remove", page.pins.at(-1)[0]);
    } else if (button.id === `${page.name}-new-seed`) {
      const seed = Number(page.values.seed);
      edit("seed", Number.isInteger(seed) ? seed + 1 : 1);
    } else if (button.id === `${page.name}-offer` && page.offer) {
      editAll(page.offer);
    }
  });

  // A details element does not let its toggle bubble.
  document.addEventListener(
    "toggle",
    (event) => {
      if (!onPage(event.target) || !event.target.dataset.tables || !event.target.open) return;
      page.stale.add(event.target.dataset.tables);
      settle();
    },
    true,
  );

  // ------------------------------------------------------------------ undo and redo

  // What the page says once it rests is a step; nothing in between is, unless it is taken back. A link says what is
  // shown: controls that count for nothing now may stand otherwise on another page.
  function remember() {
    const now = { link: page.link, state: JSON.stringify([page.values, page.pins]) };
    if (steps.present && steps.present.link !== now.link) {
      steps.past.push(steps.present);
      steps.past.splice(0, steps.past.length - STEPS_BACK);
      steps.future.length = 0;
    }
    steps.present = now;
    steps.open = false;
    showHistory();
  }

  // Something has been moved that is no step yet, and can be taken back.
  function unsettle() {
    steps.open = true;
    showHistory();
  }

  function travel(back) {
    if (!root()) return;
    // Until there is an answer nobody knows what has been moved along.
    if (page.busy || page.waiting) {
      page.travels.push(back);
      return;
    }
    // What was refused is no step: the one before it is where the page goes back to.
    if (!page.refused) remember();
    else if (back && steps.present) {
      restore();
      return;
    }
    const [from, to] = back ? [steps.past, steps.future] : [steps.future, steps.past];
    if (!from.length) return;
    to.push(steps.present);
    steps.present = from.pop();
    restore();
  }

  function restore() {
    gainscope.letGo();
    steps.open = false;
    [page.values, page.pins] = JSON.parse(steps.present.state);
    // What was moved and not understood is not said again.
    page.changed.clear();
    page.flying.clear();
    page.acting = [];
    text("note", "");
    for (const name of Object.keys(page.values)) show(name);
    showHistory();
    schedule();
  }

  function showHistory() {
    for (const [name, there] of [["undo", steps.past.length || steps.open], ["redo", steps.future.length]]) {
      const button = document.getElementById(name);
      if (button) button.disabled = !there;
    }
  }

  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || !root()) return;
    // A box has an undo of its own while something is being typed.
    const { target } = event;
    if (target.type === "text" && target.value !== target.dataset.shown) return;
    const key = event.key.toLowerCase();
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    travel(key === "z" && !event.shiftKey);
  });

  document.addEventListener("click", (event) => {
    const button = event.target instanceof Element ? event.target.closest("button") : null;
    if (button && button.id === "undo") travel(true);
    if (button && button.id === "redo") travel(false);
  });

  document.addEventListener("themechange", () => root() && schedule());

  // A click on a plot whose points are samples chooses the one of the close-up.
  function watchPlots() {
    for (const id of [...page.often, ...page.inTurn]) {
      const plot = drawing(id);
      if (!plot || plot.dataset.watched || !plot.on) continue;
      plot.dataset.watched = "yes";
      plot.on("plotly_afterplot", () => gainscope.placeHandles(id));
      plot.on("plotly_click", (event) => {
        if (plot.layout.meta && "first" in plot.layout.meta) chooseSample(plot.layout.meta, event.points[0]);
      });
      gainscope.placeHandles(id);
    }
  }

  // Such a plot says which sample its first point is, and how many samples lie from point to point and from marker to
  // marker; of a line or markers that show some samples only, every point bears its own.
  function chooseSample(meta, point) {
    const every = point.fullData.mode === "markers" ? meta.every_marker : meta.every;
    edit("at", 1 + (point.customdata ?? meta.first + point.pointNumber * every));
  }

  window.gainscope = Object.assign(window.gainscope || {}, {
    desk: {
      edit,
      editAll,
      pinning,
      text,
      showRows,
      // What a page shows beside its plots follows the page's own script.
      get values() {
        return page.values;
      },
      get samples() {
        return page.samples;
      },
      get busy() {
        return page.busy || page.waiting;
      },
      // Whether what the controls say is not shown yet.
      get settling() {
        return Boolean(root()) && root().dataset.state === "busy";
      },
      // Whether what is shown is not what stands in the controls, and does not become it.
      get refused() {
        return Boolean(root()) && page.refused;
      },
      // Once more, because the server has become able to answer.
      retry() {
        schedule();
      },
      useScene(token) {
        page.scene = token;
        page.unseen = Boolean(token);
        if (page.unseen) root().dataset.state = "busy";
        if (page.unseen && !page.busy) send([]);
      },
    },
  });

  window.dash_clientside = Object.assign({}, window.dash_clientside, {
    desk: {
      begin,
      finish(answer) {
        const outcome = finish(answer);
        if (page) watchPlots();
        return outcome;
      },
    },
  });
})();
