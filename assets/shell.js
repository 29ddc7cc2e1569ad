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

  // Once the page shows what its controls say, or has said why it does not.
  async function settled() {
    while (gainscope.desk.settling) await new Promise((resolve) => setTimeout(resolve, 50));
  }

  const LABEL = "Copy link";

  // The link is right once the page has settled; while an entry is refused it is that of what is still shown.
  async function copyLink(button) {
    const tell = (said) => (document.getElementById("copy-said").textContent = button.textContent = said);
    if (gainscope.desk.settling) tell("In a moment …");
    await settled();
    try {
      await navigator.clipboard.writeText(location.href);
      tell(gainscope.desk.refused ? "Last good link copied" : "Copied");
    } catch (error) {
      tell("It is in the address bar");
    }
    setTimeout(() => {
      button.textContent = LABEL;
      document.getElementById("copy-said").textContent = "";
    }, 1500);
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
    if (button && button.id === "copy-link" && button.textContent === LABEL) copyLink(button);
  });

  window.gainscope = Object.assign(window.gainscope || {}, { markPage, settled });
})();
