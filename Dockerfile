# The whole project, headless: `docker build -t spherefunc . && docker run --rm -v "$PWD/demo:/spherefunc/demo" spherefunc`
# runs `make demo` and leaves demo/report.html; `docker run --rm -v "$PWD:/data" spherefunc spherefunc classify /data/mug.ply`
# labels a file.
FROM python:3.11-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends git make \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /spherefunc
COPY . .
RUN ./setup.sh
ENV PATH="/spherefunc/.venv/bin:$PATH"
CMD ["make", "demo"]
