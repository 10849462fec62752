// The page: which state is shown, what is picked, and what keys and buttons do.

const byId = (id) => document.getElementById(id);
const BEAT = 1100; // milliseconds a state is shown while playing
const FADE = 220; // milliseconds in which a state appears
const shown = { view: null, index: 0, pick: [], hovered: [], playing: 0, busy: false };
let connection;

const stopNow = () => shown.view.stops[shown.index];
const atLast = () => shown.index === shown.view.stops.length - 1;
const direction = () => Number(document.querySelector("[name=side]:checked").value);

function show(view) {
  shown.view = view;
  byId("model").hidden = false;
  byId("title").textContent = view.title;
  document.title = view.title;
  byId("position").max = view.stops.length - 1;
  for (const [name, value] of Object.entries(view.colors))
    document.documentElement.style.setProperty(`--${name.replace("_", "-")}`, value);
  fillProgram();
  goTo(view.stops.length - 1);
}

function goTo(index) {
  shown.index = Math.min(Math.max(index, 0), shown.view.stops.length - 1);
  shown.pick = [];
  shown.hovered = [];
  render();
  if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches)
    document.querySelector("#folded .paper").animate([{ opacity: 0.35 }, { opacity: 1 }], FADE);
}

function inWords(stop) {
  const faces = Object.keys(stop.state.faces).length;
  const layers = stop.state.layers.length;
  const what = stop.step ? `Step ${stop.step} of ${shown.view.steps}: ${stop.text}` : "Start: the flat sheet";
  const moved = stop.moved_faces.length ? `, ${stop.moved_faces.length} moved` : "";
  return `${what}. ${faces} ${faces === 1 ? "face" : "faces"}${moved}, ${layers} ${layers === 1 ? "layer" : "layers"}.`;
}

function render() {
  const stop = stopNow();
  byId("stop").textContent = inWords(stop);
  byId("position").value = shown.index;
  byId("position").setAttribute("aria-valuetext", inWords(stop));
  byId("first").disabled = byId("back").disabled = shown.index === 0;
  byId("last").disabled = byId("next").disabled = atLast();
  markInProgram();
  fillNumbers(stop);
  drawPictures();
  renderFolding();
}

function drawPictures() {
  const { view } = shown;
  const stop = stopNow();
  const count = (kind) => stop.state.edges.filter((edge) => edge[2] === kind).length;
  byId("folded").setAttribute("aria-label", `Folded state. ${inWords(stop)}`);
  byId("pattern").setAttribute("aria-label",
    `Crease pattern: ${count("M")} mountain folds, ${count("V")} valley folds, ${count("F")} opened creases.`);
  drawFolded(view, stop);
  const place = patternPlacing(view);
  const pattern = byId("pattern");
  const unit = SIZE / (pattern.clientWidth || SIZE);
  const found = places(view.sheet_coords, Object.keys(stop.state.vertices), place);
  pattern.replaceChildren(creasePattern(view, stop, place), spots(found, unit), element("g", { class: "overlay" }));
  drawOverlays();
}

function drawFolded(view, stop) {
  const place = foldedPlacing(view);
  const svg = byId("folded");
  const photo = view.photos[stop.frame];
  byId("photo").hidden = !photo;
  const unfinished = view.stops[shown.index + 1]?.step === stop.step;
  byId("photo-name").textContent = `Uncover the photo of frame ${stop.frame}${unfinished ? ", the end of this step" : ""}`;
  const paper = foldedPaper(stop, place);
  const share = Number(byId("uncovered").value) / 100;
  const found = places(stop.state.vertices, Object.keys(stop.state.vertices), place);
  const drawn = photo && share ? besidePhoto(paper, photo, stop.frame, share) : [paper];
  svg.replaceChildren(...drawn, spots(found, SIZE / (svg.clientWidth || SIZE)), element("g", { class: "overlay" }));
}

function drawOverlays() {
  const { view, pick } = shown;
  const stop = stopNow();
  overlay(byId("folded"), stop.state.vertices, foldedPlacing(view), () =>
    foldPreview(stop.state.vertices[pick[0]], stop.state.vertices[pick[1]], direction(), view));
  overlay(byId("pattern"), view.sheet_coords, patternPlacing(view), (place) =>
    kindOf(stop, pick) ? [segment(place(view.sheet_coords[pick[0]]), place(view.sheet_coords[pick[1]]), { class: "picked" })] : []);
}

// What lies over one picture: the newest crease or the picked one, marked vertices, labels.
function overlay(svg, coords, place, picture) {
  const { pick, hovered } = shown;
  const stop = stopNow();
  const unit = SIZE / (svg.clientWidth || SIZE);
  const found = places(coords, Object.keys(stop.state.vertices), place);
  const marked = found.filter(({ ids }) => ids.some((id) => hovered.includes(id) || pick.includes(id)));
  const labelled = byId("ids").checked ? found : marked;
  const middle = middleOf(found);
  const over = [];
  if (pick.length === 2) over.push(...picture(place));
  else if (stop.crease) over.push(segment(...stop.crease.map((id) => place(coords[id])), { class: "made" }));
  over.push(...marked.map(({ at }) => dot(at, unit)), ...labelled.map((each) => label(each, middle, unit)));
  svg.querySelector(".overlay").replaceChildren(...over);
}

