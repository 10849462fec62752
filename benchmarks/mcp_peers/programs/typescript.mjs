// A client of one of the TypeScript SDKs: node typescript.mjs JSON makes the calls and prints what arrived as JSON.
// It is copied into the folder of the SDK's packages, from where its imports are found; `modules` names where the client and
// both transports are.
const wanted = JSON.parse(process.argv[2]);
const [{ Client }, { StdioClientTransport }, { StreamableHTTPClientTransport }] = await Promise.all(
  wanted.modules.map((module) => import(module)),
);

const transport = wanted.url
  ? new StreamableHTTPClientTransport(new URL(wanted.url))
  : new StdioClientTransport({ command: wanted.command[0], args: wanted.command.slice(1), env: process.env });
const client = new Client({ name: "peer", version: "1" });
await client.connect(transport);
const { tools } = await client.listTools();
const answers = [];
let run = {};
for (const [tool, given] of wanted.calls) {
  const result = await client.callTool({ name: tool, arguments: { ...given, ...run } });
  answers.push({
    tool,
    is_error: Boolean(result.isError),
    texts: result.content.filter((block) => block.type === "text").map((block) => block.text),
    images: result.content
      .filter((block) => block.type === "image")
      .map((block) => ({ mime: block.mimeType, data: block.data })),
    structured: result.structuredContent ?? null,
  });
  if (tool === "open_run" && wanted.url) run = { run_id: result.structuredContent.run_id };
}
await client.close();
process.stdout.write(JSON.stringify({ tools: tools.map((tool) => tool.name), answers }) + "\n");
