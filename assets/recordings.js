// Recordings in the browser: sent to the server, kept here where they are not to be kept there, sent again when the
// server has let go of one that a link names (layouts/uploads.py).
(function () {
  "use strict";

  const SET = "recordings";
  const AGAIN = 20000; // ms within which the same file is not sent again by itself
  let database = null;

  // ------------------------------------------------------------------ kept in this browser

  function opened() {
    database ??= new Promise((resolve, reject) => {
      const asked = indexedDB.open("gainscope", 1);
      asked.onupgradeneeded = () => asked.result.createObjectStore(SET, { keyPath: "data" });
      asked.onsuccess = () => resolve(asked.result);
      asked.onerror = () => {
        database = null;
        reject(asked.error);
      };
    });
    return database;
  }

  async function act(mode, work) {
    const transaction = (await opened()).transaction(SET, mode);
    const asked = work(transaction.objectStore(SET));
    return new Promise((resolve, reject) => {
      transaction.oncomplete = () => resolve(asked.result);
      transaction.onerror = transaction.onabort = () => reject(transaction.error);
    });
  }

  // A browser may forbid this; nothing is kept here then.
  const kept = {
    get: (data) => act("readonly", (set) => set.get(data)).catch(() => undefined),
    list: () => act("readonly", (set) => set.getAll()).catch(() => []),
    put: (record) => act("readwrite", (set) => set.put(record)),
    forget: (data) => act("readwrite", (set) => set.delete(data)),
  };

  // ------------------------------------------------------------------ to and from the server

  // Dash knows the path that the application is served under.
  const base = () => JSON.parse(document.getElementById("_dash-config").textContent).requests_pathname_prefix;

  // fetch does not tell how much has been sent. A `signal` of an AbortController ends it.
  function send(blob, name, keep, progress, signal) {
    return new Promise((resolve, reject) => {
      const request = new XMLHttpRequest();
      request.open("PUT", `${base()}recordings?${new URLSearchParams({ name, keep })}`);
      request.setRequestHeader("Content-Type", "application/octet-stream");
      request.responseType = "json";
      if (progress) request.upload.onprogress = (event) => progress(event.loaded, event.total);
      request.onload = () => {
        const answer = request.response;
        if (request.status === 200) resolve(answer);
        else reject(new Error(answer?.message || `The server answered ${request.status}.`));
      };
      request.onerror = () => reject(new Error("The server did not take the file."));
      request.onabort = () => reject(new DOMException("", "AbortError"));
      signal?.addEventListener("abort", () => request.abort());
      request.send(blob);
    });
  }

  // ------------------------------------------------------------------ a recording that is missing

  const sentAt = new Map();

  // Of a page that was loaded anew as well.
  function sentLately(data) {
    const now = Date.now();
    let before = sentAt.get(data) || 0;
    try {
      before = Math.max(before, Number(sessionStorage.getItem(`gainscope-sent-${data}`)));
      sessionStorage.setItem(`gainscope-sent-${data}`, now);
    } catch (error) {
      // Without storage the map has to do.
    }
    sentAt.set(data, now);
    return now - before < AGAIN;
  }

  // With `whole` the page could not be shown as its link says, else its last state stands.
  async function recover(page, data, whole) {
    const record = await kept.get(data);
    if (record && !sentLately(data)) {
      say("This server has no longer the recording of this page; this browser sends it again.");
      try {
        await send(record.bytes, record.name, "browser");
        if (whole) location.reload();
        else {
          say("");
          gainscope.desk.retry();
        }
        return;
      } catch (error) {
        // The person is asked.
      }
    }
    const name = record ? record.name : `${data.slice(0, 8)}…`;
    say(`The recording ${name} is not kept on this server, or no longer: load the file again, and this link works as before.`, page !== "data");
  }

  function say(text, withLink) {
    const banner = document.getElementById("missing-recording");
    banner.hidden = !text;
    banner.replaceChildren(text);
    if (!withLink) return;
    const link = Object.assign(document.createElement("a"), { href: `${base()}data${location.search}`, textContent: "Load it" });
    banner.append(" ", link);
  }

  document.addEventListener("deskbegin", ({ detail }) => {
    say("");
    if (detail.missing) recover(detail.page, detail.missing, true);
  });

  document.addEventListener("deskrefused", ({ detail }) => {
    if (detail.answer.missing) recover(detail.page, detail.answer.missing, false);
  });

  document.addEventListener("deskreport", ({ detail }) => {
    if (detail.answer.controls.data) say("");
  });

  window.gainscope = Object.assign(window.gainscope || {}, { recordings: { kept, send, base } });
})();