function markInProgram() {
  const list = byId("program");
  list.querySelector("[aria-current]")?.removeAttribute("aria-current");
  const button = list.querySelector(`[data-index="${shown.index}"]`);
  button.setAttribute("aria-current", "step");
  list.scrollTop = button.offsetTop - list.clientHeight / 2;
}

function fillProgram() {
  const items = shown.view.stops.map((stop, index) => {
    const button = document.createElement("button");
    button.type = "button";
    button.dataset.index = index;
    button.textContent = stop.step ? `${stop.step}. ${stop.text}` : "Start: the flat sheet";
    button.addEventListener("click", () => goTo(index));
    const item = document.createElement("li");
    item.append(button);
    return item;
  });
  const left = shown.view.left_out;
  const missing = document.createElement("li");
  missing.textContent = `${left} earlier states are left out, as they are too large to send.`;
  byId("program").replaceChildren(...(left ? [missing] : []), ...items);
}

function fillNumbers(stop) {
  const rows = Object.entries(stop.state.vertices).map(([id, folded]) => {
    const row = document.createElement("tr");
    for (const text of [id, folded.join(", "), shown.view.sheet_coords[id].join(", ")])
      row.append(Object.assign(document.createElement("td"), { textContent: text }));
    return row;
  });
  byId("numbers").tBodies[0].replaceChildren(...rows);
}

function whyNoFold() {
  if (connection.whyNoCalls()) return connection.whyNoCalls();
  return atLast() ? "" : "Go to the last state to fold from there.";
}

function renderFolding() {
  const stop = stopNow();
  const why = whyNoFold();
  const { pick } = shown;
  const options = [new Option(creasesOf(stop).length ? "none picked" : "none yet", "")];
  for (const [u, v, kind] of creasesOf(stop)) options.push(new Option(`${u}-${v}, ${KINDS[kind]}`, edgeKey(u, v)));
  byId("crease").replaceChildren(...options);
  byId("crease").value = pick.length === 2 && creasesOf(stop).some(([u, v]) => edgeKey(u, v) === edgeKey(...pick)) ? edgeKey(...pick) : "";
  byId("from").value = pick[0] ?? "";
  byId("to").value = pick[1] ?? "";
  const ends = pick.map((id) => stop.state.vertices[id]);
  [byId("plus").textContent, byId("minus").textContent] = pick.length === 2 ? sideNames(...ends) : ["upper", "lower"];
  const off = Boolean(why) || shown.busy;
  for (const control of byId("controls").querySelectorAll("select, input, button")) control.disabled = off;
  byId("fold").disabled = off || pick.length < 2;
  byId("unfold").disabled = off || !["M", "V"].includes(kindOf(stop, pick));
  byId("controls").hidden = Boolean(connection.whyNoCalls());
  byId("cannot").hidden = !why;
  byId("cannot").textContent = why;
}

function choose(pick) {
  if (shown.busy || !shown.view) return;
  const known = stopNow().state.vertices;
  shown.pick = pick.every((id) => known[id]) ? pick : [];
  drawOverlays();
  renderFolding();
}

function chooseTyped() {
  choose([byId("from").value, byId("to").value].filter(Boolean).map(Number));
}

function say(text, refused = false) {
  byId("answer").textContent = text;
  byId("answer").classList.toggle("refused", refused);
}

const textOf = (result) => result.content?.find((block) => block.type === "text")?.text ?? "";

async function act(tool, args) {
  if (shown.busy || whyNoFold()) return;
  const { run_id } = shown.view;
  const inFocus = document.activeElement;
  shown.busy = true;
  renderFolding();
  say("Folding.");
  try {
    const result = await connection.callTool(tool, run_id ? { ...args, run_id } : args);
    if (result.isError) say(textOf(result), true);
    else await showChanged(textOf(result));
  } catch (error) {
    say(`This could not be done: ${error.message}.`, true);
  } finally {
    shown.busy = false;
    renderFolding();
    (inFocus?.disabled ? byId("folded") : inFocus)?.focus({ preventScroll: true });
  }
}

async function showChanged(said) {
  const { run_id } = shown.view;
  take(await connection.callTool("show_model", run_id ? { run_id } : {}));
  say(said);
  connection.tellModel(`The user changed the model in the view. ${said}`);
}

function take(result) {
  const view = result._meta?.[VIEW_KEY];
  if (view) show(view);
  else byId("stop").textContent = textOf(result) || "The host did not pass on the model.";
}

function fold() {
  if (shown.pick.length === 2) act("fold", { edge: shown.pick, direction: direction() });
}

