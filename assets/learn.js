// The Learn page in the browser: an answer shows once it has been predicted; what was predicted lasts as long as the tab.
(function () {
  "use strict";

  const KEPT = "gainscope-learn";
  const MARKS = { right: "✓", wrong: "✗" };
  let right = {};
  let choices = {}; // by lesson the number of what was predicted

  const root = () => document.getElementById("learn");
  const card = (name) => root().querySelector(`[data-lesson="${name}"]`);

  function isChoice([name, choice]) {
    if (!Object.hasOwn(right, name) || !Number.isInteger(choice)) return false;
    return Boolean(card(name).querySelector(`[data-choice="${choice}"]`));
  }

  function kept() {
    try {
      return JSON.parse(sessionStorage.getItem(KEPT)) || choices;
    } catch (error) {
      return choices;
    }
  }

  function keep(wanted) {
    choices = wanted;
    try {
      sessionStorage.setItem(KEPT, JSON.stringify(choices));
    } catch (error) {
      // They then last until the page is loaded anew.
    }
    count();
  }

  function begin(data) {
    right = data;
    choices = Object.fromEntries(Object.entries(kept()).filter(isChoice));
    gainscope.markPage();
    for (const name of Object.keys(choices)) show(name);
    count();
    const lesson = Object.keys(data).find((name) => location.hash === `#lesson-${name}`);
    if (lesson) card(lesson).scrollIntoView();
    root().dataset.state = "settled";
    return true;
  }

  function outcome(name, choice) {
    return choice === right[name] ? "right" : "wrong";
  }

  function verdict(name) {
    return outcome(name, choices[name]) === "right" ? "As you predicted." : "Not as you predicted.";
  }

  function show(name) {
    const lesson = card(name);
    for (const button of lesson.querySelectorAll("[data-choice]")) {
      const own = Number(button.dataset.choice);
      const taken = own === choices[name];
      // What is disabled would lose the focus.
      button.setAttribute("aria-disabled", "true");
      button.setAttribute("aria-pressed", String(taken));
      if (!taken && own !== right[name]) continue;
      button.dataset.outcome = outcome(name, own);
      button.querySelector(".mark").textContent = `${MARKS[outcome(name, own)]} ${taken ? "predicted" : "what happens"}`;
    }
    const line = lesson.querySelector(".verdict-line");
    line.textContent = verdict(name);
    line.dataset.outcome = outcome(name, choices[name]);
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

  function count() {
    const names = Object.keys(choices);
    const hits = names.filter((name) => outcome(name, choices[name]) === "right");
    for (const place of root().querySelectorAll("[data-mark]")) {
      const name = place.dataset.mark;
      const said = name in choices ? outcome(name, choices[name]) : "";
      place.textContent = said ? MARKS[said] : "";
      for (const [attribute, value] of [["role", "img"], ["aria-label", said]]) {
        if (said) place.setAttribute(attribute, value);
        else place.removeAttribute(attribute);
      }
    }
    const score = names.length ? `${hits.length} of ${names.length} predicted rightly` : "";
    document.getElementById("learn-score").textContent = score;
    document.getElementById("learn-again").hidden = !names.length;
  }

  document.addEventListener("click", (event) => {
    if (!(event.target instanceof Element) || !root() || !root().contains(event.target)) return;
    const button = event.target.closest("button");
    if (button && button.matches("[data-choice]:not([aria-disabled])")) {
      const name = button.closest("[data-lesson]").dataset.lesson;
      if (!Object.hasOwn(right, name)) return;
      keep({ ...choices, [name]: Number(button.dataset.choice) });
      show(name);
      const happens = card(name).querySelector(`[data-choice="${right[name]}"] > span`).textContent;
      document.getElementById("learn-said").textContent = `${verdict(name)} What happens: ${happens}`;
    }
    if (button && button.id === "learn-again") {
      keep({});
      for (const name of Object.keys(right)) hide(name);
      document.getElementById("learn-said").textContent = "";
      root().querySelector("[data-choice]").focus();
    }
  });

  window.dash_clientside = Object.assign({}, window.dash_clientside, { learn: { begin } });
})();
