"""Model providers that follow a script, on a local port: real HTTP, reached through the real litellm."""