function play() {
  const start = !shown.playing;
  window.clearInterval(shown.playing);
  shown.playing = 0;
  if (start) {
    if (atLast()) goTo(0);
    shown.playing = window.setInterval(() => (atLast() ? play() : goTo(shown.index + 1)), BEAT);
  }
  byId("play").textContent = start ? "Pause" : "Play";
  byId("play").setAttribute("aria-pressed", String(start));
}

function pointAt(event) {
  const { ids, u, v, kind } = event.target.dataset;
  shown.hovered = ids ? ids.split(",").map(Number) : [];
  const at = ids && event.currentTarget.id === "folded" ? stopNow().state.vertices[shown.hovered[0]] : shown.view.sheet_coords[shown.hovered[0]];
  if (ids) byId("pointed").textContent = `Vertex ${shown.hovered.join(", ")} at (${at.map((value) => value.toFixed(3)).join(", ")})`;
  else if (u) byId("pointed").textContent = `${u}-${v}, ${KINDS[kind]}`;
  drawOverlays();
}

function pickAt(event) {
  const { ids, u, v } = event.target.dataset;
  if (ids) choose(withVertex(shown.pick, Number(ids.split(",")[0])));
  else if (u) choose([Number(u), Number(v)]);
}

const STEP_KEYS = {
  ArrowLeft: () => goTo(shown.index - 1),
  ArrowRight: () => goTo(shown.index + 1),
  Home: () => goTo(0),
  End: () => goTo(shown.view.stops.length - 1),
};
const PICTURE_KEYS = {
  ArrowUp: () => choose(nextCrease(stopNow(), shown.pick, -1)),
  ArrowDown: () => choose(nextCrease(stopNow(), shown.pick, 1)),
  Enter: fold,
};

function onKey(event) {
  if (!shown.view || event.ctrlKey || event.metaKey || event.altKey) return;
  const on = event.target;
  if (event.key === "Escape") choose([]);
  const inPicture = on === document.body || on.closest("figure > svg");
  const keys = { ...(on.matches("input, select") ? {} : STEP_KEYS), ...(inPicture ? PICTURE_KEYS : {}) };
  if (on.matches("#crease, #sides input")) keys.Enter = fold;
  if (on.matches("#from, #to")) keys.Enter = () => (chooseTyped(), fold());
  if (keys[event.key]) {
    event.preventDefault();
    keys[event.key]();
  }
}

function listen() {
  const on = (id, event, does) => byId(id).addEventListener(event, does);
  on("first", "click", STEP_KEYS.Home);
  on("back", "click", STEP_KEYS.ArrowLeft);
  on("next", "click", STEP_KEYS.ArrowRight);
  on("last", "click", STEP_KEYS.End);
  on("play", "click", play);
  on("position", "input", () => goTo(Number(byId("position").value)));
  on("uncovered", "input", drawPictures);
  on("ids", "change", drawOverlays);
  on("crease", "change", () => choose(byId("crease").value.split("-").filter(Boolean).map(Number)));
  for (const id of ["from", "to"]) on(id, "change", chooseTyped);
  on("sides", "change", drawOverlays);
  on("fold", "click", fold);
  on("unfold", "click", () => act("unfold", { edge: shown.pick }));
  on("undo", "click", () => act("undo", {}));
  for (const id of ["folded", "pattern"]) {
    on(id, "pointerover", pointAt);
    on(id, "click", pickAt);
  }
  document.addEventListener("keydown", onKey);
}

function wear(context) {
  const root = document.documentElement;
  if (context.theme) root.dataset.theme = context.theme;
  for (const [name, value] of Object.entries(context.styles?.variables ?? {}))
    if (name.startsWith("--") && value) root.style.setProperty(name, value);
}

function hear(method, params) {
  if (method === "ui/notifications/tool-result") take(params);
  else if (method === "ui/notifications/host-context-changed") wear(params);
  else if (method === "ui/notifications/tool-cancelled")
    byId("stop").textContent = `The call was cancelled${params.reason ? `: ${params.reason}` : ""}.`;
}

function watchSize() {
  let told = "";
  new ResizeObserver(() => {
    if (shown.view) drawPictures();
    const { width, height } = document.body.getBoundingClientRect();
    const size = [Math.ceil(width), Math.ceil(height)];
    if (String(size) === told) return;
    told = String(size);
    connection.tellSize(...size);
  }).observe(document.body);
}

async function start() {
  const given = byId("view");
  const view = JSON.parse(given.textContent);
  listen();
  if (view) {
    connection = new LocalConnection(given.dataset.endpoint);
    show(view);
  } else if (window.parent === window) {
    byId("stop").textContent = "This page shows a model inside an MCP host; foldingagent-server view shows one without.";
    return;
  } else {
    connection = new HostConnection(hear);
    wear(await connection.open());
  }
  watchSize();
  byId("program").parentElement.addEventListener("toggle", markInProgram);
}

start();
