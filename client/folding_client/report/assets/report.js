"use strict";
/* Everything is in the page already; this adds filters, stepping by keys, and looking for a newer version of the page. */

const byId = (id) => document.getElementById(id);
const all = (selector, within = document) => [...within.querySelectorAll(selector)];

/* Overview: find, filter, sort, compare. The choices are kept in the address, so that a page can be sent to someone. */
const CHOICES = ["find", "status", "group", "sort", "left", "right"];
const HIGH_FIRST = new Set(["cost", "tokens", "seconds"]);

function startOverview() {
  const list = byId("list");
  const rows = all(".run", list);
  const asked = new URLSearchParams(location.hash.slice(1));
  for (const name of CHOICES) {
    const control = byId(name);
    if (!control) continue;
    if (asked.has(name)) control.value = asked.get(name);
    control.addEventListener("input", () => arrange(list, rows));
  }
  byId("controls").hidden = false;
  arrange(list, rows);
}

function chosen(name) {
  return byId(name) ? byId(name).value : "";
}

function arrange(list, rows) {
  const words = chosen("find").toLowerCase().split(/\s+/).filter(Boolean);
  const kept = rows.filter((row) =>
    words.every((word) => row.dataset.name.includes(word) || row.dataset.model.includes(word)) &&
    (!chosen("status") || row.dataset.status === chosen("status")) &&
    (!chosen("group") || row.dataset.group === chosen("group")));
  kept.sort(inOrder(chosen("sort") || "name"));
  const compares = chosen("left") !== "" && chosen("right") !== "";
  list.replaceChildren(...(compares ? pairs(kept, chosen("left"), chosen("right")) : kept));
  const shown = compares ? `${list.childElementCount} sequences side by side.` : `${kept.length} of ${rows.length} runs.`;
  if (byId("count").textContent !== shown) byId("count").textContent = shown;
  keepChoices();
}

function inOrder(key) {
  const byName = (a, b) => a.dataset.name.localeCompare(b.dataset.name) || Number(a.dataset.group) - Number(b.dataset.group) || Number(a.dataset.seed) - Number(b.dataset.seed);
  if (key === "name") return byName;
  const number = (row) => (row.dataset[key] === "" ? -1 : Number(row.dataset[key]));
  const sign = HIGH_FIRST.has(key) ? -1 : 1;
  return (a, b) => sign * (number(a) - number(b)) || byName(a, b);
}

function pairs(rows, left, right) {
  const names = [...new Set(rows.filter((row) => [left, right].includes(row.dataset.group)).map((row) => row.dataset.name))];
  return names.map((name) => {
    const pair = document.createElement("section");
    pair.className = "pair";
    pair.append(side(rows, name, left), side(rows, name, right));
    return pair;
  });
}

function side(rows, name, group) {
  const runs = rows.filter((each) => each.dataset.name === name && each.dataset.group === group);
  if (runs.length > 1) return severalSeeds(runs);
  if (runs.length) return runs[0];
  const none = document.createElement("p");
  none.className = "quiet";
  none.textContent = `${name}: no run that fits the filters`;
  return none;
}

/* Runs of one sequence that differ in their seed: mean and range of their figures, and behind them the runs. */
const openSeeds = new Set();
const FIGURES = {
  match: ["match", (value) => `${Math.round(100 * value)} %`],
  score: ["", (value) => value.toFixed(3)],
  cost: ["cost", (value) => `$${value.toFixed(2)}`],
  seconds: ["time", (value) => `${value.toFixed(value < 10 ? 1 : 0)} s`],
};

function severalSeeds(runs) {
  const { name, model, group } = runs[0].dataset;
  const box = document.createElement("article");
  box.className = "seeds";
  const title = document.createElement("h3");
  title.textContent = runs[0].querySelector("h3").textContent;
  const about = document.createElement("p");
  about.className = "model small";
  about.textContent = `${runs.length} runs of ${model}, mean and range`;
  const figures = document.createElement("dl");
  figures.className = "small";
  for (const [key, [label, words]] of Object.entries(FIGURES)) {
    const values = runs.map((run) => run.dataset[key]).filter((value) => value !== undefined && value !== "").map(Number);
    if (values.length && (key !== "cost" || Math.max(...values))) figures.append(meanAndRange(label || byId("list").dataset.metric, values, words));
  }
  const behind = document.createElement("details");
  const heading = document.createElement("summary");
  heading.textContent = `Seeds ${runs.map((run) => run.dataset.seed).join(", ")}`;
  behind.append(heading, ...runs);
  const id = `${group} ${name}`;
  behind.open = openSeeds.has(id);
  behind.addEventListener("toggle", () => (behind.open ? openSeeds.add(id) : openSeeds.delete(id)));
  box.append(title, about, figures, behind);
  return box;
}

function meanAndRange(label, values, words) {
  const [mean, least, most] = [values.reduce((sum, each) => sum + each, 0) / values.length, Math.min(...values), Math.max(...values)];
  const figure = document.createElement("div");
  const [term, told] = [document.createElement("dt"), document.createElement("dd")];
  term.textContent = label;
  told.textContent = least === most ? words(mean) : `${words(mean)} (${words(least)} to ${words(most)})`;
  figure.append(term, told);
  return figure;
}

