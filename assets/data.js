// The Data page: files are chosen, dropped and sent; how they are read is shown; results are saved.
(function () {
  "use strict";

  // assets/recordings.js comes after this script.
  const files = () => gainscope.recordings;
  const base = () => files().base();
  let missing = ""; // what the recording is known by that the link names and the server does not have
  let terms = null;
  let choice = new AbortController(); // of the newest choice of a file: the ones before it count for nothing any more

  const part = (name) => document.getElementById(`data-${name}`);
  const root = () => part("drop") && document.getElementById("data");

  function make(tag, properties, ...children) {
    const made = Object.assign(document.createElement(tag), properties);
    made.append(...children);
    return made;
  }

  function fill(place, ...children) {
    place.replaceChildren(...children);
  }

  function say(name, text) {
    if (part(name).textContent !== text) part(name).textContent = text;
  }

  const size = (bytes) => (bytes < 1e6 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(1)} MB`);

  // ------------------------------------------------------------------ loading

  document.addEventListener("deskbegin", ({ detail }) => {
    choice.abort();
    if (detail.page !== "data") return;
    missing = detail.missing;
    hydrate();
    showKept();
    showTerms();
  });

  function hydrate() {
    const place = part("file-place");
    if (!place.firstChild) place.append(make("input", { type: "file", id: "data-file", accept: ".csv,.tsv,.txt,.dat,.log,.gz,text/*" }));
    for (const spot of document.querySelectorAll("#data [data-keep]")) {
      if (spot.firstChild) continue;
      const { keep, checked } = spot.dataset;
      spot.append(make("input", { type: "radio", name: "data-keep", id: `data-keep-${keep}`, value: keep, checked: checked === "yes" }));
    }
  }

  async function showTerms() {
    const asked = fetch(`${base()}recordings`).then((answer) => (answer.ok ? answer.json() : null));
    terms = await asked.catch(() => null);
    if (!terms || !root()) return;
    const bound = `Up to ${size(terms.most_bytes)} and 200,000 rows.`;
    const where = terms.problem
      ? `This server keeps no files (${terms.problem}): they stay in its memory for a while, and in this browser.`
      : `On this server a file is kept for ${terms.days} days after its last use; whoever has the link can see it.`;
    say("terms", `${bound} ${where}`);
  }

  // A file is chosen. `find` gives it, `keep` says where it is kept; what is under way for the choice before it ends.
  async function choose(name, keep, find) {
    choice.abort();
    choice = new AbortController();
    const { signal } = choice;
    // The page may have been left as well.
    const counts = () => !signal.aborted && root();
    const bar = part("progress");
    Object.assign(bar, { hidden: false, value: 0 });
    say("data-error", "");
    say("said", `Sending ${name} …`);
    try {
      const blob = await find(signal);
      signal.throwIfAborted();
      if (terms && blob.size > terms.most_bytes) {
        throw new Error(`${name} has ${size(blob.size)}; at most ${size(terms.most_bytes)} are taken. Leave out columns, rows or tracks that are not needed, or pack it with gzip.`);
      }
      const progress = (loaded, total) => {
        if (!counts()) return;
        bar.value = loaded / total;
        if (loaded === total) say("said", `Reading ${name} …`);
      };
      const answer = await files().send(blob, name, keep, progress, signal);
      const place = counts() && (await placed(answer, blob, keep));
      if (!counts()) return;
      say("said", `${answer.name}, ${size(answer.bytes)}: ${place}`);
      show(answer.data);
    } catch (error) {
      if (!counts()) return;
      say("said", "");
      say("data-error", error.message);
    } finally {
      if (counts()) bar.hidden = true;
    }
  }

  const wantedPlace = () => document.querySelector('#data input[name="data-keep"]:checked').value;
  const load = (file) => choose(file.name, wantedPlace(), () => file);

  async function example(name, signal) {
    const answer = await fetch(`${base()}assets/recordings/${name}`, { signal });
    if (!answer.ok) throw new Error(`${name} cannot be had: the server answered ${answer.status}.`);
    return answer.blob();
  }

  async function keptHere(data) {
    const record = await files().kept.get(data);
    if (!record) throw new Error("This browser does not have the file any more.");
    return record.bytes;
  }

  // What the server does not keep is kept here.
  async function placed(answer, blob, keep) {
    if (answer.kept === "store") return "kept on this server.";
    try {
      await files().kept.put({ data: answer.data, name: answer.name, bytes: blob, when: Date.now() });
      showKept();
      return keep === "browser" ? "kept in this browser only." : "kept in this browser; the server could not.";
    } catch (error) {
      return "kept nowhere: this browser does not allow it. Load it again next time.";
    }
  }

  function show(data) {
    if (data === missing) {
      // The link says the rest.
      location.reload();
      return;
    }
    missing = "";
    gainscope.desk.editAll({ data });
  }

  async function showKept() {
    const records = (await files().kept.list()).sort((one, other) => other.when - one.when);
    if (!root()) return;
    part("browser").hidden = !records.length;
    fill(
      part("browser-list"),
      ...records.map(({ data, name, bytes, when }) => {
        const about = make("span", { className: "hint" }, `${size(bytes.size)}, ${new Date(when).toLocaleDateString()}`);
        const buttons = ["Open", "Forget"].map((word) => {
          const button = make("button", { type: "button", className: "quiet" }, word);
          button.setAttribute("aria-label", `${word} ${name}`);
          Object.assign(button.dataset, { [word.toLowerCase()]: data, name });
          return button;
        });
        return make("li", {}, make("span", { className: "kept-name" }, name), about, ...buttons);
      }),
    );
  }

  async function click(button) {
    const { example: name, open: wanted, forget, take } = button.dataset;
    if (name) {
      choose(name, wantedPlace(), (signal) => example(name, signal));
    } else if (wanted) {
      choose(button.dataset.name, "browser", () => keptHere(wanted));
    } else if (forget) {
      const gone = await files().kept.forget(forget).then(() => true, () => false);
      if (root()) say("said", gone ? "Forgotten by this browser." : "This browser does not let go of it.");
      showKept();
    } else if (take) {
      takeHome(button, take);
    } else if (button.id === "data-proposal") {
      gainscope.desk.edit("reading", "");
    }
  }

  document.addEventListener("click", (event) => {
    const button = root() && event.target instanceof Element ? event.target.closest("#data button") : null;
    if (button) click(button);
  });

  document.addEventListener("change", ({ target }) => {
    if (target.id !== "data-file" || !target.files.length) return;
    load(target.files[0]);
    // The same file again is a change too.
    target.value = "";
  });

  const holdsFile = (event) => root() && [...(event.dataTransfer?.types || [])].includes("Files");

  document.addEventListener("dragover", (event) => {
    if (!holdsFile(event)) return;
    event.preventDefault();
    part("drop").dataset.over = "yes";
  });

  for (const over of ["dragleave", "dragend", "drop"]) {
    document.addEventListener(over, () => root() && delete part("drop").dataset.over);
  }

  document.addEventListener("drop", (event) => {
    if (!holdsFile(event)) return;
    event.preventDefault();
    const [file] = event.dataTransfer.files;
    if (file) load(file);
  });

  // ------------------------------------------------------------------ how it is read

  function showRecording(recording, ok) {
    const state = recording ? (ok ? "shown" : "refused") : "none";
    const appeared = root().dataset.recording === "none" && state !== "none";
    root().dataset.recording = state;
    if (recording) {
      say("name", recording.name);
      const packed = recording.packed ? ", gzip" : "";
      say("format", `${recording.format} · ${recording.rows.toLocaleString("en")} rows · ${size(recording.bytes)}${packed}`);
      fill(part("reasons"), ...recording.why.map((reason) => make("li", {}, reason)));
      part("proposal").hidden = recording.proposed;
      showMenus(recording);
      showPreview(recording);
      for (const [name, shown] of Object.entries(recording.fields)) {
        for (const field of document.querySelectorAll(`#data .field-${name}`)) field.hidden = !shown;
      }
      for (const [name, label] of Object.entries(recording.labels)) say(`${name}-label`, label);
    }
    // What was laid out just now plotly has not seen.
    if (appeared) {
      for (const plot of document.querySelectorAll("#data .js-plotly-plot")) if (plot._fullLayout) window.Plotly.relayout(plot, { autosize: true });
    }
  }

  function showMenus({ columns, tracks }) {
    const key = JSON.stringify(columns);
    for (const menu of document.querySelectorAll("#data [data-columns]")) {
      const name = menu.dataset.control;
      if (menu.dataset.shown !== key) {
        menu.dataset.shown = key;
        const none = name === "read_time" ? "none" : "–";
        fill(menu, new Option(none, "0"), ...columns.map(([number, title]) => new Option(`${number}  ${title}`, number)));
      }
      menu.value = gainscope.desk.values[name] ?? "0";
    }
    const ids = JSON.stringify(tracks);
    const list = part("read_only-list");
    if (list.dataset.shown === ids) return;
    list.dataset.shown = ids;
    fill(list, ...tracks.map(([id, count]) => new Option(`${count.toLocaleString("en")} rows`, id)));
  }

  function showPreview({ columns, roles, preview }) {
    const names = new Map(columns);
    const head = (text, number) => {
      const cell = make("th", { scope: "col" }, text);
      if (number in roles) cell.append(make("div", { className: "role" }, roles[number]));
      return cell;
    };
    fill(part("preview-head"), make("tr", {}, head("Line"), ...preview.columns.map((number) => head(names.get(number), number))));
    fill(
      part("preview"),
      ...preview.rows.map(([line, cells]) => {
        const first = make("th", { scope: "row" }, String(line));
        const others = cells.map((cell, i) => {
          const made = make("td", {}, cell);
          if (preview.columns[i] in roles) made.dataset.read = "yes";
          return made;
        });
        return make("tr", {}, first, ...others);
      }),
    );
    say("preview-left", preview.left ? `${preview.left.toLocaleString("en")} more columns are not shown.` : "");
  }

  document.addEventListener("deskreport", ({ detail: { page, answer } }) => {
    if (page !== "data") return;
    showRecording(answer.recording, true);
    query = answer.link;
    showTaken();
    showWays();
  });

  document.addEventListener("deskrefused", ({ detail: { page, answer } }) => {
    if (page !== "data") return;
    showRecording(answer.recording, false);
    showWays();
  });

  // Whether the suggested filter is the present one.
  function showTaken() {
    const button = part("use");
    if (!button || !button.dataset.controls) return;
    const { values } = gainscope.desk;
    const same = Object.entries(JSON.parse(button.dataset.controls)).every(([name, value]) => String(values[name]) === String(value));
    button.disabled = same;
    say("taken", same ? "This filter is in use, on every page." : "Sets order, gains, sensor σ and gate.");
  }

  document.addEventListener("studyshown", ({ detail }) => detail.page === "data" && showTaken());

  // ------------------------------------------------------------------ taken home

  let query = "";
  const making = new Set(); // the buttons whose files are on their way

  // What is taken home is what is shown: while an entry is refused that is not what the controls say.
  function showWays() {
    for (const button of document.querySelectorAll("#data [data-take]")) {
      button.disabled = gainscope.desk.refused || making.has(button);
    }
  }

  async function takeHome(button, address) {
    say("take-error", "");
    say("take-said", `${button.textContent} is being made …`);
    making.add(button);
    showWays();
    try {
      await gainscope.settled();
      if (gainscope.desk.refused) throw new Error("What the controls say cannot be run.");
      const answer = await fetch(`${base()}${address}?${query}`);
      if (!answer.ok) throw new Error((await answer.json().catch(() => ({}))).message || `The server answered ${answer.status}.`);
      const name = decodeURIComponent(/filename\*=UTF-8''([^;]+)/.exec(answer.headers.get("Content-Disposition"))[1]);
      save(await answer.blob(), name);
      if (root()) say("take-said", `${name} is saved.`);
    } catch (error) {
      if (!root()) return;
      say("take-said", "");
      say("take-error", error.message);
    } finally {
      making.delete(button);
      showWays();
    }
  }

  function save(blob, name) {
    const link = make("a", { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  }
})();
