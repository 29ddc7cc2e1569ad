// A page's scene in three dimensions: an iframe with a secret of its own, mounted when it comes into sight, let go when
// nobody uses it; and the player that runs through the samples.
(function () {
  "use strict";

  const IDLE = 10 * 60 * 1000; // ms without a hand on page or scene until it is let go; the server waits longer
  const PATIENCE = 15000; // ms without a connection after which that is said
  const USES = ["pointerdown", "pointermove", "wheel", "keydown", "input", "touchstart"];

  let place = null; // where the scene of the present page goes
  let idle = 0;
  let waiting = 0; // for a connection
  let watcher = null;

  const part = (name) => place && place.closest("section").querySelector(`[data-part="${name}"]`);

  function hasWebGL() {
    try {
      const canvas = document.createElement("canvas");
      return Boolean(canvas.getContext("webgl2") || canvas.getContext("webgl"));
    } catch (error) {
      return false;
    }
  }

  function secret() {
    return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
  }

  function address(token) {
    const base = JSON.parse(document.getElementById("_dash-config").textContent).requests_pathname_prefix;
    // What stands behind # is not sent, and the page before it is the same for everyone: it is kept.
    return `${base}viser/${document.documentElement.dataset.theme}/#${token}`;
  }

  function mount() {
    if (!place || place.querySelector("iframe")) return;
    const token = secret();
    const frame = document.createElement("iframe");
    Object.assign(frame, { src: address(token), title: place.dataset.title });
    frame.addEventListener("load", () => {
      try {
        for (const use of USES) frame.contentWindow.addEventListener(use, used, { passive: true });
      } catch (error) {
        // The page's own events then have to do.
      }
    });
    frame.addEventListener("connection", ({ detail }) => hear(detail, frame));
    part("resume").hidden = true;
    place.append(frame);
    awaitConnection();
    place.dataset.token = token;
    used();
    gainscope.desk.useScene(token);
  }

  function awaitConnection() {
    clearTimeout(waiting);
    waiting = setTimeout(refuse, PATIENCE);
  }

  function refuse() {
    clearTimeout(waiting);
    part("again").textContent = "Try again";
    part("refused").hidden = false;
  }

  // The page in the frame, which tries again by itself, says how that goes (layouts/scenes/page.py).
  function hear(state, frame) {
    if (!frame.isConnected) return;
    if (state === "connected") {
      clearTimeout(waiting);
      frame.dataset.connected = "yes";
      part("refused").hidden = true;
    } else if (frame.dataset.connected) {
      // What was there once may come back before anybody misses it.
      delete frame.dataset.connected;
      awaitConnection();
    } else {
      refuse();
    }
  }

  function unmount() {
    if (!place) return;
    clearTimeout(waiting);
    place.replaceChildren();
    part("refused").hidden = true;
    delete place.dataset.token;
    gainscope.desk.useScene("");
    part("resume").hidden = false;
  }

  function used() {
    clearTimeout(idle);
    idle = setTimeout(unmount, IDLE);
  }

  for (const use of USES) document.addEventListener(use, () => place && place.dataset.token && used(), { passive: true });

  // Background and labels belong to the page in the frame.
  document.addEventListener("themechange", () => {
    const frame = place && place.querySelector("iframe");
    if (!frame || !frame.isConnected) return;
    delete frame.dataset.connected;
    frame.src = address(place.dataset.token);
    awaitConnection();
  });

  document.addEventListener("deskbegin", (event) => {
    clearTimeout(idle);
    clearTimeout(waiting);
    stop();
    if (watcher) watcher.disconnect();
    place = document.querySelector(`#${event.detail.page} [data-scene]`);
    if (!place) return;
    place.replaceChildren();
    if (!hasWebGL()) {
      part("missing").hidden = false;
      place.hidden = true;
      return;
    }
    watcher = new IntersectionObserver((seen) => {
      if (!seen.some((entry) => entry.isIntersecting)) return;
      watcher.disconnect();
      mount();
    });
    watcher.observe(place);
  });

  // ------------------------------------------------------------------ player

  let player = null;

  function play(button) {
    const { desk } = gainscope;
    const start = Number(desk.values.at) >= desk.samples ? 1 : Number(desk.values.at);
    player = { button, at: start, then: performance.now(), frame: 0 };
    button.textContent = "Pause";
    player.frame = requestAnimationFrame(step);
  }

  function step(now) {
    if (!player || !player.button.isConnected) return stop();
    const { desk } = gainscope;
    const seconds = Number(part("speed").value);
    // A hand on the slider moves the player too.
    if (Math.abs(Number(desk.values.at) - player.at) > 1.5 && !desk.busy) player.at = Number(desk.values.at);
    player.at = Math.min(desk.samples, player.at + ((now - player.then) / 1000 / seconds) * desk.samples);
    player.then = now;
    const sample = Math.round(player.at);
    if (sample !== Number(desk.values.at) && !desk.busy) desk.edit("at", sample, null, true);
    if (player.at >= desk.samples && !desk.busy) return stop();
    player.frame = requestAnimationFrame(step);
  }

  function stop() {
    if (!player) return;
    cancelAnimationFrame(player.frame);
    player.button.textContent = "Play";
    player = null;
  }

  document.addEventListener("click", (event) => {
    const button = event.target instanceof Element ? event.target.closest("button[data-part]") : null;
    if (!button || !place) return;
    if (button.dataset.part === "show") mount();
    if (button.dataset.part === "again") {
      button.textContent = "Trying again …";
      place.replaceChildren();
      mount();
    }
    if (button.dataset.part === "play") {
      if (player) stop();
      else play(button);
    }
  });
})();
