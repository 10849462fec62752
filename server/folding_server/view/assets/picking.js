// The crease that is picked: any two vertices; how a fold along it is announced in the pictures and in words.

// Whether the line through two points counts as upright for the paper: then +1 moves its right side, else its upper one.
const UPRIGHT = 1e-4;

function isUpright([x1, y1], [x2, y2]) {
  return Math.abs(x2 - x1) <= UPRIGHT * Math.abs(y2 - y1);
}

function sideNames(p, q) {
  return isUpright(p, q) ? ["right", "left"] : ["upper", "lower"];
}

// The unit vector to the side that moves, y up.
function towardsMoving(p, q, direction) {
  const [dx, dy] = [q[0] - p[0], q[1] - p[1]];
  const length = Math.hypot(dx, dy);
  const normal = [-dy / length, dx / length];
  const plus = isUpright(p, q) ? normal[0] > 0 : normal[1] > 0;
  return plus === direction > 0 ? normal : normal.map((value) => -value);
}

// The whole line through the picked vertices and an arrow from the moving side across it.
function foldPreview(p, q, direction, view) {
  const place = foldedPlacing(view);
  const side = view.window[2];
  const [dx, dy] = [q[0] - p[0], q[1] - p[1]];
  const length = Math.hypot(dx, dy);
  if (length < UPRIGHT) return [];
  const far = (2 * side) / length;
  const line = [[p[0] - far * dx, p[1] - far * dy], [q[0] + far * dx, q[1] + far * dy]].map(place);
  const n = towardsMoving(p, q, direction);
  const middle = [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2];
  const along = [dx / length, dy / length];
  const point = (off, aside) => place([0, 1].map((i) => middle[i] + off * side * n[i] + aside * side * along[i]));
  const from = point(0.11, 0);
  const bend = point(0, 0.1);
  const to = point(-0.11, 0);
  const barbs = [point(-0.063, 0.0), point(-0.1, 0.05)];
  const shape = `M${from}Q${bend} ${to}M${barbs[0]}L${to}L${barbs[1]}`;
  return [
    segment(...line, { class: "through" }),
    segment(place(p), place(q), { class: "picked" }),
    element("path", { class: "arrow", d: shape }),
    element("path", { class: "arrow", d: shape }),
  ];
}

// The pick after one more vertex was pointed at: it replaces the older of two.
function withVertex(pick, id) {
  if (pick.length === 1 && pick[0] !== id) return [pick[0], id];
  return [id];
}

// Inner edges of a state as picks, in the order in which keys go through them.
function creasesOf(stop) {
  return stop.state.edges.filter(([, , kind]) => kind !== "B");
}

function nextCrease(stop, pick, by) {
  const creases = creasesOf(stop);
  if (!creases.length) return [];
  const now = creases.findIndex(([u, v]) => edgeKey(u, v) === edgeKey(...pick));
  const then = now < 0 ? (by > 0 ? 0 : creases.length - 1) : (now + by + creases.length) % creases.length;
  return creases[then].slice(0, 2);
}

function kindOf(stop, pick) {
  return stop.state.edges.find(([u, v]) => edgeKey(u, v) === edgeKey(...pick))?.[2];
}
