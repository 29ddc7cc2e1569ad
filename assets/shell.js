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

  async function copyLink(button) {
    const label = button.textContent;
    let said = "Copied";
    try {
      await navigator.clipboard.writeText(location.href);
    } catch (error) {
      said = "It is in the address bar";
    }
    button.textContent = said;
    setTimeout(() => (button.textContent = label), 1500);
  }

  document.addEventListener("click", (event) => {
    const button = event.target instanceof Element ? event.target.closest("button") : null;
    if (button && button.id === "theme-switch") switchTheme();
    if (button && button.id === "copy-link" && button.textContent === "Copy link") copyLink(button);
  });
})();
