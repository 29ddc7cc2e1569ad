# A release pins this by digest:  --build-arg BASE=python:3.11-slim@sha256:...
ARG BASE=python:3.11-slim

FROM ${BASE} AS build
COPY requirements/serve.txt /tmp/serve.txt
# pip serves the build alone: it installs from outside the environment and never enters it. It compiles to bytecode,
# which the server cannot write later. Wheels alone, so that nothing runs at install and no compiler is needed.
RUN python -m venv --without-pip /venv \
    && python -m pip --python /venv/bin/python install --no-cache-dir --disable-pip-version-check \
        --require-hashes --only-binary :all: -r /tmp/serve.txt
WORKDIR /gainscope
COPY . .
RUN /venv/bin/python -m compileall -q .


FROM ${BASE}
ARG VERSION=0.1.0
LABEL org.opencontainers.image.title="Gainscope" \
      org.opencontainers.image.description="An interactive laboratory for alpha-beta(-gamma(-eta)) tracking filters" \
      org.opencontainers.image.version="${VERSION}"

# Fixed, so that what is mounted can be given to it; no home, no shell.
RUN groupadd --gid 10001 gainscope \
    && useradd --uid 10001 --gid gainscope --no-create-home --home-dir /nonexistent --shell /usr/sbin/nologin gainscope
# Recordings; what is mounted here must belong to that user, as a new volume does.
RUN mkdir --mode=0700 /data && chown 10001:10001 /data
COPY --from=build /venv /venv
COPY --from=build /gainscope /gainscope
WORKDIR /gainscope
USER 10001:10001

# The kernels are compiled at every start, before the server says that it is ready: machine code made here would be
# compiled again on any other model of processor, and a root file system that is read only has no room but /tmp.
ENV PATH=/venv/bin:$PATH \
    PYTHONDONTWRITEBYTECODE=1 \
    PYTHONUNBUFFERED=1 \
    NUMBA_CACHE_DIR=/tmp/numba \
    OPENBLAS_NUM_THREADS=1 \
    GAINSCOPE_HOST=0.0.0.0 \
    GAINSCOPE_PORT=8050 \
    GAINSCOPE_DATA=/data
VOLUME /data
EXPOSE 8050

HEALTHCHECK --interval=15s --timeout=5s --start-period=60s --retries=3 CMD ["python", "scripts/healthcheck.py"]
CMD ["python", "app.py"]
