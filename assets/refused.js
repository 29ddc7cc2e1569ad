// What the server does not answer. Dash keeps to itself what a callback is refused with, and that nobody can be reached;
// here the page hears of it, as a `callbackrefused` event with the question that was asked, the problem in the shape of
// every refusal (server/problem.py) and the seconds after which to ask again, if any. The page whose question it is
// cancels it.
(function () {
  "use strict";

  const CALLBACK = "_dash-update-component";
  const PAGES = ".._pages_content."; // Dash's own callback, which changes pages
  const BUSY = [429, 503];
  // The server is gone for a moment, or what stands before it says so in its own words.
  const UNREACHED = { problem: { message: "it cannot be reached" }, again: 3 };

  async function refusal(response) {
    const problem = await response.clone().json().catch(() => null);
    return problem && problem.message ? { problem, again: Number(response.headers.get("Retry-After")) || null } : null;
  }

  const pause = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

  const { fetch } = window;
  window.fetch = async function (address, options) {
    if (!String(address).includes(CALLBACK)) return fetch(address, options);
    const tell = (refused) => {
      const detail = { asked: JSON.parse(options.body), ...refused };
      return !document.dispatchEvent(new CustomEvent("callbackrefused", { detail, cancelable: true }));
    };
    let response;
    try {
      response = await fetch(address, options);
      // Nobody else would ask for a page again.
      while (BUSY.includes(response.status) && options.body.includes(PAGES)) {
        await pause(Number(response.headers.get("Retry-After")) || 1);
        response = await fetch(address, options);
      }
    } catch (error) {
      if (tell(UNREACHED)) return taken();
      throw error;
    }
    return response.ok || !tell((await refusal(response)) || UNREACHED) ? response : taken();
  };

  // To Dash, a question that a page takes back is one to which nothing changes.
  const taken = () => new Response(null, { status: 204 });

  window.gainscope = Object.assign(window.gainscope || {}, { refusal });
})();
