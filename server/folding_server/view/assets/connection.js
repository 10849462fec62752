// Calls tools: through the MCP host that shows this page (JSON-RPC 2.0 over postMessage, MCP Apps 2026-01-26), or through
// the small server that served it.

const PROTOCOL_VERSION = "2026-01-26";
const VIEW_KEY = "foldingagent/view";

class HostConnection {
  // `heard` is told of every notification of the host: (method, params).
  constructor(heard) {
    this.heard = heard;
    this.waiting = new Map();
    this.lastId = 0;
    this.capabilities = {};
    window.addEventListener("message", (event) => {
      if (event.source === window.parent && event.data?.jsonrpc === "2.0") this.receive(event.data);
    });
  }

  async open() {
    const answer = await this.request("ui/initialize", {
      protocolVersion: PROTOCOL_VERSION,
      appInfo: { name: "foldingagent-view", version: "1" },
      appCapabilities: { availableDisplayModes: ["inline", "fullscreen"] },
    });
    this.capabilities = answer.hostCapabilities ?? {};
    this.notify("ui/notifications/initialized", {});
    return answer.hostContext ?? {};
  }

  whyNoCalls() {
    return this.capabilities.serverTools ? "" : "This host does not let views call tools; ask its model to fold.";
  }

  callTool(name, args) {
    return this.request("tools/call", { name, arguments: args });
  }

  tellModel(text) {
    this.request("ui/update-model-context", { content: [{ type: "text", text }] }).catch(() => {});
  }

  tellSize(width, height) {
    this.notify("ui/notifications/size-changed", { width, height });
  }

  request(method, params) {
    const id = ++this.lastId;
    this.send({ id, method, params });
    return new Promise((resolve, reject) => this.waiting.set(id, { resolve, reject }));
  }

  notify(method, params) {
    this.send({ method, params });
  }

  send(message) {
    window.parent.postMessage({ jsonrpc: "2.0", ...message }, "*");
  }

  receive(message) {
    if (message.method === undefined) this.settle(message);
    else if (message.id === undefined) this.heard(message.method, message.params ?? {});
    else if (message.method === "ping" || message.method === "ui/resource-teardown")
      this.send({ id: message.id, result: {} });
    else this.send({ id: message.id, error: { code: -32601, message: `${message.method} is not known here` } });
  }

  settle(message) {
    const asked = this.waiting.get(message.id);
    this.waiting.delete(message.id);
    if (message.error) asked?.reject(new Error(message.error.message));
    else asked?.resolve(message.result ?? {});
  }
}

class LocalConnection {
  constructor(endpoint) {
    this.endpoint = endpoint;
  }

  whyNoCalls() {
    return this.endpoint ? "" : "This is a file to look at; to fold, open the program with foldingagent-server view.";
  }

  async callTool(name, args) {
    const answer = await fetch(this.endpoint, {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ name, arguments: args }),
    });
    if (!answer.ok) throw new Error(`the server answered ${answer.status}`);
    return answer.json();
  }

  tellModel() {}

  tellSize() {}
}
