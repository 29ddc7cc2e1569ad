// The focus of what hides itself goes to a neighbour: at the beginning of the page the keyboard would have lost its place.
(function () {
  "use strict";

  const PLACES = ".study-row, .status, .card"; // the smallest of them that it stood in is searched, and takes it at last
  const REACHED = "a[href], button, input, select, summary, [tabindex='0']";

  // What is hidden or disabled does not take it.
  function takes(element) {
    element.focus();
    return document.activeElement === element;
  }

  function leave(gone) {
    const place = gone.parentElement.closest(PLACES) || document.getElementById("main");
    const isAfter = (each) => gone.compareDocumentPosition(each) & Node.DOCUMENT_POSITION_FOLLOWING;
    const others = [...place.querySelectorAll(REACHED)].filter((each) => !gone.contains(each));
    const nearest = [...others.filter(isAfter), ...others.filter((each) => !isAfter(each)).reverse()];
    if (nearest.some(takes)) return;
    place.tabIndex = -1;
    place.focus();
  }

  // Browsers take it from what is hidden at their leisure: as soon as the page is laid out, or not at all.
  let held = null;

  document.addEventListener("focusin", ({ target }) => (held = target));
  document.addEventListener("focusout", ({ target }) => {
    if (!target.closest("[hidden]")) held = null;
  });

  new MutationObserver(() => {
    const gone = held && held.isConnected && held.closest("[hidden]");
    if (!gone) return;
    held = null;
    leave(gone);
  }).observe(document.body, { attributes: true, attributeFilter: ["hidden"], subtree: true });
})();
