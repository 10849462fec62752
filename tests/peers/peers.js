// Reads our FOLD files (paths as arguments) with rabbit-ear and with fold, and prints what they make of them as JSON:
// the faces found from the edges alone, the crease pattern folded flat, and the face orders that are possible.

import { createRequire } from "node:module";
import { readFileSync } from "node:fs";

const require = createRequire(import.meta.url);
const ear = require("rabbit-ear");
const FOLD = require("fold");

const copy = (value) => JSON.parse(JSON.stringify(value));

/** A frame of a document with what it inherits, by the rules of the FOLD specification. */
const frame = (document, index) => {
  if (index === 0) {
    const { file_frames, ...key } = document;
    return key;
  }
  const own = document.file_frames[index - 1];
  return own.frame_inherit ? { ...frame(document, own.frame_parent), ...own } : own;
};

/** Only what defines a crease pattern; everything else is left for the peer to find. */
const bare = ({ vertices_coords, edges_vertices, edges_assignment }) =>
  copy({ vertices_coords, edges_vertices, edges_assignment });

const readByEar = (pattern) => {
  const found = ear.graph.populate(bare(pattern));
  const graph = ear.graph.populate({ ...bare(pattern), faces_vertices: copy(pattern.faces_vertices) });
  const folded = ear.graph.makeVerticesCoordsFlatFolded(graph, 0);
  const lying = { ...graph, vertices_coords: folded };
  const solution = ear.layer.solver(lying);
  return {
    faces: found.faces_vertices,
    angles: graph.edges_foldAngle,
    coords: folded,
    windings: ear.graph.makeFacesWinding(lying),
    orders: solution && { root: solution.root, branches: solution.branches },
  };
};

const readByFold = (pattern) => {
  const found = bare(pattern);
  FOLD.convert.edges_vertices_to_faces_vertices(found);
  const graph = copy(pattern);
  FOLD.convert.flatFoldedGeometry(graph);
  return { faces: found.faces_vertices, coords: graph.vertices_flatFoldCoords };
};

// rabbit-ear reports its times on stdout; only the answer may go there.
console.log = console.error;
const answers = process.argv.slice(2).map((path) => {
  const document = JSON.parse(readFileSync(path, "utf-8"));
  const pattern = frame(document, document.file_frames ? 1 : 0);
  return { ear: readByEar(pattern), fold: readByFold(pattern), classes: pattern.frame_classes };
});
process.stdout.write(JSON.stringify(answers));
