// What the server does not answer. Dash keeps to itself what a callback is refused with; here the page hears of it, as
// a `callbackrefused` event with the question that was asked, the problem in the shape of every refusal
// (server/problem.py) and the seconds after which to ask again, if any. The page whose question it is cancels it.
(function () {
  "use strict";

  const CALLBACK = "_dash-update-component";
  const PAGES = ".._pages_content."; // Dash's own callback, which changes pages
  const BUSY = [429, 503];

  // A request without an answer in that shape is none of this server's: whoever asked hears of it by waiting in vain.
  async function refusal(response) {
    const problem = await response.clone().json().catch(() => null);
    return problem && problem.message ? { problem, again: Number(response.headers.get("Retry-After")) || null } : null;
  }

  const pause = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

  const { fetch } = window;
  window.fetch = async function (address, options) {
    let response = await fetch(address, options);
    if (!String(address).includes(CALLBACK)) return response;
    // Nobody else would ask for a page again.
    while (BUSY.includes(response.status) && options.body.includes(PAGES)) {
      await pause(Number(response.headers.get("Retry-After")) || 1);
      response = await fetch(address, options);
    }
    const refused = response.ok ? null : await refusal(response);
    if (!refused) return response;
    const detail = { asked: JSON.parse(options.body), ...refused };
    const told = !document.dispatchEvent(new CustomEvent("callbackrefused", { detail, cancelable: true }));
    // To Dash, a question that a page takes back is one to which nothing changes.
    return told ? new Response(null, { status: 204 }) : response;
  };

  window.gainscope = Object.assign(window.gainscope || {}, { refusal });
})();
