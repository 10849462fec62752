// Folds FOLD files with a clone of Flat-Folder: node flat_folder.mjs CLONE LIMIT FILE... Prints one JSON line a file.
// Where it finds that a pattern does not fold flat it prints "Unable to resolve", and throws an error without words: that is 0 states.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [clone, limit, ...files] = process.argv.slice(2);
const load = (name) => import(pathToFileURL(`${clone}/src/${name}.js`).href);
const { BATCH } = await load("batch");
const { CON } = await load("constraints");
const { NOTE } = await load("note");
NOTE.show = false;
CON.build();
const print = console.log;
let said = "";
console.log = (text) => { said += text + "\n"; };
for (const file of files) {
    const pattern = JSON.parse(readFileSync(file, "utf-8"));
    const cpu = process.cpuUsage();
    const started = performance.now();
    said = "";
    let states = null;
    let refused = null;
    try {
        const found = await BATCH.process_file(pattern, limit === "all" ? Infinity : Number(limit));
        states = String(found.states);
    } catch (error) {
        if (said.includes("Unable to resolve")) states = "0";
        else refused = said.trim() || String(error.message ?? error);
    }
    const used = process.cpuUsage(cpu);
    print(JSON.stringify({
        flat_folder: file, states, refused,
        seconds: (performance.now() - started) / 1000, cpu: (used.user + used.system) / 1e6,
    }));
}
