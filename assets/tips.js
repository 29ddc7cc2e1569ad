// What explains a term or a field, shown above it: to the pointer on its name, and to the keyboard on its control. Escape
// takes it away, and the pointer may go to it. Screen readers are told the same with the control (layouts/inputs.py).
(function () {
  "use strict";

  const GRACE = 200; // ms in which the pointer gets from the name to the explanation
  const GAP = 4; // px between them
  const EDGE = 8; // px to the edge of the window, at least

  const bubble = document.createElement("div");
  bubble.className = "bubble";
  bubble.hidden = true;
  bubble.setAttribute("aria-hidden", "true");
  document.body.append(bubble);

  let shown = null; // what is explained, even while Escape has taken that away: the element, its field, who asked
  let byKeys = false; // whether the last hand was on the keyboard
  let leaving = 0;

  // A term says it itself; of a label and its control the description does.
  function explanation(element) {
    if (element.dataset.tip) return { field: element, text: element.dataset.tip };
    const told = (element.control || element).getAttribute("aria-describedby") || "";
    const about = document.getElementById(told.split(" ").find((id) => id.endsWith("-about")));
    return about && { field: about.parentElement, text: about.textContent };
  }

  function stay() {
    clearTimeout(leaving);
    leaving = 0;
  }

  function show(element, hand) {
    const found = explanation(element);
    if (!found) return;
    stay();
    if (shown && shown.element === element) return;
    shown = { element, field: found.field, hand };
    bubble.textContent = found.text;
    bubble.dataset.hand = hand;
    bubble.hidden = false;
    place();
  }

  function hide() {
    stay();
    shown = null;
    bubble.hidden = true;
  }

  // Above, since its control and its error are below; below all of them where there is no room.
  function place() {
    if (bubble.hidden) return;
    if (!shown.element.getClientRects().length) {
      hide();
      return;
    }
    const { left } = shown.element.getBoundingClientRect();
    const { top, bottom } = shown.field.getBoundingClientRect();
    const { clientWidth, clientHeight } = document.documentElement;
    const above = top - GAP - bubble.offsetHeight;
    const below = Math.min(bottom + GAP, clientHeight - EDGE - bubble.offsetHeight);
    bubble.style.left = `${Math.max(EDGE, Math.min(left, clientWidth - EDGE - bubble.offsetWidth))}px`;
    bubble.style.top = `${above >= EDGE ? above : below}px`;
  }

  // ------------------------------------------------------------------ pointer

  document.addEventListener("pointerover", ({ target }) => {
    const term = target instanceof Element ? target.closest(".tip") : null;
    if (target === bubble) stay();
    else if (term) show(term, "pointer");
    else leave();
  });

  function leave() {
    if (shown && shown.hand === "pointer") leaving ||= setTimeout(hide, GRACE);
  }

  // A finger leaves the page each time it is lifted.
  document.documentElement.addEventListener("pointerleave", (event) => event.pointerType !== "touch" && leave());
  // One that scrolls has not asked for anything.
  document.addEventListener("pointercancel", hide);

  // ------------------------------------------------------------------ keyboard

  document.addEventListener("pointerdown", () => (byKeys = false), true);

  document.addEventListener(
    "keydown",
    (event) => {
      byKeys = true;
      if (event.key === "Escape") bubble.hidden = true;
    },
    true,
  );

  document.addEventListener("focusin", ({ target }) => byKeys && show(target, "keys"));
  document.addEventListener("focusout", () => shown && shown.hand === "keys" && hide());

  // ------------------------------------------------------------------ page

  window.addEventListener("scroll", place, { capture: true, passive: true });
  window.addEventListener("resize", place);
  window.addEventListener("popstate", hide);
  document.addEventListener("deskbegin", hide);
})();
