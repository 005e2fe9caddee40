# The whole project, headless: `docker build -t spherefunc . && docker run --rm -v "$PWD/demo:/spherefunc/demo" spherefunc`
# runs `make demo` and leaves demo/report.html; `docker run --rm -v "$PWD:/data" spherefunc spherefunc classify /data/mug.ply`
# labels a file.
FROM python:3.11-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends git make \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /spherefunc
COPY . .
# A container forgets what it compiles, so modules are compiled here; files among them that are no Python may fail.
RUN ./setup.sh && (.venv/bin/python -m compileall -qq -j 0 .venv/lib >/dev/null || true)
ENV PATH="/spherefunc/.venv/bin:$PATH"
CMD ["make", "demo"]
