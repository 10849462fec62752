// Draws one state as SVG: the folded paper from its layers, bottom to top, and the crease pattern from its edges.

const SIZE = 1000;
const SHEET_BORDER = 0.09; // around the crease pattern, in parts of its longer side
const LABEL = 13; // pixels
const HIT = 11; // pixels around a vertex that count as pointing at it
const SAME_PLACE = 1e-3; // vertices nearer than this, in sheet units, share a label: a little over the paper's tolerance
const KINDS = { B: "edge of the sheet", F: "opened crease", M: "mountain fold", V: "valley fold" };

function element(name, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

const edgeKey = (u, v) => (u < v ? `${u}-${v}` : `${v}-${u}`);

// Where points of a square of the plane lie in a picture.
function placing([left, bottom, side]) {
  return ([x, y]) => [((x - left) / side) * SIZE, ((bottom + side - y) / side) * SIZE];
}

function foldedPlacing(view) {
  return placing(view.window);
}

function patternPlacing({ sheet: [width, height] }) {
  const border = SHEET_BORDER * Math.max(width, height);
  const side = Math.max(width, height) + 2 * border;
  return placing([(width - side) / 2, (height - side) / 2, side]);
}

function segment(p, q, attributes) {
  return element("line", { x1: p[0], y1: p[1], x2: q[0], y2: q[1], ...attributes });
}

const corners = (points) => points.map((point) => point.map((value) => value.toFixed(2)).join()).join(" ");

// An edge that is seen, and around it one that is easy to point at.
function pickable(p, q, u, v, kind) {
  const about = { "data-u": u, "data-v": v, "data-kind": kind };
  return [segment(p, q, { class: `line ${kind}` }), segment(p, q, { class: "reach", ...about })];
}

function foldedPaper(stop, place) {
  const { vertices, faces, faces_orientations, edges, layers } = stop.state;
  const kinds = new Map(edges.map(([u, v, kind]) => [edgeKey(u, v), kind]));
  const at = Object.fromEntries(Object.entries(vertices).map(([id, xy]) => [id, place(xy)]));
  const paper = element("g", { class: "paper" });
  for (const face of layers.flat(2)) {
    const cycle = faces[face];
    const drawn = element("g", { class: faces_orientations[face] ? "back" : "front" });
    drawn.append(element("polygon", { class: "face", points: corners(cycle.map((id) => at[id])) }));
    cycle.forEach((v, i) => {
      const [a, b] = [cycle.at(i - 1), v].sort((x, y) => x - y);
      drawn.append(...pickable(at[a], at[b], a, b, kinds.get(edgeKey(a, b))));
    });
    paper.append(drawn);
  }
  return paper;
}

function creasePattern(view, stop, place) {
  const [width, height] = view.sheet;
  const sheet = [[0, 0], [width, 0], [width, height], [0, height]].map(place);
  const pattern = element("g", { class: "pattern" }, element("polygon", { class: "sheet", points: corners(sheet) }));
  const order = "FVMB";
  const sorted = [...stop.state.edges].sort((a, b) => order.indexOf(a[2]) - order.indexOf(b[2]));
  for (const [u, v, kind] of sorted)
    pattern.append(...pickable(place(view.sheet_coords[u]), place(view.sheet_coords[v]), u, v, kind));
  return pattern;
}

// The photo in the part of the picture left of `share` (0 to 1), the paper in the rest.
function besidePhoto(paper, photo, frame, share) {
  const edge = share * SIZE;
  const covered = element("clipPath", { id: "covered" }, element("rect", { x: edge, y: -SIZE, width: 2 * SIZE, height: 3 * SIZE }));
  const image = element("image", { href: photo, width: SIZE, height: SIZE, role: "img", "aria-label": `Photo of frame ${frame}` });
  const wipe = element("clipPath", { id: "uncovered-part" }, element("rect", { width: edge, height: SIZE }));
  const shown = element("g", { "clip-path": "url(#uncovered-part)" }, image);
  paper.setAttribute("clip-path", "url(#covered)");
  return [covered, wipe, shown, paper, segment([edge, 0], [edge, SIZE], { class: "edge-of-photo" })];
}

// Vertices by place: [{ids, at}], those at one place together.
function places(coords, ids, place) {
  const found = new Map();
  for (const id of ids) {
    const key = coords[id].map((value) => Math.round(value / SAME_PLACE)).join();
    if (!found.has(key)) found.set(key, { ids: [], at: place(coords[id]), xy: coords[id] });
    found.get(key).ids.push(Number(id));
  }
  return [...found.values()];
}

function spots(found, unit) {
  return element("g", {}, ...found.map(({ ids, at }) =>
    element("circle", { class: "spot", cx: at[0], cy: at[1], r: HIT * unit, "data-ids": ids.join() })));
}

// A label beside a place, away from the middle of the picture's contents.
function label({ ids, at }, middle, unit) {
  const off = [at[0] - middle[0], at[1] - middle[1]];
  const [dx, dy] = Math.hypot(...off) < LABEL * unit ? [0, -1] : off; // in the middle itself: above
  const away = Math.hypot(dx, dy);
  const text = ids.length > 4 ? `${ids.slice(0, 3).join(", ")}, +${ids.length - 3}` : ids.join(", ");
  const width = (text.length * 0.6 + 0.7) * LABEL * unit;
  const clamp = (value, half) => Math.min(Math.max(value, half), SIZE - half);
  const x = clamp(at[0] + (dx / away) * (0.5 * width + 6 * unit), width / 2);
  const y = clamp(at[1] + (dy / away) * 17 * unit, LABEL * unit * 0.7);
  const height = LABEL * 1.35 * unit;
  return element("g", { class: "ids" },
    element("rect", { x: x - width / 2, y: y - height / 2, width, height, rx: 4 * unit }),
    Object.assign(element("text", { x, y, "font-size": LABEL * unit }), { textContent: text }));
}

function middleOf(found) {
  const sum = (axis) => found.reduce((total, { at }) => total + at[axis], 0) / found.length;
  return [sum(0), sum(1)];
}

function dot(at, unit) {
  return element("circle", { class: "dot", cx: at[0], cy: at[1], r: 4.5 * unit });
}
