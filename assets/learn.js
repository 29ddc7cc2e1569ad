// The Learn page in the browser: an answer shows once it has been predicted; what was predicted lasts as long as the tab.
(function () {
  "use strict";

  const KEPT = "gainscope-learn";
  const MARKS = { right: "✓", wrong: "✗" };
  let right = {};

  const root = () => document.getElementById("learn");
  const card = (name) => root().querySelector(`[data-lesson="${name}"]`);

  // By lesson the number of the choice.
  function predicted() {
    try {
      const kept = JSON.parse(sessionStorage.getItem(KEPT)) || {};
      return Object.fromEntries(Object.entries(kept).filter(([name, choice]) => choiceOf(name, choice)));
    } catch (error) {
      return {};
    }
  }

  function keep(choices) {
    try {
      sessionStorage.setItem(KEPT, JSON.stringify(choices));
    } catch (error) {
      // They then last as long as the page.
    }
  }

  function choiceOf(name, choice) {
    return name in right && card(name).querySelector(`[data-choice="${Number(choice)}"]`);
  }

  function begin(data) {
    right = data;
    gainscope.markPage();
    for (const [name, choice] of Object.entries(predicted())) show(name, choice);
    count(predicted());
    const lesson = Object.keys(data).find((name) => location.hash === `#lesson-${name}`);
    if (lesson) card(lesson).scrollIntoView();
    root().dataset.state = "settled";
    return true;
  }

  function outcome(name, choice) {
    return choice === right[name] ? "right" : "wrong";
  }

  function show(name, choice) {
    const lesson = card(name);
    for (const button of lesson.querySelectorAll("[data-choice]")) {
      const own = Number(button.dataset.choice);
      // What is disabled would lose the focus.
      button.setAttribute("aria-disabled", "true");
      button.setAttribute("aria-pressed", String(own === choice));
      if (own !== choice && own !== right[name]) continue;
      button.dataset.outcome = outcome(name, own);
      const said = own === choice ? "predicted" : "what happens";
      button.querySelector(".mark").textContent = `${MARKS[outcome(name, own)]} ${said}`;
    }
    const verdict = outcome(name, choice) === "right" ? "As you predicted." : "Not as you predicted.";
    const line = lesson.querySelector(".verdict-line");
    line.textContent = verdict;
    line.dataset.outcome = outcome(name, choice);
    turn(lesson, true);
  }

  // To the answer, or back to what stands in its place.
  function turn(lesson, answered) {
    const answer = lesson.querySelector(".lesson-answer");
    answer.hidden = !answered;
    answer.previousElementSibling.hidden = answered;
  }

  function hide(name) {
    const lesson = card(name);
    for (const button of lesson.querySelectorAll("[data-choice]")) {
      button.removeAttribute("aria-disabled");
      button.setAttribute("aria-pressed", "false");
      delete button.dataset.outcome;
      button.querySelector(".mark").textContent = "";
    }
    turn(lesson, false);
  }

  function count(choices) {
    const names = Object.keys(choices);
    const hits = names.filter((name) => outcome(name, choices[name]) === "right");
    for (const place of root().querySelectorAll("[data-mark]")) {
      const name = place.dataset.mark;
      place.textContent = name in choices ? MARKS[outcome(name, choices[name])] : "";
      if (name in choices) place.setAttribute("aria-label", outcome(name, choices[name]));
      else place.removeAttribute("aria-label");
    }
    document.getElementById("learn-score").textContent = names.length
      ? `${hits.length} of ${names.length} predicted rightly`
      : "";
    document.getElementById("learn-again").hidden = !names.length;
  }

  document.addEventListener("click", (event) => {
    if (!(event.target instanceof Element) || !root() || !root().contains(event.target)) return;
    const button = event.target.closest("button");
    if (button && "choice" in button.dataset && !button.ariaDisabled) {
      const name = button.closest("[data-lesson]").dataset.lesson;
      const choices = { ...predicted(), [name]: Number(button.dataset.choice) };
      keep(choices);
      show(name, choices[name]);
      count(choices);
    }
    if (button && button.id === "learn-again") {
      keep({});
      for (const name of Object.keys(right)) hide(name);
      count({});
      root().querySelector("[data-choice]").focus();
    }
  });

  window.dash_clientside = Object.assign({}, window.dash_clientside, { learn: { begin } });
})();