function keepChoices() {
  const told = new URLSearchParams();
  for (const name of CHOICES) if (chosen(name) && chosen(name) !== "name") told.set(name, chosen(name));
  history.replaceState(null, "", told.size ? `#${told}` : location.pathname + location.search);
}

/* Page of a run: one frame at a time. The frame is kept in the address. */
function startRun(first) {
  const frames = all(".frame");
  if (frames.length) {
    byId("viewer").classList.add("stepping");
    showFrame(frameAsked(frames) || frames[0]);
    byId("previous").addEventListener("click", () => step(-1));
    byId("next").addEventListener("click", () => step(1));
  }
  all(".player").forEach((player) => { player.hidden = player.closest("#viewer") !== null && !frames.length; });
  byId("expand").addEventListener("click", () => openAll(true));
  byId("collapse").addEventListener("click", () => openAll(false));
  if (first) reveal();
}

function frameAsked(frames) {
  return frames.find((frame) => `#${frame.id}` === location.hash);
}

function showFrame(frame) {
  const frames = all(".frame");
  for (const each of frames) each.classList.toggle("current", each === frame);
  const place = frames.indexOf(frame);
  byId("at").textContent = `${frame.id.slice(1)} of ${frames.length}`;
  byId("previous").disabled = place === 0;
  byId("next").disabled = place === frames.length - 1;
  for (const link of all(".pick a")) {
    const here = link.getAttribute("href") === `#${frame.id}`;
    if (here) {
      link.setAttribute("aria-current", "step");
      const strip = link.closest(".strip"), item = link.parentElement;
      strip.scrollLeft = item.offsetLeft - strip.offsetLeft - (strip.clientWidth - item.clientWidth) / 2;
    } else link.removeAttribute("aria-current");
  }
}

function step(by) {
  const frames = all(".frame");
  const at = frames.findIndex((frame) => frame.classList.contains("current"));
  goTo(Math.min(Math.max(at + by, 0), frames.length - 1));
}

function goTo(place) {
  const frame = all(".frame")[place];
  history.replaceState(null, "", `#${frame.id}`);
  showFrame(frame);
}

function openAll(open) {
  for (const each of all("#log details")) each.open = open;
}

/* Open whatever holds the part of the trace that the address names. */
function reveal() {
  const target = /^#e\d+$/.test(location.hash) && byId(location.hash.slice(1));
  if (!target) return;
  for (let each = target; each; each = each.parentElement) if (each.tagName === "DETAILS") each.open = true;
  target.scrollIntoView();
  target.querySelector("summary").focus({ preventScroll: true });
}

function onKey(event) {
  if (event.altKey || event.ctrlKey || event.metaKey || event.shiftKey) return;
  if (event.target.closest("input, select, textarea, pre, .wide")) return;
  const last = all(".frame").length - 1;
  if (last < 0) return;
  const moves = { ArrowLeft: () => step(-1), ArrowRight: () => step(1), Home: () => goTo(0), End: () => goTo(last) };
  if (!(event.key in moves)) return;
  event.preventDefault();
  moves[event.key]();
}

function onAddress() {
  const frame = frameAsked(all(".frame"));
  if (frame) showFrame(frame);
  reveal();
}

/* While the site is served during a batch: take over a newer version without losing the place. */
const LOOK_AGAIN = 2000;

async function look(version) {
  const { live, page } = document.body.dataset;
  let now = version;
  try {
    now = (await (await fetch(live, { cache: "no-store" })).json())[page] || version;
    if (version && now !== version) await takeOver();
  } catch (error) {
    now = version; /* the server has ended, or is about to begin again */
  }
  setTimeout(look, LOOK_AGAIN, now);
}

async function takeOver() {
  const answer = await fetch(location.pathname, { cache: "no-store" });
  const fresh = new DOMParser().parseFromString(await answer.text(), "text/html");
  const open = new Set(all("details[open]").map((each) => each.id));
  for (const each of all("details", fresh)) each.open = open.has(each.id);
  const values = CHOICES.filter((name) => byId(name)).map((name) => [name, byId(name).value]);
  const strips = new Map(all(".strip").map((strip) => [strip.getAttribute("aria-label"), strip.scrollLeft]));
  const focused = document.activeElement && document.activeElement.id;
  const [x, y] = [scrollX, scrollY];
  document.title = fresh.title;
  document.querySelector("header").replaceWith(fresh.querySelector("header"));
  document.querySelector("main").replaceWith(fresh.querySelector("main"));
  for (const [name, value] of values) if (byId(name)) byId(name).value = value;
  begin(false);
  for (const strip of all(".strip")) strip.scrollLeft = strips.get(strip.getAttribute("aria-label")) || strip.scrollLeft;
  if (focused && byId(focused)) byId(focused).focus({ preventScroll: true });
  scrollTo(x, y);
}

function begin(first) {
  if (byId("list")) startOverview();
  else if (byId("viewer")) startRun(first);
}

begin(true);
if (byId("viewer")) {
  addEventListener("keydown", onKey);
  addEventListener("hashchange", onAddress);
}
if (document.body.dataset.live) look("");
