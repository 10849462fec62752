// Counts the layer orders of crease patterns (paths as arguments) with rabbit-ear: a number each as JSON, null where there is none.

import { createRequire } from "node:module";
import { readFileSync } from "node:fs";

const ear = createRequire(import.meta.url)("rabbit-ear");

const count = (pattern) => {
  const { vertices_coords, edges_vertices, edges_assignment, faces_vertices } = pattern;
  const graph = ear.graph.populate({ vertices_coords, edges_vertices, edges_assignment, faces_vertices });
  const lying = { ...graph, vertices_coords: ear.graph.makeVerticesCoordsFlatFolded(graph, 0) };
  try {
    const solution = ear.layer.solver(lying);
    return solution ? (solution.branches ?? []).reduce((product, branch) => product * branch.length, 1) : null;
  } catch (error) {
    return null;
  }
};

console.log = console.error;
const counts = process.argv.slice(2).map((path) => count(JSON.parse(readFileSync(path, "utf-8"))));
process.stdout.write(JSON.stringify(counts));
