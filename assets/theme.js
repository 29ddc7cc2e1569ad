// The theme is chosen before the first paint: what the user chose last, else what the system prefers.
(function () {
  let chosen = null;
  try {
    chosen = localStorage.getItem("gainscope-theme");
  } catch (error) {
    // Storage may be forbidden; the system's preference is as good.
  }
  const dark = chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  document.documentElement.dataset.theme = dark ? "dark" : "light";
})();
