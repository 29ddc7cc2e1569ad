// The header's buttons: theme and link.
(function () {
  "use strict";

  function switchTheme() {
    const theme = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    document.documentElement.dataset.theme = theme;
    try {
      localStorage.setItem("gainscope-theme", theme);
    } catch (error) {
      // The theme then lasts as long as the page.
    }
    document.dispatchEvent(new Event("themechange"));
  }

  // Which page of the navigation is shown.
  function markPage() {
    for (const link of document.querySelectorAll(".page-link")) {
      if (link.pathname === location.pathname) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
  }

  // The link is right once the page has settled.
  async function settled() {
    const page = document.querySelector("[data-state]");
    for (let wait = 0; page && page.dataset.state === "busy" && wait < 40; wait++) {
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
  }

  async function copyLink(button) {
    const label = button.textContent;
    await settled();
    let said = "Copied";
    try {
      await navigator.clipboard.writeText(location.href);
    } catch (error) {
      said = "It is in the address bar";
    }
    button.textContent = said;
    setTimeout(() => (button.textContent = label), 1500);
  }

  // Going there by the address would make Dash build the page anew.
  document.addEventListener("click", (event) => {
    if (!(event.target instanceof Element) || !event.target.closest(".skip")) return;
    event.preventDefault();
    const main = document.getElementById("main");
    main.tabIndex = -1;
    main.focus();
  });

  document.addEventListener("click", (event) => {
    const button = event.target instanceof Element ? event.target.closest("button") : null;
    if (button && button.id === "theme-switch") switchTheme();
    if (button && button.id === "copy-link" && button.textContent === "Copy link") copyLink(button);
  });

  window.gainscope = Object.assign(window.gainscope || {}, { markPage });
})();
