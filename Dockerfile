FROM python:3.11-slim

WORKDIR /app
COPY pyproject.toml requirements.lock README.md LICENSE ./
COPY schemas schemas
COPY prompts prompts
COPY server server
COPY client client
RUN pip install --no-cache-dir --constraint requirements.lock ".[agent,dask,foldability,postgres,video]"

RUN useradd --create-home --uid 1000 folding \
    && mkdir /data /sequences /runs \
    && chown folding:folding /data /runs
USER folding
VOLUME ["/data", "/runs"]
EXPOSE 8000

CMD ["foldingagent-server", "--http", "0.0.0.0:8000", "--known-as", "server", "--token-file", "/run/secrets/tokens", "--sequences", "/sequences", "--data", "/data"]
