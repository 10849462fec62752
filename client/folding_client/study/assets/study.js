"use strict";
/* One question at a time. Answers are kept in this browser until they are saved as a file; nothing is sent anywhere. */

const study = document.body.dataset.study;
const questions = [...document.querySelectorAll(".question")];
const sections = [document.getElementById("start"), ...questions, document.getElementById("end")];
const KEYS = { a: "A", "1": "A", arrowleft: "A", b: "B", "2": "B", arrowright: "B", t: "tie", "0": "tie", arrowdown: "tie" };
let kept = recall();
let at = 0;
let since = performance.now();

function fresh() {
  const bytes = crypto.getRandomValues(new Uint8Array(6));
  return { code: [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join(""), rater: "", answers: {} };
}

function recall() {
  try {
    const found = JSON.parse(localStorage.getItem(`study-${study}`));
    return found && typeof found.answers === "object" && found.code ? found : fresh();
  } catch (error) {
    return fresh();
  }
}

function remember() {
  try {
    localStorage.setItem(`study-${study}`, JSON.stringify(kept));
  } catch (error) {
    /* a browser that keeps nothing: the answers are there until the page is left */
  }
}

function show(place) {
  at = Math.min(Math.max(place, 0), sections.length - 1);
  sections.forEach((section, number) => { section.hidden = number !== at; });
  const section = sections[at];
  if (section.classList.contains("question")) {
    const given = kept.answers[section.dataset.question];
    for (const button of section.querySelectorAll("[data-choice]")) {
      button.setAttribute("aria-pressed", String(Boolean(given) && given.choice === button.dataset.choice));
    }
    const next = questions[at];
    if (next) for (const picture of next.querySelectorAll("img")) picture.loading = "eager";
  }
  if (at > 0) section.focus();
  scrollTo(0, 0);
  since = performance.now();
}

function answer(choice) {
  const question = sections[at].dataset.question;
  if (!question) return;
  kept.answers[question] = { choice, seconds: Math.round(performance.now() - since) / 1000 };
  remember();
  show(at + 1);
}

function begin() {
  const open = questions.findIndex((question) => !(question.dataset.question in kept.answers));
  show(open < 0 ? sections.length - 1 : open + 1);
}

function save() {
  kept.rater = document.getElementById("rater").value.trim();
  remember();
  const rater = kept.rater || kept.code;
  const answers = questions.map((each) => each.dataset.question).filter((id) => id in kept.answers)
    .map((id) => ({ question: id, ...kept.answers[id] }));
  const text = JSON.stringify({ format: 1, study, rater, answers }, null, 1);
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
  link.download = `answers-${study}-${kept.code}.json`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  document.getElementById("said").textContent = `${answers.length} of ${questions.length} answers saved as ${link.download}.`;
}

function anew() {
  kept = fresh();
  remember();
  document.getElementById("rater").value = "";
  document.getElementById("said").textContent = "";
  document.getElementById("begin").textContent = "Begin";
  show(0);
}

addEventListener("keydown", (event) => {
  if (event.repeat || event.altKey || event.ctrlKey || event.metaKey || event.target.closest("input")) return;
  const choice = KEYS[event.key.toLowerCase()];
  if (choice && sections[at].dataset.question) {
    event.preventDefault();
    answer(choice);
  } else if (event.key === "Backspace" && at > 1) {
    event.preventDefault();
    show(at - 1);
  }
});
for (const button of document.querySelectorAll("[data-choice]")) button.addEventListener("click", () => answer(button.dataset.choice));
for (const button of document.querySelectorAll(".back")) button.addEventListener("click", () => show(at - 1));
document.getElementById("begin").addEventListener("click", begin);
document.getElementById("save").addEventListener("click", save);
document.getElementById("anew").addEventListener("click", anew);
document.getElementById("rater").value = kept.rater;
if (Object.keys(kept.answers).length) document.getElementById("begin").textContent = "Go on";
